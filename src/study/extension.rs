//! Meshes that `run --extend` has added to a study: `extension.toml` in the folder of its results.
//!
//! The file has the form of a study file, with `[family.tet10]` and its members in place of `[[family]]`. It belongs to the results: a later run
//! expands the study with it, and the members may be moved to the study file, which then takes precedence.

use crate::scene::{Line, SceneError, changes, from_text, hint, read_table};
use crate::schema::AnyTable;
use crate::study::estimate::power_law::Predicted;
use crate::study::spec::{FamilySpec, refuse};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::de::DeTable;

/// The command that adds the mesh, as messages quote it; the command line replaces `STUDY` by its own study.
pub const ADD: &str = "durometer run STUDY --extend";

/// Name of the file in a folder of results.
pub const FILE: &str = "extension.toml";

/// A mesh to add to a family.
#[derive(Serialize, JsonSchema, Clone, Debug, PartialEq)]
pub struct Extension {
    /// Family of the new member
    pub family: String,
    /// Label of the new member
    pub member: String,
    /// Changes of the new member by path
    #[schemars(with = "AnyTable")]
    pub set: toml::Table,
    /// Approximate number of cells
    pub cells: usize,
    /// Mean cost of a case over the variants \[s\], from the power law of the family; `None` if the family does not have two sizes
    pub cost_s: Option<Predicted>,
    /// Which mesh and why, in words
    pub sentence: String,
}

/// All members added to a study.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Default)]
#[serde(deny_unknown_fields)]
pub struct AddedMeshes {
    /// Family → label → changes by path
    #[serde(rename = "family", default, deserialize_with = "changes::of_series")]
    pub families: BTreeMap<String, toml::Table>,
    /// Family → its line in the file
    #[serde(skip)]
    lines: BTreeMap<String, usize>,
    /// Family and label → the line of the member
    #[serde(skip)]
    member_lines: AddedLines,
}

/// Family and label of each added member → its line in the file of added meshes.
pub type AddedLines = BTreeMap<(String, String), usize>;

impl AddedMeshes {
    /// Path of the file in a folder of results.
    pub fn file(dir: &Path) -> PathBuf {
        dir.join(FILE)
    }

    /// Reads the members added to the results in `dir`; empty if there is no such file.
    pub fn read(dir: &Path) -> Result<Self, SceneError> {
        let file = Self::file(dir);
        if !file.exists() {
            return Ok(Self::default());
        }
        let (text, _) = read_table(&file)?;
        let (lines, member_lines) = lines(&text);
        Ok(Self { lines, member_lines, ..from_text(&file, &text, "")? })
    }

    /// Adds a member to the meshes.
    #[must_use]
    pub fn with(mut self, extension: &Extension) -> Self {
        let members = self.families.entry(extension.family.clone()).or_default();
        members.insert(extension.member.clone(), extension.set.clone().into());
        self
    }

    /// The text of the file.
    pub fn text(&self) -> String {
        let head = format!(
            "# Meshes added by `{ADD}`. Delete this file to take them back, or move its members to the study file.\n\n"
        );
        head + &toml::to_string(self).expect("tables with string keys only")
    }

    /// Adds the members to the families of the study and returns the lines of the file in which they are. A member that the study itself has keeps its
    /// definition there.
    pub fn add_to(&self, families: &mut [FamilySpec], dir: &Path) -> Result<AddedLines, SceneError> {
        let mut added = AddedLines::new();
        for (name, members) in &self.families {
            let known: Vec<String> = families.iter().map(|f| f.name.clone()).collect();
            let Some(family) = families.iter_mut().find(|f| f.name == *name) else {
                let fact = "the study has no such family".to_string();
                let place = at_line(self.lines.get(name), &format!("family {name}"));
                return Err(refuse(&Self::file(dir), (place, fact, hint(name, &known))));
            };
            for (label, set) in members {
                if family.members.contains_key(label) {
                    continue;
                }
                family.members.insert(label.clone(), set.clone());
                let key = (name.clone(), label.clone());
                added.extend(self.member_lines.get(&key).map(|line| (key.clone(), *line)));
            }
        }
        Ok(added)
    }
}

/// A location in the file, with its line if that is known.
pub fn at_line(line: Option<&usize>, place: &str) -> String {
    line.map_or_else(|| place.into(), |line| format!("line {line}: {place}"))
}

/// Finds the lines of the families and of their members.
fn lines(text: &str) -> (BTreeMap<String, usize>, AddedLines) {
    let (mut families, mut members) = (BTreeMap::new(), AddedLines::new());
    let file = DeTable::parse(text).ok();
    let all = file.as_ref().and_then(|file| file.get_ref().get("family")?.get_ref().as_table());
    for (name, family) in all.into_iter().flatten() {
        let family_name = name.get_ref().to_string();
        families.insert(family_name.clone(), Line::of(text, name.span()).number);
        for (label, _) in family.get_ref().as_table().into_iter().flatten() {
            members.insert((family_name.clone(), label.get_ref().to_string()), Line::of(text, label.span()).number);
        }
    }
    (families, members)
}
