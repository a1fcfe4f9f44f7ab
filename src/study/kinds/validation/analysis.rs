//! Findings of a validation: constants, predictions with their budgets, and the score of those that were measured.

use crate::report::numbers::{capital, digits, space};
use crate::study::analysis::{self, Analysis};
use crate::study::kinds::validation::budget::{COVERAGE, Contribution, Groups, contributions, half_width};
use crate::study::kinds::validation::evaluate::evaluate;
use crate::study::kinds::validation::joint::{Problem, Response, Solution};
use crate::study::kinds::validation::monte_carlo::{Draws, draws};
use crate::study::kinds::validation::numerical::{Meshes, Numerical};
use crate::study::kinds::validation::plan::{ErrorPlan, QuantityPlan, RecordPlan, ValidationPlan};
use crate::study::kinds::validation::spec::Purpose;
use crate::study::kinds::validation::surface::{Sample, Surface};
use crate::study::store::results::Results;
use serde::Serialize;

/// Seed of the simulated experiments.
const SEED: u64 = 19;
/// Predictions that a verdict names.
const SHOWN: usize = 4;
/// Standard deviations by which data may move an input without a warning.
const FAR: f64 = 2.0;
/// Largest relative difference of the deviations by derivatives and by simulated experiments.
const CURVED: f64 = 0.1;

/// Findings of a validation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ValidationFindings {
    pub constants: Vec<FoundConstant>,
    pub fitted: Vec<FittedDatum>,
    /// √(χ²/ν) where that is beyond chance, else 1
    pub widened: f64,
    pub chi2: f64,
    pub freedom: usize,
    pub predictions: Vec<Prediction>,
    /// Terms of the budget with their origin: (term, deviation, source)
    pub sources: Vec<(String, String, String)>,
}

/// A constant that the calibration records give.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FoundConstant {
    pub key: String,
    pub label: String,
    pub symbol: String,
    pub unit: String,
    pub value: f64,
    /// 95 %, from the errors of data and inputs
    pub interval: [f64; 2],
    pub range: [f64; 2],
}

/// A measured value of the calibration.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FittedDatum {
    pub record: String,
    pub quantity: String,
    pub unit: String,
    pub measured: f64,
    pub fitted: f64,
    /// (measured − fitted)/standard deviation of its independent errors
    pub residual: f64,
}

/// A value that is predicted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Prediction {
    pub record: String,
    pub record_label: String,
    pub experiment: String,
    pub quantity: String,
    pub label: String,
    pub symbol: String,
    pub unit: String,
    pub value: f64,
    /// 95 %
    pub interval: [f64; 2],
    /// Largest first
    pub budget: Vec<Contribution>,
    /// Standard deviation by derivatives, and by simulated experiments
    pub deviations: [f64; 2],
    /// The response is so curved that the interval is that of simulated experiments
    pub curved: bool,
    /// Mean of the measured values, where it was measured
    pub measured: Option<f64>,
    /// Whether the interval contains the measured value
    pub inside: Option<bool>,
    /// (measured − predicted) over the half of the interval on that side
    pub score: Option<f64>,
    /// Reasons to doubt the numerical error bars
    pub doubts: Vec<String>,
}

/// A record and a quantity with their response.
struct Target<'a> {
    record: &'a RecordPlan,
    quantity: &'a QuantityPlan,
    response: Response,
    measured: &'a [f64],
    /// Per independent error of the response: its group
    groups: Vec<String>,
}

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
                sources: sources_of(plan),
            }
        }
    };
    let verdict = verdict(&found) + &analysis::without_result(incomplete.len());
    Analysis { tolerance: results.study.tolerance, found, incomplete, warnings, verdict }
}

fn find(results: &Results, plan: &ValidationPlan, warnings: &mut Vec<String>) -> Result<ValidationFindings, String> {
    let targets = targets(results, plan)?;
    let shared = shared_errors(plan);
    let sources = plan.inputs.len() + shared.len();
    let calibration: Vec<&Target> = targets.iter().filter(|t| t.record.purpose == Purpose::Calibration).collect();
    let data: Vec<&Response> = calibration.iter().map(|t| &t.response).collect();
    let values: Vec<f64> = calibration.iter().map(|t| mean(t.measured)).collect();
    let problem = Problem { constants: plan.unknowns.len(), sources, data };
    let solution = problem.solve(&values).map_err(|e| named(&e.to_string(), plan))?;
    warn_of_fit(&solution, plan, warnings);
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
            predict_moved(&targets, &problem, &values, t, shift)
        };
        let numerical = meshes.of((t.record, t.quantity), &t.response.surface, value, &again);
        let groups = Groups { sources: &source_groups, data: &data_groups, own: &t.groups };
        let budget = contributions(&influence, &groups, solution.birge(), &numerical.deviations());
        let simulated = simulated.as_ref().map(|all| &all[k]);
        prediction(
            t,
            value + numerical.correction,
            budget,
            (influence.deviation(), simulated, solution.birge()),
            numerical,
        )
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
        constants: constants(plan, &solution),
        fitted: calibration
            .iter()
            .zip(&values)
            .zip(&solution.residuals)
            .map(|((t, measured), r)| fitted(t, *measured, *r, &solution))
            .collect(),
        widened: solution.birge(),
        chi2: solution.chi2,
        freedom: solution.freedom,
        predictions,
        sources: sources_of(plan),
    })
}

