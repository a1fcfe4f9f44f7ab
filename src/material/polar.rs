//! Rotation-variant singular value decomposition and polar decomposition of any F, including inverted and singular ones.
//!
//! F = U diag(s) Vᵀ with det U = det V = 1 and s₁ ≥ s₂ ≥ |s₃|; the sign of det F is the sign of s₃ (Irving, Teran & Fedkiw 2004). R = U Vᵀ is the
//! rotation nearest to F. One-sided Jacobi rotations keep every singular value to nearly full precision, where an eigendecomposition of FᵀF would
//! lose half the digits of the small ones (Golub & Van Loan, 4th ed., ch. 8). If s₂ + s₃ = 0, the nearest rotation is not unique and one of them is
//! returned.

use crate::math::tensor::{Mat3, Vec3, perpendicular};

/// F = U diag(s) Vᵀ, with the conventions of the module.
#[derive(Clone, Copy, Debug)]
pub struct SignedSvd {
    pub u: Mat3,
    /// s₁ ≥ s₂ ≥ |s₃| \[–\]
    pub s: [f64; 3],
    pub v: Mat3,
}

impl SignedSvd {
    pub fn of(f: &Mat3) -> Self {
        let scale = f.amax();
        if !(scale > 0.0 && scale.is_finite()) {
            // F = 0: all rotations are equally near. F not finite: s = tr F propagates the NaN.
            let s = if scale == 0.0 { 0.0 } else { f64::NAN };
            return Self { u: Mat3::identity(), s: [s; 3], v: Mat3::identity() };
        }
        let mut g = [0, 1, 2].map(|k| f.column(k) / scale);
        let mut v = [Vec3::x(), Vec3::y(), Vec3::z()];
        // Quadratic convergence takes 4 or 5 sweeps; the bound only guards the loop.
        for _ in 0..20 {
            let rotated = rotate(&mut g, &mut v, 0, 1) | rotate(&mut g, &mut v, 1, 2) | rotate(&mut g, &mut v, 0, 2);
            if !rotated {
                break;
            }
        }
        // Sort by length; exchanging two columns and changing one sign keeps det V = 1.
        for (p, q) in [(0, 1), (1, 2), (0, 1)] {
            if g[p].norm_squared() < g[q].norm_squared() {
                (g[p], g[q]) = (g[q], -g[p]);
                (v[p], v[q]) = (v[q], -v[p]);
            }
        }
        let s1 = g[0].norm();
        let u1 = g[0] / s1;
        let s2 = g[1].norm();
        let u2 = if s2 > 0.0 { g[1] / s2 } else { perpendicular(&u1) };
        let u3 = u1.cross(&u2);
        let s3 = u3.dot(&g[2]);
        Self {
            u: Mat3::from_columns(&[u1, u2, u3]),
            s: [s1 * scale, s2 * scale, s3 * scale],
            v: Mat3::from_columns(&v),
        }
    }

    /// R = U Vᵀ, the rotation nearest to F.
    pub fn rotation(&self) -> Mat3 {
        self.u * self.v.transpose()
    }
}

/// One Jacobi rotation that makes columns p and q of G orthogonal, with the same rotation of V; false if they already are.
#[inline(always)]
fn rotate(g: &mut [Vec3; 3], v: &mut [Vec3; 3], p: usize, q: usize) -> bool {
    const TOLERANCE: f64 = 4.0 * f64::EPSILON * f64::EPSILON;
    let (a, b, c) = (g[p].norm_squared(), g[q].norm_squared(), g[p].dot(&g[q]));
    if c * c <= TOLERANCE * a * b {
        return false;
    }
    let zeta = (b - a) / (2.0 * c);
    let t = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
    let cos = 1.0 / (1.0 + t * t).sqrt();
    let sin = cos * t;
    for m in [g, v] {
        (m[p], m[q]) = (m[p] * cos - m[q] * sin, m[p] * sin + m[q] * cos);
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(f: Mat3) {
        let d = SignedSvd::of(&f);
        let size = f.norm().max(f64::MIN_POSITIVE);
        let back = d.u * Mat3::from_diagonal(&Vec3::from(d.s)) * d.v.transpose();
        // Backward error of a few sweeps of 3 rotations each: below 50 ulp of ‖F‖.
        assert!((back - f).norm() <= 1e-14 * size, "{f} is not U S Vᵀ: {back}");
        for q in [d.u, d.v] {
            assert!((q.transpose() * q - Mat3::identity()).norm() < 1e-14, "not orthogonal: {q}");
            assert!((q.determinant() - 1.0).abs() < 1e-14, "not a rotation: {q}");
        }
        assert!(d.s[0] >= d.s[1] && d.s[1] * (1.0 + 1e-14) >= d.s[2].abs(), "order of {:?}", d.s);
    }

    #[test]
    fn regular_inverted_and_singular() {
        let m = |a: [f64; 9]| Mat3::from_row_slice(&a);
        let general = m([0.9, -0.4, 0.3, 0.7, 1.3, -0.2, -0.1, 0.5, 0.8]);
        check(general);
        check(-general);
        check(Mat3::identity());
        check(-Mat3::identity());
        check(Mat3::zeros());
        check(general * 1e-180);
        check(general * 1e150);
        check(m([1.0, 2.0, 3.0, 2.0, 4.0, 6.0, 3.0, 6.0, 9.0])); // collapsed to a line
        check(m([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0])); // to a plane
        check(m([0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0]));
        check(Mat3::from_diagonal(&Vec3::new(1.0, 1e-9, -1e-12)));
        check(general * Mat3::from_diagonal(&Vec3::new(1.0, 1e-7, -1e-14)));
    }
}
