//! Dependence of a quantity on the swept keys: trend, range, elasticity.
//!
//! Pure: stored cases in, [`SweepFindings`] out. y is the peak of a quantity at a point of the sweep, or its value at the end of the run
//! ([`Judged`]), p the value of a swept key. A quantity that does not start at zero, such as a position, is measured from its first value, so that
//! the position of the body in its frame does not matter.
//!
//! ```text
//! change along an axis      (max y − min y)/scale(max |y|), the others held; the largest over them. Of all points: the same over all of them
//! elasticity                ln(y₂/y₁)/ln(p₂/p₁) between neighbours: exact for y = c pᵉ; where p > 0 and y keeps its sign, on lines that are not constant
//! ```
//!
//! The scale is the value itself, unless an absolute tolerance is larger there ([`Tolerance`]); the text then gives the change and the tolerance in
//! the unit. An elasticity refers to |y|: for a quantity that is negative everywhere, the text also states how its magnitude changes.
//!
//! A trend describes y as p rises, whatever the order of the values. A line rises or falls if two of its points, neighbours or not, differ by more
//! than all of the following: 1e-6 of its largest |y|; the algebraic error, multiplied by the largest change of a recorded column in this unit; and
//! the rounding of the largest |y| of all lines, so that a line of zeros among others is constant. A constant line has a change of zero. A list whose
//! axes vary together is one line along its points: the effects of single keys cannot be separated, and no elasticity is given.

use crate::math::statistics::extent;
use crate::report::numbers::{
    capital, digits, minus_signs, percent, readable, significant, space, span, unsigned_zero,
};
use crate::scene::{ExtremeKind, column};
use crate::study::analysis::{self, Analysis, ByQuantity};
use crate::study::axis::AxisRecord;
use crate::study::curve::{peak, start};
use crate::study::estimate::tolerance::Tolerance;
use crate::study::store::record::{CaseRecord, Role, StoredCase, StudyRecord};
use crate::wording;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Relative difference \[of the largest |y| of the line\] below which values count as equal.
const STEP: f64 = 1e-6;

/// Relative difference \[of the largest |y| of all lines\] below which it counts as rounding.
const ROUNDING: f64 = 1e-12;
/// Largest |ln p₂/p₁| of one number written in two units \[–\]
const SAME: f64 = 1e-12;

/// The value of a run by which a sweep judges a quantity.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema, PartialEq, Eq, Default)]
#[serde(rename_all = "snake_case")]
pub enum Judged {
    /// The value farthest from the first one
    #[default]
    Peak,
    /// The last value
    Final,
}

impl Judged {
    /// Returns this value of a quantity; `None` if it is not recorded or not finite.
    pub fn of(self, case: &StoredCase, quantity: &str) -> Option<f64> {
        match self {
            Self::Peak => peak(case, quantity),
            Self::Final => Some(case.record.probes.get(quantity)?.last).filter(|v| v.is_finite()),
        }
    }

    /// The first value of a quantity, from which this value is measured; 0 if it starts at zero, and for a peak, which is already a change.
    fn origin(self, case: &StoredCase, quantity: &str) -> f64 {
        match self {
            Self::Peak => 0.0,
            Self::Final => start(case, quantity).unwrap_or(0.0),
        }
    }

    /// The table heading of the values.
    pub fn heading(self) -> &'static str {
        match self {
            Self::Peak => "Peaks",
            Self::Final => "Final values",
        }
    }
}

/// Axes of a sweep as they are stored with the study.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct SweepRecord {
    /// The keys that were swept
    pub axes: Vec<AxisRecord>,
    /// Index of its value on every axis, by member
    pub points: BTreeMap<String, Vec<usize>>,
    #[serde(default)]
    pub judged: Judged,
}

/// Findings of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepFindings {
    pub axes: Vec<AxisRecord>,
    /// Index of its value on every axis, by member
    pub points: BTreeMap<String, Vec<usize>>,
    pub judged: Judged,
    /// Whether the axes vary together, so that the points form one line
    pub list: bool,
    /// Findings in every quantity \[variants × quantities\]
    pub quantities: Vec<ByQuantity<Dependence>>,
}

/// Dependence of one quantity on the swept keys.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Dependence {
    pub points: Vec<SweepPoint>,
    /// Largest |y| of all points
    #[serde(skip)]
    size: f64,
    /// Behaviour along each axis \[axes\]; for a list only one entry, along the first axis, for all together
    pub along: Vec<Along>,
}

