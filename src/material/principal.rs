//! Terms of an incompressible energy ψ = Σ c w, by their derivatives in eᵢ = ln λᵢ.
//!
//! τᵢ = ∂w/∂eᵢ, Dᵢⱼ = ∂τᵢ/∂eⱼ. Direction 3 is stress-free in every fitted test, which determines the pressure:
//!
//! P = (τ₁ − τ₃)/λ₁, in simple shear P₁₂ = (τ₁ − τ₃)/(λ₁ + λ₁⁻¹)
//!
//! For w(I₁, I₂) with aᵢ = ∂I₁/∂eᵢ = 2λᵢ² and bᵢ = ∂I₂/∂eᵢ = −2λᵢ⁻² (J = 1, I₂ = Σλᵢ⁻²): τ = w₁a + w₂b, D = 2w₁ diag a − 2w₂ diag b + w₁₁ a⊗a +
//! w₁₂(a⊗b + b⊗a) + w₂₂ b⊗b.
//!
//! Source: Ogden, *Non-linear Elastic Deformations*, 1984, ch. 6; Treloar, *The Physics of Rubber Elasticity*, 3rd ed. 1975, ch. 5.

use super::isochoric::{InvariantEnergy, Partials};

/// Derivatives of one term with factor 1.
#[derive(Clone, Copy, Debug)]
pub struct PrincipalDerivatives {
    /// τᵢ \[–\]
    pub tau: [f64; 3],
    /// Dᵢⱼ \[–\]
    pub d: [[f64; 3]; 3],
}

/// I₁ − 3 and I₂ − 3 \[–\] at the principal stretches of an incompressible material.
pub fn invariants(s: [f64; 3]) -> (f64, f64) {
    (s.iter().map(|x| x * x).sum::<f64>() - 3.0, s.iter().map(|x| 1.0 / (x * x)).sum::<f64>() - 3.0)
}

/// Derivatives of a law in the invariants; NaN where the law is not defined.
pub fn of_invariants(law: &impl InvariantEnergy, s: [f64; 3]) -> PrincipalDerivatives {
    let (i, k) = invariants(s);
    let nan = Partials { w1: f64::NAN, ..Partials::default() };
    let w = law.partials(i, k).unwrap_or(nan);
    let (a, b) = (s.map(|x| 2.0 * x * x), s.map(|x| -2.0 / (x * x)));
    let row = |i: usize| {
        let entry = |j: usize| {
            let own = if i == j { 2.0 * (w.w1 * a[i] - w.w2 * b[i]) } else { 0.0 };
            own + w.w11 * a[i] * a[j] + w.w12 * (a[i] * b[j] + b[i] * a[j]) + w.w22 * b[i] * b[j]
        };
        [0, 1, 2].map(entry)
    };
    PrincipalDerivatives { tau: tau(w.w1, w.w2, s), d: [0, 1, 2].map(row) }
}

/// τ \[–\] from w₁ and w₂.
pub fn tau(w1: f64, w2: f64, s: [f64; 3]) -> [f64; 3] {
    s.map(|x| 2.0 * (w1 * x * x - w2 / (x * x)))
}

impl PrincipalDerivatives {
    /// The second derivative in the plane Σde = 0 as (q₁₁, q₁₂, q₂₂) for de = (u, v, −u − v): Drucker's stability requires it to be positive
    /// definite.
    pub fn in_plane(&self) -> [f64; 3] {
        let d = &self.d;
        [d[0][0] - 2.0 * d[0][2] + d[2][2], d[0][1] - d[0][2] - d[1][2] + d[2][2], d[1][1] - 2.0 * d[1][2] + d[2][2]]
    }
}

#[cfg(test)]
mod tests {
    use super::super::mooney_rivlin::MooneyRivlin;
    use super::*;

    /// Compares with differences of ψ along e: τ is its gradient and D its Hessian within Σe = 0 (h = 1e-4: h²ψ⁗/12 and εψ/h² are below 1e-6 of ψ″
    /// here).
    #[test]
    fn tau_and_d_are_derivatives_of_the_energy() {
        let law = MooneyRivlin { c: [1.0, 0.4, -0.2, 0.3, 0.1], terms: 5 };
        let energy = |e: [f64; 3]| {
            let (i, k) = invariants(e.map(f64::exp));
            law.partials(i, k).expect("a polynomial").w
        };
        let e: [f64; 3] = [0.31, -0.12, -0.19];
        let got = of_invariants(&law, e.map(f64::exp));
        let h = 1e-4;
        let moved = |u: f64, v: f64| energy([e[0] + u, e[1] + v, e[2] - u - v]);
        let first = (moved(h, 0.0) - moved(-h, 0.0)) / (2.0 * h);
        assert!((got.tau[0] - got.tau[2] - first).abs() < 1e-6, "{first}");
        let [q11, q12, q22] = got.in_plane();
        let second = (moved(h, 0.0) - 2.0 * moved(0.0, 0.0) + moved(-h, 0.0)) / (h * h);
        let other = (moved(0.0, h) - 2.0 * moved(0.0, 0.0) + moved(0.0, -h)) / (h * h);
        let mixed = (moved(h, h) - moved(h, -h) - moved(-h, h) + moved(-h, -h)) / (4.0 * h * h);
        for (a, b) in [(q11, second), (q22, other), (q12, mixed)] {
            assert!((a - b).abs() < 1e-5 * q11, "{a} not {b}");
        }
    }
}
