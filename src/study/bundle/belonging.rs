//! Checks that results belong to the study that they are bundled with.

use super::error::BundleError;
use crate::study::expand::Study;
use crate::study::listing::{Listed, State, list};
use crate::study::store::record::StudyRecord;
use crate::wording::few;
use std::collections::BTreeSet;
use std::path::Path;

/// Refuses results of other inputs, for example from changes by `--set` or from a scene that was edited after the run: a rerun would give different
/// results.
pub fn check(file: &Path, dir: &Path, stored: &StudyRecord) -> Result<(), BundleError> {
    let mut study = Study::read_with_added(file, &[], dir)?;
    let mut unknown = others(&study, stored);
    if !unknown.is_empty() {
        // Another build may have requested them
        study = Study::read_as_stored(file, dir)?;
        unknown = others(&study, stored);
    }
    let listed = list(&study, dir);
    let in_state = |state| listed.iter().filter(|c: &&Listed| c.state == state).map(|c| c.id.clone()).collect();
    let found: [(Vec<String>, &str); 3] = [
        (unknown, "the study has no such cases"),
        (in_state(State::Outdated), "they were computed from another scene, other files or another mesh"),
        (in_state(State::Damaged), "their files are not those that were stored"),
    ];
    let fact = |(cases, fact): &(Vec<String>, &str)| format!("{}: {fact}", few(cases));
    let mut facts: Vec<String> = found.iter().filter(|(cases, _)| !cases.is_empty()).map(fact).collect();
    // The version is that of the program, which the environment of the bundle records; the inputs were compared case by case
    let (schema, version, inputs_sha256) = (stored.schema, stored.version.clone(), stored.inputs_sha256.clone());
    let asks = stored.asks.and(study.record.asks);
    if facts.is_empty() && *stored != (StudyRecord { schema, version, asks, inputs_sha256, ..study.record }) {
        facts.push("the study file has changed since: question, tolerance, quantities or families".into());
    }
    match facts.is_empty() {
        true => Ok(()),
        false => Err(BundleError::OtherInputs { path: dir.into(), facts }),
    }
}

/// The cases of stored results that a study does not have.
fn others(study: &Study, stored: &StudyRecord) -> Vec<String> {
    let known: BTreeSet<&str> = study.cases.iter().map(|c| c.id.as_str()).collect();
    let others = stored.families.iter().flat_map(|f| &f.cases).filter(|id| !known.contains(id.as_str()));
    others.collect::<BTreeSet<_>>().into_iter().cloned().collect()
}
