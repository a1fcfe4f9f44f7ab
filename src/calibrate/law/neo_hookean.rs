//! Neo-Hookean, incompressible: ψ = ½μ(I₁ − 3), nominal stress P = ∂ψ/∂λ with the free faces free of stress.
//!
//! | mode | P | slope at λ = 1 |
//! |---|---|---|
//! | uniaxial | μ(λ − λ⁻²) | 3μ |
//! | equibiaxial | μ(λ − λ⁻⁵) | 6μ |
//! | planar | μ(λ − λ⁻³) | 4μ |
//!
//! Source: L. R. G. Treloar, The Physics of Rubber Elasticity, 3rd ed. (1975), chapter 4 (network theory). Limits: no
//! upturn at large stretch and no softening at moderate stretch (the Mooney plot P/(λ − λ⁻²) against 1/λ is a
//! horizontal line), so the fitted μ depends on the range.

use super::{Fittable, Form};
use crate::calibrate::term::of_invariants;
use crate::material::Parameter;
use crate::material::yeoh::Yeoh;
use crate::math::units::Dimension;

pub const NEO_HOOKEAN: Fittable = Fittable {
    name: "neo_hookean",
    formula: "P = μ(λ − λ⁻²) uniaxial, μ(λ − λ⁻⁵) equibiaxial, μ(λ − λ⁻³) planar",
    source: "Treloar, The Physics of Rubber Elasticity, 3rd ed. (1975), chapter 4",
    parameters: &[Parameter {
        name: "mu",
        symbol: "μ",
        dimension: Dimension::PRESSURE,
        bounds: (0.0, f64::INFINITY),
        meaning: "shear modulus at small strain",
    }],
    terms: &[1],
    usual: 1,
    // C10 = ½μ of Yeoh's first term
    form: Form::Linear(|_, s| of_invariants(&Yeoh { c: [0.5, 0.0, 0.0], terms: 1 }, s)),
};
