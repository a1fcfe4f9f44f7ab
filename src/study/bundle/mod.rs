//! A study with its inputs, results, environment and checksums in one folder, as an RO-Crate 1.1, from which it can be run again.
//!
//! ```text
//! ro-crate-metadata.json   description of the contents
//! manifest-sha256.txt      SHA-256 and path of every other file
//! environment.json         builds that computed the results
//! home/                    everything that the run reads: study, scenes, data, bodies, meshes
//! results/                 the results with their report
//! ```

mod belonging;
mod error;
mod inputs;
mod metadata;

use crate::mesh::generate::MeshStore;
use crate::storage::{self, DATA_LIMIT, sha256};
use crate::study::expand::Study;
use crate::study::extension::AddedMeshes;
use crate::study::listing::made_meshes;
use crate::study::store::builds::builds;
use crate::study::store::origin;
use crate::study::store::outdated::check_summary;
use crate::study::store::results;
pub use error::BundleError;
use inputs::{Files, Inputs, gather, list, name};
use metadata::{About, Stored, metadata};
use serde::{Deserialize, Serialize};
use std::io;
use std::path::{Path, PathBuf};

const MANIFEST: &str = "manifest-sha256.txt";
const ENVIRONMENT: &str = "environment.json";
/// Subfolders that belong to a result, and the file extensions kept from the result folder itself.
const FOLDERS: [&str; 4] = ["cases", "figures", "tables", PAPER];
const ENDS: [&str; 3] = ["json", "html", "toml"];
/// Folder of the LaTeX sources, and the extensions of files that LaTeX leaves there.
const PAPER: &str = "paper";
const LEFT_BY_LATEX: [&str; 8] = ["aux", "bbl", "bcf", "blg", "fdb_latexmk", "fls", "log", "out"];

/// Contents of a bundle that has been written.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Bundled {
    pub files: usize,
    pub bytes: u64,
    /// Meshes that are not stored; a rerun needs the mesher for them
    pub without_mesh: Vec<String>,
}

/// Contents of `environment.json`
#[derive(Serialize, Deserialize)]
struct Environment {
    /// Path of the study file in the bundle
    study: String,
    builds: Vec<crate::study::store::identity::Build>,
    operating_system: String,
}

/// Writes the study in a file, with its results, into a folder that is new or empty.
///
/// # Errors
/// Results or inputs that cannot be read; results of another study or of other inputs; a report that is older than the results; file names that are not
/// valid on other machines; and a folder that is not empty or cannot be written.
pub fn write(study: &Path, named: &str, dir: &Path, out: &Path, license: &str) -> Result<Bundled, BundleError> {
    if out.is_file() || std::fs::read_dir(out).is_ok_and(|mut entries| entries.next().is_some()) {
        return Err(BundleError::NotEmpty { path: out.into() });
    }
    let stored = results::read(dir)?;
    if stored.study.study != named {
        let found = stored.study.study;
        return Err(BundleError::OtherStudy { path: dir.into(), found, wanted: named.into() });
    }
    let (file, store) = (study, MeshStore::find());
    let Inputs { mut files, study, expanded, missing } = gather(file, dir, &stored.cases, store.as_ref().ok())?;
    belonging::check(file, dir, &stored.study)?;
    check_summary(dir, &stored.study)?;
    files.extend(of_results(dir)?);
    let written = put_all(out, (&files, study), &stored, license);
    let done = written.and_then(|done| match (missing_meshes(out, &expanded, missing), store) {
        (Ok(without_mesh), Err(_)) if without_mesh.is_empty() => Ok(done),
        // The folder of the bodies is unknown
        (_, Err(e)) => Err(e.into()),
        (found, Ok(_)) => Ok(Bundled { without_mesh: found?, ..done }),
    });
    if done.is_err() {
        // The folder did not exist, or was empty
        std::fs::remove_dir_all(out).ok();
    }
    done
}

