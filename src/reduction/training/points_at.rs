//! The points of a body at the training states, each with the laws of its constants.

use super::body_points::{BodyPoints, PointForce};
use super::fields_at_points::FieldsAtPoints;
use super::full_state::FullState;
use crate::material::{LawCard, LawSpecError};
use crate::reduction::constants::Constants;
use crate::reduction::error::ReductionError;

/// The laws of a body at the training states, if constants are inputs.
pub struct PointsAt<'a, 'b> {
    points: &'b BodyPoints<'a>,
    /// \[states\] the laws of the parts whose law varies
    laws: Vec<Vec<(usize, LawCard)>>,
}

impl<'a, 'b> PointsAt<'a, 'b> {
    pub fn new(points: &'b BodyPoints<'a>, constants: &Constants, states: &[FullState]) -> Result<Self, LawSpecError> {
        let laws = states.iter().map(|state| constants.cards(&state.inputs)).collect::<Result<_, _>>()?;
        Ok(Self { points, laws })
    }

    /// Returns P and G of Σ y_k v_k at all points, with the laws of a state.
    pub fn forces(&self, state: usize, fields: &FieldsAtPoints, y: &[f64]) -> Result<Vec<PointForce>, ReductionError> {
        match &self.laws[state][..] {
            [] => fields.forces(self.points, y),
            laws => fields.forces(&self.points.with_laws(laws)?, y),
        }
    }
}
