//! Effects of a scene: the registry of their kinds.

use super::builder::{Builder, Gathered};
use super::error::SceneError;
use super::spec::{EffectSpec, FormulationSpec, LumpingSpec};
use crate::effect::{
    Elastic, Gravity, Inertia, Mass, MassDamping, MeanDilatation, MixedElastic, ViscousDamping, pressure_hosts,
};
use crate::math::tensor::Vec3;
use crate::math::units::Dimension;
use crate::mesh::Order;
use crate::scene::comparison::{build_edge_dampers, build_edge_springs, build_stiffness_damping};
use crate::scene::loads::{build_point_force, build_traction};
use crate::scene::viscoelastic::build_viscoelastic;
use crate::system::Effect;
use std::sync::Arc;

pub(super) fn build_effect(
    builder: &mut Builder,
    place: &str,
    spec: &EffectSpec,
    gathered: &mut Gathered,
) -> Result<Box<dyn Effect>, SceneError> {
    let body = builder.body.clone();
    let mesh = &body.mesh;
    let positive = |rho: f64| {
        let fact = || format!("the density is {rho:.4} kg/m^3");
        if rho > 0.0 { Ok(rho) } else { Err(builder.content(place, fact(), "give a positive one")) }
    };
    let mass = |region: &str, rho: f64, lumping: LumpingSpec| {
        Ok::<_, SceneError>(Mass::new(mesh, builder.cells(place, region)?, positive(rho)?, lumping.into()))
    };
    Ok(match spec {
        EffectSpec::Elastic { region, law, formulation } => {
            let cells = builder.cells(place, region)?;
            let (name, built) = ("elastic".to_string(), builder.law(place, law)?);
            let info = built.info().name;
            gathered.laws.push(builder.law(place, law)?);
            match formulation {
                FormulationSpec::Displacement => gathered.solid(region, Elastic::new(name, mesh, cells, built)),
                FormulationSpec::Mixed => {
                    let first = (3 * builder.nodes + gathered.hosts.len()) as u32;
                    let effect = MixedElastic::new(name, mesh, cells, &*built, first)
                        .ok_or_else(|| no_split(builder, place, info))?;
                    gathered.hosts.extend(pressure_hosts(mesh, cells));
                    gathered.solid(region, effect)
                }
                FormulationSpec::MeanDilatation if mesh.order == Order::Linear => {
                    let fact = "mean_dilatation on tet4 is the displacement formulation";
                    return Err(builder.content(
                        place,
                        fact,
                        "take formulation = \"mixed\", or mesh.element = \"tet10\"",
                    ));
                }
                FormulationSpec::MeanDilatation => {
                    let effect = MeanDilatation::new(name, mesh, cells, &*built)
                        .ok_or_else(|| no_split(builder, place, info))?;
                    gathered.solid(region, effect)
                }
            }
        }
        EffectSpec::Inertia { region, density, mass: lumping } => {
            Box::new(Inertia { mass: mass(region, density.0, *lumping)? })
        }
        EffectSpec::MassDamping { region, density, mass: lumping, alpha } => {
            if alpha.0 < 0.0 {
                return Err(builder.content(place, format!("alpha is {} 1/s", alpha.0), "damping is not negative"));
            }
            Box::new(MassDamping { alpha: alpha.0, mass: mass(region, density.0, *lumping)? })
        }
        EffectSpec::ViscousDamping { region, eta } => {
            if eta.0 < 0.0 {
                return Err(builder.content(place, format!("eta is {} Pa s", eta.0), "a viscosity is not negative"));
            }
            Box::new(ViscousDamping::new(mesh, builder.cells(place, region)?, eta.0))
        }
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
            let direction = Vec3::from(*direction);
            if direction.norm() == 0.0 || !direction.norm().is_finite() {
                return Err(builder.content(place, "the direction has no length", "write for example [0, 0, -1]"));
            }
            let density = positive(density.0)?;
            let name = format!("{region}_acceleration_m_s2");
            let acceleration = builder.signal(place, name, acceleration, Dimension::ACCELERATION)?;
            let cells = builder.cells(place, region)?;
            Box::new(Gravity::new(mesh, cells, density, direction.normalize(), acceleration))
        }
    })
}

fn no_split(builder: &Builder, place: &str, law: &str) -> SceneError {
    let fact = format!("the law {law} has no volumetric part of its own");
    builder.content(place, fact, "take a law with a split such as neo_hookean, or formulation = \"displacement\"")
}
