//! Whether a run would take the place of the results of another study.

use crate::study::expand::Study;
use crate::study::store::case_files;
use crate::study::store::origin;
use crate::study::store::record::StudyRecord;
use std::path::Path;

/// The other study whose results `dir` holds: its file, or its name where that is not known. Those of the same study are none of another one, also where its file was moved, or is
/// a copy of the one that they were computed from.
pub fn held(study: &Study, dir: &Path) -> Option<String> {
    let stored = case_files::study(dir).ok()?;
    let has_other_name = stored.study != study.record.study;
    match origin::other(dir, &study.file) {
        Some(file) => (has_other_name || !has_cases_of(study, &stored)).then(|| file.display().to_string()),
        None if dir.join(origin::FILE).is_file() => None,
        None => has_other_name.then(|| format!("the study {}", stored.study)),
    }
}

/// Whether the stored study has cases of this one, all of the same inputs; true of one of an earlier version, which does not say its inputs.
fn has_cases_of(study: &Study, stored: &StudyRecord) -> bool {
    let shared = study.cases.iter().filter_map(|case| Some((case, stored.inputs_sha256.get(&case.id)?)));
    let mut is_same = shared.map(|(case, inputs)| case.identity(&[]).inputs_sha256 == *inputs).peekable();
    stored.inputs_sha256.is_empty() || is_same.peek().is_some() && is_same.all(|is_same| is_same)
}
