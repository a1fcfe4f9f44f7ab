//! Shapes of obstacles, and their distance d(y) with ∂d/∂y = n and ∂²d/∂y².
//!
//! With p the point of the obstacle nearest to y, n = ±(y − p)/|y − p|, and ∂²d/∂y² = ±(I − nnᵀ − T)/|y − p| with T the projector onto the directions
//! in which p moves with y: two for a face, one for an edge, none for a corner; for a curved side of radius R, R + d replaces d. Projections,
//! bounding volume hierarchies and inside tests of a surface are those of parry3d. Inside a shape, d has kinks where faces are equally near, hence
//! below each convex edge and corner. For a triangle surface
//! [`Shape::rounded`] replaces d = max d_i, d_i the distances from the planes of the faces, within `width` of such a kink by
//!
//! ```text
//! max_λ Σ λ_i d_i + ½ width (1 − Σ λ_i²),   λ_i ≥ 0, Σ λ_i = 1
//! ```
//!
//! (Nesterov, *Math. Program.* 103 (2005), §4), which has continuous derivatives: λ is the projection of d/width onto the simplex, n = Σ λ_i n_i.
//! Without it, a point that sticks to a corner by friction has no equilibrium: on each face, friction would push it over to the next.
//!
//! A triangle surface must be closed and oriented outward.

pub use super::facets::Facets;
pub use super::witness::Witness;

use super::sheets::Sheets;
use super::witness::{curved, on_triangle, sharp};
use crate::math::boxes::{from_parry, overlapping, to_parry, widened};
use crate::math::tensor::{Mat3, Vec3};
use crate::mesh::closed_surface::VolumeMoments;
use crate::mesh::surface_file::Surface;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::query::{PointQuery, PointQueryWithLocation};
use parry3d_f64::shape::{Ball, Cuboid, Cylinder, HalfSpace, Shape as _};
use std::collections::BTreeMap;

/// The shape of an obstacle, in its own frame.
pub enum Shape {
    /// The half-space z < 0
    Floor(HalfSpace),
    /// Centred at the origin
    Sphere(Ball),
    /// Centred at the origin, aligned with the axes
    Box(Cuboid),
    /// Centred at the origin, along y
    Cylinder(Cylinder),
    Surface(Box<Facets>),
}

/// Reason why a surface cannot be an obstacle.
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

impl Shape {
    pub fn floor() -> Self {
        Self::Floor(HalfSpace::new(Vector::Z))
    }

    pub fn sphere(radius: f64) -> Self {
        Self::Sphere(Ball::new(radius))
    }

    pub fn cuboid(half: Vec3) -> Self {
        Self::Box(Cuboid::new(to_parry(&half)))
    }

    pub fn cylinder(half_height: f64, radius: f64) -> Self {
        Self::Cylinder(Cylinder::new(half_height, radius))
    }

    /// Builds a shape from a closed surface with outward triangles.
    pub fn surface(surface: &Surface) -> Result<Self, ShapeError> {
        check(surface)?;
        let points = surface.points.iter().map(to_parry).collect();
        Ok(Self::Surface(Box::new(Facets::new(points, surface.triangles.clone()))))
    }

    /// The bounding box of the shape, the smallest and largest value of each coordinate; `None` for a floor.
    pub fn bounds(&self) -> Option<[Vec3; 2]> {
        let bounds: Aabb = match self {
            Self::Floor(_) => return None,
            Self::Sphere(s) => s.local_aabb(),
            Self::Box(s) => s.local_aabb(),
            Self::Cylinder(s) => s.local_aabb(),
            Self::Surface(s) => s.mesh.local_aabb(),
        };
        Some([from_parry(bounds.mins), from_parry(bounds.maxs)])
    }

    /// Returns the mass \[kg\], the centre of mass \[m\] and the inertia about it \[kg m²\] for a density \[kg/m³\]; zero for a floor.
    pub fn mass(&self, density: f64) -> (f64, Vec3, Mat3) {
        let properties = match self {
            Self::Floor(s) => s.mass_properties(density),
            Self::Sphere(s) => s.mass_properties(density),
            Self::Box(s) => s.mass_properties(density),
            Self::Cylinder(s) => s.mass_properties(density),
            Self::Surface(s) => {
                // parry loses the principal axes of bodies that are small in its units.
                let points: Vec<Vec3> = s.mesh.vertices().iter().copied().map(from_parry).collect();
                let VolumeMoments { volume, center, second } = VolumeMoments::within(&points, s.mesh.indices());
                let inertia = (Mat3::identity() * second.trace() - second) * density;
                return (density * volume, center, inertia);
            }
        };
        let inertia = properties.reconstruct_inertia_matrix();
        let inertia = Mat3::from_columns(&[inertia.x_axis, inertia.y_axis, inertia.z_axis].map(from_parry));
        (properties.mass(), from_parry(properties.local_com), inertia)
    }

