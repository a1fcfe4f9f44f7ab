//! Rotation vectors: axis times angle.

use super::tensor::{Mat3, Vec3};
use nalgebra::{Rotation3, UnitQuaternion};
use std::f64::consts::TAU;

/// The rotation vector of R \[rad\], with the number of full turns that brings it nearest to the vector `before`.
pub fn nearest_vector(rotation: Mat3, before: Vec3) -> Vec3 {
    let base = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation)).scaled_axis();
    // Only the earlier states know the axis of a full turn.
    let axis = match base.norm() {
        angle if angle > 1e-9 => base / angle,
        _ => before.try_normalize(0.0).unwrap_or(Vec3::x()),
    };
    base + axis * (TAU * ((before - base).dot(&axis) / TAU).round())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rotations by 1 rad about one axis add up over any number of full turns. Bound: rounding of the last angle.
    #[test]
    fn whole_rotations_are_counted() {
        let axis = Vec3::new(1.0, -2.0, 2.0) / 3.0;
        let mut vector = Vec3::zeros();
        for k in 1..=100 {
            let angle = f64::from(k);
            vector = nearest_vector(Rotation3::new(axis * angle).into_inner(), vector);
            assert!((vector - axis * angle).norm() < 1e-12 * angle.max(10.0), "{vector:?} after {k} rad");
        }
    }
}
