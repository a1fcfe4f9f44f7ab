//! Finds the cells that contain many points, by a bounding volume hierarchy.

use super::TetMesh;
use super::embed::{Embedded, deepest, reach_of};
use crate::math::boxes::{hierarchy, overlapping};
use crate::math::tensor::Vec3;
use parry3d_f64::partitioning::Bvh;

/// The cells of a mesh in a bounding volume hierarchy.
pub(super) struct Locator<'a> {
    mesh: &'a TetMesh,
    cells: Bvh,
}

impl<'a> Locator<'a> {
    /// Builds the hierarchy of all cells.
    pub fn new(mesh: &'a TetMesh) -> Self {
        Self { mesh, cells: hierarchy((0..mesh.cell_count()).map(|c| reach_of(mesh, c))) }
    }

    /// Returns the point as [`super::embed::embed`] finds it; `None` outside the body.
    pub fn locate(&self, at: Vec3) -> Option<Embedded> {
        let near = overlapping(&self.cells, (at, at));
        deepest(self.mesh, near.into_iter().map(|c| c as usize), at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Order;
    use crate::mesh::embed::embed;
    use crate::mesh::made::disturb::distort;
    use crate::mesh::made::structured::block;

    /// For every node, every centre of a cell and points outside, the result equals that of a search through all cells.
    #[test]
    fn the_answer_is_that_of_all_cells() {
        for order in [Order::Linear, Order::Quadratic] {
            let mut mesh = block(4, 3, 2, 0.04, 0.03, 0.02, order);
            distort(&mut mesh, 3, 0.15);
            let locator = Locator::new(&mesh);
            let middles = (0..mesh.cell_count()).map(|c| mesh.position(c, [0.25; 3]));
            let outside = [[-0.001, 0.01, 0.01], [0.05, 0.01, 0.01]].map(Vec3::from);
            for at in mesh.points.iter().copied().chain(middles).chain(outside) {
                assert_eq!(locator.locate(at), embed(&mesh, at).ok(), "{at}");
            }
        }
    }
}
