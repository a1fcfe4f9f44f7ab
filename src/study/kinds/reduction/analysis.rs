//! Findings of a reduction study, from the record of its models.
//!
//! Pure: stored cases and the record in, [`ReductionFindings`] out.

use crate::report::numbers::{percent, significant};
use crate::study::analysis::{self, Analysis};
use crate::study::kinds::reduction::record::{
    DerivedRecord, ModelRecord, QuantityRecord, ReductionInputRecord, ReductionRecord,
};
use crate::study::store::record::StudyQuantity;
use crate::study::store::results::Results;
use crate::wording::count;

/// Findings of a reduction study.
#[derive(Clone, Debug, PartialEq)]
pub struct ReductionFindings {
    pub inputs: Vec<ReductionInputRecord>,
    pub quantities: Vec<StudyQuantity>,
    /// Record of the models; `None` as long as there are none
    pub derived: Option<DerivedRecord>,
    /// Whether every case has its result
    pub complete: bool,
    /// Largest number of states of a greedy plan
    pub plan: Option<usize>,
    /// Index of the smallest model whose errors are within the tolerance
    pub chosen: Option<usize>,
}

impl ReductionFindings {
    /// Returns why there is no model although every case has its result.
    pub fn without_models(&self) -> Option<String> {
        match &self.derived {
            Some(derived) if derived.models.is_empty() => {
                Some(format!("no model could be made: {}", derived.left_out.join(" ")))
            }
            None if self.complete => Some("no model could be made; the report says why".into()),
            _ => None,
        }
    }

    /// Returns the models; an empty slice as long as there are none.
    pub fn models(&self) -> &[ModelRecord] {
        self.derived.as_ref().map_or(&[], |d| &d.models)
    }
}

/// Returns the largest error of a quantity relative to its size.
pub fn relative(q: &QuantityRecord) -> f64 {
    if q.largest == 0.0 { 0.0 } else { q.largest / q.size }
}

/// Formats a time in µs or ms; a dash if it was not measured.
pub fn time(seconds: f64) -> String {
    match seconds {
        0.0 => "–".into(),
        s if s < 1e-3 => format!("{:.0} µs", 1e6 * s),
        s if s < 1.0 => format!("{:.1} ms", 1e3 * s),
        s => format!("{s:.1} s"),
    }
}

/// Analyses the stored results.
pub fn analyse(results: &Results, record: &ReductionRecord) -> Analysis<ReductionFindings> {
    let study = &results.study;
    let read = |value: &serde_json::Value| serde_json::from_value::<DerivedRecord>(value.clone());
    let (derived, unread) = match results.derived.as_ref().map(read) {
        None => (None, None),
        Some(Ok(derived)) => (Some(derived), None),
        Some(Err(why)) => (
            None,
            Some(format!("The record of the models cannot be read: {why}. Delete derived.json and report again.")),
        ),
    };
    let quantities = study.quantities.values().next().cloned().unwrap_or_default();
    let within = |model: &ModelRecord| {
        model.quantities.iter().zip(&quantities).all(|(q, asked)| {
            let accepted = study.tolerance * q.size;
            let failed = q.errors.iter().any(Option::is_none);
            !failed && q.largest <= accepted.max(asked.absolute_tolerance.unwrap_or(0.0))
        })
    };
    let models = derived.as_ref().map_or(&[][..], |d| &d.models);
    let chosen = models.iter().position(within);
    let incomplete = study.incomplete(&results.cases);
    let mut warnings = analysis::warnings(&incomplete);
    warnings.extend(unread);
    warnings.extend(derived.iter().flat_map(|d| d.left_out.iter().cloned()));
    warnings.extend(doubts(models, &quantities));
    analysis::add_notes(&mut warnings, &results.cases);
    let complete = incomplete.is_empty();
    let plan = record.greedy.as_ref().map(|plan| plan.states);
    let found = ReductionFindings { inputs: record.inputs.clone(), quantities, derived, complete, plan, chosen };
    let verdict = verdict(&found, study.tolerance) + &analysis::without_result(incomplete.len());
    Analysis { tolerance: study.tolerance, found, incomplete, warnings, verdict }
}

