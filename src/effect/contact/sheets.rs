//! Sheets of a surface of triangles: in a concave edge a point meets two sides at once, so each of them is on a sheet of its own, and a point has one contact
//! with each sheet.
//!
//! Beyond its concave edges a sheet goes on inside of the solid, in the planes of its sides: there its distance is as smooth as that of a floor, whether
//! the point is in front of the other side or behind it. How far, is half of the way through the solid, and of the width of the triangle at the edge, so that nothing comes
//! out elsewhere. A point sees it if it is not behind the other side of the edge.
//!
//! Elsewhere a sheet may end at an edge beyond which the surface goes on as another one. A point y outside has the contact of the sheet that is nearest to it, and
//! those of others whose own nearest point q
//!
//! - is not behind q's side of the sheet, as what is seen through the solid is;
//! - is, at an end of the sheet, nearest to y among all places of the surface near it, and not where another sheet has this contact.
//!
//! A point inside has the contacts of the nearest point of the surface, each with its own distance from the same sides.
//!
//! Limits: of two places of one sheet, as of one of many posts on a floor, a point meets the nearer one; an edge that is concave by less than 20 degrees is a facet of a
//! smooth hollow, where a point meets the nearest side.

use super::sheet_numbers::{Neighbours, SheetNumbers, is_sharp_and_concave};
use super::witness::{ON_SURFACE, Witness, on_triangle};
use crate::math::boxes::{from_parry, to_parry};
use crate::math::tensor::{Mat3, Vec3};
use parry3d_f64::math::Vector;
use parry3d_f64::query::{PointQueryWithLocation, Ray, RayCast};
use parry3d_f64::shape::{TriMesh, TriMeshFlags, TrianglePointLocation};
use std::collections::BTreeMap;

/// Share of the way through the solid, and of the width of the triangle at the edge, by which a sheet goes on beyond a concave edge \[–\].
const BEYOND: f64 = 0.5;
/// How much a vertex is held back from moving along its concave edge, against keeping in the planes of its sides \[–\].
const HELD: f64 = 1e-3;
/// Share of the size of a surface by which a ray starts inside of it \[–\].
const INSIDE: f64 = 1e-6;
/// Sine of the angle behind the other side of a concave edge within which a point sees beyond the edge, where that side is curved \[–\]: half of what makes an edge sharp.
const BEHIND: f64 = 0.17;
/// Share of the distance from a point within which its nearest point on a sheet is compared with the rest of the surface \[–\].
const NEAR: f64 = 0.1;
/// Share of a distance below which another one is not less than it \[–\].
const LESS: f64 = 1e-6;

/// All sheets of a surface.
pub struct Sheets {
    all: Vec<Sheet>,
    /// \[triangles of the surface\] the sheet
    numbers: Vec<usize>,
    /// Distance below which two points are one \[m\]
    rounding: f64,
}

/// One sheet.
struct Sheet {
    /// Its triangles of the surface, then those beyond concave edges
    mesh: TriMesh,
    /// Triangles of the surface
    own: usize,
    /// \[triangles beyond concave edges\] the normal of the other side, a point of the edge, and its direction
    across: Vec<[Vec3; 3]>,
    /// \[triangles\] how the sheet ends at each edge, then at each corner
    ends: Vec<[End; 6]>,
}

/// How a sheet ends at an edge or at a corner.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
enum End {
    /// Not at all
    None,
    /// Inside of the solid
    Beyond,
    /// Where the surface goes on as another sheet, which has the contacts there
    Other,
    /// Where the surface goes on as another sheet, and contacts there are those of this one
    Own,
}

/// The nearest point of a sheet.
struct Seen {
    at: Vec3,
    distance: f64,
    end: End,
    triangle: u32,
    witness: Witness,
}

impl Sheets {
    /// None of a surface without sharp concave edges.
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

    /// The sheet of a triangle of the surface.
    pub(super) fn of_triangle(&self, t: u32) -> usize {
        self.numbers[t as usize]
    }

