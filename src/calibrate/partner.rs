//! The constant that completes the law of an incompressible fit.

use super::FitError;
use serde::Serialize;

/// The constant that complements μ in a compressible law. Tests of an incompressible material do not determine it.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Partner {
    /// Poisson's ratio ν \[–\]
    Nu(f64),
    /// Bulk modulus κ \[Pa\]
    Kappa(f64),
}

impl Partner {
    /// Returns the value; refuses one that no stable compressible law can have.
    pub fn check(self) -> Result<Self, FitError> {
        match self {
            Self::Nu(nu) if !(nu > -1.0 && nu < 0.5) => Err(FitError::Partner {
                name: "nu",
                value: nu,
                allowed: "above -1 and below 0.5",
                remedy: "0.5 is exactly incompressible, which a displacement law cannot take",
            }),
            Self::Kappa(kappa) if !(kappa > 0.0 && kappa.is_finite()) => Err(FitError::Partner {
                name: "kappa",
                value: kappa,
                allowed: "above 0 Pa",
                remedy: "give a finite bulk modulus",
            }),
            ok => Ok(ok),
        }
    }
}
