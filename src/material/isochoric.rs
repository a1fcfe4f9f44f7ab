//! Isochoric parts W(Ī₁, Ī₂) of the modified invariants Ī₁ = J^{−2/3} I₁, Ī₂ = J^{−4/3} I₂, I₂ = ½(I₁² − C:C) = cof F:cof F.
//!
//! With G = F⁻ᵀ, N = ½ ∂I₂/∂F = I₁F − FFᵀF, D₁ = J^{−2/3}(F − ⅓I₁G) = ½ ∂Ī₁/∂F and D₂ = J^{−4/3}(N − ⅔I₂G) = ½ ∂Ī₂/∂F:
//!
//! P = 2W₁D₁ + 2W₂D₂ + U′J G
//!
//! A = 4W₁₁ D₁⊗D₁ + 4W₁₂(D₁⊗D₂ + D₂⊗D₁) + 4W₂₂ D₂⊗D₂ + 2W₁ ∂D₁ + 2W₂ ∂D₂ + (U″J² + U′J) G⊗G − U′J G_iL G_kJ
//!
//! ∂D₁ = J^{−2/3}\[𝕀 − (2/9)I₁ G⊗G + ⅓I₁ G_iL G_kJ\] − ⅔(D₁⊗G + G⊗D₁)
//!
//! ∂D₂ = J^{−4/3}\[2F⊗F + I₁𝕀 − δ_ik (FᵀF)_JL − F_iL F_kJ − (FFᵀ)_ik δ_JL − (8/9)I₂ G⊗G + ⅔I₂ G_iL G_kJ\] − (4/3)(D₂⊗G + G⊗D₂)
//!
//! Source: Holzapfel, *Nonlinear Solid Mechanics*, 2000, ch. 6, written in F.

use super::assemble::{add_dyad, isotropic, rows};
use super::kinematics::{Invariants, exp_m1_minus_y};
use super::response::{LawError, Response, Want};
use super::volumetric::Volumetric;
use crate::math::tensor::{Mat3, Mat9};

/// W \[J/m³\] and its derivatives \[Pa\] by Ī₁ and Ī₂.
#[derive(Clone, Copy, Default, Debug)]
pub struct Partials {
    pub w: f64,
    pub w1: f64,
    pub w2: f64,
    pub w11: f64,
    pub w12: f64,
    pub w22: f64,
}

/// A part given by its derivatives.
pub trait Strain {
    /// Depends on Ī₂; without it the second invariant is not computed
    const SECOND: bool;
    /// At i = Ī₁ − 3 ≥ 0 and k = Ī₂ − 3 ≥ 0 \[–\] (k = 0 where it does not depend on it)
    fn partials(&self, i: f64, k: f64) -> Result<Partials, LawError>;
}

/// A part with constants of its own.
pub trait Parametric: Strain {
    /// ∂/∂θ of [`Strain::partials`], where the values of the part change by `rates` per unit of θ
    fn partials_along(&self, rates: &[f64], i: f64, k: f64) -> Result<Partials, LawError>;
}

/// ∂W/∂θ of a part: of the same form, with the derivatives of its derivatives.
pub struct Along<'a, W> {
    pub part: &'a W,
    /// ∂/∂θ of its values
    pub rates: &'a [f64],
}

impl<W: Parametric> Strain for Along<'_, W> {
    const SECOND: bool = W::SECOND;

    fn partials(&self, i: f64, k: f64) -> Result<Partials, LawError> {
        self.part.partials_along(self.rates, i, k)
    }
}