/// A converged case of the sweep.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct SweepPoint {
    pub case: String,
    pub member: String,
    /// Index of its value on every axis
    pub at: Vec<usize>,
    /// Peak or final value
    pub value: f64,
    /// The value minus the first one, if a final value does not start at zero; trends, shares and elasticities refer to it
    pub change: f64,
    /// Algebraic error of the value, if the record has one \[unit of the quantity\]
    #[serde(skip)]
    pub algebraic: f64,
}

/// Behaviour of a quantity along one axis.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Along {
    pub axis: String,
    pub trend: Trend,
    /// Whether every line has this trend; false if some lines are constant and others are not
    pub everywhere: bool,
    /// Largest (max − min)/scale(max |y|) over the lines along this axis; constant lines count as zero \[–\]
    pub change: f64,
    /// Smallest and largest elasticity between neighbours on lines that are not constant, and that of the middle line from end to end \[–\]
    pub elasticity: Option<[f64; 3]>,
}

/// How a quantity changes as the value of the axis rises; for a list, from its first point to its last.
#[derive(Serialize, Clone, Copy, Debug, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Trend {
    Rising,
    Falling,
    /// No two points of a line differ
    Constant,
    /// Rising and falling on one line
    Turning,
    /// Rising on some lines, falling on others
    Mixed,
    /// It differs between values that have no order: words, or the scattered values of a list
    Unordered,
}

impl Trend {
    /// Returns the name used in `summary.json`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rising => "rising",
            Self::Falling => "falling",
            Self::Constant => "constant",
            Self::Turning => "turning",
            Self::Mixed => "mixed",
            Self::Unordered => "unordered",
        }
    }
}

impl Dependence {
    /// Returns the smallest and the largest value.
    pub fn range(&self) -> [f64; 2] {
        extent(self.points.iter().map(|p| p.value))
    }

    /// Whether no change is positive and at least one is negative, so that a falling value grows in magnitude.
    pub fn is_negative(&self) -> bool {
        self.points.iter().all(|p| p.change <= 0.0) && self.points.iter().any(|p| p.change < 0.0)
    }

    /// Whether values are measured from their first ones.
    pub fn has_origin(&self) -> bool {
        self.points.iter().any(|p| p.change != p.value)
    }

    /// Returns the points that differ in axis `k` only, in its order; for a list all of them.
    pub fn lines(&self, k: usize, list: bool) -> Vec<Vec<&SweepPoint>> {
        let mut lines: Vec<Vec<&SweepPoint>> = vec![];
        for p in &self.points {
            let same = |q: &SweepPoint| list || (0..p.at.len()).all(|i| i == k || q.at[i] == p.at[i]);
            match lines.iter_mut().find(|line| same(line[0])) {
                Some(line) => line.push(p),
                None => lines.push(vec![p]),
            }
        }
        lines.iter_mut().for_each(|line| line.sort_by_key(|p| p.at[k]));
        lines
    }

    /// Difference up to which these points count as equal \[unit of the quantity\].
    fn noise(&self, points: &[&SweepPoint]) -> f64 {
        let algebraic = points.iter().map(|p| p.algebraic).fold(0.0, f64::max);
        (STEP * Spread::of(points.iter().copied()).size).max(algebraic).max(ROUNDING * self.size)
    }

    /// The trend along a line. Small steps add up, because each point is compared with the largest and the smallest one before it.
    fn trend(&self, line: &[&SweepPoint]) -> Trend {
        let noise = self.noise(line);
        let (mut low, mut high, mut rises, mut falls) = (f64::INFINITY, f64::NEG_INFINITY, false, false);
        for y in line.iter().map(|p| p.change) {
            (low, high) = (low.min(y), high.max(y));
            (rises, falls) = (rises || y - low > noise, falls || high - y > noise);
        }
        match (rises, falls) {
            (true, true) => Trend::Turning,
            (true, false) => Trend::Rising,
            (false, true) => Trend::Falling,
            (false, false) => Trend::Constant,
        }
    }

    /// The spread of points; a difference within the noise counts as zero.
    fn spread(&self, points: &[&SweepPoint]) -> Spread {
        let spread = Spread::of(points.iter().copied());
        if spread.difference <= self.noise(points) { Spread { difference: 0.0, ..spread } } else { spread }
    }
}

