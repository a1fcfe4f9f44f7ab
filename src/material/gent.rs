//! Gent law: chains of finite length.
//!
//! ψ = −½μJ_m ln(1 − (Ī₁ − 3)/J_m) + U(J)
//!
//! Source: Gent, *A new constitutive relation for rubber*, Rubber Chem. Technol. 69, 1996.
//!
//! Limits: J > 0 and Ī₁ − 3 < J_m, refused beyond: there the chains are fully stretched and ψ is infinite.

use super::isochoric::{self, Partials, Strain};
use super::registry::{Chosen, LawSpecError, Values};
use super::split::{Part, required};
use super::volumetric::{CHOICES, Volumetric};
use super::{LawError, LawInfo, Parameter, Response, Want, moduli};
use crate::math::tensor::Mat3;

/// Keys in files; κ and ν stand for each other.
pub const KEYS: &[Parameter] = &[
    moduli::NU,
    moduli::KAPPA,
    Parameter::modulus("mu", "μ", 0.0, "shear modulus at F = I"),
    Parameter::number("J_m", "J_m", 0.0, "Ī₁ − 3 at which the chains are fully stretched"),
];

pub static INFO: LawInfo = LawInfo {
    name: "gent",
    formula: "ψ = −½μJ_m ln(1 − (Ī₁ − 3)/J_m) + U(J)",
    source: "Gent 1996; modified invariant: Holzapfel 2000, ch. 6",
    limits: "J > 0; locks at Ī₁ − 3 = J_m and is not defined beyond",
    parameters: KEYS.split_at(1).1,
    optional: 0,
    choices: CHOICES,
    survives_inversion: false,
    objective: true,
    isochoric: true,
};

/// Constants of W.
#[derive(Clone, Copy, Debug)]
pub struct Gent {
    /// μ [Pa]
    pub mu: f64,
    /// J_m [–]
    pub limit: f64,
}

impl Part for Gent {
    const INFO: &'static LawInfo = &INFO;

    fn read(values: &Values, _: &Chosen) -> Result<Self, LawSpecError> {
        Ok(Self { mu: required(&INFO, values, "mu")?, limit: required(&INFO, values, "J_m")? })
    }

    fn values(&self) -> Vec<f64> {
        vec![self.mu, self.limit]
    }

    fn shear(&self) -> f64 {
        self.mu
    }

    fn response(&self, u: &Volumetric, f: &Mat3, want: Want) -> Result<Response, LawError> {
        isochoric::response(self, u, f, want)
    }
}

impl Strain for Gent {
    const SECOND: bool = false;

    #[inline(always)]
    fn partials(&self, i: f64, _: f64) -> Result<Partials, LawError> {
        let Self { mu, limit } = *self;
        if i >= limit {
            return Err(LawError::Locked { i, limit });
        }
        let t = i / limit;
        let slope = 0.5 * mu / (1.0 - t);
        Ok(Partials {
            w: -0.5 * mu * limit * (-t).ln_1p(),
            w1: slope,
            w11: slope / (limit * (1.0 - t)),
            ..Partials::default()
        })
    }
}
