//! Formulas in files: arithmetic in named variables, `0.4 * (30 - bending_angle_deg) + 0.1 * sin(2 * PI * t)`.
//!
//! Operators `+ - * / ^` with the usual precedence, as in Python; functions of one argument such as `sin`, `exp`, `sqrt`, `abs`, and of several:
//! `min(a, b)`, `max(a, b)`, `atan2(y, x)`; constants `PI`, `TAU`, `E`. A name in braces, `{a b}`, may contain any characters.

mod functions;
mod parser;
mod program;

use program::Program;
use std::fmt;
use std::sync::Arc;

/// Largest length of a formula \[bytes\].
const LONGEST: usize = 4096;

/// A formula with a factor that converts its value to SI.
#[derive(Clone)]
pub struct Formula {
    text: String,
    factor: f64,
    variables: Vec<String>,
    /// Shared, because every degree of freedom may hold a signal
    program: Arc<Program>,
}

/// Two formulas are equal if their text and factor are.
impl PartialEq for Formula {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text && self.factor == other.factor
    }
}

impl fmt::Debug for Formula {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} × ({})", self.factor, self.text)
    }
}

impl Formula {
    /// Parses a formula. The error message names the part that cannot be read.
    pub fn new(text: &str, factor: f64) -> Result<Self, String> {
        if text.len() > LONGEST {
            return Err(format!("it has {} characters, and at most {LONGEST} are read", text.len()));
        }
        let (program, variables) = parser::parse(text)?;
        Ok(Self { text: text.into(), factor, variables, program: Arc::new(program) })
    }

    /// Names of its variables, in the order of [`Formula::value`].
    pub fn variables(&self) -> &[String] {
        &self.variables
    }

    /// Value \[SI\] for these values of the variables.
    pub fn value(&self, variables: &[f64]) -> f64 {
        self.factor * self.program.value(variables)
    }

    /// Value \[SI\] of a formula with t as its only variable, or without variables.
    pub fn at(&self, t: f64) -> f64 {
        self.value(&[t][..self.variables.len()])
    }

