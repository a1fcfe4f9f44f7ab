//! The rigid motion of a group of markers over time.

use super::error::MotionError;
use super::registration::{not_on_a_line, rigid};
use super::swap;
use super::tracks::Tracks;
use crate::math::tensor::{Mat3, Vec3};
use nalgebra::{Rotation3, UnitQuaternion};

/// Position and orientation of a body at a time: x = R X + t of each of its reference points X.
#[derive(Clone, Debug)]
pub struct Pose {
    pub time_s: f64,
    /// Samples that the row is the mean of
    pub samples: f64,
    pub rotation: Mat3,
    /// \[m\]
    pub translation: Vec3,
    /// Deformation of the group: what a rigid motion leaves of the distances, √(Σ|e|²/n) \[m\]
    pub rms: f64,
}

impl Pose {
    /// Displacement of a point of the body that is at `reference` in the reference \[m\].
    pub fn displacement(&self, reference: Vec3) -> Vec3 {
        self.rotation * reference + self.translation - reference
    }

    /// Rotation about an axis \[rad\], positive by the right hand: the twist of the rotation about it, 2 atan2(q·a, q₀) of the unit quaternion (q₀, q).
    pub fn rotation_about(&self, axis: Vec3) -> f64 {
        twist(&self.rotation, axis)
    }
}

/// The twist of a rotation about an axis \[rad\], within ±π.
pub fn twist(rotation: &Mat3, axis: Vec3) -> f64 {
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation));
    let along = q.imag().dot(&axis.normalize());
    let angle = 2.0 * along.atan2(q.scalar());
    angle.sin().atan2(angle.cos())
}

/// Poses of a body over time, one for each row in which three or more of its markers are seen. `reference` are their positions in the reference
/// \[m\], in the order of `names`.
///
/// # Errors
/// Fewer than three markers, names that do not exist, reference points on a line or of another size, exchanged markers, and markers that are
/// never seen together.
pub fn pose(tracks: &Tracks, names: &[String], reference: &[Vec3]) -> Result<Vec<Pose>, MotionError> {
    if names.len() != reference.len() {
        return Err(MotionError::Lengths {
            what: "markers and reference points",
            lengths: vec![names.len(), reference.len()],
        });
    }
    let group = tracks.select(names)?;
    if group.len() < 3 {
        return Err(MotionError::TooFew { found: group.len(), names: names.to_vec() });
    }
    not_on_a_line(reference)?;
    swap::check(&tracks.time_s, &group)?;
    let mut poses = vec![];
    for (k, time_s) in tracks.time_s.iter().enumerate() {
        let seen: Vec<(Vec3, Vec3)> =
            group.iter().zip(reference).filter_map(|(m, x)| Some((*x, Vec3::from(m.points[k]?)))).collect();
        let (from, to): (Vec<Vec3>, Vec<Vec3>) = seen.into_iter().unzip();
        if from.len() < 3 || not_on_a_line(&from).is_err() {
            continue;
        }
        let found = rigid(&from, &to, None)?;
        let (rotation, translation, rms) = (found.rotation, found.translation, found.rms);
        poses.push(Pose { time_s: *time_s, samples: tracks.samples[k], rotation, translation, rms });
    }
    if poses.is_empty() { Err(MotionError::NeverSeen { names: names.to_vec() }) } else { Ok(poses) }
}
