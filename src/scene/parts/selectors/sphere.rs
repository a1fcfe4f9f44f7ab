//! Selector `sphere`: everything in a ball.

use super::part::{Ground, PickSpec, Refusal, SelectedEntities, SelectorPart};
use super::place::{RuleSpec, at_place, vector};
use crate::mesh::error::point;
use crate::scene::text::quantity::Length;
use schemars::JsonSchema;
use serde::Deserialize;

/// A ball.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereSelector {
    /// Centre of the ball
    pub center: [Length; 3],
    /// Radius of the ball
    pub radius: Length,
    /// Kind of entities that are selected
    #[serde(default)]
    pub pick: PickSpec,
    /// Rule for facets or cells at the border; it is required for both
    pub rule: Option<RuleSpec>,
}

impl SelectorPart for SphereSelector {
    fn find(&self, ground: &Ground) -> Result<SelectedEntities, Refusal> {
        let (center, radius) = (vector(&self.center), self.radius.0);
        if radius <= 0.0 {
            return Err(Refusal::new(format!("the radius is {} mm", radius * 1e3), "it must be positive"));
        }
        at_place(ground, &self.words(), (self.pick, self.rule), &|x, margin| (x - center).norm() <= radius + margin)
    }

    fn words(&self) -> String {
        format!("the sphere of radius {} mm at {}", self.radius.0 * 1e3, point(&vector(&self.center)))
    }
}
