//! Prony series: the isochoric modulus of a rubber that relaxes.
//!
//! G(t) = G₀ \[1 − Σ g_α (1 − e^{−t/τ_α})\] = G∞ + Σ g_α G₀ e^{−t/τ_α}, G∞ = (1 − Σ g_α) G₀
//!
//! The g_α are shares of the instantaneous modulus G₀, as in the Prony tables of Abaqus and Ansys. The constants of a law give G₀ or G∞. In both
//! cases the whole isochoric stress is (1 − ρ) S_iso + Σ β_α h_α, where h_α is the part of the isochoric stress S_iso that has not yet relaxed in arm
//! α, all of it after a jump and nothing in the long term:
//!
//! | constants are | ρ | β_α |
//! |---|---|---|
//! | long-term | 0 | g_α/(1 − Σ g_α) |
//! | instantaneous | Σ g_α | g_α |
//!
//! Source: Simo, *On a fully three-dimensional finite-strain viscoelastic damage model*, CMAME 60, 1987.

use serde::{Deserialize, Serialize};

/// One term of the series: share g \[–\] of the instantaneous modulus and relaxation time τ \[s\].
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Arm {
    pub g: f64,
    pub tau: f64,
}

/// The modulus that the constants of the law give.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Constants {
    /// G∞, as slow tests show it
    LongTerm,
    /// G₀, as a jump shows it
    Instantaneous,
}

/// Errors of an invalid Prony series.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum PronyError {
    #[error("the Prony series has no term; give at least one, such as {{ g = 0.2, tau = \"0.1 s\" }}")]
    Empty,
    #[error("term {term}: g = {g} is not positive; it is a share of the instantaneous modulus, between 0 and 1")]
    Share { term: usize, g: f64 },
    #[error("term {term}: tau = {tau} s is not a positive time; remove the term, or give its relaxation time")]
    Time { term: usize, tau: f64 },
    #[error(
        "the shares g add up to {sum}: nothing is left in the long run; they are shares of the instantaneous modulus, \
         and their sum stays below 1"
    )]
    Sum { sum: f64 },
    #[error("terms {first} and {second} have the same tau = {tau} s; make one term of them, with the sum of their g")]
    SameTime { first: usize, second: usize, tau: f64 },
}

/// A valid series, relative to the constants of the law.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Prony {
    /// ρ \[–\]: share of the law's isochoric stress that vanishes in the long term
    pub relaxed: f64,
    /// (β \[–\], τ \[s\]) of each arm
    pub arms: Vec<(f64, f64)>,
}

impl Prony {
    pub fn new(arms: &[Arm], constants: Constants) -> Result<Self, PronyError> {
        if arms.is_empty() {
            return Err(PronyError::Empty);
        }
        for (k, arm) in arms.iter().enumerate() {
            if arm.g.is_nan() || arm.g <= 0.0 {
                return Err(PronyError::Share { term: k + 1, g: arm.g });
            }
            if !(arm.tau > 0.0 && arm.tau.is_finite()) {
                return Err(PronyError::Time { term: k + 1, tau: arm.tau });
            }
            if let Some(first) = arms[..k].iter().position(|other| other.tau == arm.tau) {
                return Err(PronyError::SameTime { first: first + 1, second: k + 1, tau: arm.tau });
            }
        }
        let sum: f64 = arms.iter().map(|arm| arm.g).sum();
        if sum >= 1.0 {
            return Err(PronyError::Sum { sum });
        }
        let (relaxed, scale) = match constants {
            Constants::LongTerm => (0.0, 1.0 / (1.0 - sum)),
            Constants::Instantaneous => (sum, 1.0),
        };
        Ok(Self { relaxed, arms: arms.iter().map(|arm| (scale * arm.g, arm.tau)).collect() })
    }

    /// G∞ and G₀, relative to the modulus that the constants give \[–\].
    pub fn limits(&self) -> (f64, f64) {
        let long_term = 1.0 - self.relaxed;
        (long_term, long_term + self.arms.iter().map(|arm| arm.0).sum::<f64>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ARMS: [Arm; 2] = [Arm { g: 0.3, tau: 0.1 }, Arm { g: 0.2, tau: 2.0 }];

    /// G∞ = (1 − Σg) G₀, whichever of the two is given.
    #[test]
    fn both_conventions_describe_one_series() {
        let (long, jump) = Prony::new(&ARMS, Constants::LongTerm).expect("valid").limits();
        assert!(long == 1.0 && (jump - 2.0).abs() < 1e-15, "{long}, {jump}");
        let (long, jump) = Prony::new(&ARMS, Constants::Instantaneous).expect("valid").limits();
        assert!((long - 0.5).abs() < 1e-15 && (jump - 1.0).abs() < 1e-15, "{long}, {jump}");
    }

    #[test]
    fn refuses_what_is_no_series() {
        let refused = |arms: &[(f64, f64)]| {
            let arms: Vec<Arm> = arms.iter().map(|&(g, tau)| Arm { g, tau }).collect();
            Prony::new(&arms, Constants::LongTerm).expect_err("not a series")
        };
        assert_eq!(refused(&[]), PronyError::Empty);
        assert_eq!(refused(&[(0.1, 1.0), (0.0, 2.0)]), PronyError::Share { term: 2, g: 0.0 });
        assert!(matches!(refused(&[(f64::NAN, 1.0)]), PronyError::Share { term: 1, .. }));
        assert_eq!(refused(&[(0.1, 0.0)]), PronyError::Time { term: 1, tau: 0.0 });
        assert_eq!(refused(&[(0.1, f64::INFINITY)]), PronyError::Time { term: 1, tau: f64::INFINITY });
        assert_eq!(refused(&[(0.5, 1.0), (0.5, 2.0)]), PronyError::Sum { sum: 1.0 });
        assert_eq!(
            refused(&[(0.1, 1.0), (0.1, 3.0), (0.1, 1.0)]),
            PronyError::SameTime { first: 1, second: 3, tau: 1.0 }
        );
    }
}
