//! Marks a report whose study has changed since: its verdict does not belong to the present inputs. Models made from results of other inputs are
//! removed.

use crate::storage::{self, DATA_LIMIT};
use crate::study::store::folder::{StoreError, unwritable};
use crate::study::store::outdated::check_summary;
use crate::study::store::record::StudyRecord;
use crate::study::store::report_files::ReportFiles;
use std::path::Path;

/// Fact and remedy.
const WORDS: &str = "The study or its inputs have changed since this report was written: its verdict is that of the earlier ones. \
                     Run the study to the end, or call durometer report, to write it anew.";

/// Marks the page and the summary of a report in a folder if they belong to another study, or to inputs other than the present ones. Files made once
/// from results of other inputs, such as reduced models, are removed, since they are used without the report.
///
/// # Errors
///
/// A folder that cannot be written.
pub fn mark(dir: &Path, study: &StudyRecord) -> Result<(), StoreError> {
    let is_of_others = match ReportFiles::read(dir) {
        Some(report) => {
            let is_of_other_inputs = report.is_of_other_inputs(dir, study);
            if is_of_other_inputs {
                report.remove_derived(dir);
            }
            is_of_other_inputs || report.is_of_other_study(study)
        }
        None => check_summary(dir, study).is_err(),
    };
    if !is_of_others {
        return Ok(());
    }
    let banner = format!("<body>\n<p class=\"verdict refused\">{WORDS}</p>\n");
    add(dir, "index.html", ("<body>\n", &banner))?;
    add(dir, "summary.json", ("{\n", &format!("{{\n  \"superseded\": \"{WORDS}\",\n")))
}

/// Inserts a mark at its position in a file, once.
fn add(dir: &Path, name: &str, (place, marked): (&str, &str)) -> Result<(), StoreError> {
    let path = dir.join(name);
    let Ok(text) = storage::read_text(&path, DATA_LIMIT) else { return Ok(()) };
    if text.contains(WORDS) || !text.contains(place) {
        return Ok(());
    }
    storage::write(&path, text.replacen(place, marked, 1).as_bytes()).map_err(|e| unwritable(&path, &e))
}
