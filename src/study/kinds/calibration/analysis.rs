//! Result of a calibration: each constant from the finest mesh, with an interval that covers what the data, the mesh and imprecisely known dimensions
//! leave open.
//!
//! Pure: stored cases in, [`CalibrationFindings`] out. A constant θ has the 95 % interval \[θ − d₋, θ + d₊\] due to the errors of the data, the
//! widest of all cases. U is the uncertainty of the finest mesh, from the meshes of its family ([`crate::study::estimate`]), plus the error of its
//! time steps, from families of time steps ([`crate::study::estimate::step_size`]). δ_fi = θ_fi − θ is the change in member i of family f of an
//! imprecisely known dimension, relative to the size on the same mesh. Then:
//!
//! ```text
//! interval  [θ − d₋ − U + Σ_f min(0, min_i δ_fi), θ + d₊ + U + Σ_f max(0, max_i δ_fi)]
//! bias      θ(gauge)/θ − 1          of the reading by a gauge length
//! ```
//!
//! [`super::corners`] combines the worst ends of all dimensions. If the pressures of the finest mesh look locked, or its family diverges, U is no
//! bound and no interval is stated; nor is it if a case of a dimension has no result.

use crate::calibrate::inverse::{Bound, Calibration, FittedConstant};
use crate::math::statistics::larger;
use crate::study::analysis::Analysis;
use crate::study::estimate::family::{Estimate, Level, estimate};
use crate::study::estimate::step_size::error_of_steps;
use crate::study::kinds::calibration::corners::{self, Corners};
use crate::study::kinds::calibration::findings::{
    CalibratedConstant, CalibratedVariant, CalibrationFindings, ConstantInCase,
};
use crate::study::kinds::calibration::words::{
    doubts, left_words, mesh_verdict, unknown_dimensions, verdict, warnings,
};
use crate::study::locking;
use crate::study::store::record::{CaseRecord, FamilyRecord, Role, StoredCase, StudyRecord};
use std::collections::{BTreeMap, BTreeSet};

/// A case with a solution.
struct SolvedSearch<'a> {
    stored: &'a StoredCase,
    found: &'a Calibration,
    family: &'a str,
    role: Role,
}

pub fn analyse(
    study: &StudyRecord,
    stored: &[StoredCase],
    found: &BTreeMap<String, Calibration>,
) -> Analysis<CalibrationFindings> {
    let incomplete = study.incomplete(stored);
    let variants: Vec<CalibratedVariant> =
        study.variants.iter().filter_map(|v| answer(study, stored, &solved(study, stored, found, v), v)).collect();
    let doubts = variants.iter().flat_map(|a| doubts(a, study.tolerance));
    let warnings = doubts.chain(warnings(stored, found, &incomplete)).collect();
    let verdict = verdict(&variants, study.tolerance);
    Analysis { tolerance: study.tolerance, found: CalibrationFindings { variants }, incomplete, warnings, verdict }
}

/// The cases of a variant with a solution, starting with the sizes from coarse to fine.
fn solved<'a>(
    study: &'a StudyRecord,
    stored: &'a [StoredCase],
    found: &'a BTreeMap<String, Calibration>,
    variant: &str,
) -> Vec<SolvedSearch<'a>> {
    let of = |role: Role| {
        let families = study.families.iter().filter(move |f| f.role == role);
        let ids = families.flat_map(|f| f.cases.iter().map(move |id| (f, id)));
        let case = |(f, id): (&'a FamilyRecord, &'a String)| {
            let c = stored.iter().find(|c| c.record.id == *id && c.is_in(&f.name, variant))?;
            c.record.has_constants().then_some((f, c))
        };
        let mut all: Vec<SolvedSearch> = (ids.filter_map(case))
            .filter_map(|(f, c)| {
                Some(SolvedSearch { stored: c, found: found.get(&c.record.id)?, family: &f.name, role })
            })
            .collect();
        all.sort_by_key(|s| s.stored.record.mesh.cells * usize::from(role == Role::Sizes));
        all
    };
    [Role::Sizes, Role::TimeStep, Role::Nuisance].into_iter().flat_map(of).collect()
}

