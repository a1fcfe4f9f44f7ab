//! Effect `edge_dampers`: dampers on the edges of a mesh, for comparison with other simulators.

use super::edge_springs::linear_cells;
use super::part::EffectPart;
use super::repeated::check_repeated;
use crate::effect::EdgeDampers;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::text::quantity::Damping;
use crate::system::Effect;
use schemars::JsonSchema;
use serde::Deserialize;

/// Dampers of one constant on the edges of a region.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EdgeDampersSpec {
    /// Region of cells on whose edges the dampers are
    pub region: String,
    /// Constant of each damper
    pub damping: Damping,
}

impl EffectPart for EdgeDampersSpec {
    fn build(&self, place: &str, builder: &mut Builder) -> Result<Box<dyn Effect>, SceneError> {
        let c = self.damping.0;
        if c < 0.0 {
            return Err(builder.content(place, format!("damping is {c} N s/m"), "damping is not negative"));
        }
        Ok(Box::new(EdgeDampers::new(&builder.body.mesh, linear_cells(builder, place, &self.region)?, c)))
    }

    fn words(&self) -> String {
        format!("region {}, {} N s/m", self.region, self.damping)
    }

    fn needs_rates(&self) -> bool {
        true
    }

    fn check(&self, number: usize, builder: &mut Builder) -> Result<(), SceneError> {
        check_repeated(builder, number, "edge_dampers", String::new(), &self.region)
    }
}
