//! The builds of this program that computed the results of a study.

use crate::study::store::identity::Build;
use crate::study::store::record::CaseRecord;

/// The builds that computed these results, each with its cases, in order of decreasing number of cases; of equal ones, this program comes first.
pub fn builds<'a>(records: impl Iterator<Item = &'a CaseRecord>) -> Vec<(Build, Vec<String>)> {
    let mut all: Vec<(Build, Vec<String>)> = vec![];
    for record in records {
        let build = &record.provenance.build;
        match all.iter_mut().find(|(known, _)| known == build) {
            Some((_, cases)) => cases.push(record.id.clone()),
            None => all.push((build.clone(), vec![record.id.clone()])),
        }
    }
    let this = Build::this();
    all.sort_by_key(|(build, cases)| (std::cmp::Reverse(cases.len()), *build != this));
    all
}

/// A warning if the results of a study come from more than one build.
pub fn warning<'a>(records: impl Iterator<Item = &'a CaseRecord>) -> Option<String> {
    let builds = builds(records);
    let others: Vec<String> =
        builds.iter().skip(1).map(|(build, cases)| format!("{} ({})", cases.join(", "), build.words())).collect();
    (!others.is_empty()).then(|| {
        format!(
            "Computed by other builds of this program than the rest: {}. Run the study again to compute all cases by one.",
            others.join("; ")
        )
    })
}
