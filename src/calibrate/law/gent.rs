//! Gent: ψ = −½μJ_m ln(1 − i/J_m), i = I₁ − 3.
//!
//! P = μ g/(1 − i/J_m), g = λ − λ⁻² uniaxial, λ − λ⁻⁵ equibiaxial, λ − λ⁻³ planar.
//!
//! J_m = i*(1 + eˣ) with the largest i* of the whole table, whatever is fitted: stretches that were reached are possible.
//!
//! Source: Gent, Rubber Chem. Technol. 69 (1996). Limits: no softening at moderate stretch; J_m is unidentifiable where the data
//! show no upturn.

use super::{Family, Fittable, Form};
use crate::calibrate::term::{invariants, of_invariants, tau};
use crate::material::gent::{Gent, KEYS};

pub const GENT: Fittable = Fittable {
    name: "gent",
    formula: "P = μ g/(1 − i/J_m), i = I₁ − 3, g = λ − λ⁻² uniaxial, λ − λ⁻⁵ equibiaxial, λ − λ⁻³ planar",
    source: "Gent, Rubber Chem. Technol. 69 (1996)",
    parameters: KEYS.split_at(2).1,
    terms: &[1],
    usual: 1,
    form: Form::Separable(Family {
        tau: |limit, s| of_invariants(&Gent { mu: 1.0, limit }, s).tau,
        tau_by_shape: |limit, s| {
            let i = invariants(s).0;
            // w₁ = ½J_m/(J_m − i)
            tau(-0.5 * i / (limit - i).powi(2), 0.0, s)
        },
        shape: |x, reach| (reach * (1.0 + x.exp()), reach * x.exp()),
        grid: &[-7.0, -6.0, -5.0, -4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0],
        factor: |_| (1.0, 0.0),
    }),
};
