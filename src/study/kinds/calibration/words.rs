//! Sentences of a calibration: its verdict, its constants, the assessment of element and mesh, doubts and warnings.

use crate::calibrate::ErrorModel;
use crate::calibrate::inverse::{Calibration, FittedConstant, Stable};
use crate::math::statistics::larger;
use crate::report::names::constant;
use crate::report::numbers::{capital, digits, percent};
use crate::study::analysis::{self, Analysis};
use crate::study::kinds::calibration::findings::{CalibratedConstant, CalibratedVariant, CalibrationFindings};
use crate::study::locking;
use crate::study::store::record::{CaseRecord, StoredCase};
use crate::wording::few;
use std::collections::BTreeMap;

pub fn mesh_verdict(
    constants: &[CalibratedConstant],
    record: &CaseRecord,
    locked: Option<f64>,
    tolerance: f64,
) -> String {
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
    let Some(worst) = constants.iter().filter_map(|c| c.mesh).reduce(larger) else {
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
    let side = if worst <= tolerance { "within" } else { "above" };
    format!("{mesh}: the error of the mesh is up to {}, {side} the tolerance of {}", percent(worst), percent(tolerance))
}

/// The reason why no interval is stated if cases of dimensions have no constants.
pub fn unknown_dimensions(without_constants: &[String]) -> String {
    let have = if without_constants.len() == 1 { "has" } else { "have" };
    format!("what the dimensions change is not known, as {} {have} no constants", few(without_constants))
}

/// Keys of the constants that the search left at their starting values, and of those that it changed only together with others.
fn left_and_moved(found: &Calibration) -> [Vec<&str>; 2] {
    let keys = |is_moved: bool| {
        let own = found.constants.iter().filter(|c| c.left && c.moved() == is_moved);
        own.map(|c| c.key.as_str()).collect()
    };
    [keys(false), keys(true)]
}

/// The words that follow the statement that a constant is not determined, if the search left constants at their starting values or changed them only
/// together with others.
pub fn left_words(found: &Calibration, own: &FittedConstant) -> String {
    let [left, moved] = left_and_moved(found);
    match (&left[..], &moved[..]) {
        ([], []) => String::new(),
        _ if own.left && own.moved() => ", and the search changed it with others only".into(),
        _ if own.left => ", and the search left it at its starting value".into(),
        ([one], _) => format!("; the search left {one} at its starting value"),
        ([], moved) => format!("; the search changed {} with others only", moved.join(", ")),
        (several, _) => format!("; the search left {} at their starting values", several.join(", ")),
    }
}

/// The unit in which a constant is printed: the factor from SI, its name and the number of decimals.
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

/// Writes a constant as `98.9 kPa (95 % interval 97.1 to 100.8 kPa)`.
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
    /// Returns the symbol of a constant, with its law if another constant has the same symbol: `E of silicone`.
    pub fn symbol_of(&self, c: &CalibratedConstant) -> String {
        let is_shared = self.constants.iter().any(|o| o.key != c.key && o.symbol == c.symbol);
        if is_shared { constant(&c.key) } else { c.symbol.clone() }
    }
}

impl CalibratedConstant {
    /// States the contributions to the interval, and the value that a gauge length would have given.
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

/// Whether element or mesh may affect the constants of a solution.
pub fn mesh_is_doubtful(a: &CalibratedVariant, tolerance: f64) -> bool {
    let mesh = |c: &CalibratedConstant| {
        c.mesh_refused || c.mesh.is_none_or(|m| m > tolerance || c.rest.is_some_and(|r| m > r))
    };
    a.locking.is_some() || a.constants.iter().any(mesh)
}

/// Returns reasons to doubt the constants of a variant.
pub fn doubts(a: &CalibratedVariant, tolerance: f64) -> Vec<String> {
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

/// Returns the warnings about the constants of one variant, as written in its law file.
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

pub fn warnings(
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

/// The meaning of a pattern in the residuals: it does not speak against the law if the constants are not the best ones of the law.
fn cause(found: &Calibration) -> String {
    let held: Vec<&str> = found.constants.iter().filter(|c| !c.bound.is_free()).map(|c| c.key.as_str()).collect();
    let [left, moved] = left_and_moved(found);
    if !found.settled() {
        return "the search did not come to its end, so that this says nothing against the law".into();
    }
    if !left.is_empty() {
        return format!(
            "the search left {} at the starting value, and another one may describe the curve, so that this says nothing against the law",
            left.join(", ")
        );
    }
    if !moved.is_empty() {
        return format!(
            "the search changed {} with others only, and other values may describe the curve, so that this says nothing against the law",
            moved.join(", ")
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

pub fn verdict(variants: &[CalibratedVariant], tolerance: f64) -> String {
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
