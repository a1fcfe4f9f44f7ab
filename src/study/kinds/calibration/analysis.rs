//! Result of a calibration: each constant from the finest mesh, with an interval that holds what the data, the mesh and the
//! dimensions that are not known exactly leave open.
//!
//! Pure: stored cases in, [`CalibrationFindings`] out. Of a constant θ with its 95 % interval by the errors of the data \[θ − d₋, θ + d₊\], the widest
//! of all cases, with U the uncertainty of the finest mesh by the meshes of its family ([`crate::study::estimate`]) and the error of its time steps by families of them
//! ([`crate::study::estimate::step_size`]), and with δ_fi = θ_fi − θ the change in
//! member i of the family f of a dimension that is not known exactly, from the size on its own mesh:
//!
//! ```text
//! interval  [θ − d₋ − U + Σ_f min(0, min_i δ_fi), θ + d₊ + U + Σ_f max(0, max_i δ_fi)]
//! bias      θ(gauge)/θ − 1          of the reading by a gauge length
//! ```
//!
//! [`super::corners`] takes all dimensions at their worst ends together. Where the pressures of
//! the finest mesh look locked, or its family diverges, U is no bound and no interval is stated; nor where a case of a dimension has no result.

use super::corners::{self, Corners};
use crate::calibrate::ErrorModel;
use crate::calibrate::inverse::{Bound, Calibration, Found, Stable};
use crate::report::names::constant;
use crate::report::numbers::{capital, digits, percent};
use crate::study::analysis::{self, Analysis};
use crate::study::estimate::family::{Estimate, Level, estimate};
use crate::study::estimate::step_size::error_of_steps;
use crate::study::locking;
use crate::study::store::record::{CaseRecord, FamilyRecord, Role, StoredCase, StudyRecord};
use crate::wording::few;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Findings of a calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationFindings {
    pub variants: Vec<CalibratedVariant>,
}

/// Result of one measured curve.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct CalibratedVariant {
    pub variant: String,
    /// The variant in words
    pub label: String,
    /// The case on the finest mesh
    pub case: String,
    pub cells: usize,
    pub constants: Vec<CalibratedConstant>,
    /// Relative misfit √(Σr²/Σy²) of each curve \[–\]
    pub rms_relative: Vec<f64>,
    /// Formulation of the finest mesh
    pub formulation: String,
    /// The verdict on element and mesh in words: whether the constants are those of the material or partly those of the mesh
    #[serde(rename = "element")]
    pub mesh_verdict: String,
    /// Pressure scatter of the finest mesh where it raises the locking alarm \[–\]
    pub locking: Option<f64>,
    /// Errors of the data points, in words
    pub errors: String,
    /// Cases of dimensions not known exactly that have no constants: what these dimensions change is in no interval
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub without_constants: Vec<String>,
    /// The scene depends on the time steps, whose error is in no interval
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub lacks_steps: bool,
    /// Forward solves of the finest case, and its time over the one of a forward solve \[–\]
    pub solves: usize,
    pub cost: f64,
}

/// A constant with all that is known of its error. SI.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct CalibratedConstant {
    pub key: String,
    pub symbol: String,
    pub unit: String,
    pub value: f64,
    /// 95 %: data, mesh, time steps, nuisance
    pub interval: Option<[f64; 2]>,
    /// Reason for which there is none
    pub open: Option<String>,
    /// Half-width of the interval of the data alone, and of data and dimensions together where these are known, relative \[–\]
    pub rows: Option<f64>,
    pub rest: Option<f64>,
    /// Relative change from the next coarser mesh to the finest \[–\]
    pub drift: Option<f64>,
    /// Uncertainty of the finest mesh U over the value \[–\], and how it was estimated; none of one mesh
    pub mesh: Option<f64>,
    pub mesh_method: Option<String>,
    /// Error of the time steps over the value \[–\]; none where no family of them tells it
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps: Option<f64>,
    /// U is no bound: the finest mesh locks, or its family diverges
    pub mesh_refused: bool,
    /// Smallest and largest value over the corners of the nuisance families, on the finest mesh
    pub nuisance: Option<[f64; 2]>,
    /// Where the dimensions do not simply add up, in words
    pub corners: Option<String>,
    /// Reading by a gauge length
    pub gauge: Option<f64>,
    /// Its relative error \[–\]
    pub bias: Option<f64>,
    pub cases: Vec<ConstantInCase>,
}

