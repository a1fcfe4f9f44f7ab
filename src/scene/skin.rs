//! Skins of a scene: surfaces from files that follow the body and are written with its fields. They have no stiffness and
//! no mass; a traction on one reaches the nodes by the transpose of the map that moves it.

use super::builder::Builder;
use super::error::part;
use super::error::{SceneError, hint};
use super::quantity::Length;
use crate::math::units::{self, Dimension};
use crate::mesh::attach::attach;
use crate::mesh::surface_file::{Surface, read_surface};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A surface that follows the body, to be written with its fields.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SkinSpec {
    pub name: String,
    /// STL or OBJ
    pub file: PathBuf,
    /// Unit of length of the file
    pub unit: String,
    /// Vertices may be this far outside of the body
    pub reach: Length,
}

/// A surface with the nodes that move its vertices.
pub struct NamedSkin {
    pub name: String,
    pub surface: Surface,
    /// \[vertices\] (node, weight), Σ w = 1
    pub weights: Vec<Vec<(u32, f64)>>,
}

impl NamedSkin {
    /// \[3 × vertices\] displacement \[m\] with that of the nodes x.
    pub fn displacement(&self, x: &[f64]) -> Vec<f64> {
        let component =
            |weights: &Vec<(u32, f64)>, i: usize| weights.iter().map(|&(k, w)| w * x[3 * k as usize + i]).sum::<f64>();
        self.weights.iter().flat_map(|w| [0, 1, 2].map(|i| component(w, i))).collect()
    }

    /// (node, area \[m²\]): the areas of the vertices, taken to the nodes by the transpose.
    pub(super) fn nodal_areas(&self) -> Vec<(u32, f64)> {
        let mut nodal = BTreeMap::new();
        for (weights, area) in self.weights.iter().zip(self.surface.areas()) {
            weights.iter().for_each(|&(k, w)| *nodal.entry(k).or_insert(0.0) += w * area);
        }
        nodal.into_iter().filter(|(_, area)| *area != 0.0).collect()
    }
}

/// Reads the skins and attaches them to the body.
pub(super) fn attach_skins(builder: &mut Builder, specs: &[SkinSpec]) -> Result<(), SceneError> {
    for (k, spec) in specs.iter().enumerate() {
        let place = format!("skin {}", k + 1);
        let fits = |c: char| c.is_alphanumeric() || "_-".contains(c);
        if spec.name.is_empty() || !spec.name.chars().all(fits) {
            let fact = format!("\"{}\" cannot be part of a file name", spec.name);
            return Err(builder.content(&place, fact, "use letters, digits, \"-\" and \"_\""));
        }
        if builder.skins.iter().any(|s| s.name == spec.name) {
            let fact = format!("another skin is called \"{}\" too", spec.name);
            return Err(builder.content(&place, fact, "give each skin a `name` of its own"));
        }
        let fail = |e| part(builder.file, &place, e);
        let unit =
            units::parse(&format!("1 {}", spec.unit), Dimension::LENGTH).map_err(|e| part(builder.file, &place, e))?;
        let surface = read_surface(&builder.base.join(&spec.file), unit).map_err(|e| part(builder.file, &place, e))?;
        let weights = attach(&builder.body.mesh, &surface.points, spec.reach.0).map_err(fail)?;
        builder.skins.push(NamedSkin { name: spec.name.clone(), surface, weights });
    }
    Ok(())
}

/// The nodal areas of a skin.
pub(super) fn skin_areas(builder: &Builder, place: &str, name: &str) -> Result<Vec<(u32, f64)>, SceneError> {
    let skin = builder.skins.iter().find(|s| s.name == name).ok_or_else(|| {
        let known: Vec<&String> = builder.skins.iter().map(|s| &s.name).collect();
        builder.content(place, format!("there is no skin \"{name}\""), hint(name, &known))
    })?;
    Ok(skin.nodal_areas())
}
