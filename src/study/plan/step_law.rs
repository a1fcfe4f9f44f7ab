//! The error of one quantity versus the time step, from runs on one mesh whose steps are φ times those of the scene.
//!
//! ```text
//! s = f*/f(1) − 1,   e(φ) = max |f(φᵢ) − f*|/|f*| over φᵢ ≤ φ,   e(φ) = e(φ₁) (φ/φ₁)ᵖ below the finest φ₁
//! ```
//!
//! | order p of the three finest | f\* | U(f\*) |
//! |---|---|---|
//! | from ¾ to 1.05 times that of the integrator | Richardson with p | that of the estimate |
//! | any other from ½ on, equal in two triples | the estimate of the four finest | that of the estimate, at least 3 \|f₁ − f₂\| |
//! | from ½ to ¾ times that of the integrator | Richardson of the two finest with the order of the integrator | that of two, at least 3 \|f₁ − f₂\| |
//! | any other, or none | f₁ | 3 ΔM of the three finest |
//!
//! The estimates are those of [`family`](crate::study::estimate::family). In the last two rows the observed order is not used for extrapolation: coarse
//! steps that do not yet resolve the motion may show any order. Limits: one mesh, and peaks at the recorded times of the run.

use crate::study::estimate::family::{Estimate, Level, estimate_of_order};
use crate::study::estimate::richardson::{CAUTIOUS_FACTOR, Convergence, LEAST_ORDER, ORDER_SLACK};
use crate::study::plan::mesh_limits::largest_of_sequence;
use crate::study::store::record::Role;
use serde::Serialize;

/// Share of the order of the integrator below which an observed order is attributed to steps that are too coarse.
const PLAUSIBLE: f64 = 0.75;

/// Error of one quantity versus φ on one mesh.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct StepLaw {
    /// s: relative change of the peak from the steps of the scene to infinitely small ones \[–\]
    pub shift: f64,
    /// U(f*)/|f*| \[–\]
    pub uncertainty: f64,
    /// Order p of the three finest steps
    pub observed_order: Option<f64>,
    /// Order expected for smaller steps
    pub order: f64,
    /// Whether the observed order is used: it matches the integrator, or two triples agree on it
    pub trusted: bool,
    /// Peak with the steps of the scene
    #[serde(skip)]
    peak: f64,
    /// (φ, e), the smallest φ first
    #[serde(skip)]
    errors: Vec<(f64, f64)>,
}

impl StepLaw {
    /// Builds the law from (φ, peak) of runs in any order, and the order of the integrator. `None` with fewer than two runs, without one at φ = 1, or
    /// if the peak has no limit with the same sign.
    pub fn new(values: &[(f64, f64)], formal: f64, tolerance: f64) -> Option<Self> {
        let mut values = values.to_vec();
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        let peak = values.iter().find(|v| v.0 == 1.0)?.1;
        let of = |most: usize| {
            let level = |(h, f): &(f64, f64)| Level { h: *h, f: *f, ..Level::default() };
            let levels = values.iter().take(most).map(level).collect();
            estimate_of_order(("steps", Role::TimeStep, ""), formal, levels, None, tolerance)
        };
        let all = of(4)?;
        let observed_order = all.observed_order;
        let difference = (all.values[0] - all.values[1]).abs();
        let plausible = observed_order.is_some_and(|p| (PLAUSIBLE * formal..=ORDER_SLACK * formal).contains(&p));
        let agreed = all.asymptotic == Some(true);
        let low = values.len() == 2 || observed_order.is_some_and(|p| (LEAST_ORDER..PLAUSIBLE * formal).contains(&p));
        let exact = all.class == Convergence::Exact;
        let (estimate, least) = match () {
            () if exact => (all, 0.0),
            () if plausible => (of(3)?, 0.0),
            () if agreed => (all, CAUTIOUS_FACTOR * difference),
            () if low => (of(2)?, CAUTIOUS_FACTOR * difference),
            () => (of(3)?, 0.0),
        };
        let trusted = exact || plausible || agreed;
        let order = observed_order.filter(|_| trusted && !exact).unwrap_or(formal);
        let star = estimate.extrapolated;
        if !(star / peak > 0.0 && star.is_finite() && peak.is_finite()) {
            return None;
        }
        let uncertainty = estimate.uncertainty.max(least).max(largest_of_sequence(&estimate));
        // If f* is f₁ for lack of an order, f₁ has an error nevertheless
        let finest = if trusted { 0.0 } else { spread(&estimate) / (2f64.powf(formal) - 1.0) };
        let mut largest: f64 = finest;
        let mut errors = Vec::new();
        for (factor, f) in &values {
            largest = largest.max((f - star).abs());
            errors.push((*factor, largest / star.abs()));
        }
        let shift = star / peak - 1.0;
        Some(Self { shift, uncertainty: uncertainty / star.abs(), observed_order, order, trusted, peak, errors })
    }

    /// Relative error e(φ) \[–\].
    pub fn error(&self, factor: f64) -> f64 {
        let known = self.errors.iter().rev().find(|(at, _)| *at <= factor).unwrap_or(&self.errors[0]);
        known.1 * (factor / known.0).powf(self.order)
    }

    /// Relative change of f* if the change is carried over to the limit over h, found with the steps of the scene, in the unit of f instead of as a
    /// ratio \[–\].
    pub fn transfer(&self, limit: f64) -> f64 {
        (self.shift / (1.0 + self.shift)).abs() * (1.0 - self.peak / limit).abs()
    }

