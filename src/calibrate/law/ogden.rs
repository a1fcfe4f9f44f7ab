//! Ogden with 1 to 4 terms: ψ = Σ (μ_n/α_n)(λ₁^{α_n} + λ₂^{α_n} + λ₃^{α_n} − 3).
//!
//! P = Σ μ_n (λ^{α_n − 1} − λ^{−α_n/2 − 1}) uniaxial, Σ μ_n (λ^{α_n − 1} − λ^{−2α_n − 1}) equibiaxial, Σ μ_n (λ^{α_n − 1} − λ^{−α_n − 1}) planar.
//!
//! Fitted with c_n = μ_n α_n ≥ 0: then every term is convex in ln λ, and their sum is stable at every stretch in every mode
//! (Hill's inequality; Ogden, Non-linear Elastic Deformations, 1984, ch. 6). Pairs of large terms that cancel cannot occur.
//!
//! Source: Ogden, Proc. R. Soc. A 326 (1972). Limits: terms of the other sign, which may describe data better up to some stretch
//! and are unstable beyond, are not looked for.

use super::{Family, Fittable, Form};
use crate::material::ogden::KEYS;

pub const OGDEN: Fittable = Fittable {
    name: "ogden",
    formula: "P = Σ μ_n (λ^{α_n − 1} − λ₃^{α_n}/λ), λ₃ = λ^{−1/2} uniaxial, λ⁻² equibiaxial, λ⁻¹ planar; μ_n α_n ≥ 0",
    source: "Ogden, Proc. R. Soc. A 326 (1972)",
    parameters: KEYS.split_at(2).1,
    terms: &[1, 2, 3, 4],
    usual: 3,
    form: Form::Separable(Family {
        // w = (Σ λ^α − 3)/α², so that τᵢ = λᵢ^α/α; less 1/α, which is a pressure: smooth where α changes its sign
        tau: |alpha, s| s.map(|x| power(alpha, x)),
        tau_by_shape: |alpha, s| s.map(|x| power_by_alpha(alpha, x)),
        shape: |x, _| (x, 1.0),
        grid: &[-12.0, -8.0, -5.0, -3.0, -2.0, -1.0, 0.6, 1.3, 2.0, 3.0, 4.5, 6.5, 9.0, 13.0, 18.0],
        factor: |alpha| (1.0 / alpha, -1.0 / (alpha * alpha)),
    }),
};

/// (λ^α − 1)/α
fn power(alpha: f64, x: f64) -> f64 {
    let e = x.ln();
    if alpha == 0.0 { e } else { (alpha * e).exp_m1() / alpha }
}

/// ∂/∂α of it: \[αe λ^α − (λ^α − 1)\]/α², by its series where the difference cancels
fn power_by_alpha(alpha: f64, x: f64) -> f64 {
    let e = x.ln();
    let y = alpha * e;
    if y.abs() < 1e-2 {
        // e²(1/2 + y/3 + y²/8 + y³/30 + y⁴/144 + y⁵/840): the next term is y⁶/5760 < 2e-16
        let series = [1.0 / 840.0, 1.0 / 144.0, 1.0 / 30.0, 1.0 / 8.0, 1.0 / 3.0, 0.5];
        return e * e * series.iter().fold(0.0, |s, c| s * y + c);
    }
    let grown = y.exp_m1();
    (y + (y - 1.0) * grown) / (alpha * alpha)
}
