//! The frame that analyses of all kinds of study share, around the results of one kind.

use crate::study::curve::{CHANGE, peak_words};
use crate::study::notes::notes;
use crate::study::store::record::{CaseRecord, FamilyRecord, NOT_RUN, Role, StoredCase, StudyQuantity, StudyRecord};
use crate::wording::{NAMED, all, count, few};
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::ops::Deref;

/// Everything that is said about a study; `T` holds the results that only its kind has.
#[derive(Clone, Debug, PartialEq)]
pub struct Analysis<T> {
    pub tolerance: f64,
    pub found: T,
    /// Cases without a usable result: (id, reason)
    pub incomplete: Vec<(String, String)>,
    pub warnings: Vec<String>,
    /// The answer in words, refusals included
    pub verdict: String,
}

impl<T> Deref for Analysis<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.found
    }
}

/// Everything that is said about one quantity in one variant; `T` holds the results that only the kind of study has.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct ByQuantity<T> {
    pub variant: String,
    /// The variant in words
    pub variant_label: String,
    pub quantity: StudyQuantity,
    /// `maximum`, `minimum`, `extreme` or `largest change of`: the kind of peak over the cases of the variant
    pub peak_is: &'static str,
    #[serde(flatten)]
    pub found: T,
    pub sentence: String,
}

impl<T> Deref for ByQuantity<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.found
    }
}

impl<T> ByQuantity<T> {
    /// Collects variants × quantities for which `find` returns a result; sentences are added later.
    pub fn each(
        study: &StudyRecord,
        stored: &[StoredCase],
        mut find: impl FnMut(&str, &StudyQuantity) -> Option<T>,
    ) -> Vec<Self> {
        let mut all = vec![];
        for variant in &study.variants {
            let cases = || stored.iter().filter(|c| c.is_of(variant) && c.record.converged());
            for quantity in study.quantities.get(variant).into_iter().flatten() {
                all.extend(find(variant, quantity).map(|found| Self {
                    variant: variant.clone(),
                    variant_label: study.label(variant),
                    quantity: quantity.clone(),
                    peak_is: peak_words(cases(), &quantity.name),
                    found,
                    sentence: String::new(),
                }));
            }
        }
        all
    }

    /// Title of the quantity in its variant: `cable tension, length control`.
    pub fn title(&self) -> String {
        format!("{}, {}", self.quantity.label, self.variant_label)
    }

    /// Prefix of the label on an axis of peaks: `change of ` if the peaks are changes, otherwise empty.
    pub fn peak_prefix(&self) -> &'static str {
        if self.peak_is == CHANGE { "change of " } else { "" }
    }

    /// Label of the peak: `change of tip height`, or the label alone if the peak is not a change.
    pub fn peak_label(&self) -> String {
        format!("{}{}", self.peak_prefix(), self.quantity.label)
    }

    /// Symbol of the peak: `Δz` for a change, otherwise the symbol alone.
    pub fn peak_symbol(&self) -> String {
        format!("{}{}", if self.peak_is == CHANGE { "Δ" } else { "" }, self.quantity.symbol)
    }

    /// Title of the peak: `maximum cable tension, length control`.
    pub fn peak_title(&self) -> String {
        format!("{} {}", self.peak_is, self.title())
    }
}

impl<T: Serialize> ByQuantity<T> {
    /// Maps the name of a quantity to its variants, and each variant to its results.
    pub fn as_json(all: &[Self]) -> Map<String, Value> {
        by_name(all, |q| json!(q))
    }
}

/// Maps the name of a quantity to its variants, and each variant to the value of `describe`.
pub fn by_name<T>(all: &[ByQuantity<T>], describe: impl Fn(&ByQuantity<T>) -> Value) -> Map<String, Value> {
    let mut out = Map::new();
    for q in all {
        let entry = out.entry(q.quantity.name.clone()).or_insert_with(|| json!({}));
        entry[&q.variant] = describe(q);
    }
    out
}

/// Warnings about errors that the error bars of these cases leave out: that of the time steps, in variants whose states depend on them and for which it
/// is not `estimated`, and that of the solver, where it is not estimated.
pub fn warnings_of_steps(study: &StudyRecord, stored: &[StoredCase], estimated: impl Fn(&str) -> bool) -> Vec<String> {
    let mut out = vec![];
    let cases: Vec<&StoredCase> = stored.iter().filter(|c| c.record.converged()).collect();
    let depends = |variant: &str| cases.iter().any(|c| c.is_of(variant) && c.record.depends_on_steps());
    let without: Vec<&String> = study.variants.iter().filter(|v| depends(v) && !estimated(v)).collect();
    if !without.is_empty() {
        let is_one = |c: &&&StoredCase| c.record.depends_on_steps() && without.iter().any(|v| c.is_of(v));
        let labels: Vec<String> = without.iter().map(|v| study.label(v)).collect();
        let of = if without.len() == study.variants.len() { String::new() } else { format!(" of {}", all(&labels)) };
        let runs = |f: &&FamilyRecord| f.role == Role::TimeStep && cases.iter().any(|c| c.is_in(&f.name, without[0]));
        let remedy = match study.families.iter().find(runs) {
            Some(f) => format!("family {} has no two time steps on one mesh, one of them that of the meshes", f.name),
            None => "add a family of role \"time_step\"".into(),
        };
        out.push(format!(
            "The states of {} of {} cases depend on the time steps, whose error is not estimated and in no error bar{of}: {remedy}.",
            cases.iter().filter(is_one).count(),
            cases.len()
        ));
    }
    let unknown = cases.iter().filter(|c| c.record.solver.steps_without_algebraic_error > 0).count();
    if unknown > 0 {
        out.push(format!(
            "The algebraic error of {unknown} of {} cases is not estimated in every step: steps by arc length, by contact corrections and \
             linearised ones are accepted by their residual.",
            cases.len()
        ));
    }
    out
}

