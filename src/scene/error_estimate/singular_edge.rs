//! Edges of the body at which displacements are singular.
//!
//! Displacements near an edge go with r^λ (M. L. Williams, *J. Appl. Mech.* 19 (1952) 526–528): λ is down to about 0.3 where a held face meets a free one at a
//! re-entrant edge, ½ where a held face ends on a flat one or the tip of a crack is, and 0.54 at a free edge of 270°. Quantities of the whole body converge with
//! an order of 2λ. Within a cell at the edge a displacement grows with r instead: the cell does not show those nearer to the edge than its size.

use super::indicators::gradients;
use crate::mesh::boundary::boundary_facets;
use crate::mesh::element::FACET_EDGES;
use crate::scene::Scene;
use crate::system::Dofs;
use std::collections::{BTreeSet, HashMap};
use std::f64::consts::{FRAC_PI_3, FRAC_PI_4};

/// Least turn beyond flat \[rad\] of a glued edge.
const LEAST_GLUED: f64 = 0.1;
/// Least turn beyond flat \[rad\] of an edge at which λ is below about 0.6: between faces that are held and free, and that are held alike. A plane of symmetry
/// that meets a free face at a right angle is not singular, nor are facets of a coarse concave surface.
const LEAST_SINGULAR: [f64; 2] = [-FRAC_PI_4, FRAC_PI_3];
/// Turn beyond flat from which an edge is the tip of a crack, whose two faces lie on each other \[rad\].
const CRACK: f64 = 3.1;

/// An edge of the boundary at which displacements are singular.
struct SingularEdge {
    corners: [u32; 2],
    /// Re-entrant, with a face that is held along an axis on one side, and one that is not on the other
    glued: bool,
}

/// All of them.
fn singular_edges(scene: &Scene) -> Vec<SingularEdge> {
    let mesh = &scene.body.mesh;
    let held: BTreeSet<u32> = scene.system.prescribed.iter().map(|p| p.dof).collect();
    let corners = |f: u32| &mesh.facet(f as usize)[..3];
    let is_held = |f: u32| [0, 1, 2].map(|axis| corners(f).iter().all(|node| held.contains(&(3 * node + axis))));
    let mut first: HashMap<[u32; 2], u32> = HashMap::new();
    let mut found = Vec::new();
    for f in boundary_facets(mesh) {
        let nodes = corners(f);
        for [i, j] in FACET_EDGES {
            let edge = [nodes[i].min(nodes[j]), nodes[i].max(nodes[j])];
            let other = *first.entry(edge).or_insert(f);
            if other == f {
                continue;
            }
            let Some(turn) = turn(scene, edge, [f, other]) else { continue };
            let is_border = is_held(f) != is_held(other);
            if turn > LEAST_SINGULAR[usize::from(!is_border)] {
                found.push(SingularEdge { corners: edge, glued: is_border && turn > LEAST_GLUED });
            }
        }
    }
    found
}

/// The inner angle of the body at an edge of two facets, beyond 180° \[rad\].
fn turn(scene: &Scene, edge: [u32; 2], [one, other]: [u32; 2]) -> Option<f64> {
    let mesh = &scene.body.mesh;
    let [start, end] = edge.map(|node| mesh.points[node as usize]);
    let along = (end - start).normalize();
    let away = |f: u32| {
        let third = mesh.facet(f as usize)[..3].iter().find(|node| !edge.contains(node))?;
        let away = mesh.points[*third as usize] - start;
        Some((away - along * away.dot(&along)).normalize())
    };
    let (a, b) = (away(one)?, away(other)?);
    let turn = a.dot(&mesh.facet_normal(other as usize, [1.0 / 3.0; 2]).normalize()).atan2(-a.dot(&b));
    // No body has an inner angle of zero
    Some(if turn < -CRACK { -turn } else { turn })
}

/// Whether a body has an edge of an inner angle above 180° with a face that is held along an axis on one side, and one that is not on the other.
pub(super) fn has_glued_edge(scene: &Scene) -> bool {
    singular_edges(scene).iter().any(|edge| edge.glued)
}

/// \[columns\] whether a column is the displacement of a place in one cell that has a singular edge, as far as it is not prescribed; `memory`: what recorders keep.
pub(super) fn unresolved_columns(scene: &Scene, memory: &[f64]) -> Vec<bool> {
    let mesh = &scene.body.mesh;
    let at_edges: BTreeSet<u32> = singular_edges(scene).iter().flat_map(|edge| edge.corners).collect();
    let cells = (0..mesh.cell_count()).map(|c| mesh.cell(c));
    let near: Vec<&[u32]> = cells.filter(|cell| cell[..4].iter().any(|node| at_edges.contains(node))).collect();
    let is_free = |dof: u32| scene.system.dofs.equation[dof as usize] != Dofs::FIXED;
    let is_near = |x: &[(u32, f64)]| {
        let nodes: BTreeSet<u32> =
            x.iter().filter(|(dof, w)| *w != 0.0 && is_free(*dof)).map(|(dof, _)| dof / 3).collect();
        !nodes.is_empty() && near.iter().any(|cell| nodes.iter().all(|node| cell.contains(node)))
    };
    let all = gradients(scene, &scene.system.rest(), memory);
    all.iter().map(|own| own.as_ref().is_some_and(|own| own.reaction.is_empty() && is_near(&own.x))).collect()
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
