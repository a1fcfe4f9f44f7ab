//! Selector `box`: everything in a box along the axes.

use super::part::{Ground, PickSpec, Refusal, SelectedEntities, SelectorPart};
use super::place::{RuleSpec, at_place, vector};
use crate::mesh::error::point;
use crate::scene::text::quantity::Length;
use schemars::JsonSchema;
use serde::Deserialize;

/// A box along the axes, including its sides.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxSelector {
    /// Corner with the smallest coordinates
    pub min: [Length; 3],
    /// Corner with the largest coordinates
    pub max: [Length; 3],
    /// Kind of entities that are selected
    #[serde(default)]
    pub pick: PickSpec,
    /// Rule for facets or cells at the border; it is required for both
    pub rule: Option<RuleSpec>,
}

impl SelectorPart for BoxSelector {
    fn find(&self, ground: &Ground) -> Result<SelectedEntities, Refusal> {
        let (min, max) = (vector(&self.min), vector(&self.max));
        if (0..3).any(|d| min[d] > max[d]) {
            return Err(Refusal::new("`min` is beyond `max`", "give the lower corner as `min`"));
        }
        at_place(ground, &self.words(), (self.pick, self.rule), &|x, margin| {
            (0..3).all(|d| x[d] >= min[d] - margin && x[d] <= max[d] + margin)
        })
    }

    fn words(&self) -> String {
        format!("the box {} to {}", point(&vector(&self.min)), point(&vector(&self.max)))
    }
}
