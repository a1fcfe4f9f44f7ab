//! Formulas in files: arithmetic in named variables, `0.4 * (30 - bending_angle_deg) + 0.1 * sin(2 * PI * t)`.
//!
//! Operators `+ - * / ^` in the order of paper and of Python, functions of one argument such as `sin`, `exp`, `sqrt`, `abs`, and of two, `min(a, b)`,
//! `max(a, b)`, `atan2(y, x)`; constants `PI`, `E`.

use super::formula_order::bracketed;
use exmex::{Differentiate, Express, FlatEx, FloatOpsFactory, MatchLiteral, literal_matcher_from_pattern};
use std::fmt;
use std::sync::Arc;

literal_matcher_from_pattern!(Number, r"^([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?");

/// Arithmetic with numbers such as `0.5` and `2e-6`.
type Expression = FlatEx<f64, FloatOpsFactory<f64>, Number>;

/// Longest text of a formula \[bytes\].
const LONGEST: usize = 4096;
/// Most brackets within each other.
const DEEPEST: i64 = 64;
/// Most of them, with those that write out the order, where the derivative is taken in closed form.
const DERIVABLE: i64 = 12;
/// Stack of the thread that takes it \[bytes\]: powers of powers have derivatives that are nested deeply.
const STACK: usize = 64 << 20;

/// A formula whose value is brought to SI by a factor.
#[derive(Clone)]
pub struct Formula {
    text: String,
    factor: f64,
    /// Kilobytes, and every dof may hold a signal: shared
    expression: Arc<Expression>,
    /// Of a formula in one variable without kinks, whose brackets are not too deep
    derivative: Option<Arc<Expression>>,
}

/// Two formulas are the same if they are written the same.
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

/// Most brackets within each other in a text.
fn depth(text: &str) -> i64 {
    let depth = text.chars().scan(0i64, |depth, c| {
        *depth += i64::from(c == '(') - i64::from(c == ')');
        Some(*depth)
    });
    depth.max().unwrap_or(0)
}

fn check_depth(text: &str) -> Result<(), String> {
    match depth(text) > DEEPEST {
        true => Err(format!("its brackets are more than {DEEPEST} deep")),
        false => Ok(()),
    }
}

/// The derivative of a formula in one variable, if it has one in closed form.
fn derived(expression: Expression) -> Option<Arc<Expression>> {
    let derive = move || expression.partial(0).ok().map(Arc::new);
    std::thread::Builder::new().stack_size(STACK).spawn(derive).ok()?.join().ok()?
}

impl Formula {
    /// The message names the part that cannot be read.
    pub fn new(text: &str, factor: f64) -> Result<Self, String> {
        if text.len() > LONGEST {
            return Err(format!("it has {} characters, and at most {LONGEST} are read", text.len()));
        }
        check_depth(text)?;
        let read = |text: &str| Expression::parse(text).map_err(|e| e.msg().to_string());
        let ordered = bracketed(text);
        let expression = match &ordered {
            Some(ordered) => check_depth(ordered).and_then(|()| read(ordered))?,
            // The parser says what it is
            None => read(text).and(Err("a value or a bracket is missing".into()))?,
        };
        let is_derivable =
            expression.var_names().len() == 1 && ordered.is_some_and(|ordered| depth(&ordered) <= DERIVABLE);
        let derivative = if is_derivable { derived(expression.clone()) } else { None };
        Ok(Self { text: text.into(), factor, expression: Arc::new(expression), derivative })
    }

    /// Names of its variables, in the order of [`Formula::value`].
    pub fn variables(&self) -> &[String] {
        self.expression.var_names()
    }

    /// Value \[SI\] at the values of its variables.
    pub fn value(&self, variables: &[f64]) -> f64 {
        self.factor * self.expression.eval(variables).expect("one value per variable")
    }

    /// Value \[SI\] of a formula in t alone, or in nothing.
    pub fn at(&self, t: f64) -> f64 {
        self.value(&[t][..self.variables().len()])
    }

    /// d/dt \[SI\] of a formula in t alone, or in nothing; none where it has functions with kinks, and where the formula of the derivative has no value.
    pub fn rate(&self, t: f64) -> Option<f64> {
        if self.variables().is_empty() {
            return Some(0.0);
        }
        let derivative = self.derivative.as_ref()?;
        let rate = derivative.eval(&[t][..derivative.var_names().len()]).ok()?;
        Some(self.factor * rate).filter(|rate| rate.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variables_come_in_the_order_of_the_alphabet() {
        let formula = Formula::new("2 * zeta + max(alpha, 1) ^ 2 - min(t, 3)", 1e-3).expect("readable");
        assert_eq!(formula.variables(), ["alpha", "t", "zeta"]);
        assert_eq!(formula.value(&[4.0, 5.0, 0.5]), 1e-3 * (1.0 + 16.0 - 3.0));
        let swing = Formula::new("15 * (1 - cos(2 * PI * t)) / 2", 1e-3).expect("readable");
        let expected = |t: f64| 1e-3 * (15.0 * (1.0 - (2.0 * std::f64::consts::PI * t).cos()) / 2.0);
        for t in [0.0, 0.3, 0.5] {
            // The reader may fold constants in another order: a few roundings of 15e-3.
            assert!((swing.at(t) - expected(t)).abs() < 1e-17, "{t}");
        }
        assert_eq!(Formula::new("2 + 3", 1.0).expect("readable").at(7.0), 5.0);
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
        for text in ["", "2 +", "sin(", "t t", "2 * (t"] {
            assert!(Formula::new(text, 1.0).is_err(), "{text}");
        }
    }
}