/// A constant in one case.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct ConstantInCase {
    pub case: String,
    pub family: String,
    pub member: String,
    pub role: Role,
    pub cells: usize,
    pub value: f64,
    pub interval: Option<[f64; 2]>,
    pub rms_relative: f64,
}

/// A case that has an answer.
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

/// Cases of a variant with an answer, the sizes from coarse to fine first.
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

/// Cases of the nuisance families of a variant that are not among those with an answer.
fn without_constants(study: &StudyRecord, stored: &[StoredCase], cases: &[SolvedSearch], variant: &str) -> Vec<String> {
    let mut out: Vec<String> = vec![];
    for f in study.families.iter().filter(|f| f.role == Role::Nuisance) {
        // A file of an earlier version does not say its members; the records of the cases do
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

fn mesh_verdict(constants: &[CalibratedConstant], record: &CaseRecord, locked: Option<f64>, tolerance: f64) -> String {
    let mesh = format!("{} on {} cells", record.formulation, record.mesh.cells);
    if let Some(scatter) = locked {
        return format!(
            "{mesh} locks: its pressures scatter from cell to cell by {scatter:.2} of the deviatoric stress, so that the stiffness of the body is \
             partly the mesh's and the constants are too soft; {}",
            locking::REMEDY
        );
    }
    if let Some(why) = constants.iter().find(|c| c.mesh_refused).and_then(|c| c.open.as_ref()) {
        return format!("{mesh}: {why}");
    }
    let Some(worst) = constants.iter().filter_map(|c| c.mesh).reduce(f64::max) else {
        return format!(
            "{mesh}: one mesh only, whose error is not known and in no interval; add a finer one to the family of role \"sizes\""
        );
    };
    let rest = |c: &CalibratedConstant| c.rest.zip(c.mesh).is_some_and(|(rest, mesh)| mesh > rest);
    if constants.iter().any(rest) {
        return format!(
            "{mesh}: the error of the mesh, up to {}, is larger than all that the data leave open; refine",
            percent(worst)
        );
    }
    let side = if worst > tolerance { "above" } else { "within" };
    format!("{mesh}: the error of the mesh is up to {}, {side} the tolerance of {}", percent(worst), percent(tolerance))
}

/// Evidence of the meshes of a family about a constant.
struct Meshes {
    drift: Option<f64>,
    estimate: Option<Estimate>,
    /// Reason for which no error bar holds
    refused: Option<String>,
}

impl Meshes {
    fn of(cases: &[SolvedSearch], finest: &SolvedSearch, k: usize, tolerance: f64) -> Self {
        let value = |s: &SolvedSearch| s.found.constants[k].value;
        let sizes: Vec<&SolvedSearch> =
            cases.iter().filter(|s| s.role == Role::Sizes && s.family == finest.family).collect();
        let drift = sizes.len().checked_sub(2).map(|i| value(finest) - value(sizes[i]));
        let levels = sizes.iter().map(|s| Level::of(&s.stored.record, value(s))).collect();
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
    let own: &Found = &finest.found.constants[k];
    let sizes: Vec<&SolvedSearch> = cases.iter().filter(|s| s.role == Role::Sizes).collect();
    let are_known = without_constants.is_empty();
    let corners = corners_of(cases, &sizes, own.value, k).filter(|_| are_known);
    // Where a case of a dimension has no interval, the data may determine less at that end
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
        cases: listed.into_iter().map(|s| one(s, k)).collect(),
    }
}

/// Largest error of the time steps of the finest case in a constant, by the families of them. A case with its steps on their mesh may be of another family.
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
    families.into_iter().filter_map(of).reduce(f64::max)
}

/// Reason for which no interval is stated where cases of dimensions have no constants.
fn unknown_dimensions(without_constants: &[String]) -> String {
    let have = if without_constants.len() == 1 { "has" } else { "have" };
    format!("what the dimensions change is not known, as {} {have} no constants", few(without_constants))
}

/// The words after the fact that a constant is not determined, where the search left it or others at their starting values.
fn left_words(found: &Calibration, own: &Found) -> String {
    match &found.left()[..] {
        [] => String::new(),
        _ if own.left => ", and the search left it at its starting value".into(),
        [one] => format!("; the search left {one} at its starting value"),
        several => format!("; the search left {} at their starting values", several.join(", ")),
    }
}

/// Changes of a constant by the nuisance families from the size on the same mesh; none without such a family.
fn corners_of(cases: &[SolvedSearch], sizes: &[&SolvedSearch], value: f64, k: usize) -> Option<Corners> {
    let cells = |s: &SolvedSearch| s.stored.record.mesh.cells;
    let (mut single, mut runs): (BTreeMap<&str, Vec<f64>>, Vec<f64>) = (BTreeMap::new(), vec![]);
    for s in cases.iter().filter(|s| s.role == Role::Nuisance) {
        let near = sizes.iter().min_by_key(|o| cells(o).abs_diff(cells(s)));
        let change = near.map_or(0.0, |o| s.found.constants[k].value - o.found.constants[k].value);
        if s.family == corners::FAMILY { &mut runs } else { single.entry(s.family).or_default() }.push(change);
    }
    corners::judge(value, &single, &runs)
}

fn one(s: &SolvedSearch, k: usize) -> ConstantInCase {
    let c = &s.found.constants[k];
    ConstantInCase {
        case: s.stored.record.id.clone(),
        family: s.family.into(),
        member: s.stored.record.member.clone(),
        role: s.role,
        cells: s.stored.record.mesh.cells,
        value: c.value,
        interval: c.widest(),
        rms_relative: s.found.curves[0].rms_relative,
    }
}

/// A constant in its printed unit: value or end of an interval.
pub fn scaled(c: &CalibratedConstant) -> (f64, &str, usize) {
    let (factor, unit) = match (c.unit.as_str(), c.value.abs()) {
        ("Pa", s) if s >= 2e6 => (1e-6, "MPa"),
        ("Pa", s) if s >= 2e3 => (1e-3, "kPa"),
        ("Pa", _) => (1.0, "Pa"),
        _ => (1.0, ""),
    };
    let half = c.interval.map_or(0.0, |[a, b]| 0.5 * (b - a));
    (factor, unit, digits(factor * half.max(1e-3 * c.value.abs())))
}

/// `98.9 kPa (95 % interval 97.1 to 100.8 kPa)`
fn with_interval(c: &CalibratedConstant) -> String {
    let (f, unit, n) = scaled(c);
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    match c.interval {
        Some([a, b]) => format!("{:.n$}{unit} (95 % interval {:.n$} to {:.n$}{unit})", f * c.value, f * a, f * b),
        None => {
            let why = c.open.as_deref().unwrap_or("no reason is known");
            format!("{:.n$}{unit} (no interval: {why})", f * c.value)
        }
    }
}

impl CalibratedVariant {
    /// The symbol of a constant, with its law where another constant has the same symbol: `E of silicone`.
    pub fn symbol_of(&self, c: &CalibratedConstant) -> String {
        let is_shared = self.constants.iter().any(|o| o.key != c.key && o.symbol == c.symbol);
        if is_shared { constant(&c.key) } else { c.symbol.clone() }
    }
}

impl CalibratedConstant {
    /// The contributions to the interval, and the result a gauge length would have given, in words.
    pub fn sentence(&self, label: &str) -> String {
        let mut words = format!("{} from {label}: {}", self.key, with_interval(self));
        if let Some(rows) = self.rows {
            words += &format!("; the scatter of the data alone leaves ±{}", percent(rows));
        }
        if let (Some(drift), Some(mesh)) = (self.drift, self.mesh) {
            words += &format!(
                ", the finer mesh changes it by {} and leaves ±{} ({})",
                percent(drift.abs()),
                percent(mesh),
                self.mesh_method.as_deref().unwrap_or_default()
            );
        }
        if let Some(steps) = self.steps {
            words += &format!(", the time steps leave ±{}", percent(steps));
        }
        let (f, unit, n) = scaled(self);
        if let Some([a, b]) = self.nuisance {
            words += &format!(", the dimensions not known exactly give {:.n$} to {:.n$} {unit}", f * a, f * b);
        }
        if let (Some(gauge), Some(bias)) = (self.gauge, self.bias) {
            let side = if bias < 0.0 { "less" } else { "more" };
            words += &format!(
                ". Read by its gauge length the same test gives {:.n$} {unit}, {} {side}",
                f * gauge,
                percent(bias.abs())
            );
        }
        words + "."
    }
}

/// Whether element or mesh may decide the constants of an answer.
pub fn mesh_is_doubtful(a: &CalibratedVariant, tolerance: f64) -> bool {
    let mesh = |c: &CalibratedConstant| {
        c.mesh_refused || c.mesh.is_none_or(|m| m > tolerance || c.rest.is_some_and(|r| m > r))
    };
    a.locking.is_some() || a.constants.iter().any(mesh)
}

/// Reasons not to take an answer at its word.
fn doubts(a: &CalibratedVariant, tolerance: f64) -> Vec<String> {
    let mesh = mesh_is_doubtful(a, tolerance).then(|| format!("{}: {}.", a.label, a.mesh_verdict));
    let steps = a.lacks_steps.then(|| {
        format!(
            "{}: the curves depend on the time steps, whose error is in no interval; add a family of role \"time_step\" with two steps on one mesh, one of them that of the answer.",
            a.label
        )
    });
    let errors = (a.errors != ErrorModel::Independent.to_string()).then(|| format!("{}: {}.", a.label, a.errors));
    let may_be_zero = |c: &CalibratedConstant| {
        c.interval.filter(|[low, high]| *low < 0.0 && 0.0 < *high)?;
        Some(format!("{}, {}: its interval contains zero; it is hardly determined.", a.label, c.key))
    };
    let corner = |c: &CalibratedConstant| c.corners.as_ref().map(|note| format!("{}, {}: {note}.", a.label, c.key));
    let of_constants = a.constants.iter().filter_map(may_be_zero).chain(a.constants.iter().filter_map(corner));
    mesh.into_iter().chain(steps).chain(errors).chain(of_constants).collect()
}

/// Warnings of the answer of one variant, as its law file has them.
pub fn warnings_of(
    a: &Analysis<CalibrationFindings>,
    v: &CalibratedVariant,
    case: &StoredCase,
    found: &Calibration,
) -> Vec<String> {
    let incomplete: Vec<_> = a.incomplete.iter().filter(|(id, _)| *id == v.case).cloned().collect();
    let found = BTreeMap::from([(v.case.clone(), found.clone())]);
    let own = warnings(std::slice::from_ref(case), &found, &incomplete);
    doubts(v, a.tolerance).into_iter().chain(own).collect()
}

fn warnings(
    stored: &[StoredCase],
    found: &BTreeMap<String, Calibration>,
    incomplete: &[(String, String)],
) -> Vec<String> {
    let mut out = analysis::warnings(incomplete);
    let mut add = |text: String| {
        if !out.contains(&text) {
            out.push(text);
        }
    };
    for (id, c) in found.iter().filter(|(id, _)| stored.iter().any(|s| s.record.id == **id)) {
        c.unidentified.iter().for_each(|d| add(format!("{id}: {d}.")));
        let left_out = c.gauge.iter().filter_map(|g| g.left_out.as_ref());
        left_out.for_each(|why| add(format!("There is no reading by the gauge length: {why}.")));
        for curve in &c.curves {
            curve.measured.notes.iter().for_each(|n| add(format!("{}: {n}.", curve.measured.file)));
            let unstable = |s: &&Stable| s.above.is_some_and(|a| a < curve.stretch[2]) && s.mode != "simple_shear";
            for s in curve.stability.iter().filter(unstable) {
                let at = s.above.expect("filtered");
                let (mode, reached) = (s.mode.replace('_', " "), curve.stretch[2]);
                add(format!(
                    "{id}, {}: laws.{} is not stable in {mode} tension beyond {at:.3}, and the body stretches to {reached:.3}.",
                    curve.name, s.law
                ));
            }
            if let Some(p) = curve.runs_p.filter(|p| *p < 0.025) {
                add(format!(
                    "{id}, {}: the residuals have a pattern that the correlation of neighbours does not explain (runs of sign, p = {p:.1e}): {}.",
                    curve.name,
                    cause(c)
                ));
            }
        }
        if c.failed > 0 {
            add(format!(
                "{id}: {} of {} forward solves did not converge, or had constants that the scene cannot have, and were stepped back from.",
                c.failed, c.solves
            ));
        }
    }
    analysis::add_notes(&mut out, stored);
    out
}

/// The meaning of a pattern in the residuals: nothing against the law where the constants are not the best ones of the law.
fn cause(found: &Calibration) -> String {
    let held: Vec<&str> = found.constants.iter().filter(|c| !c.bound.is_free()).map(|c| c.key.as_str()).collect();
    let left = found.left();
    if !found.settled() {
        return "the search did not come to its end, so that this says nothing against the law".into();
    }
    if !left.is_empty() {
        return format!(
            "the search left {} at the starting value, and another one may describe the curve, so that this says nothing against the law",
            left.join(", ")
        );
    }
    if !held.is_empty() {
        return format!(
            "{} is held at a bound, and a value beyond may describe the curve, so that this says nothing against the law",
            held.join(", ")
        );
    }
    "the law does not describe the curve within the scatter of its data, and the constants depend on its range".into()
}

fn verdict(variants: &[CalibratedVariant], tolerance: f64) -> String {
    let of = |answer: &CalibratedVariant| {
        let constants = answer.constants.iter().map(|c| format!("{} = {}", answer.symbol_of(c), with_interval(c)));
        format!("{} from {}", constants.collect::<Vec<_>>().join(", "), answer.label)
    };
    if variants.is_empty() {
        return "No verdict: no case found its constants.".into();
    }
    let mut words = variants.iter().map(of).collect::<Vec<_>>().join("; ") + ".";
    let all = || variants.iter().flat_map(|v| &v.constants);
    if all().any(|c| c.interval.is_none()) {
        words += " Not every constant has an interval.";
    }
    match variants {
        [only] => words += &format!(" {}.", capital(&only.mesh_verdict)),
        several => {
            let doubtful = several.iter().filter(|v| mesh_is_doubtful(v, tolerance));
            words += &doubtful.map(|v| format!(" {}: {}.", v.label, v.mesh_verdict)).collect::<String>();
        }
    }
    let bias = all().filter_map(|c| c.bias).max_by(|x, y| x.abs().total_cmp(&y.abs()));
    match bias {
        Some(bias) if all().count() == 1 => {
            let side = if bias < 0.0 { "low" } else { "high" };
            words += &format!(" The reading by a gauge length is {} too {side}.", percent(bias.abs()));
        }
        Some(bias) => words += &format!(" The readings by a gauge length are off by up to {}.", percent(bias.abs())),
        None => {}
    }
    words
}
