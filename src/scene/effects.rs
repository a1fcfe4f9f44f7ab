//! Effects of a scene: the registry of their kinds, one line each.

use super::builder::{Builder, Gathered};
use super::error::SceneError;
use super::parts::edge_springs::{build_edge_dampers, build_edge_springs};
use super::parts::elastic::build_elastic;
use super::parts::gravity::build_gravity;
use super::parts::inertia::{build_inertia, build_mass_damping};
use super::parts::point_force::build_point_force;
use super::parts::stiffness_damping::build_stiffness_damping;
use super::parts::traction::build_traction;
use super::parts::viscoelastic::build_viscoelastic;
use super::parts::viscous_damping::build_viscous_damping;
use super::spec::EffectSpec;
use crate::system::Effect;
use std::collections::BTreeMap;
use std::sync::Arc;

/// All effects of a scene, in the order of the file.
pub(super) fn build_effects(
    builder: &mut Builder,
    specs: &[EffectSpec],
    gathered: &mut Gathered,
) -> Result<Vec<Box<dyn Effect>>, SceneError> {
    // Damping by the stiffness of other effects is built after them, and keeps its place in the list.
    let mut order: Vec<usize> = (0..specs.len()).collect();
    order.sort_by_key(|&k| matches!(specs[k], EffectSpec::StiffnessDamping { .. }));
    let mut built = BTreeMap::new();
    for k in order {
        let effect = &specs[k];
        let place = format!("effect {} ({})", k + 1, effect.kind());
        built.insert(k, build_effect(builder, &place, effect, gathered)?);
    }
    Ok(built.into_values().collect())
}

/// The effect that a specification describes; what later effects need of it is gathered.
fn build_effect(
    builder: &mut Builder,
    place: &str,
    spec: &EffectSpec,
    gathered: &mut Gathered,
) -> Result<Box<dyn Effect>, SceneError> {
    Ok(match spec {
        EffectSpec::Elastic { region, law, formulation } => {
            build_elastic(builder, place, region, law, *formulation, gathered)?
        }
        EffectSpec::Inertia { region, density, mass } => {
            Box::new(build_inertia(builder, place, region, density.0, *mass)?)
        }
        EffectSpec::MassDamping { region, density, mass, alpha } => {
            Box::new(build_mass_damping(builder, place, region, (density.0, *mass), alpha.0)?)
        }
        EffectSpec::ViscousDamping { region, eta } => Box::new(build_viscous_damping(builder, place, region, eta.0)?),
        EffectSpec::Viscoelastic { region, law, moduli, prony } => {
            let shared = Arc::new(build_viscoelastic(builder, place, region, law, *moduli, prony)?);
            gathered.relaxing.push(shared.clone());
            Box::new(shared)
        }
        EffectSpec::StiffnessDamping { region, beta, stiffness } => {
            build_stiffness_damping(builder, place, region, beta.0, *stiffness, gathered)?
        }
        EffectSpec::EdgeSprings { region, stiffness, modulus } => {
            build_edge_springs(builder, place, region, *stiffness, *modulus, gathered)?
        }
        EffectSpec::EdgeDampers { region, damping } => build_edge_dampers(builder, place, region, damping.0)?,
        EffectSpec::PointForce { name, point, radius, direction, force } => {
            Box::new(build_point_force(builder, place, name, (point, *radius), *direction, force)?)
        }
        EffectSpec::Traction { name, region, skin, direction, traction } => {
            Box::new(build_traction(builder, place, name, (region, skin), *direction, traction)?)
        }
        EffectSpec::Gravity { region, density, direction, acceleration } => {
            Box::new(build_gravity(builder, place, (region, density.0), *direction, acceleration)?)
        }
    })
}
