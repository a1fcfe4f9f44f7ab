//! Columns of a rigid body on the four nodes of a frame: the position of its centre, and its rotation vector including whole rotations.

use super::recorder::Moment;
use crate::effect::contact::placement::AffineFrame;
use crate::material::polar::SignedSvd;
use crate::math::rotation::nearest_vector;
use crate::math::tensor::Vec3;
use crate::system::State;

/// The columns `<name>_{x,y,z}_m` and `<name>_rotation_{x,y,z}_deg`.
pub(in crate::scene) fn columns(name: &str) -> Vec<String> {
    let place = ["x", "y", "z"].map(|c| format!("{name}_{c}_m"));
    let rotation = ["x", "y", "z"].map(|c| format!("{name}_rotation_{c}_deg"));
    place.into_iter().chain(rotation).collect()
}

/// The rotation vector at rest \[rad\].
pub(in crate::scene) fn memory() -> Vec<f64> {
    vec![0.0; 3]
}

/// Stores the rotation vector that is nearest to the one in memory.
pub(in crate::scene) fn remember(frame: &AffineFrame, state: &State, memory: &mut [f64]) {
    let rotation = SignedSvd::of(&frame.gradient_of(&state.x)).rotation();
    memory.copy_from_slice(nearest_vector(rotation, Vec3::from_column_slice(memory)).as_slice());
}

/// Values of the columns.
pub(in crate::scene) fn record(frame: &AffineFrame, now: &Moment) -> Vec<f64> {
    let place = frame.positions(&now.state.x)[0];
    place.iter().copied().chain(now.memory.iter().map(|angle| angle.to_degrees())).collect()
}
