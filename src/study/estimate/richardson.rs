//! Observed order, Richardson extrapolation and GCI of three meshes (1 is the finest) with unequal ratios.
//!
//! With h = (V/N)^{1/3}, r₂₁ = h₂/h₁, ε₂₁ = f₂ − f₁, ε₃₂ = f₃ − f₂ and f = f₀ + αh^p,
//!
//! ```text
//! p = |ln|ε₃₂/ε₂₁| + q(p)| / ln r₂₁,   q(p) = ln((r₂₁^p − s)/(r₃₂^p − s)),   s = sign(ε₃₂/ε₂₁)
//! f* = f₁ + (f₁ − f₂)/(r₂₁^p − 1),     GCI₂₁ = Fs·|f₁ − f₂|/(r₂₁^p − 1)
//! ```
//!
//! Source: I. Celik et al., Procedure for estimation and reporting of uncertainty due to discretization in CFD
//! applications, J. Fluids Eng. 130 (2008) 078001; safety factors after P. J. Roache (1.25 with three meshes and a sane
//! order, 3 otherwise).
//!
//! Limits: one power of h only. The classical check GCI₃₂/(r^p GCI₂₁) ≈ 1 says nothing, because p comes from the same triple.

use serde::Serialize;

/// Smallest size ratio recommended by Roache; smaller ones amplify noise in f too much.
pub const LEAST_RATIO: f64 = 1.3;
/// Lowest order that counts as convergence for an error bar.
pub const LEAST_ORDER: f64 = 0.5;
/// Factor by which an observed order may exceed the formal one (Eça & Hoekstra 2014 accept p < 2.1 for 2).
pub const ORDER_SLACK: f64 = 1.05;
/// Differences below this fraction of the value are rounding of the nonlinear solution (residual tolerance 1e-8).
pub const ROUNDING: f64 = 1e-7;

/// Safety factor Fs of the grid convergence index (Roache 1998): 1.25 if three or more meshes show a sane order, otherwise 3.
pub fn safety_factor(is_sane: bool) -> f64 {
    if is_sane { 1.25 } else { CAUTIOUS_FACTOR }
}

/// Safety factor if the order is assumed, and factor of differences if there is no order.
pub const CAUTIOUS_FACTOR: f64 = 3.0;

/// Safety factor of two meshes, applied to their change extrapolated at first order: with it 95 % of the limits of randomly drawn pairs are inside
/// (`tests/estimates/coverage_of_estimates.rs`).
pub const PAIR_FACTOR: f64 = 4.0;

/// Uncertainty of the limit of two meshes with this difference, whose order is unknown.
pub fn bound_of_pair(difference: f64, r: f64) -> f64 {
    PAIR_FACTOR * correction(difference.abs(), r, 1.0)
}

/// Whether a size ratio, rounded to the two decimals with which it is shown, is below the recommended one.
pub fn is_small_ratio(ratio: f64) -> bool {
    (100.0 * ratio).round() / 100.0 < LEAST_RATIO
}

/// How values approach their limit; three values are judged by R = ε₂₁/ε₃₂.
#[derive(Serialize, Clone, Copy, Debug, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Convergence {
    /// 0 < R < ln r₂₁/ln r₃₂: there is an order p > 0
    Monotone,
    /// −1 < R ≤ 0: only ½(max − min) is known
    Oscillatory,
    /// R ≥ ln r₂₁/ln r₃₂, or R ≤ −1
    Diverging,
    /// Two different values: they show neither how they approach their limit nor that there is one
    TwoMeshes,
    /// All differences are rounding: the quantity is prescribed, or does not depend on the mesh
    Exact,
}

impl Convergence {
    pub fn words(self) -> &'static str {
        match self {
            Self::Monotone => "monotone",
            Self::Oscillatory => "oscillatory",
            Self::Diverging => "diverging",
            Self::TwoMeshes => "not shown by two meshes",
            Self::Exact => "independent of the mesh",
        }
    }
}

/// Values of one scalar on three meshes of one family, 1 is the finest.
#[derive(Serialize, Clone, Copy, Debug, PartialEq)]
pub struct Triple {
    pub r21: f64,
    pub r32: f64,
    /// R = ε₂₁/ε₃₂ \[–\]; 0 if both differences vanish
    pub ratio: f64,
    /// ln r₂₁/ln r₃₂, the value of R at p = 0
    pub ratio_limit: f64,
    pub class: Convergence,
    /// Observed order; only for monotone triples
    pub p: Option<f64>,
    /// Difference ε₂₁ and finest value f₁, in the unit of f
    pub e21: f64,
    pub f1: f64,
}