    /// d/dt \[SI\] of a formula with t as its only variable, or without variables; `None` if it depends on t through functions with kinks, or if the
    /// derivative is not finite.
    pub fn rate(&self, t: f64) -> Option<f64> {
        let rate = self.program.derivative(&[t][..self.variables.len()]);
        Some(self.factor * rate).filter(|rate| rate.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix;
    use crate::math::statistics::larger;

    fn formula(text: &str) -> Formula {
        Formula::new(text, 1.0).unwrap_or_else(|why| panic!("{text}: {why}"))
    }

    #[test]
    fn variables_come_in_the_order_of_the_alphabet() {
        let formula = Formula::new("2 * zeta + max(alpha, 1) ^ 2 - min(t, 3)", 1e-3).expect("readable");
        assert_eq!(formula.variables(), ["alpha", "t", "zeta"]);
        assert_eq!(formula.value(&[4.0, 5.0, 0.5]), 1e-3 * (1.0 + 16.0 - 3.0));
        let swing = Formula::new("15 * (1 - cos(2 * PI * t)) / 2", 1e-3).expect("readable");
        for t in [0.0, 0.3, 0.5] {
            assert_eq!(swing.at(t), 1e-3 * (15.0 * (1.0 - (2.0 * std::f64::consts::PI * t).cos()) / 2.0), "{t}");
        }
        assert_eq!(Formula::new("2 + 3", 1.0).expect("readable").at(7.0), 5.0);
        assert_eq!(Formula::new("{tip of 2}^2 * e", 1.0).expect("readable").variables(), ["tip of 2"]);
    }

    #[test]
    fn rates_are_exact_where_the_formula_is_smooth() {
        let fast = Formula::new("sin(2 * PI * 2000000 * t) * exp(-t)", 1e-3).expect("readable");
        let w = 2.0 * std::f64::consts::PI * 2e6;
        for t in [0.0_f64, 1.3e-7, 0.2] {
            let exact = 1e-3 * (-t).exp() * (w * (w * t).cos() - (w * t).sin());
            assert!((fast.rate(t).expect("smooth") / exact - 1.0).abs() < 1e-6, "{t}: {:?} and {exact}", fast.rate(t));
        }
        assert_eq!(Formula::new("0.25 * (1 - cos(2 * PI * t))", 1.0).expect("readable").rate(0.0), Some(0.0));
        assert_eq!(Formula::new("7", 1.0).expect("readable").rate(0.3), Some(0.0));
        assert_eq!(Formula::new("3 * t", 2.0).expect("readable").rate(0.3), Some(6.0));
        assert_eq!(Formula::new("max(t, 1)", 1.0).expect("readable").rate(0.3), None);
    }

    #[test]
    fn numbers_may_have_an_exponent() {
        let one = |text: &str| Formula::new(text, 1.0).expect("readable").at(0.5);
        let expected = [
            ("2e6", 2e6),
            ("2.5E-3*t", 1.25e-3),
            ("1e+2-1.e1", 90.0),
            (".5e1 - 2", 3.0),
            ("E*2", 2.0 * std::f64::consts::E),
        ];
        for (text, value) in expected {
            assert_eq!(one(text), value, "{text}");
        }
        assert_eq!(Formula::new("1e3*t^2", 1.0).expect("readable").rate(0.5), Some(1e3));
        assert!(Formula::new("2e", 1.0).is_err());
    }

    #[test]
    fn the_order_is_that_of_paper() {
        let e = std::f64::consts::E;
        let expected = [
            ("-t^2", -0.25),
            ("exp(-t^2)", e.powf(-0.25)),
            ("-sin(t)^2", -0.5f64.sin().powi(2)),
            ("2^3^2", 512.0),
            ("2^-2", 0.25),
            ("-2^-2", -0.25),
            ("6/-t^2*2", -48.0),
            ("1 - -t^2", 1.25),
            ("exp(-((t-1)/0.8)^2)", e.powf(-0.390_625)),
            ("8/2/2*3-1-1", 4.0),
        ];
        for (text, value) in expected {
            let found = Formula::new(text, 1.0).expect("readable").at(0.5);
            assert!((found - value).abs() < 1e-15 * value.abs().max(1.0), "{text}: {found} in place of {value}");
        }
        assert_eq!(Formula::new("-t^2", 1.0).expect("readable").rate(0.5), Some(-1.0));
        let deep = ["2"; 80].join("^");
        assert!(Formula::new(&deep, 1.0).is_err_and(|why| why.contains("more than 64 deep")));
    }

    #[test]
    fn what_cannot_be_read_is_said() {
        let deep = format!("{}t{}", "(".repeat(65), ")".repeat(65));
        assert!(Formula::new(&deep, 1.0).expect_err("deep").contains("64 deep"));
        assert!(Formula::new(&"1+".repeat(3000), 1.0).expect_err("long").contains("at most 4096"));
        for (text, why) in [
            ("", "a value is missing at its beginning"),
            ("2 +", "a value is missing after \"+\""),
            ("sin(", "a value is missing after \"(\""),
            ("sin()", "a value is missing after \"(\""),
            ("sin t", "sin has no argument in brackets"),
            ("t t", "between \"t\" and \"t\" there is no operator"),
            ("2(t)", "between \"2\" and \"(\" there is no operator"),
            ("2 * (t", "a \"(\" has no \")\""),
            ("(t, 2)", "a \",\" is outside of the arguments of a function"),
            ("t)", "a \")\" has no opening bracket"),
            ("{t", "a \"{\" has no \"}\""),
            ("1.2.3", "\"1.2.3\" is no number"),
            ("5 % t", "\"%\" has no meaning in it; operators are + - * / ^"),
            ("sine(t)", "there is no function sine; did you mean `sin`?"),
            ("sin(t, 2)", "sin takes one argument, not 2"),
            ("max(t)", "max takes two or more arguments, not 1"),
            ("atan2(t, 1, 2)", "atan2 takes two arguments, y and x, not 3"),
        ] {
            let found = Formula::new(text, 1.0).expect_err(text);
            assert!(found.starts_with(why), "{text}: {found}");
        }
    }

    /// Random formulas are written with brackets around every operation and without superfluous ones, and are evaluated independently.
    #[test]
    fn random_formulas_have_the_values_of_their_operations() {
        /// Text, value, and precedence of the last operation: 0 a sum, 1 a product, 2 a sign, 3 a power, 4 a value
        type Made = (String, f64, u8);
        fn bracket((text, _, binds): &Made, least: u8) -> String {
            if *binds < least { format!("({text})") } else { text.clone() }
        }
        fn made(random: &mut SplitMix, t: f64, depth: u32) -> Made {
            if depth == 0 || random.below(6) == 0 {
                let number = random.below(40) as f64 / 8.0;
                return match random.below(3) {
                    0 => ("t".into(), t, 4),
                    1 => ("PI".into(), std::f64::consts::PI, 4),
                    _ => (format!("{number}"), number, 4),
                };
            }
            let a = made(random, t, depth - 1);
            let kind = random.below(11);
            match kind {
                0 => return (format!("-{}", bracket(&a, 2)), -a.1, 2),
                1 => return (format!("sin({})", a.0), a.1.sin(), 4),
                2 => return (format!("sqrt({})", a.0), a.1.sqrt(), 4),
                _ => {}
            }
            let b = made(random, t, depth - 1);
            match kind {
                3 => (format!("max({}, {})", a.0, b.0), larger(a.1, b.1), 4),
                4 => (format!("atan2({}, {})", a.0, b.0), a.1.atan2(b.1), 4),
                5 => (format!("{}^{}", bracket(&a, 4), bracket(&b, 2)), a.1.powf(b.1), 3),
                6 | 7 => (format!("{} * {}", bracket(&a, 1), bracket(&b, 2)), a.1 * b.1, 1),
                8 => (format!("{} / {}", bracket(&a, 1), bracket(&b, 2)), a.1 / b.1, 1),
                9 => (format!("{} + {}", bracket(&a, 0), bracket(&b, 1)), a.1 + b.1, 0),
                _ => (format!("{} - {}", bracket(&a, 0), bracket(&b, 1)), a.1 - b.1, 0),
            }
        }
        let mut random = SplitMix(11);
        for _ in 0..4000 {
            let t = random.below(1000) as f64 / 250.0;
            let (text, value, _) = made(&mut random, t, 5);
            let found = formula(&text).at(t);
            assert!(found == value || (found.is_nan() && value.is_nan()), "{text} at {t}: {found} in place of {value}");
        }
    }

    /// NaN is not replaced by the other of two values.
    #[test]
    fn the_larger_of_no_number_is_none() {
        for text in ["max(sqrt(-1), 0)", "max(0, sqrt(-1))", "min(1, 2, sqrt(-1))", "0 * min(sqrt(-1), 3)"] {
            assert!(formula(text).at(0.0).is_nan(), "{text}");
        }
        assert_eq!(formula("sqrt(max(-1, 0)) + min(3, max(1, 2))").at(0.0), 2.0);
    }

    /// Compared with differences over 2h, whose error is h²/6 of the third derivative and ε/h of the value.
    #[test]
    fn every_smooth_function_has_its_derivative() {
        let h = 1e-5;
        for function in functions::FUNCTIONS.iter().filter(|function| function.derivative.is_some()) {
            // Only acosh begins at 1
            for t in if function.name == "acosh" { [1.3, 2.0] } else { [0.2, 0.7] } {
                let one = formula(&format!("{}(t)", function.name));
                let difference = (one.at(t + h) - one.at(t - h)) / (2.0 * h);
                let exact = one.rate(t).expect("smooth");
                assert!((exact - difference).abs() < 1e-8 * exact.abs().max(1.0), "{}: {exact}", function.name);
            }
        }
        for text in
            ["t^3 - 2^t", "t^t / (1 + t)", "atan2(t, 1 + t^2) * -t", "exp(-t * 2 * 3)", "sin(2 * PI * (t - 0.5) * 3)"]
        {
            let one = formula(text);
            let difference = (one.at(0.6 + h) - one.at(0.6 - h)) / (2.0 * h);
            let exact = one.rate(0.6).expect("smooth");
            assert!((exact - difference).abs() < 1e-6 * exact.abs().max(1.0), "{text}: {exact} and {difference}");
        }
        assert_eq!(formula("max(1, 2) * t + abs(-3)").rate(0.3), Some(2.0));
        assert_eq!(formula("0^t * 0 + t").rate(-1.0), None);
    }

    #[test]
    fn limits_are_nested_in_any_order() {
        for (text, t, value) in [
            ("min(1, max(0, t))", 3.0, 1.0),
            ("min(1, 0 + max(0, t))", -3.0, 0.0),
            ("max(t, sin(min(1, t)))", 0.5, 0.5),
            ("max(t, 1, 2 - t, -4)", -1.0, 3.0),
            ("sin(t * 2 * PI)", 0.25, 1.0),
            ("(1 - cos(t * 2 * PI)) / 2", 0.5, 1.0),
            ("-(t + 1 + 2)", 0.5, -3.5),
        ] {
            assert!((formula(text).at(t) - value).abs() < 1e-15, "{text}");
        }
    }
}
