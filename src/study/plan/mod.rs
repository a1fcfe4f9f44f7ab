//! Which mesh, element and time step meet a tolerance within a time: coarse pilots, fits, a choice, and what it cannot promise.
//!
//! The budget is wall time, and everything counts: meshes, factorisations, pilots, and the run that is advised.
//!
//! 1. Pilots: every element (`sizes`) on its coarsest meshes, while they fit into a quarter of the budget.
//! 2. Reference: f* of every quantity as in a convergence study, from the pilots of each element.
//! 3. Fits: error over h and time over counted work ([`model`]); error over the time step from three steps on the coarsest mesh.
//! 4. Choice: the setting of least time whose expected error, of mesh and step together, is within the tolerance. Errors are those of
//!    the peaks, the largest over the quantities. Only its mesh is made, to count the work; if it is more than expected, the next one's.
//!
//! Where the mesh is given, there are formulations and steps to choose from only, and the errors are those estimated from each run alone.
//!
//! The uncertainty of f* is not in the expected error: the plan states it apart, as what it cannot promise. After the run f* is estimated
//! again with the run as a further mesh, and the error of the run against it is compared with the expected one.

mod budget;
mod choose;
mod error;
pub mod model;
mod pilots;
mod request;
mod settings;
mod sizes;
mod steps;
mod weigh;
mod words;

pub use error::PlanError;
pub use request::{PlanWatch, Request};
pub use settings::{Outcome, Pilot, Plan, Setting};
pub use sizes::Meshes;

use crate::scene::Scene;
use crate::study::curve::peak;
use crate::study::estimate::family::{Estimate, Level, estimate};
use crate::study::estimate::reference;
use crate::study::store::record::{Role, StoredCase};
use budget::Budget;
use choose::Known;
use pilots::{Pilots, Trial};
use sizes::Choice;
use std::collections::BTreeMap;
use weigh::References;

/// A plan with what is needed to carry it out.
pub struct Planned {
    pub plan: Plan,
    choices: Vec<Choice>,
    pilots: Pilots,
}

/// Runs the pilots and weighs the settings, within the budget by the clock.
pub fn plan(request: &Request, watch: &dyn PlanWatch) -> Result<Planned, PlanError> {
    let budget = Budget::new(request.budget_s);
    let (choices, meshes) = sizes::choices(&request.file, &pilots::read(request, &[])?.0)?;
    let (scene, quantities) = coarsest(request, &choices, &budget, watch)?;
    let mut pilots = pilots::run_all(request, (&choices, meshes), &quantities, &budget, watch)?;
    let needed = if meshes == Meshes::Given { 1 } else { 3 };
    let (k, first) = (pilots.of.iter().enumerate().filter(|(_, p)| p.len() >= needed))
        .map(|(k, own)| (k, &own[0]))
        .min_by(|a, b| a.1.record.cpu_s.total_cmp(&b.1.record.cpu_s))
        .ok_or_else(|| PlanError::FewPilots { spent: budget.spent_s(), lost: pilots.lost.clone() })?;
    let size = choices[k].sizes.iter().copied().find(|cells| first.record.id == choices[k].words(*cells)).unwrap_or(0);
    let steps = steps::steps(request, &scene, (&choices[k], size, first), &quantities, &budget, watch)?;
    let (references, mut weighed) = match meshes {
        Meshes::Given => weigh::given(&choices, &pilots, &quantities, &steps),
        _ => {
            let references = references(request, &choices, &pilots, &quantities);
            let settings = weigh::settings(&choices, &pilots, &references, &steps, budget.left_s());
            (references, settings)
        }
    };
    let known = Known { choices: &choices, references: &references, steps: &steps, budget: &budget };
    let (chosen, meets) = choose::choose(request, &known, &mut weighed, &mut pilots, watch)?;
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
        chosen,
        meets,
        weighed,
        lost: pilots.lost.clone(),
        quantities,
        promises: vec![],
        outcome: None,
    };
    plan.promises = words::promises(&plan, &pilots);
    Ok(Planned { plan, choices, pilots })
}