fn answer(
    study: &StudyRecord,
    stored: &[StoredCase],
    cases: &[SolvedSearch],
    variant: &str,
) -> Option<CalibratedVariant> {
    let finest = cases.iter().rfind(|s| s.role == Role::Sizes).or(cases.first())?;
    let locking = locking::alarm(&finest.stored.record);
    let meshes = |k: usize| Meshes::of(cases, finest, k, study.tolerance);
    let without_constants = without_constants(study, stored, cases, variant);
    let constants: Vec<CalibratedConstant> =
        (0..finest.found.constants.len()).map(|k| judge(cases, finest, k, meshes(k), &without_constants)).collect();
    let (found, record) = (finest.found, &finest.stored.record);
    Some(CalibratedVariant {
        variant: variant.into(),
        label: study.label(variant),
        case: record.id.clone(),
        cells: record.mesh.cells,
        lacks_steps: record.depends_on_steps() && constants.iter().any(|c| c.steps.is_none()),
        mesh_verdict: mesh_verdict(&constants, record, locking, study.tolerance),
        constants,
        rms_relative: found.curves.iter().map(|c| c.rms_relative).collect(),
        formulation: record.formulation.clone(),
        locking,
        errors: found.errors.words("responses"),
        without_constants,
        solves: found.solves,
        cost: found.wall_s / found.forward_s,
    })
}

/// The cases of the nuisance families of a variant that have no solution.
fn without_constants(study: &StudyRecord, stored: &[StoredCase], cases: &[SolvedSearch], variant: &str) -> Vec<String> {
    let mut out: Vec<String> = vec![];
    for f in study.families.iter().filter(|f| f.role == Role::Nuisance) {
        // A file of an earlier version does not state its members; the records of the cases do
        let is_recorded =
            |id: &String| stored.iter().find(|c| c.record.id == *id).is_none_or(|c| c.is_in(&f.name, variant));
        let is_own = |k: usize, id: &String| f.members.get(k).map_or_else(|| is_recorded(id), |m| m.variant == variant);
        let is_solved = |id: &String| cases.iter().any(|s| s.family == f.name && s.stored.record.id == *id);
        for (_, id) in f.cases.iter().enumerate().filter(|(k, id)| is_own(*k, id) && !is_solved(id)) {
            if !out.contains(id) {
                out.push(id.clone());
            }
        }
    }
    out
}

/// Evidence about a constant from the meshes of a family.
struct Meshes {
    drift: Option<f64>,
    estimate: Option<Estimate>,
    /// Reason why no error bar is valid
    refused: Option<String>,
}

impl Meshes {
    fn of(cases: &[SolvedSearch], finest: &SolvedSearch, k: usize, tolerance: f64) -> Self {
        let value = |s: &SolvedSearch| s.found.constants[k].value;
        let sizes: Vec<&SolvedSearch> =
            cases.iter().filter(|s| s.role == Role::Sizes && s.family == finest.family).collect();
        let drift = sizes.len().checked_sub(2).map(|i| value(finest) - value(sizes[i]));
        let levels = sizes.iter().map(|s| Level::of(&s.stored.record, "", value(s))).collect();
        let record = &finest.stored.record;
        let estimate = estimate((finest.family, Role::Sizes, &record.formulation), levels, None, tolerance);
        let refused = match (locking::alarm(record), &estimate) {
            (Some(_), _) => Some("the finest mesh raises the locking alarm".to_string()),
            (None, Some(e)) if e.refused => Some(e.reasons.join("; ")),
            _ => None,
        };
        Self { drift, estimate, refused }
    }
}

fn judge(
    cases: &[SolvedSearch],
    finest: &SolvedSearch,
    k: usize,
    meshes: Meshes,
    without_constants: &[String],
) -> CalibratedConstant {
    let own: &FittedConstant = &finest.found.constants[k];
    let sizes: Vec<&SolvedSearch> = cases.iter().filter(|s| s.role == Role::Sizes).collect();
    let are_known = without_constants.is_empty();
    let corners = corners_of(cases, &sizes, own.value, k).filter(|_| are_known);
    // If a case of a dimension has no interval, the data may determine the constant less well at that end
    let widest: Option<[f64; 2]> =
        (cases.iter().filter(|s| s.role == Role::Nuisance).chain([finest])).try_fold([0.0_f64; 2], |[a, b], s| {
            let c = &s.found.constants[k];
            let [low, high] = c.widest()?;
            Some([a.max(c.value - low), b.max(high - c.value)])
        });
    let [down, up] = corners.as_ref().map_or([0.0; 2], |c| c.change);
    let mesh = meshes.estimate.as_ref().map(|e| e.uncertainty_finest);
    let steps = step_error(cases, finest, k);
    let interval = widest.filter(|_| are_known && meshes.refused.is_none()).map(|[below, above]| {
        let numerical = mesh.unwrap_or(0.0) + steps.unwrap_or(0.0);
        [own.value - below - numerical + down, own.value + above + numerical + up]
    });
    let size = own.value.abs();
    let open = match (&meshes.refused, own.bound, widest) {
        (_, Bound::Lower | Bound::Upper, _) => Some("it is held at a bound".into()),
        (_, Bound::Free, None) => Some(format!("the curves do not determine it{}", left_words(finest.found, own))),
        (Some(why), Bound::Free, Some(_)) => Some(why.clone()),
        (None, Bound::Free, Some(_)) => (!are_known).then(|| unknown_dimensions(without_constants)),
    };
    let gauge = finest.found.gauge.as_ref().and_then(|g| g.values[k]);
    // A case of two families is listed once
    let mut listed: Vec<&SolvedSearch> = vec![];
    for s in cases {
        if !listed.iter().any(|o| o.stored.record.id == s.stored.record.id) {
            listed.push(s);
        }
    }
    CalibratedConstant {
        key: own.key.clone(),
        symbol: own.symbol.clone(),
        unit: own.unit.clone(),
        value: own.value,
        interval,
        open,
        rows: own.widest().map(|[a, b]| 0.5 * (b - a) / size),
        rest: widest.filter(|_| are_known).map(|[a, b]| 0.5 * (a + b + up - down) / size),
        drift: meshes.drift.map(|d| d / size),
        mesh: mesh.map(|u| u / size),
        mesh_method: meshes.estimate.map(|e| e.method.to_string()),
        steps: steps.map(|e| e / size),
        mesh_refused: meshes.refused.is_some(),
        nuisance: corners.as_ref().map(|c| c.change.map(|by| own.value + by)),
        corners: corners.and_then(|c| c.note),
        gauge,
        bias: gauge.map(|g| g / own.value - 1.0),
        cases: listed.into_iter().map(|s| one(s, &sizes, k)).collect(),
    }
}

