//! Choice of mesh, element and time step for a tolerance and a time budget, from coarse pilots; with the limits of that choice.
//!
//! The budget is wall time, and everything counts: meshes, factorisations, pilots, and the recommended run.
//!
//! 1. Pilots: every element (`sizes`) on its two coarsest meshes, then first those whose two agree best, as long as they fit into a quarter of the
//!    budget, or into half of it until one element has three.
//! 2. Limits over h: f_h of every quantity with the steps of the scene, as in a convergence study, from the pilots of each element.
//! 3. Fits: error versus h and time versus counted work ([`model`]); error versus time step from runs with other steps on one pilot (`steps`).
//!    Both together give f* (`limit`): no run is compared with a limit that ignores the effect of its time steps.
//! 4. Choice: the fastest setting whose expected error, of mesh and step together, is within the tolerance. Errors are those of the
//!    peaks, the largest over the quantities. Only its mesh is made, to count the work; if that is more than expected, the next one's.
//!
//! The meshes of a grid are grids with its proportions. If the mesh is given, only formulations and steps can be chosen, and the errors are those
//! estimated from each run alone.
//!
//! The uncertainty of f* is not part of the expected error: the plan states it separately, as something that it cannot promise. The error of the run
//! that is made is measured against f*, which is estimated again with the run as a further mesh if its steps are those of the pilots.

mod budget;
mod choose;
mod error;
mod limit;
mod mesh_limits;
pub mod model;
mod pilots;
mod request;
mod settings;
mod sizes;
mod step_law;
mod steps;
mod weigh;
mod words;

pub use error::PlanError;
pub use limit::{Limit, References};
pub use mesh_limits::Contradiction;
pub use request::{PlanWatch, Request};
pub use settings::{Outcome, Pilot, Plan, Setting};
pub use sizes::Meshes;
pub use step_law::StepLaw;
pub use steps::Steps;

use crate::scene::{Scene, nearest_cells};
use crate::study::curve::peak;
use crate::study::store::record::StoredCase;
use budget::Budget;
use choose::Known;
use pilots::{Pilots, Trial};
use sizes::ElementMeshes;
use std::collections::BTreeMap;
use steps::Examined;

/// A plan and everything needed to carry it out.
pub struct Planned {
    pub plan: Plan,
    choices: Vec<ElementMeshes>,
    pilots: Pilots,
}

