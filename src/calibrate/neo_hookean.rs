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

use super::{Estimate, FitError, Fittable, LawFit, Mode, Sample, optimise, statistics};
use crate::material::Parameter;
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
    stress: |parameters, mode, stretch| parameters[0] * shape(mode, stretch),
    fit,
};

/// P/μ [–]
fn shape(mode: Mode, stretch: f64) -> f64 {
    let exponent = match mode {
        Mode::Uniaxial => -2,
        Mode::Equibiaxial => -5,
        Mode::Planar => -3,
    };
    stretch - stretch.powi(exponent)
}

/// Below this misfit ‖r‖/‖P‖ the residuals are rounding and their pattern means nothing [–]
pub const ROUNDING: f64 = 1e-9;

/// Least squares in nominal stress, every row with the same weight; μ ≥ 0.
///
/// Interval: μ ± t₀.₉₇₅(n − 1)·s/‖g‖ with s² = Σr²/(n − 1), gᵢ = P/μ at λᵢ. It assumes exact stretches and independent
/// normal errors of stress with one standard deviation for all rows.
fn fit(samples: &[Sample]) -> Result<LawFit, FitError> {
    let g: Vec<f64> = samples.iter().map(|s| shape(s.mode, s.stretch)).collect();
    let p: Vec<f64> = samples.iter().map(|s| s.stress).collect();
    let check = optimise::stiffness(&g, &p)?;
    let mu = check.clarabel;
    let r: Vec<f64> = g.iter().zip(&p).map(|(g, p)| p - mu * g).collect();
    let free = samples.len() - 1;
    let g2 = dot(&g, &g);
    let std_error = (dot(&r, &r) / free as f64 / g2).sqrt();
    let half = statistics::t_quantile(0.95, free) * std_error;
    let estimate =
        Estimate { name: "mu", symbol: "μ", unit: "Pa", value: mu, std_error, interval: [mu - half, mu + half] };
    Ok(LawFit { estimates: vec![estimate], check, departure_p: departure(samples, &g, &p, &r) })
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// p-value of β = 0 in P = μ g + β g/λ (in uniaxial tension β is Mooney's second constant, 2C₂): a t-test with n − 2
/// degrees of freedom on the part of g/λ that is orthogonal to g.
fn departure(samples: &[Sample], g: &[f64], p: &[f64], r: &[f64]) -> Option<f64> {
    let free = samples.len().checked_sub(2).filter(|n| *n >= 1)?;
    let (r2, p2) = (dot(r, r), dot(p, p));
    if r2 <= ROUNDING * ROUNDING * p2 {
        return None;
    }
    let second: Vec<f64> = g.iter().zip(samples).map(|(g, s)| g / s.stretch).collect();
    let along = dot(&second, g) / dot(g, g);
    let across: Vec<f64> = second.iter().zip(g).map(|(h, g)| h - along * g).collect();
    let across2 = dot(&across, &across);
    if across2 <= 1e-20 * dot(&second, &second) {
        return None;
    }
    let explained = dot(&across, r).powi(2) / across2;
    let left = (r2 - explained).max(f64::EPSILON * r2);
    let t = (explained / (left / free as f64)).sqrt();
    Some(1.0 - statistics::t_probability(t, free))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against finite differences of ψ(λ) = ½μ(I₁ − 3): P = ∂ψ/∂λ, halved for equibiaxial where two directions work.
    #[test]
    fn stress_is_the_slope_of_the_energy() {
        let energy = |mode, l: f64| {
            let i1 = match mode {
                Mode::Uniaxial => l * l + 2.0 / l,
                Mode::Equibiaxial => 2.0 * l * l + l.powi(-4),
                Mode::Planar => l * l + 1.0 + l.powi(-2),
            };
            0.5 * (i1 - 3.0)
        };
        for mode in Mode::ALL {
            let directions = if mode == Mode::Equibiaxial { 2.0 } else { 1.0 };
            for stretch in [0.7, 1.0, 1.3, 3.0] {
                let d = 1e-5;
                let slope = (energy(mode, stretch + d) - energy(mode, stretch - d)) / (2.0 * d) / directions;
                // Truncation d²/6·ψ''' and rounding ε·ψ/d are both below 1e-8 here
                assert!((shape(mode, stretch) - slope).abs() < 1e-8, "{mode} at {stretch}");
            }
        }
    }
}
