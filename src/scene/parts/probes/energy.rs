//! Probe `energy`: `elastic_J`, `kinetic_J`, `dissipated_J`, `work_J`.

use super::part::Probe;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::record::recorder::{Energies, Moment, Recorder};
use schemars::JsonSchema;
use serde::Deserialize;

/// Energies of the whole scene.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Energy {}

impl Probe for Energy {
    fn build(&self, _: &str, _: &Builder) -> Result<Box<dyn Recorder>, SceneError> {
        Ok(Box::new(*self))
    }
}

impl Recorder for Energy {
    fn columns(&self) -> Vec<String> {
        ["elastic_J", "kinetic_J", "dissipated_J", "work_J"].map(String::from).into()
    }

    fn record(&self, now: &Moment) -> Vec<f64> {
        let Energies { elastic, kinetic, dissipated, work } = now.energies;
        vec![elastic, kinetic, dissipated, work]
    }
}
