//! Analysis of a validation: the calibration, the predictions with their budgets, and their score.

use crate::math::statistics::larger;
use crate::report::numbers::{capital, percent, space};
use crate::study::analysis::{self, Analysis};
use crate::study::kinds::validation::evaluate::still_rings;
use crate::study::kinds::validation::findings::{FoundScatter, ValidationFindings};
use crate::study::kinds::validation::outcomes::Calibration;
use crate::study::kinds::validation::plan::{QuantityPlan, ValidationPlan};
use crate::study::kinds::validation::responses::{Target, targets};
use crate::study::kinds::validation::scatter::{Repeats, Scatter};
use crate::study::kinds::validation::spec::Purpose;
use crate::study::kinds::validation::words::{of_scatter, verdict, warn_of_fit, warn_of_scatter};
use crate::study::store::results::Results;

/// Analyses the cases that have a result.
pub fn analyse(results: &Results, plan: &ValidationPlan) -> Analysis<ValidationFindings> {
    let incomplete = results.study.incomplete(&results.cases);
    let mut warnings = analysis::warnings(&incomplete);
    analysis::add_notes(&mut warnings, &results.cases);
    let found = match find(results, plan, &mut warnings) {
        Ok(found) => found,
        Err(why) => {
            warnings.push(format!("{}.", capital(&why)));
            ValidationFindings {
                constants: vec![],
                fitted: vec![],
                widened: 1.0,
                chi2: 0.0,
                freedom: 0,
                predictions: vec![],
                reference: plan.reference.clone(),
                sources: sources_of(plan, &[]),
                scatter: vec![],
                tracks: plan.tracks.clone(),
            }
        }
    };
    let verdict = verdict(&found) + &analysis::without_result(incomplete.len());
    Analysis { tolerance: results.study.tolerance, found, incomplete, warnings, verdict }
}

fn find(results: &Results, plan: &ValidationPlan, warnings: &mut Vec<String>) -> Result<ValidationFindings, String> {
    let repeats: Vec<Repeats> = plan.quantities.iter().map(|q| Repeats::of(&q.records)).collect();
    let scatter = scatters(plan, &repeats);
    warn_of_scatter(&scatter, warnings);
    let targets = targets(results, plan, &repeats)?;
    warn_of_ringing(results, &targets, warnings);
    let of = |purpose: Purpose| targets.iter().filter(move |t| t.record.purpose == purpose).collect::<Vec<&Target>>();
    let (data, predicted) = (of(Purpose::Calibration), of(Purpose::Prediction));
    let calibration = Calibration::of(results, plan, &data)?;
    warn_of_fit(&calibration.solution, &calibration.consistency, plan, warnings);
    let predictions = calibration.predictions(&predicted, warnings);
    let constants = calibration.constants();
    let told = |doubt: &String| predictions.iter().any(|p| p.doubts.contains(doubt));
    warnings.extend(constants.iter().flat_map(|c| {
        let own = c.doubts.iter().filter(|d| !told(d));
        own.map(|d| format!("{}: {d}.", capital(&c.label)))
    }));
    Ok(ValidationFindings {
        constants,
        fitted: calibration.fitted(),
        widened: calibration.widened,
        chi2: calibration.solution.chi2,
        freedom: calibration.solution.freedom,
        predictions,
        reference: plan.reference.clone(),
        sources: sources_of(plan, &scatter),
        scatter,
        tracks: plan.tracks.clone(),
    })
}

/// Warns of records in time of which the last row is used although its column oscillates by more than the tolerance.
fn warn_of_ringing(results: &Results, targets: &[Target], warnings: &mut Vec<String>) {
    for t in targets {
        let runs = results
            .cases
            .iter()
            .filter(|c| c.is_of(&t.record.name) && c.record.converged() && c.record.depends_on_steps());
        let most = runs.filter_map(|c| still_rings(t.quantity, &c.series)).fold(0.0, larger);
        if most > results.study.tolerance {
            warnings.push(format!(
                "{} of {} still rings by {} of its change at the end of the run, and its value is that of the last row: run longer, or take a static stage.",
                capital(&t.quantity.label),
                t.record.label,
                percent(most)
            ));
        }
    }
}

/// The scatter of the quantities that have repeats.
fn scatters(plan: &ValidationPlan, repeats: &[Repeats]) -> Vec<FoundScatter> {
    let of = |q: &QuantityPlan, record: Option<String>, s: Scatter| FoundScatter {
        quantity: q.label.clone(),
        record,
        unit: q.unit.clone(),
        deviation: s.variance.sqrt(),
        freedom: s.freedom,
    };
    let label = |name: &str| plan.records.iter().find(|r| r.name == name).map_or(name.into(), |r| r.label.clone());
    let one = |(q, repeats): (&QuantityPlan, &Repeats)| {
        let alone = repeats.alone().map(|(name, s)| of(q, Some(label(name)), s));
        repeats.pooled.map(|s| of(q, None, s)).into_iter().chain(alone).collect::<Vec<_>>()
    };
    plan.quantities.iter().zip(repeats).flat_map(one).collect()
}

/// The terms of the budget with the origin of each.
fn sources_of(plan: &ValidationPlan, scatter: &[FoundScatter]) -> Vec<(String, String, String)> {
    let inputs =
        plan.inputs.iter().map(|i| (format!("{} ({})", i.name, i.group), i.deviation.clone(), i.source.clone()));
    let mut all: Vec<(String, String, String)> = inputs.collect();
    for (q, record, group, deviation, source) in plan.quantities.iter().flat_map(of_tracks) {
        all.push((format!("{} of {record} ({group})", q.label), format!("{deviation:.3e}{}", space(&q.unit)), source));
    }
    for s in scatter {
        let source = format!("scatter of single values between repeats, degrees of freedom: {}", s.freedom);
        all.push((format!("{} (repeats)", of_scatter(s)), format!("{:.3e}{}", s.deviation, space(&s.unit)), source));
    }
    for q in &plan.quantities {
        for e in &q.errors {
            // A field has many points but one source of errors
            let label = if q.records.len() == 1 && e.group == "field" { "points of a field" } else { &q.label };
            let row =
                (format!("{label} ({})", e.group), format!("{}{}", e.deviation, space(&q.unit)), e.source.clone());
            let is_turn = e.group == "registration";
            if !all.contains(&row) && !is_turn {
                all.push(row);
            }
        }
    }
    all
}

/// The errors that tracks give to a quantity, each group of a record once.
fn of_tracks(q: &QuantityPlan) -> Vec<(&QuantityPlan, &str, String, f64, String)> {
    let mut all: Vec<(&QuantityPlan, &str, String, f64, String)> = vec![];
    for (record, e) in q.by_record.iter().flat_map(|(r, errors)| errors.iter().map(move |e| (r.as_str(), e))) {
        match all.iter_mut().find(|(_, r, group, ..)| *r == record && *group == e.group) {
            Some((.., deviation, _)) => *deviation = deviation.hypot(e.deviation),
            None => all.push((q, record, e.group.clone(), e.deviation, e.source.clone())),
        }
    }
    all
}
