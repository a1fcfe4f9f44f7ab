//! The studies and scenes of the catalogue.

use super::expand::Study;
use super::listing;
use crate::mesh::generate::MeshStore;
use crate::scene::{MadeMesh, SceneError, made_meshes, read_scene};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// A folder of `studies` with a study, or with only a scene.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Shipped {
    pub name: String,
    /// Kind of the study, or `scene`
    pub kind: String,
    /// Question of the study, or title of the scene
    pub about: String,
    /// Number of cases of the study
    pub cases: usize,
    /// Whether it runs without the mesher
    pub has_meshes: bool,
    pub file: PathBuf,
}

/// All of them, sorted by name; for a folder that cannot be read, its name and the reason.
pub fn shipped(store: &MeshStore) -> Vec<Result<Shipped, (String, SceneError)>> {
    let entries = std::fs::read_dir(store.home.studies()).into_iter().flatten().flatten();
    let mut folders: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(|path| path.is_dir()).collect();
    folders.sort();
    let of_folder = |folder: PathBuf| {
        let (study, scene) = (folder.join("study.toml"), folder.join("scene.toml"));
        let found = match (study.is_file(), scene.is_file()) {
            (true, _) => of_study(&study, store),
            (_, true) => of_scene(&scene, store),
            _ => return None,
        };
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Some(found.map_err(|e| (name, e)))
    };
    folders.into_iter().filter_map(of_folder).collect()
}

fn of_study(file: &Path, store: &MeshStore) -> Result<Shipped, SceneError> {
    let study = Study::read(file, &[])?;
    Ok(Shipped {
        name: study.name.clone(),
        kind: study.record.kind.to_string(),
        about: study.record.question.clone(),
        cases: study.cases.len(),
        has_meshes: are_stored(&listing::made_meshes(&study, store)?),
        file: file.into(),
    })
}

fn are_stored(meshes: &[MadeMesh]) -> bool {
    meshes.iter().all(|mesh| mesh.stored.is_some())
}

fn of_scene(file: &Path, store: &MeshStore) -> Result<Shipped, SceneError> {
    let (scene, _) = read_scene(file, &[])?;
    let folder = file.parent().and_then(Path::file_name).unwrap_or_default();
    Ok(Shipped {
        name: folder.to_string_lossy().into_owned(),
        kind: "scene".into(),
        about: scene.title.clone(),
        cases: 1,
        has_meshes: are_stored(&made_meshes(file, &scene.mesh, store)?),
        file: file.into(),
    })
}
