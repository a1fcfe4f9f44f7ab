//! Re-entrant edges at which a held face meets a free one.
//!
//! Displacements near such an edge go with r^λ, λ down to about 0.3 (M. L. Williams, *J. Appl. Mech.* 19 (1952) 526–528), while λ is at least ½ where the
//! held face ends on a flat one. Quantities converge with an order of 2λ.

use crate::mesh::boundary::boundary_facets;
use crate::mesh::element::FACET_EDGES;
use crate::scene::Scene;
use std::collections::{BTreeSet, HashMap};

/// Sine of the angle by which two faces must be more than flat.
const LEAST_SINE: f64 = 0.1;

/// Whether a body has an edge of an inner angle above 180° with a face that is held along an axis on one side, and one that is not on the other.
pub(super) fn has_glued_edge(scene: &Scene) -> bool {
    let mesh = &scene.body.mesh;
    let held: BTreeSet<u32> = scene.system.prescribed.iter().map(|p| p.dof).collect();
    let corners = |f: u32| &mesh.facet(f as usize)[..3];
    let is_held = |f: u32| [0, 1, 2].map(|axis| corners(f).iter().all(|node| held.contains(&(3 * node + axis))));
    let mut first: HashMap<[u32; 2], u32> = HashMap::new();
    for f in boundary_facets(mesh) {
        let nodes = corners(f);
        for [i, j] in FACET_EDGES {
            let [a, b] = [nodes[i].min(nodes[j]), nodes[i].max(nodes[j])];
            let other = *first.entry([a, b]).or_insert(f);
            if other == f || is_held(f) == is_held(other) {
                continue;
            }
            let [start, end] = [a, b].map(|node| mesh.points[node as usize]);
            let Some(third) = nodes.iter().find(|node| **node != a && **node != b) else { continue };
            let along = (end - start).normalize();
            let away = mesh.points[*third as usize] - start;
            let away = (away - along * away.dot(&along)).normalize();
            if away.dot(&mesh.facet_normal(other as usize, [1.0 / 3.0; 2]).normalize()) > LEAST_SINE {
                return true;
            }
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parse_scene;

    /// A bracket is held at its inner face, which ends at the re-entrant edge, or at the end of an arm, which does not.
    #[test]
    fn only_faces_at_the_inner_edge_count() {
        let of = |region: &str, more: &str| {
            let text = format!(
                "[mesh]\ngrid = {{ kind = \"bracket\", edge = \"20 mm\", thickness = \"5 mm\", divisions = [2, 1] }}\nelement = \"tet10\"\n\
                 [mesh.regions]\ninner = {{ kind = \"plane\", point = [\"10 mm\", \"0 mm\", \"0 mm\"], normal = [1, 0, 0], \
                 tolerance = \"0.01 mm\", pick = \"facets\", rule = \"all\" }}\n[laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\n\
                 nu = 0.3\n[[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n[[constraint]]\nkind = \"fixed\"\n\
                 region = \"{region}\"\n{more}[[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n"
            );
            has_glued_edge(&parse_scene(&text).unwrap_or_else(|e| panic!("{e}")))
        };
        let plane_strain = "[[constraint]]\nkind = \"fixed\"\nregion = \"body\"\ncomponents = \"z\"\n";
        assert!(of("inner", "") && of("inner", plane_strain));
        assert!(!of("xmax", "") && !of("zmin", "") && !of("xmax", plane_strain));
    }
}