    /// Whether smaller steps would show nothing relevant: the order is known, or U(f*) is within this share.
    pub fn is_settled(&self, share: f64) -> bool {
        self.trusted || self.uncertainty <= share
    }
}

/// Difference between the largest and the smallest value.
fn spread(e: &Estimate) -> f64 {
    let (lo, hi) = e.values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    hi - lo
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Deflection \[mm\] of a block under its weight, `tet4`, BDF2 with steps of 20, 10, 5, … ms. With 0.625 ms it is 4.2656, and its limit is 4.267.
    const BLOCK: [(f64, f64); 5] = [(2.0, 3.5184), (1.0, 3.9078), (0.5, 4.1527), (0.25, 4.2382), (0.125, 4.2607)];
    const TRUE: f64 = 4.267;

    fn law(values: &[(f64, f64)], formal: f64) -> StepLaw {
        StepLaw::new(values, formal, 0.01).expect("a limit")
    }

    #[test]
    fn steps_that_are_too_coarse_show_no_order() {
        let law = law(&BLOCK[..3], 2.0);
        assert!(!law.trusted && law.order == 2.0, "{law:?}");
        assert!(law.observed_order.is_some_and(|p| p > 0.5 && p < 1.0), "{law:?}");
        let star = BLOCK[1].1 * (1.0 + law.shift);
        // With order 2 from the last two
        assert!((star - (4.1527 + 0.2449 / 3.0)).abs() < 1e-10, "{star}");
        assert!((law.uncertainty * star - 4.0 * 0.2449).abs() < 1e-10, "{law:?}");
        assert!((star - TRUE).abs() < law.uncertainty * star);
        // An order of 0.67 would require 64 times as many steps
        assert!(law.error(0.125) < 0.0025, "{}", law.error(0.125));
        assert!(!law.is_settled(0.0025), "a smaller step is to show more");
    }

    #[test]
    fn smaller_steps_show_the_order_and_a_limit_that_holds() {
        let law = law(&BLOCK, 2.0);
        assert!(law.trusted && law.is_settled(0.0), "{law:?}");
        assert!((law.order - 1.92).abs() < 0.02, "{law:?}");
        let star = BLOCK[1].1 * (1.0 + law.shift);
        assert!((star - TRUE).abs() < law.uncertainty * star && law.uncertainty < 0.004, "{star}: {law:?}");
        // Errors of steps that were run are those found; below, they decrease with the order
        assert!((law.error(0.5) - (star - 4.1527) / star).abs() < 1e-12);
        assert!((law.error(0.0625) / law.error(0.125) - 0.5f64.powf(law.order)).abs() < 1e-12);
    }

    #[test]
    fn an_exact_second_order_gives_its_limit_back() {
        let f = |factor: f64| 2.0 - 0.1 * factor * factor;
        let law = law(&[0.5, 1.0, 2.0].map(|x| (x, f(x))), 2.0);
        assert!((law.shift - (2.0 / 1.9 - 1.0)).abs() < 1e-12 && law.trusted, "{law:?}");
        assert!((law.error(0.25) - 0.05 * 0.0625).abs() < 1e-12);
        // At least the distance from the finest to the limit
        assert!(law.uncertainty * 2.0 >= 0.025 - 1e-12);
    }

    #[test]
    fn an_order_that_two_triples_agree_on_is_used_with_a_cautious_bar() {
        let f = |factor: f64| 1.0 - 0.1 * factor;
        let law = law(&[0.25, 0.5, 1.0, 2.0].map(|x| (x, f(x))), 2.0);
        assert!(law.trusted && (law.order - 1.0).abs() < 1e-6, "{law:?}");
        assert!(law.uncertainty >= 3.0 * 0.025 - 1e-9, "{law:?}");
        assert!((law.error(0.125) - 0.0125).abs() < 1e-7, "{law:?}");
    }

    /// With contributions of opposite sign the two finest values agree by chance.
    #[test]
    fn values_that_agree_by_chance_do_not_make_the_limit_known() {
        for last in [1.1001, 1.0999] {
            let law = law(&[(2.0, 1.0), (1.0, 1.1), (0.5, last)], 2.0);
            assert!(!law.trusted && law.uncertainty > 0.25, "{law:?}");
            assert!(law.error(0.5) > 0.02 && law.error(1.0) >= law.error(0.5), "{law:?}");
        }
        let pair = law(&[(1.0, 1.1), (2.0, 1.0)], 2.0);
        assert!(!pair.trusted && (pair.uncertainty * 1.1 * (1.0 + pair.shift) - 0.4).abs() < 1e-12, "{pair:?}");
    }

    #[test]
    fn what_does_not_depend_on_the_step_has_no_error() {
        let law = law(&[(2.0, 1.0), (1.0, 1.0), (0.5, 1.0)], 2.0);
        assert_eq!((law.shift, law.uncertainty, law.error(1.0), law.trusted), (0.0, 0.0, 0.0, true));
        assert!(StepLaw::new(&[(2.0, 1.0), (1.0, -1.0), (0.5, 2.0)], 2.0, 0.01).is_none_or(|l| l.uncertainty > 1.0));
        assert!(StepLaw::new(&[(1.0, 1.0)], 2.0, 0.01).is_none(), "one run shows no law");
    }
}
