//! Inputs for which the quantities of a reduced model have given values: damped least squares with its derivatives, within the ranges.
//!
//! Source: Levenberg, *Quart. Appl. Math.* 2, 1944; Marquardt, *J. SIAM* 11, 1963. Inputs are scaled by their ranges, so that among many solutions
//! the shortest change is the one with the smallest shares of the ranges. If the search from the current inputs ends short of the targets, as at
//! rest, where an unsigned angle has no derivative, it is restarted from other positions in the ranges. Limits: each of these searches is local.

use super::twin::{StepError, Twin, TwinState};
use crate::reduction::inputs::Input;
use nalgebra::{DMatrix, DVector};

/// A target value of a quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Index of the quantity
    pub quantity: usize,
    pub value: f64,
    /// Accepted difference, in the unit of the quantity
    pub tolerance: f64,
}

/// Result of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Reached {
    /// Inputs at which the model now is, in SI
    pub inputs: Vec<f64>,
    /// Whether every target is met within its tolerance
    pub met: bool,
    /// Largest distance from a target, in units of its tolerance
    pub distance: f64,
    pub iterations: usize,
}

/// Largest number of iterations.
const ITERATIONS: usize = 40;
/// Initial damping.
const DAMPING_FIRST: f64 = 1e-3;
/// Factor of the damping after a better step.
const DAMPING_BETTER: f64 = 0.2;
/// Factor of the damping after a worse step.
const DAMPING_WORSE: f64 = 5.0;
/// Damping at which a search stops.
const DAMPING_MOST: f64 = 1e8;

/// Positions in the ranges from which the search is restarted \[–\].
const STARTS: [f64; 5] = [0.5, 0.25, 0.75, 0.05, 0.95];

/// Moves the model to inputs in their ranges at which the targets are met, or as close to them as the search gets. Only the driving inputs are moved,
/// not constants of laws and weights. A dynamic model takes one time step, at whose end the targets are met, with inputs that change by no more than
/// in the runs from which it was made.
///
/// # Errors
///
/// [`StepError`] if the model has no equilibrium at the current inputs.
pub fn reach(twin: &mut Twin, targets: &[Target]) -> Result<Reached, StepError> {
    let moving = twin.model().driving();
    reach_by(twin, targets, &moving)
}

/// Moves the model to the targets as [`reach`] does, but by the inputs that are true in `moving`; the others are unchanged.
///
/// # Errors
///
/// The errors of [`reach`].
pub fn reach_by(twin: &mut Twin, targets: &[Target], moving: &[bool]) -> Result<Reached, StepError> {
    let ranges = reachable(twin, moving);
    let present: Vec<f64> = twin.inputs().iter().zip(&ranges).map(|(u, r)| u.clamp(r[0], r[1])).collect();
    let from = twin.dt().map(|_| twin.save());
    let from = from.as_ref();
    let mut best = search(twin, targets, from, &ranges, present)?;
    for share in STARTS {
        if best.met {
            break;
        }
        let start = ranges.iter().map(|r| r[0] + share * (r[1] - r[0])).collect();
        if let Ok(other) = search(twin, targets, from, &ranges, start) {
            let iterations = best.iterations + other.iterations;
            best = Reached { iterations, ..if other.distance < best.distance { other } else { best } };
        }
    }
    go(twin, from, &best.inputs)?;
    Ok(best)
}

/// Returns the ranges of the inputs; for a dynamic model, those that are reachable within one step. The range of an input that is not moved is its
/// current value.
fn reachable(twin: &Twin, moving: &[bool]) -> Vec<[f64; 2]> {
    let model = twin.model();
    let within = |(k, (input, present)): (usize, (&Input, &f64))| {
        if !moving[k] {
            return [*present; 2];
        }
        let [low, high] = input.range;
        let present = present.clamp(low, high);
        let most = model.dynamics.as_ref().map_or(f64::INFINITY, |dynamics| dynamics.changes[k]);
        [low.max(present - most), high.min(present + most)]
    };
    model.inputs.iter().zip(twin.inputs()).enumerate().map(within).collect()
}

/// Takes a step to these inputs, always from the same state in time if one is given.
fn go(twin: &mut Twin, from: Option<&TwinState>, inputs: &[f64]) -> Result<(), StepError> {
    if let Some(state) = from {
        twin.restore(state);
    }
    twin.step(inputs).map(drop)
}

/// Searches from one starting point.
fn search(
    twin: &mut Twin,
    targets: &[Target],
    from: Option<&TwinState>,
    ranges: &[[f64; 2]],
    mut inputs: Vec<f64>,
) -> Result<Reached, StepError> {
    let (n, m) = (ranges.len(), targets.len());
    go(twin, from, &inputs)?;
    let left = |twin: &Twin| {
        DVector::from_fn(m, |k, _| (targets[k].value - twin.values()[targets[k].quantity]) / targets[k].tolerance)
    };
    let mut damping = DAMPING_FIRST;
    let mut rest = left(twin);
    let mut sensitivities = vec![0.0; twin.values().len() * n];
    for iteration in 0..ITERATIONS {
        let distance = rest.amax();
        if distance <= 1.0 {
            return Ok(Reached { inputs, met: true, distance, iterations: iteration });
        }
        twin.sensitivities(&mut sensitivities);
        let width = |k: usize| ranges[k][1] - ranges[k][0];
        let by_share = |t: &Target, k: usize| sensitivities[t.quantity * n + k] * width(k) / t.tolerance;
        let jacobian = DMatrix::from_fn(m, n, |row, k| by_share(&targets[row], k));
        let gradient = jacobian.transpose() * &rest;
        // An input at an end of its range that would leave the range is held there
        let held: Vec<bool> = (0..n)
            .map(|k| {
                (inputs[k] <= ranges[k][0] && gradient[k] < 0.0) || (inputs[k] >= ranges[k][1] && gradient[k] > 0.0)
            })
            .collect();
        let normal = jacobian.transpose() * &jacobian;
        let size = normal.diagonal().amax();
        let mut better = false;
        while !better && damping < DAMPING_MOST {
            let mut matrix = normal.clone();
            for k in 0..n {
                matrix[(k, k)] += damping * size.max(f64::MIN_POSITIVE);
            }
            for k in (0..n).filter(|&k| held[k]) {
                matrix.row_mut(k).fill(0.0);
                matrix.column_mut(k).fill(0.0);
                matrix[(k, k)] = 1.0;
            }
            let right = DVector::from_fn(n, |k, _| if held[k] { 0.0 } else { gradient[k] });
            let change = matrix.cholesky().map(|factor| factor.solve(&right));
            let trial: Option<Vec<f64>> = change.map(|change| {
                (0..n).map(|k| (inputs[k] + width(k) * change[k]).clamp(ranges[k][0], ranges[k][1])).collect()
            });
            if let Some(trial) = trial.filter(|t| go(twin, from, t).is_ok()) {
                let next = left(twin);
                better = next.norm() < rest.norm();
                if better {
                    (inputs, rest) = (trial, next);
                }
            }
            damping *= if better { DAMPING_BETTER } else { DAMPING_WORSE };
        }
        if !better {
            break;
        }
    }
    go(twin, from, &inputs)?;
    let distance = rest.amax();
    Ok(Reached { inputs, met: distance <= 1.0, distance, iterations: ITERATIONS })
}
