//! One error bar compared with the truth.
//!
//! ```text
//! bar holds          |truth − value| ≤ bar
//! interval holds     |truth − corrected| ≤ uncertainty
//! ratio              bar / |truth − value|
//! effectivity        (corrected − value) / (truth − value)
//! ```
//!
//! For an estimate from one run, value, corrected value, uncertainty and bar are its own. For an estimate from many runs, value is that of the finest
//! mesh of a family, corrected ± uncertainty is f* ± U(f*), and bar = |value − f*| + U(f*), as in a convergence study.

use crate::math::statistics::half_width_of_one;
use crate::study::curve::peak;
use crate::study::estimate::family::{Estimate, Level, estimate};
use crate::study::kinds::coverage::record::{JudgedFamily, ProblemRecord};
use crate::study::kinds::coverage::truth::{Truth, levels};
use crate::study::store::record::{CaseRecord, Role, StoredCase, StudyRecord};
use serde::Serialize;

/// Largest uncertainty of a truth that counts as known, as a fraction of the bar.
const KNOWN: f64 = 0.1;

/// The source of an error bar.
#[derive(Clone, Copy, Debug, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Estimator {
    OneRun,
    ManyRuns,
}

impl Estimator {
    pub const ALL: [Self; 2] = [Self::OneRun, Self::ManyRuns];

    pub fn words(self) -> &'static str {
        match self {
            Self::OneRun => "one run",
            Self::ManyRuns => "many runs",
        }
    }
}

/// Whether a bar counts.
#[derive(Clone, Copy, Debug, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    Counted,
    /// The truth is not known to within a tenth of the bar
    TruthUncertain,
    /// A study makes no claim with it and refuses it, because the family diverges, locks, or does not resolve the thinnest wall
    Refused,
}

/// One error bar of one quantity.
#[derive(Clone, Debug, Serialize, PartialEq)]
pub struct Mark {
    pub problem: String,
    pub body: String,
    pub smooth: bool,
    /// Whether the boundary of the body is curved
    pub curved: bool,
    /// Whether the problem took no part in the choice of the bounds and rules
    pub fresh: bool,
    pub material: String,
    pub formulation: String,
    pub seed: String,
    pub quantity: String,
    pub estimator: Estimator,
    /// The case, or the finest one of the family
    pub case: String,
    pub cells: usize,
    pub standing: Standing,
    pub value: f64,
    pub truth: f64,
    pub truth_uncertainty: f64,
    pub corrected: f64,
    pub uncertainty: f64,
    pub bar: f64,
    /// Number of meshes behind an estimate from many runs
    pub meshes: usize,
    /// Whether U(f*) from many runs is within the tolerance of the study
    pub defensible: bool,
    /// Whether the case, or the finest one of the family, raises the locking alarm
    pub locks: bool,
}

impl Mark {
    pub fn error(&self) -> f64 {
        (self.truth - self.value).abs()
    }

    pub fn holds(&self) -> bool {
        self.error() <= self.bar
    }

    pub fn interval_holds(&self) -> bool {
        (self.truth - self.corrected).abs() <= self.uncertainty
    }

    /// Whether the truth is known to within a tenth of the uncertainty of the corrected value.
    pub fn interval_known(&self) -> bool {
        self.truth_uncertainty <= KNOWN * self.uncertainty
    }

    pub fn ratio(&self) -> f64 {
        self.bar / self.error()
    }

    pub fn effectivity(&self) -> f64 {
        (self.corrected - self.value) / (self.truth - self.value)
    }

    pub fn counts(&self) -> bool {
        self.standing == Standing::Counted
    }
}

