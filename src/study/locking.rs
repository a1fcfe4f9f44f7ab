//! Cases whose pressures indicate locking: a sentence for every report, and one for a verdict that recommends such a case.

use crate::effect::pressure_scatter::ALARM;
use crate::report::names::title;
use crate::report::numbers::{percent, span};
use crate::study::store::record::{CaseRecord, StoredCase};
use crate::wording::count;

/// Remedy for the alarm.
pub const REMEDY: &str = "take formulation = \"mixed\", or show by a finer mesh that the answer stays";

/// Pressure scatter \[–\] of a case that raises the alarm; otherwise `None`.
pub fn alarm(c: &CaseRecord) -> Option<f64> {
    c.locking.filter(|l| l.alarm).map(|l| l.pressure_scatter)
}

/// Reports which cases raise the alarm, by formulation; `None` if no case does.
pub fn sentence(stored: &[StoredCase]) -> Option<String> {
    let raised: Vec<(&CaseRecord, f64)> = stored.iter().filter_map(|c| Some((&c.record, alarm(&c.record)?))).collect();
    let mut formulations: Vec<&str> = raised.iter().map(|(c, _)| c.formulation.as_str()).collect();
    formulations.sort_unstable();
    formulations.dedup();
    let each = |name: &&str| {
        let of = || raised.iter().filter(|(c, _)| c.formulation == **name);
        let all = stored.iter().filter(|c| c.record.formulation == **name).count();
        let by = span(of().map(|(_, s)| *s), |s| format!("{s:.2}")).unwrap_or_default();
        format!("{} of {} of {} (by {by})", of().count(), count(all, "case"), title(name))
    };
    let words: Vec<String> = formulations.iter().map(each).collect();
    (!words.is_empty()).then(|| {
        format!(
            "Locking alarm: pressures that scatter from cell to cell by more than {} of the deviatoric stress in {}. \
             Their stiffness is partly the mesh's: {REMEDY}.",
            percent(ALARM),
            words.join(" and ")
        )
    })
}