/// Writes all files of a bundle of this study.
fn put_all(
    out: &Path,
    (files, study): (&Files, String),
    stored: &results::Results,
    license: &str,
) -> Result<Bundled, BundleError> {
    let mut all: Vec<Stored> = vec![];
    for (place, from) in files {
        let bytes = storage::read(from, DATA_LIMIT).map_err(|e| BundleError::unreadable(from, &e))?;
        all.push(put(out, place, &bytes)?);
    }
    let builds: Vec<_> = builds(stored.cases.iter().map(|c| &c.record)).into_iter().map(|(build, _)| build).collect();
    let environment = Environment { study, builds, operating_system: std::env::consts::OS.into() };
    all.push(put(out, ENVIRONMENT, &json(&environment))?);
    let run_unix_s = stored.cases.iter().map(|c| c.record.provenance.started_unix_s).max().unwrap_or(0);
    let about = About { study: &stored.study, license, run_unix_s, builds: &environment.builds };
    let described = metadata(&about, &all);
    all.push(put(out, "ro-crate-metadata.json", &json(&described))?);
    let lines: String = all.iter().map(|f| format!("{}  {}\n", f.sha256, f.name)).collect();
    put(out, MANIFEST, lines.as_bytes())?;
    Ok(Bundled { files: all.len() + 1, bytes: all.iter().map(|f| f.bytes).sum(), without_mesh: vec![] })
}

/// Reads the study of a bundle as a rerun does, and lists the meshes that it would make, together with the `missing` ones of refinements.
fn missing_meshes(dir: &Path, original: &Study, mut missing: Vec<String>) -> Result<Vec<String>, BundleError> {
    let bundle = open(dir)?;
    let incomplete = |reason: String| BundleError::Incomplete { path: dir.into(), reason };
    let study = Study::read_as_stored(&bundle.study, &bundle.results).map_err(|e| incomplete(e.to_string()))?;
    // Identities include the contents of all files that the scenes name
    let inputs =
        |study: &Study| study.cases.iter().map(|case| (case.id.clone(), case.identity(&[]))).collect::<Vec<_>>();
    if inputs(&study) != inputs(original) {
        return Err(incomplete("files that its scenes name are missing".into()));
    }
    let store = MeshStore::of_project(bundle.home, PathBuf::new());
    let made = made_meshes(&study, &store).map_err(|e| incomplete(e.to_string()))?;
    missing.extend(made.into_iter().filter(|mesh| mesh.stored.is_none()).map(|mesh| mesh.name));
    missing.sort();
    missing.dedup();
    Ok(missing)
}

fn json(value: &impl Serialize) -> Vec<u8> {
    serde_json::to_vec_pretty(value).expect("numbers, strings and string keys only")
}

/// The results and their report.
fn of_results(dir: &Path) -> Result<Files, BundleError> {
    let mut files = Files::new();
    let ends = |file: &Path, ends: &[&str]| ends.iter().any(|end| file.extension().is_some_and(|e| e == *end));
    let place = |file: &Path| format!("results/{}", name(file.strip_prefix(dir).unwrap_or(file)));
    // The path of the study is meaningful on this machine only
    let is_told = |file: &PathBuf| ends(file, &ENDS) && file.file_name().is_none_or(|name| name != origin::FILE);
    files.extend(list(dir)?.into_iter().filter(is_told).map(|f| (place(&f), f)));
    for folder in FOLDERS.iter().map(|f| dir.join(f)).filter(|f| f.is_dir()) {
        let is_left = |file: &PathBuf| folder.ends_with(PAPER) && ends(file, &LEFT_BY_LATEX);
        files.extend(list(&folder)?.into_iter().filter(|f| !is_left(f)).map(|f| (place(&f), f)));
    }
    Ok(files)
}

