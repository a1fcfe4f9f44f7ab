//! The files that a study reads: its own, the files that they name, and the meshes made from bodies and files.

use super::error::BundleError;
use crate::mesh::format::{Format, Reader, recognise};
use crate::mesh::generate::{MeshStore, geometry_files, manifest_path, referred};
use crate::scene::MadeMesh;
use crate::storage::{self, TEXT_LIMIT};
use crate::study::expand::Study;
use crate::study::listing::made_meshes;
use crate::study::spec::EXPERIMENT;
use crate::study::store::record::StoredCase;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};
use toml::Value;

/// Files of a bundle: path in the bundle → present path.
pub type Files = BTreeMap<String, PathBuf>;

/// Inputs of a study, with the path of its file in the bundle.
pub struct Inputs {
    pub files: Files,
    pub study: String,
    pub expanded: Study,
    /// Meshes of refinements that are no longer stored; a rerun makes them again
    pub missing: Vec<String>,
}

/// Gathers everything that a run of the study reads. The folder structure is kept, relative to the home of the project or to the deepest folder that
/// contains all files.
pub fn gather(
    study: &Path,
    dir: &Path,
    cases: &[StoredCase],
    store: Option<&MeshStore>,
) -> Result<Inputs, BundleError> {
    let real = |path: &Path| path.canonicalize().map_err(|e| BundleError::unreadable(path, &e));
    let whole = std::path::absolute(study).map_err(|e| BundleError::unreadable(study, &e))?;
    let file = &real(whole.parent().unwrap_or(&whole))?.join(whole.file_name().unwrap_or_default());
    let (mut found, mut absolute) = (BTreeSet::new(), BTreeSet::new());
    follow(file, &mut found, &mut absolute)?;
    let study = Study::read_as_stored(file, dir)?;
    // Changes of the study name files relative to the scene
    let named: BTreeSet<PathBuf> = study.cases.iter().flat_map(|case| case.files().into_keys()).collect();
    for named in named.iter().filter(|named| named.is_file()) {
        follow(&as_named(named)?, &mut found, &mut absolute)?;
    }
    if !absolute.is_empty() {
        return Err(BundleError::Absolute { files: absolute.into_iter().collect() });
    }
    let about = file.with_file_name("README.md");
    found.extend(about.is_file().then_some(about));
    let home = store.map(|s| real(&s.home.path)).transpose()?;
    let root = match &home {
        Some(home) if file.parent() != Some(home) && found.iter().all(|f| f.starts_with(home)) => home.clone(),
        // The study is named after its folder
        _ => match shared(&found) {
            root if file.parent() == Some(&root) => root.parent().unwrap_or(&root).to_path_buf(),
            root => root,
        },
    };
    let place = |file: &Path| format!("home/{}", name(file.strip_prefix(&root).unwrap_or(file)));
    let mut inputs = Inputs { study: place(file), expanded: study, files: Files::new(), missing: vec![] };
    inputs.files.extend(found.iter().map(|f| (place(f), f.clone())));
    if let Some(store) = store {
        let made = made_meshes(&inputs.expanded, store)?;
        meshes(store, made, cases, &mut inputs)?;
    }
    Ok(inputs)
}

/// The format from which the mesher converts a mesh file; `None` for other files.
fn converter(file: &Path) -> Option<&'static str> {
    match recognise(file) {
        Ok(Format { reader: Reader::Mesher(name), .. }) => Some(name),
        _ => None,
    }
}