/// Returns all error bars of a problem in one material and quantity.
pub fn marks(study: &StudyRecord, stored: &[StoredCase], problem: &ProblemRecord, truth: &Truth) -> Vec<Mark> {
    let mut seen: Vec<(&str, &CaseRecord)> = vec![];
    let mut out = vec![];
    for judged in &problem.judged {
        let Some(family) = study.families.iter().find(|f| f.name == judged.family) else { continue };
        let formulation = family.formulation.as_str();
        let all = levels(stored, &judged.family, &truth.material, &truth.quantity.name);
        let base = Mark::base(problem, judged, formulation, truth);
        for (_, case) in &all {
            // A mesh without inner nodes is the same for all seeds
            if !seen.iter().any(|(f, known)| *f == formulation && known.has_mesh_of(&case.record)) {
                out.extend(base.of_one_run(case));
            }
            seen.push((formulation, &case.record));
        }
        let noise = noise(stored, problem, formulation, study, truth);
        let meshes = all.iter().map(|(level, _)| level.clone()).collect();
        let found = estimate((&judged.family, Role::Sizes, formulation), meshes, noise, study.tolerance);
        out.extend(found.map(|e| base.of_many_runs(&e, all[0].1)));
    }
    out
}

/// The half-width of the 95 % interval of one value, from the seeds at the second finest size, as a convergence study takes it from a family of
/// seeds.
fn noise(
    stored: &[StoredCase],
    problem: &ProblemRecord,
    formulation: &str,
    study: &StudyRecord,
    truth: &Truth,
) -> Option<f64> {
    let of = |j: &&JudgedFamily| study.families.iter().any(|f| f.name == j.family && f.formulation == formulation);
    let second = |j: &JudgedFamily| -> Option<Level> {
        levels(stored, &j.family, &truth.material, &truth.quantity.name).into_iter().nth(1).map(|(level, _)| level)
    };
    let values: Vec<f64> = problem.judged.iter().filter(of).filter_map(second).map(|level| level.f).collect();
    (values.len() > 1).then(|| half_width_of_one(&values))
}

impl Mark {
    fn base(problem: &ProblemRecord, judged: &JudgedFamily, formulation: &str, truth: &Truth) -> Self {
        Self {
            problem: problem.name.clone(),
            body: problem.body.clone(),
            smooth: problem.smooth,
            curved: problem.curved,
            fresh: problem.fresh,
            material: truth.material.clone(),
            formulation: formulation.into(),
            seed: judged.seed.clone(),
            quantity: truth.quantity.name.clone(),
            estimator: Estimator::OneRun,
            case: String::new(),
            cells: 0,
            standing: Standing::Counted,
            value: 0.0,
            truth: truth.value,
            truth_uncertainty: truth.uncertainty,
            corrected: 0.0,
            uncertainty: 0.0,
            bar: 0.0,
            meshes: 1,
            defensible: true,
            locks: false,
        }
    }

    fn known(mut self) -> Self {
        if self.truth_uncertainty > KNOWN * self.bar {
            self.standing = Standing::TruthUncertain;
        }
        self
    }

    fn of_one_run(&self, case: &StoredCase) -> Option<Self> {
        let r = &case.record;
        let q = r.one_run.as_ref()?.quantities.get(&self.quantity)?;
        // For a quantity that does not start at zero, its change is judged
        let value = peak(case, &self.quantity)?;
        let mark = Self {
            case: r.id.clone(),
            cells: r.mesh.cells,
            value,
            corrected: value + q.correction,
            uncertainty: q.uncertainty,
            bar: q.bar,
            locks: locks(case),
            ..self.clone()
        };
        Some(mark.known())
    }

    fn of_many_runs(&self, e: &Estimate, finest: &StoredCase) -> Self {
        let value = e.values[0];
        let mark = Self {
            estimator: Estimator::ManyRuns,
            case: e.cases[0].clone(),
            cells: finest.record.mesh.cells,
            value,
            corrected: e.extrapolated,
            uncertainty: e.uncertainty,
            bar: (value - e.extrapolated).abs() + e.uncertainty,
            meshes: e.values.len(),
            defensible: e.defensible,
            locks: locks(finest),
            standing: if e.refused { Standing::Refused } else { Standing::Counted },
            ..self.clone()
        };
        if e.refused { mark } else { mark.known() }
    }
}

fn locks(case: &StoredCase) -> bool {
    case.record.locking.is_some_and(|locking| locking.alarm)
}
