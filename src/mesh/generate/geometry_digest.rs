//! Digest of the sources of a body's CAD: the files of its folder, and those of the adjacent modules that it imports.

use crate::storage::{self, DATA_LIMIT, sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The mesher itself, whose changes are tracked separately, and the folder of generated meshes.
const NO_GEOMETRY: [&str; 2] = ["meshgen", "cache"];

/// (Module, name in its folder, SHA-256) of a file → its path.
type Files = BTreeMap<(String, String, String), PathBuf>;

/// Returns the SHA-256 of the files in the folder of a body and of the modules that its Python code imports from `meshes`; `None` for a body without
/// Python code.
///
/// A table or profile read by the Python code is included if it lies in one of these folders.
pub(super) fn geometry_sha256(home: &Path, body: &str) -> Option<String> {
    let all = files(home, body);
    let has_python = all.values().any(|file| is_python(file));
    has_python.then(|| sha256(format!("{:?}", all.keys().collect::<BTreeSet<_>>())))
}

/// Returns the files that enter the digest `geometry_sha256`.
pub fn geometry_files(home: &Path, body: &str) -> impl Iterator<Item = PathBuf> {
    files(home, body).into_values()
}

fn files(home: &Path, body: &str) -> Files {
    let meshes = home.join("meshes");
    let (mut open, mut seen) = (vec![body.to_string()], BTreeSet::new());
    let mut all = Files::new();
    while let Some(module) = open.pop() {
        if NO_GEOMETRY.contains(&module.as_str()) || !seen.insert(module.clone()) {
            continue;
        }
        let folder = meshes.join(&module);
        let mut files = vec![];
        collect(&folder, &mut files);
        let single = meshes.join(format!("{module}.py"));
        files.extend(single.is_file().then_some(single));
        for file in files {
            // Independent of the location of the home
            let inside = file.strip_prefix(&folder).or(file.strip_prefix(&meshes)).expect("below the meshes");
            let name = inside.to_string_lossy().replace('\\', "/");
            // Files that cannot be read are left to the mesher
            let Ok(bytes) = storage::read(&file, DATA_LIMIT) else { continue };
            if is_python(&file) {
                open.extend(imported(&String::from_utf8_lossy(&bytes)));
            }
            all.insert((module.clone(), name, sha256(&bytes)), file);
        }
    }
    all
}

fn is_python(file: &Path) -> bool {
    file.extension().is_some_and(|end| end == "py")
}

/// Collects the files below a folder on which a geometry can depend.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for path in std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if name.starts_with('.') || name == "__pycache__" || name == "body.toml" || is_made(&name) {
            continue;
        }
        match path.is_dir() {
            true => collect(&path, files),
            false => files.push(path),
        }
    }
}

/// Whether this is the name of a committed mesh or of its manifest: 16 hex digits and an extension.
pub(super) fn is_made(name: &str) -> bool {
    let (stem, ending) = name.split_once('.').unwrap_or((name, ""));
    let is_name = stem.len() == 16 && stem.bytes().all(|b| b.is_ascii_hexdigit());
    is_name && ["msh.gz", "json"].contains(&ending)
}

/// Returns the top-level names of the modules that a Python file imports: `finger` for `from finger.geometry import build`. A line of a string may
/// look like an import, but the result is never used as a path.
fn imported(text: &str) -> impl Iterator<Item = String> {
    let modules = text.lines().filter_map(|line| {
        let line = line.trim_start();
        line.strip_prefix("from ")
            .map(|rest| rest.split(" import").next().unwrap_or(rest))
            .or(line.strip_prefix("import "))
    });
    modules.flat_map(|list| list.split(',')).filter_map(|module| {
        let is_of_name = |c: char| c.is_alphanumeric() || c == '_';
        let first = module.split(|c| !is_of_name(c)).find(|part| !part.is_empty())?;
        Some(first.to_string())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modules_are_found_in_every_form_of_import() {
        let text = "import gmsh, beam.geometry as b\nfrom finger.geometry import build, x\nif True:\n    from block import geometry\n# import none\nfrom /tmp/x\n";
        let found: Vec<String> = imported(text).collect();
        assert_eq!(found, ["gmsh", "beam", "finger", "block", "tmp"]);
    }

    #[test]
    fn all_that_the_python_can_read_counts_and_made_meshes_do_not() {
        let home = tempfile::tempdir().expect("a temporary folder");
        let write = |name: &str, text: &str| {
            let file = home.path().join("meshes").join(name);
            std::fs::create_dir_all(file.parent().expect("below the home")).expect("room");
            std::fs::write(file, text).expect("room");
        };
        let digest = || geometry_sha256(home.path(), "rib");
        assert_eq!(digest(), None);
        write("rib/profile.csv", "0,1\n");
        assert_eq!(digest(), None, "no Python");
        write("rib/geometry.py", "from shared.dims import SCALE\nimport single, numpy\n");
        let mut before = digest();
        assert!(before.is_some());
        for (name, counts) in [
            ("rib/profile.csv", true),
            ("rib/parts/edge.py", true),
            ("shared/dims.py", true),
            ("shared/table.csv", true),
            ("single.py", true),
            ("other/geometry.py", false),
            ("rib/0123456789abcdef.msh.gz", false),
            ("rib/0123456789abcdef.json", false),
            ("rib/__pycache__/geometry.pyc", false),
            ("rib/body.toml", false),
            ("meshgen/mesh.py", false),
        ] {
            write(name, "1\n");
            let now = digest();
            assert_eq!(now != before, counts, "{name}");
            let is_one = geometry_files(home.path(), "rib").any(|file| file.ends_with(name));
            assert_eq!(is_one, counts, "{name}");
            before = now;
        }
        // The digest is the same for a copy elsewhere, such as the one in a bundle
        let copy = tempfile::tempdir().expect("a temporary folder");
        for file in geometry_files(home.path(), "rib") {
            let to = copy.path().join(file.strip_prefix(home.path()).expect("below the home"));
            std::fs::create_dir_all(to.parent().expect("below the copy")).expect("room");
            std::fs::copy(&file, &to).expect("room");
        }
        assert_eq!(geometry_sha256(copy.path(), "rib"), before);
    }

    /// A change of the files of a body invalidates its committed meshes: they must be generated and committed again with it.
    #[test]
    fn committed_meshes_are_of_the_geometry_next_to_them() {
        let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
        let entries = |folder: &Path| std::fs::read_dir(folder).expect("a folder").flatten().map(|entry| entry.path());
        let mut manifests = 0;
        for folder in entries(&root.join("meshes")).filter(|path| path.is_dir() && !path.ends_with("cache")) {
            let name = folder.file_name().expect("a name").to_string_lossy().into_owned();
            let now = geometry_sha256(root, &name);
            for file in entries(&folder).filter(|file| file.extension().is_some_and(|end| end == "json")) {
                let text = std::fs::read_to_string(&file).expect("a manifest");
                let manifest: serde_json::Value = serde_json::from_str(&text).expect("JSON");
                assert_eq!(manifest["geometry_sha256"].as_str(), now.as_deref(), "{}", file.display());
                manifests += 1;
            }
        }
        assert!(manifests >= 77, "{manifests}");
    }
}
