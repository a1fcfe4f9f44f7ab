//! Identity of a result: its resolved scene, the contents of every file that it reads, its mesh, and the build that computed it.

use crate::scene::{FileDigest, named_files};
use crate::storage::sha256;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The program that computed a result.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Eq, Default)]
pub struct Build {
    pub version: String,
    /// SHA-256 of the sources, with the versions of all dependencies
    pub source_sha256: String,
    /// Compiler, target and level of optimisation
    pub compiler: String,
    /// The processor instructions that select the numerical kernels
    pub cpu: String,
}

impl Build {
    /// The running program on this machine.
    pub fn this() -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").into(),
            source_sha256: env!("DUROMETER_SOURCE_SHA256").into(),
            compiler: env!("DUROMETER_COMPILER").into(),
            cpu: cpu(),
        }
    }

    /// The build in words: `0.1.0, sources 4f2a…, rustc 1.90.0 …, x86_64 with avx2`.
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

/// Everything that determines the result of a case, apart from the build.
#[derive(Serialize, Deserialize, Clone, Debug, Default)]
pub struct Identity {
    /// SHA-256 of all the other fields
    pub sha256: String,
    /// SHA-256 of all inputs except the mesh, which is known before the mesh exists; empty in records of earlier versions
    #[serde(default)]
    pub inputs_sha256: String,
    /// Files that the scene names, in the order of the scene
    pub files: Vec<FileDigest>,
    /// SHA-256 of the mesh with the cable paths of its body; empty before the mesh exists
    pub mesh_sha256: String,
    /// SHA-256 of the meshes of further curves of a calibration, each with its cable paths
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub curves_mesh_sha256: Vec<String>,
}

impl PartialEq for Identity {
    fn eq(&self, other: &Self) -> bool {
        self.sha256 == other.sha256
    }
}

impl Eq for Identity {}

impl Identity {
    /// The identity of a resolved scene, of what is `asked` in addition, as a digest, and of the digests by [`crate::scene::mesh_sha256`] of its mesh
    /// and those of further curves; `meshes` is empty before they exist.
    pub fn of(scene_file: &Path, text: &str, asked: &str, meshes: &[String]) -> Self {
        let files = text.parse().map_or_else(|_| vec![], |scene| named_files(scene_file, &scene));
        let named: String = files.iter().map(|f| format!("{:?}", (&f.file, &f.sha256))).collect();
        let with = |mesh: &str| sha256(format!("{:?}{named}", (text, asked, mesh)));
        let (all, inputs_sha256) = (with(&meshes.join(" ")), with(""));
        let mesh_sha256 = meshes.first().cloned().unwrap_or_default();
        Self {
            sha256: all,
            inputs_sha256,
            files,
            mesh_sha256,
            curves_mesh_sha256: meshes.iter().skip(1).cloned().collect(),
        }
    }

    /// The digests of its mesh and of the meshes of further curves.
    pub fn meshes(&self) -> Vec<String> {
        std::iter::once(&self.mesh_sha256).chain(&self.curves_mesh_sha256).cloned().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_build_names_its_sources() {
        let this = Build::this();
        assert_eq!(this.source_sha256.len(), 64);
        assert_eq!(Build::default().words(), "of an unknown build");
        assert!(this.compiler.starts_with("rustc ") && this.words().contains(&this.source_sha256[..12]), "{this:?}");
    }
}
