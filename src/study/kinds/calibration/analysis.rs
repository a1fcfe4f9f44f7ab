//! Result of a calibration: each constant from the finest mesh, with an interval that holds what the data, the mesh and the
//! dimensions that are not known exactly leave open.
//!
//! Pure: stored cases in, [`CalibrationFindings`] out. Of a constant θ, with θᵢ and its 95 % interval \[aᵢ, bᵢ\] (the wider one of covariance and
//! bootstrap) in the finest case and in every nuisance case i:
//!
//! ```text
//! interval  [min aᵢ − |drift|, max bᵢ + |drift|],   drift = θ(finest) − θ(next)
//! bias      θ(gauge)/θ − 1                          of the reading by a gauge length
//! ```
//!
//! Nuisance cases have the coarser mesh: their differences to the nominal one are moved to the finest.

use crate::calibrate::inverse::{Calibration, Found};
use crate::report::numbers::{digits, percent};
use crate::study::analysis::{self, Analysis};
use crate::study::store::record::{Role, StoredCase, StudyRecord};
use serde::Serialize;
use std::collections::BTreeMap;

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
    /// Relative misfit √(Σr²/Σy²) \[–\]
    pub rms_relative: f64,
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
    /// 95 %: data, mesh, nuisance; none where the curve does not determine the constant
    pub interval: Option<[f64; 2]>,
    /// Half-width of the interval of the data alone, relative \[–\]
    pub rows: Option<f64>,
    /// Relative change from the next coarser mesh to the finest \[–\]
    pub drift: Option<f64>,
    /// Values over the nuisance cases, moved to the finest mesh
    pub nuisance: Option<[f64; 2]>,
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
    role: Role,
}

pub fn analyse(
    study: &StudyRecord,
    stored: &[StoredCase],
    found: &BTreeMap<String, Calibration>,
) -> Analysis<CalibrationFindings> {
    let incomplete = study.incomplete(stored);
    let variants: Vec<CalibratedVariant> =
        study.variants.iter().filter_map(|v| answer(study, &solved(study, stored, found, v), v)).collect();
    let doubts = variants.iter().flat_map(|a| doubts(a, study.tolerance));
    let warnings = doubts.chain(warnings(stored, found, &incomplete)).collect();
    let verdict = verdict(&variants, study.tolerance);
    Analysis { tolerance: study.tolerance, found: CalibrationFindings { variants }, incomplete, warnings, verdict }
}

/// Cases of a variant with an answer, the sizes from coarse to fine first.
fn solved<'a>(
    study: &StudyRecord,
    stored: &'a [StoredCase],
    found: &'a BTreeMap<String, Calibration>,
    variant: &str,
) -> Vec<SolvedSearch<'a>> {
    let of = |role: Role| {
        let ids = study.families.iter().filter(move |f| f.role == role).flat_map(|f| &f.cases);
        let cases = ids.filter_map(|id| stored.iter().find(|c| c.record.id == *id && c.record.variant == variant));
        let converged = cases.filter(|c| c.record.converged());
        let mut all: Vec<SolvedSearch> =
            converged.filter_map(|c| Some(SolvedSearch { stored: c, found: found.get(&c.record.id)?, role })).collect();
        all.sort_by_key(|s| s.stored.record.mesh.cells * usize::from(role == Role::Sizes));
        all
    };
    let mut all = of(Role::Sizes);
    all.extend(of(Role::Nuisance));
    all
}

fn answer(study: &StudyRecord, cases: &[SolvedSearch], variant: &str) -> Option<CalibratedVariant> {
    let finest = cases.iter().rfind(|s| s.role == Role::Sizes).or(cases.first())?;
    let constants = (0..finest.found.constants.len()).map(|k| judge(cases, finest, k)).collect();
    let found = finest.found;
    Some(CalibratedVariant {
        variant: variant.into(),
        label: study.label(variant),
        case: finest.stored.record.id.clone(),
        cells: finest.stored.record.mesh.cells,
        constants,
        rms_relative: found.rms_relative,
        solves: found.solves,
        cost: found.wall_s / found.forward_s,
    })
}