/// The largest error of a constant by the time steps of the finest case, over the families of time steps. The case with the same steps and mesh may
/// belong to another family.
fn step_error(cases: &[SolvedSearch], finest: &SolvedSearch, k: usize) -> Option<f64> {
    let of = |family: &str| {
        let members: Vec<&SolvedSearch> =
            cases.iter().filter(|s| s.role == Role::TimeStep && s.family == family).collect();
        let first = &members.first()?.stored.record;
        let is_same = |s: &&SolvedSearch| {
            let record = &s.stored.record;
            s.role == Role::Sizes && record.formulation == first.formulation && record.has_mesh_of(first)
        };
        let runs = members.iter().copied().chain(cases.iter().filter(is_same));
        let runs: Vec<(&CaseRecord, f64)> = runs.map(|s| (&s.stored.record, s.found.constants[k].value)).collect();
        error_of_steps(&finest.stored.record, &runs)
    };
    let families: BTreeSet<&str> = cases.iter().filter(|s| s.role == Role::TimeStep).map(|s| s.family).collect();
    families.into_iter().filter_map(of).reduce(larger)
}

/// The changes of a constant in the nuisance families, relative to the size on the same mesh; `None` without such a family.
fn corners_of(cases: &[SolvedSearch], sizes: &[&SolvedSearch], value: f64, k: usize) -> Option<Corners> {
    let (mut single, mut runs): (BTreeMap<&str, Vec<f64>>, Vec<f64>) = (BTreeMap::new(), vec![]);
    for s in cases.iter().filter(|s| s.role == Role::Nuisance) {
        let change = base_of(s, sizes).map_or(0.0, |o| s.found.constants[k].value - o.found.constants[k].value);
        if s.family == corners::FAMILY { &mut runs } else { single.entry(s.family).or_default() }.push(change);
    }
    corners::judge(value, &single, &runs)
}

/// The size that a case of a dimension is compared with: of the same formulation, on the same mesh if possible, otherwise with the nearest number of
/// cells.
fn base_of<'s, 'a>(s: &SolvedSearch, sizes: &[&'s SolvedSearch<'a>]) -> Option<&'s SolvedSearch<'a>> {
    let own = &s.stored.record;
    let rank = |o: &&&SolvedSearch| {
        let record = &o.stored.record;
        let is_other = record.formulation != own.formulation;
        (is_other, !record.has_mesh_of(own), record.mesh.cells.abs_diff(own.mesh.cells))
    };
    sizes.iter().min_by_key(rank).copied()
}

fn one(s: &SolvedSearch, sizes: &[&SolvedSearch], k: usize) -> ConstantInCase {
    let c = &s.found.constants[k];
    let base = base_of(s, sizes).filter(|_| s.role == Role::Nuisance);
    ConstantInCase {
        case: s.stored.record.id.clone(),
        family: s.family.into(),
        member: s.stored.record.member.clone(),
        role: s.role,
        cells: s.stored.record.mesh.cells,
        value: c.value,
        interval: c.widest(),
        rms_relative: s.found.curves[0].rms_relative,
        base: base.map(|o| o.stored.record.id.clone()),
    }
}
