//! Springs and dampers on the edges of a mesh, for comparison with other simulators.

use crate::effect::{CellPoints, EdgeDampers, EdgeSprings};
use crate::mesh::Order;
use crate::scene::builder::{Builder, Gathered};
use crate::scene::error::SceneError;
use crate::scene::quantity::{Modulus, SpringStiffness};
use crate::scene::spec::{EffectSpec, SceneSpec};
use crate::system::Effect;
use std::sync::Arc;

/// Springs of one stiffness, or of a modulus.
pub(in crate::scene) fn build_edge_springs(
    builder: &Builder,
    place: &str,
    region: &str,
    stiffness: Option<SpringStiffness>,
    modulus: Option<Modulus>,
    gathered: &mut Gathered,
) -> Result<Box<dyn Effect>, SceneError> {
    let cells = linear_cells(builder, place, region)?;
    let mesh = &builder.body.mesh;
    let positive = |key: &str, value: f64, unit: &str| {
        let fact = || format!("{key} is {value} {unit}");
        if value > 0.0 { Ok(value) } else { Err(builder.content(place, fact(), "give a positive one")) }
    };
    let springs = match (stiffness, modulus) {
        (Some(k), None) => EdgeSprings::uniform(mesh, cells, positive("stiffness", k.0, "N/m")?),
        (None, Some(e)) => EdgeSprings::of_modulus(mesh, cells, positive("E", e.0, "Pa")?),
        (both, _) => {
            let fact = if both.is_some() { "both `stiffness` and `E`" } else { "neither `stiffness` nor `E`" };
            let remedy = "give `stiffness` (\"20 N/m\", the same on every edge) or `E` (\"100 kPa\", Young's modulus)";
            return Err(builder.content(place, fact, remedy));
        }
    };
    gathered.points.push(Arc::new(CellPoints::new(mesh, cells)));
    Ok(gathered.store(region, springs))
}

/// Dampers of one constant.
pub(in crate::scene) fn build_edge_dampers(
    builder: &Builder,
    place: &str,
    region: &str,
    c: f64,
) -> Result<Box<dyn Effect>, SceneError> {
    if c < 0.0 {
        return Err(builder.content(place, format!("damping is {c} N s/m"), "damping is not negative"));
    }
    Ok(Box::new(EdgeDampers::new(&builder.body.mesh, linear_cells(builder, place, region)?, c)))
}

fn linear_cells<'b>(builder: &'b Builder, place: &str, region: &str) -> Result<&'b [u32], SceneError> {
    if builder.body.mesh.order == Order::Quadratic {
        let fact = "springs on the halves of a straight edge do not hold its mid-node";
        return Err(builder.content(place, fact, "take mesh.element = \"tet4\"; mesh.levels = 1 splits the edges"));
    }
    builder.cells(place, region)
}

/// Reason why the response of a body of springs has no limit as h → 0.
pub(in crate::scene) fn limit_of_springs(spec: &SceneSpec) -> Option<String> {
    let why = |effect: &EffectSpec| match effect {
        EffectSpec::EdgeSprings { stiffness: Some(_), .. } => {
            Some("springs of one stiffness on every edge stiffen the body as 1/h")
        }
        EffectSpec::EdgeSprings { .. } => {
            Some("springs on edges have ν = 1/4 and a stiffness that depends on the directions of the edges")
        }
        _ => None,
    };
    spec.effects.iter().find_map(why).map(String::from)
}