    /// The contacts of a point y with the `surface`: each with its sheet, at most one of each.
    pub(super) fn contacts(&self, surface: &TriMesh, y: &Vec3) -> Vec<(usize, Witness)> {
        let (nearest, (triangle, location)) = surface.project_local_point_and_get_location(to_parry(y), false);
        let outside = if nearest.is_inside { from_parry(nearest.point) } else { *y };
        let distance = (outside - from_parry(nearest.point)).norm();
        let seen: Vec<Seen> = self.all.iter().map(|sheet| sheet.see(&outside, distance + self.rounding)).collect();
        let nearest_ones = (0..seen.len()).filter(|&k| (seen[k].distance - distance).abs() <= self.rounding);
        let owner = nearest_ones.min_by_key(|&k| seen[k].end == End::Other);
        let contact = |(k, own): (usize, &Seen)| {
            // Beyond the edges of a very rough surface a sheet may come out of it, nearer than all else.
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

    /// Whether a sheet that is not the nearest one has a contact of its own with a point y outside; `lower` are the sheets before it.
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
    /// Sheet `k`.
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
        // Of a side with a concave edge and one without the former has the contacts, of two others the lower sheet.
        let is_own = |(i, j): (u32, u32)| {
            let rank = |t: u32| (!numbers.concave[t as usize], numbers.sheets[t as usize]);
            rank(neighbours[&(i, j)]) < rank(neighbours[&(j, i)])
        };
        let ends = ends(&triangles, own, is_own);
        let mesh = TriMesh::with_flags(points, triangles, TriMeshFlags::ORIENTED).expect("a sheet has triangles");
        Self { mesh, own, across, ends }
    }

    /// The nearest point of y, which is not inside. Where it is one of the whole surface, within `nearest` of y, y is in front of it: in the plane of a side,
    /// beyond the end of its sheet, the triangles of this one alone have y on either side.
    fn see(&self, y: &Vec3, nearest: f64) -> Seen {
        let (projection, (triangle, location)) = self.mesh.project_local_point_and_get_location(to_parry(y), false);
        let (at, end) = (from_parry(projection.point), self.end(triangle as usize, location));
        let distance = (y - at).norm();
        let inside = end < End::Other && projection.is_inside && distance > nearest;
        let witness = on_triangle(&self.mesh.triangle(triangle), y, &at, [true, inside], location);
        Seen { at, distance, end, triangle, witness }
    }

    /// The distance of another point y from the same plane, or from the same edge or corner.
    fn witness(&self, Seen { at, triangle, witness, .. }: &Seen, y: &Vec3) -> Witness {
        if witness.curvature == Mat3::zeros() {
            return Witness { gap: witness.normal.dot(&(y - at)), ..*witness };
        }
        let triangle = self.mesh.triangle(*triangle);
        let (projection, location) = triangle.project_local_point_and_get_location(to_parry(y), false);
        on_triangle(&triangle, y, &from_parry(projection.point), [true, false], location)
    }

    /// Whether y, which is outside, is behind the other side of the concave edge beyond which its nearest point is.
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

/// The edges of a triangle as it passes them.
fn sides([a, b, c]: &[u32; 3]) -> [(u32, u32); 3] {
    [(*a, *b), (*b, *c), (*c, *a)]
}

/// \[triangles\] how a sheet ends at the edges and at the corners of its triangles, of which the first `own` are of the surface; `is_own` tells of an edge of it where
/// another sheet goes on whether contacts there are those of this one.
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

/// Where the vertices of concave edges move, as the sheet goes on beyond these.
struct Beyond {
    /// (group, vertex) → the part of its planes and of its concave edges in the motion of least squares, and how far it moves \[m\]
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

    /// The motion \[m\]: in the planes of the sides as well as it goes, and one length away from each concave edge.
    fn motion(&self, key: (usize, u32)) -> Vec3 {
        let (square, right, length) = &self.of[&key];
        let motion = square.cholesky().expect("HELD makes it definite").solve(right);
        motion * (*length / motion.norm().max(1.0))
    }
}
