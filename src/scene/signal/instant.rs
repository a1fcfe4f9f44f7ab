//! Requested times compared with points of a time grid, which carry rounding errors.

use crate::math::signal::PLACES;

/// Share of a step by which a grid point may lie before a time and still count as reaching it \[–\].
const SHARE: f64 = 1e-6;

/// Largest rounding of the time `t`, the end of a step of length `step` \[s\].
pub(in crate::scene) fn rounding(t: f64, step: f64) -> f64 {
    (SHARE * step).max(PLACES * f64::EPSILON * t.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_is_less_than_a_step_at_any_time() {
        for (t, step) in [(0.0, 1e-6), (1.0, 1e-3), (86_400.0, 1e-5), (1e7, 1e-4)] {
            assert!(rounding(t, step) <= 1e-3 * step, "{t} {step}");
            let sum = (0..10).fold(t, |t, _| t + step);
            assert!((sum - (t + 10.0 * step)).abs() <= rounding(t, step), "{t} {step}");
        }
    }
}
