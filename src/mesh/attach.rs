//! A surface that follows the body: every vertex as a weighted mean of nodes, also where it is a little outside.
//!
//! Inside, the weights are the shape functions of the cell that holds the vertex. Outside, up to `reach`, they continue
//! the cell of the nearest facet linearly by its four corners. Both have Σ w = 1 and Σ w_i X_i = X: affine motions are
//! followed exactly.

use super::TetMesh;
use super::boundary::{boundary_facets, facet_cells};
use super::embed::{EmbedError, distance_to_facet, locate};
use crate::math::tensor::{Mat3, Vec3};
use rayon::prelude::*;

/// (node, weight) of each point; the first that is further out than `reach` \[m\] is refused.
pub fn attach(mesh: &TetMesh, points: &[Vec3], reach: f64) -> Result<Vec<Vec<(u32, f64)>>, EmbedError> {
    attach_each(mesh, points, reach).into_iter().collect()
}

/// The same with a refusal for each point that is further out.
pub fn attach_each(mesh: &TetMesh, points: &[Vec3], reach: f64) -> Vec<Result<Vec<(u32, f64)>, EmbedError>> {
    let cells = facet_cells(mesh);
    let boundary: Vec<u32> = boundary_facets(mesh);
    let one = |at: &Vec3| {
        if let Some(inside) = locate(mesh, *at) {
            return Ok(inside.weights);
        }
        let distances = boundary.iter().map(|&f| (distance_to_facet(mesh, f, *at), f));
        let (distance, facet) = distances.min_by(|a, b| a.0.total_cmp(&b.0)).expect("a body has a surface");
        if distance > reach {
            return Err(EmbedError::Outside { at: *at, distance });
        }
        Ok(continued(mesh, cells[facet as usize].0 as usize, *at))
    };
    points.par_iter().map(one).collect()
}

/// Barycentric coordinates by the corners of the cell, some of them negative.
fn continued(mesh: &TetMesh, cell: usize, at: Vec3) -> Vec<(u32, f64)> {
    let nodes = &mesh.cell(cell)[..4];
    let p = |k: usize| mesh.points[nodes[k] as usize];
    let edges = Mat3::from_columns(&[p(1) - p(0), p(2) - p(0), p(3) - p(0)]);
    let xi = edges.try_inverse().expect("a checked mesh has no flat cell") * (at - p(0));
    let weights = [1.0 - xi.sum(), xi.x, xi.y, xi.z];
    nodes.iter().copied().zip(weights).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Order;
    use crate::mesh::disturb::distort;
    use crate::mesh::structured::block;

    /// Inside, on the surface and 0.5 mm outside: Σ w = 1 and Σ w X = X to rounding, so every affine motion is followed.
    #[test]
    fn affine_motions_are_followed_inside_and_outside() {
        for order in [Order::Linear, Order::Quadratic] {
            let mut mesh = block(3, 2, 2, 0.03, 0.02, 0.02, order);
            distort(&mut mesh, 3, 0.1);
            let points = [[0.011, 0.007, 0.013], [0.03, 0.01, 0.01], [0.0305, 0.012, 0.004], [0.01, 0.0203, -0.0002]];
            let points = points.map(Vec3::from);
            let weights = attach(&mesh, &points, 0.001).expect("near enough");
            for (at, weights) in points.iter().zip(&weights) {
                let sum: f64 = weights.iter().map(|w| w.1).sum();
                let mean: Vec3 = weights.iter().map(|&(k, w)| mesh.points[k as usize] * w).sum();
                assert!((sum - 1.0).abs() < 1e-13 && (mean - at).norm() < 1e-14, "{order:?}: {sum}, {mean}");
            }
            let far = attach(&mesh, &[Vec3::new(0.032, 0.01, 0.01)], 0.001).expect_err("2 mm outside");
            assert!(matches!(far, EmbedError::Outside { distance, .. } if (distance - 0.002).abs() < 1e-12));
        }
    }
}
