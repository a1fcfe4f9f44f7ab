//! A force on an embedded point, or on the patch around it.

use crate::effect::dead_load::DeadLoad;
use crate::math::tensor::Vec3;
use crate::math::units::Dimension;
use crate::mesh::embed::{ball_weights, embed};
use crate::scene::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::error::part;
use crate::scene::quantity::{GuideRadius, Length};
use crate::scene::signal::SignalSpec;

/// A force on an embedded point, or on the patch around it.
pub(in crate::scene) fn build_point_force(
    builder: &mut Builder,
    place: &str,
    name: &str,
    (point, radius): (&[Length; 3], GuideRadius),
    direction: [f64; 3],
    force: &SignalSpec,
) -> Result<DeadLoad, SceneError> {
    let at = Vec3::new(point[0].0, point[1].0, point[2].0);
    let body = builder.body.clone();
    let embedded = embed(&body.mesh, at).map_err(|e| part(builder.file, place, e))?;
    let weights = match radius {
        GuideRadius::Point => {
            builder.no_limits.push("a force on a point moves it further the finer the mesh".into());
            embedded.weights
        }
        GuideRadius::Ball(radius) if radius <= 0.0 => {
            let fact = format!("radius is {} mm", radius * 1e3);
            return Err(builder.content(place, fact, "give a positive length, at least the size of a cell"));
        }
        GuideRadius::Ball(radius) => ball_weights(&body.mesh, at, radius).map_err(|e| part(builder.file, place, e))?,
    };
    let (direction, signal) = builder.dead(place, direction, force, Dimension::FORCE, format!("{name}_imposed_N"))?;
    Ok(DeadLoad::new(name.into(), &weights, direction, signal))
}
