//! The files that a study reads: its own, those that they name, and the meshes that were made of bodies and files.

use super::error::BundleError;
use crate::mesh::format::{Format, Reader, recognise};
use crate::mesh::generate::{MeshStore, manifest_path, referred};
use crate::storage::{self, TEXT_LIMIT};
use crate::study::store::record::StoredCase;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};
use toml::Value;

/// Files of a bundle: place in the bundle → where it is now.
pub type Files = BTreeMap<String, PathBuf>;

/// Inputs of a study, with the place of its file in the bundle.
pub struct Inputs {
    pub files: Files,
    pub study: String,
    /// Meshes of the results that are no longer stored: a rerun makes them again
    pub missing: Vec<String>,
}

/// Gathers everything that a run of the study reads. Places keep the folders as they are below the home of the project, or below what all files share.
pub fn gather(study: &Path, cases: &[StoredCase]) -> Result<Inputs, BundleError> {
    let real = |path: &Path| path.canonicalize().map_err(|e| BundleError::unreadable(path, &e));
    let whole = std::path::absolute(study).map_err(|e| BundleError::unreadable(study, &e))?;
    let study = &real(whole.parent().unwrap_or(&whole))?.join(whole.file_name().unwrap_or_default());
    let (mut found, mut absolute) = (BTreeSet::new(), BTreeSet::new());
    follow(study, &mut found, &mut absolute)?;
    if !absolute.is_empty() {
        return Err(BundleError::Absolute { files: absolute.into_iter().collect() });
    }
    let store = match MeshStore::find() {
        Err(e) if sources(cases).any(is_made) || found.iter().any(|f| is_converted(f, cases)) => return Err(e.into()),
        found => found.ok(),
    };
    let about = study.with_file_name("README.md");
    found.extend(about.is_file().then_some(about));
    let home = store.as_ref().map(|s| real(&s.home.path)).transpose()?;
    let root = match &home {
        Some(home) if found.iter().all(|f| f.starts_with(home)) => home.clone(),
        // The folder of a study is its name
        _ => match shared(&found) {
            root if study.parent() == Some(&root) => root.parent().unwrap_or(&root).to_path_buf(),
            root => root,
        },
    };
    let place = |file: &Path| format!("home/{}", name(file.strip_prefix(&root).unwrap_or(file)));
    let mut inputs = Inputs { study: place(study), files: Files::new(), missing: vec![] };
    inputs.files.extend(found.iter().map(|f| (place(f), f.clone())));
    if let Some(store) = store {
        meshes(&store, cases, &found, &mut inputs)?;
    }
    Ok(inputs)
}

/// Names of the meshes of the cases; a scene of several bodies may have several.
fn sources(cases: &[StoredCase]) -> impl Iterator<Item = &str> {
    cases.iter().flat_map(|c| c.record.mesh.source.split(" + "))
}

/// The format by which the mesher converts a mesh file; none of other files.
fn converter(file: &Path) -> Option<&'static str> {
    match recognise(file) {
        Ok(Format { reader: Reader::Mesher(name), .. }) => Some(name),
        _ => None,
    }
}

/// Whether a case has the mesh that this file was converted to. Its surface may have been meshed anew instead.
fn is_converted(file: &Path, cases: &[StoredCase]) -> bool {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    converter(file).is_some() && sources(cases).any(|source| source == name)
}

/// Whether a mesh was made of a body or a shape: it is stored under the digest of its request.
fn is_made(source: &str) -> bool {
    source.strip_suffix(".msh.gz").is_some_and(|s| s.len() == 16 && s.chars().all(|c| c.is_ascii_hexdigit()))
}

/// A path with slashes.
pub fn name(path: &Path) -> String {
    path.components().map(|c| c.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// Adds a file and what it names: the texts of a TOML file, and the files that a mesh file refers to.
fn follow(file: &Path, found: &mut BTreeSet<PathBuf>, absolute: &mut BTreeSet<String>) -> Result<(), BundleError> {
    if !found.insert(file.into()) {
        return Ok(());
    }
    if file.extension().is_none_or(|e| e != "toml") {
        return refer(file, found, absolute);
    }
    let text = storage::read_text(file, TEXT_LIMIT).map_err(|e| BundleError::unreadable(file, &e))?;
    // A file that is not TOML names nothing; the run says what is wrong with it
    let Ok(table) = text.parse::<toml::Table>() else { return Ok(()) };
    let mut named = vec![];
    texts(&Value::Table(table), &mut named);
    let base = file.parent().unwrap_or(Path::new(""));
    for text in named {
        let path = base.join(&text);
        if text.is_empty() || text.len() > 4096 || text.contains('\n') || !path.is_file() {
            continue;
        }
        if Path::new(&text).is_absolute() {
            absolute.insert(format!("{} names {text}", file.display()));
        } else {
            follow(&as_named(&path)?, found, absolute)?;
        }
    }
    Ok(())
}

/// Adds the files that a mesh file refers to; other files refer to none.
fn refer(file: &Path, found: &mut BTreeSet<PathBuf>, absolute: &mut BTreeSet<String>) -> Result<(), BundleError> {
    let Some(format) = converter(file) else { return Ok(()) };
    let folder = referred::folder(file, format)?;
    for name in referred::names(file, format)? {
        if name.is_absolute() {
            absolute.insert(format!("{} names {}", file.display(), name.display()));
        } else {
            found.insert(as_named(&folder.join(name))?);
        }
    }
    Ok(())
}

/// The path of a file by the names that lead to it: a link keeps its own name, which is the one that the study uses. Where `..` leads out of a linked
/// folder, the path is that of the file itself.
fn as_named(path: &Path) -> Result<PathBuf, BundleError> {
    let real = |path: &Path| path.canonicalize().map_err(|e| BundleError::unreadable(path, &e));
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(plain.pop()),
            Component::CurDir => {}
            part => plain.push(part),
        }
    }
    let whole = real(path)?;
    Ok(if plain.canonicalize().is_ok_and(|plain| plain == whole) { plain } else { whole })
}

