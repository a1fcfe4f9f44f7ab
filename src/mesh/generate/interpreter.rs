//! The Python interpreter that runs the mesher, on every system.

use crate::catalogue::host;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Returns DUROMETER_PYTHON, or else the Python that has loaded this program as a package, or else that of an environment if it is set up, or else
/// that of the system.
pub fn of(environment: &Path) -> PathBuf {
    let given =
        std::env::var_os("DUROMETER_PYTHON").map(PathBuf::from).or_else(|| host::python().map(Path::to_path_buf));
    given.unwrap_or_else(|| Some(in_environment(environment)).filter(|own| own.exists()).unwrap_or_else(of_system))
}

/// Returns the Python of a `venv` environment.
pub fn in_environment(environment: &Path) -> PathBuf {
    environment.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" })
}

/// Returns the first Python in the folders of the path; on Windows the launcher `py` comes first, which starts the newest version.
pub fn of_system() -> PathBuf {
    let names: &[&str] = if cfg!(windows) { &["py.exe", "python.exe", "python3.exe"] } else { &["python3", "python"] };
    first_of(names, std::env::var_os("PATH").unwrap_or_default()).unwrap_or_else(|| names[0].into())
}

/// Returns the first of these programs in the folders of `path`. An empty program is a placeholder of the Windows Store, which would open a window.
fn first_of(names: &[&str], path: OsString) -> Option<PathBuf> {
    let folders: Vec<PathBuf> = std::env::split_paths(&path).filter(|folder| folder.is_absolute()).collect();
    let is_program = |file: &PathBuf| file.metadata().is_ok_and(|found| found.is_file() && found.len() > 0);
    names.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name))).find(is_program)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_name_in_any_folder_comes_before_the_second() {
        let keep = tempfile::tempdir().expect("a temporary folder");
        let folders = ["a b", "c"].map(|name| keep.path().join(name));
        for (folder, name, text) in [(0, "python", "x"), (1, "python3", "x"), (0, "py", "")] {
            std::fs::create_dir_all(&folders[folder]).expect("writable");
            std::fs::write(folders[folder].join(name), text).expect("writable");
        }
        let path = std::env::join_paths(&folders).expect("no separators in them");
        let first = |names: &[&str]| first_of(names, path.clone());
        assert_eq!(first(&["python3", "python"]), Some(folders[1].join("python3")));
        assert_eq!(first(&["py", "python"]), Some(folders[0].join("python")), "a place holder is no program");
        assert_eq!(first(&["ruby"]), None);
        assert_eq!(first_of(&["python"], "relative:".into()), None, "a program of the current folder may be anyone's");
    }
}
