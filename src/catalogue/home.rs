//! The folder of the catalogue: a project, or the folder into which the program has unpacked its bundled files.

use super::cache;
use super::embedded::archive;
use super::error::CatalogueError;
use crate::storage;
use std::path::{Path, PathBuf};

/// The folder with `studies`, `data` and `meshes`, and the folders for files that can be made again.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Home {
    pub path: PathBuf,
    /// Folder of generated meshes
    pub meshes: PathBuf,
    /// The Python environment of the mesher, which need not exist
    pub environment: PathBuf,
    pub origin: Origin,
}

/// Reason why this folder is used.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Origin {
    /// DUROMETER_HOME names it
    Named,
    /// The program was built in it
    Checkout,
    /// The program has unpacked its files into it
    Program,
}

impl Home {
    /// The folder that DUROMETER_HOME names; otherwise the checkout in which the program was built, if the program is still in it; otherwise the
    /// unpacked files of the program itself.
    pub fn find() -> Result<Self, CatalogueError> {
        if let Some(named) = std::env::var_os("DUROMETER_HOME") {
            let folder = PathBuf::from(named);
            let is_project = folder.join("meshes/meshgen").is_dir();
            return if is_project {
                Ok(Self::project(folder, Origin::Named))
            } else {
                Err(CatalogueError::NoProject { folder })
            };
        }
        match checkout() {
            Some(folder) => Ok(Self::project(folder, Origin::Checkout)),
            None => Self::of_program(&cache::folder()?),
        }
    }

    /// The folder of a project, which also holds the generated files.
    pub fn project(path: PathBuf, origin: Origin) -> Self {
        Self { meshes: path.join("meshes/cache"), environment: path.join(".venv"), path, origin }
    }

    /// The bundled files, unpacked in a cache. Generated meshes and the environment of the mesher are kept when the program is updated.
    fn of_program(cache: &Path) -> Result<Self, CatalogueError> {
        let (archive, path) = (archive()?, cache::unpacked(cache)?);
        let required = archive.entries().find(|entry| entry.name == "meshes/meshgen/requirements.txt");
        let digest = required.map_or(archive.digest, |entry| entry.sha256);
        let (meshes, environment) = (cache.join("meshes"), cache.join(format!("python-{}", &digest[..8])));
        Ok(Self { path, meshes, environment, origin: Origin::Program })
    }

    /// The folder of the studies.
    pub fn studies(&self) -> PathBuf {
        self.path.join("studies")
    }
}

/// The checkout in which Cargo runs a program, or in whose folder `target` the program is.
fn checkout() -> Option<PathBuf> {
    let of_cargo = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from).filter(|folder| is_checkout(folder));
    of_cargo.or_else(|| {
        let program = std::env::current_exe().ok()?;
        let target = program.ancestors().find(|folder| folder.file_name().is_some_and(|name| name == "target"))?;
        target.parent().filter(|folder| is_checkout(folder) && is_of_one_owner(&program, folder)).map(Path::to_path_buf)
    })
}

/// Whether a folder is a checkout of Durometer.
fn is_checkout(folder: &Path) -> bool {
    let manifest = storage::read_text(&folder.join("Cargo.toml"), storage::TEXT_LIMIT).unwrap_or_default();
    manifest.lines().any(|line| line == "name = \"durometer\"") && folder.join("meshes/meshgen").is_dir()
}

/// Whether program, folder and mesher belong to the same user: a folder open to all users, such as `/tmp`, may hold files of others.
#[cfg(unix)]
fn is_of_one_owner(program: &Path, folder: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let owner = |path: &Path| path.metadata().ok().map(|found| found.uid());
    let of_program = owner(program);
    of_program.is_some()
        && [folder.to_path_buf(), folder.join("meshes/meshgen")].iter().all(|path| owner(path) == of_program)
}

#[cfg(not(unix))]
fn is_of_one_owner(_: &Path, _: &Path) -> bool {
    true
}
