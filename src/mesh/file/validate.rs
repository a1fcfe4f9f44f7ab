//! Detection of mesh defects: coincident nodes, folded cells.

use crate::math::statistics::smaller;
use crate::math::tensor::{Mat3, Vec3};
use crate::mesh::element::CELL_NODES;
use crate::mesh::{Order, TetMesh, geometry};
use std::collections::HashMap;

/// Distance relative to the diagonal of the bounding box below which two nodes are duplicates \[–\].
const DUPLICATE: f64 = 1e-9;

/// Returns the nodes at the position of an earlier one, with the earliest one there \[pairs in ascending order of the second\].
pub(super) fn doubled(points: &[Vec3]) -> Vec<(usize, usize)> {
    let (low, high) = geometry::bounds(points.iter().copied());
    closer_than(points, DUPLICATE * (high - low).norm())
}

/// Returns the nodes within a distance of an earlier one, with that one \[pairs in ascending order of the second\].
pub(super) fn closer_than(points: &[Vec3], distance: f64) -> Vec<(usize, usize)> {
    let low = geometry::bounds(points.iter().copied()).0;
    // Grid of four times the distance: a neighbour is in this box or the adjacent one on the nearer side. If all nodes coincide, any size will do.
    let size = if distance > 0.0 { 4.0 * distance } else { 1.0 };
    let mut grid: HashMap<[i64; 3], Vec<usize>> = HashMap::with_capacity(points.len());
    let mut pairs = Vec::new();
    for (i, p) in points.iter().enumerate() {
        let s = (p - low) / size;
        let near =
            |x: f64| [x.floor() as i64, if x.fract() < 0.5 { x.floor() as i64 - 1 } else { x.floor() as i64 + 1 }];
        let (x, y, z) = (near(s.x), near(s.y), near(s.z));
        let around = (0..8).filter_map(|k| grid.get(&[x[k & 1], y[k >> 1 & 1], z[k >> 2]])).flatten();
        if let Some(&j) = around.filter(|&&j| (points[j] - p).norm() <= distance).min() {
            pairs.push((j, i));
        }
        grid.entry([x[0], y[0], z[0]]).or_default().push(i);
    }
    pairs
}

/// Returns a lower bound of det ∂X/∂ξ over cell `c` \[m³\]: exact on tet4; on tet10 from Bernstein coefficients, tightened by subdivision until the
/// sign is certain (Johnen, Remacle & Geuzaine, J. Comput. Phys. 233, 2013).
pub fn min_det(mesh: &TetMesh, c: usize) -> f64 {
    match mesh.order {
        Order::Linear => mesh.jacobian(c, [0.0; 3]).determinant(),
        Order::Quadratic => min_det_in(&std::array::from_fn(|i| mesh.jacobian(c, CELL_NODES[i])), 5),
    }
}

/// Returns the bound over a sub-tetrahedron with the Jacobians `j` at its corners; ∂X/∂ξ is linear on tet10.
fn min_det_in(j: &[Mat3; 4], depth: usize) -> f64 {
    let corners = j.iter().map(Mat3::determinant).fold(f64::INFINITY, smaller);
    let bound = min_bernstein(j);
    if corners <= 0.0 || bound > 0.0 || depth == 0 {
        return smaller(bound, corners);
    }
    split(j, |a, b| (a + b) * 0.5).iter().map(|sub| min_det_in(sub, depth - 1)).fold(f64::INFINITY, smaller)
}

/// Returns the smallest of the 20 Bernstein coefficients of the cubic det(Σ λ_i J_i).
fn min_bernstein(j: &[Mat3; 4]) -> f64 {
    let mixed = |a: usize, b: usize, c: usize| j[a].column(0).cross(&j[b].column(1)).dot(&j[c].column(2));
    let mut least = f64::INFINITY;
    for a in 0..4 {
        for b in a..4 {
            for c in b..4 {
                let sum =
                    mixed(a, b, c) + mixed(a, c, b) + mixed(b, a, c) + mixed(b, c, a) + mixed(c, a, b) + mixed(c, b, a);
                least = smaller(least, sum / 6.0);
            }
        }
    }
    least
}

/// Splits a tetrahedron, given by its corners, into 8 of equal volume.
pub(in crate::mesh) fn split<T: Clone>(corner: &[T; 4], middle: impl Fn(&T, &T) -> T) -> [[T; 4]; 8] {
    let c = corner;
    let [m01, m12, m02, m03, m13, m23] = crate::mesh::element::CELL_EDGES.map(|[a, b]| middle(&c[a], &c[b]));
    let tet = |a: &T, b: &T, c: &T, d: &T| [a.clone(), b.clone(), c.clone(), d.clone()];
    [
        tet(&c[0], &m01, &m02, &m03),
        tet(&m01, &c[1], &m12, &m13),
        tet(&m02, &m12, &c[2], &m23),
        tet(&m03, &m13, &m23, &c[3]),
        tet(&m01, &m12, &m02, &m13),
        tet(&m01, &m02, &m03, &m13),
        tet(&m02, &m13, &m23, &m03),
        tet(&m02, &m12, &m23, &m13),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splits_into_eight_of_equal_positive_volume() {
        let corner: [Vec3; 4] = std::array::from_fn(|i| Vec3::from(CELL_NODES[i]));
        for [a, b, c, d] in split(&corner, |a, b| (a + b) / 2.0) {
            let volume = (b - a).cross(&(c - a)).dot(&(d - a));
            assert!((volume - 0.125).abs() < 1e-15, "{volume}");
        }
    }

    #[test]
    fn bounds_the_jacobian_of_a_curved_cell() {
        let mut points: Vec<Vec3> = CELL_NODES.map(Vec3::from).to_vec();
        let mesh = |points: &[Vec3]| TetMesh {
            order: Order::Quadratic,
            points: points.to_vec(),
            cells: (0..10).collect(),
            facets: vec![],
            regions: Default::default(),
        };
        assert!((min_det(&mesh(&points), 0) - 1.0).abs() < 1e-14);
        // With the mid-node of edge (0,1) at x, dX/dξ at corner 0 is 4x − 1, which vanishes at x = 1/4.
        points[4].x = 0.251;
        assert!(min_det(&mesh(&points), 0) > 0.0);
        points[4].x = 0.249;
        assert!(min_det(&mesh(&points), 0) < 0.0);
    }

    #[test]
    fn finds_a_duplicate_across_a_grid_line() {
        let mut points: Vec<Vec3> = (0..1000).map(|i| Vec3::new(f64::from(i), 0.0, 0.0)).collect();
        assert_eq!(doubled(&points), []);
        points.push(Vec3::new(500.0, 2e-7, -3e-7));
        assert_eq!(doubled(&points), [(500, 1000)]);
        points[1000].y = 2e-6;
        assert_eq!(doubled(&points), []);
    }
}
