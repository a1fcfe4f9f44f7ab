//! Runs a study and, if its kind requests them, the cases that follow from the results of others.

use crate::report::ReportError;
use crate::study::expand::Study;
use crate::study::kinds;
use crate::study::rounds::Rounds;
use crate::study::run::runner::{Options, RunError, Watch, run_cases};
use crate::study::store::folder::Store;
use crate::study::store::record::CaseRecord;
use crate::study::store::results;
use std::path::Path;
use std::sync::atomic::Ordering;

/// Runs a study into `dir`: its cases, then those that its kind requests on the basis of the results, until it requests no more. Returns the records of
/// all wanted cases that have one; an interrupted case has none.
///
/// # Errors
///
/// No case is wanted, a scene is refused, another run writes to the folder, or a result cannot be written.
pub fn run_study(study: &Study, dir: &Path, options: &Options, watch: &dyn Watch) -> Result<Vec<CaseRecord>, RunError> {
    let mut records = run_cases(study, dir, options, watch)?;
    let broken = with_earlier_results(&records, dir);
    // The cases have been computed now, so that none has to be computed again
    let (only, isolation) = (options.only.clone(), options.isolation.clone());
    let options = Options { redo: false, redo_registered: false, only, isolation, ..*options };
    let mut present = study.clone();
    while options.only.is_none() && !options.stop.load(Ordering::Relaxed) {
        let Some(next) = next(&present, dir)? else { break };
        present = next;
        records = run_cases(&present, dir, &options, watch)?;
        for record in &mut records {
            let of_case = |(_, earlier): &&(CaseRecord, String)| *earlier == record.provenance.record_sha256;
            if let Some((broke, _)) = broken.iter().find(of_case) {
                *record = broke.clone();
            }
        }
    }
    Ok(records)
}

/// Whether further cases may follow from the results of this study in `dir`. A partial run does not request any, since the results of the other cases
/// may be missing.
pub fn is_open(study: &Study, dir: &Path) -> bool {
    let rounds = Rounds::read(dir);
    let has_ended = rounds.of == study.source_sha256 && rounds.has_ended();
    !has_ended && kinds::find(&study.record.kind).is_some_and(|kind| (kind.grows)(&study.record))
}

/// The cases that crashed and whose earlier result was kept, with the digest of its record.
fn with_earlier_results(records: &[CaseRecord], dir: &Path) -> Vec<(CaseRecord, String)> {
    let store = Store::at(dir);
    let broken = records.iter().filter(|record| record.broke());
    broken.filter_map(|broke| Some((broke.clone(), store.record(&broke.id)?.provenance.record_sha256))).collect()
}

/// The study with the cases that its kind requests; `None` if it requests none. If it cannot determine them, the report finds and states the reason.
fn next(study: &Study, dir: &Path) -> Result<Option<Study>, RunError> {
    let Some(kind) = kinds::find(&study.record.kind) else { return Ok(None) };
    let rounds = Rounds::read(dir).keep_only(&study.source_sha256, dir);
    if rounds.has_ended() {
        return Ok(None);
    }
    let Ok(results) = results::read(dir) as Result<_, ReportError> else { return Ok(None) };
    let Ok(Some(round)) = (kind.grow)(&results, dir) else { return Ok(None) };
    let has_ended = round.members.is_empty();
    rounds.add(&study.source_sha256, round, dir).map_err(|why| RunError::Apart { why })?;
    if has_ended { Ok(None) } else { Ok(Some(study.again(dir)?)) }
}
