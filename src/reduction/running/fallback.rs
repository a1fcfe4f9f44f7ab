//! A reduced model backed by the full one, which answers if the error bar is above the tolerance or unknown.

use super::twin::{StepError, StepReport, Twin};
use crate::reduction::training::full_model::{FullModel, FullModelError};

/// Model from which an answer comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    Reduced,
    Full,
}

/// Quantities with their error bars.
#[derive(Clone, Debug, PartialEq)]
pub struct TwinAnswer {
    pub by: By,
    pub values: Vec<f64>,
    /// Zero for the full model, because the bars are relative to its mesh; its solver leaves an error within its own tolerance
    pub bars: Vec<f64>,
}

/// Reason why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum FallbackError {
    #[error(transparent)]
    Step(#[from] StepError),
    #[error(transparent)]
    Full(#[from] FullModelError),
}

/// The full model, and the criterion for its use.
pub struct Fallback {
    pub full: FullModel,
    /// Largest acceptable error bar of the reduced model, relative to the largest change from rest in the training states
    pub tolerance: f64,
}

/// Whether every error bar of the current equilibrium is within the tolerance and the inputs are within their ranges.
fn is_trusted(twin: &Twin, tolerance: f64) -> bool {
    let sizes = &twin.model().largest_changes;
    twin.in_range() && twin.bars().iter().zip(sizes).all(|(bar, size)| *bar <= tolerance * size)
}

impl Fallback {
    /// Returns the quantities at these inputs in SI, by the reduced model if it is within the tolerance.
    ///
    /// # Errors
    ///
    /// [`FallbackError`]: invalid inputs, or a full model without an equilibrium.
    pub fn step(&mut self, twin: &mut Twin, inputs: &[f64]) -> Result<TwinAnswer, FallbackError> {
        let reached = twin.step(inputs);
        match self.correct(twin, inputs, reached)? {
            Some(values) => Ok(TwinAnswer { by: By::Full, bars: vec![0.0; values.len()], values }),
            None => Ok(TwinAnswer { by: By::Reduced, values: twin.values().to_vec(), bars: twin.bars().to_vec() }),
        }
    }

    /// Returns the quantities by the full model if the reduced one did not reach these inputs or is not within the tolerance there.
    ///
    /// # Errors
    ///
    /// See [`Fallback::step`].
    pub fn correct(
        &mut self,
        twin: &Twin,
        inputs: &[f64],
        reached: Result<StepReport, StepError>,
    ) -> Result<Option<Vec<f64>>, FallbackError> {
        match reached {
            Ok(_) if is_trusted(twin, self.tolerance) => Ok(None),
            Ok(_) | Err(StepError::NoEquilibrium) => Ok(Some(self.full.step(inputs)?)),
            Err(why) => Err(why.into()),
        }
    }
}
