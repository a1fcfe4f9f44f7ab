//! Probe `moment`: `<region>_moment_{x,y,z}_Nm`, the resultant moment of the reactions on a region.

use super::mean::Mean;
use super::part::Probe;
use crate::math::tensor::Vec3;
use crate::scene::build::builder::Builder;
use crate::scene::build::held_rim::HeldRims;
use crate::scene::error::SceneError;
use crate::scene::record::recorder::{Headline, Moment, Recorder};
use crate::scene::text::quantity::Length;
use schemars::JsonSchema;
use serde::Deserialize;

/// Resultant moment of the reactions on a region.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReactionMoment {
    /// Region that is held or moved
    pub region: String,
    /// Point fixed in space about which the moment is taken; if absent, the mean position of the region, which moves
    pub about: Option<[Length; 3]>,
}

impl Probe for ReactionMoment {
    fn build(&self, place: &str, builder: &Builder) -> Result<Box<dyn Recorder>, SceneError> {
        let (mesh, region) = (&builder.body.mesh, builder.region_with_nodes(place, &self.region)?);
        let about = self.about.as_ref().map(|p| Vec3::new(p[0].0, p[1].0, p[2].0));
        let (mut nodes, middle) = (mesh.nodes_of(region), Mean::new(mesh, region));
        nodes.sort_unstable();
        let rims = builder.gathered.rims.clone();
        Ok(Box::new(Recorded { name: self.region.clone(), nodes, about, middle, rims }))
    }

    fn regions(&self) -> Vec<&str> {
        vec![&self.region]
    }

    fn headline(&self) -> Option<Headline> {
        Some(Headline { column: format!("{}_moment_x_Nm", self.region), label: "moment", symbol: "M", unit: "N m" })
    }
}

struct Recorded {
    name: String,
    /// Nodes of the region, ascending
    nodes: Vec<u32>,
    /// Fixed point about which the moment is taken \[m\]
    about: Option<Vec3>,
    middle: Mean,
    rims: HeldRims,
}

impl Recorder for Recorded {
    fn columns(&self) -> Vec<String> {
        ["x", "y", "z"].map(|c| format!("{}_moment_{c}_Nm", self.name)).into()
    }

    /// The moment Σ (x − x₀) × r.
    fn record(&self, now: &Moment) -> Vec<f64> {
        let of_node = |values: &[f64], k: u32| Vec3::from_column_slice(&values[3 * k as usize..][..3]);
        let about = self.about.unwrap_or_else(|| self.middle.at(&now.state.x));
        let arm = |k: u32| now.body.mesh.points[k as usize] + of_node(&now.state.x, k) - about;
        let of_residual: Vec3 = self.nodes.iter().map(|&k| arm(k).cross(&of_node(now.residual, k))).sum();
        let of_rim = |(dof, force): (u32, f64)| {
            let along = Vec3::from_fn(|i, _| if i as u32 == dof % 3 { force } else { 0.0 });
            arm(dof / 3).cross(&along)
        };
        let rims = self.rims.forces(now).into_iter().filter(|(dof, _)| self.nodes.binary_search(&(dof / 3)).is_ok());
        (of_residual + rims.map(of_rim).sum::<Vec3>()).as_slice().to_vec()
    }
}
