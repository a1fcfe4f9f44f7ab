//! Sheets of a triangle surface. At a concave edge a point can be in contact with two sides at once; each side is therefore on a separate sheet, and
//! a point has one contact with each sheet.
//!
//! Beyond its concave edges a sheet continues inside the solid, in the planes of its sides: its distance there is as smooth as that of a floor,
//! whether the point is in front of the other side or behind it. It extends by half of the distance through the solid, and at most half of the width
//! of the triangle at the edge, so that it does not emerge elsewhere. A point sees this extension if it is not behind the other side of the edge.
//!
//! Elsewhere a sheet may end at an edge beyond which the surface continues as another sheet. A point y outside has a contact with the sheet nearest
//! to it, and with other sheets whose nearest point q
//!
//! - is not hidden: y is not behind the side of the sheet at q, as it would be if q were seen through the solid;
//! - if it is at an end of the sheet, is locally the nearest point of the whole surface to y, and no other sheet has this contact.
//!
//! A point inside has the contacts of the nearest point of the surface, each with its distance from the same sides.
//!
//! Limits: if a sheet is near a point in two places, such as two of many posts on a floor, the point is in contact only with the nearer one; an edge
//! that is concave by less than 20 degrees counts as a facet edge of a smooth hollow, where a point is in contact with the nearest side.

use super::sheet_numbers::{Neighbours, SheetNumbers, is_sharp_and_concave};
use super::witness::{ON_SURFACE, Witness, on_triangle};
use crate::math::boxes::{from_parry, to_parry};
use crate::math::tensor::{Mat3, Vec3};
use parry3d_f64::math::Vector;
use parry3d_f64::query::{PointQueryWithLocation, Ray, RayCast};
use parry3d_f64::shape::{TriMesh, TriMeshFlags, TrianglePointLocation};
use std::collections::BTreeMap;

/// Length by which a sheet extends beyond a concave edge, relative to the distance through the solid and to the width of the triangle at the edge
/// \[–\].
const BEYOND: f64 = 0.5;
/// Weight of holding a vertex back from moving along its concave edge, relative to keeping it in the planes of its sides \[–\].
const HELD: f64 = 1e-3;
/// Distance inside a surface at which a ray starts, relative to the size of the surface \[–\].
const INSIDE: f64 = 1e-6;
/// Sine of the angle behind the other side of a concave edge within which a point sees beyond the edge if that side is curved \[–\]: half of the
/// angle that makes an edge sharp.
const BEHIND: f64 = 0.17;
/// Share of the distance from a point within which its nearest point on a sheet is compared with the rest of the surface \[–\].
const NEAR: f64 = 0.1;
/// Relative difference below which a distance does not count as smaller than another \[–\].
const LESS: f64 = 1e-6;

/// All sheets of a surface.
pub struct Sheets {
    all: Vec<Sheet>,
    /// \[triangles of the surface\] index of the sheet
    numbers: Vec<usize>,
    /// Distance below which two points coincide \[m\]
    rounding: f64,
}

/// One sheet.
struct Sheet {
    /// Its triangles of the surface, followed by those beyond concave edges
    mesh: TriMesh,
    /// Number of its triangles that belong to the surface
    own: usize,
    /// \[triangles beyond concave edges\] the normal of the other side, a point of the edge, and its direction
    across: Vec<[Vec3; 3]>,
    /// \[triangles\] how the sheet ends at each edge, and then at each corner
    ends: Vec<[End; 6]>,
}

/// How a sheet ends at an edge or at a corner.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
enum End {
    /// It does not end there
    None,
    /// Inside of the solid
    Beyond,
    /// The surface continues as another sheet, which has the contacts there
    Other,
    /// The surface continues as another sheet, but this one has the contacts there
    Own,
}

/// The nearest point of a sheet to a given point.
struct Seen {
    at: Vec3,
    distance: f64,
    end: End,
    triangle: u32,
    witness: Witness,
}

