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

pub mod model;
mod pilots;
mod sizes;
mod steps;
mod words;

pub use sizes::Meshes;

use crate::scene::{Progress, SceneError};
use crate::study::curve::peak;
use crate::study::estimate::family::{Estimate, Level, estimate};
use crate::study::estimate::reference::choose;
use crate::study::record::{CaseRecord, Role, StoredCase};
use model::{Clock, Counted, error_law};
use pilots::Pilots;
use serde::Serialize;
use sizes::Choice;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use steps::Steps;

/// Share of the budget for the pilots.
const SHARE: f64 = 0.25;

/// Request for a plan.
pub struct Request<'a> {
    pub file: PathBuf,
    pub changes: Vec<(String, toml::Value)>,
    /// Largest error of a peak \[–\]
    pub tolerance: f64,
    /// For pilots and run together \[CPU s\]
    pub budget_s: f64,
    /// Columns; those of a convergence study if empty
    pub quantities: Vec<String>,
    /// Set to stop
    pub stop: &'a AtomicBool,
}

/// Observer of a plan in progress.
pub trait Watch {
    fn line(&self, line: &str);
    fn started(&self, name: &str);
    fn progress(&self, name: &str, progress: Progress);
    fn finished(&self, record: &CaseRecord);
}

/// Why there is no plan.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    #[error(transparent)]
    Scene(Box<SceneError>),
    #[error("{}: its mesh comes in one size, and a plan chooses the size; give a `body` with `cells`, or a CAD or surface file with `cells`", file.display())]
    OneMesh { file: PathBuf },
    #[error("{}: mesh.size is given, and a plan chooses mesh.cells; replace it by `cells`", file.display())]
    EdgeLength { file: PathBuf },
    #[error("{}: fewer than three sizes of its body are stored, and the mesher is not installed; run: durometer doctor --setup", file.display())]
    FewMeshes { file: PathBuf },
    #[error("{0}")]
    Mesh(String),
    #[error("{}: {fact}", file.display())]
    Quantity { file: PathBuf, fact: String },
    #[error("no element came through three pilots within a quarter of the budget ({spent:.0} s spent{}); raise --budget, or take a larger dt", told(.lost))]
    FewPilots { spent: f64, lost: Vec<(String, String)> },
    #[error("stopped")]
    Stopped,
}

fn told(lost: &[(String, String)]) -> String {
    lost.iter().map(|(what, why)| format!("; {what}: {why}")).collect()
}

/// The answer.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Plan {
    pub tolerance: f64,
    pub budget_s: f64,
    pub meshes: Meshes,
    pub quantities: Vec<String>,
    /// Column → f* and U(f*)/|f*| from the pilots
    pub references: BTreeMap<String, (f64, f64)>,
    pub pilots: Vec<Pilot>,
    pub pilots_cpu_s: f64,
    pub steps: Steps,
    /// Every setting that was weighed, by time
    pub weighed: Vec<Setting>,
    pub chosen: Option<Setting>,
    /// The chosen one is expected within tolerance and budget
    pub meets: bool,
    /// Pilots that could not be used: (what, why)
    pub lost: Vec<(String, String)>,
    pub promises: Vec<String>,
    /// How good the prediction was, once the run was made
    pub outcome: Option<Outcome>,
}

#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Pilot {
    pub name: String,
    pub cells: usize,
    pub cpu_s: f64,
    /// Column → peak
    pub peaks: BTreeMap<String, f64>,
}

/// A mesh and element with what is expected of it.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Setting {
    pub element: String,
    /// As to be asked for
    pub cells: u64,
    /// Changes to the scene, `key=value`
    pub set: Vec<String>,
    pub counted: Counted,
    /// Largest over the quantities \[–\]
    pub error: f64,
    pub limited_by: String,
    /// Known only this well \[–\]: U(f*) of that quantity
    pub uncertainty: f64,
    pub cpu_s: f64,
}

/// Expected and found.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Outcome {
    pub status: String,
    pub cpu_s: f64,
    pub wall_s: f64,
    /// Expected over found
    pub time_ratio: f64,
    /// Of the quantity that limits, against f* with the run as a further mesh \[–\]
    pub error: f64,
    /// Known this well \[–\]
    pub uncertainty: f64,
    pub error_ratio: f64,
    /// Column → peak of the run
    pub peaks: BTreeMap<String, f64>,
}

/// A plan with what is needed to carry it out.
pub struct Planned {
    pub plan: Plan,
    choices: Vec<Choice>,
    pilots: Pilots,
}

/// Runs the pilots and weighs the settings.
pub fn plan(request: &Request, watch: &dyn Watch) -> Result<Planned, PlanError> {
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
            let r = choose(&estimates(&choices, &pilots, q, request.tolerance))?;
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
    let level = |c: &StoredCase| Some(Level { id: c.record.id.clone(), h: c.record.mesh.h_m, f: peak(c, quantity)? });
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
    watch: &dyn Watch,
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
    pub fn carry_out(&mut self, request: &Request, watch: &dyn Watch) -> Result<(), PlanError> {
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
        let now = choose(&estimates(&self.choices, &pilots, &chosen.limited_by, self.plan.tolerance));
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
