//! Effect `viscous_damping`: damping of a region by a viscosity.

use super::part::EffectPart;
use super::repeated::check_repeated;
use crate::effect::ViscousDamping;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::text::quantity::Viscosity;
use crate::system::Effect;
use schemars::JsonSchema;
use serde::Deserialize;
use std::sync::Arc;

/// Viscous damping of the cells of a region.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ViscousDampingSpec {
    /// Region of cells that are damped
    pub region: String,
    /// Viscosity η
    pub eta: Viscosity,
}

impl EffectPart for ViscousDampingSpec {
    fn build(&self, place: &str, builder: &mut Builder) -> Result<Box<dyn Effect>, SceneError> {
        let eta = self.eta.0;
        if eta < 0.0 {
            return Err(builder.content(place, format!("eta is {eta} Pa s"), "a viscosity is not negative"));
        }
        let damping = Arc::new(ViscousDamping::new(&builder.body.mesh, builder.cells(place, &self.region)?, eta));
        builder.gathered.viscous.push(damping.clone());
        Ok(Box::new(damping))
    }

    fn words(&self) -> String {
        format!("region {}, eta = {} Pa s", self.region, self.eta)
    }

    fn needs_rates(&self) -> bool {
        true
    }

    fn check(&self, number: usize, builder: &mut Builder) -> Result<(), SceneError> {
        check_repeated(builder, number, "viscous_damping", String::new(), &self.region)
    }
}
