//! Findings of a reduction study, from the record of its models.
//!
//! Pure: stored cases and the record in, [`ReductionFindings`] out.

use crate::report::numbers::{percent, significant};
use crate::study::analysis::{self, Analysis};
use crate::study::kinds::reduction::record::{
    DerivedRecord, InputRecord, ModelRecord, QuantityRecord, ReductionRecord,
};
use crate::study::store::record::Quantity;
use crate::study::store::results::Results;
use crate::wording::count;

/// Findings of a reduction study.
#[derive(Clone, Debug, PartialEq)]
pub struct ReductionFindings {
    pub inputs: Vec<InputRecord>,
    pub quantities: Vec<Quantity>,
    /// None as long as there are no models
    pub derived: Option<DerivedRecord>,
    /// Whether every case has its result
    pub complete: bool,
    /// Most states of a greedy plan
    pub plan: Option<usize>,
    /// The smallest model whose errors are within the tolerance
    pub chosen: Option<usize>,
}

impl ReductionFindings {
    /// Why there is no model, where every case has its result.
    pub fn without_models(&self) -> Option<String> {
        match &self.derived {
            Some(derived) if derived.models.is_empty() => {
                Some(format!("no model could be made: {}", derived.left_out.join(" ")))
            }
            None if self.complete => Some("no model could be made; the report says why".into()),
            _ => None,
        }
    }

    /// The models; none where there are none yet.
    pub fn models(&self) -> &[ModelRecord] {
        self.derived.as_ref().map_or(&[], |d| &d.models)
    }
}

/// Largest error of a quantity as a share of its size.
pub fn relative(q: &QuantityRecord) -> f64 {
    if q.largest == 0.0 { 0.0 } else { q.largest / q.size }
}

/// A time in µs or ms; a dash where none was measured.
pub fn time(seconds: f64) -> String {
    match seconds {
        0.0 => "–".into(),
        s if s < 1e-3 => format!("{:.0} µs", 1e6 * s),
        s if s < 1.0 => format!("{:.1} ms", 1e3 * s),
        s => format!("{s:.1} s"),
    }
}

/// Analyses what is there.
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

/// Bar over error from which on a bar is called wide.
const WIDE: f64 = 5.0;

fn doubts(models: &[ModelRecord], quantities: &[Quantity]) -> Vec<String> {
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

/// How long a small step takes, in a sentence; nothing where none was measured.
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
        let part =
            |(q, asked): (&QuantityRecord, &Quantity)| format!("the {} within {}", asked.label, percent(relative(q)));
        let all: Vec<String> = model.quantities.iter().zip(&found.quantities).map(part).collect();
        all.join(", ")
    };
    match found.chosen.map(|k| &derived.models[k]) {
        Some(model) if derived.dt.is_some() => format!(
            "The model of {} modes and {} points gives {} of the largest change at every step of {} runs that it was not made of. A step of {} takes {} (median; \
             {} in 99 of 100), {} times less than the full model.",
            model.modes,
            model.points,
            of(model),
            derived.held_back,
            time(derived.dt.unwrap_or_default()),
            time(model.leap_s[0]),
            time(model.leap_s[1]),
            significant(model.gain(derived.full_step_s), 2)
        ),
        Some(model) => format!(
            "The model of {} modes and {} points gives {} of the largest change at {} that it was not made of.{} From state to state it takes {}, {} times less \
             than the full model.",
            model.modes,
            model.points,
            of(model),
            count(derived.held_back, "state"),
            small_step(model),
            time(model.leap_s[0]),
            significant(model.gain(derived.full_step_s), 2)
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
mod tests {
    use super::*;

    /// Of one state that was held back there is no way to another, and no small step along it.
    #[test]
    fn what_was_not_measured_is_not_said() {
        let model = |step_s| ModelRecord {
            modes: 5,
            file: String::new(),
            bytes: 0,
            displacements: 5,
            pressures: 0,
            points: 26,
            estimate_points: 40,
            offline_s: 1.0,
            step_s,
            leap_s: [1e-4, 2e-4],
            iterations: [0.0, 5.0],
            quantities: vec![],
        };
        assert_eq!(small_step(&model([0.0; 2])), "");
        assert_eq!(small_step(&model([1e-5, 2e-5])), " A small step takes 10 µs (median; 20 µs in 99 of 100).");
        assert_eq!(time(0.0), "–");
    }
}
