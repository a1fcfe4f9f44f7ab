//! The time step of a plan: runs with other steps on one pilot, their error ([`StepLaw`]), and the largest sufficient step.
//!
//! The pilot is the one whose peaks are closest to the limits over h, among those for which a share of the budget allows runs with steps down to an
//! eighth; otherwise the cheapest. It is run with φ = 2 and ½ times the steps of the scene, then with ¼, ⅛, … until the orders are known and the chosen
//! step is among those run, as long as the budget allows it.
//!
//! The largest φ whose error is within a quarter of the tolerance for every quantity is taken: the rest is left to the mesh. In statics without history
//! the state does not depend on the step, and the scene keeps its own.

use crate::scene::Scene;
use crate::study::curve::peak;
use crate::study::plan::budget::Budget;
use crate::study::plan::error::PlanError;
use crate::study::plan::mesh_limits::MeshLimits;
use crate::study::plan::pilots::{Pilots, Trial, build, run};
use crate::study::plan::request::{PlanWatch, Request};
use crate::study::plan::sizes::ElementMeshes;
use crate::study::plan::step_law::StepLaw;
use crate::study::store::record::StoredCase;
use crate::system::ConstraintKind;
use serde::Serialize;
use std::collections::BTreeMap;
use toml::Value;

/// Share of the tolerance that the error of the time step may take.
const SHARE: f64 = 0.25;
/// Largest number of halvings of the step of the scene that is planned.
const HALVINGS: i32 = 6;
/// Cost of the runs with twice the steps of the scene and with a half, a quarter and an eighth of them, relative to one run of the scene.
const DOWN_TO_AN_EIGHTH: f64 = 14.5;
/// Share of the time for learning that they may take on a pilot other than the cheapest.
const FOR_ACCURACY: f64 = 0.25;
/// Share of the remaining time for learning that one further run may take.
const FURTHER: f64 = 0.5;

/// The step of a plan, and what is known about its errors.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Steps {
    /// φ, the factor on the steps of the scene
    pub factor: f64,
    /// Changes of the scene that set these steps
    #[serde(skip)]
    pub changes: Vec<(String, Value)>,
    /// Column → expected error \[–\]
    pub errors: BTreeMap<String, f64>,
    /// Whether the states depend on the steps
    pub matter: bool,
    /// Column → error versus φ, if it was examined
    pub laws: BTreeMap<String, StepLaw>,
    /// Ratio of the CPU time of a step to that of a step of the scene \[–\]
    pub per_step: f64,
    pub cpu_s: f64,
    pub words: String,
}

impl Steps {
    /// The steps of the scene, without any knowledge about them.
    pub fn of_scene(matter: bool, words: &str) -> Self {
        Self {
            factor: 1.0,
            changes: vec![],
            errors: BTreeMap::new(),
            matter,
            laws: BTreeMap::new(),
            per_step: 1.0,
            cpu_s: 0.0,
            words: words.into(),
        }
    }

    /// Expected error of a column due to the step \[–\]; 0 if unknown.
    pub fn error(&self, quantity: &str) -> f64 {
        self.errors.get(quantity).copied().unwrap_or(0.0)
    }
}

/// A pilot whose steps are varied.
#[derive(Clone, Copy)]
pub struct Examined<'a> {
    pub choice: &'a ElementMeshes,
    pub cells: u64,
    pub case: &'a StoredCase,
}

impl<'a> Examined<'a> {
    /// Selects the pilot closest to the limits among those whose runs fit into a share of `left_s`, otherwise the cheapest.
    pub fn new(choices: &'a [ElementMeshes], pilots: &'a Pilots, limits: &MeshLimits, left_s: f64) -> Option<Self> {
        let all =
            || choices.iter().zip(&pilots.of).flat_map(|(choice, own)| own.iter().map(move |case| (choice, case)));
        let distance = |case: &StoredCase| {
            let one = |(q, (limit, _)): (&String, &(f64, f64))| peak(case, q).map_or(1.0, |f| (f / limit - 1.0).abs());
            limits.iter().map(one).fold(0.0, f64::max)
        };
        let affordable = |case: &StoredCase| DOWN_TO_AN_EIGHTH * case.record.wall_s <= FOR_ACCURACY * left_s;
        let nearest = (all().filter(|(_, case)| affordable(case)))
            .min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)).then(a.1.record.cpu_s.total_cmp(&b.1.record.cpu_s)));
        let (choice, case) = nearest.or_else(|| all().min_by(|a, b| a.1.record.cpu_s.total_cmp(&b.1.record.cpu_s)))?;
        let cells = choice.sizes.iter().copied().find(|cells| case.record.id == choice.words(*cells)).unwrap_or(0);
        Some(Self { choice, cells, case })
    }
}

