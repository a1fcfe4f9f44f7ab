//! Cases that a study requests once it has the results of others: `growth.json` in the folder of its results.
//!
//! Each round adds members to a family, with a record of why. The file belongs to the results: a later run expands the study with it and continues from
//! there. It is valid for one study file, scene and build of the program; for others it is ignored, and the search starts again.

use crate::report::files;
use crate::scene::{SceneError, named_files, read_scene, read_table};
use crate::storage::sha256;
use crate::study::spec::FamilySpec;
use crate::study::store::identity::Build;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Name of the file in a folder of results.
pub const FILE: &str = "growth.json";

/// Members that were requested together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Round {
    /// Family of the new members
    pub family: String,
    /// Label → changes by path; empty if the search has ended
    pub members: BTreeMap<String, toml::Table>,
    /// The findings at this point, for the report
    pub record: Value,
}

/// All rounds of a study.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rounds {
    /// Digest of the inputs to which they belong
    pub of: String,
    pub rounds: Vec<Round>,
}

impl Rounds {
    fn file(dir: &Path) -> PathBuf {
        dir.join(FILE)
    }

    /// Reads the rounds of the results in `dir`; empty if there is no file, or one that cannot be read.
    pub fn read(dir: &Path) -> Self {
        files::json(&Self::file(dir)).ok().flatten().unwrap_or_default()
    }

    /// Adds a round and writes the file.
    ///
    /// # Errors
    ///
    /// A folder that cannot be written.
    pub fn add(mut self, of: &str, round: Round, dir: &Path) -> Result<(), String> {
        if self.of != of {
            self = Self { of: of.into(), rounds: vec![] };
        }
        self.rounds.push(round);
        let text = serde_json::to_string_pretty(&self).expect("numbers, strings and string keys only") + "\n";
        files::write(&Self::file(dir), text.as_bytes()).map_err(|e| e.to_string())
    }

    /// Whether the last round requested no further case.
    pub fn has_ended(&self) -> bool {
        self.rounds.last().is_some_and(|round| round.members.is_empty())
    }

    /// The changes of a member that was added.
    pub fn member(&self, family: &str, label: &str) -> Option<&toml::Table> {
        self.rounds.iter().filter(|round| round.family == family).find_map(|round| round.members.get(label))
    }

    /// Removes the rounds of another study, scene or program.
    pub fn keep_only(self, of: &str, dir: &Path) -> Self {
        if self.of == of || self.rounds.is_empty() {
            return self;
        }
        // A file that cannot be removed is ignored, and overwritten later
        std::fs::remove_file(Self::file(dir)).ok();
        Self::default()
    }

    /// Adds the members to the families of a study with this digest.
    pub fn add_to(&self, families: &mut [FamilySpec], of: &str) {
        for round in self.rounds.iter().filter(|_| self.of == of) {
            for family in families.iter_mut().filter(|family| family.name == round.family) {
                let members = round.members.iter().map(|(label, set)| (label.clone(), set.clone().into()));
                family.members.extend(members);
            }
        }
    }
}

/// Digest of the inputs of a search: the details of the study, the columns that it requests, its scene with everything that this includes and names,
/// the changes to it, and the program.
pub fn digest(
    details: &Value,
    columns: &[&str],
    scene: &Path,
    changes: &[(String, toml::Value)],
) -> Result<String, SceneError> {
    // A scene that its study completes is not yet complete itself
    let text = match read_scene(scene, changes) {
        Ok((_, text)) => text,
        Err(_) => read_table(scene)?.0,
    };
    let files = text.parse().map_or_else(|_| vec![], |table| named_files(scene, &table));
    let build = serde_json::to_string(&Build::this()).expect("strings only");
    Ok(sha256(format!("{:?}", (details.to_string(), columns, text, files, changes, build))))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = r#"
[mesh.grid]
kind = "box"
size = ["40 mm", "10 mm", "10 mm"]
divisions = [4, 1, 1]
[laws.rubber]
include = "law.toml"
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "prescribed"
region = "xmax"
components = "x"
displacement = { kind = "table", file = "signal.csv", unit = "mm" }
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
"#;

    #[test]
    fn a_search_depends_on_all_that_its_scene_includes_and_names() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let scene = folder.path().join("scene.toml");
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("room");
        write("scene.toml", SCENE);
        write("law.toml", "law = \"neo_hookean\"\nmu = \"60 kPa\"\nnu = 0.45\n");
        write("signal.csv", "t,u\n0,0\n1,2\n");
        assert!(read_scene(&scene, &[]).is_ok(), "{:?}", read_scene(&scene, &[]).err());
        let of = |columns: &[&str]| digest(&Value::Null, columns, &scene, &[]).expect("a scene");
        let mut seen = vec![of(&["xmax_z_m"])];
        assert_eq!(of(&["xmax_z_m"]), seen[0]);
        seen.push(of(&["xmax_x_m"]));
        write("law.toml", "law = \"neo_hookean\"\nmu = \"50 kPa\"\nnu = 0.45\n");
        seen.push(of(&["xmax_z_m"]));
        write("signal.csv", "t,u\n0,0\n1,4\n");
        seen.push(of(&["xmax_z_m"]));
        let different: std::collections::BTreeSet<&String> = seen.iter().collect();
        assert_eq!(different.len(), seen.len());
    }
}