/// Difference between the largest and the smallest change of some points, and the largest magnitude among them.
#[derive(Clone, Copy)]
struct Spread {
    difference: f64,
    size: f64,
}

impl Spread {
    fn of<'a>(points: impl IntoIterator<Item = &'a SweepPoint>) -> Self {
        let changes = points.into_iter().map(|p| p.change);
        let (low, high) = changes.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        Self { difference: high - low, size: low.abs().max(high.abs()) }
    }

    /// Returns the difference relative to the scale of the tolerance \[–\].
    fn share(&self, tolerance: Tolerance) -> f64 {
        let scale = tolerance.scale(self.size);
        if scale > 0.0 { self.difference / scale } else { 0.0 }
    }

    /// The difference and the tolerance that it is compared with, in words.
    fn words(&self, form: Form, tolerance: Tolerance, unit: &str) -> [String; 2] {
        match form {
            Form::Unit => [significant(self.difference, 3), tolerance.absolute.to_string()].map(|v| v + &space(unit)),
            Form::Share => [self.share(tolerance), tolerance.relative].map(percent),
        }
    }
}

/// How the changes of a quantity are written: all in one form, so that they can be compared.
#[derive(Clone, Copy, PartialEq)]
enum Form {
    /// Relative to the largest magnitude of a line
    Share,
    /// In the unit of the quantity, if the absolute tolerance decides
    Unit,
}

impl Form {
    /// The form for one spread.
    fn of(spread: Spread, tolerance: Tolerance) -> Self {
        if tolerance.is_absolute(spread.size) { Self::Unit } else { Self::Share }
    }

    /// Returns the number that is written.
    fn size(self, spread: Spread, tolerance: Tolerance) -> f64 {
        if self == Self::Unit { spread.difference } else { spread.share(tolerance) }
    }
}

impl ByQuantity<Dependence> {
    /// Returns the spreads along an axis, one for each line with at least two points.
    fn spreads(&self, a: &Along, axes: &[AxisRecord], list: bool) -> Vec<Spread> {
        let lines = self.lines(axes.iter().position(|x| x.name == a.axis).unwrap_or(0), list);
        lines.iter().filter(|line| line.len() > 1).map(|line| self.spread(line)).collect()
    }

    /// The form of all changes: in the unit if the largest relative change along some axis is written so.
    fn form(&self, axes: &[AxisRecord], list: bool, tolerance: Tolerance) -> Form {
        let largest = |a: &Along| {
            let spreads = self.spreads(a, axes, list).into_iter();
            spreads.max_by(|a, b| a.share(tolerance).total_cmp(&b.share(tolerance)))
        };
        let mut forms = self.along.iter().filter_map(largest).map(|spread| Form::of(spread, tolerance));
        if forms.any(|form| form == Form::Unit) { Form::Unit } else { Form::Share }
    }

    /// The largest change along an axis, the form in which it is written, and whether several lines have a change.
    fn largest(&self, a: &Along, axes: &[AxisRecord], list: bool, tolerance: Tolerance) -> (Spread, Form, bool) {
        let (form, spreads) = (self.form(axes, list, tolerance), self.spreads(a, axes, list));
        let largest =
            spreads.iter().copied().max_by(|a, b| form.size(*a, tolerance).total_cmp(&form.size(*b, tolerance)));
        (largest.expect("an axis has a line of two points"), form, spreads.len() > 1)
    }
}

