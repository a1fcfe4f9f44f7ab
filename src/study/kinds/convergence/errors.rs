//! Errors of the cases against the reference, mesh noise, and differences between time steps.
//!
//! The error of a case is |f − f*|/|f*|. Its error bar is (|f − f*| + U(f*) + error of the time steps + part of the peak that the time grid may
//! miss)/|f*|. If an absolute tolerance is given, the scale of the tolerance replaces |f*|.

use crate::math::statistics::{half_width_of_one, larger, mean, range};
use crate::report::numbers::{percent, seconds};
use crate::study::curve::peak;
use crate::study::estimate::reference::Reference;
use crate::study::estimate::richardson::{CAUTIOUS_FACTOR, ROUNDING};
use crate::study::estimate::step_size::{Timed, first_order, step_sizes};
use crate::study::kinds::convergence::cases::Cases;
use crate::study::store::record::{CaseRecord, FamilyRecord, Role, StoredCase};
use serde::Serialize;

/// Error of one case in one quantity.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct CaseQuantityError {
    pub id: String,
    pub value: f64,
    /// |f − f*|/scale \[–\]
    pub error: f64,
    /// Error plus U(f*) and the error of the time steps, relative to the scale \[–\]
    pub bar: f64,
}

/// Scatter between meshes of one size from different seeds.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Noise {
    pub family: String,
    pub formulation: String,
    pub seeds: usize,
    pub h_m: f64,
    pub mean: f64,
    /// Largest minus smallest value \[unit of f\]
    pub scatter: f64,
    /// Half-width of the 95 % interval of one value, which is part of U(f*) \[unit of f\]
    pub half_width: f64,
}

/// Cause of the differences between runs that differ only in their time steps.
#[derive(Serialize, Clone, Copy, Debug, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum StepCause {
    /// Dynamics, or a path of loading that the steps follow
    TimeStep,
    /// The states are static and path-independent: at one time, Newton's method stops at different distances from the same solution.
    Algebraic,
}

impl StepCause {
    pub fn words(self) -> &'static str {
        match self {
            Self::TimeStep => "time-step error",
            Self::Algebraic => "algebraic error",
        }
    }
}

/// Differences between time steps on one mesh, as an error of the study's step, which is part of every error bar.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct TimeStepError {
    pub family: String,
    pub cause: StepCause,
    /// Time step of each case \[s\], smallest first
    pub dt_s: Vec<f64>,
    pub values: Vec<f64>,
    /// Error of the time step |f(Δt) − f(Δt_min)| + s Δt_min, with s the change per time step towards shorter steps, assuming first order; for an
    /// algebraic cause, max − min of the values, or of the values at the end of the run if that is larger \[unit of f\]
    pub error: f64,
    /// Whether error ≤ U(f*)/10, or the error is rounding
    pub negligible: bool,
}

/// Returns the error of every converged case that was run with the study's time step.
pub fn errors(
    cases: &Cases,
    (variant, quantity): (&str, &str),
    reference: Option<&Reference>,
    step: Option<&TimeStepError>,
) -> Vec<CaseQuantityError> {
    let Some(r) = reference.filter(|r| r.scale > 0.0) else { return vec![] };
    let (scale, more) = (r.scale, r.uncertainty + step.map_or(0.0, |s| s.error));
    (cases.of_variant(variant))
        .filter(|c| cases.at_study_step(variant, &c.record))
        .filter_map(|c| {
            let value = peak(c, quantity)?;
            let off = (value - r.value).abs();
            let bar = (off + more + missed(&c.record, quantity) * value.abs()) / scale;
            Some(CaseQuantityError { id: c.record.id.clone(), value, error: off / scale, bar })
        })
        .collect()
}

/// Share of a peak that the time grid may miss because a prescribed signal has its extremum between two grid points. It is three times the missed
/// share of the signal, because a response may grow faster than its load, and may start to grow in the middle of the range of the load.
fn missed(run: &CaseRecord, quantity: &str) -> f64 {
    CAUTIOUS_FACTOR * run.unseen(quantity)
}

/// Returns the largest share of a peak that the time grid of a case with the study's step may miss \[–\].
pub fn missed_share(cases: &Cases, variant: &str, quantity: &str) -> f64 {
    let own = cases.of_variant(variant).map(|c| &c.record).filter(|r| cases.at_study_step(variant, r));
    own.map(|run| missed(run, quantity)).fold(0.0, larger)
}

