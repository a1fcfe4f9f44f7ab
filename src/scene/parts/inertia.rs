//! Inertia and mass-proportional damping of a region.

use crate::effect::{Inertia, Mass, MassDamping};
use crate::scene::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::spec::LumpingSpec;

/// The mass matrix of the cells of a region.
fn mass(builder: &Builder, place: &str, region: &str, density: f64, lumping: LumpingSpec) -> Result<Mass, SceneError> {
    let cells = builder.cells(place, region)?;
    let density = builder.positive_density(place, density)?;
    Ok(Mass::new(&builder.body.mesh, cells, density, lumping.into()))
}

/// Inertia of a region.
pub(in crate::scene) fn build_inertia(
    builder: &Builder,
    place: &str,
    region: &str,
    density: f64,
    lumping: LumpingSpec,
) -> Result<Inertia, SceneError> {
    Ok(Inertia { mass: mass(builder, place, region, density, lumping)? })
}

/// Damping α M of a region.
pub(in crate::scene) fn build_mass_damping(
    builder: &Builder,
    place: &str,
    region: &str,
    (density, lumping): (f64, LumpingSpec),
    alpha: f64,
) -> Result<MassDamping, SceneError> {
    if alpha < 0.0 {
        return Err(builder.content(place, format!("alpha is {alpha} 1/s"), "damping is not negative"));
    }
    Ok(MassDamping { alpha, mass: mass(builder, place, region, density, lumping)? })
}
