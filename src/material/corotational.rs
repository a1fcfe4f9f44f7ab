//! Corotational linear elasticity: Hooke's law in the frame of the rotation nearest to F.
//!
//! ψ = μ‖F − R‖² + ½λ tr²(RᵀF − I), F = RS
//!
//! Source: Sifakis & Barbič, *FEM Simulation of 3D Deformable Solids*, SIGGRAPH 2012 course notes, part I, ch. 3. Twist modes: Smith,
//! de Goes & Kim, *Analytic eigensystems for isotropic distortion energies*, ACM TOG 2019.
//!
//! Limits: large rotation, small strain. With R a proper rotation ψ is defined for every F and grows with inversion, but it stays
//! finite at J = 0. R jumps where s₂ + s₃ = 0 (strongly inverted or collapsed to a line): ψ is continuous there with a concave kink.

use super::assemble::{add_dyad, isotropic};
use super::entry::LawEntry;
use super::law::{Law, LawInfo};
use super::moduli;
use super::moduli::Moduli;
use super::polar::SignedSvd;
use super::response::{LawError, Response, Want};
use crate::math::tensor::{Mat3, Row9, rows};

pub static INFO: LawInfo = LawInfo {
    name: "corotational",
    title: "corotational",
    formula: "ψ = μ‖F − R‖² + ½λ tr²(RᵀF − I)",
    source: "Sifakis & Barbič 2012, part I, ch. 3",
    limits: "small strain, any rotation; finite energy at J = 0, so cells may invert under load; they are driven back",
    parameters: moduli::PAIR,
    optional: 0,
    choices: &[],
    survives_inversion: true,
    objective: true,
    isochoric: false,
};

/// The law in the registry.
pub const ENTRY: LawEntry = LawEntry::elastic(&INFO, |v, _| Ok(Box::new(Corotational(Moduli::from_map(v)?))));

/// Smallest s_i + s_j \[–\] by which the derivative of R is divided. Below it ∂R/∂F, which is infinite at the kink, is limited to 2/(s_i + s_j) =
/// 2e6; above it A is exact.
const NEAR_KINK: f64 = 1e-6;

/// Corotational law.
#[derive(Clone, Copy, Debug)]
pub struct Corotational(pub Moduli);

impl Law for Corotational {
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

    /// P = 2μ(F − R) + λ tr(S − I) R. From δR = Σ_{i<j} 2/(s_i + s_j) (T_ij : δF) T_ij with the twists
    /// T_ij = U (e_i e_jᵀ − e_j e_iᵀ)/√2 Vᵀ: A = 2μ 𝕀 + λ R ⊗ R + (λ tr(S − I) − 2μ) Σ_{i<j} 2/(s_i + s_j) T_ij ⊗ T_ij.
    fn eval(&self, f: &Mat3, want: Want) -> Result<Response, LawError> {
        let Moduli { mu, lambda, .. } = self.0;
        let svd = SignedSvd::of(f);
        let s = svd.s;
        let r = svd.rotation();
        let tr = (s[0] - 1.0) + (s[1] - 1.0) + (s[2] - 1.0);
        let squares: f64 = s.iter().map(|s| (s - 1.0).powi(2)).sum();
        let mut out = Response::energy(mu * squares + 0.5 * lambda * tr * tr);
        if want >= Want::Residual {
            out.p = (f - r) * (2.0 * mu) + r * (lambda * tr);
        }
        if want >= Want::Tangent {
            out.a = isotropic(2.0 * mu, lambda, 0.0, &rows(&r));
            for (i, j) in [(0, 1), (0, 2), (1, 2)] {
                let t = twist(&svd, i, j);
                // T = √2 T_ij, so that its dyad has half the factor 2/(s_i + s_j).
                add_dyad(&mut out.a, (lambda * tr - 2.0 * mu) / (s[i] + s[j]).max(NEAR_KINK), &t, &t);
            }
        }
        Ok(out)
    }
}

/// u_i v_jᵀ − u_j v_iᵀ = √2 T_ij.
#[inline(always)]
fn twist(d: &SignedSvd, i: usize, j: usize) -> Row9 {
    let mut t = [0.0; 9];
    for a in 0..3 {
        for b in 0..3 {
            t[3 * a + b] = d.u[(a, i)] * d.v[(b, j)] - d.u[(a, j)] * d.v[(b, i)];
        }
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::statistics::larger;
    use crate::math::tensor::Vec3;

    fn law() -> Corotational {
        Corotational(Moduli::from_e_nu(100e3, 0.3).expect("within bounds"))
    }

    /// An inverted gradient with s₂ + s₃ = δ, rotated so that no entry is zero.
    fn near_kink(delta: f64) -> Mat3 {
        let q = nalgebra::Rotation3::from_euler_angles(0.4, -0.9, 1.7).into_inner();
        q * Mat3::from_diagonal(&Vec3::new(1.2, 0.6, delta - 0.6)) * q * q
    }

    /// Compares A : D with the central difference of P along D, extrapolated once, at δ = 1e-2. With h = δ/400 the truncation is (1/400)⁴/4 of A and
    /// the rounding, ε/δ in R over h, 1e-11 of A (A ≈ 2μ·2/δ).
    #[test]
    fn tangent_is_exact_near_the_kink() {
        let f = near_kink(1e-2);
        let d = Mat3::new(0.3, -0.5, 0.2, 0.7, 0.1, -0.4, -0.2, 0.6, 0.5);
        let p = |h: f64| law().eval(&(f + d * h), Want::Residual).expect("defined for every F").p;
        let central = |h: f64| (p(h) - p(-h)) / (2.0 * h);
        let h = 1e-2 / 400.0;
        let reference = rows(&((central(h / 2.0) * 4.0 - central(h)) / 3.0));
        let a = law().eval(&f, Want::Tangent).expect("defined for every F").a;
        let size = a.as_flattened().iter().fold(0.0, |m, x| larger(m, x.abs()));
        for (row, want) in a.iter().zip(reference) {
            let got: f64 = row.iter().zip(rows(&d)).map(|(x, y)| x * y).sum();
            assert!((got - want).abs() < 1e-8 * size, "{got}, difference {want}");
        }
    }

    /// ψ is continuous across the kink, where P jumps, and A stays below its limit.
    #[test]
    fn the_kink_is_finite() {
        let at = |delta| law().eval(&near_kink(delta), Want::Tangent).expect("defined for every F");
        for delta in [1e-5, 1e-9, 0.0] {
            let (above, below) = (at(delta), at(-delta));
            let slope = above.p.norm() + below.p.norm();
            assert!((above.psi - below.psi).abs() <= 2.0 * delta * slope + 1e-14 * slope);
            let bound = 4.0 * (law().0.mu + law().0.kappa) / NEAR_KINK;
            assert!(above.a.as_flattened().iter().all(|x| x.abs() <= bound), "A at δ = {delta}");
        }
    }
}