fn judge(cases: &[SolvedSearch], finest: &SolvedSearch, k: usize) -> CalibratedConstant {
    let own: &Found = &finest.found.constants[k];
    let sizes: Vec<&SolvedSearch> = cases.iter().filter(|s| s.role == Role::Sizes).collect();
    let before = sizes.len().checked_sub(2).map(|i| sizes[i].found.constants[k].value);
    let drift = before.map(|v| own.value - v);
    // A nuisance case is compared with the size on its own mesh
    let cells = |s: &SolvedSearch| s.stored.record.mesh.cells;
    let spread: Vec<(f64, Option<[f64; 2]>)> = (cases.iter().filter(|s| s.role == Role::Nuisance))
        .map(|s| {
            let near = sizes.iter().min_by_key(|o| cells(o).abs_diff(cells(s)));
            let moved = near.map_or(0.0, |o| own.value - o.found.constants[k].value);
            let c = &s.found.constants[k];
            (c.value + moved, c.widest().map(|[a, b]| [a + moved, b + moved]))
        })
        .collect();
    let ends =
        |v: &mut dyn Iterator<Item = f64>| v.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)]);
    let nuisance = (!spread.is_empty()).then(|| ends(&mut spread.iter().map(|s| s.0)));
    let interval = own.widest().and_then(|of_rows| {
        let others: Option<Vec<[f64; 2]>> = spread.iter().map(|s| s.1).collect();
        let [a, b] = ends(&mut others?.into_iter().chain([of_rows]).flatten());
        let mesh = drift.unwrap_or(0.0).abs();
        Some([a - mesh, b + mesh])
    });
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
        rows: own.widest().map(|[a, b]| 0.5 * (b - a) / own.value.abs()),
        drift: drift.map(|d| d / own.value.abs()),
        nuisance,
        gauge,
        bias: gauge.map(|g| g / own.value - 1.0),
        cases: listed.into_iter().map(|s| one(s, k)).collect(),
    }
}

fn one(s: &SolvedSearch, k: usize) -> ConstantInCase {
    let c = &s.found.constants[k];
    ConstantInCase {
        case: s.stored.record.id.clone(),
        member: s.stored.record.member.clone(),
        role: s.role,
        cells: s.stored.record.mesh.cells,
        value: c.value,
        interval: c.widest(),
        rms_relative: s.found.rms_relative,
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
pub fn with_interval(c: &CalibratedConstant) -> String {
    let (f, unit, n) = scaled(c);
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    match c.interval {
        Some([a, b]) => format!("{:.n$}{unit} (95 % interval {:.n$} to {:.n$}{unit})", f * c.value, f * a, f * b),
        None => format!("{:.n$}{unit} (not determined by the curve)", f * c.value),
    }
}

impl CalibratedConstant {
    /// The contributions to the interval, and the result a gauge length would have given, in words.
    pub fn sentence(&self, label: &str) -> String {
        let mut words = format!("{} from {label}: {}", self.key, with_interval(self));
        if let Some(rows) = self.rows {
            words += &format!("; the scatter of the data alone leaves ±{}", percent(rows));
        }
        if let Some(drift) = self.drift {
            words += &format!(", the finer mesh changes it by {}", percent(drift.abs()));
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

/// Reasons not to take an answer at its word.
fn doubts(a: &CalibratedVariant, tolerance: f64) -> Vec<String> {
    let mut out = vec![];
    for c in &a.constants {
        match c.drift {
            None => out.push(format!("{}: one mesh only, so what the mesh does to it is not known.", c.key)),
            Some(d) if d.abs() > tolerance => out.push(format!(
                "{}: the finer mesh changes it by {}, above the tolerance of {}; refine further.",
                c.key,
                percent(d.abs()),
                percent(tolerance)
            )),
            Some(_) => {}
        }
    }
    out
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
        c.measured.notes.iter().for_each(|n| add(format!("{}: {n}.", c.measured.file)));
        for s in c.stability.iter().filter(|s| s.above.is_some_and(|a| a < c.stretch[2]) && s.mode != "simple_shear") {
            let at = s.above.expect("filtered");
            let (mode, reached) = (s.mode.replace('_', " "), c.stretch[2]);
            add(format!(
                "{id}: laws.{} is not stable in {mode} tension beyond {at:.3}, and the body stretches to {reached:.3}.",
                s.law
            ));
        }
        if c.runs_p.is_some_and(|p| p < 0.025) {
            add(format!(
                "{id}: the residuals have a pattern (runs of sign, p = {:.1e}): the law does not describe the curve within the scatter of its data, and the covariance is too narrow.",
                c.runs_p.unwrap_or_default()
            ));
        }
        if c.failed > 0 {
            add(format!(
                "{id}: {} of {} forward solves did not converge and were stepped back from.",
                c.failed, c.solves
            ));
        }
    }
    analysis::add_notes(&mut out, stored);
    out
}

fn verdict(variants: &[CalibratedVariant], tolerance: f64) -> String {
    let of = |answer: &CalibratedVariant| {
        let constants = answer.constants.iter().map(|c| format!("{} = {}", c.symbol, with_interval(c)));
        format!("{} from {}", constants.collect::<Vec<_>>().join(", "), answer.label)
    };
    if variants.is_empty() {
        return "No verdict: no case found its constants.".into();
    }
    let mut words = variants.iter().map(of).collect::<Vec<_>>().join("; ") + ".";
    let all = || variants.iter().flat_map(|v| &v.constants);
    if all().any(|c| c.interval.is_none()) {
        words += " The curve does not determine every constant.";
    }
    let drift = all().filter_map(|c| c.drift).fold(0.0f64, |m, d| m.max(d.abs()));
    if all().any(|c| c.drift.is_none()) {
        words += " Drift with the mesh is not known: one mesh only.";
    } else if drift > tolerance {
        words += &format!(" The mesh still moves them by up to {}.", percent(drift));
    } else {
        words += &format!(" A finer mesh moves them by at most {}.", percent(drift));
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
