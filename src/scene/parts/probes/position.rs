//! Probe `position`: `<region>_{x,y,z}_m`, the area-mean position of a region.

use super::mean::Mean;
use super::part::Probe;
use crate::scene::body::Body;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::record::features::{Features, Reading};
use crate::scene::record::recorder::{Headline, Moment, Recorder};
use crate::system::{Gradient, State};
use schemars::JsonSchema;
use serde::Deserialize;

/// Area-mean position of a region.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Position {
    /// Region whose mean position is recorded
    pub region: String,
}

impl Probe for Position {
    fn build(&self, place: &str, builder: &Builder) -> Result<Box<dyn Recorder>, SceneError> {
        let mean = Mean::new(&builder.body.mesh, builder.region_with_nodes(place, &self.region)?);
        Ok(Box::new(Recorded { name: self.region.clone(), mean }))
    }

    fn regions(&self) -> Vec<&str> {
        vec![&self.region]
    }

    fn headline(&self) -> Option<Headline> {
        Some(Headline { column: format!("{}_x_m", self.region), label: "position", symbol: "x", unit: "m" })
    }
}

struct Recorded {
    name: String,
    mean: Mean,
}

impl Recorder for Recorded {
    fn columns(&self) -> Vec<String> {
        ["x", "y", "z"].map(|c| format!("{}_{c}_m", self.name)).into()
    }

    fn record(&self, now: &Moment) -> Vec<f64> {
        self.mean.at(&now.state.x).as_slice().to_vec()
    }

    fn gradients(&self, _: &Body, _: &State, _: &[f64]) -> Vec<Option<Gradient>> {
        self.mean.gradients().map(Some).into()
    }

    fn is_differentiable(&self) -> bool {
        true
    }

    fn features(&self) -> Option<Features> {
        Some(Features { degree: 1, readings: (0..3).map(Reading::Value).collect() })
    }

    fn feature_values(&self, _: &Body, x: &[f64]) -> Vec<f64> {
        self.mean.at(x).as_slice().to_vec()
    }
}
