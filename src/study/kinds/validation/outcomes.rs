//! Constants and predictions of a calibration with every part of their errors.

use crate::math::statistics::mean;
use crate::report::numbers::capital;
use crate::study::kinds::validation::budget::{COVERAGE, Contribution, Groups, contributions, half_width};
use crate::study::kinds::validation::consistency::Consistency;
use crate::study::kinds::validation::findings::{FittedDatum, FoundConstant, Prediction};
use crate::study::kinds::validation::joint::{Influence, Problem, Response, Solution};
use crate::study::kinds::validation::monte_carlo::{Draws, draws};
use crate::study::kinds::validation::numerical::{Meshes, Numerical, Outcome};
use crate::study::kinds::validation::plan::{UnknownPlan, ValidationPlan};
use crate::study::kinds::validation::responses::{Shift, Target, shared_errors, shares};
use crate::study::kinds::validation::words::{named, not_fitted};
use crate::study::store::results::Results;

/// Seed of the simulated experiments.
const SEED: u64 = 19;
/// Relative difference of the deviations from derivatives and from simulated experiments above which a response counts as curved.
const CURVED: f64 = 0.1;

/// The calibration of a study.
pub struct Calibration<'a> {
    plan: &'a ValidationPlan,
    /// Its data and their measured values
    data: &'a [&'a Target<'a>],
    values: Vec<f64>,
    problem: Problem<'a>,
    pub solution: Solution,
    pub consistency: Consistency,
    /// Factor that widens all statistical parts
    pub widened: f64,
    meshes: Meshes<'a>,
    /// Group of each source in the budget
    sources: Vec<String>,
    /// Independent errors of each datum: (group, share of the variance)
    shares: Vec<Vec<(String, f64)>>,
}

impl<'a> Calibration<'a> {
    /// Calibrates with these data; the error states in words why they give no constants.
    pub fn of(results: &'a Results, plan: &'a ValidationPlan, data: &'a [&'a Target<'a>]) -> Result<Self, String> {
        let shared = shared_errors(plan);
        let inputs = plan.inputs.iter().map(|i| i.group.clone());
        let sources: Vec<String> = inputs.chain(shared.into_iter().map(|(_, group)| group)).collect();
        let responses = data.iter().map(|t| &t.response).collect();
        let problem = Problem { constants: plan.unknowns.len(), sources: sources.len(), data: responses };
        let values: Vec<f64> = data.iter().map(|t| mean(t.measured)).collect();
        let solution = problem.solve(&values).map_err(|e| named(&e.to_string(), plan))?;
        let consistency = Consistency::of(&problem, &solution);
        let (widened, meshes) = (consistency.birge(), Meshes::new(results, plan, data));
        let shares = data.iter().map(|t| shares(t)).collect();
        let found = Self { plan, data, values, problem, solution, consistency, widened, meshes, sources, shares };
        match found.consistency.open(&found.solution) {
            Some(constant) => Err(not_fitted(&plan.unknowns[constant], &found.fitted())),
            None => Ok(found),
        }
    }

    pub fn constants(&self) -> Vec<FoundConstant> {
        self.plan.unknowns.iter().enumerate().map(|(k, u)| self.constant(k, u)).collect()
    }

    fn constant(&self, k: usize, u: &UnknownPlan) -> FoundConstant {
        let influence = self.solution.constant(&self.problem, k, u.half());
        let again = |shift: &Shift| Ok(self.moved(shift)?.map(|found| u.at(found.xi[k])));
        let numerical = self.numerical(u.at(self.solution.xi[k]), None, &influence, &again);
        let groups = Groups { sources: &self.sources, data: &self.shares, own: &[] };
        let budget = contributions(&influence, &groups, self.widened, &numerical.deviations());
        let (value, half) = (u.at(self.solution.xi[k]) + numerical.correction, half_width(&budget));
        FoundConstant {
            key: u.key.clone(),
            label: u.label.clone(),
            symbol: u.symbol.clone(),
            unit: u.unit.clone(),
            value,
            interval: [value - half, value + half],
            range: u.range,
            budget,
            numerical: COVERAGE * numerical.variance().sqrt(),
            doubts: numerical.doubts,
        }
    }

    /// Returns the predictions; adds warnings of curved responses and of doubts.
    pub fn predictions(&self, targets: &[&Target], warnings: &mut Vec<String>) -> Vec<Prediction> {
        let responses: Vec<&Response> = targets.iter().map(|t| &t.response).collect();
        let simulated = draws(&self.problem, &self.solution, &responses, SEED);
        if simulated.is_none() {
            warnings.push(
                "More than 5 % of the simulated experiments gave no constants: the intervals rest on derivatives alone."
                    .into(),
            );
        }
        let one = |(k, t): (usize, &&Target)| self.prediction(t, simulated.as_ref().map(|all| &all[k]));
        let predictions: Vec<Prediction> = targets.iter().enumerate().map(one).collect();
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
        predictions
    }

