//! Weight of a region.

use crate::effect::Gravity;
use crate::math::tensor::Vec3;
use crate::math::units::Dimension;
use crate::scene::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::signal::SignalSpec;

/// Weight of the cells of a region along a direction.
pub(in crate::scene) fn build_gravity(
    builder: &mut Builder,
    place: &str,
    (region, density): (&str, f64),
    direction: [f64; 3],
    acceleration: &SignalSpec,
) -> Result<Gravity, SceneError> {
    let direction = Vec3::from(direction);
    if direction.norm() == 0.0 || !direction.norm().is_finite() {
        return Err(builder.content(place, "the direction has no length", "write for example [0, 0, -1]"));
    }
    let density = builder.positive_density(place, density)?;
    let name = format!("{region}_acceleration_m_s2");
    let acceleration = builder.signal(place, name, acceleration, Dimension::ACCELERATION)?;
    let cells = builder.cells(place, region)?;
    Ok(Gravity::new(&builder.body.mesh, cells, density, direction.normalize(), acceleration))
}