/// Analyses the stored cases; cases that are missing or did not converge are named.
pub fn analyse(study: &StudyRecord, sweep: &SweepRecord, stored: &[StoredCase]) -> Analysis<SweepFindings> {
    let list = sweep.axes.len() > 1 && sweep.points.values().all(|at| at.iter().all(|k| *k == at[0]));
    let mut quantities = ByQuantity::each(study, stored, |variant, quantity| {
        let found = (stored.iter().filter(|c| c.record.converged()))
            .flat_map(|c| members(study, c, variant).into_iter().map(move |member| (c, member)));
        let points: Vec<SweepPoint> = found
            .filter_map(|(c, member)| {
                let value = sweep.judged.of(c, &quantity.name)?;
                Some(SweepPoint {
                    case: c.record.id.clone(),
                    member: member.into(),
                    at: sweep.points.get(member)?.clone(),
                    value,
                    change: value - sweep.judged.origin(c, &quantity.name),
                    algebraic: algebraic(c, &quantity.name),
                })
            })
            .collect();
        let mut found = Dependence { size: Spread::of(&points).size, points, along: vec![] };
        let axes = sweep.axes.iter().enumerate().take(if list { 1 } else { sweep.axes.len() });
        let tolerance = quantity.tolerance(study.tolerance);
        found.along = axes.filter_map(|(k, axis)| along_axis(&found, (k, axis), list, tolerance)).collect();
        Some(found)
    });
    for q in &mut quantities {
        if sweep.judged == Judged::Final {
            q.peak_is = "final";
        }
        q.sentence = sentence_of(q, study.tolerance, &sweep.axes, list);
    }
    let incomplete = study.incomplete(stored);
    let mut warnings = warnings_of(stored, &incomplete);
    if sweep.judged == Judged::Peak {
        warnings.extend(quantities.iter().filter_map(|q| opposite_peaks(q, stored)));
    }
    let verdict = verdict_of(&quantities, study.tolerance, sweep, list, incomplete.len());
    let found = SweepFindings {
        axes: sweep.axes.clone(),
        points: sweep.points.clone(),
        judged: sweep.judged,
        list,
        quantities,
    };
    Analysis { tolerance: study.tolerance, found, incomplete, warnings, verdict }
}

/// Returns the points of a variant whose result is this case.
pub fn members<'a>(study: &StudyRecord, case: &'a StoredCase, variant: &str) -> Vec<&'a str> {
    let families = study.families.iter().filter(|f| f.role == Role::Grid);
    families.flat_map(|f| case.members(&f.name, variant).collect::<Vec<_>>()).collect()
}

/// The behaviour along one axis; `None` if no line has two points.
fn along_axis(q: &Dependence, (k, axis): (usize, &AxisRecord), list: bool, tolerance: Tolerance) -> Option<Along> {
    let mut lines: Vec<Vec<&SweepPoint>> = q.lines(k, list).into_iter().filter(|l| l.len() > 1).collect();
    if !list && axis.numbers.windows(2).any(|w| w[1] < w[0]) {
        lines.iter_mut().for_each(|line| line.reverse());
    }
    let trends: Vec<Trend> = lines.iter().map(|line| q.trend(line)).collect();
    let trend = trends.iter().copied().reduce(|a, b| match (a, b) {
        (a, b) if a == b => a,
        (Trend::Constant, other) | (other, Trend::Constant) => other,
        (Trend::Turning, _) | (_, Trend::Turning) => Trend::Turning,
        _ => Trend::Mixed,
    })?;
    let everywhere = trends.iter().all(|t| *t == trend);
    let trend = if axis.is_ordered() || trend == Trend::Constant { trend } else { Trend::Unordered };
    let exponent = |a: &SweepPoint, b: &SweepPoint| -> Option<f64> {
        let (p, y) = (axis.numbers.get(b.at[k])? / axis.numbers.get(a.at[k])?, b.change / a.change);
        let positive = axis.numbers.iter().all(|p| *p > 0.0) && y > 0.0 && y.is_finite();
        // One number in two units has no elasticity
        (positive && p.ln().abs() > SAME).then(|| y.ln() / p.ln())
    };
    // On a constant line the quotient is only rounding
    let moved = lines.iter().zip(&trends).filter(|(_, t)| **t != Trend::Constant);
    let moved: Vec<&Vec<&SweepPoint>> = moved.map(|(line, _)| line).collect();
    let between: Option<Vec<f64>> = moved.iter().flat_map(|l| l.windows(2).map(|w| exponent(w[0], w[1]))).collect();
    let ends = moved.get(moved.len() / 2).and_then(|middle| exponent(middle[0], middle[middle.len() - 1]));
    let elasticity = between.zip(ends).filter(|_| !list).map(|(all, ends)| {
        let [least, most] = extent(all.into_iter());
        [least, most, ends]
    });
    let change = lines.iter().map(|line| q.spread(line).share(tolerance)).fold(0.0, f64::max);
    Some(Along { axis: axis.name.clone(), trend, everywhere, change, elasticity })
}

/// The algebraic error of a quantity: the relative error of the record times the largest change of a result in this unit.
fn algebraic(case: &StoredCase, quantity: &str) -> f64 {
    let alike = case.record.probes.keys().filter(|column| column::comparable(column, quantity));
    let largest = alike.filter_map(|column| peak(case, column)).fold(0.0, |m: f64, change| m.max(change.abs()));
    case.record.solver.algebraic_error * largest
}

