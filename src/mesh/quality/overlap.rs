//! Overlap of two meshes: centres of cells of one that lie in the other, and surface edges of one that pierce the surface of the other.
//!
//! Faces in contact share no volume. Curved facets count as flat triangles.

use crate::math::boxes::{aabb, hierarchy, overlapping};
use crate::math::tensor::{Mat3, Vec3};
use crate::mesh::embed::{cell_bounds, invert};
use crate::mesh::made::parts::{apart, image};
use crate::mesh::surface::boundary::{add_boundary, boundary_facets};
use crate::mesh::surface::flat::{edges, flat_triangles};
use crate::mesh::{TetMesh, geometry};
use nalgebra::Rotation3;

/// Relative length or area below which a crossing counts as contact \[–\].
const TOUCH: f64 = 1e-9;
/// Displacement relative to the size of the smaller body by which a mesh is moved to distinguish contact from overlap \[–\].
const NUDGE: f64 = 1e-6;

/// Returns a position \[m\] that lies in both meshes, if there is one.
pub fn overlap(a: &TetMesh, b: &TetMesh) -> Option<Vec3> {
    let (first, second) = (bounds(a), bounds(b));
    if (0..3).any(|i| first.1[i] < second.0[i] || second.1[i] < first.0[i]) {
        return None;
    }
    let size = (first.1 - first.0).norm().min((second.1 - second.0).norm());
    let shared = |away: Vec3| {
        let moved = image(a, &Mat3::identity(), &(away * (NUDGE * size)));
        let both = [(&moved, b), (b, &moved)];
        both.iter().find_map(|(a, b)| inside(a, b)).or_else(|| both.iter().find_map(|(a, b)| pierced(a, b)))
    };
    let [first, others @ ..] = corners();
    let place = shared(first)?;
    others.into_iter().all(|away| shared(away).is_some()).then_some(place)
}

/// Returns a position \[m\] that lies in two parts of one mesh, if there is one.
pub fn overlap_of_parts(mesh: &TetMesh) -> Option<Vec3> {
    let mut parts = apart(mesh);
    parts.iter_mut().for_each(add_boundary);
    (1..parts.len()).find_map(|k| parts[..k].iter().find_map(|before| overlap(before, &parts[k])))
}

/// Corners of a tetrahedron about the origin, aligned with no axis of a mesh. Bodies that are only in contact separate in one of these directions;
/// meshes with coincident edges and faces intersect properly in all of them.
fn corners() -> [Vec3; 4] {
    let turn = Rotation3::from_euler_angles(0.3, 0.5, 0.7);
    [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]].map(|v| turn * Vec3::from(v))
}

/// Returns the position at which the segment from `p` to `q` pierces the interior of a triangle, as a share of its length; `None` if the segment lies
/// in the plane of the triangle or meets its border (Möller & Trumbore, J. Graph. Tools 2, 1997).
pub fn pierces(p: &Vec3, q: &Vec3, [a, b, c]: &[Vec3; 3]) -> Option<f64> {
    let (u, v, along) = (b - a, c - a, q - p);
    let across = along.cross(&v);
    let volume = u.dot(&across);
    if volume.abs() <= TOUCH * u.norm() * v.norm() * along.norm() {
        return None;
    }
    let from = p - a;
    let other = from.cross(&u);
    let (s, t, w) = (from.dot(&across) / volume, along.dot(&other) / volume, v.dot(&other) / volume);
    let within = s > TOUCH && t > TOUCH && s + t < 1.0 - TOUCH && w > TOUCH && w < 1.0 - TOUCH;
    within.then_some(w)
}

fn bounds(mesh: &TetMesh) -> (Vec3, Vec3) {
    geometry::bounds(mesh.points.iter().copied())
}

/// Returns the centre of a cell of `a` that lies in a cell of `b`.
fn inside(a: &TetMesh, b: &TetMesh) -> Option<Vec3> {
    let cells = hierarchy((0..b.cell_count()).map(|c| cell_bounds(b, c)));
    let (low, high) = bounds(b);
    let middles = (0..a.cell_count()).map(|c| a.position(c, [0.25; 3]));
    let near = middles.filter(|p| (0..3).all(|i| p[i] >= low[i] && p[i] <= high[i]));
    let holds = |p: &Vec3| {
        let point = aabb((*p, *p));
        cells.intersect_aabb(&point).any(|c| {
            let depth = |xi: [f64; 3]| xi.iter().copied().fold(1.0 - xi.iter().sum::<f64>(), f64::min);
            invert(b, c as usize, *p).is_some_and(|xi| depth(xi) > -TOUCH)
        })
    };
    near.into_iter().find(holds)
}

/// Returns a position where a surface edge of `a` pierces the surface of `b`.
fn pierced(a: &TetMesh, b: &TetMesh) -> Option<Vec3> {
    let corners = flat_triangles(b, &boundary_facets(b));
    let triangles: Vec<[Vec3; 3]> = corners.iter().map(|t| t.map(|k| b.points[k as usize])).collect();
    let boxes = hierarchy(triangles.iter().map(|t| geometry::bounds(t.iter().copied())));
    let ends = edges(&flat_triangles(a, &boundary_facets(a)));
    ends.into_iter().find_map(|(ends, _)| {
        let [p, q] = ends.map(|k| a.points[k as usize]);
        let near = overlapping(&boxes, geometry::bounds([p, q].into_iter()));
        near.into_iter().find_map(|t| Some(p + (q - p) * pierces(&p, &q, &triangles[t as usize])?))
    })
}