/// Ratio of bar to error above which a bar is called wide.
const WIDE: f64 = 5.0;

fn doubts(models: &[ModelRecord], quantities: &[StudyQuantity]) -> Vec<String> {
    let mut out = vec![];
    for model in models {
        for (q, asked) in model.quantities.iter().zip(quantities) {
            let failed = q.errors.iter().filter(|e| e.is_none()).count();
            if failed > 0 {
                out.push(format!("{} modes: {failed} of {} steps found no equilibrium.", model.modes, q.errors.len()));
            }
            if q.bar_over_error > WIDE {
                out.push(format!(
                    "{} modes: the error bar of the {} is {:.0} times as large as its error in the median: the estimate does not follow errors that \
                     are this small.",
                    model.modes, asked.label, q.bar_over_error
                ));
            }
        }
    }
    out.dedup();
    out
}

/// The CPU time of a small step, in a sentence; empty if it was not measured.
fn small_step(model: &ModelRecord) -> String {
    let [median, last] = model.step_s;
    if median == 0.0 {
        return String::new();
    }
    format!(" A small step takes {} (median; {} in 99 of 100).", time(median), time(last))
}

fn verdict(found: &ReductionFindings, tolerance: f64) -> String {
    let Some(derived) = &found.derived else {
        if found.complete {
            return "No verdict: no model could be made; the warnings say why.".into();
        }
        return "No verdict: not every run has a result, so that no model is made.".into();
    };
    let of = |model: &ModelRecord| {
        let part = |(q, asked): (&QuantityRecord, &StudyQuantity)| {
            format!("the {} within {}", asked.label, percent(relative(q)))
        };
        let all: Vec<String> = model.quantities.iter().zip(&found.quantities).map(part).collect();
        all.join(", ")
    };
    match found.chosen.map(|k| &derived.models[k]) {
        Some(model) if derived.dt.is_some() => format!(
            "The model of {} modes and {} points gives {} of the largest change at every step of {} runs that it was not made of. A step of {} takes {} (median; \
             {} in 99 of 100), {} times less CPU time than {}.",
            model.modes,
            model.points,
            of(model),
            derived.held_back,
            time(derived.dt.unwrap_or_default()),
            time(model.leap_s[0]),
            time(model.leap_s[1]),
            significant(model.gain(derived.full_step_s), 2),
            derived.full()
        ),
        Some(model) => format!(
            "The model of {} modes and {} points gives {} of the largest change at {} that it was not made of.{} From state to state it takes {}, {} times less \
             CPU time than {}.",
            model.modes,
            model.points,
            of(model),
            count(derived.held_back, "state"),
            small_step(model),
            time(model.leap_s[0]),
            significant(model.gain(derived.full_step_s), 2),
            derived.full()
        ),
        None if derived.models.is_empty() => "No verdict: no model could be made; the warnings say why.".into(),
        None => {
            let best = derived.models.last().map(|model| format!("that of {} modes gives {}", model.modes, of(model)));
            let (state, states) = if derived.dt.is_some() { ("step of the runs", "runs") } else { ("state", "states") };
            format!(
                "No model is within {} at every {state} that it was not made of: {}. Take more modes, more training {states}, or a smaller `sampling`.",
                percent(tolerance),
                best.unwrap_or_default()
            )
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// With a single held-back state there is no path to another one, and so no small step along it.
    #[test]
    fn what_was_not_measured_is_not_said() {
        let model = |step_s| ModelRecord { step_s, ..found(0.0, None).models()[0].clone() };
        assert_eq!(small_step(&model([0.0; 2])), "");
        assert_eq!(small_step(&model([1e-5, 2e-5])), " A small step takes 10 µs (median; 20 µs in 99 of 100).");
        assert_eq!(time(0.0), "–");
    }

    /// The models of a study: one of 5 modes, with its largest error of a quantity that changes by 2.
    pub fn found(largest: f64, chosen: Option<usize>) -> ReductionFindings {
        let derived = serde_json::json!({
            "sources_sha256": "", "training": 24, "held_back": 1, "singular_values": [], "pressure_values": [],
            "full_step_s": 1.0, "offline_s": 0.0, "left_out": [],
            "models": [{
                "modes": 5, "file": "", "bytes": 0, "displacements": 5, "pressures": 0, "points": 26, "estimate_points": 40,
                "offline_s": 1.0, "step_s": [0.0, 0.0], "leap_s": [1e-4, 2e-4], "iterations": [0.0, 5.0],
                "quantities": [{
                    "name": "tip_z_m", "size": 2.0, "largest": largest, "median": largest, "factor": 1.0, "floor": 1e-9,
                    "bar_over_error": 1.0, "errors": [[largest, 0.0]],
                }],
            }],
        });
        let quantity = StudyQuantity { label: "height of the tip".into(), ..StudyQuantity::default() };
        ReductionFindings {
            inputs: vec![],
            quantities: vec![quantity],
            derived: Some(serde_json::from_value(derived).expect("a record")),
            complete: true,
            plan: None,
            chosen,
        }
    }

    /// The verdict says which model has which error over how many states, and states only times that were measured.
    #[test]
    fn the_verdict_is_of_the_model_that_was_measured() {
        assert_eq!(
            verdict(&found(0.01, Some(0)), 0.01),
            "The model of 5 modes and 26 points gives the height of the tip within 0.50 % of the largest change at 1 state that it was not made of. From state to \
             state it takes 100 µs, 10000 times less CPU time than the full model."
        );
        let mut apart = found(0.01, Some(0));
        apart.derived.iter_mut().for_each(|derived| derived.full_from_rest = true);
        assert!(verdict(&apart, 0.01).ends_with("10000 times less CPU time than the full model from rest."));
        let none = verdict(&found(0.24, None), 0.01);
        let best = "No model is within 1 % at every state that it was not made of: that of 5 modes gives the height of the tip within 12 %.";
        assert!(none.starts_with(best), "{none}");
    }

    /// A quantity that never changes and has no error is exact.
    #[test]
    fn no_error_of_nothing_is_no_error() {
        let mut record = found(0.0, None).derived.expect("models").models.remove(0).quantities.remove(0);
        record.size = 0.0;
        assert_eq!(relative(&record), 0.0);
        record.largest = 1e-3;
        assert_eq!(relative(&record), f64::INFINITY);
    }

    /// A record of models that this program cannot read is reported with its remedy, and no verdict uses it.
    #[test]
    fn a_record_that_cannot_be_read_is_told() {
        let study = serde_json::json!({
            "study": "bar", "kind": "reduction", "question": "", "expectation": "", "tolerance": 0.01, "quantities": {}, "variants": [], "families": [],
            "version": "",
        });
        let record = serde_json::json!({
            "scene": "scene.toml", "inputs": [], "training": {}, "held_back": {}, "modes": [5], "sampling": 0.01,
        });
        let results = Results {
            study: serde_json::from_value(study).expect("a study"),
            cases: vec![],
            skins: BTreeMap::new(),
            motions: BTreeMap::new(),
            found: BTreeMap::new(),
            sensitivities: BTreeMap::new(),
            derived: Some(serde_json::json!({ "models": 5 })),
            damaged: vec![],
            outdated: vec![],
        };
        let a = analyse(&results, &serde_json::from_value(record).expect("details"));
        let told = |w: &String| {
            w.starts_with("The record of the models cannot be read: ")
                && w.ends_with("Delete derived.json and report again.")
        };
        assert!(a.warnings.iter().any(told), "{:?}", a.warnings);
        assert!(a.found.derived.is_none() && a.verdict.starts_with("No verdict"), "{}", a.verdict);
    }
}
