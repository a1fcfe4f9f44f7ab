//! Effect `mass_damping`: damping α M of a region.

use super::inertia::{LumpingSpec, mass};
use super::part::EffectPart;
use super::repeated::check_repeated;
use crate::effect::MassDamping;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::text::quantity::{Density, PerSecond};
use crate::system::Effect;
use schemars::JsonSchema;
use serde::Deserialize;

/// Damping of a region in proportion to its mass.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MassDampingSpec {
    /// Region of cells that are damped
    pub region: String,
    /// Mass density at rest
    pub density: Density,
    /// Form of the mass matrix
    pub mass: LumpingSpec,
    /// Rate α of r = α M v
    pub alpha: PerSecond,
}

impl EffectPart for MassDampingSpec {
    fn build(&self, place: &str, builder: &mut Builder) -> Result<Box<dyn Effect>, SceneError> {
        let alpha = self.alpha.0;
        if alpha < 0.0 {
            return Err(builder.content(place, format!("alpha is {alpha} 1/s"), "damping is not negative"));
        }
        let mass = mass(builder, place, &self.region, self.density, self.mass)?;
        Ok(Box::new(MassDamping { alpha, mass }))
    }

    fn words(&self) -> String {
        format!("region {}, alpha = {} 1/s, mass {}", self.region, self.alpha, self.mass.name())
    }

    fn needs_rates(&self) -> bool {
        true
    }

    fn check(&self, number: usize, builder: &mut Builder) -> Result<(), SceneError> {
        check_repeated(builder, number, "mass_damping", String::new(), &self.region)
    }
}