/// Runs the pilots and weighs the settings, within the budget of wall time. After a signal to stop no further run is made: the plan rests on the
/// complete pilots, or there is no plan.
pub fn plan(request: &Request, watch: &dyn PlanWatch) -> Result<Planned, PlanError> {
    let budget = Budget::new(request.budget_s);
    let spec = pilots::read(request, &[])?.0;
    let (choices, meshes) = sizes::choices(&request.file, &spec)?;
    let mut learnt = learn(request, (choices, meshes), &budget, watch);
    // If coarser and finer versions of a grid do not complete, the grid counts as a given mesh
    if meshes == Meshes::Scaled && !learnt.as_ref().is_ok_and(Learnt::is_enough) && !request.is_stopped() {
        learnt = learn(request, (sizes::given(&spec), Meshes::Given), &budget, watch);
    }
    let learnt = learnt?;
    let enough = learnt.is_enough();
    let Learnt { choices, meshes, scene, quantities, mut pilots } = learnt;
    let limits = match meshes {
        Meshes::Given => mesh_limits::of_given(&pilots, &quantities),
        _ => mesh_limits::of_meshes(&choices, &pilots, &quantities, request.tolerance),
    };
    let examined = Examined::new(&choices, &pilots, &limits, budget.learning_s()).filter(|_| enough);
    let examined = examined.ok_or_else(|| match request.is_stopped() {
        true => PlanError::Stopped,
        false => PlanError::FewPilots {
            spent: budget.spent_s(),
            done: pilots
                .of
                .iter()
                .flatten()
                .map(|c| (c.record.id.clone(), c.record.mesh.cells, c.record.cpu_s))
                .collect(),
            lost: pilots.lost.clone(),
        },
    })?;
    let steps = steps::steps(request, &scene, examined, &quantities, &budget, watch)?;
    let limit = |(q, mesh): (&String, &(f64, f64))| (q.clone(), Limit::new(*mesh, &steps, q));
    let references: References = limits.iter().map(limit).collect();
    let (mut weighed, left_out) = match meshes {
        _ if references.is_empty() => Default::default(),
        Meshes::Given => weigh::given(&choices, &pilots, &references, &steps),
        _ => weigh::settings(&choices, &pilots, &references, &steps, budget.left_s()),
    };
    pilots.lost.extend(left_out);
    let known = Known { choices: &choices, references: &references, steps: &steps, budget: &budget };
    let (chosen, meets) = choose::choose(request, &known, &mut weighed, &mut pilots, watch)?;
    let against = || mesh_limits::contradiction(&choices, &pilots, &limits, request.tolerance);
    let contradicted = if meets { None } else { against() };
    let listed = pilots.of.iter().flatten().map(|c| settings::Pilot {
        name: c.record.id.clone(),
        cells: c.record.mesh.cells,
        cpu_s: c.record.cpu_s,
        peaks: peaks(c, &quantities),
    });
    let mut plan = Plan {
        tolerance: request.tolerance,
        budget_s: request.budget_s,
        meshes,
        references,
        pilots: listed.collect(),
        pilots_cpu_s: pilots.cpu_s + steps.cpu_s,
        planning_s: budget.spent_s(),
        steps,
        chosen: chosen.filter(|_| contradicted.is_none()),
        meets,
        contradicted,
        weighed,
        lost: pilots.lost.clone(),
        quantities,
        promises: vec![],
        stopped: request.is_stopped(),
        outcome: None,
    };
    plan.promises = words::promises(&plan, &pilots);
    Ok(Planned { plan, choices, pilots })
}

/// The pilots of some choices, with the scene and the columns by which they are judged.
struct Learnt {
    choices: Vec<ElementMeshes>,
    meshes: Meshes,
    scene: Scene,
    quantities: Vec<String>,
    pilots: Pilots,
}

impl Learnt {
    /// Whether an element has as many pilots as a plan requires.
    fn is_enough(&self) -> bool {
        let needed = if self.meshes == Meshes::Given { 1 } else { 3 };
        self.pilots.of.iter().any(|own| own.len() >= needed)
    }
}

/// Runs the pilots of these choices.
fn learn(
    request: &Request,
    (mut choices, meshes): (Vec<ElementMeshes>, Meshes),
    budget: &Budget,
    watch: &dyn PlanWatch,
) -> Result<Learnt, PlanError> {
    let (scene, quantities) = coarsest(request, &mut choices, budget, watch)?;
    let pilots = pilots::run_all(request, (&choices, meshes), &quantities, budget, watch)?;
    Ok(Learnt { choices, meshes, scene, quantities, pilots })
}

/// Builds the scene with its own element on the coarsest mesh that can be made, and returns it with the columns to judge. If the mesher needs a larger
/// number of cells, as in thin walls, all choices start there.
fn coarsest(
    request: &Request,
    choices: &mut [ElementMeshes],
    budget: &Budget,
    watch: &dyn PlanWatch,
) -> Result<(Scene, Vec<String>), PlanError> {
    let spec = pilots::read(request, &[])?.0;
    let own = choices.iter().position(|c| c.element == spec.mesh.element).unwrap_or(0);
    let mut sizes = if choices[own].sizes.is_empty() { vec![0] } else { choices[own].sizes.clone() };
    let (mut last, mut k) = (None, 0);
    while let Some(&cells) = sizes.get(k) {
        k += 1;
        let changes: Vec<_> = choices[own].size(cells).into_iter().collect();
        match pilots::build(request, &changes, budget.pilots_s(), watch) {
            Ok(scene) => {
                let quantities = quantities(request, &scene)?;
                return Ok((scene, quantities));
            }
            Err(PlanError::Scene(e)) if nearest_cells(&e).is_some_and(|n| n as u64 > cells) => {
                let least = nearest_cells(&e).unwrap_or_default() as u64;
                choices.iter_mut().filter(|c| !c.sizes.is_empty()).for_each(|c| c.start_at(least));
                (sizes, k) = (choices[own].sizes.clone(), 0);
                last = None;
            }
            // A mesh of another size may be possible; any other error would occur at every size
            Err(e) if budget.pilots_s() > 0.0 && last.is_none() => last = Some(e),
            Err(e) if budget.pilots_s() == 0.0 => {
                let lost = vec![("the coarsest mesh".into(), e.to_string())];
                return Err(PlanError::FewPilots { spent: budget.spent_s(), done: vec![], lost });
            }
            Err(e) => return Err(last.unwrap_or(e)),
        }
    }
    Err(last.expect("there is at least one size"))
}

