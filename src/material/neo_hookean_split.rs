//! Neo-Hookean law split into an isochoric and a volumetric part.
//!
//! ψ = ½μ(J^{−2/3} I₁ − 3) + ½κ(J − 1)², I₁ = F:F
//!
//! Source: Simo & Hughes, *Computational Inelasticity*, 1998, ch. 9 for the split; U(J) = ½κ(J − 1)² as in Bonet & Wood, 2nd ed.
//! 2008, ch. 6.
//!
//! Limits: J > 0 only. U stays finite at J = 0: the barrier there comes from J^{−2/3} alone, and a purely volumetric collapse has
//! none. Near incompressibility (κ ≫ μ) use a mixed formulation.

use super::assemble::{add_dyad, isotropic, rows};
use super::kinematics::{Invariants, exp_m1_minus_y};
use super::volumetric::{Volumetric, VolumetricKind};
use super::{Law, LawError, LawInfo, Moduli, Response, Want, moduli};
use crate::math::tensor::Mat3;

pub static INFO: LawInfo = LawInfo {
    name: "neo_hookean_split",
    formula: "ψ = ½μ(J^{−2/3} I₁ − 3) + ½κ(J − 1)²",
    source: "Simo & Hughes 1998, ch. 9; U(J) of Bonet & Wood 2008, ch. 6",
    limits: "J > 0; no barrier against uniform collapse",
    parameters: moduli::PAIR,
    survives_inversion: false,
    objective: true,
    isochoric: true,
};

/// Neo-Hookean law with an isochoric and a volumetric part.
#[derive(Clone, Copy, Debug)]
pub struct NeoHookeanSplit(pub Moduli);

impl Law for NeoHookeanSplit {
    fn info(&self) -> &'static LawInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        vec![self.0.e, self.0.nu]
    }

    fn small_strain(&self) -> Moduli {
        self.0
    }

    fn split(&self) -> Option<(Box<dyn Law>, Volumetric)> {
        let volumetric = Volumetric { kind: VolumetricKind::Quadratic, kappa: self.0.kappa };
        Some((Box::new(Self(Moduli { kappa: 0.0, ..self.0 })), volumetric))
    }

    /// With G = F⁻ᵀ and m = μ J^{−2/3}: P = m(F − ⅓I₁ G) + κ(J − 1)J G;
    /// A_iJkL = m[δ_ik δ_JL − ⅔(F_iJ G_kL + G_iJ F_kL) + (2/9) I₁ G_iJ G_kL + ⅓I₁ G_iL G_kJ]
    ///        + κ[(2J − 1)J G_iJ G_kL − (J − 1)J G_iL G_kJ].
    fn eval(&self, f: &Mat3, want: Want) -> Result<Response, LawError> {
        let Moduli { mu, kappa, .. } = self.0;
        let k = Invariants::of_positive(f)?;
        let (j, x) = (k.j, k.x);
        let ln = k.ln_j();
        // J^{2/3} = eʸ; J^{−2/3} I₁ − 3 = e⁻ʸ{[I₁ − 3 − 2 ln J] − 3[eʸ − 1 − y]} since 3y = 2 ln J
        let y = 2.0 / 3.0 * ln;
        let m = mu * (-y).exp();
        let mut r = Response::energy(0.5 * m * (k.i_2ln(ln) - 3.0 * exp_m1_minus_y(y)) + 0.5 * kappa * x * x);
        if want >= Want::Residual {
            let g = k.cof / j;
            let third = (k.i + 3.0) / 3.0;
            r.p = (f - g * third) * m + g * (kappa * x * j);
            if want >= Want::Tangent {
                // The two mixed dyads as one: (F − ⅓I₁G) = D gives −⅔(D⊗G + G⊗D) − (2/9) I₁ G⊗G.
                let (g, d) = (rows(&g), rows(&(f - g * third)));
                let w = kappa * (j + x) * j - 2.0 / 3.0 * m * third;
                r.a = isotropic(m, w, m * third - kappa * x * j, &g);
                add_dyad(&mut r.a, -2.0 / 3.0 * m, &d, &g);
                add_dyad(&mut r.a, -2.0 / 3.0 * m, &g, &d);
            }
        }
        Ok(r)
    }
}
