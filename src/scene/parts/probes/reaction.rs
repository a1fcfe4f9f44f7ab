//! Probe `reaction`: `<region>_reaction_{x,y,z}_N`, the sum of the reactions on a region.

use super::part::Probe;
use crate::scene::body::Body;
use crate::scene::build::builder::Builder;
use crate::scene::build::held_rim::HeldRims;
use crate::scene::error::SceneError;
use crate::scene::record::recorder::{Headline, Moment, Recorder};
use crate::system::{Gradient, State};
use schemars::JsonSchema;
use serde::Deserialize;

/// Sum of the reactions on a region.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reaction {
    /// Region that is held or moved
    pub region: String,
}

impl Probe for Reaction {
    fn build(&self, place: &str, builder: &Builder) -> Result<Box<dyn Recorder>, SceneError> {
        let mut nodes = builder.body.mesh.nodes_of(builder.region_with_nodes(place, &self.region)?);
        nodes.sort_unstable();
        Ok(Box::new(Recorded { name: self.region.clone(), nodes, rims: builder.gathered.rims.clone() }))
    }

    fn regions(&self) -> Vec<&str> {
        vec![&self.region]
    }

    fn headline(&self) -> Option<Headline> {
        Some(Headline { column: format!("{}_reaction_x_N", self.region), label: "reaction", symbol: "R", unit: "N" })
    }
}

struct Recorded {
    name: String,
    /// Nodes of the region, ascending
    nodes: Vec<u32>,
    rims: HeldRims,
}

impl Recorded {
    fn has(&self, dof: u32) -> bool {
        self.nodes.binary_search(&(dof / 3)).is_ok()
    }
}

impl Recorder for Recorded {
    fn columns(&self) -> Vec<String> {
        ["x", "y", "z"].map(|c| format!("{}_reaction_{c}_N", self.name)).into()
    }

    fn record(&self, now: &Moment) -> Vec<f64> {
        let of_rims = self.rims.forces(now);
        let sum = |i: u32| -> f64 {
            let residual: f64 = self.nodes.iter().map(|&k| now.residual[(3 * k + i) as usize]).sum();
            let own = of_rims.iter().filter(|(dof, _)| dof % 3 == i && self.has(*dof));
            residual + own.map(|(_, force)| force).sum::<f64>()
        };
        (0..3).map(sum).collect()
    }

    fn gradients(&self, _: &Body, state: &State, _: &[f64]) -> Vec<Option<Gradient>> {
        let along = |i: u32| {
            let reaction = self.nodes.iter().map(|&k| (3 * k + i, 1.0)).collect();
            let mut all = Gradient { reaction, ..Gradient::default() };
            let weight = |dof: u32| if dof % 3 == i && self.has(dof) { 1.0 } else { 0.0 };
            self.rims.add_gradient(state, weight, &mut all);
            Some(all)
        };
        (0..3).map(along).collect()
    }

    fn is_differentiable(&self) -> bool {
        true
    }
}
