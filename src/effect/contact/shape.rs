//! Shapes of obstacles and their distance d(y) with ∂d/∂y = n and ∂²d/∂y².
//!
//! With p the point of the obstacle that is nearest to y, n = ±(y − p)/|y − p|, and ∂²d/∂y² = ±(I − nnᵀ − T)/|y − p| with T the
//! projector on the directions in which p moves along with y: both of a face, the one of an edge, none at a corner; a curved
//! side of radius R has R + d in place of d. Projections, hierarchies of boxes and the side of a surface are those of parry3d.
//! Inside of a shape d has kinks where faces are equally near, so below each convex edge and corner. Of a triangle surface
//! [`Shape::rounded`] replaces d = max d_i, d_i the distances from the planes of the faces, within `width` of such a kink by
//!
//! ```text
//! max_λ Σ λ_i d_i + ½ width (1 − Σ λ_i²),   λ_i ≥ 0, Σ λ_i = 1
//! ```
//!
//! (Nesterov, *Math. Program.* 103 (2005), §4), which has continuous derivatives: λ is the projection of d/width on the simplex, n = Σ λ_i n_i.
//! Without it a point that sticks to a corner by friction has no equilibrium: on every face friction would push it over to the next.
//!
//! A triangle surface is closed and outward.

use crate::math::tensor::{Mat3, Vec3};
use crate::mesh::closed_surface::VolumeMoments;
use crate::mesh::surface_file::Surface;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::query::{PointQuery, PointQueryWithLocation};
use parry3d_f64::shape::{
    Ball, Cuboid, Cylinder, HalfSpace, Shape as _, TriMesh, TriMeshFlags, Triangle, TrianglePointLocation,
};
use std::collections::BTreeMap;

/// Share of the size of a triangle below which the distance from it is rounding \[–\].
const ON_SURFACE: f64 = 1e-9;

/// Distance of a point from an obstacle, and how it changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Witness {
    /// d \[m\], negative inside
    pub gap: f64,
    /// ∂d/∂y
    pub normal: Vec3,
    /// ∂²d/∂y² \[1/m\]
    pub curvature: Mat3,
}

/// A shape in its own frame.
pub enum Shape {
    /// Below z = 0
    Floor(HalfSpace),
    /// About the origin
    Sphere(Ball),
    /// About the origin, along the axes
    Box(Cuboid),
    /// About the origin, along y
    Cylinder(Cylinder),
    Surface(Box<Facets>),
}

/// Why a surface cannot be an obstacle.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ShapeError {
    #[error(
        "the edge between the vertices {0} and {1} of the surface has {2} triangle(s); close the surface, every edge has two"
    )]
    Open(u32, u32, usize),
    #[error(
        "the triangles {0} and {1} of the surface look to opposite sides; turn one of them, so that all look outward"
    )]
    Flipped(u32, u32),
    #[error("the surface looks inward: its volume is {0:.3e} m^3; turn its triangles")]
    Inward(f64),
    #[error("triangle {0} of the surface has no area; remove it")]
    Degenerate(u32),
}

