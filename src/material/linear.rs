//! Small-strain isotropic elasticity (Hooke).
//!
//! ψ = μ ε:ε + ½λ tr²ε, ε = sym(F − I)
//!
//! Source: Bonet & Wood, *Nonlinear Continuum Mechanics for Finite Element Analysis*, 2nd ed. 2008, ch. 6 (Hooke's law as the limit F → I).
//!
//! Limits: not objective; a rotation by θ causes the strain cos θ − 1, so that the law is limited to rotations of less than a few degrees.

use super::assemble::isotropic;
use super::entry::LawEntry;
use super::law::{Law, LawInfo};
use super::moduli;
use super::moduli::Moduli;
use super::response::{LawError, Response, Want};
use crate::math::tensor::{Mat3, rows};

pub static INFO: LawInfo = LawInfo {
    name: "linear",
    title: "linear elastic",
    formula: "ψ = μ ε:ε + ½λ tr²ε, ε = sym(F − I)",
    source: "Bonet & Wood 2008, ch. 6",
    limits: "small strain and small rotation; not objective",
    parameters: moduli::PAIR,
    optional: 0,
    choices: &[],
    survives_inversion: true,
    objective: false,
    isochoric: false,
};

/// The law in the registry.
pub const ENTRY: LawEntry = LawEntry::elastic(&INFO, |v, _| Ok(Box::new(Linear(Moduli::from_map(v)?))));

/// Hooke's law in the symmetric part of F − I.
#[derive(Clone, Copy, Debug)]
pub struct Linear(pub Moduli);

impl Law for Linear {
    fn info(&self) -> &'static LawInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        vec![self.0.e, self.0.nu]
    }

    fn small_strain(&self) -> Moduli {
        self.0
    }

    /// ψ is linear in μ and λ.
    fn along(&self, rates: &[f64]) -> Box<dyn Law> {
        Box::new(Self(self.0.along(rates)))
    }

    /// P = 2με + λ tr ε I; A_iJkL = μ(δ_ik δ_JL + δ_iL δ_kJ) + λ δ_iJ δ_kL.
    fn eval(&self, f: &Mat3, want: Want) -> Result<Response, LawError> {
        let Moduli { mu, lambda, .. } = self.0;
        let eps = (f + f.transpose()) * 0.5 - Mat3::identity();
        let tr = eps.trace();
        let mut r = Response::energy(mu * eps.norm_squared() + 0.5 * lambda * tr * tr);
        if want >= Want::Residual {
            r.p = eps * (2.0 * mu) + Mat3::identity() * (lambda * tr);
        }
        if want >= Want::Tangent {
            r.a = isotropic(mu, lambda, mu, &rows(&Mat3::identity()));
        }
        Ok(r)
    }
}