fn texts(value: &Value, out: &mut Vec<String>) {
    match value {
        Value::String(text) => out.push(text.clone()),
        Value::Table(table) => table.iter().for_each(|(_, value)| texts(value, out)),
        Value::Array(values) => values.iter().for_each(|value| texts(value, out)),
        _ => {}
    }
}

/// The folder that all files share.
fn shared(files: &BTreeSet<PathBuf>) -> PathBuf {
    let mut folders = files.iter().filter_map(|f| f.parent());
    let first = folders.next().unwrap_or(Path::new("")).to_path_buf();
    folders.fold(first, |root, folder| {
        root.components().zip(folder.components()).take_while(|(a, b)| a == b).map(|(a, _)| a).collect()
    })
}

/// Bodies with the mesher, and the meshes that it made of them and of files, where they are stored.
fn meshes(
    store: &MeshStore,
    cases: &[StoredCase],
    found: &BTreeSet<PathBuf>,
    inputs: &mut Inputs,
) -> Result<(), BundleError> {
    let folder = store.home.path.join("meshes");
    let mut names = bodies(&folder, cases);
    let mut stored = converted(store, cases, found, inputs)?;
    let folders = names.iter().map(|name| folder.join(name)).chain([folder.join("file"), store.home.meshes.clone()]);
    let folders: Vec<PathBuf> = folders.collect();
    for source in sources(cases).filter(|s| is_made(s)).collect::<BTreeSet<_>>() {
        match folders.iter().map(|folder| folder.join(source)).find(|path| path.is_file()) {
            Some(path) => stored.extend([manifest_path(&path), path]),
            None => inputs.missing.push(source.into()),
        }
    }
    if names.is_empty() && stored.is_empty() && inputs.missing.is_empty() {
        return Ok(());
    }
    // A folder without the mesher is no home of meshes
    names.insert("meshgen".into());
    let place = |path: &Path| match path.strip_prefix(&folder) {
        Ok(inside) => format!("home/meshes/{}", name(inside)),
        Err(_) => format!("home/meshes/cache/{}", name(Path::new(path.file_name().unwrap_or_default()))),
    };
    inputs.files.extend(stored.into_iter().map(|path| (place(&path), path)));
    for body in &names {
        let is_source = |file: &PathBuf| file.extension().is_some_and(|e| e == "py" || e == "toml" || e == "txt");
        let sources = list(&folder.join(body))?.into_iter().filter(is_source);
        inputs.files.extend(sources.map(|file| (place(&file), file)));
    }
    Ok(())
}

/// Names of the bodies that the scenes of the cases name.
fn bodies(folder: &Path, cases: &[StoredCase]) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for case in cases {
        if let Ok(scene) = case.record.provenance.scene.parse::<toml::Table>() {
            let mut words = vec![];
            texts(&scene.get("mesh").cloned().unwrap_or(Value::Boolean(false)), &mut words);
            names
                .extend(words.into_iter().filter(|w| crate::study::spec::check_names(std::slice::from_ref(w)).is_ok()));
        }
    }
    names.retain(|name| folder.join(name).join("body.toml").is_file());
    names
}

/// The meshes that mesh files were converted to. One that a case has used and that is not stored is missing.
fn converted(
    store: &MeshStore,
    cases: &[StoredCase],
    found: &BTreeSet<PathBuf>,
    inputs: &mut Inputs,
) -> Result<Vec<PathBuf>, BundleError> {
    let mut stored = vec![];
    for file in found {
        let Some(format) = converter(file) else { continue };
        match store.stored_conversion(file, format)? {
            Some(path) => stored.push(path),
            None if is_converted(file, cases) => {
                inputs.missing.push(name(Path::new(file.file_name().unwrap_or_default())))
            }
            None => {}
        }
    }
    Ok(stored)
}

/// The files of a folder, without those of folders in it.
pub fn list(dir: &Path) -> Result<Vec<PathBuf>, BundleError> {
    let entries = std::fs::read_dir(dir).map_err(|e| BundleError::unreadable(dir, &e))?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|e| e.path()).filter(|p| p.is_file()).collect();
    files.sort();
    Ok(files)
}
