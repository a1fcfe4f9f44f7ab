//! Digest of the Python that creates the CAD of a body: its own, and that of bodies which it takes.

use super::body::names;
use crate::storage::{self, TEXT_LIMIT, sha256};
use std::collections::BTreeSet;
use std::path::Path;

/// SHA-256 of the Python files in the folder of a body and in those of the bodies whose modules they import; none of a body without such files.
pub(super) fn geometry_sha256(home: &Path, body: &str) -> Option<String> {
    let known = names(home);
    let (mut open, mut seen) = (vec![body.to_string()], BTreeSet::new());
    let mut all = BTreeSet::new();
    while let Some(body) = open.pop() {
        if !seen.insert(body.clone()) {
            continue;
        }
        for (name, text) in sources(&home.join("meshes").join(&body)) {
            open.extend(imported(&text).filter(|module| known.contains(module) && !seen.contains(module)));
            all.insert((body.clone(), name, sha256(&text)));
        }
    }
    (!all.is_empty()).then(|| sha256(format!("{all:?}")))
}

/// The Python files of a folder with their texts; those that cannot be read are left to the mesher.
fn sources(folder: &Path) -> impl Iterator<Item = (String, String)> {
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let python = files.filter(|file| file.extension().is_some_and(|end| end == "py"));
    python.filter_map(|file| {
        let name = file.file_name()?.to_string_lossy().into_owned();
        Some((name, storage::read_text(&file, TEXT_LIMIT).ok()?))
    })
}

/// The first names of the modules that a Python file imports: `finger` of `from finger.geometry import build`.
fn imported(text: &str) -> impl Iterator<Item = String> {
    let modules = text.lines().filter_map(|line| {
        let line = line.trim_start();
        line.strip_prefix("from ")
            .map(|rest| rest.split(" import").next().unwrap_or(rest))
            .or(line.strip_prefix("import "))
    });
    modules.flat_map(|list| list.split(',')).filter_map(|module| {
        let first = module.split(['.', ' ']).find(|part| !part.is_empty())?;
        Some(first.to_string())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modules_are_found_in_every_form_of_import() {
        let text = "import gmsh, beam.geometry as b\nfrom finger.geometry import build, x\nif True:\n    from block import geometry\n# import none\n";
        let found: Vec<String> = imported(text).collect();
        assert_eq!(found, ["gmsh", "beam", "finger", "block"]);
    }
}
