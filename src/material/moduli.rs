//! The five constants of isotropic linear elasticity; any two of them determine the others.

use std::collections::BTreeMap;

use super::parameter::{LawSpecError, Parameter, check_bounds};
use crate::math::units::Dimension;

/// Consistent elastic constants: the given pair is kept exactly, the others follow.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Moduli {
    /// Young's modulus E \[Pa\]
    pub e: f64,
    /// Poisson's ratio ν \[–\]
    pub nu: f64,
    /// Shear modulus μ \[Pa\]
    pub mu: f64,
    /// Lamé's first constant λ \[Pa\]
    pub lambda: f64,
    /// Bulk modulus κ \[Pa\]
    pub kappa: f64,
}

const E: Parameter = Parameter::new("E", "E", Dimension::PRESSURE, Parameter::POSITIVE, "Young's modulus");
pub const NU: Parameter = Parameter::new("nu", "ν", Dimension::NONE, (-1.0, 0.5), "Poisson's ratio");
const MU: Parameter = Parameter::new("mu", "μ", Dimension::PRESSURE, Parameter::POSITIVE, "shear modulus");
const LAMBDA: Parameter = Parameter::new("lambda", "λ", Dimension::PRESSURE, Parameter::ANY, "Lamé's first constant");
pub const KAPPA: Parameter = Parameter::new("kappa", "κ", Dimension::PRESSURE, Parameter::POSITIVE, "bulk modulus");

/// The independent pair of a law with two elastic constants: its bounds are a box, unlike those of (μ, λ).
pub const PAIR: &[Parameter] = &[E, NU];

/// All constants that a file may give; exactly two are required.
pub const KEYS: &[Parameter] = &[E, NU, MU, LAMBDA, KAPPA];

impl Moduli {
    /// The moduli that follow from E \[Pa\] and ν \[–\].
    ///
    /// # Errors
    ///
    /// Returns an error if a constant is out of its range.
    pub fn from_e_nu(e: f64, nu: f64) -> Result<Self, LawSpecError> {
        Self::from_pair(("E", e), ("nu", nu))
    }

    /// The moduli that follow from exactly two of the constants in [`KEYS`] \[SI\].
    ///
    /// # Errors
    ///
    /// Returns an error unless there are exactly two of them, or if one is out of its range.
    pub fn from_map(given: &BTreeMap<String, f64>) -> Result<Self, LawSpecError> {
        let of: Vec<(&str, f64)> = KEYS.iter().filter_map(|p| given.get(p.name).map(|v| (p.name, *v))).collect();
        match of[..] {
            [a, b] => Self::from_pair(a, b),
            _ => Err(LawSpecError::NotTwo { given: of.iter().map(|(name, _)| (*name).to_string()).collect() }),
        }
    }