fn to(v: &Vec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn from(v: Vector) -> Vec3 {
    Vec3::new(v.x, v.y, v.z)
}

impl Shape {
    pub fn floor() -> Self {
        Self::Floor(HalfSpace::new(Vector::Z))
    }

    pub fn sphere(radius: f64) -> Self {
        Self::Sphere(Ball::new(radius))
    }

    pub fn cuboid(half: Vec3) -> Self {
        Self::Box(Cuboid::new(to(&half)))
    }

    pub fn cylinder(half_height: f64, radius: f64) -> Self {
        Self::Cylinder(Cylinder::new(half_height, radius))
    }

    /// Closed, with triangles that look outward.
    pub fn surface(surface: &Surface) -> Result<Self, ShapeError> {
        check(surface)?;
        let points = surface.points.iter().map(to).collect();
        let mesh = TriMesh::with_flags(points, surface.triangles.clone(), TriMeshFlags::ORIENTED);
        Ok(Self::Surface(Box::new(Facets::new(mesh.expect("a surface has triangles")))))
    }

    /// The box about the shape, \[least, most\] of each coordinate; a floor has none.
    pub fn bounds(&self) -> Option<[Vec3; 2]> {
        let bounds: Aabb = match self {
            Self::Floor(_) => return None,
            Self::Sphere(s) => s.local_aabb(),
            Self::Box(s) => s.local_aabb(),
            Self::Cylinder(s) => s.local_aabb(),
            Self::Surface(s) => s.mesh.local_aabb(),
        };
        Some([from(bounds.mins), from(bounds.maxs)])
    }

    /// Mass \[kg\], centre of mass \[m\], and inertia about it \[kg m²\], with the density \[kg/m³\]; a floor has none.
    pub fn mass(&self, density: f64) -> (f64, Vec3, Mat3) {
        let properties = match self {
            Self::Floor(s) => s.mass_properties(density),
            Self::Sphere(s) => s.mass_properties(density),
            Self::Box(s) => s.mass_properties(density),
            Self::Cylinder(s) => s.mass_properties(density),
            Self::Surface(s) => {
                // parry loses the principal axes of bodies that are small in its units
                let points: Vec<Vec3> = s.mesh.vertices().iter().copied().map(from).collect();
                let VolumeMoments { volume, center, second } = VolumeMoments::within(&points, s.mesh.indices());
                let inertia = (Mat3::identity() * second.trace() - second) * density;
                return (density * volume, center, inertia);
            }
        };
        let inertia = properties.reconstruct_inertia_matrix();
        let inertia = Mat3::from_columns(&[inertia.x_axis, inertia.y_axis, inertia.z_axis].map(from));
        (properties.mass(), from(properties.local_com), inertia)
    }

    /// The boundary as triangles, round ones in `parts` around; a floor has none.
    pub fn triangles(&self, parts: u32) -> Option<Surface> {
        let (points, triangles) = match self {
            Self::Floor(_) => return None,
            Self::Sphere(s) => s.to_trimesh(parts, parts / 2),
            Self::Box(s) => s.to_trimesh(),
            Self::Cylinder(s) => s.to_trimesh(parts),
            Self::Surface(s) => (s.mesh.vertices().to_vec(), s.mesh.indices().to_vec()),
        };
        Some(Surface { points: points.into_iter().map(from).collect(), triangles })
    }

    /// The sharpest concave edge of a surface: the angle by which its sides are turned towards each other \[rad\], and its middle \[m\]; none of a convex shape.
    pub fn sharpest_concave_edge(&self) -> Option<(f64, Vec3)> {
        let Self::Surface(s) = self else { return None };
        let concave = |(&(i, j), one): (&(u32, u32), &u32)| {
            let other = *s.neighbours.get(&(j, i))?;
            let beyond: Vec3 = s.mesh.indices()[other as usize].iter().map(|&k| s.vertex(k) - s.vertex(i)).sum();
            let angle = s.normal(*one).angle(&s.normal(other));
            (beyond.dot(&s.normal(*one)) > 0.0).then(|| (angle, (s.vertex(i) + s.vertex(j)) / 2.0))
        };
        s.neighbours.iter().filter_map(concave).max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// The nearest point of the boundary, and whether y is inside.
    fn project(&self, y: &Vec3) -> (Vec3, bool) {
        let projection = match self {
            Self::Floor(s) => s.project_local_point(to(y), false),
            Self::Sphere(s) => s.project_local_point(to(y), false),
            Self::Box(s) => s.project_local_point(to(y), false),
            Self::Cylinder(s) => s.project_local_point(to(y), false),
            Self::Surface(s) => s.mesh.project_local_point(to(y), false),
        };
        (from(projection.point), projection.is_inside)
    }

    /// d(y) \[m\], negative inside.
    pub fn gap(&self, y: &Vec3) -> f64 {
        match self {
            Self::Floor(_) => y.z,
            Self::Sphere(s) => y.norm() - s.radius,
            _ => {
                let (p, inside) = self.project(y);
                (y - p).norm() * if inside { -1.0 } else { 1.0 }
            }
        }
    }

    /// The nearest point as a witness.
    pub fn nearest(&self, y: &Vec3) -> Witness {
        match self {
            Self::Floor(_) => Witness { gap: y.z, normal: Vec3::z(), curvature: Mat3::zeros() },
            Self::Sphere(s) => curved(y.norm() - s.radius, s.radius, y, None),
            Self::Box(s) => {
                let (p, inside) = self.project(y);
                let half = from(s.half_extents);
                let beyond = |i: usize| y[i].abs() - half[i];
                let nearest = (0..3).max_by(|a, b| beyond(*a).total_cmp(&beyond(*b))).into_iter();
                let face: Vec<usize> =
                    if inside { nearest.collect() } else { (0..3).filter(|&i| beyond(i) >= 0.0).collect() };
                let free = Mat3::from_diagonal(&Vec3::from_fn(|i, _| if face.contains(&i) { 0.0 } else { 1.0 }));
                sharp(y, &p, inside, free, || face.first().map_or(Vec3::z(), |&i| Vec3::ith(i, p[i].signum())))
            }
            Self::Cylinder(s) => {
                let (p, inside) = self.project(y);
                let across = Vec3::new(y.x, 0.0, y.z);
                let radial = across.try_normalize(0.0).unwrap_or(Vec3::x());
                if p.y.abs() < s.half_height {
                    return curved(across.norm() - s.radius, s.radius, &across, Some(Vec3::y()));
                }
                let flat = Mat3::identity() - Vec3::y() * Vec3::y().transpose();
                if across.norm() < s.radius {
                    return sharp(y, &p, inside, flat, || Vec3::ith(1, p.y.signum()));
                }
                // The rim: p turns with y by R/ρ of the displacement of y.
                let around = Vec3::y().cross(&radial);
                sharp(y, &p, inside, around * around.transpose() * (s.radius / across.norm()), || radial)
            }
            Self::Surface(s) => {
                let (projection, (triangle, location)) = s.mesh.project_local_point_and_get_location(to(y), false);
                let sides = [true, projection.is_inside];
                on_triangle(&s.mesh.triangle(triangle), y, &from(projection.point), sides, location)
            }
        }
    }

    /// The nearest point as a witness, of a surface with the kinks inside rounded over `width` \[m\]: d grows by less than half of it there.
    pub fn rounded(&self, y: &Vec3, width: f64) -> Witness {
        let nearest = self.nearest(y);
        // Only a face has no curvature: the region of a sharp side or corner seen from inside has neither kinks nor faces.
        let (Self::Surface(s), true) = (self, nearest.gap < 0.0 && nearest.curvature == Mat3::zeros()) else {
            return nearest;
        };
        let p = y - nearest.normal * nearest.gap;
        // Twice as far as the planes: the foot of y on one of them may be beyond its face.
        let reach = 2.0 * (width - nearest.gap);
        let around = Aabb::new(to(&y.add_scalar(-reach)), to(&y.add_scalar(reach)));
        let mut planes = vec![(nearest.gap, nearest.normal)];
        let mut triangles: Vec<u32> = s.mesh.bvh().intersect_aabb(&around).collect();
        triangles.sort_unstable();
        for triangle in triangles {
            let [a, b, c] = {
                let t = s.mesh.triangle(triangle);
                [t.a, t.b, t.c].map(from)
            };
            let normal = (b - a).cross(&(c - a)).normalize();
            let gap = normal.dot(&(y - a));
            // Beyond a concave side the plane cuts the inside.
            let convex = normal.dot(&(p - a)) <= ON_SURFACE * (b - a).norm().max((c - a).norm());
            let known = |(_, n): &(f64, Vec3)| (n - normal).norm() < ON_SURFACE;
            if convex && gap > nearest.gap - width && !planes.iter().any(known) {
                planes.push((gap.min(nearest.gap), normal));
            }
        }
        smooth_maximum(planes, width)
    }

    /// Every witness nearer than `reach` to a point outside, for sums that are smooth: of a surface one of each flat side, by its nearest triangle, in the
    /// order of these.
    pub fn within(&self, y: &Vec3, reach: f64) -> Vec<Witness> {
        let Self::Surface(s) = self else {
            let nearest = self.nearest(y);
            return if nearest.gap < reach { vec![nearest] } else { Vec::new() };
        };
        let around = Aabb::new(to(&y.add_scalar(-reach)), to(&y.add_scalar(reach)));
        let mut triangles: Vec<u32> = s.mesh.bvh().intersect_aabb(&around).collect();
        triangles.sort_unstable();
        let mut found = BTreeMap::<u32, Witness>::new();
        for k in triangles {
            let triangle = s.mesh.triangle(k);
            let (projection, location) = triangle.project_local_point_and_get_location(to(y), false);
            let witness = on_triangle(&triangle, y, &from(projection.point), [false, false], location);
            let of_side = found.entry(s.sides[k as usize]).or_insert(witness);
            if witness.gap < of_side.gap {
                *of_side = witness;
            }
        }
        found.into_values().filter(|w| w.gap < reach).collect()
    }
}

/// Angle between triangles that are parts of one flat side \[rad\]: files in single precision turn small ones by 1e-5.
const FLAT: f64 = 1e-4;

/// A closed surface of triangles, and the flat sides that they make up.
pub struct Facets {
    mesh: TriMesh,
    /// Edge, as a triangle passes it → the triangle
    neighbours: BTreeMap<(u32, u32), u32>,
    /// \[triangles\] the first triangle of the side that it is part of
    sides: Vec<u32>,
}

impl Facets {
    fn new(mesh: TriMesh) -> Self {
        let edges = |(t, corners): (usize, &[u32; 3])| {
            let [a, b, c] = *corners;
            [(a, b), (b, c), (c, a)].map(|edge| (edge, t as u32))
        };
        let neighbours = mesh.indices().iter().enumerate().flat_map(edges).collect();
        let mut own = Self { sides: vec![u32::MAX; mesh.indices().len()], mesh, neighbours };
        for first in 0..own.sides.len() as u32 {
            let mut open = vec![first];
            while let Some(t) = open.pop() {
                if own.sides[t as usize] == u32::MAX && own.normal(t).angle(&own.normal(first)) <= FLAT {
                    own.sides[t as usize] = first;
                    let [a, b, c] = own.mesh.indices()[t as usize];
                    open.extend([(b, a), (c, b), (a, c)].iter().filter_map(|edge| own.neighbours.get(edge)));
                }
            }
        }
        own
    }

    fn vertex(&self, k: u32) -> Vec3 {
        from(self.mesh.vertices()[k as usize])
    }

    fn normal(&self, t: u32) -> Vec3 {
        let [a, b, c] = self.mesh.indices()[t as usize].map(|k| self.vertex(k));
        (b - a).cross(&(c - a)).normalize()
    }
}

/// The smooth maximum of the distances from planes, each with its normal.
fn smooth_maximum(mut planes: Vec<(f64, Vec3)>, width: f64) -> Witness {
    planes.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (mut sum, mut level, mut held) = (0.0, 0.0, 0);
    for (k, (d, _)) in planes.iter().enumerate() {
        sum += d;
        let next = (sum - width) / (k + 1) as f64;
        if *d <= next {
            break;
        }
        (level, held) = (next, k + 1);
    }
    let planes = &planes[..held];
    let shares: Vec<f64> = planes.iter().map(|(d, _)| (d - level) / width).collect();
    let square: f64 = shares.iter().map(|s| s * s).sum();
    let gap = planes.iter().zip(&shares).map(|((d, _), s)| d * s).sum::<f64>() + 0.5 * width * (1.0 - square);
    let normal: Vec3 = planes.iter().zip(&shares).map(|((_, n), s)| n * *s).sum();
    let middle = planes.iter().map(|(_, n)| n).sum::<Vec3>() / held as f64;
    let spread = planes.iter().map(|(_, n)| (n - middle) * (n - middle).transpose()).sum::<Mat3>();
    Witness { gap, normal, curvature: spread / width }
}

/// Of a rounded side: `from_axis` from the centre or axis to y.
fn curved(gap: f64, radius: f64, from_axis: &Vec3, axis: Option<Vec3>) -> Witness {
    let normal = from_axis.try_normalize(0.0).unwrap_or(Vec3::x());
    let along = axis.map_or(Mat3::zeros(), |a| a * a.transpose());
    let curvature = (Mat3::identity() - normal * normal.transpose() - along) / (radius + gap).max(f64::MIN_POSITIVE);
    Witness { gap, normal, curvature }
}

/// Of a nearest point p that moves along with y by the matrix `free`; `face` is the normal where y lies on the boundary.
fn sharp(y: &Vec3, p: &Vec3, inside: bool, free: Mat3, face: impl Fn() -> Vec3) -> Witness {
    let sign = if inside { -1.0 } else { 1.0 };
    let away = y - p;
    let distance = away.norm();
    if distance == 0.0 {
        return Witness { gap: 0.0, normal: face(), curvature: Mat3::zeros() };
    }
    let normal = away * (sign / distance);
    let curvature = (Mat3::identity() - normal * normal.transpose() - free) * (sign / distance);
    Witness { gap: sign * distance, normal, curvature }
}

/// Of the triangle t with the nearest point p. `solid`: y may be on either side, and the triangle says on which one; else y is outside.
fn on_triangle(
    t: &Triangle,
    y: &Vec3,
    p: &Vec3,
    [solid, inside]: [bool; 2],
    location: TrianglePointLocation,
) -> Witness {
    let [a, b, c] = [t.a, t.b, t.c].map(from);
    let plane = (b - a).cross(&(c - a)).normalize();
    let line = |from: Vec3, to: Vec3| {
        let along = (to - from).normalize();
        along * along.transpose()
    };
    let free = match location {
        TrianglePointLocation::OnVertex(_) => Mat3::zeros(),
        TrianglePointLocation::OnEdge(0, _) => line(a, b),
        TrianglePointLocation::OnEdge(1, _) => line(b, c),
        TrianglePointLocation::OnEdge(..) => line(a, c),
        _ => Mat3::identity() - plane * plane.transpose(),
    };
    // y − p has no direction of its own where it departs from the normal by the rounding of p: flat neighbours share their sides and corners.
    let away = y - p;
    let near = (away - plane * plane.dot(&away)).norm() < ON_SURFACE * (b - a).norm().max((c - a).norm());
    let face = !matches!(location, TrianglePointLocation::OnVertex(_) | TrianglePointLocation::OnEdge(..));
    if solid && (face || near) {
        return Witness { gap: plane.dot(&(y - p)), normal: plane, curvature: Mat3::zeros() };
    }
    sharp(y, p, inside, free, || plane)
}

/// Every edge has two triangles, which pass it in opposite directions, and the volume inside is positive.
fn check(surface: &Surface) -> Result<(), ShapeError> {
    let mut edges = BTreeMap::<(u32, u32), Vec<(u32, bool)>>::new();
    let mut volume = 0.0;
    for (k, corners) in (0..).zip(&surface.triangles) {
        let [a, b, c] = corners.map(|i| surface.points[i as usize]);
        if (b - a).cross(&(c - a)).norm() == 0.0 {
            return Err(ShapeError::Degenerate(k));
        }
        volume += a.dot(&b.cross(&c)) / 6.0;
        for (i, j) in [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (corners[i], corners[j])) {
            edges.entry((i.min(j), i.max(j))).or_default().push((k, i < j));
        }
    }
    for ((i, j), triangles) in &edges {
        match triangles[..] {
            [(a, forth), (b, too)] if forth == too => return Err(ShapeError::Flipped(a, b)),
            [_, _] => {}
            _ => return Err(ShapeError::Open(*i, *j, triangles.len())),
        }
    }
    if volume > 0.0 { Ok(()) } else { Err(ShapeError::Inward(volume)) }
}
