//! Identity of a result: its resolved scene, the contents of every file that it reads, its mesh, and the build that computed it.

use crate::scene::Body;
use crate::storage::{self, DATA_LIMIT, sha256};
use serde::{Deserialize, Serialize};
use std::path::Path;
use toml::Value;

/// A file by its contents.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Eq, Default)]
pub struct FileDigest {
    pub file: String,
    /// Empty where the file cannot be read
    pub sha256: String,
}

/// The program that computed a result.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Eq, Default)]
pub struct Build {
    pub version: String,
    /// SHA-256 of the sources, with the versions of all dependencies
    pub source_sha256: String,
    /// Compiler, target and optimisation
    pub compiler: String,
    /// The instructions of the processor that the numerics choose by
    pub cpu: String,
}

impl Build {
    /// This program on this machine.
    pub fn this() -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").into(),
            source_sha256: env!("DUROMETER_SOURCE_SHA256").into(),
            compiler: env!("DUROMETER_COMPILER").into(),
            cpu: cpu(),
        }
    }

    /// `0.1.0, sources 4f2a…, rustc 1.90.0 …, x86_64 with avx2`
    pub fn words(&self) -> String {
        if self.version.is_empty() {
            return "of an unknown build".into();
        }
        let source = self.source_sha256.get(..12).unwrap_or("unknown");
        format!("{}, sources {source}, {}, {}", self.version, self.compiler, self.cpu)
    }
}

fn cpu() -> String {
    let mut found: Vec<&str> = vec![];
    #[cfg(target_arch = "x86_64")]
    {
        let features = [
            ("avx2", std::is_x86_feature_detected!("avx2")),
            ("fma", std::is_x86_feature_detected!("fma")),
            ("avx512f", std::is_x86_feature_detected!("avx512f")),
        ];
        found.extend(features.iter().filter(|(_, has)| *has).map(|(name, _)| *name));
    }
    found.insert(0, std::env::consts::ARCH);
    found.join(" ")
}

/// Everything that decides the result of a case, apart from the build.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Eq, Default)]
pub struct Identity {
    /// SHA-256 of all the rest
    pub sha256: String,
    /// Files that the scene names, in its order
    pub files: Vec<FileDigest>,
    /// SHA-256 of the mesh with the cable paths of its body; empty before the mesh exists
    pub mesh_sha256: String,
}

impl Identity {
    /// Of a resolved scene, of what is `asked` in addition, as a digest, and of its mesh, by [`mesh_sha256`].
    pub fn of(scene_file: &Path, text: &str, asked: &str, mesh_sha256: String) -> Self {
        let files = files(scene_file, text);
        let mut all = format!("{:?}", (text, asked, &mesh_sha256));
        files.iter().for_each(|f| all += &format!("{:?}", (&f.file, &f.sha256)));
        Self { sha256: sha256(all), files, mesh_sha256 }
    }
}

/// SHA-256 of the mesh with the cable paths of its body.
pub fn mesh_sha256(body: &Body) -> String {
    sha256(format!("{}{:?}", body.sha256, body.paths))
}

/// Keys under which a scene names files, wherever they are.
const KEYS: [&str; 2] = ["file", "reference"];

/// The files that a resolved scene names: relative to the scene.
fn files(scene_file: &Path, text: &str) -> Vec<FileDigest> {
    let base = scene_file.parent().unwrap_or(Path::new(""));
    let mut names = vec![];
    if let Ok(table) = text.parse() {
        named(&Value::Table(table), &mut names);
    }
    let digest = |file: String| {
        let sha256 = storage::read(&base.join(&file), DATA_LIMIT).map(sha256).unwrap_or_default();
        FileDigest { file, sha256 }
    };
    names.into_iter().map(digest).collect()
}

fn named(value: &Value, names: &mut Vec<String>) {
    match value {
        Value::Table(table) => {
            for (key, value) in table {
                match value.as_str() {
                    Some(name) if KEYS.contains(&key.as_str()) => {
                        if !names.iter().any(|n| n == name) {
                            names.push(name.into());
                        }
                    }
                    _ => named(value, names),
                }
            }
        }
        Value::Array(values) => values.iter().for_each(|value| named(value, names)),
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
        let found = files(&scene, text);
        assert_eq!(found.iter().map(|f| f.file.as_str()).collect::<Vec<_>>(), ["a.csv", "b.csv"]);
        assert_eq!(found[0].sha256, sha256("0,1\n"));
        assert_eq!(found[1].sha256, "");
    }

    #[test]
    fn a_build_names_its_sources() {
        let this = Build::this();
        assert_eq!(this.source_sha256.len(), 64);
        assert_eq!(Build::default().words(), "of an unknown build");
        assert!(this.compiler.starts_with("rustc ") && this.words().contains(&this.source_sha256[..12]), "{this:?}");
    }
}
