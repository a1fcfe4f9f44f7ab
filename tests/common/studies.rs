//! Runs a study in the process of a test.

use durometer::study::expand::Study;
use durometer::study::run::growing;
use durometer::study::run::runner::Options;
use durometer::study::store::record::CaseRecord;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Runs a study into a folder, all cases or those whose ids contain `only`; two at a time.
pub fn run_study(study: &Study, dir: &Path, only: Option<&str>) -> Vec<CaseRecord> {
    let stop = AtomicBool::new(false);
    let options = Options { jobs: 2, only: only.map(Into::into), ..Options::new(&stop) };
    growing::run_study(study, dir, &options, &()).unwrap_or_else(|e| panic!("{e}"))
}

/// Reads `study.toml` of a folder and runs all its cases into the folder `results` next to it.
pub fn run_folder(folder: &Path) -> Vec<CaseRecord> {
    let study = Study::read(&folder.join("study.toml"), &[]).unwrap_or_else(|e| panic!("{e}"));
    run_study(&study, &folder.join("results"), None)
}
