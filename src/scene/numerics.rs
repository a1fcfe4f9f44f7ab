//! `[numerics]`: settings that decide how a scene is solved, never what it describes.

use super::error::{SceneError, content};
use super::linear_solver::{LinearSpec, MemorySpec};
use super::text::quantity::{Length, Time};
use crate::solve::MOST_CUTS;
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::Path;

/// Tolerances and methods of the solution; every key has a default
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct NumericsSpec {
    /// Tolerance of the relative residual and of the constraints \[–\]
    pub tolerance: f64,
    /// Largest correction that may remain in an accepted state, relative to the largest displacement
    pub accuracy: f64,
    /// Largest number of iterations of Newton's method in one step
    pub max_iterations: usize,
    /// Shortens Newton steps that do not lower the residual
    pub line_search: bool,
    /// Reuses a factorisation as long as it is useful; the solution is the same within `tolerance`
    pub reuse_factor: bool,
    /// Cost of a factorisation, in back-substitutions, from which it is reused from step to step
    pub reuse_threshold: f64,
    /// Method for linear systems
    pub linear: LinearSpec,
    /// Largest memory of a factor
    pub factor_memory: MemorySpec,
    /// Extrapolates the initial guess of a step from previous steps
    pub extrapolate: bool,
    /// Largest number of times that a step may be halved
    pub cuts: u32,
    /// Largest error that one dynamic step may make; `dt` is then the longest step
    pub time_error: Option<Length>,
    /// Repeats a failed step with projected tangents before cutting it
    pub projection: bool,
    /// Wall time after which a run stops
    pub time_budget: Option<Time>,
}

impl Default for NumericsSpec {
    fn default() -> Self {
        let (newton, step) = (crate::solve::NewtonSettings::default(), crate::solve::StepSettings::default());
        Self {
            tolerance: newton.tolerance,
            accuracy: newton.accuracy,
            max_iterations: newton.max_iterations,
            line_search: newton.line_search,
            reuse_factor: newton.reuse_factor,
            reuse_threshold: newton.reuse_threshold,
            linear: LinearSpec::default(),
            factor_memory: MemorySpec::default(),
            extrapolate: step.extrapolate,
            cuts: step.cuts,
            time_error: None,
            projection: newton.projection,
            time_budget: None,
        }
    }
}

/// Refuses meaningless settings.
pub(super) fn check_numerics(file: &Path, n: &NumericsSpec) -> Result<(), SceneError> {
    if !(n.tolerance > 0.0 && n.tolerance < 1.0) {
        let fact = format!("tolerance = {}", n.tolerance);
        return Err(content(file, "numerics", fact, "it lies between 0 and 1, for example 1e-8"));
    }
    if !(n.accuracy > 0.0 && n.accuracy < 1.0) {
        let fact = format!("accuracy = {}", n.accuracy);
        return Err(content(file, "numerics", fact, "it lies between 0 and 1, for example 1e-6"));
    }
    if let Some(budget) = n.time_budget.filter(|b| b.0 <= 0.0) {
        let fact = format!("time_budget = {} s", budget.0);
        return Err(content(file, "numerics", fact, "give a positive time, for example \"10 min\""));
    }
    if let Some(error) = n.time_error.filter(|e| !(e.0 > 0.0 && e.0.is_finite())) {
        let fact = format!("time_error = {} m", error.0);
        return Err(content(file, "numerics", fact, "give a positive length, for example \"0.05 mm\""));
    }
    if n.reuse_threshold.is_nan() || n.reuse_threshold < 0.0 {
        let fact = format!("reuse_threshold = {}", n.reuse_threshold);
        return Err(content(file, "numerics", fact, "give a number of back-substitutions, 0 or more"));
    }
    if n.max_iterations == 0 {
        return Err(content(file, "numerics", "max_iterations = 0", "allow at least one iteration"));
    }
    if n.cuts > MOST_CUTS {
        let fact = format!("cuts = {}: 2^{} parts of a step", n.cuts, n.cuts);
        return Err(content(file, "numerics", fact, format!("take {MOST_CUTS} at most; 10 is usual")));
    }
    Ok(())
}