    /// Returns the boundary as triangles, with `parts` around round shapes; `None` for a floor.
    pub fn triangles(&self, parts: u32) -> Option<Surface> {
        let (points, triangles) = match self {
            Self::Floor(_) => return None,
            Self::Sphere(s) => s.to_trimesh(parts, parts / 2),
            Self::Box(s) => s.to_trimesh(),
            Self::Cylinder(s) => s.to_trimesh(parts),
            Self::Surface(s) => (s.mesh.vertices().to_vec(), s.mesh.indices().to_vec()),
        };
        Some(Surface { points: points.into_iter().map(from_parry).collect(), triangles })
    }

    /// Returns the nearest point of the boundary, and whether y is inside.
    fn project(&self, y: &Vec3) -> (Vec3, bool) {
        let projection = match self {
            Self::Floor(s) => s.project_local_point(to_parry(y), false),
            Self::Sphere(s) => s.project_local_point(to_parry(y), false),
            Self::Box(s) => s.project_local_point(to_parry(y), false),
            Self::Cylinder(s) => s.project_local_point(to_parry(y), false),
            Self::Surface(s) => s.mesh.project_local_point(to_parry(y), false),
        };
        (from_parry(projection.point), projection.is_inside)
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

    /// Returns the witness of the nearest point.
    pub fn nearest(&self, y: &Vec3) -> Witness {
        match self {
            Self::Floor(_) => Witness { gap: y.z, normal: Vec3::z(), curvature: Mat3::zeros() },
            Self::Sphere(s) => curved(y.norm() - s.radius, s.radius, y, None),
            Self::Box(s) => {
                let (p, inside) = self.project(y);
                let half = from_parry(s.half_extents);
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
                // At the rim, p rotates with y by R/ρ of the displacement of y.
                let around = Vec3::y().cross(&radial);
                sharp(y, &p, inside, around * around.transpose() * (s.radius / across.norm()), || radial)
            }
            Self::Surface(s) => {
                let (projection, (triangle, location)) =
                    s.mesh.project_local_point_and_get_location(to_parry(y), false);
                let sides = [true, projection.is_inside];
                on_triangle(&s.mesh.triangle(triangle), y, &from_parry(projection.point), sides, location)
            }
        }
    }

    /// Largest number of contacts that a point can have: more than one with a surface that has sharp concave edges.
    pub fn sheets(&self) -> usize {
        match self {
            Self::Surface(s) => s.sheets.as_ref().map_or(1, Sheets::count),
            _ => 1,
        }
    }

    /// Returns the contacts of a point, each with its index below [`Self::sheets`]. Kinks inside a surface are rounded over `width` \[m\], unless it
    /// is 0.
    pub fn contacts(&self, y: &Vec3, width: f64) -> Vec<(usize, Witness)> {
        let sheets = match self {
            Self::Surface(s) => s.sheets.as_ref().map(|sheets| (s, sheets)),
            _ => None,
        };
        let Some((s, sheets)) = sheets else { return vec![(0, self.rounded(y, width))] };
        let mut contacts = sheets.contacts(&s.mesh, y);
        for (k, witness) in contacts.iter_mut().filter(|_| width > 0.0) {
            *witness = s.rounded(y, *witness, width, |t| sheets.of_triangle(t) == *k || s.is_behind(t, y, witness));
        }
        contacts
    }

    /// Returns the witness of the nearest point; for a surface, kinks inside are rounded over `width` \[m\], unless it is 0, which increases d by
    /// less than half of it.
    pub fn rounded(&self, y: &Vec3, width: f64) -> Witness {
        let nearest = self.nearest(y);
        match self {
            Self::Surface(s) => s.rounded(y, nearest, width, |_| true),
            _ => nearest,
        }
    }

    /// Returns all witnesses nearer than `reach` to a point outside, for sums that are smooth; for a surface one per flat side, for its nearest
    /// triangle, in the order of the sides.
    pub fn within(&self, y: &Vec3, reach: f64) -> Vec<Witness> {
        let Self::Surface(s) = self else {
            let nearest = self.nearest(y);
            return if nearest.gap < reach { vec![nearest] } else { Vec::new() };
        };
        let mut found = BTreeMap::<u32, Witness>::new();
        for k in overlapping(s.mesh.bvh(), widened((*y, *y), reach)) {
            let triangle = s.mesh.triangle(k);
            let (projection, location) = triangle.project_local_point_and_get_location(to_parry(y), false);
            let witness = on_triangle(&triangle, y, &from_parry(projection.point), [false, false], location);
            let of_side = found.entry(s.sides[k as usize]).or_insert(witness);
            if witness.gap < of_side.gap {
                *of_side = witness;
            }
        }
        found.into_values().filter(|w| w.gap < reach).collect()
    }
}

/// Checks that every edge has two triangles, which traverse it in opposite directions, and that the volume inside is positive.
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
