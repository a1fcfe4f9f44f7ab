//! Selector `near`: everything near a surface from a file.

use super::part::{Ground, PickSpec, Refusal, SelectedEntities, SelectorPart};
use super::place::{RuleSpec, at_surface};
use crate::math::units::{self, Dimension};
use crate::mesh::distance::Nearest;
use crate::mesh::surface_file::read_surface;
use crate::scene::body::surface_unit::Sizes;
use crate::scene::text::quantity::Length;
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::PathBuf;

/// The layer within `tolerance` of a surface, on both sides of it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NearSelector {
    /// Path of the STL or OBJ file
    pub file: PathBuf,
    /// Unit of length of the file
    pub unit: String,
    /// Half the thickness of the layer
    pub tolerance: Length,
    /// Kind of entities that are selected
    #[serde(default)]
    pub pick: PickSpec,
    /// Rule for facets or cells at the border; it is required for both
    pub rule: Option<RuleSpec>,
}

impl SelectorPart for NearSelector {
    fn find(&self, ground: &Ground) -> Result<SelectedEntities, Refusal> {
        let tolerance = self.tolerance.0;
        if tolerance < 0.0 {
            let fact = format!("the tolerance is {} mm", tolerance * 1e3);
            return Err(Refusal::new(fact, "it must not be negative"));
        }
        let unit = units::parse(&format!("1 {}", self.unit), Dimension::LENGTH)
            .map_err(|e| Refusal::new(e.to_string(), "write for example unit = \"mm\""))?;
        let surface = read_surface(&ground.base.join(&self.file), unit)
            .map_err(|e| Refusal::new(e.to_string(), "or remove the region"))?;
        let nearest = Nearest::new(&surface).ok_or_else(|| {
            Refusal::new(format!("{} holds no triangle", self.file.display()), "give another surface")
        })?;
        let found = at_surface(ground, (&self.words(), tolerance), (self.pick, self.rule), &|x, margin| {
            nearest.of(x).distance <= tolerance + margin
        })?;
        let sizes = Sizes { surface: &surface, unit_m: unit, mesh: ground.mesh };
        if found.entities.is_empty() {
            return Err(Refusal::new(format!("{} holds no {}", self.words(), found.pick.words()), sizes.words()));
        }
        Ok(SelectedEntities { note: sizes.doubt().or(found.note), ..found })
    }

    fn words(&self) -> String {
        format!("the layer within {} mm of {}", self.tolerance.0 * 1e3, self.file.display())
    }
}
