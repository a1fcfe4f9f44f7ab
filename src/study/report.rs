//! The report of a study: reads the stored results, analyses them, and writes `summary.json`, figures, tables and `index.html`.
//!
//! Nothing is solved here; [`write_report()`] can be called again on a folder to redraw the report.

use crate::report::export::Pictures;
use crate::report::figure::Figure;
use crate::report::paper::Parts;
use crate::report::{ReportError, files, viewer};
use crate::storage::writing::Writing;
use crate::study::content::Content;
use crate::study::curve::missed_extremes;
use crate::study::kind::{Kind, Underived};
use crate::study::kinds::{self, KINDS};
use crate::study::overlay::{in_study, markers_in_study};
use crate::study::page;
use crate::study::paper::{self, OwnMethods};
use crate::study::store::record::CaseRecord;
use crate::study::store::report_files::{self, ReportFiles};
use crate::study::store::results::Results;
use crate::study::store::{builds, collapse_record, energy_record, results, sunk_record};
use crate::study::summary;
pub use crate::study::summary::Summary;
use crate::study::view;
use crate::wording::few;
use std::path::Path;

/// Writes the report of the study in `dir`, next to its cases.
///
/// If a figure cannot be drawn, the numbers and the page are still written, and the page reports the missing figure. `summary.json` is written first,
/// in case the disk is full.
///
/// # Errors
///
/// Results that cannot be read or belong to other inputs, or a file that cannot be written.
pub fn write_report(dir: &Path) -> Result<Summary, ReportError> {
    let mut results = results::read(dir)?;
    let kind = kinds::find(&results.study.kind).ok_or_else(|| ReportError::Kind {
        path: dir.join("study.json"),
        kind: results.study.kind.clone(),
        known: KINDS.map(|kind| kind.name).join(", "),
    })?;
    let earlier = ReportFiles::read(dir);
    let mut own = ReportFiles::of(&results.study, results.cases.iter().map(|c| &c.record));
    let underived = derive(kind, &mut results, (earlier.as_ref(), &mut own), dir);
    let writing = Writing::begin();
    let mut content =
        (kind.report)(&results).map_err(|source| ReportError::Malformed { path: dir.join("study.json"), source })?;
    if let Some(why) = results.study.without_verdict() {
        content = content.without_verdict(why);
    }
    content.warnings.extend(builds::warning(results.cases.iter().map(|c| &c.record)));
    let grown = results.cases.iter().map(|c| &c.record);
    let grown = grown.filter_map(|record| Some((record.id.as_str(), record.solver.energy_from_nothing.as_ref()?)));
    content.warnings.extend(energy_record::warning(grown));
    let collapsed = results.cases.iter().map(|c| (c.record.id.as_str(), &c.record.solver.collapsed_cavities[..]));
    content.warnings.extend(collapse_record::warning(collapsed));
    let sunken = results.cases.iter().map(|c| (c.record.id.as_str(), &c.record.solver.sunken_facets[..]));
    content.warnings.extend(sunk_record::warning(sunken));
    content.warnings.extend(missed_extremes(&results.study, &results.cases));
    content.warnings.extend(results.damaged.iter().cloned().chain(underived));
    content.warnings.extend(outdated(&results.outdated));
    content.figures.extend(in_study::figures(&results));
    content.figures.extend(markers_in_study::figures(&results));
    content.tables.extend(in_study::table(&results));
    content.tables.extend(markers_in_study::table(&results));
    let (figures, pictures) = pictures(&mut content);
    let summary = summary::summarise(&results, &content, (kind.judged)(&results.study, &results.cases));
    let text = serde_json::to_string_pretty(&summary).expect("numbers, strings and string keys only");
    files::write(&dir.join("summary.json"), text.as_bytes())?;
    files::folder(&dir.join("tables"))?;
    for table in content.all_tables() {
        table.save(&dir.join("tables"))?;
    }
    for (name, text) in &content.files {
        files::write(&dir.join(name), text.as_bytes())?;
    }
    files::folder(&dir.join("figures"))?;
    let shown = view::cases(&results);
    if !shown.is_empty() {
        files::write(&dir.join(page::VIEW), viewer::page::page(&results.study.study, &shown).as_bytes())?;
    }
    files::write(&dir.join("index.html"), page::html(&results, &content, &figures, &shown).as_bytes())?;
    for (figure, pictures) in figures.iter().zip(&pictures) {
        pictures.save(&dir.join("figures"), figure)?;
    }
    let records: Vec<&CaseRecord> = results.cases.iter().map(|c| &c.record).collect();
    let methods = OwnMethods { errors: &content.errors, search: &content.search };
    paper::write(&dir.join("paper"), &records, methods, parts(&results.study.question, &content, &figures))?;
    own.files = report_files::names(writing.files(), dir);
    let path = dir.join(report_files::FILE);
    own.replace(earlier.as_ref(), dir).map_err(|source| ReportError::Unwritable { path, source })?;
    Ok(summary)
}

