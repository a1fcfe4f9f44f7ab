//! Edges of the body at which displacements are singular.
//!
//! Displacements near an edge vary as r^λ (M. L. Williams, *J. Appl. Mech.* 19 (1952) 526–528). λ is as small as about 0.3 where a held face and a free one
//! form a re-entrant edge, ½ where a held face ends on a flat one and at the tip of a crack, 0.54 at a free edge of 270°, and 0.6 (ν = ½) to 0.71 (ν = 0.3)
//! where a clamped face and a free one form a right angle. Quantities of the whole body converge with an order of 2λ. Within a cell at the edge, however, a
//! displacement is linear in r: the cell does not resolve displacements nearer to the edge than its size.

use crate::mesh::Region;
use crate::mesh::boundary::boundary_facets;
use crate::mesh::element::FACET_EDGES;
use crate::scene::Scene;
use crate::scene::spec::ConstraintSpec;
use std::collections::{BTreeSet, HashMap};
use std::f64::consts::{FRAC_PI_3, FRAC_PI_4, PI};

/// Smallest inner angle beyond 180° of a glued edge \[rad\].
const LEAST_GLUED: f64 = 0.1;
/// Smallest inner angle beyond 180° of a singular edge between a clamped face and a free one \[rad\]: from 75° on, λ is 0.8 or less.
const LEAST_CLAMPED: f64 = -7.0 / 12.0 * PI;
/// Smallest inner angle beyond 180° of a singular edge between faces that are held along different axes \[rad\], where λ is below about 0.6. A plane of
/// symmetry at a right angle to a free or a clamped face is not singular.
const LEAST_BORDER: f64 = -FRAC_PI_4;
/// Smallest inner angle beyond 180° of a singular edge between faces that are held along the same axes \[rad\]. Edges between facets of a coarse concave
/// surface are below it.
const LEAST_ALIKE: f64 = FRAC_PI_3;
/// Inner angle beyond 180° from which an edge is the tip of a crack, whose two faces coincide \[rad\].
const CRACK: f64 = 3.1;
/// Smallest sum of the squared components of a direction along held axes with which the direction counts as held.
const HELD: f64 = 0.99;

/// An edge of the boundary at which displacements are singular.
struct SingularEdge {
    corners: [u32; 2],
    /// Whether the edge is re-entrant and its two faces are held along different axes
    glued: bool,
}

/// The axes along which constraints hold the facets of a mesh.
struct Held<'a> {
    scene: &'a Scene,
    /// Facets of regions → held axes
    facets: HashMap<u32, [bool; 3]>,
    /// Nodes of regions that are not given by facets → held axes
    nodes: HashMap<u32, [bool; 3]>,
}

impl<'a> Held<'a> {
    fn new(scene: &'a Scene) -> Self {
        let (mut facets, mut nodes) = (HashMap::new(), HashMap::new());
        for (name, components) in scene.spec.constraints.iter().filter_map(ConstraintSpec::held) {
            let Some(region) = scene.regions.get(name) else { continue };
            let others = Region { facets: vec![], ..region.clone() };
            for axis in (0..3).filter(|&axis| components.contains(["x", "y", "z"][axis])) {
                let hold = |of: &mut HashMap<u32, [bool; 3]>, k: u32| of.entry(k).or_default()[axis] = true;
                scene.body.mesh.facets_of(region).iter().for_each(|&f| hold(&mut facets, f));
                scene.body.mesh.nodes_of(&others).into_iter().for_each(|node| hold(&mut nodes, node));
            }
        }
        Self { scene, facets, nodes }
    }

    /// The axes along which a facet is held: by a region of facets that contains it, or by regions that contain all its nodes. A free facet in a corner may
    /// have three corners on held faces, but then not all nodes between them.
    fn along(&self, facet: u32) -> [bool; 3] {
        let of = |all: &HashMap<u32, [bool; 3]>, k: &u32| all.get(k).copied().unwrap_or_default();
        let own = of(&self.facets, &facet);
        let nodes = self.scene.body.mesh.facet(facet as usize);
        [0, 1, 2].map(|axis| own[axis] || nodes.iter().all(|node| of(&self.nodes, node)[axis]))
    }

