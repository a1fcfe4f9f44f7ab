//! Loads of a scene that have a place: forces on embedded points, tractions on parts of the surface.

use super::build::part;
use super::builder::Builder;
use super::error::SceneError;
use super::quantity::{GuideRadius, Length};
use super::signal::SignalSpec;
use crate::effect::dead_load::{DeadLoad, nodal_areas};
use crate::math::tensor::Vec3;
use crate::math::units::Dimension;
use crate::mesh::embed::{ball_weights, embed};
use crate::scene::skin::skin_areas;

/// A force on an embedded point, or on the patch around it.
pub(super) fn build_point_force(
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

/// A traction on facets of the mesh, or on a skin.
pub(super) fn build_traction(
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
