//! Constraint `fixed`: holds components of the displacement of a region.

use super::part::{ConstraintPart, Motion, Moved};
use crate::math::signal::Signal;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use schemars::JsonSchema;
use serde::Deserialize;

/// A region that is held.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FixedSpec {
    /// Region that is held
    pub region: String,
    /// Components held, such as `"x"` or `"yz"`; all if absent
    #[serde(default = "all_components")]
    pub components: String,
}

fn all_components() -> String {
    "xyz".into()
}

impl FixedSpec {
    /// Holds the nodes of the region.
    pub(super) fn build(&self, builder: &mut Builder, place: &str) -> Result<(), SceneError> {
        builder.prescribe(place, &self.region, &self.components, |_, _| Signal::Constant(0.0))
    }
}

impl ConstraintPart for FixedSpec {
    fn moves(&self, _number: usize) -> Option<Moved<'_>> {
        Some(Moved { region: &self.region, components: &self.components, motion: Motion::Held })
    }
}
