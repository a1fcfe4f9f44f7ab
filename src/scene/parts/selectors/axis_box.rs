//! Selector `box`: everything in a box along the axes.

use super::part::{Found, Ground, PickSpec, Refusal, SelectorPart};
use super::place::{RuleSpec, at_place, vector};
use crate::mesh::error::point;
use crate::scene::quantity::Length;
use serde::Deserialize;

/// A box along the axes, its sides included.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxSelector {
    pub min: [Length; 3],
    pub max: [Length; 3],
    #[serde(default)]
    pub pick: PickSpec,
    pub rule: Option<RuleSpec>,
}

impl SelectorPart for BoxSelector {
    fn find(&self, ground: &Ground) -> Result<Found, Refusal> {
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
