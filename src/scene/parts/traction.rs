//! A traction on a part of the surface, per reference area.

use crate::effect::dead_load::{DeadLoad, nodal_areas};
use crate::math::units::Dimension;
use crate::scene::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::signal::SignalSpec;
use crate::scene::skin::skin_areas;

/// A traction on facets of the mesh, or on a skin.
pub(in crate::scene) fn build_traction(
    builder: &mut Builder,
    place: &str,
    name: &str,
    on: (&Option<String>, &Option<String>),
    direction: [f64; 3],
    traction: &SignalSpec,
) -> Result<DeadLoad, SceneError> {
    let weights = match on {
        (Some(region), None) => {
            let facets = &builder.region(place, region)?.facets;
            if facets.is_empty() {
                let fact = format!("region \"{region}\" holds no facets");
                let remedy = "a traction acts on a part of the surface: take a facet region";
                return Err(builder.content(place, fact, remedy));
            }
            nodal_areas(&builder.body.mesh, facets)
        }
        (None, Some(skin)) => skin_areas(builder, place, skin)?,
        _ => {
            let fact = "a traction acts on one surface";
            return Err(builder.content(place, fact, "give either `region` (facets of the mesh) or `skin`"));
        }
    };
    let column = format!("{name}_imposed_Pa");
    let (direction, signal) = builder.dead(place, direction, traction, Dimension::PRESSURE, column)?;
    Ok(DeadLoad::new(name.into(), &weights, direction, signal))
}
