//! `[numerics]`: what decides how a scene is solved, never what it is.

use super::linear::{LinearSpec, MemorySpec};
use super::quantity::{Length, Time};
use serde::Deserialize;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NumericsSpec {
    pub tolerance: f64,
    pub max_iterations: usize,
    pub line_search: bool,
    pub reuse_factor: bool,
    /// Back-substitutions that a factorisation must cost to be kept from step to step
    pub reuse_threshold: f64,
    pub linear: LinearSpec,
    /// The largest factor that is made
    pub factor_memory: MemorySpec,
    pub extrapolate: bool,
    pub cuts: u32,
    /// Largest error that a dynamic step may make by itself: dt is then the longest step
    pub time_error: Option<Length>,
    pub projection: bool,
    /// Wall time after which a run stops
    pub time_budget: Option<Time>,
}

impl Default for NumericsSpec {
    fn default() -> Self {
        let (newton, step) = (crate::solve::NewtonSettings::default(), crate::solve::StepSettings::default());
        Self {
            tolerance: newton.tolerance,
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