impl Sheets {
    /// Builds the sheets; `None` for a surface without sharp concave edges.
    pub(super) fn of(mesh: &TriMesh, normals: &[Vec3], neighbours: &Neighbours) -> Option<Self> {
        let numbers = SheetNumbers::of(mesh, normals, neighbours);
        if numbers.count == 1 {
            return None;
        }
        let all = (0..numbers.count).map(|k| Sheet::new(mesh, normals, neighbours, &numbers, k)).collect();
        let bounds = mesh.local_aabb();
        let rounding = ON_SURFACE * from_parry(bounds.maxs - bounds.mins).norm();
        Some(Self { all, numbers: numbers.sheets, rounding })
    }

    pub fn count(&self) -> usize {
        self.all.len()
    }

    /// The index of the sheet of a triangle of the surface.
    pub(super) fn of_triangle(&self, t: u32) -> usize {
        self.numbers[t as usize]
    }

    /// Returns the contacts of a point y with the `surface`, at most one per sheet, each with its sheet.
    pub(super) fn contacts(&self, surface: &TriMesh, y: &Vec3) -> Vec<(usize, Witness)> {
        let (nearest, (triangle, location)) = surface.project_local_point_and_get_location(to_parry(y), false);
        let outside = if nearest.is_inside { from_parry(nearest.point) } else { *y };
        let distance = (outside - from_parry(nearest.point)).norm();
        let seen: Vec<Seen> = self.all.iter().map(|sheet| sheet.see(&outside, distance + self.rounding)).collect();
        let nearest_ones = (0..seen.len()).filter(|&k| (seen[k].distance - distance).abs() <= self.rounding);
        let owner = nearest_ones.min_by_key(|&k| seen[k].end == End::Other);
        let contact = |(k, own): (usize, &Seen)| {
            // Beyond the edges of a very rough surface, a sheet may emerge from it and be nearer than everything else.
            if owner.is_none() && k == self.of_triangle(triangle) {
                let sides = [true, nearest.is_inside];
                return Some((
                    k,
                    on_triangle(&surface.triangle(triangle), y, &from_parry(nearest.point), sides, location),
                ));
            }
            let witness = if nearest.is_inside { self.all[k].witness(own, y) } else { own.witness };
            let is_contact = owner == Some(k) || self.is_contact(surface, &outside, &seen[..k], (&self.all[k], own));
            is_contact.then_some((k, witness))
        };
        seen.iter().enumerate().filter_map(contact).collect()
    }

    /// Whether a sheet other than the nearest has a separate contact with a point y outside; `lower` are the sheets with lower indices.
    fn is_contact(&self, surface: &TriMesh, y: &Vec3, lower: &[Seen], (sheet, own): (&Sheet, &Seen)) -> bool {
        if own.witness.gap < -self.rounding || sheet.is_hidden(own, y, self.rounding) {
            return false;
        }
        match own.end {
            End::None => true,
            End::Beyond | End::Other => false,
            End::Own => {
                let near = own.at + (y - own.at) * NEAR;
                let nearest = surface.project_local_point_and_get_location(to_parry(&near), false).0;
                !nearest.is_inside
                    && (near - from_parry(nearest.point)).norm() >= (1.0 - LESS) * NEAR * own.distance
                    && lower.iter().all(|other| (other.at - own.at).norm() > self.rounding)
            }
        }
    }
}

