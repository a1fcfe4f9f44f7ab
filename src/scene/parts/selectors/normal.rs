//! Selector `normal`: the facets that face in a direction.

use super::part::{Ground, Refusal, SelectedEntities, SelectorPart};
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

/// Angle between facets below which they belong to one smooth surface \[rad\].
const SMOOTH: f64 = 0.7;

/// Boundary facets whose outward normal is within `angle` of `direction`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NormalSelector {
    /// Direction with which the normal is compared; its length does not matter
    pub direction: [f64; 3],
    /// Largest angle between the two, from 0 to 180 deg
    pub angle: Angle,
}

impl SelectorPart for NormalSelector {
    fn find(&self, ground: &Ground) -> Result<SelectedEntities, Refusal> {
        let degrees = self.angle.0.to_degrees();
        if !(0.0..=180.0).contains(&degrees) {
            let fact = format!("the angle is {} deg", shown(degrees));
            return Err(Refusal::new(fact, "the angle between two directions is from 0 to 180 deg"));
        }
        let entities = facing(ground.mesh, &direction("direction", &self.direction)?, self.angle.0);
        let (is_smooth, is_flat) = border(ground.mesh, &entities);
        // The parts of a flat facet face the same way as the facet: the border is the same on all levels of one file
        let is_kept = is_smooth && is_flat && ground.levels.is_some();
        let note = "`levels` keep its border, which runs where facets of the file meet; other files of a round body have another one";
        Ok(SelectedEntities {
            pick: Pick::Facets,
            entities,
            depends_on_mesh: is_smooth && !(is_kept && ground.levels > Some(0)),
            note: is_kept.then(|| note.into()),
        })
    }

    fn words(&self) -> String {
        let [x, y, z] = self.direction;
        format!("the normal [{x}, {y}, {z}] within {} deg", shown(self.angle.0.to_degrees()))
    }
}

/// Whether these facets end where the surface continues smoothly, so that their extent differs on another mesh; and whether all facets at such a border are
/// flat.
fn border(mesh: &TetMesh, taken: &[u32]) -> (bool, bool) {
    let normal = |f: u32| mesh.facet_normal(f as usize, [1.0 / 3.0; 2]).normalize();
    let mut first: HashMap<[u32; 2], u32> = HashMap::new();
    let (mut is_smooth, mut is_flat) = (false, true);
    for f in boundary_facets(mesh) {
        let nodes = mesh.facet(f as usize);
        for [i, j] in FACET_EDGES {
            let ends = [nodes[i].min(nodes[j]), nodes[i].max(nodes[j])];
            let other = *first.entry(ends).or_insert(f);
            let is_border = taken.binary_search(&f).is_ok() != taken.binary_search(&other).is_ok();
            if is_border && normal(f).dot(&normal(other)) > SMOOTH.cos() {
                is_smooth = true;
                is_flat &= [f, other].iter().all(|&f| has_one_normal(mesh, f));
            }
        }
    }
    (is_smooth, is_flat)
}

/// Whether the normals of a facet at its corners are the same, to rounding.
fn has_one_normal(mesh: &TetMesh, f: u32) -> bool {
    let at = |xi: [f64; 2]| mesh.facet_normal(f as usize, xi).normalize();
    let [a, b, c] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(at);
    a.dot(&b) > 1.0 - 1e-12 && a.dot(&c) > 1.0 - 1e-12
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::statistics::larger;
    use crate::mesh::Order;
    use crate::mesh::curved::cylinder;
    use crate::mesh::enrich::Enriched;
    use std::collections::BTreeMap;
    use std::path::Path;

    /// A border on a round surface depends on the mesh, but not where the cells of a file with flat facets are split.
    #[test]
    fn the_border_between_flat_facets_is_the_same_on_all_levels() {
        let selector = NormalSelector { direction: [1.0, 0.2, 0.0], angle: Angle(0.9) };
        for (order, is_kept) in [(Order::Linear, true), (Order::Quadratic, false)] {
            let mut mesh = cylinder(0.01, 0.03, 4, 2, order);
            let mut areas = vec![];
            for level in 0..3 {
                let found = |levels: Option<u32>| {
                    let ground = Ground { mesh: &mesh, levels, base: Path::new(""), regions: &BTreeMap::new() };
                    selector.find(&ground).unwrap_or_else(|refusal| panic!("{}", refusal.fact))
                };
                assert!(found(None).depends_on_mesh && found(None).note.is_none());
                let own = found(Some(level));
                assert_eq!(own.depends_on_mesh, !(is_kept && level > 0), "{order:?}, level {level}");
                assert_eq!(own.note.is_some(), is_kept);
                areas.push(own.entities.iter().map(|&f| mesh.facet_area(f as usize)).sum::<f64>());
                mesh = Enriched::by_splitting(&mesh).mesh;
            }
            let off = areas.iter().map(|area| (area / areas[0] - 1.0).abs()).fold(0.0, larger);
            assert_eq!(off < 1e-12, is_kept, "{order:?}: {areas:?}");
        }
    }
}
