//! The files of an earlier run of `durometer simulate` under the same name.

use durometer::mesh::grid_file::read_collection;
use durometer::scene::{Checkpoint, Scene, same_simulation};
use durometer::storage::{self, DATA_LIMIT};
use durometer::study::store::csv_text;
use durometer::study::store::record::CaseRecord;
use std::collections::HashSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Endings of the files `<name>.<ending>` that not every run writes. Recordings and saved states are kept, because later runs may start from them.
const ENDS: [&str; 4] = ["errors.csv", "html", "refinement.csv", "sensitivities.csv"];

/// The files that an earlier run has written, with their modification times, the record last; empty if there is no record.
pub struct Earlier(Vec<(PathBuf, SystemTime)>);

impl Earlier {
    pub fn find(out: &Path, name: &str) -> Self {
        let Some(record) = record(out, name) else { return Self(Vec::new()) };
        let mut files: Vec<PathBuf> = ENDS.iter().map(|end| out.join(format!("{name}.{end}"))).collect();
        files.extend(figures(out, name));
        files.push(out.join(format!("{name}-regions.vtu")));
        let of_skins = skins(&record).into_iter().map(|skin| format!("{name}-{skin}"));
        for stem in std::iter::once(name.to_string()).chain(of_skins) {
            let collection = out.join(format!("{stem}.pvd"));
            files.extend(frames(&collection));
            files.push(collection);
        }
        files.push(out.join(format!("{name}.json")));
        Self(files.into_iter().filter_map(|file| Some((changed(&file)?, file))).map(|(t, file)| (file, t)).collect())
    }

    /// Removes the files that this run has not rewritten, the record last: without it nothing there counts as a result. Files named in a rewritten
    /// collection are kept, because the collections of a continued run also name the states before the restart.
    pub fn remove(self) {
        let (again, old): (Vec<_>, Vec<_>) =
            self.0.into_iter().partition(|(file, before)| changed(file) != Some(*before));
        let collections = again.iter().filter(|(file, _)| file.extension() == Some("pvd".as_ref()));
        let kept: HashSet<PathBuf> = collections.flat_map(|(file, _)| frames(file)).collect();
        for (file, _) in old.iter().filter(|(file, _)| !kept.contains(file)) {
            std::fs::remove_file(file).ok();
        }
    }
}

/// Reads the record of the last run under this name.
fn record(out: &Path, name: &str) -> Option<CaseRecord> {
    let bytes = storage::read(&out.join(format!("{name}.json")), DATA_LIMIT).ok()?;
    serde_json::from_slice::<CaseRecord>(&bytes).ok().filter(|record| record.id == name)
}

/// Whether the files under this name are of the run that the checkpoint continues: the record must be of the same scene, and all rows up to the time of
/// the checkpoint must be rows of the checkpoint. Rows alone do not decide, because many scenes have the same rows at rest.
pub fn is_of_run(out: &Path, name: &str, scene: &Scene, checkpoint: &Checkpoint) -> bool {
    if !record(out, name).is_some_and(|record| same_simulation(&record.provenance.scene, &scene.text)) {
        return false;
    }
    let Ok(text) = storage::read_text(&out.join(format!("{name}.csv")), DATA_LIMIT) else { return false };
    let rows: HashSet<String> = checkpoint.rows().iter().map(|row| csv_text::line(row)).collect();
    let time = |line: &str| line.split(',').next().and_then(|t| t.parse::<f64>().ok());
    let is_before = |line: &&str| time(line).is_some_and(|t| t <= checkpoint.state.t);
    let before: Vec<&str> = text.split_inclusive('\n').skip(1).filter(is_before).collect();
    !before.is_empty() && before.into_iter().all(|line| rows.contains(line))
}

fn changed(file: &Path) -> Option<SystemTime> {
    std::fs::symlink_metadata(file).ok().filter(std::fs::Metadata::is_file)?.modified().ok()
}

/// Returns the figures of the run, which compare it with measurements.
fn figures(out: &Path, name: &str) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for kind in ["compare", "markers"] {
        let of = |k: usize| ["svg", "png", "pdf"].map(|end| out.join(format!("{name}-{kind}-{k}.{end}")));
        all.extend((1..).map(of).take_while(|files| files[0].is_file()).flatten());
    }
    all
}

/// Returns the names of the skins in the scene of a record.
fn skins(record: &CaseRecord) -> Vec<String> {
    let scene: toml::Table = record.provenance.scene.parse().unwrap_or_default();
    let all = scene.get("skin").and_then(toml::Value::as_array).into_iter().flatten();
    all.filter_map(|skin| Some(skin.get("name")?.as_str()?.to_string())).collect()
}

/// Returns the files that a ParaView collection names, `<stem>-….vtu` next to it.
fn frames(collection: &Path) -> Vec<PathBuf> {
    let text = |part: Option<&OsStr>| part.map_or_else(String::new, |part| part.to_string_lossy().into_owned());
    let stem = format!("{}-", text(collection.file_stem()));
    let is_own = |file: &PathBuf| file.parent() == collection.parent() && text(file.file_name()).starts_with(&stem);
    read_collection(collection).unwrap_or_default().into_iter().map(|(_, file)| file).filter(is_own).collect()
}
