//! Calibration and predictions repeated with simulated experiments and the full nonlinear response.
//!
//! Each draw takes the errors of all sources and data at random, measures the calibration records with them, finds the constants again, and predicts.
//! The errors of the predictions need no linearisation. Source: JCGM 101:2008 (GUM Supplement 1).

use crate::math::random::SplitMix;
use crate::study::kinds::validation::joint::{Problem, Response, Solution};

/// Number of draws: the standard deviation is known to within 1/√(2·1000) = 2.2 %.
const DRAWS: usize = 1000;
/// Largest fraction of draws whose calibration may fail.
const FAILING: f64 = 0.05;

/// Number of draws for a quantile: the 95 % quantile is exceeded in 5 % ± √(0.05·0.95/2000) = 0.5 %.
const DRAWS_OF_QUANTILE: usize = 2000;

/// Errors of one prediction over all draws.
#[derive(Clone, Debug, PartialEq)]
pub struct Draws {
    pub deviation: f64,
    /// 2.5 % and 97.5 % quantiles of predicted minus true value
    pub ends: [f64; 2],
}

/// Returns the draws of each target; `None` if too many calibrations fail.
pub fn draws(problem: &Problem, truth: &Solution, targets: &[&Response], seed: u64) -> Option<Vec<Draws>> {
    let mut random = SplitMix(seed);
    let mut errors: Vec<Vec<f64>> = vec![vec![]; targets.len()];
    let measured = |r: &Response, s: &[f64], random: &mut SplitMix| {
        r.value(&truth.xi, s) + r.noise.iter().map(|sigma| sigma * random.normal()).sum::<f64>()
    };
    for _ in 0..DRAWS {
        let s: Vec<f64> = truth.s.iter().map(|s| s + random.normal()).collect();
        let data: Vec<f64> = problem.data.iter().map(|r| measured(r, &s, &mut random)).collect();
        let own: Vec<f64> = targets.iter().map(|t| measured(t, &s, &mut random)).collect();
        let Ok(found) = problem.solve_around(&data, &truth.s) else { continue };
        for ((errors, target), own) in errors.iter_mut().zip(targets).zip(own) {
            errors.push(target.value(&found.xi, &found.s) - own);
        }
    }
    let enough = |e: &Vec<f64>| e.len() as f64 >= (1.0 - FAILING) * DRAWS as f64;
    errors.iter().all(enough).then(|| errors.into_iter().map(summary).collect())
}

fn summary(mut errors: Vec<f64>) -> Draws {
    errors.sort_by(f64::total_cmp);
    let n = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / n;
    let deviation = (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    Draws { deviation, ends: [0.025, 0.975].map(|p| quantile(&errors, p)) }
}

/// The quantile of sorted values.
fn quantile(sorted: &[f64], p: f64) -> f64 {
    let at = p * (sorted.len() as f64 - 1.0);
    let (k, share) = (at as usize, at.fract());
    sorted[k] + share * (sorted[(k + 1).min(sorted.len() - 1)] - sorted[k])
}

/// Returns quantiles of a random number.
pub fn quantiles<const N: usize>(of: [f64; N], mut draw: impl FnMut() -> f64) -> [f64; N] {
    let mut all: Vec<f64> = (0..DRAWS_OF_QUANTILE).map(|_| draw()).collect();
    all.sort_by(f64::total_cmp);
    of.map(|p| quantile(&all, p))
}

/// Draws a value of χ² with the given degrees of freedom.
pub fn chi_square(freedom: usize, random: &mut SplitMix) -> f64 {
    (0..freedom).map(|_| random.normal().powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers 0 to 1999, each drawn once in a scrambled order: every quantile is the corresponding fraction of the range, also between two
    /// numbers.
    #[test]
    fn quantiles_are_shares_of_all_draws() {
        let mut next = 0;
        let found = quantiles([0.0, 0.01, 0.5, 0.95, 1.0], || {
            next = (next + 777) % DRAWS_OF_QUANTILE;
            next as f64
        });
        for (found, expected) in found.into_iter().zip([0.0, 19.99, 999.5, 1899.05, 1999.0]) {
            assert!((found - expected).abs() < 1e-9, "{found}, not {expected}");
        }
    }
}
