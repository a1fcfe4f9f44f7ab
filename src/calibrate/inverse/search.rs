//! Least squares over forward solves, within bounds: a trust region on the Gauss–Newton matrix.
//!
//! f = ½‖w(ŷ(θ) − y)‖²/‖wy‖². The coordinates are those of [`super::determined`], u = u₀ + Bw: a step of length 1 in w changes the curve by its own
//! size, so that the region is a sphere of curves, and constants that compensate each other do not form a narrow valley; directions that are not
//! searched are not part of B and stay unchanged. Within the region of radius Δ the step is the Levenberg–Marquardt step with the λ at which it
//! reaches the boundary (Moré 1978), from one SVD, or at which no u changes by more than 1, so that a single step cannot send a time to where the
//! curve no longer depends on it. A constant at a bound that the step would cross is held there, and is released when the next step leads inside
//! (projected Newton: Bertsekas, SIAM J. Control Optim. 20, 1982); a step that reaches a bound ends on it. If a forward solve fails, or the scene
//! cannot have the constants or has no derivative at them, the step is rejected and the region shrinks. The search ends when a full Gauss–Newton step
//! would lower f by less than a share of 1e-6, a change of the constants by 1e-3 √n of their standard deviation, or by less than rounding. If a
//! specimen begins to carry load exactly at a data point, the curve has a kink in the slack: a search that has no step left there has settled.
//!
//! Source: Nocedal & Wright, *Numerical Optimization*, 2nd ed. 2006, ch. 4 and 10.

use super::bound::Bound;
use super::determined::Coordinates;
use super::model::Failure;
use super::objective::{Objective, Point};
use crate::calibrate::solve::rows::padded;
use crate::math::svd::svd;
use nalgebra::DVector;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Predicted decrease of f that counts as zero: relative to f, and absolute (rounding of the forward solves)
const STILL: f64 = 1e-6;
const ROUNDING: f64 = 1e-16;
/// Radius of the trust region: at the start, the largest, and the smallest before the search gives up; relative change of the curve
const RADIUS: f64 = 0.5;
const LARGEST: f64 = 2.0;
const NOTHING: f64 = 1e-9;
/// Largest change of a coordinate in one step: of ln θ, or as a share of the range over which a constant can change \[–\]
const LONGEST: f64 = 1.0;
/// Largest number of steps that are tried
const STEPS: usize = 40;
/// Ratio of the actual to the predicted decrease below which the region shrinks, and above which it grows
const POOR: f64 = 0.25;
const GOOD: f64 = 0.75;
/// Ratio to the largest singular value below which the curve does not depend on a direction \[–\]
const BLIND: f64 = 1e-12;

/// The end of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// The next step was too small to count, or the misfit has a kink there
    Settled,
    /// No remaining step lowers the misfit
    Stuck,
    /// The time budget was used up
    OutOfTime,
}

/// Result of a search.
pub struct SearchResult {
    pub point: Point,
    /// Bound of each unknown
    pub bound: Vec<Bound>,
    pub end: End,
}

/// A step within the trust region.
struct Step {
    /// Change of u
    change: DVector<f64>,
    /// Norm in terms of w
    length: f64,
    /// Decrease of f that the linearised problem predicts for this step, and for the full step
    predicted: f64,
    full: f64,
    bound: Vec<Bound>,
}

/// Searches from a point. `until`: after the first step, no forward solve is started that would end later, judging by the longest one so far.
pub fn search(
    objective: &mut Objective,
    coordinates: &Coordinates,
    start: Point,
    until: Option<Instant>,
) -> Result<SearchResult, Failure> {
    let size = objective.size();
    let misfit = |p: &Point| 0.5 * (p.residual.norm() / size).powi(2);
    let (mut point, mut radius, mut longest) = (start, RADIUS, 0.0_f64);
    let mut u = coordinates.of(&point.values);
    for tried in 0..STEPS {
        let f = misfit(&point);
        let step = step(coordinates, &u, &point, size, radius);
        let bound = step.bound.clone();
        if step.full <= STILL * f || step.full <= ROUNDING {
            return Ok(SearchResult { point, bound, end: End::Settled });
        }
        if radius < NOTHING || step.length == 0.0 {
            let end = at_the_last(objective, &point);
            return Ok(SearchResult { point, bound, end });
        }
        let begin = Instant::now();
        // At least one step, so that a continued search makes progress
        if tried > 0 && until.is_some_and(|until| begin + std::time::Duration::from_secs_f64(longest) > until) {
            return Ok(SearchResult { point, bound, end: End::OutOfTime });
        }
        let next_u = coordinates.within(&(&u + &step.change));
        match objective.at(&coordinates.values(&next_u)) {
            Ok(next) => {
                let ratio = (f - misfit(&next)) / step.predicted;
                if ratio < POOR {
                    radius = POOR * step.length;
                } else if ratio > GOOD && step.length > 0.9 * radius {
                    radius = (2.0 * radius).min(LARGEST);
                }
                if ratio > 0.0 {
                    (point, u) = (next, next_u);
                    objective.tell(&point);
                }
            }
            Err(failure @ (Failure::Input(_) | Failure::Interrupted)) => return Err(failure),
            Err(Failure::Constants(_) | Failure::Run(_)) => radius = POOR * step.length,
        }
        longest = longest.max(begin.elapsed().as_secs_f64());
    }
    let (bound, end) = (vec![Bound::Free; u.len()], at_the_last(objective, &point));
    Ok(SearchResult { point, bound, end })
}