/// Ratio of wall time to CPU time above which a run counts as disturbed by other programs \[–\].
const DISTURBED: f64 = 1.1;

/// Ratios of wall time to CPU time of the disturbed cases.
pub fn disturbed<'a>(records: impl Iterator<Item = &'a CaseRecord>) -> Vec<f64> {
    let timed = records.filter(|r| r.cpu_s > 0.0);
    timed.map(|r| r.wall_s / r.cpu_s).filter(|x| *x > DISTURBED).collect()
}

/// Warnings about costs. These are CPU seconds in every kind of study that compares them: other programs do not add to them directly, but share caches
/// and memory with the run.
pub fn warnings_of_costs(stored: &[StoredCase]) -> Vec<String> {
    let records = || stored.iter().map(|c| &c.record);
    let mut out = vec![];
    if records().any(|r| r.shared) {
        out.push("Cases ran at the same time: costs are CPU seconds, and `--jobs 1` gives quieter ones.".into());
    }
    let disturbed = disturbed(records());
    if !disturbed.is_empty() {
        out.push(format!(
            "The machine was busy: {} of {} took more than {DISTURBED} times their CPU seconds by the clock, one {:.1} times. \
             Costs are CPU seconds; what shares caches and memory disturbs them too.",
            disturbed.len(),
            count(stored.len(), "case"),
            disturbed.iter().copied().fold(0.0, f64::max)
        ));
    }
    out
}

/// Returns one warning for each case without a usable result, or a single one for all cases that were not run if there are many.
pub fn warnings(incomplete: &[(String, String)]) -> Vec<String> {
    let (not_run, failed): (Vec<_>, Vec<_>) = incomplete.iter().partition(|(_, what)| what == NOT_RUN);
    let each = |(id, what): &(String, String)| format!("Case {id}: {what}.");
    let mut out: Vec<String> = failed.into_iter().map(each).collect();
    if not_run.len() > NAMED {
        let ids: Vec<&String> = not_run.into_iter().map(|(id, _)| id).collect();
        out.push(format!("{} cases have no result yet: {}.", ids.len(), few(&ids)));
    } else {
        out.extend(not_run.into_iter().map(each));
    }
    out
}

/// Adds the notes of the cases, without repetition.
pub fn add_notes(warnings: &mut Vec<String>, stored: &[StoredCase]) {
    for note in notes(stored) {
        if !warnings.contains(&note) {
            warnings.push(note);
        }
    }
}

/// End of a verdict if some cases have no usable result; otherwise empty.
pub fn without_result(cases: usize) -> String {
    match cases {
        0 => String::new(),
        1 => " One case has no usable result.".into(),
        _ => format!(" {cases} cases have no usable result."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::numbers::space;
    use crate::study::store::record::Series;

    #[test]
    fn many_cases_that_were_not_run_are_one_warning() {
        let case = |id: &str, what: &str| (id.to_string(), what.to_string());
        let mut cases = vec![case("a", NOT_RUN), case("f", "Singular"), case("b", NOT_RUN), case("c", NOT_RUN)];
        let few = warnings(&cases);
        assert_eq!(
            few,
            ["Case f: Singular.", "Case a: has no result.", "Case b: has no result.", "Case c: has no result."]
        );
        cases.push(case("d", NOT_RUN));
        assert_eq!(warnings(&cases), ["Case f: Singular.", "4 cases have no result yet: a, b, c and 1 more."]);
    }

    /// A case whose wall time is half as long again as its CPU time is reported; one with 5 % more, and one without a measured CPU time, are not.
    #[test]
    fn a_busy_machine_is_told_by_the_cases_that_waited() {
        let case = |(wall_s, cpu_s): (f64, f64)| {
            let record = CaseRecord { wall_s, cpu_s, ..CaseRecord::default() };
            StoredCase::new(record, Series::default())
        };
        let mut cases = [(2.1, 2.0), (3.0, 2.0), (5.0, 0.0)].map(case);
        let busy = "The machine was busy: 1 of 3 cases took more than 1.1 times their CPU seconds by the clock, one 1.5 times. ";
        let all = warnings_of_costs(&cases);
        assert!(all.len() == 1 && all[0].starts_with(busy), "{all:?}");
        assert_eq!(warnings_of_costs(&cases[..1]), Vec::<String>::new());
        cases[0].record.shared = true;
        let all = warnings_of_costs(&cases);
        assert!(
            all.len() == 2 && all[0].starts_with("Cases ran at the same time") && all[1].starts_with(busy),
            "{all:?}"
        );
    }

    #[test]
    fn a_peak_that_is_a_change_is_called_one() {
        let quantity = StudyQuantity { label: "tip height".into(), symbol: "z".into(), ..StudyQuantity::default() };
        let of = |peak_is| ByQuantity {
            variant: String::new(),
            variant_label: String::new(),
            quantity: quantity.clone(),
            peak_is,
            found: (),
            sentence: String::new(),
        };
        assert_eq!([of(CHANGE).peak_label(), of(CHANGE).peak_symbol()], ["change of tip height", "Δz"]);
        assert_eq!([of("maximum").peak_label(), of("maximum").peak_symbol()], ["tip height", "z"]);
        assert_eq!(["m", "°", "1", ""].map(space), [" m", "°", "", ""]);
    }
}
