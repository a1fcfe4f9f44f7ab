//! Choice of the nodes at which an imported body is held: a region of the file whose name says so, else the wide ends of its components.

use crate::math::tensor::Vec3;
use crate::mesh::TetMesh;
use std::collections::{BTreeMap, BTreeSet};

/// Parts of names of regions that tell where a robot is held.
const HOLDS: [&str; 10] = ["fix", "root", "base", "held", "clamp", "ground", "bottom", "mount", "encastre", "support"];
/// Largest share of the nodes that a region may hold to be taken for a fixture.
const MOST: f64 = 0.5;
/// Thickness of the slab that is held, as a share of the length of the component.
const SLAB: f64 = 0.05;
/// The nodes that are held.
pub enum Held {
    /// A region of the file
    Region(String),
    /// A slab at the end of each component: lower and upper corner \[m\], and the axis along which the component is longest
    Slabs(Vec<(Vec3, Vec3, usize)>),
}

/// A region whose name says that the body is held there and that all components have nodes of, else slabs at ends. `of_cells` are the
/// components by [`crate::mesh::parts::parts`].
pub(super) fn held(mesh: &TetMesh, of_cells: &[u32]) -> Held {
    let mut component = vec![0u32; mesh.points.len()];
    let mut nodes: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (c, &part) in of_cells.iter().enumerate() {
        mesh.cell(c).iter().for_each(|&i| component[i as usize] = part);
    }
    component.iter().enumerate().for_each(|(i, &part)| nodes.entry(part).or_default().push(i as u32));
    for word in HOLDS {
        for (name, region) in mesh.regions.iter().filter(|(name, _)| name.to_lowercase().contains(word)) {
            let inside = mesh.nodes_of(region);
            let reached: BTreeSet<u32> = inside.iter().map(|&i| component[i as usize]).collect();
            if reached.len() == nodes.len()
                && (inside.len() as f64) < MOST * mesh.points.len() as f64
                && inside.len() > 2
            {
                return Held::Region(name.clone());
            }
        }
    }
    Held::Slabs(nodes.values().map(|nodes| slab(mesh, nodes)).collect())
}

/// The end of a component, along its longest axis, that has more nodes: its widest one. At least three nodes that span a plane are in it.
fn slab(mesh: &TetMesh, nodes: &[u32]) -> (Vec3, Vec3, usize) {
    let at = |i: &u32| mesh.points[*i as usize];
    let start = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    let (low, high) = nodes.iter().map(at).fold(start, |(a, b), p| (a.inf(&p), b.sup(&p)));
    let size = high - low;
    let axis = size.imax();
    let mut share = SLAB;
    loop {
        let depth = share * size[axis];
        let first: Vec<Vec3> = nodes.iter().map(at).filter(|p| p[axis] <= low[axis] + depth).collect();
        let last: Vec<Vec3> = nodes.iter().map(at).filter(|p| p[axis] >= high[axis] - depth).collect();
        let (inside, at_low) = if first.len() >= last.len() { (first, true) } else { (last, false) };
        if share > 0.5 || spans_a_plane(&inside) {
            // Against rounding in the text
            let margin = Vec3::repeat(1e-4 * size.norm());
            let (mut a, mut b) = (low - margin, high + margin);
            match at_low {
                true => b[axis] = low[axis] + depth,
                false => a[axis] = high[axis] - depth,
            }
            return (a, b, axis);
        }
        share *= 1.5;
    }
}

/// Whether three of the points are on no common line.
fn spans_a_plane(points: &[Vec3]) -> bool {
    let Some(first) = points.first() else { return false };
    let far = points.iter().max_by(|a, b| (*a - first).norm().total_cmp(&(*b - first).norm())).expect("not empty");
    let along = far - first;
    points.iter().any(|p| (p - first).cross(&along).norm() > 0.05 * along.norm_squared())
}
