//! St Venant–Kirchhoff law: Hooke's law in the Green–Lagrange strain.
//!
//! ψ = μ E:E + ½λ tr²E, E = ½(FᵀF − I)
//!
//! Source: Bonet & Wood, *Nonlinear Continuum Mechanics for Finite Element Analysis*, 2nd ed. 2008, ch. 6.
//!
//! Limits: large rotation, small strain. It softens in compression: the magnitude of the uniaxial stress E λ(λ² − 1)/2 decreases from λ = 1/√3 on and
//! vanishes at λ = 0. The energy does not depend on the sign of J, so a reflected cell is stress-free and stays reflected.

use super::assemble::isotropic;
use super::entry::LawEntry;
use super::law::{Law, LawInfo};
use super::moduli;
use super::moduli::Moduli;
use super::response::{LawError, Response, Want};
use crate::math::tensor::{Mat3, rows};

pub static INFO: LawInfo = LawInfo {
    name: "st_venant_kirchhoff",
    title: "St Venant–Kirchhoff",
    formula: "ψ = μ E:E + ½λ tr²E, E = ½(FᵀF − I)",
    source: "Bonet & Wood 2008, ch. 6",
    limits: "small strain, any rotation; loses stiffness in compression below λ = 1/√3 and leaves inverted cells inverted",
    parameters: moduli::PAIR,
    optional: 0,
    choices: &[],
    survives_inversion: true,
    objective: true,
    isochoric: false,
};

/// The law in the registry.
pub const ENTRY: LawEntry = LawEntry::elastic(&INFO, |v, _| Ok(Box::new(StVenantKirchhoff(Moduli::from_map(v)?))));

/// St Venant–Kirchhoff law.
#[derive(Clone, Copy, Debug)]
pub struct StVenantKirchhoff(pub Moduli);

impl Law for StVenantKirchhoff {
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

    /// S = 2μE + λ tr E I, P = FS; A_iJkL = δ_ik S_JL + λ F_iJ F_kL + μ(F_iL F_kJ + δ_JL (FFᵀ)_ik).
    fn eval(&self, f: &Mat3, want: Want) -> Result<Response, LawError> {
        let Moduli { mu, lambda, .. } = self.0;
        let h = f - Mat3::identity();
        // E from H: no cancellation near F = I
        let e = (h + h.transpose() + h.transpose() * h) * 0.5;
        let tr = e.trace();
        let mut r = Response::energy(mu * e.norm_squared() + 0.5 * lambda * tr * tr);
        if want >= Want::Residual {
            let s = e * (2.0 * mu) + Mat3::identity() * (lambda * tr);
            r.p = f * s;
            if want >= Want::Tangent {
                let b = f * f.transpose() * mu;
                r.a = isotropic(0.0, lambda, mu, &rows(f));
                for i in 0..3 {
                    for j in 0..3 {
                        for m in 0..3 {
                            r.a[3 * i + j][3 * i + m] += s[(j, m)];
                            r.a[3 * i + j][3 * m + j] += b[(i, m)];
                        }
                    }
                }
            }
        }
        Ok(r)
    }
}
