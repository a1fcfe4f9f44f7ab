//! Invariants of F = I + H without cancellation near F = I, where ψ = O(‖H‖²) is a difference of terms of order one.

use crate::math::tensor::{Mat3, cofactor, det_minus_one};

use super::response::LawError;

/// Invariants of one F, each without cancellation.
#[derive(Clone, Copy, Debug)]
pub struct Invariants {
    /// Whether ‖H‖² < 0.1: the differences are then formed from H, otherwise from F, where they do not cancel
    near: bool,
    /// cof F = J F⁻ᵀ \[–\]
    pub cof: Mat3,
    /// J = det F \[–\]
    pub j: f64,
    /// x = J − 1 \[–\]
    pub x: f64,
    /// I₁ − 3 \[–\] = 2 tr H + H:H
    pub i: f64,
    /// I₁ − 3 − 2x \[–\], with the terms linear in H cancelled analytically: 2 ε:ε − tr²H − 2 det H, ε = sym H
    pub i_2x: f64,
}

impl Invariants {
    /// The invariants of any F, including singular and inverted ones.
    #[inline(always)]
    pub fn of(f: &Mat3) -> Self {
        let cof = cofactor(f);
        let j = f[(0, 0)] * cof[(0, 0)] + f[(0, 1)] * cof[(0, 1)] + f[(0, 2)] * cof[(0, 2)];
        let h = f - Mat3::identity();
        let squares = h.norm_squared();
        let i = 2.0 * h.trace() + squares;
        let near = squares < 0.1;
        if near {
            let shear =
                (h[(0, 1)] + h[(1, 0)]).powi(2) + (h[(1, 2)] + h[(2, 1)]).powi(2) + (h[(0, 2)] + h[(2, 0)]).powi(2);
            let normal = h[(0, 0)].powi(2) + h[(1, 1)].powi(2) + h[(2, 2)].powi(2);
            let i_2x = shear + 2.0 * normal - h.trace().powi(2) - 2.0 * h.determinant();
            Self { near, cof, j, x: det_minus_one(&h), i, i_2x }
        } else {
            Self { near, cof, j, x: j - 1.0, i, i_2x: i - 2.0 * (j - 1.0) }
        }
    }

    /// The invariants of an F with J > 0; refused otherwise, also for NaN.
    #[inline(always)]
    pub fn of_positive(f: &Mat3) -> Result<Self, LawError> {
        let k = Self::of(f);
        if k.j > 0.0 { Ok(k) } else { Err(LawError::Inverted { j: k.j }) }
    }

    /// ln J \[–\], for J > 0.
    #[inline(always)]
    pub fn ln_j(&self) -> f64 {
        if self.near { self.x.ln_1p() } else { self.j.ln() }
    }

    /// I₁ − 3 − 2 ln J \[–\] ≥ 0, for J > 0 and with ln J given: \[I₁ − 3 − 2x\] + 2\[x − ln(1 + x)\] near F = I.
    #[inline(always)]
    pub fn i_2ln(&self, ln_j: f64) -> f64 {
        if self.near { self.i_2x + 2.0 * x_minus_ln_1p(self.x) } else { self.i - 2.0 * ln_j }
    }

    /// I₁(K) − 3 − 2(det K − 1) \[–\] of K = cof F, det K = J²: I₂ − 3 − 2(J² − 1) because I₂ = K:K. Near F = I computed from K − I = tr H I − Hᵀ +
    /// cof H.
    #[inline(always)]
    pub fn second_2x(&self, f: &Mat3) -> f64 {
        if !self.near {
            return self.cof.norm_squared() - 3.0 - 2.0 * self.x * (2.0 + self.x);
        }
        let h = f - Mat3::identity();
        let d = Mat3::identity() * h.trace() - h.transpose() + cofactor(&h);
        let eps = (d + d.transpose()) * 0.5;
        2.0 * eps.norm_squared() - d.trace().powi(2) - 2.0 * d.determinant()
    }
}

/// x − ln(1 + x) \[–\] to full relative accuracy: with y = x/(2 + x) and ln(1 + x) = 2 artanh y it is xy − 2(y³/3 + y⁵/5 + …).
#[inline]
pub fn x_minus_ln_1p(x: f64) -> f64 {
    if x.abs() >= 0.2 {
        return x - x.ln_1p();
    }
    // |y| < 1/9: the last term kept is y¹⁷/17, below 1e-16 of xy ≈ 2y².
    let y = x / (2.0 + x);
    let z = y * y;
    let odd = [17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0].iter().fold(0.0, |s, n| s * z + 1.0 / n);
    x * y - 2.0 * y * z * odd
}

/// eʸ − 1 − y \[–\] to full relative accuracy.
#[inline]
pub fn exp_m1_minus_y(y: f64) -> f64 {
    if y.abs() >= 0.5 {
        return y.exp_m1() - y;
    }
    // y²/2 (1 + y/3 (1 + y/4 (…))): the first neglected term is 2 y¹³/15! relative to the first one, below 1e-15 at |y| = ½.
    let tail = (3..=15).rev().fold(1.0, |s, n| 1.0 + s * y / f64::from(n));
    0.5 * y * y * tail
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The leading terms of the Taylor series are the independent reference for small arguments.
    #[test]
    fn small_differences_keep_their_digits() {
        for x in [1e-9_f64, -3e-7, 2e-6] {
            let ln = x * x / 2.0 - x.powi(3) / 3.0 + x.powi(4) / 4.0;
            assert!((x_minus_ln_1p(x) / ln - 1.0).abs() < 1e-15, "x − ln(1+x) at {x}");
            let exp = x * x / 2.0 + x.powi(3) / 6.0 + x.powi(4) / 24.0;
            assert!((exp_m1_minus_y(x) / exp - 1.0).abs() < 1e-15, "eʸ − 1 − y at {x}");
        }
    }

    /// Both branches agree: the direct difference loses only a few digits at the switch.
    #[test]
    fn branches_agree_at_the_switch() {
        for s in [-1.0, 1.0] {
            let x = s * 0.1999999;
            assert!((x_minus_ln_1p(x) / (x - x.ln_1p()) - 1.0).abs() < 1e-14);
            let y = s * 0.4999999;
            assert!((exp_m1_minus_y(y) / (y.exp_m1() - y) - 1.0).abs() < 1e-14);
        }
    }
}
