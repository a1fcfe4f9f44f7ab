//! Probe `reaction`: `<region>_reaction_{x,y,z}_N`, the sum of the reactions on a region.

use super::part::Probe;
use crate::scene::body::Body;
use crate::scene::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::recorder::{Headline, Moment, Recorder};
use crate::system::{Gradient, State};
use schemars::JsonSchema;
use serde::Deserialize;

/// Sum of the reactions on a region.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reaction {
    /// Region that is held or moved
    pub region: String,
}

impl Probe for Reaction {
    fn build(&self, place: &str, builder: &Builder) -> Result<Box<dyn Recorder>, SceneError> {
        let nodes = builder.body.mesh.nodes_of(builder.region(place, &self.region)?);
        Ok(Box::new(Recorded { name: self.region.clone(), nodes }))
    }

    fn headline(&self) -> Option<Headline> {
        Some(Headline { column: format!("{}_reaction_x_N", self.region), label: "reaction", symbol: "R", unit: "N" })
    }
}

struct Recorded {
    name: String,
    nodes: Vec<u32>,
}

impl Recorder for Recorded {
    fn columns(&self) -> Vec<String> {
        ["x", "y", "z"].map(|c| format!("{}_reaction_{c}_N", self.name)).into()
    }

    fn record(&self, now: &Moment) -> Vec<f64> {
        (0..3).map(|i| self.nodes.iter().map(|&k| now.residual[3 * k as usize + i]).sum()).collect()
    }

    fn gradients(&self, _: &Body, _: &State, _: &[f64]) -> Vec<Option<Gradient>> {
        let along = |i: u32| self.nodes.iter().map(|&k| (3 * k + i, 1.0)).collect();
        (0..3).map(|i| Some(Gradient { reaction: along(i), ..Gradient::default() })).collect()
    }

    fn is_differentiable(&self) -> bool {
        true
    }
}