/// Names an axis: `Young's modulus E`, or for a list `the points of the list`.
pub fn axis_words(study: &[AxisRecord], name: &str, list: bool) -> String {
    match study.iter().find(|a| a.name == *name) {
        Some(axis) if !list => format!("{} {}", axis.label, axis.symbol),
        _ => "the points of the list".into(),
    }
}

/// The change in words: `67 %`, or `up to 67 %` if it depends on the values of the other keys.
fn amount(q: &ByQuantity<Dependence>, a: &Along, axes: &[AxisRecord], list: bool, tolerance: Tolerance) -> String {
    let (largest, form, several) = q.largest(a, axes, list, tolerance);
    let [change, _] = largest.words(form, tolerance, &q.quantity.unit);
    format!("{}{change}", if several { "up to " } else { "" })
}

/// The axes of a grid along which a quantity does not have two values.
fn unjudged<'a>(q: &'a Dependence, axes: &'a [AxisRecord], list: bool) -> impl Iterator<Item = &'a AxisRecord> {
    axes.iter().filter(move |axis| !list && q.along.iter().all(|a| a.axis != axis.name))
}

/// The sentence `Young's modulus E is not judged: no two converged points differ in it alone`, with the quantities if others are judged.
fn not_judged(axes: &[AxisRecord], axis: &AxisRecord, quantities: &str) -> String {
    let axis = capital(&axis_words(axes, &axis.name, false));
    format!("{axis} is not judged{quantities}: no two converged points differ in it alone")
}

fn sentence_of(q: &ByQuantity<Dependence>, tolerance: f64, axes: &[AxisRecord], list: bool) -> String {
    if q.along.is_empty() {
        return format!("{}: too few converged cases to say anything.", capital(&q.peak_title()));
    }
    let [low, high] = q.range();
    let n = digits(1e-1 * low.abs().max(high.abs()));
    let [low, high] = [low, high].map(|v| readable(v, n));
    let (low, high) = (unsigned_zero(&low), unsigned_zero(&high));
    let from = if q.has_origin() { "; its changes are counted from its first value" } else { "" };
    let mut words = format!("{}: {low} to {high}{}{from}", capital(&q.peak_title()), space(&q.quantity.unit));
    for a in &q.along {
        let axis = axis_words(axes, &a.axis, list);
        let lines = q.lines(axes.iter().position(|x| x.name == a.axis).unwrap_or(0), list);
        let everywhere = match lines.iter().filter(|line| line.len() > 1).count() {
            0 | 1 => "",
            _ if a.everywhere => ", whatever the others are",
            _ => " for some values of the others (it is constant for the rest)",
        };
        let own = q.quantity.tolerance(tolerance);
        let by = amount(q, a, axes, list, own);
        let (rises, falls, of) = match q.is_negative() {
            true => ("rises (its magnitude falls)", "falls (its magnitude rises)", " of the magnitude"),
            false => ("rises", "falls", ""),
        };
        words += &match a.trend {
            Trend::Constant => format!(". It does not depend on {axis}"),
            _ if a.change <= tolerance => {
                let (largest, form, _) = q.largest(a, axes, list, own);
                let [change, allowed] = largest.words(form, own, &q.quantity.unit);
                format!(". It hardly depends on {axis}: by at most {change}, within {allowed}")
            }
            Trend::Unordered if list => format!(". It differs between {axis}, by {by}"),
            Trend::Unordered => format!(". It differs between the values of {axis}, by {by}"),
            Trend::Turning => format!(". Along {axis} it turns around, and changes by {by}"),
            Trend::Mixed => {
                format!(". Along {axis} it rises or falls, depending on the others, by {by}")
            }
            Trend::Rising => format!(". It {rises} with {axis}{everywhere}, by {by}"),
            Trend::Falling => format!(". It {falls} with {axis}{everywhere}, by {by}"),
        };
        if let Some([least, most, ends]) = a.elasticity.filter(|_| a.change > tolerance) {
            words +=
                &format!(" (elasticity{of} {ends:.2} from end to end, {least:.2} to {most:.2} between neighbours)");
        }
    }
    for axis in unjudged(q, axes, list) {
        words += &format!(". {}", not_judged(axes, axis, ""));
    }
    minus_signs(&(words + "."))
}

