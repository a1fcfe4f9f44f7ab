//! Effect `stiffness_damping`: damping β K of a region, for comparison with other simulators.

use super::part::EffectPart;
use super::repeated::check_repeated;
use crate::effect::{Stiffness, StiffnessDamping, Undamped};
use crate::scene::build::builder::Builder;
use crate::scene::error::{SceneError, hint};
use crate::scene::text::quantity::Time;
use crate::system::Effect;
use schemars::JsonSchema;
use serde::Deserialize;
use std::sync::Arc;

/// Damping of the elastic effects and springs whose region has this name.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StiffnessDampingSpec {
    /// Region of an elastic effect or of springs
    pub region: String,
    /// Time β of r = β K v
    pub beta: Time,
    /// Choice of the tangent K
    pub stiffness: StiffnessSpec,
}

/// Tangent that a stiffness-proportional damping uses.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum StiffnessSpec {
    /// The tangent at rest
    Initial,
    /// The tangent at the start of the step
    Last,
}

impl StiffnessSpec {
    /// Name as in scene files.
    fn name(self) -> &'static str {
        match self {
            Self::Initial => "initial",
            Self::Last => "last",
        }
    }
}

impl From<StiffnessSpec> for Stiffness {
    fn from(spec: StiffnessSpec) -> Self {
        match spec {
            StiffnessSpec::Initial => Self::Initial,
            StiffnessSpec::Last => Self::Last,
        }
    }
}

impl EffectPart for StiffnessDampingSpec {
    fn build(&self, place: &str, builder: &mut Builder) -> Result<Box<dyn Effect>, SceneError> {
        let (region, beta, stored) = (&self.region, self.beta.0, &builder.gathered.stored);
        if beta < 0.0 {
            return Err(builder.content(place, format!("beta is {beta} s"), "damping is not negative"));
        }
        let of_region = stored.iter().filter(|(name, _)| name == region);
        let damped: Vec<Arc<dyn Effect>> = of_region.map(|(_, effect)| effect.clone()).collect();
        if damped.is_empty() {
            let known: Vec<&String> = stored.iter().map(|(name, _)| name).collect();
            let fact = format!("no elastic effect and no springs have the region \"{region}\"");
            return Err(builder.content(place, fact, hint(region, &known)));
        }
        let damping = StiffnessDamping::new(damped, beta, self.stiffness.into(), &builder.body.mesh.points);
        match damping {
            Ok(damping) => Ok(Box::new(damping)),
            Err(fact) => {
                let remedy = match fact {
                    Undamped::SecondField => {
                        "take formulation = \"displacement\" or \"mean_dilatation\", or viscous_damping"
                    }
                    Undamped::OnMeans { .. } => "take viscous_damping",
                };
                Err(builder.content(place, fact.to_string(), remedy))
            }
        }
    }

    fn words(&self) -> String {
        format!("region {}, beta = {} s, stiffness {}", self.region, self.beta, self.stiffness.name())
    }

    fn needs_rates(&self) -> bool {
        true
    }

    fn needs_others(&self) -> bool {
        true
    }

    fn check(&self, number: usize, builder: &mut Builder) -> Result<(), SceneError> {
        check_repeated(builder, number, "stiffness_damping", self.stiffness.name().into(), &self.region)
    }
}
