//! Identity of a scene: the contents of the files that it names, and everything that a run depends on.

use crate::mesh::format::recognise;
use crate::mesh::generate::referred;
use crate::scene::body::Body;
use crate::scene::read::from_text;
use crate::scene::spec::SceneSpec;
use crate::storage::{self, DATA_LIMIT, sha256};
use serde::{Deserialize, Serialize};
use std::path::Path;
use toml::{Table, Value};

/// A file, identified by its contents.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Eq, Default)]
pub struct FileDigest {
    pub file: String,
    /// Digest of the contents; empty if the file cannot be read
    pub sha256: String,
}

impl FileDigest {
    /// The present contents of a file in a folder.
    pub fn of(base: &Path, file: String) -> Self {
        let sha256 = storage::read(&base.join(&file), DATA_LIMIT).map(sha256).unwrap_or_default();
        Self { file, sha256 }
    }
}

/// Keys under which a scene names files, at any depth.
const KEYS: [&str; 2] = ["file", "reference"];
/// Keys of a scene that a restart may change, since the simulation does not depend on them.
const FREE: [&str; 4] = ["title", "numerics", "output", "compare"];

/// SHA-256 of a scene without the keys that a restart may change, of the contents of all files that the rest names, and of additions from Rust. The text is
/// used if it is that of the specification; the specification itself is used if it was changed or written in Rust.
pub(in crate::scene) fn simulated(file: &Path, text: &str, spec: &SceneSpec, added: &str) -> String {
    let scene = without_free(text.parse().unwrap_or_default());
    let own = printed(spec);
    let is_read = from_text::<SceneSpec>(file, text, "").is_ok_and(|read| printed(&read) == own);
    let (rest, files) = match is_read {
        true => (scene.to_string(), named_files(file, &scene)),
        false => (own.clone(), digests(file, in_printed(&own))),
    };
    sha256(format!("{rest}\n{files:?}{added}"))
}

/// A specification without the keys that a restart may change, as Rust prints it.
fn printed(spec: &SceneSpec) -> String {
    let SceneSpec { title, numerics, output, comparisons, .. } = SceneSpec::default();
    format!("{:?}", SceneSpec { title, numerics, output, comparisons, ..spec.clone() })
}

/// A scene without the keys that a restart may change.
fn without_free(mut scene: Table) -> Table {
    FREE.iter().for_each(|key| drop(scene.remove(*key)));
    scene
}

/// Whether two resolved scenes differ at most in keys that a restart may change.
pub fn same_simulation(text: &str, other: &str) -> bool {
    let [own, known] = [text, other].map(|text| text.parse().map(without_free));
    own.is_ok_and(|own| known.is_ok_and(|known| own == known))
}

/// The files from [`named_files`] that the simulation of a resolved scene depends on: without measured data for comparison.
pub fn simulated_files(scene_file: &Path, text: &str) -> Vec<FileDigest> {
    text.parse().map_or_else(|_| vec![], |scene| named_files(scene_file, &without_free(scene)))
}

/// SHA-256 of the mesh with the cable paths of its body.
pub fn mesh_sha256(body: &Body) -> String {
    sha256(format!("{}{:?}", body.sha256, body.paths))
}

/// The files that a resolved scene names, and those to which its mesh files refer, each once and relative to the file of the scene.
pub fn named_files(scene_file: &Path, scene: &Table) -> Vec<FileDigest> {
    let mut names = vec![];
    in_table(scene, &mut names);
    digests(scene_file, names)
}

/// The files with these names, and those to which mesh files among them refer.
fn digests(scene_file: &Path, mut names: Vec<String>) -> Vec<FileDigest> {
    let base = scene_file.parent().unwrap_or(Path::new(""));
    for other in names.clone().iter().flat_map(|name| referred_names(base, name)) {
        if !names.contains(&other) {
            names.push(other);
        }
    }
    names.into_iter().map(|file| FileDigest::of(base, file)).collect()
}

/// The files to which a mesh file refers; empty for a file that cannot be read, which the run refuses.
fn referred_names(base: &Path, name: &str) -> Vec<String> {
    let path = base.join(name);
    let found = recognise(&path).ok().and_then(|format| referred::names(&path, format.reader.shape().1).ok());
    let relative = |other: &Path| Path::new(name).with_file_name(other).to_string_lossy().into_owned();
    found.unwrap_or_default().iter().map(|other| relative(other)).collect()
}