impl Sheet {
    /// Builds sheet `k`.
    fn new(mesh: &TriMesh, normals: &[Vec3], neighbours: &Neighbours, numbers: &SheetNumbers, k: usize) -> Self {
        let mut points: Vec<Vector> = mesh.vertices().to_vec();
        let vertex = |v: u32| from_parry(mesh.vertices()[v as usize]);
        let of_surface: Vec<usize> = (0..normals.len()).filter(|&t| numbers.sheets[t] == k).collect();
        let mut triangles: Vec<[u32; 3]> = of_surface.iter().map(|&t| mesh.indices()[t]).collect();
        let own = triangles.len();
        let mut across = Vec::new();
        let beyond_of = |(i, j): (u32, u32)| neighbours[&(j, i)] as usize;
        let concave: Vec<(usize, (u32, u32))> = of_surface
            .iter()
            .flat_map(|&t| sides(&mesh.indices()[t]).map(|edge| (t, edge)))
            .filter(|&(t, edge)| is_sharp_and_concave(mesh, normals, [t, beyond_of(edge)], edge.0))
            .collect();
        let beyond = Beyond::of(mesh, normals, numbers, &concave);
        let mut moved = BTreeMap::<(usize, u32), u32>::new();
        for &(t, (i, j)) in &concave {
            let [far_i, far_j] = [i, j].map(|v| {
                let key = (numbers.groups[t], v);
                *moved.entry(key).or_insert_with(|| {
                    points.push(to_parry(&(vertex(v) + beyond.motion(key))));
                    points.len() as u32 - 1
                })
            });
            triangles.extend([[j, i, far_i], [j, far_i, far_j]]);
            let of_edge = [normals[beyond_of((i, j))], vertex(i), (vertex(j) - vertex(i)).normalize()];
            across.extend([of_edge, of_edge]);
        }
        // If only one of the two sides has a concave edge, it has the contacts; otherwise the sheet with the lower index.
        let is_own = |(i, j): (u32, u32)| {
            let rank = |t: u32| (!numbers.concave[t as usize], numbers.sheets[t as usize]);
            rank(neighbours[&(i, j)]) < rank(neighbours[&(j, i)])
        };
        let ends = ends(&triangles, own, is_own);
        let mesh = TriMesh::with_flags(points, triangles, TriMeshFlags::ORIENTED).expect("a sheet has triangles");
        Self { mesh, own, across, ends }
    }

    /// Returns the nearest point to y, which is not inside. If it is also nearest on the whole surface, to within `nearest` of y, then y is in front
    /// of it: in the plane of a side, beyond the end of the sheet, the triangles of the sheet alone may put y on either side.
    fn see(&self, y: &Vec3, nearest: f64) -> Seen {
        let (projection, (triangle, location)) = self.mesh.project_local_point_and_get_location(to_parry(y), false);
        let (at, end) = (from_parry(projection.point), self.end(triangle as usize, location));
        let distance = (y - at).norm();
        let inside = end < End::Other && projection.is_inside && distance > nearest;
        let witness = on_triangle(&self.mesh.triangle(triangle), y, &at, [true, inside], location);
        Seen { at, distance, end, triangle, witness }
    }

    /// Returns the distance of another point y from the same plane, edge or corner.
    fn witness(&self, Seen { at, triangle, witness, .. }: &Seen, y: &Vec3) -> Witness {
        if witness.curvature == Mat3::zeros() {
            return Witness { gap: witness.normal.dot(&(y - at)), ..*witness };
        }
        let triangle = self.mesh.triangle(*triangle);
        let (projection, location) = triangle.project_local_point_and_get_location(to_parry(y), false);
        on_triangle(&triangle, y, &from_parry(projection.point), [true, false], location)
    }

    /// Whether y, which is outside, is behind the other side of the concave edge beyond which its nearest point lies.
    fn is_hidden(&self, seen: &Seen, y: &Vec3, rounding: f64) -> bool {
        let Some([normal, on_edge, along]) = (seen.triangle as usize).checked_sub(self.own).map(|t| &self.across[t])
        else {
            return false;
        };
        let away = y - on_edge;
        let from_edge = (away - along * along.dot(&away)).norm();
        normal.dot(&away) < -BEHIND * from_edge - rounding
    }

    fn end(&self, t: usize, location: TrianglePointLocation) -> End {
        match location {
            TrianglePointLocation::OnEdge(edge, _) => self.ends[t][edge as usize],
            TrianglePointLocation::OnVertex(corner) => self.ends[t][3 + corner as usize],
            _ => End::None,
        }
    }
}

/// The directed edges of a triangle.
fn sides([a, b, c]: &[u32; 3]) -> [(u32, u32); 3] {
    [(*a, *b), (*b, *c), (*c, *a)]
}

