//! Skins of a scene: surfaces from files that follow the body and are written with its fields. They have neither stiffness nor mass; a traction on a skin is
//! transferred to the nodes by the transpose of the map that moves it.

use crate::math::units::{self, Dimension};
use crate::mesh::attach::attach;
use crate::mesh::surface_file::read_surface;
use crate::scene::body::surface_unit::Sizes;
use crate::scene::build::builder::Builder;
use crate::scene::build::skin::NamedSkin;
use crate::scene::error::{SceneError, part};
use crate::scene::text::quantity::Length;
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::PathBuf;

/// A surface that follows the body, to be written with its fields.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SkinSpec {
    /// Name by which effects refer to the skin, also used in the names of its files
    pub name: String,
    /// Path of the STL or OBJ file
    pub file: PathBuf,
    /// Unit of length of the file
    pub unit: String,
    /// Largest distance of vertices outside of the body
    pub reach: Length,
}

/// Reads the skins and attaches them to the body.
pub(in crate::scene) fn attach_skins(builder: &mut Builder, specs: &[SkinSpec]) -> Result<(), SceneError> {
    for (k, spec) in specs.iter().enumerate() {
        let place = format!("skin {}", k + 1);
        builder.check_name(&place, &spec.name)?;
        if builder.skins.iter().any(|s| s.name == spec.name) {
            let fact = format!("another skin is called \"{}\" too", spec.name);
            return Err(builder.content(&place, fact, "give each skin a `name` of its own"));
        }
        let unit =
            units::parse(&format!("1 {}", spec.unit), Dimension::LENGTH).map_err(|e| part(builder.file, &place, e))?;
        let surface = read_surface(&builder.base.join(&spec.file), unit).map_err(|e| part(builder.file, &place, e))?;
        let sizes = Sizes { surface: &surface, unit_m: unit, mesh: &builder.body.mesh };
        let attached = attach(&builder.body.mesh, &surface.points, spec.reach.0)
            .map_err(|far| part(builder.file, &place, format!("{far}; {}", sizes.words())))?;
        let doubt = sizes.doubt().map(|words| format!("skin {}: {words}", spec.name));
        let outside = attached.iter().map(|a| a.outside).fold(0.0, f64::max);
        let weights = attached.into_iter().map(|a| a.weights).collect();
        let (name, reach) = (spec.name.clone(), spec.reach.0);
        builder.notes.extend(doubt);
        builder.skins.push(NamedSkin { name, surface, weights, reach, outside });
    }
    Ok(())
}
