//! The starter around a shape: a mesh, surface or CAD file of the user.

use super::error::StarterError;
use super::folder::write;
use crate::mesh::format::recognise;
use crate::mesh::generate::GenerateError;
use crate::mesh::generate::referred::{self, names};
use crate::scene::{Import, SceneError, starter};
use std::path::{Component, Path};

/// Fills the folder of a project with a copy of the file, a scene that holds the body at one end under its own weight, a study and a page.
pub(super) fn fill(
    folder: &Path,
    file: &Path,
    title: &str,
    (unit, cells): (Option<&str>, Option<usize>),
    progress: &mut dyn FnMut(&str),
) -> Result<(), StarterError> {
    let format = recognise(file).map_err(SceneError::Mesh)?;
    let copy = folder.join(file.file_name().unwrap_or_default());
    std::fs::copy(file, &copy).map_err(|e| StarterError::io(file, &e))?;
    copy_referred(folder, file, format.reader.shape().1)?;
    // Messages must name the file of the user
    let mut import = Import::of(file, unit, progress)?;
    if let Some(cells) = cells {
        import = import.with_cells(cells)?;
    }
    let imported = import.load(progress)?;
    let scene = starter(&Import { file: copy.clone(), ..import.clone() }, &imported, folder);
    // Only a shape that is meshed here can have finer meshes
    let (study, question) = match import.spec.cells {
        Some(cells) => (convergence(cells), "which mesh can be trusted with the elastic energy"),
        None => (include_str!("shape/sweep.toml").to_string(), "how the elastic energy depends on the stiffness"),
    };
    let name = copy.file_name().unwrap_or_default().to_string_lossy();
    let page = include_str!("shape/README.md")
        .replace("{name}", title)
        .replace("{file}", &name)
        .replace("{question}", question);
    write(folder, [("scene.toml", &scene), ("study.toml", &study), ("README.md", &page)])
}

/// Copies the files to which a mesh file refers, under the same names; files with an absolute path can be found from everywhere.
fn copy_referred(folder: &Path, file: &Path, format: &str) -> Result<(), StarterError> {
    let from = referred::folder(file, format)?;
    for name in names(file, format)?.iter().filter(|name| name.is_relative()) {
        if name.components().any(|c| c == Component::ParentDir) {
            let fact = format!("it refers to {}, which is in a folder above its own", name.display());
            let remedy = "put both in one folder, and change the name in the file".to_string();
            return Err(GenerateError::Refers { file: file.into(), fact, remedy }.into());
        }
        let (from, to) = (from.join(name), folder.join(name));
        std::fs::create_dir_all(to.parent().unwrap_or(folder)).map_err(|e| StarterError::io(&to, &e))?;
        std::fs::copy(&from, &to).map_err(|e| StarterError::io(&from, &e))?;
    }
    Ok(())
}

/// The study with meshes of `cells` cells, and of 2.5 and 6 times as many.
fn convergence(cells: usize) -> String {
    let member = |cells: usize| format!("{cells} = {{ \"mesh.cells\" = {cells} }}\n");
    // The file ends with the header of the table of members
    include_str!("shape/convergence.toml").to_string() + &[cells, cells * 5 / 2, cells * 6].map(member).concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_study_has_three_meshes_for_every_number_of_cells() {
        for cells in [1, 2000, 4800, 5000, 12000] {
            let study: toml::Table = convergence(cells).parse().unwrap_or_else(|e| panic!("{cells}: {e}"));
            let members = study["family"][0]["members"].as_table().expect("a table");
            let mut numbers: Vec<i64> =
                members.values().map(|m| m["mesh.cells"].as_integer().expect("a number")).collect();
            numbers.sort_unstable();
            let cells = cells as i64;
            assert_eq!(numbers, [cells, cells * 5 / 2, cells * 6]);
            assert!(numbers.iter().all(|n| members.contains_key(&n.to_string())), "{members:?}");
        }
    }

    #[test]
    fn the_files_that_a_mesh_file_refers_to_are_copied_with_it() {
        let (from, to) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
        let file = from.path().join("m.inp");
        std::fs::create_dir(from.path().join("parts")).expect("room");
        std::fs::write(from.path().join("parts/nodes.inp"), "*NODE\n").expect("room");
        std::fs::write(&file, "*INCLUDE, INPUT=parts/nodes.inp\n").expect("room");
        copy_referred(to.path(), &file, "abaqus").unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(std::fs::read_to_string(to.path().join("parts/nodes.inp")).expect("a copy"), "*NODE\n");
        std::fs::write(&file, "*INCLUDE, INPUT=parts/../parts/nodes.inp\n").expect("room");
        let error = copy_referred(to.path(), &file, "abaqus").expect_err("above").to_string();
        assert!(error.contains("folder above its own; put both in one folder"), "{error}");
    }
}