/// The scene with the element that it has, on the coarsest mesh that can be made, and the columns to be judged.
fn coarsest(
    request: &Request,
    choices: &[Choice],
    budget: &Budget,
    watch: &dyn PlanWatch,
) -> Result<(Scene, Vec<String>), PlanError> {
    let spec = pilots::read(request, &[])?.0;
    let own = choices.iter().find(|c| c.element == spec.mesh.element).unwrap_or(&choices[0]);
    let sizes = if own.sizes.is_empty() { &[0] } else { own.sizes.as_slice() };
    let mut last = None;
    for &cells in sizes {
        let changes: Vec<_> = own.size(cells).into_iter().collect();
        match pilots::build(request, &changes, budget.pilots_s(), watch) {
            Ok(scene) => {
                let quantities = quantities(request, &scene)?;
                return Ok((scene, quantities));
            }
            // A mesh of another size may be possible; anything else is said by every size
            Err(e) if budget.pilots_s() > 0.0 && last.is_none() => last = Some(e),
            Err(e) if budget.pilots_s() == 0.0 => {
                let lost = vec![("the coarsest mesh".into(), e.to_string())];
                return Err(PlanError::FewPilots { spent: budget.spent_s(), lost });
            }
            Err(e) => return Err(last.unwrap_or(e)),
        }
    }
    Err(last.expect("there is at least one size"))
}

/// f* of every quantity, from the pilots of each element.
fn references(request: &Request, choices: &[Choice], pilots: &Pilots, quantities: &[String]) -> References {
    let one = |q: &String| {
        let r = reference::choose(&estimates(choices, pilots, q, request.tolerance), request.tolerance)?;
        (r.value != 0.0).then(|| (q.clone(), (r.value, r.uncertainty / r.value.abs())))
    };
    quantities.iter().filter_map(one).collect()
}

/// The columns to be judged: those asked for, else every recorded angle and cable tension.
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

/// Estimate of the limit by each element.
fn estimates(choices: &[Choice], pilots: &Pilots, quantity: &str, tolerance: f64) -> Vec<Estimate> {
    let level = |c: &StoredCase| Some(Level { edge: None, ..Level::of(&c.record, peak(c, quantity)?) });
    let one = |(choice, own): (&Choice, &Vec<StoredCase>)| {
        let levels = own.iter().filter_map(level).collect();
        estimate((&choice.name, Role::Element, &choice.name), levels, None, tolerance)
    };
    choices.iter().zip(&pilots.of).filter_map(one).collect()
}

impl Planned {
    /// Makes the run that was chosen and compares it with what was expected.
    pub fn carry_out(&mut self, request: &Request, watch: &dyn PlanWatch) -> Result<(), PlanError> {
        let Some(chosen) = self.plan.chosen.clone() else { return Ok(()) };
        let k = chosen.choice;
        let changes = [self.plan.steps.changes.clone(), self.choices[k].changes(chosen.cells)].concat();
        let scene = pilots::build(request, &changes, f64::INFINITY, watch)?;
        let estimated: &[String] = if self.plan.meshes == Meshes::Given { &self.plan.quantities } else { &[] };
        let name = self.choices[k].words(chosen.cells);
        let trial = Trial { name, scene: &scene, limit_s: f64::INFINITY, estimated };
        let case = pilots::run(request, trial, watch)?.expect("without a limit it comes to an end");
        let record = &case.record;
        let (status, cpu_s, wall_s) = (record.status.clone(), record.cpu_s, record.wall_s);
        let peaks = peaks(&case, &self.plan.quantities);
        let converged = record.converged();
        let mut pilots = self.pilots.clone();
        if converged {
            pilots.of[k].push(case);
        }
        let now = reference::choose(
            &estimates(&self.choices, &pilots, &chosen.limited_by, self.plan.tolerance),
            self.plan.tolerance,
        );
        let value = peaks.get(&chosen.limited_by).copied().filter(|_| converged);
        let (error, uncertainty) = match (now, value) {
            (Some(r), Some(f)) => ((f - r.value).abs() / r.value.abs(), r.uncertainty / r.value.abs()),
            _ => (f64::NAN, f64::NAN),
        };
        self.plan.outcome = Some(Outcome {
            status,
            cpu_s,
            wall_s,
            time_ratio: chosen.cpu_s / cpu_s,
            error,
            uncertainty,
            error_ratio: chosen.error / error,
            peaks,
        });
        Ok(())
    }
}