/// Performs the work of a kind on the results of all cases and records the files that it made or kept; returns the reason if it could not be done.
fn derive(
    kind: &Kind,
    results: &mut Results,
    (earlier, own): (Option<&ReportFiles>, &mut ReportFiles),
    dir: &Path,
) -> Option<String> {
    let writing = Writing::begin();
    let derived = (kind.derive)(results, dir);
    own.derived = report_files::names(writing.files(), dir);
    // Files that are not made again are kept as long as the results that they derive from, unless these are refused
    let stays = |earlier: &&ReportFiles| {
        own.derived.is_empty()
            && !matches!(derived, Err(Underived::Refused(_)))
            && earlier.kind == own.kind
            && !earlier.is_of_other_inputs(dir, &results.study)
    };
    if let Some(earlier) = earlier.filter(stays) {
        own.derived.clone_from(&earlier.derived);
    }
    match derived {
        Ok(derived) => {
            results.derived = derived;
            None
        }
        Err(why) => Some(format!("{why}.")),
    }
}

/// A warning if stored results belong to inputs other than the present ones of the study.
fn outdated(cases: &[String]) -> Option<String> {
    let few = few(cases);
    let words = match cases.len() {
        0 => return None,
        1 => format!("The stored result of case {few} is of other inputs than the study has now, and does not count"),
        n => format!(
            "The stored results of {n} cases are of other inputs than the study has now, and do not count: {few}"
        ),
    };
    Some(format!("{words}. Run the study to compute them anew."))
}

fn parts<'a>(title: &'a str, content: &'a Content, figures: &'a [Figure]) -> Parts<'a> {
    let tables = content.all_tables().filter(|t| !t.rows.is_empty()).map(|t| t.name).collect();
    Parts { title, tables_in: "tables", tables, figures: figures.iter().map(|f| f.name.as_str()).collect() }
}

/// The figures that could be drawn, each in its formats; the others become warnings.
fn pictures(content: &mut Content) -> (Vec<Figure>, Vec<Pictures>) {
    let (mut figures, mut all) = (vec![], vec![]);
    for drawn in std::mem::take(&mut content.figures) {
        match drawn.and_then(|figure| Pictures::of(&figure.name, &figure.svg).map(|pictures| (figure, pictures))) {
            Ok((figure, pictures)) => {
                figures.push(figure);
                all.push(pictures);
            }
            Err(why) => content.warnings.push(format!("The report is without a figure: {why}.")),
        }
    }
    (figures, all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::kind::Derive;
    use std::collections::BTreeMap;

    /// Models derived from these results are kept if a run is missing or a file of the scene has changed, but not if the results are refused.
    #[test]
    fn what_was_made_of_refused_results_does_not_stay() {
        let study = serde_json::json!({
            "study": "bar", "kind": "reduction", "question": "", "expectation": "", "tolerance": 0.01, "quantities": {}, "variants": [], "families": [],
            "version": "",
        });
        let mut results = Results {
            study: serde_json::from_value(study).expect("a study"),
            cases: vec![],
            skins: BTreeMap::new(),
            motions: BTreeMap::new(),
            found: BTreeMap::new(),
            sensitivities: BTreeMap::new(),
            derived: None,
            damaged: vec![],
            outdated: vec![],
        };
        let folder = tempfile::tempdir().expect("a temporary folder");
        let new = ReportFiles::of(&results.study, std::iter::empty());
        let mut earlier = new.clone();
        earlier.derived.insert("models/bar-4.durom".into());
        let ways: [(Derive, bool); 3] = [
            (|_, _| Ok(None), true),
            (|_, _| Err(Underived::NotAsComputed("a.csv has other contents now".into())), true),
            (|_, _| Err("steps were cut".to_string().into()), false),
        ];
        for (way, stays) in ways {
            let kind = Kind { derive: way, ..*kinds::find("reduction").expect("a kind") };
            let mut own = new.clone();
            let why = derive(&kind, &mut results, (Some(&earlier), &mut own), folder.path());
            assert_eq!(own.derived == earlier.derived, stays, "{why:?}");
            assert!(stays || own.derived.is_empty(), "{:?}", own.derived);
        }
    }
}
