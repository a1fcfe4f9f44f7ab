//! Invariants of F = I + H without cancellation near F = I, where ψ = O(‖H‖²) is the difference of terms of order one.

use crate::math::tensor::{Mat3, det_minus_one, ln_det};

use super::LawError;

/// J [–], refused where it is not positive (or not a number).
#[inline]
pub fn positive_j(f: &Mat3) -> Result<f64, LawError> {
    let j = f.determinant();
    if j > 0.0 { Ok(j) } else { Err(LawError::Inverted { j }) }
}

/// ln J [–] of a positive J = det F: [`ln_det`] near 1; far from it J itself is the accurate number.
#[inline]
pub fn ln_j(f: &Mat3, j: f64) -> f64 {
    if (j - 1.0).abs() < 0.5 { ln_det(f) } else { j.ln() }
}

/// I₁ − 3 = 2 tr H + H : H [–].
#[inline]
pub fn i1_minus_three(f: &Mat3) -> f64 {
    let h = f - Mat3::identity();
    2.0 * h.trace() + h.norm_squared()
}

/// I₁ − 3 − 2(J − 1) [–]: the terms linear in H cancel by hand, leaving 2 ε:ε − tr²H − 2 det H with ε = sym H.
#[inline]
pub fn i1_minus_three_minus_two_x(f: &Mat3) -> f64 {
    let h = f - Mat3::identity();
    let shear = (h[(0, 1)] + h[(1, 0)]).powi(2) + (h[(1, 2)] + h[(2, 1)]).powi(2) + (h[(0, 2)] + h[(2, 0)]).powi(2);
    let normal = h[(0, 0)].powi(2) + h[(1, 1)].powi(2) + h[(2, 2)].powi(2);
    shear + 2.0 * normal - h.trace().powi(2) - 2.0 * h.determinant()
}

/// I₁ − 3 − 2 ln J [–] ≥ 0, with ln J at hand: [I₁ − 3 − 2x] + 2[x − ln(1 + x)], x = J − 1, near F = I.
#[inline]
pub fn i1_minus_three_minus_two_ln_j(f: &Mat3, ln_j: f64) -> f64 {
    let h = f - Mat3::identity();
    if h.norm_squared() < 0.1 {
        i1_minus_three_minus_two_x(f) + 2.0 * x_minus_ln_1p(det_minus_one(&h))
    } else {
        i1_minus_three(f) - 2.0 * ln_j
    }
}

/// x − ln(1 + x) [–] to full relative accuracy: with y = x/(2 + x), ln(1 + x) = 2 artanh y, so it is xy − 2(y³/3 + y⁵/5 + …).
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

/// eʸ − 1 − y [–] to full relative accuracy.
#[inline]
pub fn exp_m1_minus_y(y: f64) -> f64 {
    if y.abs() >= 0.5 {
        return y.exp_m1() - y;
    }
    // y²/2 (1 + y/3 (1 + y/4 (…))): the term dropped is 2 y¹³/15! of the first one, below 1e-15 at |y| = ½.
    let tail = (3..=15).rev().fold(1.0, |s, n| 1.0 + s * y / f64::from(n));
    0.5 * y * y * tail
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The leading terms of the Taylor series are the independent value where the argument is small.
    #[test]
    fn small_differences_keep_their_digits() {
        for x in [1e-9_f64, -3e-7, 2e-6] {
            let ln = x * x / 2.0 - x.powi(3) / 3.0 + x.powi(4) / 4.0;
            assert!((x_minus_ln_1p(x) / ln - 1.0).abs() < 1e-15, "x − ln(1+x) at {x}");
            let exp = x * x / 2.0 + x.powi(3) / 6.0 + x.powi(4) / 24.0;
            assert!((exp_m1_minus_y(x) / exp - 1.0).abs() < 1e-15, "eʸ − 1 − y at {x}");
        }
    }

    /// Both branches meet: the direct difference loses no more than a few digits at the switch.
    #[test]
    fn branches_meet() {
        for s in [-1.0, 1.0] {
            let x = s * 0.1999999;
            assert!((x_minus_ln_1p(x) / (x - x.ln_1p()) - 1.0).abs() < 1e-14);
            let y = s * 0.4999999;
            assert!((exp_m1_minus_y(y) / (y.exp_m1() - y) - 1.0).abs() < 1e-14);
        }
    }
}