/// Runs of one pilot with other steps.
struct Runs<'a> {
    request: &'a Request<'a>,
    /// The scene with its own steps, on any mesh
    scene: &'a Scene,
    pilot: Examined<'a>,
    budget: &'a Budget,
    watch: &'a dyn PlanWatch,
    /// (φ, run) of the converged runs
    complete: Vec<(f64, StoredCase)>,
    cpu_s: f64,
}

impl Runs<'_> {
    /// Makes a further run; returns false if it did not complete.
    fn add(&mut self, factor: f64) -> Result<bool, PlanError> {
        let Examined { choice, cells, .. } = self.pilot;
        let changes = [scaled(self.scene, factor), choice.changes(cells)].concat();
        let limit_s = self.budget.learning_s();
        let name = format!("{}, step × {factor}", choice.words(cells));
        let case = match build(self.request, &changes, limit_s, self.watch) {
            Ok(scene) => run(self.request, Trial { name, scene: &scene, limit_s, estimated: &[] }, self.watch),
            Err(e) => Err(e),
        };
        let case = match case {
            Err(PlanError::Stopped | PlanError::MeshLate { .. }) => None,
            case => case?,
        };
        let Some(case) = case else { return Ok(false) };
        self.cpu_s += case.record.cpu_s;
        let converged = case.record.converged();
        if converged {
            self.complete.push((factor, case));
        }
        Ok(converged)
    }

    /// The run with the smallest steps.
    fn finest(&self) -> &(f64, StoredCase) {
        self.complete.iter().min_by(|a, b| a.0.total_cmp(&b.0)).expect("that of the scene is one of them")
    }

    /// Error of every quantity versus φ.
    fn laws(&self, quantities: &[String]) -> BTreeMap<String, StepLaw> {
        let formal = self.pilot.case.record.order_in_time();
        let one = |q: &String| {
            let values: Vec<_> = self.complete.iter().filter_map(|(factor, c)| Some((*factor, peak(c, q)?))).collect();
            Some((q.clone(), StepLaw::new(&values, formal, self.request.tolerance)?))
        };
        quantities.iter().filter_map(one).collect()
    }

    /// Ratio of the CPU time of a step in the run closest to φ to that of a step of the scene \[–\].
    fn per_step(&self, factor: f64) -> f64 {
        let per_step = |c: &StoredCase| c.record.cpu_s / c.record.steps.max(1) as f64;
        let away = |r: &(f64, StoredCase)| (r.0 / factor).ln().abs();
        let like = self.complete.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
        like.map_or(1.0, |r| per_step(&r.1) / per_step(self.pilot.case))
    }

    /// Chooses the steps from the results of these runs.
    fn steps(&self, quantities: &[String]) -> Steps {
        let laws = self.laws(quantities);
        let most = if self.complete.iter().any(|r| r.0 == 2.0) { 1 } else { 0 };
        let factor = largest(&laws, most, SHARE * self.request.tolerance);
        let unclear: Vec<&str> = laws.iter().filter(|(_, law)| !law.trusted).map(|(q, _)| q.as_str()).collect();
        let (runs, pilot) = (self.complete.len(), self.pilot.choice.words(self.pilot.cells));
        let mut words = format!("{factor} times the steps of the scene, from {runs} runs on {pilot}");
        if !unclear.is_empty() {
            words += &format!(
                "; they show no order of convergence of {}, for which that of the integrator is assumed",
                unclear.join(", ")
            );
        }
        Steps {
            factor,
            changes: if factor == 1.0 { vec![] } else { scaled(self.scene, factor) },
            errors: laws.iter().map(|(q, law)| (q.clone(), law.error(factor))).collect(),
            matter: true,
            laws,
            per_step: self.per_step(factor),
            cpu_s: self.cpu_s,
            words,
        }
    }
}

/// The largest φ, from 2^most downwards, whose error is within a share for every quantity; otherwise the smallest one considered.
fn largest(laws: &BTreeMap<String, StepLaw>, most: i32, share: f64) -> f64 {
    let enough = |factor: &f64| laws.values().all(|law| law.error(*factor) <= share);
    // Without a law there is no reason for other steps
    let most = if laws.is_empty() { 0 } else { most };
    (-HALVINGS..=most).rev().map(|k| 2f64.powi(k)).find(enough).unwrap_or(2f64.powi(-HALVINGS))
}