/// Responses of all records and quantities, by the cases of their designs.
fn targets<'a>(results: &Results, plan: &'a ValidationPlan) -> Result<Vec<Target<'a>>, String> {
    let shared = shared_errors(plan);
    let mut all = vec![];
    for record in &plan.records {
        for quantity in &plan.quantities {
            let Some(measured) = quantity.records.get(&record.name) else { continue };
            let samples = samples(results, plan, record, quantity);
            let surface = Surface::fit(record.unknowns.len(), &samples)
                .map_err(|e| format!("{} of {}: {e}", quantity.label, record.label))?;
            let (mut noise, mut groups) = (vec![], vec![]);
            for e in quantity.errors.iter().filter(|e| e.shared.is_none()) {
                noise.push(e.deviation);
                groups.push(e.group.clone());
            }
            if let Some(scatter) = scatter_of_mean(measured) {
                noise.push(scatter);
                groups.push("repeats".into());
            }
            let amount = |e: &ErrorPlan| {
                let place = shared.iter().position(|(name, _)| e.shared.as_ref() == Some(name))?;
                Some((plan.inputs.len() + place, e.deviation))
            };
            let response = Response {
                surface,
                constants: record.unknowns.clone(),
                inputs: record.inputs.iter().map(|(k, _)| *k).collect(),
                noise,
                shared: quantity.errors.iter().filter_map(amount).collect(),
            };
            all.push(Target { record, quantity, response, measured, groups });
        }
    }
    Ok(all)
}

fn samples(results: &Results, plan: &ValidationPlan, record: &RecordPlan, q: &QuantityPlan) -> Vec<Sample> {
    let keys = record.keys(&plan.unknowns);
    let one = |(case, at): (&String, &Vec<f64>)| {
        let stored = results.cases.iter().find(|c| c.record.id == *case && c.record.variant == record.name)?;
        let derivatives = results.sensitivities.get(case);
        let (value, by) = evaluate(q, &stored.series, derivatives, &keys).filter(|_| stored.record.converged())?;
        let of = |key: &String| keys.iter().position(|k| k == key).map_or(0.0, |k| by[k]);
        let by_constants =
            record.unknowns.iter().map(|k| &plan.unknowns[*k]).map(|u| of(&u.key) * u.half() * u.factor).collect();
        let along = |(_, keys): &(usize, Vec<(String, f64)>)| keys.iter().map(|(key, d)| of(key) * d).sum();
        Some(Sample { at: at.clone(), value, by_constants, by_inputs: record.inputs.iter().map(along).collect() })
    };
    plan.points.iter().filter_map(one).collect()
}

/// Sources that several data share: name and group, each once.
fn shared_errors(plan: &ValidationPlan) -> Vec<(String, String)> {
    let mut all: Vec<(String, String)> = vec![];
    for e in plan.quantities.iter().flat_map(|q| &q.errors) {
        if let Some(name) = e.shared.as_ref().filter(|name| !all.iter().any(|(known, _)| known == *name)) {
            all.push((name.clone(), e.group.clone()));
        }
    }
    all
}

/// Shares of the independent errors of a datum in its variance; they reach a prediction by way of the constants.
fn shares(t: &Target) -> Vec<(String, f64)> {
    let total: f64 = t.response.noise.iter().map(|s| s * s).sum();
    t.groups.iter().map(|g| format!("constants: {g}")).zip(t.response.noise.iter().map(|s| s * s / total)).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Standard deviation of the mean of repeats; `None` of a single value.
fn scatter_of_mean(values: &[f64]) -> Option<f64> {
    let (n, m) = (values.len() as f64, mean(values));
    let variance = values.iter().map(|v| (v - m).powi(2)).sum::<f64>() / (n - 1.0);
    (values.len() > 1 && variance > 0.0).then(|| (variance / n).sqrt())
}

/// The prediction with every surface moved as another mesh moves it; `None` where a record has no run there.
fn predict_moved(
    targets: &[Target],
    problem: &Problem,
    values: &[f64],
    target: &Target,
    shift: &dyn Fn(&RecordPlan, &QuantityPlan) -> Option<f64>,
) -> Option<f64> {
    let moved = |t: &Target| {
        let surface = t.response.surface.clone().moved(shift(t.record, t.quantity)?);
        Some(Response { surface, ..t.response.clone() })
    };
    let data: Vec<Response> =
        targets.iter().filter(|t| t.record.purpose == Purpose::Calibration).map(moved).collect::<Option<_>>()?;
    let problem = Problem { data: data.iter().collect(), ..problem.clone() };
    let solution = problem.solve(values).ok()?;
    Some(moved(target)?.value(&solution.xi, &solution.s))
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
        inside: measured.map(|m| (interval[0]..=interval[1]).contains(&m)),
        score: measured.map(score),
        doubts: numerical.doubts,
    }
}

