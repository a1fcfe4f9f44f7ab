//! Selector `plane`: everything near a plane.

use super::part::{Ground, PickSpec, Refusal, SelectedEntities, SelectorPart};
use super::place::{RuleSpec, at_surface, direction, vector};
use crate::mesh::error::point;
use crate::scene::text::quantity::Length;
use schemars::JsonSchema;
use serde::Deserialize;

/// The layer within `tolerance` of a plane.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneSelector {
    /// Point of the plane
    pub point: [Length; 3],
    /// Normal of the plane; its length does not matter
    pub normal: [f64; 3],
    /// Half the thickness of the layer
    pub tolerance: Length,
    /// Kind of entities that are selected
    #[serde(default)]
    pub pick: PickSpec,
    /// Rule for facets or cells at the border; it is required for both
    pub rule: Option<RuleSpec>,
}

impl SelectorPart for PlaneSelector {
    fn find(&self, ground: &Ground) -> Result<SelectedEntities, Refusal> {
        let (at, normal, tolerance) = (vector(&self.point), direction("normal", &self.normal)?, self.tolerance.0);
        if tolerance < 0.0 {
            let fact = format!("the tolerance is {} mm", tolerance * 1e3);
            return Err(Refusal::new(fact, "it must not be negative"));
        }
        at_surface(ground, (&self.words(), tolerance), (self.pick, self.rule), &|x, margin| {
            (x - at).dot(&normal).abs() <= tolerance + margin
        })
    }

    fn words(&self) -> String {
        format!("the plane through {} with tolerance {} mm", point(&vector(&self.point)), self.tolerance.0 * 1e3)
    }
}
