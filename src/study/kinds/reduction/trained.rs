//! Training of the models of a study, at rest or in time, from the states of its runs.

use super::record::ReductionRecord;
use crate::reduction::{
    FullState, ReducedModel, ReductionError, Training, TransientTraining, Twin, errors, errors_in_time,
};

/// Training for models at rest or in time.
pub enum Trained<'a> {
    AtRest(Training<'a>),
    InTime(TransientTraining<'a>),
}

/// The states of runs after each step; for models at rest the division into runs has no meaning.
pub struct Runs {
    pub runs: Vec<Vec<FullState>>,
    pub states: Vec<FullState>,
}

impl Runs {
    pub fn new(runs: Vec<Vec<FullState>>) -> Self {
        let states = runs.concat();
        Self { runs, states }
    }

    /// Number of independent draws: states, or runs in time.
    pub fn count(&self, record: &ReductionRecord) -> usize {
        if record.motion.is_some() { self.runs.len() } else { self.states.len() }
    }
}

impl Trained<'_> {
    pub fn singular_values(&self) -> Result<(Vec<f64>, Vec<f64>), ReductionError> {
        match self {
            Self::AtRest(training) => training.singular_values(),
            Self::InTime(training) => training.singular_values(),
        }
    }

    pub fn model(&self, modes: usize, sampling: f64, others: &Runs) -> Result<ReducedModel, ReductionError> {
        match self {
            Self::AtRest(training) => training.model(modes, Some(sampling), &others.states),
            Self::InTime(training) => training.model(modes, Some(sampling), &others.runs),
        }
    }
}

/// Returns the errors of a model at the states of runs, with their estimates \[states × quantities\].
pub fn all_errors(model: &ReducedModel, runs: &Runs) -> Result<Vec<Vec<(f64, f64)>>, ReductionError> {
    match &model.dynamics {
        None => errors(model, &runs.states),
        Some(_) => Ok(errors_in_time(model, &runs.runs)?.concat()),
    }
}

/// Returns the inputs of the steps that are timed, in the order of each run; true for a step that starts at rest.
pub fn timed_steps(runs: &Runs) -> impl Iterator<Item = (bool, &[f64])> {
    runs.runs.iter().flat_map(|run| run.iter().enumerate().map(|(k, state)| (k == 0, &state.inputs[..])))
}

/// Resets a model that moves to rest at the start of a run.
pub fn begin(twin: &mut Twin, at_rest: bool) {
    if at_rest && twin.dt().is_some() {
        twin.reset();
    }
}
