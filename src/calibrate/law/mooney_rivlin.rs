//! Mooney–Rivlin with 2, 3 or 5 constants: ψ = C10 i + C01 k + C11 ik + C20 i² + C02 k², i = I₁ − 3, k = I₂ − 3.
//!
//! P = 2(1 − λ⁻³)(λψ₁ + ψ₂) uniaxial, 2(λ − λ⁻⁵)(ψ₁ + λ²ψ₂) equibiaxial, 2(λ − λ⁻³)(ψ₁ + ψ₂) planar, ψ₁ = ∂ψ/∂I₁, ψ₂ = ∂ψ/∂I₂.
//!
//! Source: Rivlin & Saunders, Phil. Trans. R. Soc. A 243 (1951); Treloar, 3rd ed. (1975), ch. 5. Limits: planar tests have I₁ = I₂
//! and see C10 + C01 only; uniaxial tests hardly tell the two apart at small strain. More constants than two need several modes.

use super::{Fittable, Form};
use crate::calibrate::term::of_invariants;
use crate::material::mooney_rivlin::{KEYS, MooneyRivlin};

pub const MOONEY_RIVLIN: Fittable = Fittable {
    name: "mooney_rivlin",
    formula: "P = 2(1 − λ⁻³)(λψ₁ + ψ₂) uniaxial, 2(λ − λ⁻⁵)(ψ₁ + λ²ψ₂) equibiaxial, 2(λ − λ⁻³)(ψ₁ + ψ₂) planar, ψ₁ = C10 + C11 k + 2 C20 i, ψ₂ = C01 + C11 i + 2 C02 k, i = I₁ − 3, k = I₂ − 3",
    source: "Rivlin & Saunders, Phil. Trans. R. Soc. A 243 (1951)",
    parameters: KEYS.split_at(2).1,
    terms: &[2, 3, 5],
    usual: 2,
    form: Form::Linear(|k, s| {
        let mut c = [0.0; 5];
        c[k] = 1.0;
        of_invariants(&MooneyRivlin { c, terms: 5 }, s)
    }),
};
