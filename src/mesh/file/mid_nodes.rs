//! Mid-nodes of quadratic cells: each must belong to the right edge, and be the same in both cells of a face.

use crate::math::tensor::Vec3;
use crate::mesh::TetMesh;
use crate::mesh::element::{CELL_EDGES, CELL_FACES};
use crate::mesh::error::MeshError;
use crate::mesh::surface::boundary::{Faces, sorted};
use std::path::Path;

/// Numbers of nodes and cells in a file, for messages.
pub(super) struct Numbers<'a, F: Fn(usize) -> u64> {
    pub file: &'a Path,
    pub nodes: &'a [u64],
    pub cell: F,
}

impl<F: Fn(usize) -> u64> Numbers<'_, F> {
    /// Refuses mid-nodes in the order of another program, in which most cells have mid-nodes at wrong edges.
    pub fn check_order(&self, mesh: &TetMesh) -> Result<(), MeshError> {
        let found: Vec<(usize, [usize; 2])> =
            (0..mesh.cell_count()).filter_map(|c| Some((c, exchanged(mesh, c)?))).collect();
        let (count, cells) = (found.len(), mesh.cell_count());
        let Some(&(c, [own, other])) = found.first().filter(|_| 2 * count > cells) else { return Ok(()) };
        let [edge, at] = [own, other].map(|e| CELL_EDGES[e].map(|k| self.nodes[mesh.cell(c)[k] as usize]));
        let node = self.nodes[mesh.cell(c)[4 + own] as usize];
        Err(MeshError::MidNodeOrder { file: self.file.into(), cell: (self.cell)(c), node, edge, at, count, cells })
    }

    /// Refuses a face whose two cells have different mid-nodes. Cells that share an edge but no face may differ: the edge is then on the two sides of
    /// a slit.
    pub fn check_faces(&self, mesh: &TetMesh, faces: &Faces) -> Result<(), MeshError> {
        for (c, face) in (0..mesh.cell_count()).flat_map(|c| CELL_FACES.iter().map(move |face| (c, face))) {
            let first = faces.0[&sorted([0, 1, 2].map(|k| mesh.cell(c)[face[k]]))].0 as usize;
            if first == c {
                continue;
            }
            for e in CELL_EDGES.iter().zip(4..).filter(|(_, middle)| face.contains(middle)) {
                let (edge, middle) = (e.0.map(|k| mesh.cell(c)[k]), mesh.cell(c)[e.1]);
                let other = middle_of(mesh, first, edge);
                if other != middle {
                    let [a, b, other, middle] = [edge[0], edge[1], other, middle].map(|i| self.nodes[i as usize]);
                    let (file, cells) = (self.file.into(), [first, c].map(&self.cell));
                    return Err(MeshError::MidNodeTwice { file, cells, edge: [a, b], nodes: [other, middle] });
                }
            }
        }
        Ok(())
    }
}

/// Returns the mid-node of the edge of a cell with these ends.
fn middle_of(mesh: &TetMesh, c: usize, ends: [u32; 2]) -> u32 {
    let nodes = mesh.cell(c);
    let e = CELL_EDGES.iter().position(|edge| edge.iter().all(|&k| ends.contains(&nodes[k])));
    nodes[4 + e.expect("both cells have the corners of the face")]
}

/// Returns two edges of a cell whose mid-nodes are closer to the midpoints of these edges, in the sum of squares, if they are exchanged, and the
/// first of which is closer to the midpoint of the second edge. A common motion of both does not matter: in a thin curved wall it is larger than
/// their distance.
fn exchanged(mesh: &TetMesh, c: usize) -> Option<[usize; 2]> {
    let at = |k: usize| mesh.points[mesh.cell(c)[k] as usize];
    let middles: [Vec3; 6] = CELL_EDGES.map(|[a, b]| (at(a) + at(b)) / 2.0);
    let pairs = (0..6).flat_map(|e| (0..e).map(move |f| [f, e]));
    let is_exchanged = |[e, f]: &[usize; 2]| (at(4 + e) - at(4 + f)).dot(&(middles[*e] - middles[*f])) < 0.0;
    let away = |e: usize, f: usize| (at(4 + e) - middles[f]).norm();
    pairs.into_iter().find(is_exchanged).map(|[e, f]| if away(e, f) < away(e, e) { [e, f] } else { [f, e] })
}
