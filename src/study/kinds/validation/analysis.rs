//! Analysis of a validation: the calibration, the predictions with their budgets, and their score.

use crate::math::statistics::mean;
use crate::report::numbers::{capital, space};
use crate::study::analysis::{self, Analysis};
use crate::study::kinds::validation::budget::{COVERAGE, Contribution, Groups, contributions, half_width};
use crate::study::kinds::validation::consistency::Consistency;
use crate::study::kinds::validation::findings::{
    FittedDatum, FoundConstant, FoundScatter, Prediction, ValidationFindings,
};
use crate::study::kinds::validation::joint::{JointError, Problem, Response, Solution};
use crate::study::kinds::validation::monte_carlo::{Draws, draws};
use crate::study::kinds::validation::numerical::{Meshes, Numerical};
use crate::study::kinds::validation::plan::{QuantityPlan, RecordPlan, UnknownPlan, ValidationPlan};
use crate::study::kinds::validation::responses::{Target, shared_errors, shares, targets};
use crate::study::kinds::validation::scatter::{Repeats, Scatter};
use crate::study::kinds::validation::spec::Purpose;
use crate::study::kinds::validation::words::{named, of_scatter, verdict, warn_of_fit, warn_of_scatter};
use crate::study::store::results::Results;

/// Seed of the simulated experiments.
const SEED: u64 = 19;
/// Largest relative difference of the deviations by derivatives and by simulated experiments.
const CURVED: f64 = 0.1;

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
    let shared = shared_errors(plan);
    let sources = plan.inputs.len() + shared.len();
    let calibration: Vec<&Target> = targets.iter().filter(|t| t.record.purpose == Purpose::Calibration).collect();
    let data: Vec<&Response> = calibration.iter().map(|t| &t.response).collect();
    let values: Vec<f64> = calibration.iter().map(|t| mean(t.measured)).collect();
    let problem = Problem { constants: plan.unknowns.len(), sources, data };
    let solution = problem.solve(&values).map_err(|e| named(&e.to_string(), plan))?;
    let consistency = Consistency::of(&problem, &solution);
    let widened = consistency.birge();
    warn_of_fit(&solution, &consistency, plan, warnings);
    let predicted: Vec<&Target> = targets.iter().filter(|t| t.record.purpose == Purpose::Prediction).collect();
    let responses: Vec<&Response> = predicted.iter().map(|t| &t.response).collect();
    let simulated = draws(&problem, &solution, &responses, SEED);
    if simulated.is_none() {
        warnings.push(
            "More than 5 % of the simulated experiments gave no constants: the intervals rest on derivatives alone."
                .into(),
        );
    }
    let inputs = plan.inputs.iter().map(|i| i.group.clone());
    let source_groups: Vec<String> = inputs.chain(shared.iter().map(|(_, group)| group.clone())).collect();
    let data_groups: Vec<Vec<(String, f64)>> = calibration.iter().map(|t| shares(t)).collect();
    let meshes = Meshes::new(results, plan);
    let predictions = predicted.iter().enumerate().map(|(k, t)| {
        let (value, influence) = solution.predict(&problem, &t.response);
        let again = |shift: &dyn Fn(&RecordPlan, &QuantityPlan) -> Option<f64>| {
            predict_moved(&targets, &problem, &values, t, shift).map_err(|e| named(&e.to_string(), plan))
        };
        let numerical = meshes.of((t.record, t.quantity), &t.response.surface, value, &again);
        let groups = Groups { sources: &source_groups, data: &data_groups, own: &t.groups };
        let budget = contributions(&influence, &groups, widened, &numerical.deviations());
        let simulated = simulated.as_ref().map(|all| &all[k]);
        prediction(t, value + numerical.correction, budget, (influence.deviation(), simulated, widened), numerical)
    });
    let predictions: Vec<Prediction> = predictions.collect();
    let curved: Vec<String> =
        predictions.iter().filter(|p| p.curved).map(|p| format!("{} of {}", p.label, p.record_label)).collect();
    if !curved.is_empty() {
        warnings.push(format!(
            "The response is curved within its uncertainties: for {} derivatives and simulated experiments differ by more than {:.0} %, and the intervals are those of the experiments.",
            curved.join(", "),
            100.0 * CURVED
        ));
    }
    warnings.extend(
        predictions
            .iter()
            .flat_map(|p| p.doubts.iter().map(|d| format!("{} of {}: {d}.", capital(&p.label), p.record_label))),
    );
    Ok(ValidationFindings {
        constants: constants(plan, &solution, widened),
        fitted: calibration
            .iter()
            .zip(&values)
            .zip(&solution.residuals)
            .map(|((t, measured), r)| fitted(t, *measured, *r, &solution))
            .collect(),
        widened,
        chi2: solution.chi2,
        freedom: solution.freedom,
        predictions,
        reference: plan.reference.clone(),
        sources: sources_of(plan, &scatter),
        scatter,
        tracks: plan.tracks.clone(),
    })
}

