//! A surface that follows the body: every vertex is a weighted mean of nodes, even if it is slightly outside.
//!
//! Inside, the weights are the shape functions of the cell that contains the vertex. Outside, up to `reach`, they extrapolate the cell of the nearest
//! facet linearly from its four corners. Both satisfy Σ w = 1 and Σ w_i X_i = X: affine motions are followed exactly.

use super::boundary::{boundary_facets, facet_cells};
use super::distance::Nearest;
use super::flat::{flat_triangles, pieces};
use crate::math::tensor::{Mat3, Vec3};
use crate::math::threads;
use crate::mesh::TetMesh;
use crate::mesh::embed::EmbedError;
use crate::mesh::error::point;
use crate::mesh::file::surface_file::Surface;
use crate::mesh::locator::Locator;

/// Number of points that one thread handles at a time.
const POINTS: usize = 256;

/// A vertex of a surface, with the nodes that move it.
#[derive(Clone, Debug, PartialEq)]
pub struct Attached {
    /// (node, weight), Σ w = 1
    pub weights: Vec<(u32, f64)>,
    /// Distance from the body \[m\], zero inside
    pub outside: f64,
}

/// Error for vertices that are farther outside than allowed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{count} of {of} vertices are further outside of the body than reach = {} mm, the furthest by {:.4} mm at {}; move the surface, or give a \
         larger `reach`", reach * 1e3, distance * 1e3, point(at))]
pub struct TooFar {
    pub count: usize,
    pub of: usize,
    /// \[m\]
    pub reach: f64,
    /// Distance of the farthest vertex \[m\]
    pub distance: f64,
    pub at: Vec3,
}

/// Rounding of a distance, relative to the diagonal of the body.
const ROUNDING: f64 = 1e-9;

/// Whether a point at this distance from the body \[m\] is farther outside than `reach` \[m\], rounding apart.
pub fn is_beyond(mesh: &TetMesh, distance: f64, reach: f64) -> bool {
    distance > reach + ROUNDING * mesh.diagonal()
}

/// Returns the nodes of each point; refuses points that are farther outside than `reach` \[m\].
pub fn attach(mesh: &TetMesh, points: &[Vec3], reach: f64) -> Result<Vec<Attached>, TooFar> {
    let all = attached(mesh, points);
    let far = all.iter().zip(points).filter(|(a, _)| is_beyond(mesh, a.outside, reach));
    let count = far.clone().count();
    match far.max_by(|a, b| a.0.outside.total_cmp(&b.0.outside)) {
        None => Ok(all),
        Some((a, &at)) => Err(TooFar { count, of: points.len(), reach, distance: a.outside, at }),
    }
}

/// Returns (node, weight) for each point, or a refusal if it is farther outside than `reach` \[m\].
pub fn attach_each(mesh: &TetMesh, points: &[Vec3], reach: f64) -> Vec<Result<Vec<(u32, f64)>, EmbedError>> {
    let refused = |(a, &at): (Attached, &Vec3)| match is_beyond(mesh, a.outside, reach) {
        true => Err(EmbedError::Outside { at, distance: a.outside }),
        false => Ok(a.weights),
    };
    attached(mesh, points).into_iter().zip(points).map(refused).collect()
}

fn attached(mesh: &TetMesh, points: &[Vec3]) -> Vec<Attached> {
    let cells = facet_cells(mesh);
    let boundary = boundary_facets(mesh);
    let triangles = flat_triangles(mesh, &boundary);
    let surface = Surface { points: mesh.points.clone(), triangles };
    let nearest = Nearest::new(&surface).expect("a body has a surface");
    let locator = Locator::new(mesh);
    let one = |at: &Vec3| match locator.locate(*at) {
        Some(inside) => Attached { weights: inside.weights, outside: 0.0 },
        None => {
            let near = nearest.of(at);
            let facet = boundary[near.triangle as usize / pieces(mesh.order).len()];
            let weights = continued(mesh, cells[facet as usize].0 as usize, *at);
            Attached { weights, outside: near.distance }
        }
    };
    let of_part = |part: &[Vec3]| part.iter().map(one).collect::<Vec<_>>();
    threads::map(points.chunks(POINTS).collect(), of_part).into_iter().flatten().collect()
}

/// Barycentric coordinates with respect to the corners of the cell, some of them negative.
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
    use crate::mesh::made::disturb::distort;
    use crate::mesh::made::structured::block;

    /// Inside, on the surface and 0.5 mm outside: Σ w = 1 and Σ w X = X to rounding, so that every affine motion is followed.
    #[test]
    fn affine_motions_are_followed_inside_and_outside() {
        for order in [Order::Linear, Order::Quadratic] {
            let mut mesh = block(3, 2, 2, 0.03, 0.02, 0.02, order);
            distort(&mut mesh, 3, 0.1);
            let points = [[0.011, 0.007, 0.013], [0.03, 0.01, 0.01], [0.0305, 0.012, 0.004], [0.01, 0.0203, -0.0002]];
            let points = points.map(Vec3::from);
            let attached = attach(&mesh, &points, 0.001).expect("near enough");
            for (at, Attached { weights, .. }) in points.iter().zip(&attached) {
                let sum: f64 = weights.iter().map(|w| w.1).sum();
                let mean: Vec3 = weights.iter().map(|&(k, w)| mesh.points[k as usize] * w).sum();
                assert!((sum - 1.0).abs() < 1e-13 && (mean - at).norm() < 1e-14, "{order:?}: {sum}, {mean}");
            }
            let off = attached.iter().map(|a| a.outside).collect::<Vec<_>>();
            assert!(
                off[0] == 0.0 && (off[2] - 0.0005).abs() < 1e-12 && (off[3] - 0.09_f64.hypot(0.2) * 1e-3).abs() < 1e-3,
                "{off:?}"
            );
            let out = [[0.032, 0.01, 0.01], [0.01, 0.01, 0.01], [0.0315, 0.01, 0.01]].map(Vec3::from);
            let far = attach(&mesh, &out, 0.001).expect_err("2 mm outside");
            assert!((far.count, far.of, far.at) == (2, 3, out[0]) && (far.distance - 0.002).abs() < 1e-12, "{far}");
        }
    }
}