/// Returns the scatter over the seeds, for each family of role `seeds` with at least two results.
pub fn noise(cases: &Cases, variant: &str, quantity: &str) -> Vec<Noise> {
    let families = cases.study.families.iter().filter(|f| f.role == Role::Seeds);
    families.filter_map(|family| noise_of(cases, family, variant, quantity)).collect()
}

fn noise_of(cases: &Cases, family: &FamilyRecord, variant: &str, quantity: &str) -> Option<Noise> {
    let members = cases.of(family, variant);
    let values: Vec<f64> = members.iter().filter_map(|c| peak(c, quantity)).collect();
    if values.len() < 2 {
        return None;
    }
    Some(Noise {
        family: family.name.clone(),
        formulation: family.formulation_of(&members).into(),
        seeds: values.len(),
        h_m: mean(&members.iter().map(|c| c.record.mesh.h_m).collect::<Vec<_>>()),
        mean: mean(&values),
        scatter: range(values.iter().copied()),
        half_width: half_width_of_one(&values),
    })
}

/// A motion that the time steps of a case do not resolve.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Unresolved {
    pub case: String,
    /// Share of the range of the quantity that one time step covers \[–\]
    pub share: f64,
    /// Longest time step \[s\]
    pub dt_s: f64,
}

impl Unresolved {
    pub fn words(&self) -> String {
        format!(
            "the time steps do not resolve the motion: it covers {} of its range within one step ({}, Δt = {}), and no difference of such steps bounds its error; shorten the steps",
            percent(self.share),
            self.case,
            seconds(self.dt_s)
        )
    }
}

/// Returns the case with the study's step whose motion is resolved worst, if it changes by more than `allowed` in one of its steps.
pub fn unresolved(cases: &Cases, variant: &str, quantity: &str, allowed: f64) -> Option<Unresolved> {
    let own = cases.of_variant(variant).map(|c| &c.record).filter(|r| r.converged() && cases.at_study_step(variant, r));
    let found = own
        .filter_map(|r| Some(Unresolved { case: r.id.clone(), share: r.unresolved(quantity, allowed)?, dt_s: r.dt_s }));
    found.max_by(|a, b| a.share.total_cmp(&b.share))
}

/// Returns the largest error of the study's step over the families of time steps that the variant runs; `None` if no family shows one.
pub fn step_error(
    cases: &Cases,
    variant: &str,
    quantity: &str,
    reference: Option<&Reference>,
) -> Option<TimeStepError> {
    let families = cases.study.families.iter().filter(|f| f.role == Role::TimeStep);
    let found = families.filter_map(|family| step_error_of(cases, family, (variant, quantity), reference));
    found.max_by(|a, b| a.error.total_cmp(&b.error))
}

/// Compares the study's step with the other steps of a family of time steps, on the same mesh.
fn step_error_of(
    cases: &Cases,
    family: &FamilyRecord,
    (variant, quantity): (&str, &str),
    reference: Option<&Reference>,
) -> Option<TimeStepError> {
    let mut members: Vec<&StoredCase> = cases.of(family, variant);
    let first = &members.first()?.record;
    let is_of_study = |c: &&StoredCase| cases.at_study_step(variant, &c.record);
    // The same mesh with the study's step may be stored under another family
    if !members.iter().any(is_of_study) {
        let is_same = |c: &&StoredCase| c.record.formulation == first.formulation && c.record.has_mesh_of(first);
        members.extend(cases.of_variant(variant).filter(is_same).find(is_of_study));
    }
    let records: Vec<&CaseRecord> = members.iter().map(|c| &c.record).collect();
    let sizes = step_sizes(&records);
    let mut runs: Vec<Timed> =
        (members.iter().zip(sizes)).filter_map(|(c, dt)| Some((dt, peak(c, quantity)?, is_of_study(c)))).collect();
    runs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let at = runs.iter().position(|run| run.2)?;
    let by_order = first_order(&runs, at)?;
    let (dt_s, values): (Vec<f64>, Vec<f64>) = runs.iter().map(|run| (run.0, run.1)).unzip();
    let (cause, error) = if records.iter().any(|r| r.depends_on_steps()) {
        (StepCause::TimeStep, by_order)
    } else {
        let last = records.iter().filter_map(|r| Some(r.probes.get(quantity)?.last)).collect::<Vec<_>>();
        (StepCause::Algebraic, larger(range(values.iter().copied()), range(last.iter().copied())))
    };
    let negligible = reference.is_some_and(|r| error <= 0.1 * r.uncertainty) || error <= ROUNDING * runs[at].1.abs();
    Some(TimeStepError { family: family.name.clone(), cause, dt_s, values, error, negligible })
}