/// The end of a search that has no step left: at a kink the misfit can have its minimum although the gradient does not vanish there.
fn at_the_last(objective: &Objective, point: &Point) -> End {
    if objective.is_at_kink(point) { End::Settled } else { End::Stuck }
}

/// The best step from u, constrained to the bounds that it would cross.
fn step(coordinates: &Coordinates, u: &DVector<f64>, point: &Point, size: f64, radius: f64) -> Step {
    let p = u.len();
    let jacobian = &point.jacobian * coordinates.rates(u) / size;
    let residual = &point.residual / size;
    let mut bound = vec![Bound::Free; p];
    loop {
        let free = coordinates.free(&bound);
        let none = || Step { change: DVector::zeros(p), length: 0.0, predicted: 0.0, full: 0.0, bound: bound.clone() };
        if free.ncols() == 0 {
            return none();
        }
        let seen = padded(&(&jacobian * &free), free.ncols());
        let (rows, svd) = (seen.nrows(), svd(seen, true, true));
        let (left, right, sigma) = (svd.u.expect("asked for"), svd.v_t.expect("asked for"), svd.singular_values);
        let pull = left.transpose() * residual.clone().resize_vertically(rows, 0.0);
        let blind = BLIND * sigma.max();
        let part = |lambda: f64| {
            let one = |k: usize| {
                if sigma[k] > blind && sigma[k] > 0.0 {
                    sigma[k] * pull[k] / (sigma[k] * sigma[k] + lambda)
                } else {
                    0.0
                }
            };
            DVector::from_fn(sigma.len(), |k, _| one(k))
        };
        let full: f64 = (0..sigma.len()).filter(|k| sigma[*k] > blind).map(|k| 0.5 * pull[k] * pull[k]).sum();
        let back = &free * right.transpose();
        let fits = |w: &DVector<f64>| w.norm() <= radius && (&back * w).amax() <= LONGEST;
        let w = shortened(&part, &fits, sigma.max());
        let mut change = back * &w;
        // Rounding of the product must not move held constants: they would count as leaving their bounds again
        (0..p).filter(|k| !bound[*k].is_free()).for_each(|k| change[k] = 0.0);
        // The part of the step before a bound is reached, and constants at a bound that the step would cross
        let outward: Vec<usize> = (0..p).filter(|k| coordinates.crosses(u, &change, *k) == Some(0.0)).collect();
        if outward.is_empty() {
            let share = (0..p).filter_map(|k| coordinates.crosses(u, &change, k)).fold(1.0, f64::min);
            let lowered = |k: usize| {
                let s = share * sigma[k] * w[k];
                s * pull[k] - 0.5 * s * s
            };
            let predicted = (0..sigma.len()).map(lowered).sum();
            return Step { change: change * share, length: share * w.norm(), predicted, full, bound };
        }
        outward.iter().for_each(|k| bound[*k] = if change[*k] > 0.0 { Bound::Upper } else { Bound::Lower });
    }
}

/// The step with the smallest λ that `fits`, by bisection to 1 % of λ.
fn shortened(part: &dyn Fn(f64) -> DVector<f64>, fits: &dyn Fn(&DVector<f64>) -> bool, largest: f64) -> DVector<f64> {
    let whole = part(0.0);
    if fits(&whole) {
        return whole;
    }
    let (mut low, mut high) = (0.0_f64, largest * largest);
    while high.is_finite() && !fits(&part(high)) {
        (low, high) = (high, 4.0 * high);
    }
    while high > 1.01 * low && high > 1e-12 * largest * largest {
        let middle = if low > 0.0 { (low * high).sqrt() } else { 1e-3 * high };
        match fits(&part(middle)) {
            true => high = middle,
            false => low = middle,
        }
    }
    part(high)
}
