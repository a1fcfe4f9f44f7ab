//! Distance of a point from an obstacle and its derivatives, from the nearest point of a curved side, an edge or a triangle.

use crate::math::boxes::from_parry;
use crate::math::tensor::{Mat3, Vec3};
use parry3d_f64::shape::{Triangle, TrianglePointLocation};

/// Distance from a triangle that counts as rounding, relative to the size of the triangle \[–\].
pub(super) const ON_SURFACE: f64 = 1e-9;

/// Distance of a point from an obstacle, and its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Witness {
    /// d \[m\], negative inside
    pub gap: f64,
    /// ∂d/∂y
    pub normal: Vec3,
    /// ∂²d/∂y² \[1/m\]
    pub curvature: Mat3,
}

/// The witness of a rounded side; `from_axis` is the vector from the centre or axis to y.
pub(super) fn curved(gap: f64, radius: f64, from_axis: &Vec3, axis: Option<Vec3>) -> Witness {
    let normal = from_axis.try_normalize(0.0).unwrap_or(Vec3::x());
    let along = axis.map_or(Mat3::zeros(), |a| a * a.transpose());
    let curvature = (Mat3::identity() - normal * normal.transpose() - along) / (radius + gap).max(f64::MIN_POSITIVE);
    Witness { gap, normal, curvature }
}

/// The witness of a nearest point p that moves with y by the matrix `free`; `face` is the normal if y lies on the boundary.
pub(super) fn sharp(y: &Vec3, p: &Vec3, inside: bool, free: Mat3, face: impl Fn() -> Vec3) -> Witness {
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

/// The witness of the triangle t with the nearest point p. `solid`: y may be on either side, and the triangle determines which; otherwise y is
/// outside.
pub(super) fn on_triangle(
    t: &Triangle,
    y: &Vec3,
    p: &Vec3,
    [solid, inside]: [bool; 2],
    location: TrianglePointLocation,
) -> Witness {
    let [a, b, c] = [t.a, t.b, t.c].map(from_parry);
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
    // The direction of y − p is undefined if it differs from the normal only by the rounding of p: flat neighbours share their sides and corners.
    let away = y - p;
    let near = (away - plane * plane.dot(&away)).norm() < ON_SURFACE * (b - a).norm().max((c - a).norm());
    let face = !matches!(location, TrianglePointLocation::OnVertex(_) | TrianglePointLocation::OnEdge(..));
    if solid && (face || near) {
        return Witness { gap: plane.dot(&(y - p)), normal: plane, curvature: Mat3::zeros() };
    }
    sharp(y, p, inside, free, || plane)
}
