//! Starters: project folders with a scene, a study and a page about what to do next.

mod error;
mod folder;
mod shape;

pub use error::StarterError;

use crate::scene::hint;
use std::path::{Path, PathBuf};

/// A project that is ready to run.
pub struct Starter {
    pub name: &'static str,
    pub summary: &'static str,
    scene: &'static str,
    study: &'static str,
    readme: &'static str,
}

/// A starter, given by the name of its folder.
macro_rules! starter {
    ($name:literal, $summary:literal) => {
        Starter {
            name: $name,
            summary: $summary,
            scene: include_str!(concat!($name, "/scene.toml")),
            study: include_str!(concat!($name, "/study.toml")),
            readme: include_str!(concat!($name, "/README.md")),
        }
    };
}

/// All starters.
pub const STARTERS: [Starter; 3] = [
    starter!("finger", "a finger bent by a cable, and which mesh of it can be trusted"),
    starter!("pneunet", "a bending actuator with air chambers, and what its stiffness does"),
    starter!("gripper", "two fingers that hold a ball by friction"),
];

/// Makes a project from the starter of this name, or around a mesh, surface or CAD file, with the given unit of length instead of a guess and the given
/// number of cells instead of the default. Without a folder it is named after the starter or the file. Returns the folder. `progress` receives the
/// output lines of the mesher.
///
/// # Errors
/// No such starter or file, a folder that is not empty or cannot be written, or a shape that cannot be used. Nothing is left behind then.
pub fn create(
    name: &str,
    folder: Option<&Path>,
    (unit, cells): (Option<&str>, Option<usize>),
    progress: &mut dyn FnMut(&str),
) -> Result<PathBuf, StarterError> {
    let starter = STARTERS.iter().find(|starter| starter.name == name);
    let file = Path::new(name);
    if starter.is_none() && !file.is_file() {
        let names: Vec<String> = STARTERS.iter().map(|starter| starter.name.to_string()).collect();
        return Err(StarterError::Unknown { name: name.into(), hint: hint(name, &names) });
    }
    if starter.is_some() && (unit.is_some() || cells.is_some()) {
        return Err(StarterError::OwnMesh { name: name.into() });
    }
    let own = || Some(PathBuf::from(file.file_stem()?));
    let folder = folder.map(Path::to_path_buf).or_else(own).unwrap_or_default();
    folder::make(&folder, |new, title| match starter {
        Some(Starter { scene, study, readme, .. }) => {
            let page = readme.replace("{name}", title);
            folder::write(new, [("scene.toml", scene), ("study.toml", study), ("README.md", &page)])
        }
        None => shape::fill(new, file, title, (unit, cells), progress),
    })?;
    Ok(folder)
}
