//! Compressible Neo-Hookean law with the logarithmic volumetric part.
//!
//! ψ = ½μ(I₁ − 3) − μ ln J + ½λ(ln J)², I₁ = F:F
//!
//! Source: Bonet & Wood, *Nonlinear Continuum Mechanics for Finite Element Analysis*, 2nd ed. 2008, eq. 6.27.
//!
//! Limits: J > 0 only. Not polyconvex: (ln J)² is concave in J beyond J = e, so strong dilatation softens.

use super::assemble::{isotropic, rows};
use super::kinematics::Invariants;
use super::volumetric::{Volumetric, VolumetricKind};
use super::{Law, LawError, LawInfo, Moduli, Response, Want, moduli};
use crate::math::tensor::Mat3;

pub static INFO: LawInfo = LawInfo {
    name: "neo_hookean",
    formula: "ψ = ½μ(I₁ − 3) − μ ln J + ½λ(ln J)²",
    source: "Bonet & Wood 2008, eq. 6.27",
    limits: "J > 0; (ln J)² softens in strong dilatation, J > e",
    parameters: moduli::PAIR,
    optional: 0,
    choices: &[],
    survives_inversion: false,
    objective: true,
    isochoric: false,
};

/// Neo-Hookean law in ln J.
#[derive(Clone, Copy, Debug)]
pub struct NeoHookean(pub Moduli);

impl Law for NeoHookean {
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

    /// The rest, ½μ(I₁ − 3) − μ ln J, is not isochoric.
    fn split(&self) -> Option<(Box<dyn Law>, Volumetric)> {
        let volumetric = Volumetric { kind: VolumetricKind::Logarithmic, kappa: self.0.lambda };
        Some((Box::new(Self(Moduli { lambda: 0.0, ..self.0 })), volumetric))
    }

    /// With G = F⁻ᵀ: P = μ(F − G) + λ ln J G; A_iJkL = μ δ_ik δ_JL + λ G_iJ G_kL + (μ − λ ln J) G_iL G_kJ.
    fn eval(&self, f: &Mat3, want: Want) -> Result<Response, LawError> {
        let Moduli { mu, lambda, .. } = self.0;
        let k = Invariants::of_positive(f)?;
        let ln = k.ln_j();
        let mut r = Response::energy(0.5 * mu * k.i_2ln(ln) + 0.5 * lambda * ln * ln);
        if want >= Want::Residual {
            let g = k.cof / k.j;
            r.p = (f - g) * mu + g * (lambda * ln);
            if want >= Want::Tangent {
                r.a = isotropic(mu, lambda, mu - lambda * ln, &rows(&g));
            }
        }
        Ok(r)
    }
}
