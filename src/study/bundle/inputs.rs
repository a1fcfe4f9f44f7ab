//! The files that a study reads: its own, those that they name, bodies and meshes.

use super::error::BundleError;
use crate::mesh::generate::MeshStore;
use crate::storage::{self, TEXT_LIMIT};
use crate::study::store::record::StoredCase;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
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
    let store = match MeshStore::find() {
        Err(e) if cases.iter().any(|c| is_made(&c.record.mesh.source)) => return Err(BundleError::Home(e)),
        found => found.ok(),
    };
    let real = |path: &Path| path.canonicalize().map_err(|e| BundleError::unreadable(path, &e));
    let study = &real(study)?;
    let (mut found, mut absolute) = (BTreeSet::new(), BTreeSet::new());
    follow(study, &mut found, &mut absolute)?;
    if !absolute.is_empty() {
        return Err(BundleError::Absolute { files: absolute.into_iter().collect() });
    }
    let about = study.with_file_name("README.md");
    found.extend(about.is_file().then(|| real(&about)).transpose()?);
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
        bodies(&store, cases, &mut inputs)?;
    }
    Ok(inputs)
}

/// Whether a mesh was made of a body: it is stored under the digest of its request.
fn is_made(source: &str) -> bool {
    source.strip_suffix(".msh.gz").is_some_and(|s| s.len() == 16 && s.chars().all(|c| c.is_ascii_hexdigit()))
}

/// A path with slashes.
pub fn name(path: &Path) -> String {
    path.components().map(|c| c.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// Adds a file and, of a TOML file, everything that its texts name.
fn follow(file: &Path, found: &mut BTreeSet<PathBuf>, absolute: &mut BTreeSet<String>) -> Result<(), BundleError> {
    if !found.insert(file.into()) || file.extension().is_none_or(|e| e != "toml") {
        return Ok(());
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
            let path = path.canonicalize().map_err(|e| BundleError::unreadable(&path, &e))?;
            follow(&path, found, absolute)?;
        }
    }
    Ok(())
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

/// Bodies with the mesher, and the stored meshes of the cases.
fn bodies(store: &MeshStore, cases: &[StoredCase], inputs: &mut Inputs) -> Result<(), BundleError> {
    let meshes = store.home.path.join("meshes");
    let mut names = BTreeSet::new();
    for case in cases {
        if let Ok(scene) = case.record.provenance.scene.parse::<toml::Table>() {
            let mut words = vec![];
            texts(&scene.get("mesh").cloned().unwrap_or(Value::Boolean(false)), &mut words);
            names
                .extend(words.into_iter().filter(|w| crate::study::spec::check_names(std::slice::from_ref(w)).is_ok()));
        }
    }
    names.retain(|name| meshes.join(name).join("body.toml").is_file());
    if names.is_empty() {
        return Ok(());
    }
    names.insert("meshgen".into());
    for body in &names {
        for file in list(&meshes.join(body))? {
            let is_source = file.extension().is_some_and(|e| e == "py" || e == "toml" || e == "txt");
            if is_source {
                inputs.files.insert(
                    format!("home/meshes/{body}/{}", name(Path::new(file.file_name().unwrap_or_default()))),
                    file,
                );
            }
        }
    }
    let sources: BTreeSet<&str> = cases.iter().map(|c| c.record.mesh.source.as_str()).filter(|s| is_made(s)).collect();
    for source in sources {
        let committed = names.iter().map(|name| (name.as_str(), meshes.join(name)));
        let folders = committed.chain([("cache", store.home.meshes.clone())]);
        let found = folders.map(|(name, folder)| (name, folder.join(source))).find(|(_, path)| path.is_file());
        let Some((folder, path)) = found else {
            inputs.missing.push(source.into());
            continue;
        };
        let manifest = path.with_file_name(source.replace(".msh.gz", ".json"));
        inputs.files.insert(format!("home/meshes/{folder}/{source}"), path);
        inputs.files.insert(format!("home/meshes/{folder}/{}", source.replace(".msh.gz", ".json")), manifest);
    }
    Ok(())
}

/// The files of a folder, without those of folders in it.
pub fn list(dir: &Path) -> Result<Vec<PathBuf>, BundleError> {
    let entries = std::fs::read_dir(dir).map_err(|e| BundleError::unreadable(dir, &e))?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|e| e.path()).filter(|p| p.is_file()).collect();
    files.sort();
    Ok(files)
}
