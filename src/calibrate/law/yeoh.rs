//! Yeoh with 1, 2 or 3 constants: ψ = C10 i + C20 i² + C30 i³, i = I₁ − 3.
//!
//! P = 2ψ₁(λ − λ⁻²) uniaxial, 2ψ₁(λ − λ⁻⁵) equibiaxial, 2ψ₁(λ − λ⁻³) planar, ψ₁ = C10 + 2 C20 i + 3 C30 i².
//!
//! Source: Yeoh, Rubber Chem. Technol. 66 (1993). Limits: no I₂: equibiaxial stresses come out too low where the other modes
//! are fitted.

use super::{Fittable, Form};
use crate::calibrate::term::of_invariants;
use crate::material::yeoh::{KEYS, Yeoh};

pub const YEOH: Fittable = Fittable {
    name: "yeoh",
    formula: "P = 2ψ₁(λ − λ⁻²) uniaxial, 2ψ₁(λ − λ⁻⁵) equibiaxial, 2ψ₁(λ − λ⁻³) planar, ψ₁ = C10 + 2 C20 i + 3 C30 i², i = I₁ − 3",
    source: "Yeoh, Rubber Chem. Technol. 66 (1993)",
    parameters: KEYS.split_at(2).1,
    terms: &[1, 2, 3],
    usual: 3,
    form: Form::Linear(|k, s| {
        let mut c = [0.0; 3];
        c[k] = 1.0;
        of_invariants(&Yeoh { c, terms: 3 }, s)
    }),
};