/// Returns how a sheet ends at the edges and corners of its triangles \[triangles\], the first `own` of which belong to the surface; `is_own` tells,
/// for an edge beyond which another sheet continues, whether this sheet has the contacts there.
fn ends(triangles: &[[u32; 3]], own: usize, is_own: impl Fn((u32, u32)) -> bool) -> Vec<[End; 6]> {
    let mut of_edges = BTreeMap::<(u32, u32), Vec<usize>>::new();
    for (t, corners) in triangles.iter().enumerate() {
        sides(corners).iter().for_each(|&(i, j)| of_edges.entry((i.min(j), i.max(j))).or_default().push(t));
    }
    let mut of_corners = BTreeMap::<u32, End>::new();
    let mut end_of = |(i, j): (u32, u32)| {
        let end = match of_edges[&(i.min(j), i.max(j))][..] {
            [t] if t < own && is_own((i, j)) => End::Own,
            [t] if t < own => End::Other,
            [_] => End::Beyond,
            _ => End::None,
        };
        for corner in [i, j] {
            let known = of_corners.entry(corner).or_insert(End::None);
            *known = end.max(*known);
        }
        end
    };
    let edges: Vec<[End; 3]> = triangles.iter().map(|corners| sides(corners).map(&mut end_of)).collect();
    let all = |([a, b, c], corners): (&[End; 3], &[u32; 3])| {
        let [d, e, f] = corners.map(|corner| of_corners[&corner]);
        [*a, *b, *c, d, e, f]
    };
    edges.iter().zip(triangles).map(all).collect()
}

/// Motion of the vertices of concave edges by which the sheet continues beyond them.
struct Beyond {
    /// (group, vertex) → matrix and right-hand side of the least-squares problem for the motion, from the planes and concave edges, and the length of
    /// the motion \[m\]
    of: BTreeMap<(usize, u32), (Mat3, Vec3, f64)>,
}

impl Beyond {
    fn of(mesh: &TriMesh, normals: &[Vec3], numbers: &SheetNumbers, concave: &[(usize, (u32, u32))]) -> Self {
        let vertex = |v: u32| from_parry(mesh.vertices()[v as usize]);
        let bounds = mesh.local_aabb();
        let size = from_parry(bounds.maxs - bounds.mins).norm();
        let mut of = BTreeMap::<(usize, u32), (Mat3, Vec3, f64)>::new();
        for &(t, (i, j)) in concave {
            let out = (vertex(j) - vertex(i)).cross(&normals[t]).normalize();
            let start = (vertex(i) + vertex(j)) / 2.0 + out * (INSIDE * size);
            let way = mesh
                .cast_local_ray(&Ray::new(to_parry(&start), to_parry(&out)), size, false)
                .unwrap_or(0.0)
                .max(INSIDE * size);
            let width = mesh.indices()[t].iter().map(|&v| out.dot(&(vertex(i) - vertex(v)))).fold(0.0, f64::max);
            for v in [i, j] {
                let none = (Mat3::identity() * HELD, Vec3::zeros(), f64::INFINITY);
                let (square, right, length) = of.entry((numbers.groups[t], v)).or_insert(none);
                *square += out * out.transpose();
                *right += out;
                *length = length.min(BEYOND * way.min(width));
            }
        }
        for (t, normal) in normals.iter().enumerate() {
            for v in mesh.indices()[t] {
                if let Some((square, ..)) = of.get_mut(&(numbers.groups[t], v)) {
                    *square += normal * normal.transpose();
                }
            }
        }
        Self { of }
    }

    /// Returns the motion \[m\]: as far as possible in the planes of the sides, and by the length away from each concave edge.
    fn motion(&self, key: (usize, u32)) -> Vec3 {
        let (square, right, length) = &self.of[&key];
        let motion = square.cholesky().expect("HELD makes it definite").solve(right);
        motion * (*length / motion.norm().max(1.0))
    }
}