    /// The number of directions perpendicular to an edge in which a facet is fixed if it is held along these axes.
    fn across(&self, [start, end]: [u32; 2], held: [bool; 3]) -> usize {
        let points = &self.scene.body.mesh.points;
        let edge = (points[end as usize] - points[start as usize]).normalize();
        let of_edge: f64 = (0..3).filter(|&axis| held[axis]).map(|axis| edge[axis] * edge[axis]).sum();
        held.iter().filter(|held| **held).count() - usize::from(of_edge > HELD)
    }
}

/// All singular edges of a scene. With linear cells, whether a facet is held can only be seen on the mesh with nodes between their corners.
fn singular_edges(scene: &Scene) -> Vec<SingularEdge> {
    let mesh = &scene.body.mesh;
    let held = Held::new(scene);
    let mut first: HashMap<[u32; 2], u32> = HashMap::new();
    let mut found = Vec::new();
    for f in boundary_facets(mesh) {
        let nodes = &mesh.facet(f as usize)[..3];
        for [i, j] in FACET_EDGES {
            let edge = [nodes[i].min(nodes[j]), nodes[i].max(nodes[j])];
            let other = *first.entry(edge).or_insert(f);
            if other == f {
                continue;
            }
            let Some(turn) = turn(scene, edge, [f, other]) else { continue };
            let both = [f, other].map(|facet| held.along(facet));
            let is_border = both[0] != both[1];
            let least = match both.map(|axes| held.across(edge, axes)) {
                [0, 2] | [2, 0] => LEAST_CLAMPED,
                _ if is_border => LEAST_BORDER,
                _ => LEAST_ALIKE,
            };
            if turn > least {
                found.push(SingularEdge { corners: edge, glued: is_border && turn > LEAST_GLUED });
            }
        }
    }
    found
}

/// The inner angle of the body at the edge of two facets, minus 180° \[rad\].
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

/// Whether a body has an edge with an inner angle above 180° between two faces that are held along different axes.
pub fn has_glued_edge(scene: &Scene) -> bool {
    singular_edges(scene).iter().any(|edge| edge.glued)
}

/// The corners at the ends of singular edges.
pub(super) fn singular_corners(scene: &Scene) -> BTreeSet<u32> {
    singular_edges(scene).iter().flat_map(|edge| edge.corners).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parse_scene;

    /// A bracket is held at its inner face, which ends at the re-entrant edge, or at the end of an arm, which does not.
    #[test]
    fn only_faces_at_the_inner_edge_count() {
        let scene = |region: &str, more: &str| {
            let text = format!(
                "[mesh]\ngrid = {{ kind = \"bracket\", edge = \"20 mm\", thickness = \"5 mm\", divisions = [2, 1] }}\nelement = \"tet10\"\n\
                 [mesh.regions]\ninner = {{ kind = \"plane\", point = [\"10 mm\", \"0 mm\", \"0 mm\"], normal = [1, 0, 0], \
                 tolerance = \"0.01 mm\", pick = \"facets\", rule = \"all\" }}\n[laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\n\
                 nu = 0.3\n[[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n[[constraint]]\nkind = \"fixed\"\n\
                 region = \"{region}\"\n{more}[[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n"
            );
            parse_scene(&text).unwrap_or_else(|e| panic!("{e}"))
        };
        let of = |region: &str, more: &str| has_glued_edge(&scene(region, more));
        let plane_strain = "[[constraint]]\nkind = \"fixed\"\nregion = \"body\"\ncomponents = \"z\"\n";
        assert!(of("inner", "") && of("inner", plane_strain));
        assert!(!of("xmax", "") && !of("zmin", "") && !of("xmax", plane_strain));
        // A node set of one node does not hold a face, even if a surface has its name
        let mut marked = scene("inner", "");
        let node = marked.body.mesh.facet(marked.regions["inner"].facets[0] as usize)[0];
        let inner = marked.regions.get_mut("inner").expect("a region of the scene");
        (inner.nodes, inner.is_node_set) = (vec![node], true);
        assert!(!has_glued_edge(&marked));
    }
}