impl Triple {
    /// Builds a triple from the sizes `h` and values `f` of the meshes, finest first.
    pub fn new(h: [f64; 3], f: [f64; 3]) -> Self {
        let (r21, r32) = (h[1] / h[0], h[2] / h[1]);
        let (e21, e32) = (f[1] - f[0], f[2] - f[1]);
        let ratio_limit = r21.ln() / r32.ln();
        let scale = f.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let ratio = if e32 == 0.0 && e21 == 0.0 { 0.0 } else { e21 / e32 };
        let class = if e21.abs().max(e32.abs()) <= ROUNDING * scale {
            Convergence::Exact
        } else if ratio > 0.0 && ratio < ratio_limit {
            Convergence::Monotone
        } else if ratio > -1.0 && ratio <= 0.0 {
            Convergence::Oscillatory
        } else {
            Convergence::Diverging
        };
        let p = (class == Convergence::Monotone).then(|| observed_order(ratio, r21, r32)).flatten();
        Self { r21, r32, ratio, ratio_limit, class, p, e21, f1: f[0] }
    }

    /// Whether the triple is monotone with ½ ≤ p ≤ 1.05·formal order.
    pub fn is_sane(&self, formal: f64) -> bool {
        self.p.is_some_and(|p| (LEAST_ORDER..=ORDER_SLACK * formal).contains(&p))
    }

    /// f* − f₁ = (f₁ − f₂)/(r₂₁^p − 1) \[unit of f\].
    pub fn correction(&self, p: f64) -> f64 {
        correction(-self.e21, self.r21, p)
    }
}

/// (f₁ − f₂)/(r^p − 1) for a difference f₁ − f₂.
pub fn correction(difference: f64, r: f64, p: f64) -> f64 {
    difference / (p * r.ln()).exp_m1()
}

/// The order p > 0 of a monotone triple, with R = ε₂₁/ε₃₂ in (0, ln r₂₁/ln r₃₂).
///
/// Celik's fixed point solves 1/R = r₂₁^p (r₃₂^p − 1)/(r₂₁^p − 1). The right-hand side increases strictly with p from ln r₃₂/ln r₂₁, so that the root
/// is unique; it is bracketed here. The fixed-point iteration has the same root but need not converge to it for very unequal ratios. `None` if the
/// order is above 100.
pub fn observed_order(ratio: f64, r21: f64, r32: f64) -> Option<f64> {
    let (a, b) = (r21.ln(), r32.ln());
    // Logarithm of the right-hand side, with r^p − 1 by exp_m1: no cancellation at small p
    let g = |p: f64| p * a + (p * b).exp_m1().ln() - (p * a).exp_m1().ln() + ratio.ln();
    let (mut lo, mut hi) = (1e-9, 100.0);
    if !(g(lo) < 0.0 && g(hi) > 0.0) {
        return None;
    }
    while hi - lo > 4.0 * f64::EPSILON * hi {
        let mid = 0.5 * (lo + hi);
        if g(mid) < 0.0 { lo = mid } else { hi = mid }
    }
    Some(0.5 * (lo + hi))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ratio that is called small also prints as less than the limit. No ratio here lies midway between two decimals.
    #[test]
    fn a_small_ratio_is_shown_below_the_limit() {
        for ratio in (0..1000).map(|k| 1.25005 + 1e-4 * f64::from(k)) {
            assert_eq!(is_small_ratio(ratio), format!("{ratio:.2}").as_str() < "1.30", "{ratio}");
        }
    }

    /// Celik et al. 2008, table 1, first column: N = 18000, 8000, 4500 (plane, so h ~ N^{-1/2}), reattachment length.
    #[test]
    fn reproduces_the_worked_example_of_celik_2008() {
        let h = [18000.0, 8000.0, 4500.0].map(|n: f64| n.powf(-0.5));
        let t = Triple::new(h, [6.063, 5.972, 5.863]);
        assert_eq!(t.class, Convergence::Monotone);
        let p = t.p.expect("monotone");
        let star = t.f1 + t.correction(p);
        let gci = 1.25 * (star / t.f1 - 1.0).abs() * 100.0;
        // Half a unit of the last printed digit: p = 1.53, f* = 6.1685, GCI = 2.2 %.
        assert!((p - 1.53).abs() < 5e-3, "p = {p}");
        assert!((star - 6.1685).abs() < 6e-4, "f* = {star}");
        assert!((gci - 2.2).abs() < 5e-2, "GCI = {gci} %");
    }

    #[test]
    fn the_root_is_celiks_fixed_point() {
        let h = [1.0, 1.27, 1.27 * 1.6];
        let t = Triple::new(h, h.map(|h: f64| 3.0 - 0.4 * h.powf(1.7)));
        let p = t.p.expect("monotone");
        let q = ((t.r21.powf(p) - 1.0) / (t.r32.powf(p) - 1.0)).ln();
        let next = ((1.0 / t.ratio).ln() + q).abs() / t.r21.ln();
        assert!((next - p).abs() < 1e-11, "one more iteration moves p from {p} to {next}");
    }
}