/// The prediction with every surface moved as another mesh moves it; `Ok(None)` where a record has no run there.
fn predict_moved(
    targets: &[Target],
    problem: &Problem,
    values: &[f64],
    target: &Target,
    shift: &dyn Fn(&RecordPlan, &QuantityPlan) -> Option<f64>,
) -> Result<Option<f64>, JointError> {
    let moved = |t: &Target| {
        let surface = t.response.surface.clone().moved(shift(t.record, t.quantity)?);
        Some(Response { surface, ..t.response.clone() })
    };
    let calibration = targets.iter().filter(|t| t.record.purpose == Purpose::Calibration);
    let (Some(data), Some(response)) = (calibration.map(moved).collect::<Option<Vec<Response>>>(), moved(target))
    else {
        return Ok(None);
    };
    let solution = Problem { data: data.iter().collect(), ..problem.clone() }.solve(values)?;
    Ok(Some(response.value(&solution.xi, &solution.s)))
}

fn prediction(
    t: &Target,
    value: f64,
    budget: Vec<Contribution>,
    (deviation, simulated, birge): (f64, Option<&Draws>, f64),
    numerical: Numerical,
) -> Prediction {
    let half = half_width(&budget);
    let by_draws = simulated.map_or(deviation, |d| d.deviation);
    let curved = (by_draws / deviation - 1.0).abs() > CURVED;
    let rest: f64 = numerical.deviations().iter().map(|(_, d)| (COVERAGE * d).powi(2)).sum();
    let interval = match simulated.filter(|_| curved) {
        // Predicted minus true lies between the ends, so that the truth lies on the other side
        Some(d) => {
            [-d.ends[1], -d.ends[0]].map(|end| value + (birge * end).signum() * ((birge * end).powi(2) + rest).sqrt())
        }
        None => [value - half, value + half],
    };
    let measured = (!t.measured.is_empty()).then(|| mean(t.measured));
    // An interval without the error of the mesh is too narrow to be judged
    let judged = measured.filter(|_| numerical.mesh.is_some());
    let score =
        |m: f64| if m > value { (m - value) / (interval[1] - value) } else { (m - value) / (value - interval[0]) };
    Prediction {
        record: t.record.name.clone(),
        record_label: t.record.label.clone(),
        experiment: t.record.experiment.clone(),
        quantity: t.quantity.name.clone(),
        label: t.quantity.label.clone(),
        symbol: t.quantity.symbol.clone(),
        unit: t.quantity.unit.clone(),
        value,
        interval,
        budget,
        deviations: [deviation, by_draws],
        curved,
        measured,
        inside: judged.map(|m| (interval[0]..=interval[1]).contains(&m)),
        score: judged.map(score),
        doubts: numerical.doubts,
    }
}

fn constants(plan: &ValidationPlan, solution: &Solution, widened: f64) -> Vec<FoundConstant> {
    let one = |(k, u): (usize, &UnknownPlan)| {
        let value = u.at(solution.xi[k]);
        let half = COVERAGE * widened * solution.covariance[(k, k)].sqrt() * u.half();
        FoundConstant {
            key: u.key.clone(),
            label: u.label.clone(),
            symbol: u.symbol.clone(),
            unit: u.unit.clone(),
            value,
            interval: [value - half, value + half],
            range: u.range,
        }
    };
    plan.unknowns.iter().enumerate().map(one).collect()
}

fn fitted(t: &Target, measured: f64, residual: f64, solution: &Solution) -> FittedDatum {
    FittedDatum {
        record: t.record.name.clone(),
        quantity: t.quantity.label.clone(),
        unit: t.quantity.unit.clone(),
        measured,
        fitted: t.response.value(&solution.xi, &solution.s),
        residual,
    }
}

/// Scatter of the quantities that have repeats.
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

/// The terms of the budget with what they rest on.
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
            // Points of a field are many, and have one source
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

/// The errors that tracks give a quantity, each group in a record as one.
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
