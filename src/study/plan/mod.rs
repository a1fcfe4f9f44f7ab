//! Which mesh, element and time step meet a tolerance within a time: coarse pilots, fits, a choice, and what it cannot promise.
//!
//! 1. Pilots: every element (`sizes`) on its coarsest meshes, while they fit into a quarter of the budget.
//! 2. Reference: f* of every quantity as in a convergence study, from the pilots of each element.
//! 3. Fits: error over h and time over counted work ([`model`]); error over the time step from three steps on the coarsest mesh.
//! 4. Choice: the setting of least time whose expected error, of mesh and step together, is within the tolerance. Errors are those of
//!    the peaks, the largest over the quantities.
//!
//! The uncertainty of f* is not in the expected error: the plan states it apart, as what it cannot promise. After the run f* is estimated
//! again with the run as a further mesh, and the error of the run against it is compared with the expected one.

mod error;
pub mod model;
mod pilots;
mod request;
mod settings;
mod sizes;
mod steps;
mod words;

pub use error::PlanError;
pub use request::{PlanWatch, Request};
pub use settings::{Outcome, Pilot, Plan, Setting};
pub use sizes::Meshes;

use crate::study::curve::peak;
use crate::study::estimate::family::{Estimate, Level, estimate};
use crate::study::estimate::reference::choose;
use crate::study::record::{CaseRecord, Role, StoredCase};
use model::{Clock, error_law};
use pilots::Pilots;
use sizes::Choice;
use std::collections::BTreeMap;
use steps::Steps;

/// Share of the budget for the pilots.
const SHARE: f64 = 0.25;

/// A plan with what is needed to carry it out.
pub struct Planned {
    pub plan: Plan,
    choices: Vec<Choice>,
    pilots: Pilots,
}

/// Runs the pilots and weighs the settings.
pub fn plan(request: &Request, watch: &dyn PlanWatch) -> Result<Planned, PlanError> {
    let scene = pilots::build(request, &[], watch)?;
    let quantities = quantities(request, &scene)?;
    let (choices, meshes) = sizes::choices(&request.file, &scene.spec)?;
    let pilots = pilots::run_all(request, &choices, SHARE * request.budget_s, watch)?;
    let few = |spent| PlanError::FewPilots { spent, lost: pilots.lost.clone() };
    let (k, _) = (pilots.of.iter().enumerate().filter(|(_, p)| p.len() > 2))
        .min_by(|a, b| a.1[0].record.cpu_s.total_cmp(&b.1[0].record.cpu_s))
        .ok_or_else(|| few(pilots.cpu_s))?;
    let steps = steps::steps(request, &scene, (&choices[k], &pilots.of[k][0]), &quantities, watch)?;
    let references: BTreeMap<String, (f64, f64)> = (quantities.iter())
        .filter_map(|q| {
            let r = choose(&estimates(&choices, &pilots, q, request.tolerance), request.tolerance)?;
            (r.value != 0.0).then(|| (q.clone(), (r.value, r.uncertainty / r.value.abs())))
        })
        .collect();
    let spent = pilots.cpu_s + steps.cpu_s;
    let mut weighed = weigh(request, &choices, &pilots, &references, &steps, request.budget_s - spent, watch)?;
    weighed.sort_by(|a, b| a.cpu_s.total_cmp(&b.cpu_s));
    let affordable = || weighed.iter().filter(|s| s.cpu_s <= request.budget_s - spent);
    let enough = affordable().find(|s| s.error <= request.tolerance);
    let best = affordable().min_by(|a, b| a.error.total_cmp(&b.error));
    let chosen = enough.or(best).cloned();
    let meets = enough.is_some();
    let listed = choices.iter().zip(&pilots.of).flat_map(|(_, own)| own).map(|c| Pilot {
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
        pilots_cpu_s: spent,
        steps,
        chosen,
        meets,
        weighed,
        lost: pilots.lost.clone(),
        quantities,
        promises: vec![],
        outcome: None,
    };
    plan.promises = words::promises(&plan);
    Ok(Planned { plan, choices, pilots })
}

/// The columns to be judged: those asked for, else every recorded angle and cable tension.
fn quantities(request: &Request, scene: &crate::scene::Scene) -> Result<Vec<String>, PlanError> {
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

/// Error and time of every element and size that the fits reach within `budget_s`.
fn weigh(
    request: &Request,
    choices: &[Choice],
    pilots: &Pilots,
    references: &BTreeMap<String, (f64, f64)>,
    steps: &Steps,
    budget_s: f64,
    watch: &dyn PlanWatch,
) -> Result<Vec<Setting>, PlanError> {
    let mut out = vec![];
    for (choice, own) in choices.iter().zip(&pilots.of) {
        let records: Vec<&CaseRecord> = own.iter().map(|c| &c.record).collect();
        let Some(clock) = Clock::new(&records) else { continue };
        let law = |(q, (value, _)): (&String, &(f64, f64))| {
            let error = |c: &StoredCase| Some((c.record.mesh.h_m, (peak(c, q)? - value).abs() / value.abs()));
            error_law(&own.iter().filter_map(error).collect::<Vec<_>>()).map(|law| (q.clone(), law))
        };
        let laws: Option<Vec<_>> = references.iter().map(law).collect();
        let Some(laws) = laws.filter(|l| !l.is_empty()) else { continue };
        let mut changes = steps.changes.clone();
        for &cells in &choice.sizes {
            changes.truncate(steps.changes.len());
            changes.extend(choice.changes(cells));
            let scene = pilots::build(request, &changes, watch)?;
            let counted = pilots::count(&scene);
            let cpu_s = steps.per_step * clock.predict(&counted);
            let errors = laws.iter().map(|(q, law)| (q, law.at(counted.h_m) + steps.error(q)));
            let (limited_by, error) = errors.max_by(|a, b| a.1.total_cmp(&b.1)).expect("there is a law");
            let uncertainty = references[limited_by].1;
            let set = changes.iter().map(|(key, value)| format!("{key}={value}")).collect();
            let (element, limited_by) = (choice.name.clone(), limited_by.clone());
            out.push(Setting { element, cells, set, counted, error, limited_by, uncertainty, cpu_s });
            // The next size of this element is more expensive still
            if cpu_s > budget_s {
                break;
            }
        }
    }
    Ok(out)
}

impl Planned {
    /// Makes the run that was chosen and compares it with what was expected.
    pub fn carry_out(&mut self, request: &Request, watch: &dyn PlanWatch) -> Result<(), PlanError> {
        let Some(chosen) = self.plan.chosen.clone() else { return Ok(()) };
        let k = self.choices.iter().position(|c| c.name == chosen.element).expect("chosen among them");
        let changes = [self.plan.steps.changes.clone(), self.choices[k].changes(chosen.cells)].concat();
        let scene = pilots::build(request, &changes, watch)?;
        let case = pilots::run(request, &format!("{}, {} cells", chosen.element, chosen.cells), &scene, watch)?;
        let record = &case.record;
        let (status, cpu_s, wall_s) = (record.status.clone(), record.cpu_s, record.wall_s);
        let peaks = peaks(&case, &self.plan.quantities);
        let converged = record.converged();
        let mut pilots = self.pilots.clone();
        if converged {
            pilots.of[k].push(case);
        }
        let now =
            choose(&estimates(&self.choices, &pilots, &chosen.limited_by, self.plan.tolerance), self.plan.tolerance);
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