fn put(out: &Path, place: &str, bytes: &[u8]) -> Result<Stored, BundleError> {
    let path = out.join(place);
    let refuse = |e: io::Error| BundleError::Unwritable { path: path.clone(), reason: e.to_string() };
    std::fs::create_dir_all(path.parent().unwrap_or(out)).map_err(refuse)?;
    storage::write(&path, bytes).map_err(refuse)?;
    Ok(Stored { name: place.into(), bytes: bytes.len() as u64, sha256: sha256(bytes) })
}

/// A bundle whose files have been verified.
pub struct Bundle {
    /// Folder of everything that the run reads
    pub home: PathBuf,
    pub study: PathBuf,
    pub results: PathBuf,
    /// The meshes that were added to the study, if any
    pub extension: Option<PathBuf>,
    /// Whether it contains meshes, or the mesher with its bodies, which are programs
    pub has_bodies: bool,
}

/// Opens a bundle and verifies every digest.
///
/// # Errors
/// A folder that is not a bundle, and files that are missing, changed, or lead out of the bundle.
pub fn open(dir: &Path) -> Result<Bundle, BundleError> {
    let refuse = |reason: String| BundleError::NoBundle { path: dir.into(), reason };
    let read = |file: &str| storage::read(&dir.join(file), DATA_LIMIT);
    let manifest = read(MANIFEST).map_err(|e| refuse(format!("{MANIFEST}: {e}")))?;
    let manifest = String::from_utf8(manifest).map_err(|_| refuse(format!("{MANIFEST} is no text")))?;
    let mut wrong = vec![];
    for line in manifest.lines() {
        let Some((digest, file)) = line.split_once("  ") else {
            return Err(refuse(format!("{MANIFEST} has a line without a digest")));
        };
        if !Path::new(file).components().all(|c| matches!(c, std::path::Component::Normal(_))) {
            wrong.push(format!("{file} leads out of the bundle"));
            continue;
        }
        match read(file).map(sha256) {
            Err(e) => wrong.push(format!("{file}: {e}")),
            Ok(found) if found != digest => wrong.push(format!("{file} is not the file that was written")),
            Ok(_) => {}
        }
    }
    let is_listed = |file: &str| manifest.lines().any(|line| line.ends_with(&format!("  {file}")));
    if !wrong.is_empty() {
        return Err(BundleError::Damaged { path: dir.into(), files: wrong });
    }
    let environment = read(ENVIRONMENT).map_err(|e| refuse(format!("{ENVIRONMENT}: {e}")))?;
    let environment: Environment =
        serde_json::from_slice(&environment).map_err(|e| refuse(format!("{ENVIRONMENT}: {e}")))?;
    if !is_listed(ENVIRONMENT) || !is_listed(&environment.study) {
        return Err(refuse(format!("{MANIFEST} does not list the study")));
    }
    let (home, results) = (dir.join("home"), dir.join("results"));
    // An extension that the manifest does not list is ignored
    let is_extended = is_listed("results/extension.toml");
    Ok(Bundle {
        study: dir.join(&environment.study),
        extension: is_extended.then(|| AddedMeshes::file(&results)),
        results,
        has_bodies: home.join("meshes/meshgen").is_dir(),
        home,
    })
}

impl Bundle {
    /// Adds the meshes of the bundle to the folder of a rerun.
    ///
    /// # Errors
    /// A folder to which other meshes have been added, or that cannot be written.
    pub fn extend(&self, out: &Path) -> Result<(), BundleError> {
        let to = AddedMeshes::file(out);
        let read = |file: &Path| storage::read(file, DATA_LIMIT).map_err(|e| BundleError::unreadable(file, &e));
        let own = self.extension.as_deref().map(read).transpose()?;
        let there = to.is_file().then(|| read(&to)).transpose()?;
        match (own, there) {
            (own, there) if own == there => Ok(()),
            (Some(own), None) => put(out, "extension.toml", &own).map(drop),
            _ => Err(BundleError::OtherExtension { path: to }),
        }
    }
}
