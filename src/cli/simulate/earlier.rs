//! The files of an earlier run of `durometer simulate` under the same name.

use durometer::storage::{self, DATA_LIMIT};
use durometer::study::store::record::CaseRecord;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Ends of the names of files that not every run writes, `<name>.<end>`. Recordings and saved states are kept: later runs may start from them.
const ENDS: [&str; 4] = ["errors.csv", "html", "refinement.csv", "sensitivities.csv"];

/// The files that an earlier run has written, with the times at which they were changed; none where its record is not there.
pub struct Earlier(Vec<(PathBuf, SystemTime)>);

impl Earlier {
    pub fn find(out: &Path, name: &str) -> Self {
        let record = storage::read(&out.join(format!("{name}.json")), DATA_LIMIT).ok();
        let record = record.and_then(|bytes| serde_json::from_slice::<CaseRecord>(&bytes).ok());
        if record.is_none_or(|record| record.id != name) {
            return Self(Vec::new());
        }
        let mut files: Vec<PathBuf> = ENDS.iter().map(|end| out.join(format!("{name}.{end}"))).collect();
        files.extend(figures(out, name));
        files.extend(fields(out, name));
        Self(files.into_iter().filter_map(|file| Some((changed(&file)?, file))).map(|(t, file)| (file, t)).collect())
    }

    /// Removes those that this run has not written again.
    pub fn remove(self) {
        for (file, before) in self.0 {
            if changed(&file) == Some(before) {
                std::fs::remove_file(&file).ok();
            }
        }
    }
}

fn changed(file: &Path) -> Option<SystemTime> {
    std::fs::symlink_metadata(file).ok().filter(std::fs::Metadata::is_file)?.modified().ok()
}

/// Comparisons with measurements.
fn figures(out: &Path, name: &str) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for kind in ["compare", "markers"] {
        let of = |k: usize| ["svg", "png", "pdf"].map(|end| out.join(format!("{name}-{kind}-{k}.{end}")));
        all.extend((1..).map(of).take_while(|files| files[0].is_file()).flatten());
    }
    all
}

/// The collection for ParaView with the files of the body that it names.
fn fields(out: &Path, name: &str) -> Vec<PathBuf> {
    let collection = out.join(format!("{name}.pvd"));
    let Ok(text) = storage::read_text(&collection, DATA_LIMIT) else { return Vec::new() };
    let named = text.split("file=\"").skip(1).filter_map(|rest| rest.split('"').next());
    let is_own =
        |file: &&str| file.strip_prefix(name).is_some_and(|rest| rest.starts_with('-') && !rest.contains(['/', '\\']));
    let frames = named.filter(is_own).map(|file| out.join(file));
    let regions = out.join(format!("{name}-regions.vtu"));
    frames.chain([regions, collection.clone()]).collect()
}