/// Determines the steps for a plan from runs on a pilot. A signal to stop ends it with the complete runs.
pub fn steps(
    request: &Request,
    scene: &Scene,
    pilot: Examined,
    quantities: &[String],
    budget: &Budget,
    watch: &dyn PlanWatch,
) -> Result<Steps, PlanError> {
    let remembers = scene.system.effects.iter().any(|e| e.capabilities().history.is_some());
    let linked = scene.system.constraints.iter().any(|c| c.kind() == ConstraintKind::Linked);
    if scene.spans.iter().all(|s| s.integrator.is_static()) && !remembers && !linked {
        let words = "statics without history: the state does not depend on the step, and the scene keeps its own";
        return Ok(Steps::of_scene(false, words));
    }
    // Half the steps and twice as many, about 2.5 runs
    if request.is_stopped() || 2.5 * pilot.case.record.wall_s > budget.learning_s() {
        let words = "not examined, since the budget has no time for it: the scene keeps its own, whose error is not in the expected one";
        return Ok(Steps::of_scene(true, words));
    }
    let complete = vec![(1.0, pilot.case.clone())];
    let mut runs = Runs { request, scene, pilot, budget, watch, complete, cpu_s: 0.0 };
    runs.add(2.0)?;
    let mut more = !request.is_stopped() && runs.add(0.5)?;
    loop {
        let steps = runs.steps(quantities);
        let (finest, last) = runs.finest();
        let known = steps.factor >= *finest && steps.laws.values().all(|law| law.is_settled(SHARE * request.tolerance));
        let next = 0.5 * finest;
        let possible = next >= 2f64.powi(-HALVINGS) && 2.0 * last.record.wall_s <= FURTHER * budget.learning_s();
        if !more || known || !possible || request.is_stopped() {
            return Ok(steps);
        }
        more = runs.add(next)?;
    }
}

/// Multiplies the steps of all stages by a factor.
fn scaled(scene: &Scene, factor: f64) -> Vec<(String, Value)> {
    let one = |(k, s): (usize, &crate::scene::spec::StageSpec)| {
        (format!("stage.{k}.dt"), Value::String(format!("{} s", s.dt.0 * factor)))
    };
    scene.spec.stages.iter().enumerate().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ElementSpec;
    use crate::study::store::record::{CaseRecord, Series};

    fn law(values: &[(f64, f64)]) -> BTreeMap<String, StepLaw> {
        [("q".to_string(), StepLaw::new(values, 2.0, 0.01).expect("a limit"))].into()
    }

    /// A block under its weight with BDF2: the three coarsest steps show order 0.67, with which 1 % would need a 64th of the steps.
    #[test]
    fn the_choice_does_not_trust_the_order_of_steps_that_are_too_coarse() {
        let values = [(2.0, 3.5184), (1.0, 3.9078), (0.5, 4.1527), (0.25, 4.2382), (0.125, 4.2607)];
        assert_eq!(largest(&law(&values[..3]), 1, 0.0025), 0.125);
        assert_eq!(largest(&law(&values), 1, 0.0025), 0.125);
    }

    #[test]
    fn larger_steps_are_chosen_where_they_do() {
        let values = [0.5, 1.0, 2.0].map(|x: f64| (x, 1.0 - 1e-4 * x * x));
        assert_eq!(largest(&law(&values), 1, 0.0025), 2.0);
        assert_eq!(largest(&law(&values), 0, 0.0025), 1.0);
        assert_eq!(largest(&BTreeMap::new(), 1, 0.0025), 1.0);
    }

    #[test]
    fn the_pilot_nearest_the_limit_is_examined_if_the_budget_allows_it() {
        let case = |id: &str, f: f64, seconds: f64| {
            let record = CaseRecord { id: id.into(), wall_s: seconds, cpu_s: seconds, ..CaseRecord::default() };
            StoredCase::new(record, Series { t_s: vec![0.0, 1.0], columns: [("q".to_string(), vec![0.0, f])].into() })
        };
        let choice = |name: &str| ElementMeshes {
            name: name.into(),
            sizes: vec![600, 1320],
            element: ElementSpec::Tet4,
            ..ElementMeshes::default()
        };
        let choices = [choice("tet4"), choice("tet10")];
        let coarse = vec![case("tet4, 600 cells", 0.8, 0.1), case("tet4, 1320 cells", 0.85, 0.2)];
        let fine = vec![case("tet10, 600 cells", 0.98, 1.0), case("tet10, 1320 cells", 0.99, 4.0)];
        let pilots = Pilots { of: vec![coarse, fine], ..Pilots::default() };
        let limits = MeshLimits::from([("q".to_string(), (1.0, 0.01))]);
        let of = |left_s: f64| {
            let found = Examined::new(&choices, &pilots, &limits, left_s).expect("there are pilots");
            (found.case.record.id.as_str(), found.cells)
        };
        assert_eq!(of(1000.0), ("tet10, 1320 cells", 1320));
        assert_eq!(of(100.0), ("tet10, 600 cells", 600));
        assert_eq!(of(1.0), ("tet4, 600 cells", 600));
    }
}
