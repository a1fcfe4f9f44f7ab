//! Probe `stretch`: `stretch_median`, `stretch_p95`, `stretch_max` of the largest principal stretch by volume, `min_j`.

use super::part::Probe;
use crate::effect::CellPoints;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::record::recorder::{Moment, Recorder};
use crate::scene::record::stretch::stretches;
use schemars::JsonSchema;
use serde::Deserialize;
use std::sync::Arc;

/// Distribution of the largest principal stretch over the volume.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stretch {}

impl Probe for Stretch {
    fn build(&self, _: &str, builder: &Builder) -> Result<Box<dyn Recorder>, SceneError> {
        Ok(Box::new(Recorded { points: builder.gathered.points.clone() }))
    }
}

struct Recorded {
    points: Vec<Arc<CellPoints>>,
}

impl Recorder for Recorded {
    fn columns(&self) -> Vec<String> {
        ["stretch_median", "stretch_p95", "stretch_max", "min_j"].map(String::from).into()
    }

    fn record(&self, now: &Moment) -> Vec<f64> {
        stretches(&self.points, &now.state.x)
    }
}
