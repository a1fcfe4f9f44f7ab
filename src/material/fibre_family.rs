//! Energy of a family of fibres spread over a material, after Holzapfel, Gasser & Ogden.
//!
//! ```text
//! ψ = k₁/2k₂ [exp(k₂⟨Ē⟩²) − 1]    Ē = κ(Ī₁ − 3) + (1 − 3κ)(Ī₄ − 1) = J^{−2/3} F:FM − 1    M = κ I + (1 − 3κ) a⊗a
//! P = ψ′ D    D = J^{−2/3}(2FM − ⅔ Q G)    A = ψ″ D⊗D + ψ′ ∂D    Q = F:FM, G = F⁻ᵀ
//! ∂D = J^{−2/3}[2δ_ik M_JL − (4/3)(T_iJ G_kL + G_iJ T_kL) + (4/9) Q G_iJ G_kL + ⅔ Q G_iL G_kJ]    T = FM
//! ```
//!
//! Here a is the unit direction at rest; κ = 0 aligns all fibres with it (Holzapfel, Gasser & Ogden, J. Elast. 61, 2000, eq. 66), κ = ⅓ spreads them
//! over all directions (Gasser, Ogden & Holzapfel, J. R. Soc. Interface 3, 2006, eq. 4.6). ⟨Ē⟩ is Ē if positive, otherwise 0: the fibres act in
//! tension only. ψ is independent of the volume.

use super::kinematics::Invariants;
use super::response::{LawError, Response, Want};
use crate::math::tensor::{Mat3, Vec3};

/// Exponent beyond which exp, multiplied by its square in the tangent, would soon overflow.
const MOST_EXPONENT: f64 = 300.0;

/// Constants of a family.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FibreFamily {
    /// k₁ > 0 \[Pa\]
    pub k1: f64,
    /// k₂ ≥ 0 \[–\]; for 0 the energy is ½ k₁ ⟨Ē⟩²
    pub k2: f64,
    /// κ, 0 ≤ κ ≤ ⅓ \[–\]
    pub kappa: f64,
}

impl FibreFamily {
    /// ψ, P and A of the fibres along the unit vector `a` at F; refuses det F ≤ 0, and fibres that are stretched so far that exp overflows.
    pub fn eval(&self, a: &Vec3, f: &Mat3, want: Want) -> Result<Response, LawError> {
        let invariants = Invariants::of_positive(f)?;
        let (j, g) = (invariants.j, invariants.cof / invariants.j);
        let spread = Mat3::identity() * self.kappa + a * a.transpose() * (1.0 - 3.0 * self.kappa);
        let t = f * spread;
        let q = f.dot(&t);
        let m = j.powf(-2.0 / 3.0);
        // F:FM − 1 = 2 H:M + H:HM with F = I + H, without cancellation; m − 1 by expm1
        let h = f - Mat3::identity();
        let longer = 2.0 * h.dot(&spread) + h.dot(&(h * spread));
        let e = longer + q * (-2.0 / 3.0 * invariants.ln_j()).exp_m1();
        if e <= 0.0 {
            return Ok(Response::energy(0.0));
        }
        let exponent = self.k2 * e * e;
        if exponent > MOST_EXPONENT {
            return Err(LawError::Locked { i: e, limit: (MOST_EXPONENT / self.k2).sqrt() });
        }
        let energy = if self.k2 > 0.0 { exponent.exp_m1() / self.k2 } else { e * e };
        let mut r = Response::energy(0.5 * self.k1 * energy);
        if want < Want::Residual {
            return Ok(r);
        }
        let grown = exponent.exp();
        let slope = self.k1 * e * grown;
        let d = (t * 2.0 - g * (2.0 / 3.0 * q)) * m;
        r.p = d * slope;
        if want < Want::Tangent {
            return Ok(r);
        }
        let curvature = self.k1 * grown * (1.0 + 2.0 * exponent);
        for row in 0..9 {
            let (i, jj) = (row / 3, row % 3);
            for column in 0..9 {
                let (k, l) = (column / 3, column % 3);
                let same = if i == k { 2.0 * spread[(jj, l)] } else { 0.0 };
                let second = same - 4.0 / 3.0 * (t[(i, jj)] * g[(k, l)] + g[(i, jj)] * t[(k, l)])
                    + 4.0 / 9.0 * q * g[(i, jj)] * g[(k, l)]
                    + 2.0 / 3.0 * q * g[(i, l)] * g[(k, jj)];
                r.a[row][column] = curvature * d[(i, jj)] * d[(k, l)] + slope * m * second;
            }
        }
        Ok(r)
    }
}
