//! Stiffness-proportional damping, for comparison with other simulators.

use crate::effect::{Stiffness, StiffnessDamping};
use crate::scene::builder::{Builder, Gathered};
use crate::scene::error::{SceneError, hint};
use crate::scene::spec::StiffnessSpec;
use crate::system::Effect;
use std::sync::Arc;

/// Damping of the effects that were gathered for the region.
pub(in crate::scene) fn build_stiffness_damping(
    builder: &Builder,
    place: &str,
    region: &str,
    beta: f64,
    stiffness: StiffnessSpec,
    gathered: &Gathered,
) -> Result<Box<dyn Effect>, SceneError> {
    if beta < 0.0 {
        return Err(builder.content(place, format!("beta is {beta} s"), "damping is not negative"));
    }
    let of_region = gathered.stored.iter().filter(|(name, _)| name == region);
    let damped: Vec<Arc<dyn Effect>> = of_region.map(|(_, effect)| effect.clone()).collect();
    if damped.is_empty() {
        let known: Vec<&String> = gathered.stored.iter().map(|(name, _)| name).collect();
        let fact = format!("no elastic effect and no springs have the region \"{region}\"");
        return Err(builder.content(place, fact, hint(region, &known)));
    }
    let damping = StiffnessDamping::new(damped, beta, stiffness.into(), &builder.body.mesh.points);
    let damping = damping.ok_or_else(|| {
        let remedy = "take formulation = \"displacement\" or \"mean_dilatation\", or viscous_damping";
        builder.content(place, "stiffness damping of a mixed formulation is not defined", remedy)
    })?;
    Ok(Box::new(damping))
}

impl From<StiffnessSpec> for Stiffness {
    fn from(spec: StiffnessSpec) -> Self {
        match spec {
            StiffnessSpec::Initial => Self::Initial,
            StiffnessSpec::Last => Self::Last,
        }
    }
}