/// The files that a specification names, from its debug output: `file: "a.csv"`, `file: Some("a.msh")`.
fn in_printed(printed: &str) -> Vec<String> {
    let mut names: Vec<String> = vec![];
    for rest in KEYS.iter().flat_map(|key| printed.split(&format!(" {key}: ")).skip(1).collect::<Vec<_>>()) {
        let quoted = rest.strip_prefix("Some(").unwrap_or(rest).strip_prefix('"');
        match quoted.and_then(|name| name.split('"').next()) {
            Some(name) if !names.iter().any(|n| n == name) => names.push(name.into()),
            _ => {}
        }
    }
    names
}

fn in_table(table: &Table, names: &mut Vec<String>) {
    for (key, value) in table {
        match value.as_str() {
            Some(name) if KEYS.contains(&key.as_str()) => {
                if !names.iter().any(|n| n == name) {
                    names.push(name.into());
                }
            }
            _ => in_value(value, names),
        }
    }
}

fn in_value(value: &Value, names: &mut Vec<String>) {
    match value {
        Value::Table(table) => in_table(table, names),
        Value::Array(values) => values.iter().for_each(|value| in_value(value, names)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_a_scene_counts_by_its_contents() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let scene = folder.path().join("scene.toml");
        std::fs::write(folder.path().join("a.csv"), "0,1\n").expect("room");
        let text = "[x.y]\nfile = \"a.csv\"\n[[z]]\nsignal = { file = \"b.csv\" }\n[[z]]\nsurface.file = \"a.csv\"\n";
        let found = named_files(&scene, &text.parse().expect("a table"));
        assert_eq!(found.iter().map(|f| f.file.as_str()).collect::<Vec<_>>(), ["a.csv", "b.csv"]);
        assert_eq!(found[0].sha256, sha256("0,1\n"));
        assert_eq!(found[1].sha256, "");
        let compared = format!("{text}[[compare]]\nfile = \"measured.csv\"\n");
        assert_eq!(named_files(&scene, &compared.parse().expect("a table")).len(), 3);
        assert_eq!(simulated_files(&scene, &compared), found, "measured data move nothing");
    }

    #[test]
    fn a_scene_is_simulated_alike_whatever_a_restart_may_change() {
        let text = "title = 'a'\n[x]\nE = '1 kPa'\nnu = 0.3\n";
        let freed = "[x]\nnu = 0.3\nE = '1 kPa'\n[output.series]\nevery = '1 s'\n[[compare]]\nfile = 'm.csv'\n";
        assert!(same_simulation(text, freed));
        assert!(!same_simulation(text, &text.replace("1 kPa", "2 kPa")));
        assert!(!same_simulation(text, "") && !same_simulation("x =", "x ="));
    }

    #[test]
    fn files_are_found_in_the_print_of_a_specification() {
        let printed = r#"A { file: "a.csv", mesh: M { file: Some("b.msh"), profile: "c" }, reference: None, more: [B { file: "a.csv" }] }"#;
        assert_eq!(in_printed(printed), ["a.csv", "b.msh"]);
        let text = "[mesh]\nfile = 'm.msh'\nunit = 'mm'\n\
            [mesh.regions.tip]\nkind = 'near'\nfile = 'tip.stl'\nunit = 'mm'\ntolerance = '1 mm'\n\
            [[stage]]\nintegrator = 'static'\nduration = '1 s'\ndt = '1 s'";
        let spec = SceneSpec::from_text(Path::new("scene.toml"), text, "").expect("a scene");
        assert_eq!(in_printed(&super::printed(&spec)), ["m.msh", "tip.stl"]);
    }

    #[test]
    fn the_files_that_a_mesh_file_refers_to_count() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::create_dir(folder.path().join("meshes")).expect("room");
        std::fs::write(folder.path().join("meshes/m.inp"), "*HEADING\n*INCLUDE, INPUT=nodes.inp\n").expect("room");
        std::fs::write(folder.path().join("meshes/nodes.inp"), "*NODE\n").expect("room");
        let text = "[mesh]\nfile = \"meshes/m.inp\"\n";
        let found = named_files(&folder.path().join("scene.toml"), &text.parse().expect("a table"));
        assert_eq!(found[1], FileDigest { file: "meshes/nodes.inp".into(), sha256: sha256("*NODE\n") });
    }
}
