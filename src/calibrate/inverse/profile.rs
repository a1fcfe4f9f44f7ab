//! Intervals by profile likelihood: how far one constant can be changed while a search readjusts all others.
//!
//! √(S(θⱼ) − Ŝ) ≤ t dⱼ/d⁰ⱼ with dⱼ the standard error of the constant by the error model and d⁰ⱼ the standard error for independent errors of size 1.
//! For independent errors this is S ≤ Ŝ(1 + t²/(n − p)), as in direct fits ([`crate::calibrate`]'s profile). The root is almost linear in θⱼ:
//! starting from the end of the covariance interval, with the others at their values in the linearised problem, the secant method needs one or two
//! points. Each costs one or two forward solves. The interval ends at a bound of the constant; another constant that reaches its bound is held there.

use super::Unknown;
use super::determined::{Coordinates, Searched};
use super::model::Failure;
use super::objective::{Objective, Point};
use super::search::search;
use crate::calibrate::judgement::errors::Errors;
use crate::math::statistics;
use crate::math::svd::svd;
use nalgebra::{DMatrix, DVector};

/// Relative deviation from the limit at which an end counts as found \[–\]
const CLOSE: f64 = 0.02;
const POINTS: usize = 5;

/// Lower and upper end \[SI\]; `None` if a forward solve fails or no end is found.
pub(super) type Ends = [Option<f64>; 2];

/// Both ends of each constant for which `wanted` holds.
pub fn ends(
    objective: &mut Objective,
    unknown: &[Unknown],
    best: &Point,
    errors: &Errors,
    wanted: &dyn Fn(usize) -> bool,
) -> Result<Vec<Ends>, Failure> {
    let mut all = vec![[None; 2]; unknown.len()];
    if errors.free == 0 {
        return Ok(all);
    }
    let t = statistics::t_quantile(0.95, errors.free);
    let least = best.residual.norm_squared();
    for (j, ends) in all.iter_mut().enumerate().filter(|(j, _)| wanted(*j)) {
        let limit = t * errors.deviations[j] / errors.plain[j];
        for (end, side) in ends.iter_mut().zip([-1.0, 1.0]) {
            let mut offset = side * t * errors.deviations[j];
            // Offset and root of the previous point; both are zero at the answer
            let mut before = (0.0, 0.0);
            for _ in 0..POINTS {
                let found = match squares(objective, unknown, best, (j, offset)) {
                    Ok(square) => statistics::root(square - least) / limit,
                    Err(failure @ (Failure::Input(_) | Failure::Interrupted)) => return Err(failure),
                    Err(_) => break,
                };
                if (found - 1.0).abs() <= CLOSE {
                    *end = Some(best.values[j] + offset);
                    break;
                }
                let secant = offset + (1.0 - found) * (offset - before.0) / (found - before.1);
                before = (offset, found);
                // If the root is bent by a bound of another constant, the secant may leave this side
                let factor = if secant.is_finite() { secant / offset } else { 1.0 / found };
                offset *= factor.clamp(0.2, 3.0);
            }
        }
    }
    Ok(all)
}

/// S with constant j changed by `offset` from the answer and all others readjusted.
fn squares(
    objective: &mut Objective,
    unknown: &[Unknown],
    best: &Point,
    (j, offset): (usize, f64),
) -> Result<f64, Failure> {
    let p = best.values.len();
    let others: Vec<usize> = (0..p).filter(|k| *k != j).collect();
    let mut values = best.values.clone();
    values[j] += offset;
    // Start of the others in the linearised problem: min ‖J_o δ + J_j offset‖
    let length = |k: usize| best.jacobian.column(k).norm().max(f64::MIN_POSITIVE);
    let own =
        DMatrix::from_fn(best.jacobian.nrows(), others.len(), |i, k| best.jacobian[(i, others[k])] / length(others[k]));
    if !others.is_empty() {
        let svd = svd(own, true, true);
        let pull = best.jacobian.column(j) * -offset;
        let step = svd.solve(&pull, 1e-12 * svd.singular_values.max()).unwrap_or_else(|_| DVector::zeros(others.len()));
        others.iter().enumerate().for_each(|(k, o)| values[*o] += step[k] / length(*o));
    }
    for (k, q) in unknown.iter().enumerate() {
        let [low, high] = q.bounds;
        if k == j && !(low..=high).contains(&values[k]) {
            return Err(Failure::Constants("beyond its bounds".into()));
        }
        // Another constant is held where it reaches its bound, and the search may release it
        values[k] = values[k].clamp(low, high);
    }
    let start = objective.at(&values)?;
    if others.is_empty() {
        return Ok(start.residual.norm_squared());
    }
    let spec = &objective.curves[0].model.spec;
    let coordinates = Coordinates::new(unknown, spec, &start, objective.size(), Searched::But(j));
    Ok(search(objective, &coordinates, start, None)?.point.residual.norm_squared())
}