    /// The moduli that follow from two named constants in either order \[SI\]; names as in [`KEYS`].
    ///
    /// # Errors
    ///
    /// Returns an error if a constant is out of its range, or the two do not determine the others.
    pub fn from_pair(a: (&str, f64), b: (&str, f64)) -> Result<Self, LawSpecError> {
        let order = |name: &str| KEYS.iter().position(|p| p.name == name).unwrap_or(KEYS.len());
        let ((first, p), (second, q)) = if order(a.0) <= order(b.0) { (a, b) } else { (b, a) };
        for (name, value) in [(first, p), (second, q)] {
            check_bounds(KEYS, name, value)?;
        }
        let m = match (first, second) {
            ("E", "nu") => {
                let (mu, third) = (p / (2.0 * (1.0 + q)), p / (1.0 - 2.0 * q));
                Self { e: p, nu: q, mu, lambda: third * q / (1.0 + q), kappa: third / 3.0 }
            }
            ("E", "mu") => {
                let d = 3.0 * q - p; // μ(1 − 2ν) > 0
                Self {
                    e: p,
                    nu: (p - 2.0 * q) / (2.0 * q),
                    mu: q,
                    lambda: q * (p - 2.0 * q) / d,
                    kappa: p * q / (3.0 * d),
                }
            }
            ("E", "lambda") => {
                let r = (p * p + 9.0 * q * q + 2.0 * p * q).sqrt();
                // (E − 3λ + R)/4, with the difference rationalised if λ is large.
                let mu = if 3.0 * q > p { 2.0 * p * q / (r + 3.0 * q - p) } else { (p - 3.0 * q + r) / 4.0 };
                Self { e: p, nu: 2.0 * q / (p + q + r), mu, lambda: q, kappa: q + 2.0 / 3.0 * mu }
            }
            ("E", "kappa") => {
                let d = 9.0 * q - p;
                let mu = 3.0 * q * p / d;
                Self { e: p, nu: (3.0 * q - p) / (6.0 * q), mu, lambda: 3.0 * q * (3.0 * q - p) / d, kappa: q }
            }
            ("nu", "mu") => {
                let d = 1.0 - 2.0 * p;
                let e = 2.0 * q * (1.0 + p);
                Self { e, nu: p, mu: q, lambda: 2.0 * q * p / d, kappa: e / (3.0 * d) }
            }
            ("nu", "lambda") => {
                if p == 0.0 {
                    return Err(LawSpecError::Undetermined);
                }
                let d = 1.0 - 2.0 * p;
                Self {
                    e: q * (1.0 + p) * d / p,
                    nu: p,
                    mu: q * d / (2.0 * p),
                    lambda: q,
                    kappa: q * (1.0 + p) / (3.0 * p),
                }
            }
            ("nu", "kappa") => {
                let e = 3.0 * q * (1.0 - 2.0 * p);
                Self { e, nu: p, mu: e / (2.0 * (1.0 + p)), lambda: 3.0 * q * p / (1.0 + p), kappa: q }
            }
            ("mu", "lambda") => Self {
                e: p * (3.0 * q + 2.0 * p) / (q + p),
                nu: q / (2.0 * (q + p)),
                mu: p,
                lambda: q,
                kappa: q + 2.0 / 3.0 * p,
            },
            ("mu", "kappa") => Self {
                e: 9.0 * q * p / (3.0 * q + p),
                nu: (3.0 * q - 2.0 * p) / (2.0 * (3.0 * q + p)),
                mu: p,
                lambda: q - 2.0 / 3.0 * p,
                kappa: q,
            },
            ("lambda", "kappa") => Self {
                e: 9.0 * q * (q - p) / (3.0 * q - p),
                nu: p / (3.0 * q - p),
                mu: 1.5 * (q - p),
                lambda: p,
                kappa: q,
            },
            _ => return Err(LawSpecError::NotTwo { given: vec![first.to_string()] }),
        };
        m.check(first, second)
    }

    /// Rates of all five constants for given rates of E \[Pa\] and ν \[–\].
    pub fn along(&self, rates: &[f64]) -> Self {
        let [e, nu] = [rates[0], rates[1]];
        let mu = (0.5 * e - self.mu * nu) / (1.0 + self.nu);
        let kappa = (e / 3.0 + 2.0 * self.kappa * nu) / (1.0 - 2.0 * self.nu);
        Self { e, nu, ..self.shifted(mu, kappa) }
    }

    /// Rates of all five constants for given rates of μ and κ \[Pa\].
    pub(crate) fn shifted(&self, mu: f64, kappa: f64) -> Self {
        let by = |name| self.gradient(name).iter().zip([mu, kappa]).map(|(g, rate)| g * rate).sum();
        Self { e: by("E"), nu: by("nu"), mu, lambda: by("lambda"), kappa }
    }

    /// Rates d of (E, ν) with respect to `key`, with the other given constant held: with the gradients g with respect to (μ, κ), g_key·d = 1 and
    /// g_other·d = 0.
    pub fn rates(&self, given: &BTreeMap<String, f64>, key: &str) -> Vec<f64> {
        let other = given.keys().find(|k| *k != key).map_or("", String::as_str);
        let ([a, b], [c, d]) = (self.gradient(key), self.gradient(other));
        let determinant = a * d - b * c;
        let Self { e, nu, .. } = self.shifted(d / determinant, -c / determinant);
        vec![e, nu]
    }