/// Writes a path with slashes.
pub fn name(path: &Path) -> String {
    path.components().map(|c| c.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// Adds a file and the files that it names: strings of a TOML file, and the files that a mesh file refers to.
fn follow(file: &Path, found: &mut BTreeSet<PathBuf>, absolute: &mut BTreeSet<String>) -> Result<(), BundleError> {
    if !found.insert(file.into()) {
        return Ok(());
    }
    if file.extension().is_none_or(|e| e != "toml") {
        return refer(file, found, absolute);
    }
    let text = storage::read_text(file, TEXT_LIMIT).map_err(|e| BundleError::unreadable(file, &e))?;
    // A file that is not TOML names no files; the run reports what is wrong with it
    let Ok(table) = text.parse::<toml::Table>() else { return Ok(()) };
    let mut named = vec![];
    table.values().for_each(|value| texts(value, &mut named));
    let base = file.parent().unwrap_or(Path::new(""));
    let experiments = experiments(&table);
    let in_experiments = |text: String| -> Vec<String> {
        match text.contains(EXPERIMENT) {
            true => experiments.iter().map(|experiment| text.replace(EXPERIMENT, experiment)).collect(),
            false => vec![text],
        }
    };
    for text in named.into_iter().flat_map(in_experiments) {
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

/// The experiments of the records of a study, after which files of measured fields are named.
fn experiments(table: &toml::Table) -> Vec<&str> {
    let records = table.get("record").and_then(Value::as_array).into_iter().flatten();
    records.filter_map(|record| record.get("experiment").or(record.get("name"))?.as_str()).collect()
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

/// The path of a file by the names that lead to it: a symbolic link keeps its own name, which is the one that the study uses. If `..` leads out of a
/// linked folder, the path is the canonical one.
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

/// The deepest folder that contains all files.
fn shared(files: &BTreeSet<PathBuf>) -> PathBuf {
    let mut folders = files.iter().filter_map(|f| f.parent());
    let first = folders.next().unwrap_or(Path::new("")).to_path_buf();
    folders.fold(first, |root, folder| {
        root.components().zip(folder.components()).take_while(|(a, b)| a == b).map(|(a, _)| a).collect()
    })
}

/// Adds the bodies with the mesher, and the meshes that it made for the scenes and their refinements, if they are stored.
fn meshes(
    store: &MeshStore,
    made: Vec<MadeMesh>,
    cases: &[StoredCase],
    inputs: &mut Inputs,
) -> Result<(), BundleError> {
    if made.is_empty() {
        return Ok(());
    }
    let folder = store.home.path.join("meshes");
    let bodies: BTreeSet<&String> = made.iter().filter_map(|mesh| mesh.body.as_ref()).collect();
    let mut stored: BTreeSet<PathBuf> = made.iter().filter_map(|mesh| mesh.stored.clone()).collect();
    let folders = bodies.iter().map(|body| folder.join(body)).chain([folder.join("file"), store.home.meshes.clone()]);
    let folders: Vec<PathBuf> = folders.collect();
    for case in cases {
        let steps = &case.record.refinement;
        for step in steps {
            // A committed mesh of another geometry may lie next to the new one
            let places = folders.iter().map(|folder| folder.join(&step.mesh));
            let kept: Vec<PathBuf> = places.filter(|path| path.is_file()).collect();
            match &step.mesh {
                _ if !kept.is_empty() => stored.extend(kept),
                mesh if !mesh.is_empty() => inputs.missing.push(mesh.clone()),
                _ if steps.len() == 1 => {}
                _ => inputs.missing.push(format!("with {} cells of {}", step.cells, case.record.id)),
            }
        }
    }
    let manifests: Vec<PathBuf> = stored.iter().map(|mesh| manifest_path(mesh)).filter(|path| path.is_file()).collect();
    // A folder without the mesher is not a home of meshes
    let of_mesher = list(&folder.join("meshgen"))?.into_iter();
    let of_mesher = of_mesher.filter(|f| f.extension().is_some_and(|e| e == "py" || e == "txt"));
    let of_bodies = bodies.iter().flat_map(|body| {
        let declared = folder.join(body).join("body.toml");
        geometry_files(&store.home.path, body).chain([declared])
    });
    let place = |path: &Path| match path.strip_prefix(&folder) {
        Ok(inside) => format!("home/meshes/{}", name(inside)),
        Err(_) => format!("home/meshes/cache/{}", name(Path::new(path.file_name().unwrap_or_default()))),
    };
    let all = stored.into_iter().chain(manifests).chain(of_mesher).chain(of_bodies);
    inputs.files.extend(all.map(|path| (place(&path), path)));
    Ok(())
}

/// The files of a folder, without those in its subfolders.
pub fn list(dir: &Path) -> Result<Vec<PathBuf>, BundleError> {
    let entries = std::fs::read_dir(dir).map_err(|e| BundleError::unreadable(dir, &e))?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|e| e.path()).filter(|p| p.is_file()).collect();
    files.sort();
    Ok(files)
}
