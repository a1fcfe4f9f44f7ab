//! Arruda–Boyce, five terms of the series: ψ = μ Σ c_n λ_m^{2−2n} (I₁ⁿ − 3ⁿ), n = 1 … 5.
//!
//! P = 2ψ₁ g, ψ₁ = μ Σ n c_n (I₁/λ_m²)^{n−1}, g = λ − λ⁻² uniaxial, λ − λ⁻⁵ equibiaxial, λ − λ⁻³ planar.
//!
//! λ_m = 1 + eˣ.
//!
//! Source: Arruda & Boyce, J. Mech. Phys. Solids 41 (1993). Limits: the series is softer than the inverse Langevin function of the
//! paper near λ_m, so that its λ_m fits smaller than published ones; no softening at moderate stretch; λ_m is unidentifiable
//! where the data show no upturn.

use super::{Family, Fittable, Form};
use crate::calibrate::term::{invariants, of_invariants, tau};
use crate::material::arruda_boyce::{ArrudaBoyce, KEYS, SERIES};

pub const ARRUDA_BOYCE: Fittable = Fittable {
    name: "arruda_boyce",
    formula: "P = 2μ g Σ n c_n (I₁/λ_m²)^{n−1}, n = 1 … 5, c = 1/2, 1/20, 11/1050, 19/7000, 519/673750, g = λ − λ⁻² uniaxial, λ − λ⁻⁵ equibiaxial, λ − λ⁻³ planar",
    source: "Arruda & Boyce, J. Mech. Phys. Solids 41 (1993)",
    parameters: KEYS.split_at(2).1,
    terms: &[1],
    usual: 1,
    form: Form::Separable(Family {
        tau: |limit, s| of_invariants(&ArrudaBoyce { mu: 1.0, limit }, s).tau,
        tau_by_shape: |limit, s| {
            let ratio = (3.0 + invariants(s).0) / (limit * limit);
            let powers =
                (0..).zip(SERIES).map(|(n, c)| f64::from(n + 1) * c * f64::from(-2 * n) * ratio.powi(n) / limit);
            tau(powers.sum(), 0.0, s)
        },
        shape: |x, _| (1.0 + x.exp(), x.exp()),
        grid: &[-7.0, -6.0, -5.0, -4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0],
        factor: |_| (1.0, 0.0),
    }),
};