/// ψ = W + U, P and A at F.
#[inline(always)]
pub fn response<W: Strain>(part: &W, u: &Volumetric, f: &Mat3, want: Want) -> Result<Response, LawError> {
    let k = Invariants::of_positive(f)?;
    let ln = k.ln_j();
    // J^{2/3} = eʸ; J^{−2/3} I₁ − 3 = e⁻ʸ{[I₁ − 3 − 2 ln J] − 3[eʸ − 1 − y]} since 3y = 2 ln J; Ī₂(F) = Ī₁(cof F)
    let y = 2.0 / 3.0 * ln;
    let m = (-y).exp();
    let second = if W::SECOND { m * m * (k.second_2ln(f, ln) - 3.0 * exp_m1_minus_y(2.0 * y)) } else { 0.0 };
    let d = part.partials(m * (k.i_2ln(ln) - 3.0 * exp_m1_minus_y(y)), second)?;
    let (energy, du, d2u) = u.at(k.x);
    let mut r = Response::energy(d.w + energy);
    if want < Want::Residual {
        return Ok(r);
    }
    let j = k.j;
    let g = k.cof / j;
    let third = (k.i + 3.0) / 3.0;
    let d1 = f - g * third;
    let c1 = 2.0 * m * d.w1;
    let pressure = du * j;
    r.p = d1 * c1 + g * pressure;
    let i2 = if W::SECOND { k.cof.norm_squared() } else { 0.0 };
    let c2 = 2.0 * m * m * d.w2;
    let mut d2 = Mat3::zeros();
    if W::SECOND {
        d2 = f * (3.0 * third) - f * (f.transpose() * f) - g * (2.0 / 3.0 * i2);
        r.p += d2 * c2;
    }
    if want < Want::Tangent {
        return Ok(r);
    }
    let (gr, d1r) = (rows(&g), rows(&d1));
    let ww = (d2u * j + du) * j - 2.0 / 3.0 * c1 * third - 8.0 / 9.0 * c2 * i2;
    let xx = c1 * third + 2.0 / 3.0 * c2 * i2 - pressure;
    r.a = isotropic(c1 + 3.0 * third * c2, ww, xx, &gr);
    // The dyads with G on one side, and the ones of D₁ and D₂, as u⊗(αu + βv + …) each.
    let row = |a: f64, b: f64, c: f64, d2r: &[f64; 9]| {
        let mut v = [0.0; 9];
        for n in 0..9 {
            v[n] = a * gr[n] + b * d1r[n] + c * d2r[n];
        }
        v
    };
    let (g1, g2) = (-2.0 / 3.0 * c1, -4.0 / 3.0 * c2);
    if W::SECOND {
        let d2r = rows(&d2);
        let (m2, m3, m4) = (m * m, m * m * m, m * m * m * m);
        add_dyad(&mut r.a, 1.0, &gr, &row(0.0, g1, g2, &d2r));
        add_dyad(&mut r.a, 1.0, &d1r, &row(g1, 4.0 * m2 * d.w11, 4.0 * m3 * d.w12, &d2r));
        add_dyad(&mut r.a, 1.0, &d2r, &row(g2, 4.0 * m3 * d.w12, 4.0 * m4 * d.w22, &d2r));
        add_second(&mut r.a, c2, f);
    } else {
        add_dyad(&mut r.a, g1, &gr, &d1r);
        add_dyad(&mut r.a, 1.0, &d1r, &row(g1, 4.0 * m * m * d.w11, 0.0, &[0.0; 9]));
    }
    Ok(r)
}

/// a += c\[2F⊗F − δ_ik (FᵀF)_JL − F_iL F_kJ − (FFᵀ)_ik δ_JL\].
#[inline(always)]
fn add_second(a: &mut Mat9, c: f64, f: &Mat3) {
    let (right, left) = (f.transpose() * f, f * f.transpose());
    for i in 0..3 {
        for j in 0..3 {
            let row = &mut a[3 * i + j];
            for k in 0..3 {
                for l in 0..3 {
                    row[3 * k + l] += c * (2.0 * f[(i, j)] * f[(k, l)] - f[(i, l)] * f[(k, j)]);
                }
                row[3 * i + k] -= c * right[(j, k)];
                row[3 * k + j] -= c * left[(i, k)];
            }
        }
    }
}