/// The columns to judge: the requested ones, or else every recorded angle and cable tension.
fn quantities(request: &Request, scene: &Scene) -> Result<Vec<String>, PlanError> {
    let refuse = |fact: String| PlanError::Quantity { file: request.file.clone(), fact };
    scene.check_time().map_err(refuse)?;
    if let Some(signal) = scene.controls.controlled().pop() {
        return Err(refuse(format!(
            "the signal {signal} waits for a controller, and a plan has none; drive it by a signal"
        )));
    }
    let recorded = scene.columns();
    let usual = recorded.iter().filter(|c| c.ends_with("_deg") || c.ends_with("_tension_N")).cloned();
    let all: Vec<String> = if request.quantities.is_empty() { usual.collect() } else { request.quantities.clone() };
    all.iter().try_for_each(|q| scene.check_column(q)).map_err(refuse)?;
    match all.is_empty() {
        true => Err(refuse("it records neither an angle nor a cable tension; name a column with --quantity".into())),
        false => Ok(all),
    }
}

fn peaks(case: &StoredCase, quantities: &[String]) -> BTreeMap<String, f64> {
    quantities.iter().filter_map(|q| Some((q.clone(), peak(case, q)?))).collect()
}

impl Planned {
    /// Makes the chosen run and compares it with the expectation. A signal to stop ends the run, and the plan is kept.
    pub fn carry_out(&mut self, request: &Request, watch: &dyn PlanWatch) -> Result<(), PlanError> {
        let Some(chosen) = self.plan.chosen.clone().filter(|_| !self.plan.stopped) else { return Ok(()) };
        let k = chosen.choice;
        let changes = [self.plan.steps.changes.clone(), self.choices[k].changes(chosen.cells)].concat();
        let name = self.choices[k].words(chosen.cells);
        let made = pilots::build(request, &changes, f64::INFINITY, watch).and_then(|scene| {
            let trial = Trial { name, scene: &scene, limit_s: f64::INFINITY, estimated: &[] };
            pilots::run(request, trial, watch)
        });
        let case = match made {
            Err(PlanError::Stopped) => {
                self.plan.stopped = true;
                return Ok(());
            }
            made => made?.expect("without a limit it comes to an end"),
        };
        self.plan.outcome = Some(self.compare(&chosen, &case));
        Ok(())
    }

    /// Compares the run with what was expected of it.
    fn compare(&self, chosen: &Setting, case: &StoredCase) -> Outcome {
        let (plan, record) = (&self.plan, &case.record);
        let peaks = peaks(case, &plan.quantities);
        let pilots = (self.choices.as_slice(), &self.pilots);
        let judged = (chosen.limited_by.as_str(), plan.tolerance);
        let (limit, further_mesh) =
            plan.references[&chosen.limited_by].for_run(pilots, (chosen.choice, case), &plan.steps, judged);
        let value = peaks.get(&chosen.limited_by).filter(|_| record.converged());
        let error = value.map_or(f64::NAN, |f| limit.error(*f));
        Outcome {
            status: record.status.clone(),
            cpu_s: record.cpu_s,
            wall_s: record.wall_s,
            time_ratio: chosen.cpu_s / record.cpu_s,
            error,
            further_mesh,
            with_steps: limit.of_steps.is_some(),
            uncertainty: limit.uncertainty,
            error_ratio: chosen.error / error,
            peaks,
        }
    }
}
