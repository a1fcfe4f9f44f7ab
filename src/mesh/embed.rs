//! Material points inside a mesh, expressed by the shape functions of their cells, and the nearest surface points to points outside.

use super::element::{CELL_EDGES, cell_shape};
use super::error::point;
use super::surface::boundary::boundary_facets;
use super::surface::flat::pieces;
use super::{Order, TetMesh, geometry};
use crate::math::nearest::closest_on_triangle;
use crate::math::tensor::Vec3;
use crate::math::units::Decimals;

/// A point of the body as a weighted mean of nodes.
#[derive(Clone, PartialEq, Debug)]
pub struct Embedded {
    pub cell: u32,
    /// Reference coordinates in the cell
    pub xi: [f64; 3],
    /// (node, N_i(ξ)) of the cell's nodes
    pub weights: Vec<(u32, f64)>,
}

/// Error for a point or ball that is not inside the body.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum EmbedError {
    #[error("the point {} is outside the body, {:.4} mm from its surface; move it inside", point(at), Decimals(distance * 1e3))]
    Outside { at: Vec3, distance: f64 },
    #[error("the ball of radius {:.4} mm at {} holds nothing of the body, whose surface is {:.4} mm away; move it or make it larger", Decimals(radius * 1e3), point(at), Decimals(distance * 1e3))]
    EmptyBall { at: Vec3, radius: f64, distance: f64 },
    #[error("the ball of radius {:.4e} mm at {} is less than a millionth of the body, {:.4} mm across; take a larger radius", radius * 1e3, point(at), Decimals(across * 1e3))]
    SmallBall { at: Vec3, radius: f64, across: f64 },
    #[error("the ball of radius {:.4e} mm at {} cuts a cell that is too slender to be integrated over; take a larger radius, or smaller cells there", radius * 1e3, point(at))]
    SlenderCell { at: Vec3, radius: f64 },
}

/// Amount by which reference coordinates may lie outside the cell \[–\]: points on faces belong to both cells.
const INSIDE: f64 = 1e-9;

/// Returns the cell that contains `at` \[m\] and the shape functions there. On a face, the cell in which the point lies deepest is chosen.
pub fn embed(mesh: &TetMesh, at: Vec3) -> Result<Embedded, EmbedError> {
    locate(mesh, at).ok_or_else(|| EmbedError::Outside { at, distance: distance_to_surface(mesh, at) })
}

/// Finds the point as [`embed`] does; `None` outside the body.
fn locate(mesh: &TetMesh, at: Vec3) -> Option<Embedded> {
    let near = |c: &usize| {
        let (low, high) = reach_of(mesh, *c);
        (0..3).all(|d| at[d] >= low[d] && at[d] <= high[d])
    };
    deepest(mesh, (0..mesh.cell_count()).filter(near), at)
}

/// Returns the bounding box of the points that count as inside a cell.
pub(super) fn reach_of(mesh: &TetMesh, c: usize) -> (Vec3, Vec3) {
    let (low, high) = cell_bounds(mesh, c);
    let margin = Vec3::repeat(INSIDE * (high - low).norm());
    (low - margin, high + margin)
}

/// Returns the embedding in the cell, among some cells in ascending order, in which a point lies deepest.
pub(super) fn deepest(mesh: &TetMesh, cells: impl Iterator<Item = usize>, at: Vec3) -> Option<Embedded> {
    let mut best: Option<(f64, u32, [f64; 3])> = None;
    for c in cells {
        let Some(xi) = invert(mesh, c, at) else { continue };
        let depth = xi.iter().copied().fold(1.0 - xi.iter().sum::<f64>(), f64::min);
        if depth >= -INSIDE && best.is_none_or(|b| depth > b.0) {
            best = Some((depth, c as u32, xi));
        }
    }
    let (_, cell, xi) = best?;
    let n = cell_shape(mesh.order, xi);
    Some(Embedded { cell, xi, weights: mesh.cell(cell as usize).iter().copied().zip(n).collect() })
}

/// Returns the bounding box of a cell; for a curved cell that of its Bézier points (mid-edge 2m − ½(a + b)).
pub(super) fn cell_bounds(mesh: &TetMesh, c: usize) -> (Vec3, Vec3) {
    let p = |k: usize| mesh.points[mesh.cell(c)[k] as usize];
    let edges = if mesh.order == Order::Quadratic { &CELL_EDGES[..] } else { &[] };
    let middle = |(e, [a, b]): (usize, &[usize; 2])| p(4 + e) * 2.0 - (p(*a) + p(*b)) * 0.5;
    geometry::bounds((0..4).map(p).chain(edges.iter().enumerate().map(middle)))
}

/// Solves X(ξ) = at for ξ by Newton's method; one step on tet4. `None` if it does not converge near the cell.
pub(super) fn invert(mesh: &TetMesh, c: usize, at: Vec3) -> Option<[f64; 3]> {
    let mut xi = Vec3::repeat(0.25);
    for _ in 0..20 {
        let jacobian = mesh.jacobian(c, xi.into());
        let step = jacobian.try_inverse()? * (at - mesh.position(c, xi.into()));
        xi += step;
        if mesh.order == Order::Linear || step.norm() < 1e-14 {
            return Some(xi.into());
        }
        if xi.norm() > 10.0 {
            return None;
        }
    }
    // Rounding may keep the last step above the tolerance used above.
    ((mesh.position(c, xi.into()) - at).norm() <= 1e-12 * mesh.diagonal()).then(|| xi.into())
}

/// Returns the distance \[m\] from a point to the nearest boundary facet; curved facets count as four flat triangles.
pub(super) fn distance_to_surface(mesh: &TetMesh, at: Vec3) -> f64 {
    (nearest_on_surface(mesh, at) - at).norm()
}

/// Returns the point of the boundary facets that is nearest to a point \[m\]; curved facets count as four flat triangles.
pub fn nearest_on_surface(mesh: &TetMesh, at: Vec3) -> Vec3 {
    let nearest = boundary_facets(mesh).into_iter().map(|f| nearest_on_facet(mesh, f, at));
    nearest.min_by(|a, b| (a - at).norm().total_cmp(&(b - at).norm())).unwrap_or(at)
}

/// Returns the point of a facet that is nearest to a point \[m\]; a curved facet counts as four flat triangles.
fn nearest_on_facet(mesh: &TetMesh, f: u32, at: Vec3) -> Vec3 {
    let nodes = mesh.facet(f as usize);
    let nearest = |piece: &[usize; 3]| closest_on_triangle(&at, &piece.map(|k| mesh.points[nodes[k] as usize]));
    let of_pieces = pieces(mesh.order).iter().map(nearest);
    of_pieces.min_by(|a, b| (a - at).norm().total_cmp(&(b - at).norm())).expect("a facet has a piece")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::made::structured::block;

    #[test]
    fn outside_is_an_error_with_the_distance() {
        let mesh = block(2, 2, 2, 0.02, 0.02, 0.02, Order::Quadratic);
        let at = Vec3::new(0.023, 0.024, 0.01);
        let message = embed(&mesh, at).expect_err("outside").to_string();
        assert_eq!(
            message,
            "the point (23, 24, 10) mm is outside the body, 5.0000 mm from its surface; move it inside"
        );
        assert!(embed(&mesh, Vec3::new(0.02, 0.02, 0.02)).is_ok(), "a corner belongs to the body");
    }
}
