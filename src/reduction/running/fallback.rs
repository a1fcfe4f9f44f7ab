//! A reduced model with the full one behind it, which answers where the error bar is above the tolerance, or unknown.

use super::twin::{StepError, StepReport, Twin};
use crate::reduction::training::full_model::{FullModel, FullModelError};

/// Which model an answer is from.
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
    /// Zero of the full model, on the mesh of which the bars are counted; its solver leaves its own tolerance
    pub bars: Vec<f64>,
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum FallbackError {
    #[error(transparent)]
    Step(#[from] StepError),
    #[error(transparent)]
    Full(#[from] FullModelError),
}

/// The full model, and when it is asked.
pub struct Fallback {
    pub full: FullModel,
    /// Largest error bar that is accepted of the reduced model, as a share of the largest change from rest in the training states
    pub tolerance: f64,
}

/// Whether every bar of the present equilibrium is within the tolerance, and the inputs are in their ranges.
fn is_trusted(twin: &Twin, tolerance: f64) -> bool {
    let sizes = &twin.model().largest_changes;
    twin.in_range() && twin.bars().iter().zip(sizes).all(|(bar, size)| *bar <= tolerance * size)
}

impl Fallback {
    /// The quantities at these inputs \[SI\], by the reduced model where it is within the tolerance.
    ///
    /// # Errors
    ///
    /// [`FallbackError`]: inputs that are none, and a full model without an equilibrium.
    pub fn step(&mut self, twin: &mut Twin, inputs: &[f64]) -> Result<TwinAnswer, FallbackError> {
        let reached = twin.step(inputs);
        match self.correct(twin, inputs, reached)? {
            Some(values) => Ok(TwinAnswer { by: By::Full, bars: vec![0.0; values.len()], values }),
            None => Ok(TwinAnswer { by: By::Reduced, values: twin.values().to_vec(), bars: twin.bars().to_vec() }),
        }
    }

    /// The quantities by the full model, where the reduced one did not reach these inputs, or is not within the tolerance there.
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
