//! Mean position of a region.

use crate::math::tensor::Vec3;
use crate::mesh::{Region, TetMesh};
use crate::system::Gradient;

/// Mean position of a region as weights of nodes: the area mean over its facets; for regions without facets, and for node sets apart from them, the mean of
/// the nodes.
#[derive(Clone, Debug)]
pub struct Mean {
    weights: Vec<(u32, f64)>,
    pub(super) origin: Vec3,
}

impl Mean {
    /// The mean over a region.
    pub fn new(mesh: &TetMesh, region: &Region) -> Self {
        let facets = mesh.facets_of(region);
        let mut weights: Vec<(u32, f64)> = if facets.is_empty() {
            mesh.nodes_of(region).into_iter().map(|k| (k, 1.0)).collect()
        } else {
            mesh.nodal_areas(facets)
        };
        let total: f64 = weights.iter().map(|(_, w)| w).sum();
        weights.iter_mut().for_each(|(_, w)| *w /= total);
        let origin = weights.iter().map(|&(k, w)| mesh.points[k as usize] * w).sum();
        Self { weights, origin }
    }

    /// A point that moves with the given weights of nodes.
    pub(super) fn of_point(origin: Vec3, weights: Vec<(u32, f64)>) -> Self {
        Self { weights, origin }
    }

    /// Gradients of the three coordinates.
    pub(super) fn gradients(&self) -> [Gradient; 3] {
        std::array::from_fn(|i| Gradient::of_displacements(self.along(Vec3::ith(i, 1.0))))
    }

    /// Derivatives of the position, as (unknown, derivative).
    pub(super) fn rates(&self) -> Vec<(u32, Vec3)> {
        self.weights.iter().flat_map(|&(k, w)| (0..3).map(move |i| (3 * k + i, Vec3::ith(i as usize, w)))).collect()
    }

    /// Derivatives of the coordinate along `direction` with respect to the unknowns.
    pub(super) fn along(&self, direction: Vec3) -> Vec<(u32, f64)> {
        let of_node = |&(k, w): &(u32, f64)| (0..3).map(move |i| (3 * k + i, w * direction[i as usize]));
        self.weights.iter().flat_map(of_node).filter(|(_, w)| *w != 0.0).collect()
    }

    /// Mean position at displacement x \[m\].
    pub(super) fn at(&self, x: &[f64]) -> Vec3 {
        self.weights.iter().fold(self.origin, |p, &(k, w)| p + w * Vec3::from_column_slice(&x[3 * k as usize..][..3]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Order;
    use crate::mesh::structured::block;

    /// A node set has the mean of its nodes, even if a surface has its name; with exactly the nodes of the surface it has the mean over the area.
    #[test]
    fn a_node_set_has_the_mean_of_its_own_nodes() {
        let mesh = block(2, 1, 1, 2.0, 1.0, 1.0, Order::Linear);
        let of =
            |nodes: Vec<u32>| Mean::new(&mesh, &Region { nodes, is_node_set: true, ..mesh.regions["xmin"].clone() });
        assert_eq!(of(vec![1]).origin, mesh.points[1]);
        let middle = of(mesh.nodes_of(&mesh.regions["xmin"])).origin;
        assert!((middle - Vec3::new(0.0, 0.5, 0.5)).norm() < 1e-12, "{middle}");
    }
}
