//! The rigid motion of a group of markers over time.

use super::error::MotionError;
use super::registration::{not_on_a_line, rigid};
use super::swap;
use super::tracks::Tracks;
use crate::math::tensor::{Mat3, Vec3};
use nalgebra::{Rotation3, UnitQuaternion};
use std::f64::consts::TAU;

/// Position and orientation of a body at one time: x = R X + t for each of its reference points X.
#[derive(Clone, Debug)]
pub struct Pose {
    pub time_s: f64,
    /// Number of samples averaged in the row
    pub samples: f64,
    pub rotation: Mat3,
    /// \[m\]
    pub translation: Vec3,
    /// Deformation of the group: rms distance that remains after the rigid motion, √(Σ|e|²/n) \[m\]
    pub rms: f64,
}

impl Pose {
    /// Returns the displacement of the point of the body whose reference position is `reference` \[m\].
    pub fn displacement(&self, reference: Vec3) -> Vec3 {
        self.rotation * reference + self.translation - reference
    }

    /// Returns the rotation about an axis \[rad\], positive by the right-hand rule: the twist 2 atan2(q·a, q₀) of the unit quaternion (q₀, q).
    pub fn rotation_about(&self, axis: Vec3) -> f64 {
        twist(&self.rotation, axis)
    }
}

/// Norm of the part (q₀, q·a) of the quaternion below which a twist is not used to count turns: the body has rotated by more than 120° about other
/// axes \[–\]
const SWUNG: f64 = 0.5;

/// Returns the rotations of a body about an axis over its rows \[rad\], continued beyond ±π: each is chosen nearest to that of the previous row, from
/// the row `first` on, and before `first` nearest to that of the next row. Rows in which the body has rotated by more than 120° about other axes are
/// not used to count turns, because the twist is ill-determined there.
pub(super) fn turns_about(poses: &[Pose], axis: Vec3, first: usize) -> Vec<f64> {
    let parts: Vec<[f64; 2]> = poses.iter().map(|p| twist_parts(&p.rotation, axis)).collect();
    let mut turns: Vec<f64> = parts.iter().map(|part| angle(*part)).collect();
    let mut follow = |rows: &mut dyn Iterator<Item = usize>| {
        let mut last = turns[first];
        for k in rows {
            turns[k] += TAU * ((last - turns[k]) / TAU).round();
            if parts[k][0].hypot(parts[k][1]) > SWUNG {
                last = turns[k];
            }
        }
    };
    follow(&mut (first + 1..poses.len()));
    follow(&mut (0..first).rev());
    turns
}

/// Returns the twist of a rotation about an axis \[rad\], within ±π.
pub fn twist(rotation: &Mat3, axis: Vec3) -> f64 {
    angle(twist_parts(rotation, axis))
}

/// Returns q·a and q₀ of the unit quaternion (q₀, q) of a rotation.
fn twist_parts(rotation: &Mat3, axis: Vec3) -> [f64; 2] {
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation));
    [q.imag().dot(&axis.normalize()), q.scalar()]
}

fn angle([along, scalar]: [f64; 2]) -> f64 {
    let angle = 2.0 * along.atan2(scalar);
    angle.sin().atan2(angle.cos())
}

/// Returns the poses of a body over time, one for each row in which three or more of its markers are visible. `reference` contains their positions in
/// the reference \[m\], in the order of `names`.
///
/// # Errors
/// Fewer than three markers, names that do not exist, reference points on a line or of a different size, exchanged markers, and markers that are
/// never visible together.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::statistics::larger;

    /// A body that rotates more than once about y and rocks slightly about x: the rotation continues in both directions from the row near zero, and
    /// no other axis turns.
    #[test]
    fn turns_go_on_beyond_half_a_turn() {
        let exact: Vec<f64> = (0..200).map(|k| 8.0 * f64::from(k) / 199.0).collect();
        let poses: Vec<Pose> = (0..200)
            .map(|k| {
                let rocks = Rotation3::from_axis_angle(&Vec3::x_axis(), 0.02 * (0.7 * f64::from(k)).sin());
                let turns = Rotation3::from_axis_angle(&Vec3::y_axis(), exact[k as usize]);
                let rotation = (turns * rocks).into_inner();
                Pose { time_s: f64::from(k), samples: 1.0, rotation, translation: Vec3::zeros(), rms: 0.0 }
            })
            .collect();
        for (first, whole_turns) in [(0, 0.0), (60, 0.0), (199, 1.0)] {
            let about_y = turns_about(&poses, Vec3::y(), first);
            let differences = about_y.iter().zip(&exact).map(|(a, b)| (a + TAU * whole_turns - b).abs());
            assert!(differences.fold(0.0, larger) < 1e-12, "{first}: {about_y:?}");
            let about_z = turns_about(&poses, Vec3::z(), first);
            assert!(about_z[0].abs() < 0.1 && about_z[199].abs() < 0.1, "{first}: {about_z:?}");
        }
        assert!(poses.iter().all(|p| p.rotation_about(Vec3::y()).abs() <= TAU / 2.0));
    }
}
