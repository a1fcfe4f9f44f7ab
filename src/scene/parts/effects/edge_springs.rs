//! Effect `edge_springs`: springs on the edges of a mesh, for comparison with other simulators.

use super::part::{EffectPart, OverlapSpec};
use crate::effect::{CellPoints, EdgeSprings};
use crate::mesh::Order;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::text::quantity::{Modulus, SpringStiffness};
use crate::system::Effect;
use schemars::JsonSchema;
use serde::Deserialize;
use std::sync::Arc;

/// Springs on the edges of a region; exactly one of `stiffness` and `E`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EdgeSpringsSpec {
    /// Region of cells on whose edges the springs are
    pub region: String,
    /// Stiffness of the spring on every edge
    pub stiffness: Option<SpringStiffness>,
    /// Young's modulus that the springs imitate
    #[serde(rename = "E")]
    pub modulus: Option<Modulus>,
    /// Permission to act in cells of another elastic effect, which is refused if absent
    pub overlap: Option<OverlapSpec>,
}

impl EffectPart for EdgeSpringsSpec {
    fn build(&self, place: &str, builder: &mut Builder) -> Result<Box<dyn Effect>, SceneError> {
        let cells = linear_cells(builder, place, &self.region)?;
        let mesh = &builder.body.mesh;
        let positive = |key: &str, value: f64, unit: &str| {
            let fact = || format!("{key} is {value} {unit}");
            if value > 0.0 { Ok(value) } else { Err(builder.content(place, fact(), "give a positive one")) }
        };
        let springs = match (self.stiffness, self.modulus) {
            (Some(k), None) => EdgeSprings::uniform(mesh, cells, positive("stiffness", k.0, "N/m")?),
            (None, Some(e)) => EdgeSprings::of_modulus(mesh, cells, positive("E", e.0, "Pa")?),
            (both, _) => {
                let fact = if both.is_some() { "both `stiffness` and `E`" } else { "neither `stiffness` nor `E`" };
                let remedy =
                    "give `stiffness` (\"20 N/m\", the same on every edge) or `E` (\"100 kPa\", Young's modulus)";
                return Err(builder.content(place, fact, remedy));
            }
        };
        let points = Arc::new(CellPoints::new(mesh, cells));
        builder.gathered.points.push(points);
        Ok(builder.gathered.offer_stiffness(&self.region, springs))
    }

    fn words(&self) -> String {
        match (self.stiffness, self.modulus) {
            (Some(k), _) => format!("region {}, {} N/m on every edge", self.region, k),
            (None, modulus) => format!("region {}, E = {} Pa", self.region, modulus.unwrap_or_default()),
        }
    }

    fn resists(&self) -> Option<(&str, bool)> {
        Some((&self.region, self.overlap.is_some()))
    }

    fn no_limit(&self) -> Option<&'static str> {
        Some(match self.stiffness {
            Some(_) => "springs of one stiffness on every edge stiffen the body as 1/h",
            None => "springs on edges have ν = 1/4 and a stiffness that depends on the directions of the edges",
        })
    }
}

/// The cells of a region; refuses quadratic cells, whose edges have mid-nodes.
pub(super) fn linear_cells<'b>(builder: &'b Builder, place: &str, region: &str) -> Result<&'b [u32], SceneError> {
    if builder.body.mesh.order == Order::Quadratic {
        let fact = "springs on the halves of a straight edge do not hold its mid-node";
        return Err(builder.content(place, fact, "take mesh.element = \"tet4\"; mesh.levels = 1 splits the edges"));
    }
    builder.cells(place, region)
}