fn constants(plan: &ValidationPlan, solution: &Solution) -> Vec<FoundConstant> {
    let one = |(k, u): (usize, &crate::study::kinds::validation::plan::UnknownPlan)| {
        let value = u.at(solution.xi[k]);
        let half = COVERAGE * solution.birge() * solution.covariance[(k, k)].sqrt() * u.half();
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

fn warn_of_fit(solution: &Solution, plan: &ValidationPlan, warnings: &mut Vec<String>) {
    for (u, xi) in plan.unknowns.iter().zip(&solution.xi).filter(|(_, xi)| xi.abs() > 1.0) {
        warnings.push(format!(
            "{} ({}) is found at {:.4} {}, outside of its range {} to {}, where its response is extrapolated: widen the range.",
            capital(&u.label), u.key, u.at(*xi), u.unit, u.range[0], u.range[1]
        ));
    }
    for (input, s) in plan.inputs.iter().zip(&solution.s).filter(|(_, s)| s.abs() > FAR) {
        let fact = "its deviation is understated, or it makes up for something that the model misses";
        warnings.push(format!(
            "The records move the input \"{}\" by {s:+.1} of its standard deviations: {fact}.",
            input.name
        ));
    }
    if !solution.is_consistent() {
        warnings.push(format!(
            "The calibration records scatter {:.1} times as much as their errors say (χ² = {:.1} with {} degrees of freedom): the model misses something, or errors are understated. All statistical parts of the intervals are widened by this factor.",
            solution.birge(), solution.chi2, solution.freedom
        ));
    }
}

/// The message with names of constants in place of their indices.
fn named(message: &str, plan: &ValidationPlan) -> String {
    plan.unknowns.iter().enumerate().fold(message.to_string(), |m, (k, u)| {
        m.replace(&format!("constant {k};"), &format!("{} ({});", u.label, u.key))
    })
}

/// The terms of the budget with what they rest on.
fn sources_of(plan: &ValidationPlan) -> Vec<(String, String, String)> {
    let inputs =
        plan.inputs.iter().map(|i| (format!("{} ({})", i.name, i.group), i.deviation.clone(), i.source.clone()));
    let mut all: Vec<(String, String, String)> = inputs.collect();
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

/// `16.97 ± 0.71 mm (95 %: zero 0.68, load 0.12 mm)`, of at most six terms.
pub fn sentence(p: &Prediction) -> String {
    let n = digits(0.1 * (p.interval[1] - p.interval[0]));
    let (up, down) = (p.interval[1] - p.value, p.value - p.interval[0]);
    let half = if (up - down).abs() < 0.05 * (up + down) {
        format!("± {:.n$}", 0.5 * (up + down))
    } else {
        format!("+ {up:.n$} − {down:.n$}")
    };
    let terms: Vec<String> =
        p.budget.iter().take(6).map(|c| format!("{} {:.n$}", c.group, COVERAGE * c.deviation)).collect();
    let mut words = format!(
        "The {} of {} is predicted as {:.n$} {half}{} (95 %: {})",
        p.label,
        p.record_label,
        p.value,
        space(&p.unit),
        terms.join(", ")
    );
    if let (Some(m), Some(inside)) = (p.measured, p.inside) {
        words += &format!(
            "; measured {m:.n$}{}, {} the interval",
            space(&p.unit),
            if inside { "inside" } else { "outside of" }
        );
    }
    (words + ".").replace(" -", " −")
}

fn verdict(found: &ValidationFindings) -> String {
    if found.predictions.is_empty() {
        return "No verdict: there is no prediction.".into();
    }
    let scored: Vec<bool> = found.predictions.iter().filter_map(|p| p.inside).collect();
    let mut words: Vec<String> = vec![];
    if !scored.is_empty() {
        let inside = scored.iter().filter(|i| **i).count();
        words.push(format!("{inside} of {} measured predictions lie in their 95 % intervals.", scored.len()));
    }
    words.extend(found.predictions.iter().take(SHOWN).map(sentence));
    if found.predictions.len() > SHOWN {
        words.push(format!("{} more predictions are in the table.", found.predictions.len() - SHOWN));
    }
    words.join(" ")
}

/// The measurement that would narrow the interval of a prediction most.
pub fn advice(p: &Prediction) -> Option<String> {
    let largest = p.budget.first()?;
    let half = half_width(&p.budget);
    let n = digits(0.1 * half);
    Some(format!(
        "{} of {}: {} counts most; known exactly, it would leave ± {:.n$} of ± {half:.n$}{}.",
        capital(&p.label),
        p.record_label,
        largest.group,
        largest.without,
        space(&p.unit)
    ))
}
