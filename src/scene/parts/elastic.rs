//! The elastic effect of a region: a law in one of the formulations.

use crate::effect::{Elastic, MeanDilatation, MixedElastic, pressure_hosts};
use crate::mesh::Order;
use crate::scene::builder::{Builder, Gathered};
use crate::scene::error::SceneError;
use crate::scene::spec::FormulationSpec;
use crate::system::Effect;

/// A law on the cells of a region.
pub(in crate::scene) fn build_elastic(
    builder: &Builder,
    place: &str,
    region: &str,
    law: &str,
    formulation: FormulationSpec,
    gathered: &mut Gathered,
) -> Result<Box<dyn Effect>, SceneError> {
    let cells = builder.cells(place, region)?;
    let mesh = &builder.body.mesh;
    let (name, built) = ("elastic".to_string(), builder.law(place, law)?);
    let info = built.info().name;
    gathered.laws.push(builder.law(place, law)?);
    Ok(match formulation {
        FormulationSpec::Displacement => gathered.solid(region, Elastic::new(name, mesh, cells, built)),
        FormulationSpec::Mixed => {
            let first = (3 * builder.nodes + gathered.hosts.len()) as u32;
            let effect =
                MixedElastic::new(name, mesh, cells, &*built, first).ok_or_else(|| no_split(builder, place, info))?;
            gathered.hosts.extend(pressure_hosts(mesh, cells));
            gathered.solid(region, effect)
        }
        FormulationSpec::MeanDilatation if mesh.order == Order::Linear => {
            let fact = "mean_dilatation on tet4 is the displacement formulation";
            return Err(builder.content(place, fact, "take formulation = \"mixed\", or mesh.element = \"tet10\""));
        }
        FormulationSpec::MeanDilatation => {
            let effect =
                MeanDilatation::new(name, mesh, cells, &*built).ok_or_else(|| no_split(builder, place, info))?;
            gathered.solid(region, effect)
        }
    })
}

fn no_split(builder: &Builder, place: &str, law: &str) -> SceneError {
    let fact = format!("the law {law} has no volumetric part of its own");
    builder.content(place, fact, "take a law with a split such as neo_hookean, or formulation = \"displacement\"")
}