    /// ∂/∂μ and ∂/∂κ of a constant of [`KEYS`], from E = 9κμ/(3κ + μ) and ν = (3κ − 2μ)/(6κ + 2μ).
    fn gradient(&self, name: &str) -> [f64; 2] {
        let Self { mu, kappa, .. } = *self;
        let d = (3.0 * kappa + mu).powi(2);
        match name {
            "E" => [27.0 * kappa * kappa / d, 9.0 * mu * mu / d],
            "nu" => [-4.5 * kappa / d, 4.5 * mu / d],
            "lambda" => [-2.0 / 3.0, 1.0],
            "mu" => [1.0, 0.0],
            _ => [0.0, 1.0],
        }
    }

    /// Refuses a pair if other constants leave their bounds: the stored energy would not be positive.
    fn check(self, first: &str, second: &str) -> Result<Self, LawSpecError> {
        // μ and κ first: they name the cause, and the others follow from them.
        for (p, value) in [(MU, self.mu), (KAPPA, self.kappa), (NU, self.nu), (E, self.e), (LAMBDA, self.lambda)] {
            if !(value.is_finite() && p.bounds.0 < value && value < p.bounds.1) {
                return Err(LawSpecError::Contradiction {
                    first: first.to_string(),
                    second: second.to_string(),
                    derived: p.name,
                    value,
                    lower: p.bounds.0,
                    upper: p.bounds.1,
                });
            }
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(m: &Moduli) -> [(&'static str, f64); 5] {
        [("E", m.e), ("nu", m.nu), ("mu", m.mu), ("lambda", m.lambda), ("kappa", m.kappa)]
    }

    /// Each of the ten pairs gives the same five constants. The condition number of (1 − 2ν) is 1/(1 − 2ν), and so is the tolerance.
    #[test]
    fn every_pair_gives_the_same_constants() {
        for nu in [-0.7, -0.2, 0.1, 0.3, 0.45, 0.499, 0.4999] {
            let truth = Moduli::from_e_nu(1e5, nu).expect("within bounds");
            let tolerance = 40.0 * f64::EPSILON / ((1.0 - 2.0 * nu).min(1.0 + nu) * nu.abs().min(0.5));
            for a in 0..5 {
                for b in (0..5).filter(|b| *b != a) {
                    let got = Moduli::from_pair(named(&truth)[a], named(&truth)[b]).expect("a consistent pair");
                    for ((name, x), (_, y)) in named(&got).into_iter().zip(named(&truth)) {
                        assert!((x / y - 1.0).abs() < tolerance, "{a}{b}: {name} = {x}, not {y} at ν = {nu}");
                    }
                }
            }
        }
    }

    #[test]
    fn refuses_what_is_not_elastic() {
        let message = |a, b| Moduli::from_pair(a, b).expect_err("must be refused").to_string();
        assert!(message(("E", 1e5), ("nu", 0.5)).contains("no finite bulk modulus"));
        assert!(message(("E", 1e5), ("nu", -1.0)).contains("nu"));
        assert!(message(("E", -1.0), ("nu", 0.3)).contains("E"));
        assert!(message(("E", 3e5), ("mu", 1e5)).contains("kappa"));
        assert!(message(("mu", 1e5), ("lambda", -1e5)).contains("kappa"));
        assert!(message(("lambda", 2e5), ("kappa", 1e5)).contains("mu"));
        assert!(message(("nu", 0.0), ("lambda", 0.0)).contains("nu = 0"));
        assert!(message(("E", f64::NAN), ("nu", 0.3)).contains("E"));
        assert!(message(("E", 1e5), ("E", 1e5)).contains("exactly two"));
    }
}
