//! Selector `normal`: the facets that look in a direction.

use super::part::{Found, Ground, Refusal, SelectorPart};
use super::place::direction;
use crate::mesh::select::{Pick, facing};
use crate::scene::quantity::Angle;
use schemars::JsonSchema;
use serde::Deserialize;

/// Boundary facets whose outward normal is within `angle` of `direction`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NormalSelector {
    /// Direction that the normal is compared with; its length does not count
    pub direction: [f64; 3],
    /// Largest angle between them
    pub angle: Angle,
}

impl SelectorPart for NormalSelector {
    fn find(&self, ground: &Ground) -> Result<Found, Refusal> {
        let entities = facing(ground.mesh, &direction("direction", &self.direction)?, self.angle.0);
        Ok(Found { pick: Pick::Facets, entities, depends_on_mesh: true })
    }

    fn words(&self) -> String {
        let [x, y, z] = self.direction;
        format!("the normal [{x}, {y}, {z}] within {} deg", self.angle.0.to_degrees())
    }
}
