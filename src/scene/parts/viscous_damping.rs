//! Damping of a region by a viscosity.

use crate::effect::ViscousDamping;
use crate::scene::builder::Builder;
use crate::scene::error::SceneError;

/// Viscous damping of the cells of a region.
pub(in crate::scene) fn build_viscous_damping(
    builder: &Builder,
    place: &str,
    region: &str,
    eta: f64,
) -> Result<ViscousDamping, SceneError> {
    if eta < 0.0 {
        return Err(builder.content(place, format!("eta is {eta} Pa s"), "a viscosity is not negative"));
    }
    Ok(ViscousDamping::new(&builder.body.mesh, builder.cells(place, region)?, eta))
}
