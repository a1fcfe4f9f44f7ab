//! Veronda–Westmann: ψ = C1(e^{βi} − 1) − ½C1βk, i = I₁ − 3, k = I₂ − 3.
//!
//! P = 2(1 − λ⁻³)(λψ₁ + ψ₂) uniaxial, 2(λ − λ⁻⁵)(ψ₁ + λ²ψ₂) equibiaxial, 2(λ − λ⁻³)(ψ₁ + ψ₂) planar, ψ₁ = C1βe^{βi}, ψ₂ = −½C1β.
//!
//! β = eˣ.
//!
//! Source: Veronda & Westmann, J. Biomech. 3 (1970). Limits: made for skin, which stiffens from the start; on rubber, which softens
//! first, β tends to the smallest value and stability is lost early.

use super::{Family, Fittable, Form};
use crate::calibrate::term::{invariants, of_invariants, tau};
use crate::material::veronda_westmann::{KEYS, VerondaWestmann};

pub const VERONDA_WESTMANN: Fittable = Fittable {
    name: "veronda_westmann",
    formula: "P = 2(1 − λ⁻³)(λψ₁ + ψ₂) uniaxial, 2(λ − λ⁻⁵)(ψ₁ + λ²ψ₂) equibiaxial, 2(λ − λ⁻³)(ψ₁ + ψ₂) planar, ψ₁ = C1βe^{βi}, ψ₂ = −½C1β, i = I₁ − 3",
    source: "Veronda & Westmann, J. Biomech. 3 (1970)",
    parameters: KEYS.split_at(2).1,
    terms: &[1],
    usual: 1,
    form: Form::Separable(Family {
        tau: |beta, s| of_invariants(&VerondaWestmann { c1: 1.0, beta }, s).tau,
        tau_by_shape: |beta, s| {
            let y = beta * invariants(s).0;
            tau((1.0 + y) * y.exp(), -0.5, s)
        },
        shape: |x, _| (x.exp(), x.exp()),
        grid: &[-7.0, -6.0, -5.0, -4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0],
        factor: |_| (1.0, 0.0),
    }),
};