    fn prediction(&self, t: &Target, simulated: Option<&Draws>) -> Prediction {
        let (value, influence) = self.solution.predict(&self.problem, &t.response);
        let again = |shift: &Shift| {
            let Some(response) = t.moved(shift) else { return Ok(None) };
            Ok(self.moved(shift)?.map(|found| response.value(&found.xi, &found.s)))
        };
        let mut numerical = self.numerical(value, Some(t), &influence, &again);
        let lacks = self.lacks(t, &mut numerical);
        // Errors of the data reach a prediction through the constants
        let through =
            |all: &Vec<(String, f64)>| all.iter().map(|(g, share)| (format!("constants: {g}"), *share)).collect();
        let data: Vec<Vec<(String, f64)>> = self.shares.iter().map(through).collect();
        let groups = Groups { sources: &self.sources, data: &data, own: &t.groups };
        let budget = contributions(&influence, &groups, self.widened, &numerical.deviations());
        let deviation = influence.deviation();
        let by_draws = simulated.map_or(deviation, |d| d.deviation);
        let curved = (by_draws / deviation - 1.0).abs() > CURVED;
        let value = value + numerical.correction;
        let interval = self.interval(value, &budget, simulated.filter(|_| curved), &numerical);
        let measured = (!t.measured.is_empty()).then(|| mean(t.measured));
        // An interval that lacks an error is too narrow to be judged
        let judged = measured.filter(|_| lacks.is_empty());
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
            lacks,
            doubts: numerical.doubts,
        }
    }

    /// The errors that the interval of a prediction lacks, in words; adds a doubt about those of law files.
    fn lacks(&self, t: &Target, numerical: &mut Numerical) -> Vec<String> {
        let mut constants: Vec<String> = vec![];
        for name in self.data.iter().flat_map(|data| &data.lacks).chain(&t.lacks) {
            if !constants.contains(name) {
                constants.push(name.clone());
            }
        }
        let of_laws = (!constants.is_empty()).then(|| format!("the uncertainty of {}", constants.join(", ")));
        if let Some(lack) = &of_laws {
            let why = "its law file leaves it open, or derivatives by it are not known";
            numerical.doubts.push(format!(
                "the interval lacks {lack}, and is not judged by the measured value: {why}; state it as an input"
            ));
        }
        let of_mesh = numerical.lacks_mesh.then(|| "the error of the mesh".to_string());
        of_mesh.into_iter().chain(of_laws).collect()
    }

    /// The 95 % interval around a value, with the ends from simulated experiments if these are used.
    fn interval(
        &self,
        value: f64,
        budget: &[Contribution],
        simulated: Option<&Draws>,
        numerical: &Numerical,
    ) -> [f64; 2] {
        let half = half_width(budget);
        let rest = COVERAGE * COVERAGE * numerical.variance();
        match simulated {
            // Predicted minus true lies between the ends, so the true value lies on the opposite side
            Some(d) => [-d.ends[1], -d.ends[0]]
                .map(|end| self.widened * end)
                .map(|end| value + end.signum() * (end * end + rest).sqrt()),
            None => [value - half, value + half],
        }
    }

    /// The numerical errors of a constant, or of the prediction of a target.
    fn numerical(
        &self,
        value: f64,
        own: Option<&Target>,
        influence: &Influence,
        again: &dyn Fn(&Shift) -> Result<Option<f64>, String>,
    ) -> Numerical {
        self.meshes.of(&Outcome { value, own, by_data: influence.by_data(&self.problem), again })
    }

    /// Repeats the calibration with every surface shifted; `Ok(None)` if a record has no run there.
    fn moved(&self, shift: &Shift) -> Result<Option<Solution>, String> {
        let Some(data) = self.data.iter().map(|t| t.moved(shift)).collect::<Option<Vec<Response>>>() else {
            return Ok(None);
        };
        let problem = Problem { data: data.iter().collect(), ..self.problem.clone() };
        problem.solve(&self.values).map(Some).map_err(|e| named(&e.to_string(), self.plan))
    }

    /// Returns the data with their fitted values.
    pub fn fitted(&self) -> Vec<FittedDatum> {
        let one = |((t, measured), residual): ((&&Target, &f64), &f64)| FittedDatum {
            record: t.record.name.clone(),
            quantity: t.quantity.label.clone(),
            unit: t.quantity.unit.clone(),
            measured: *measured,
            fitted: t.response.value(&self.solution.xi, &self.solution.s),
            residual: *residual,
        };
        self.data.iter().zip(&self.values).zip(&self.solution.residuals).map(one).collect()
    }
}