fn warnings_of(stored: &[StoredCase], incomplete: &[(String, String)]) -> Vec<String> {
    let mut out = analysis::warnings(incomplete);
    analysis::add_notes(&mut out, stored);
    let mut records = stored.iter().map(|c| &c.record).filter(|r| r.converged());
    let is_one = |first: &CaseRecord, r: &CaseRecord| r.has_mesh_of(first) && r.formulation == first.formulation;
    if records.next().is_some_and(|first| records.all(|r| is_one(first, r))) {
        out.push("All points share one mesh: what the mesh does to a value or to a trend is not judged here.".into());
    }
    out
}

/// A warning if the value farthest from the first one is below it at some points and above it at others.
fn opposite_peaks(q: &ByQuantity<Dependence>, stored: &[StoredCase]) -> Option<String> {
    let count = |kind: ExtremeKind| {
        let is_one = |p: &&SweepPoint| {
            let case = stored.iter().find(|c| c.record.id == p.case);
            case.and_then(|c| c.record.probes.get(&q.quantity.name)).is_some_and(|probe| probe.peak_is == kind)
        };
        q.points.iter().filter(is_one).count()
    };
    let (below, above) = (count(ExtremeKind::Minimum), count(ExtremeKind::Maximum));
    (below > 0 && above > 0).then(|| {
        format!(
            "The peak of {} ({}) is a minimum in {below} and a maximum in {above} of the points: its trend compares one with the other. `judged = \"final\"` \
             compares the ends of the runs.",
            q.quantity.label, q.variant_label
        )
    })
}

/// The verdict for each quantity: the keys that it depends on, the strongest first.
fn verdict_of(
    quantities: &[ByQuantity<Dependence>],
    tolerance: f64,
    sweep: &SweepRecord,
    list: bool,
    missing: usize,
) -> String {
    let known: Vec<&ByQuantity<Dependence>> = quantities.iter().filter(|q| !q.along.is_empty()).collect();
    if known.is_empty() {
        return "No verdict: there are no two converged cases to compare.".into();
    }
    let name = |q: &ByQuantity<Dependence>| format!("the {} {} ({})", q.peak_is, q.quantity.label, q.variant_label);
    let one = |q: &&ByQuantity<Dependence>| {
        let own = q.quantity.tolerance(tolerance);
        let size = |a: &Along| {
            let (largest, form, _) = q.largest(a, &sweep.axes, list, own);
            form.size(largest, own)
        };
        let mut strong: Vec<&Along> = q.along.iter().filter(|a| a.change > tolerance).collect();
        strong.sort_by(|a, b| size(b).total_cmp(&size(a)));
        let from = if q.has_origin() { ", counted from its first value," } else { "" };
        let name = format!("{}{from}", name(q));
        let words: Vec<String> = (strong.iter())
            .map(|a| format!("{} ({})", axis_words(&sweep.axes, &a.axis, list), amount(q, a, &sweep.axes, list, own)))
            .collect();
        if !words.is_empty() {
            return format!("{name} changes with {}", words.join(", then "));
        }
        let spread = q.spread(&q.points.iter().collect::<Vec<_>>());
        let [change, allowed] = spread.words(Form::of(spread, own), own, &q.quantity.unit);
        match spread.share(own) <= tolerance {
            true => format!("{name} stays within {allowed}"),
            false => format!("{name} changes by {change}, with no key alone by more than {allowed}"),
        }
    };
    let all: Vec<String> = known.iter().map(one).collect();
    let not = sweep.axes.iter().filter_map(|axis| {
        let lacks = |q: &&&ByQuantity<Dependence>| unjudged(q, &sweep.axes, list).any(|a| a.name == axis.name);
        let names: Vec<String> = known.iter().filter(lacks).map(|q| name(q)).collect();
        let of = if names.len() < known.len() { format!(" for {}", wording::all(&names)) } else { String::new() };
        (!names.is_empty()).then(|| format!(" {}.", not_judged(&sweep.axes, axis, &of)))
    });
    let not: String = not.collect();
    let planned = sweep.points.len().to_string();
    let points = match span(known.iter().map(|q| q.points.len() as f64), |n| n.to_string()) {
        Some(found) if found != planned => format!("{found} of {planned}"),
        _ => planned,
    };
    format!("Over {points} points {}.{not}{}", all.join("; "), analysis::without_result(missing))
}
