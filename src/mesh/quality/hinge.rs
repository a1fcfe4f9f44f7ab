//! Parts of a mesh that are connected only at edges or single nodes, about which they can rotate as about a hinge.

use crate::math::tensor::Vec3;
use crate::mesh::TetMesh;
use crate::mesh::made::parts::parts_by_faces;
use std::collections::BTreeSet;

/// Parts without a common face that have nodes in common.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Hinge {
    /// Number of these parts
    pub parts: usize,
    /// Number of their common corners
    pub nodes: usize,
    /// Position of one of these corners \[m\]
    pub at: Vec3,
}

/// Returns the hinges of a mesh; `None` if parts share faces or nothing.
pub fn hinge(mesh: &TetMesh) -> Option<Hinge> {
    let mut owners = vec![None; mesh.points.len()];
    let (mut nodes, mut parts) = (BTreeSet::new(), BTreeSet::new());
    for (part, cell) in parts_by_faces(mesh).into_iter().zip(mesh.cells.chunks_exact(mesh.order.cell_nodes())) {
        for &node in &cell[..4] {
            let owner = *owners[node as usize].get_or_insert(part);
            if owner != part {
                nodes.insert(node);
                parts.extend([owner, part]);
            }
        }
    }
    let at = mesh.points[*nodes.first()? as usize];
    Some(Hinge { parts: parts.len(), nodes: nodes.len(), at })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Order;
    use crate::mesh::structured::block;
    use std::collections::BTreeMap;

    /// Of a cube of eight boxes, two remain that share an edge, a corner, a face or nothing.
    #[test]
    fn parts_with_a_common_edge_or_node_are_found() {
        for order in [Order::Linear, Order::Quadratic] {
            let whole = block(2, 2, 2, 2.0, 2.0, 2.0, order);
            let found = |kept: &[[bool; 3]]| {
                let is_kept = |cell: &&[u32]| {
                    let middle = cell[..4].iter().map(|&node| whole.points[node as usize]).sum::<Vec3>() / 4.0;
                    kept.contains(&[0, 1, 2].map(|k| middle[k] > 1.0))
                };
                let cells = whole.cells.chunks_exact(order.cell_nodes()).filter(is_kept).flatten().copied().collect();
                hinge(&TetMesh { cells, facets: vec![], regions: BTreeMap::new(), ..whole.clone() })
            };
            let first = [false; 3];
            let edge = found(&[first, [true, true, false]]).expect("a common edge");
            assert_eq!((edge.parts, edge.nodes, edge.at.x, edge.at.y), (2, 2, 1.0, 1.0));
            let node = Hinge { parts: 2, nodes: 1, at: Vec3::repeat(1.0) };
            assert_eq!(found(&[first, [true; 3]]), Some(node));
            assert_eq!(found(&[first, [true, false, false]]), None);
            assert_eq!(found(&[first]), None);
        }
    }
}
