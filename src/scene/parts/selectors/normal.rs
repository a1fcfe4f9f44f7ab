//! Selector `normal`: the facets that look in a direction.

use super::part::{Found, Ground, Refusal, SelectorPart};
use super::place::direction;
use crate::math::units::shown;
use crate::mesh::TetMesh;
use crate::mesh::boundary::boundary_facets;
use crate::mesh::element::FACET_EDGES;
use crate::mesh::select::{Pick, facing};
use crate::scene::text::quantity::Angle;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::HashMap;

/// Facets that meet at less than this angle are of one smooth surface \[rad\].
const SMOOTH: f64 = 0.7;

/// Boundary facets whose outward normal is within `angle` of `direction`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NormalSelector {
    /// Direction that the normal is compared with; its length does not count
    pub direction: [f64; 3],
    /// Largest angle between them, from 0 to 180 deg
    pub angle: Angle,
}

impl SelectorPart for NormalSelector {
    fn find(&self, ground: &Ground) -> Result<Found, Refusal> {
        let degrees = self.angle.0.to_degrees();
        if !(0.0..=180.0).contains(&degrees) {
            let fact = format!("the angle is {} deg", shown(degrees));
            return Err(Refusal::new(fact, "the angle between two directions is from 0 to 180 deg"));
        }
        let entities = facing(ground.mesh, &direction("direction", &self.direction)?, self.angle.0);
        let depends_on_mesh = ends_on_smooth_surface(ground.mesh, &entities);
        Ok(Found { pick: Pick::Facets, entities, depends_on_mesh, note: None })
    }

    fn words(&self) -> String {
        let [x, y, z] = self.direction;
        format!("the normal [{x}, {y}, {z}] within {} deg", shown(self.angle.0.to_degrees()))
    }
}

/// Whether these facets end where the surface goes on smoothly, so that another mesh has another extent.
fn ends_on_smooth_surface(mesh: &TetMesh, taken: &[u32]) -> bool {
    let normal = |f: u32| mesh.facet_normal(f as usize, [1.0 / 3.0; 2]).normalize();
    let mut first: HashMap<[u32; 2], u32> = HashMap::new();
    for f in boundary_facets(mesh) {
        let nodes = mesh.facet(f as usize);
        for [i, j] in FACET_EDGES {
            let ends = [nodes[i].min(nodes[j]), nodes[i].max(nodes[j])];
            let other = *first.entry(ends).or_insert(f);
            let is_border = taken.binary_search(&f).is_ok() != taken.binary_search(&other).is_ok();
            if is_border && normal(f).dot(&normal(other)) > SMOOTH.cos() {
                return true;
            }
        }
    }
    false
}
