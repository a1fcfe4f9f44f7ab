//! Meshes that `run --extend` has added to a study: `extension.toml` in the folder of its results.
//!
//! The file has the form of a study file, `[family.tet10]` with members in place of `[[family]]`. It belongs to the results: a later run
//! expands the study with it, and the members may be moved to the study file, which then takes precedence.

use crate::scene::{SceneError, from_text, hint, read_table};
use crate::schema::AnyTable;
use crate::study::estimate::growth::Predicted;
use crate::study::spec::{FamilySpec, refuse};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A mesh to be added to a family.
#[derive(Serialize, JsonSchema, Clone, Debug, PartialEq)]
pub struct Extension {
    /// Family that takes the new member
    pub family: String,
    /// Label of the new member
    pub member: String,
    /// Its changes by path
    #[schemars(with = "AnyTable")]
    pub set: toml::Table,
    /// Cells, about
    pub cells: usize,
    /// Cost of one case \[s\], by the law of growth of the family; none where it has no two sizes
    pub cost_s: Option<Predicted>,
    /// In words: which mesh, and why
    pub sentence: String,
}

/// All members that were added to a study.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Default)]
#[serde(deny_unknown_fields)]
pub struct Additions {
    /// Family → label → changes by path
    #[serde(rename = "family", default)]
    pub families: BTreeMap<String, toml::Table>,
}

impl Additions {
    /// The file of a folder of results.
    pub fn file(dir: &Path) -> PathBuf {
        dir.join("extension.toml")
    }

    /// The members that were added to the results in `dir`, none where there is no such file.
    pub fn read(dir: &Path) -> Result<Self, SceneError> {
        let file = Self::file(dir);
        if !file.exists() {
            return Ok(Self::default());
        }
        let (text, _) = read_table(&file)?;
        from_text(&file, &text, "")
    }

    /// With another member.
    #[must_use]
    pub fn with(mut self, extension: &Extension) -> Self {
        let members = self.families.entry(extension.family.clone()).or_default();
        members.insert(extension.member.clone(), extension.set.clone().into());
        self
    }

    /// The text of the file.
    pub fn text(&self) -> String {
        let head = "# Meshes added by `durometer run STUDY --extend`. Delete this file to take them back, or move its members to the study file.\n\n";
        head.to_string() + &toml::to_string(self).expect("tables with string keys only")
    }

    /// Adds the members to the families of the study; one that the study has itself stays as it is there.
    pub fn add_to(&self, families: &mut [FamilySpec], dir: &Path) -> Result<(), SceneError> {
        for (name, members) in &self.families {
            let known: Vec<String> = families.iter().map(|f| f.name.clone()).collect();
            let Some(family) = families.iter_mut().find(|f| f.name == *name) else {
                let fact = "the study has no such family".to_string();
                return Err(refuse(&Self::file(dir), (format!("family {name}"), fact, hint(name, &known))));
            };
            for (label, set) in members {
                family.members.entry(label.clone()).or_insert_with(|| set.clone());
            }
        }
        Ok(())
    }
}
