//! A comparison that a case must pass: two formulas evaluated on the recorded results.
//!
//! Variables are the columns of the CSV in their units; `steps`, `unstable_steps`, `newton_iterations` and `cuts` of the whole run; and, in braces,
//! values of the scene in SI: `{laws.rubber.E}`. With m the measured value and r the reference over the rows that are compared:
//!
//! ```text
//! error = max |m − r| / max s        s the scale; at_most: m − r where positive; at_least: r − m
//! ```
//!
//! Without a given scale, s is |r|. In a comparison with another member, it is the largest change of r over its run, so that the position of the body
//! in its frame does not matter.

use crate::math::formula::Formula;
use crate::math::statistics::larger;
use crate::math::units;
use crate::scene::{hint, overrides};
use crate::study::curve::Curve;
use crate::study::store::record::StoredCase;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Relative change \[of the largest value\] up to which a formula counts as constant.
const CONSTANT: f64 = 1e-6;

/// Variables that are numbers of the whole run.
const OF_THE_RUN: [&str; 4] = ["steps", "unstable_steps", "newton_iterations", "cuts"];

/// Keys of a `[[suite.check]]`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CheckSpec {
    /// The comparison, in words
    pub what: String,
    /// Formula of recorded columns that is compared
    pub measured: String,
    /// Formula of the reference; or `like`, or `first`
    pub reference: Option<String>,
    /// Another member, of the same variant, in which the same formula is evaluated; with `reference`, the reference is evaluated there
    pub like: Option<String>,
    /// The formula keeps its first value
    #[serde(default)]
    pub first: bool,
    /// Rows that are compared
    #[serde(default)]
    pub at: Moment,
    /// Side of the reference that counts
    #[serde(default)]
    pub bound: Bound,
    /// Largest error, as a fraction or in %
    pub accept: String,
    /// Formula of the size that errors are divided by; if absent the reference, with `like` its largest change
    pub scale: Option<String>,
    /// Where the reference comes from
    pub source: String,
    /// Members that it applies to, all if absent
    pub members: Option<Vec<String>>,
    /// Variants that it applies to, all if absent
    pub variants: Option<Vec<String>>,
}

/// Rows that are compared.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Moment {
    /// The last row
    #[default]
    End,
    /// All rows
    Every,
    /// The largest loads that a path of equilibria carries: variables are signals
    Limit,
}

/// Which side of the reference counts.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    /// Both sides
    #[default]
    Both,
    /// The measured formula may be smaller
    AtMost,
    /// The measured formula may be larger
    AtLeast,
}

impl Bound {
    /// Returns by how much a measured value violates its reference; NaN if either is not finite.
    fn off(self, measured: f64, reference: f64) -> f64 {
        if !(measured.is_finite() && reference.is_finite()) {
            return f64::NAN;
        }
        match self {
            Self::Both => (measured - reference).abs(),
            Self::AtMost => (measured - reference).max(0.0),
            Self::AtLeast => (reference - measured).max(0.0),
        }
    }

    /// The largest error relative to the largest size, and the values there; `None` without rows. NaN counts as the largest error.
    fn largest_error(self, measured: &[f64], reference: &[f64], size: &[f64]) -> Option<(f64, f64, f64)> {
        let size = size.iter().map(|s| s.abs()).fold(0.0, larger);
        let worse = |a: f64, b: f64| if b.is_nan() || a.is_nan() { b.is_nan() } else { b > a };
        let rows = measured.iter().zip(reference).map(|(&m, &r)| (self.off(m, r), m, r));
        let (off, measured, reference) = rows.reduce(|a, b| if worse(a.0, b.0) { b } else { a })?;
        // An exact agreement has error zero, whatever the size; with a size that is not finite the error is NaN
        let error = match size.is_finite() {
            true if off == 0.0 => 0.0,
            true => off / size,
            false => f64::NAN,
        };
        Some((error, measured, reference))
    }
}

/// A check as it is stored with the study.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Check {
    pub what: String,
    pub measured: String,
    /// Formula of the reference; if absent the measured formula, in `like` or at the first row
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub like: Option<String>,
    pub at: Moment,
    pub bound: Bound,
    pub accept: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<String>,
    pub source: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub members: Option<Vec<String>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub variants: Option<Vec<String>>,
}

/// Result of a check.
#[derive(Clone, Debug, Serialize, PartialEq)]
pub struct CheckResult {
    pub what: String,
    pub source: String,
    /// Values where the error is largest
    pub measured: f64,
    pub reference: f64,
    pub error: f64,
    pub accept: f64,
    pub met: bool,
}

impl Check {
    /// Builds a check of a suite with these members and variants.
    pub fn new(spec: &CheckSpec, members: &[String], variants: &[String]) -> Result<Self, (String, String)> {
        let place = |fact: String| format!("check \"{}\": {fact}", spec.what);
        let choices = [spec.reference.is_some(), spec.like.is_some(), spec.first];
        let both = choices == [true, true, false];
        if choices.iter().filter(|c| **c).count() != 1 && !both {
            let fact = place("it needs one of `reference`, `like` and `first`, or `like` with `reference`".into());
            return Err((fact, "write for example reference = \"0.30172\"".into()));
        }
        for text in [Some(&spec.measured), spec.reference.as_ref(), spec.scale.as_ref()].into_iter().flatten() {
            Formula::new(text, 1.0).map_err(|e| {
                (place(format!("\"{text}\" is no formula: {e}")), "write arithmetic in columns".to_string())
            })?;
        }
        let named = spec.like.iter().chain(spec.members.iter().flatten()).map(|name| ("member", name, members));
        for (what, name, known) in named.chain(spec.variants.iter().flatten().map(|name| ("variant", name, variants))) {
            if !known.contains(name) {
                return Err((place(format!("there is no {what} \"{name}\"")), hint(name, known)));
            }
        }
        let is_judged = |member: &String| spec.like.as_ref() != Some(member);
        let some = spec.members.as_deref().unwrap_or(members).iter().any(is_judged);
        if !some || spec.variants.as_ref().is_some_and(Vec::is_empty) {
            let remedy = "name other members or variants, or leave the check out; `like` is not compared with itself";
            return Err((place("it holds for no case".into()), remedy.into()));
        }
        let accept = units::parse(&spec.accept, units::Dimension::NONE)
            .map_err(|e| (place(e.to_string()), "write accept = \"1 %\"".to_string()))?;
        if accept.is_nan() || accept < 0.0 {
            return Err((place(format!("accept = {accept}")), "write accept = \"1 %\"".into()));
        }
        Ok(Self {
            what: spec.what.clone(),
            measured: spec.measured.clone(),
            reference: spec.reference.clone(),
            like: spec.like.clone(),
            at: spec.at,
            bound: spec.bound,
            accept,
            scale: spec.scale.clone(),
            source: spec.source.clone(),
            members: spec.members.clone(),
            variants: spec.variants.clone(),
        })
    }

    /// Columns that a case must record for this check.
    pub fn columns(&self) -> Vec<String> {
        if self.at == Moment::Limit {
            return vec![];
        }
        let texts = [Some(&self.measured), self.reference.as_ref(), self.scale.as_ref()];
        let formulas = texts.into_iter().flatten().filter_map(|text| Formula::new(text, 1.0).ok());
        let names = formulas.flat_map(|f| f.variables().to_vec());
        names.filter(|n| !n.contains('.') && n != "t_s" && !OF_THE_RUN.contains(&n.as_str())).collect()
    }

    /// Whether the check applies to this case.
    pub fn applies(&self, case: &StoredCase) -> bool {
        let within = |list: &Option<Vec<String>>, name: &String| list.as_ref().is_none_or(|l| l.contains(name));
        let itself = self.like.as_ref() == Some(&case.record.member);
        within(&self.members, &case.record.member) && within(&self.variants, &case.record.variant) && !itself
    }

    /// Compares a case; `other` is the case that it must agree with. `None` if something that is needed was not recorded.
    pub fn evaluate(&self, case: &StoredCase, other: Option<&StoredCase>) -> Option<CheckResult> {
        let measured = values(&self.measured, case, self.at)?;
        let formula = self.reference.as_ref().unwrap_or(&self.measured);
        let reference = match &self.like {
            Some(_) => values(formula, other?, self.at)?,
            None if self.reference.is_some() => values(formula, case, self.at)?,
            None => vec![values(formula, case, Moment::Every)?[0]; measured.len()],
        };
        if measured.len() != reference.len() || measured.is_empty() {
            return None;
        }
        let size = match (&self.scale, other.filter(|_| self.at != Moment::Limit)) {
            (Some(scale), _) => values(scale, case, self.at)?,
            (None, Some(other)) => {
                largest_change(formula, other).map_or_else(|| reference.clone(), |change| vec![change])
            }
            (None, None) => reference.clone(),
        };
        let (error, measured, reference) = self.bound.largest_error(&measured, &reference, &size)?;
        let (what, source) = (self.what.clone(), self.source.clone());
        Some(CheckResult { what, source, measured, reference, error, accept: self.accept, met: error <= self.accept })
    }
}

/// The largest change of a formula over a run from its first value, or from zero if it starts there; `None` if it is constant, such as a number of
/// steps.
fn largest_change(formula: &str, case: &StoredCase) -> Option<f64> {
    let rows = values(formula, case, Moment::Every)?.into_iter().zip(&case.series.t_s);
    let (f, t): (Vec<f64>, Vec<f64>) = rows.filter(|(f, _)| f.is_finite()).unzip();
    let curve = Curve { t, f };
    let largest = if curve.f.is_empty() { 0.0 } else { curve.largest_change() };
    (largest.abs() > CONSTANT * curve.peak().abs()).then_some(largest)
}

/// The values of a formula at the rows that `at` selects.
fn values(text: &str, case: &StoredCase, at: Moment) -> Option<Vec<f64>> {
    let formula = Formula::new(text, 1.0).ok()?;
    let series = &case.series;
    let rows = match at {
        Moment::Every => 0..series.t_s.len(),
        Moment::End => series.t_s.len().checked_sub(1)?..series.t_s.len(),
        Moment::Limit => 0..1,
    };
    let scene: toml::Table = case.record.provenance.scene.parse().ok()?;
    rows.map(|k| {
        let value = |name: &String| variable(name, case, &scene, k, at);
        let variables: Option<Vec<f64>> = formula.variables().iter().map(value).collect();
        Some(formula.value(&variables?))
    })
    .collect()
}

fn variable(name: &str, case: &StoredCase, scene: &toml::Table, row: usize, at: Moment) -> Option<f64> {
    let r = &case.record;
    if name.contains('.') {
        return in_scene(scene, name);
    }
    if at == Moment::Limit {
        let solver = &r.solver;
        let stop = solver.stop.as_ref().and_then(|stop| stop.limit.get(name));
        return stop.or_else(|| solver.turning_points.first()?.signals.get(name)).copied();
    }
    match name {
        "t_s" => case.series.t_s.get(row).copied(),
        "steps" => Some(r.steps as f64),
        // Unknown unless eigenvalues were counted in every step
        "unstable_steps" => (r.solver.uncounted_steps == 0).then_some(r.solver.unstable_steps as f64),
        "newton_iterations" => Some(r.newton_iterations as f64),
        "cuts" => Some(r.cuts as f64),
        column => case.series.columns.get(column)?.get(row).copied(),
    }
}

/// A number or a quantity of the scene, in SI.
fn in_scene(scene: &toml::Table, path: &str) -> Option<f64> {
    match overrides::find(scene, path).ok()? {
        toml::Value::Float(x) => Some(*x),
        toml::Value::Integer(n) => Some(*n as f64),
        toml::Value::String(text) => units::quantity(text).ok().map(|q| q.0),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::store::record::{CaseRecord, Series};
    use crate::study::store::solver_record::StopRecord;

    /// A case with these values of x, after two steps.
    fn case(x: &[f64]) -> StoredCase {
        let t_s = (0..x.len()).map(|k| k as f64).collect();
        let series = Series { t_s, columns: [("x".to_string(), x.to_vec())].into() };
        StoredCase::new(CaseRecord { steps: 2, ..CaseRecord::default() }, series)
    }

    /// Reads a check of a suite with the members a and b and the variants v and w.
    fn read(more: &str) -> Result<Check, (String, String)> {
        let text = format!("what = 'a'\nmeasured = 'x'\naccept = '1 %'\nsource = 'a closed form'\n{more}");
        let spec: CheckSpec = toml::from_str(&text).expect("valid TOML");
        Check::new(&spec, &["a", "b"].map(String::from), &["v", "w"].map(String::from))
    }

    fn check(more: &str) -> Check {
        read(more).expect("a check")
    }

    fn met(more: &str, x: &[f64]) -> bool {
        check(more).evaluate(&case(x), None).expect("recorded").met
    }

    #[test]
    fn every_bound_is_met_on_its_side_and_by_no_value_that_is_not_finite() {
        let reference = |bound: &str| format!("reference = '2'\nbound = '{bound}'");
        for (bound, held, missed) in [
            ("both", &[2.019, 1.981][..], &[2.021, 1.979][..]),
            ("at_most", &[2.019, -9.0], &[2.021]),
            ("at_least", &[1.981, 9.0], &[1.979]),
        ] {
            let bound = reference(bound);
            held.iter().for_each(|x| assert!(met(&bound, &[0.0, *x]), "{bound} {x}"));
            let none = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
            missed.iter().chain(&none).for_each(|x| assert!(!met(&bound, &[0.0, *x]), "{bound} {x}"));
        }
        assert!(!met("reference = 'sqrt(x - 1)'\nbound = 'at_most'\nscale = '1'", &[0.5]));
        assert!(!met("reference = 'x'\nscale = 'sqrt(x - 1)'", &[0.5]), "a size that is no number");
        assert!(!met("reference = '1'\nscale = '1 / (x - x)'", &[0.5]), "a size that is infinite");
    }

    #[test]
    fn moments_choose_the_rows() {
        let every = "reference = '2'\nat = 'every'";
        assert!(met("reference = '2'", &[7.0, 2.0]) && !met(every, &[7.0, 2.0]) && met(every, &[2.0, 2.01]));
        assert!(!met(every, &[2.0, f64::NAN, 2.0]), "the row that is no number decides");
        assert!(met("first = true\nat = 'every'", &[3.0, 3.02]) && !met("first = true\nat = 'every'", &[3.0, 3.1]));
        let found = check("reference = '2 * t_s'\nat = 'every'\nscale = '10'").evaluate(&case(&[0.0, 3.0, 4.5]), None);
        let found = found.expect("recorded");
        assert_eq!((found.measured, found.reference, found.error), (3.0, 2.0, 0.1));
        let of_the_run = |name: &str, x: f64| {
            check(&format!("reference = '{name}'")).evaluate(&case(&[x]), None).map(|found| found.met)
        };
        assert_eq!((of_the_run("steps", 2.0), of_the_run("steps", 3.0)), (Some(true), Some(false)));
        assert_eq!((of_the_run("unstable_steps", 0.0), of_the_run("unstable_steps", 1.0)), (Some(true), Some(false)));
        let mut uncounted = case(&[0.0]);
        uncounted.record.solver.uncounted_steps = 1;
        assert_eq!(check("reference = 'unstable_steps'").evaluate(&uncounted, None), None);
    }

    #[test]
    fn a_check_holds_for_some_case() {
        let fact = |more: &str| read(more).expect_err(more).0;
        assert!(fact("first = true\nvariants = ['vv']").contains("there is no variant \"vv\""));
        assert!(fact("first = true\nmembers = ['c']").contains("there is no member \"c\""));
        for none in ["first = true\nvariants = []", "first = true\nmembers = []", "like = 'b'\nmembers = ['b']"] {
            assert!(fact(none).contains("it holds for no case"), "{none}");
        }
        check("like = 'b'\nmembers = ['a', 'b']\nvariants = ['w']");
    }

    /// A body that moves by 0.1 over the run, and by at most 0.2 in between, is off by 1e-3: half a percent of its motion, wherever it is. For a body
    /// that does not move, the error is relative to its own value.
    #[test]
    fn the_scale_of_another_member_is_its_motion() {
        for place in [0.0, 7.0, -0.1, 1e3] {
            let run = |off: f64| case(&[0.0, 0.2, 0.1 + off].map(|x| place + x));
            let found = check("like = 'b'").evaluate(&run(1e-3), Some(&run(0.0))).expect("recorded");
            assert!((found.error - 5e-3).abs() < 1e-9, "at {place}: {}", found.error);
        }
        let found = check("like = 'b'").evaluate(&case(&[4.0, 4.1]), Some(&case(&[4.0, 4.0]))).expect("recorded");
        assert!((found.error - 0.025).abs() < 1e-12, "{}", found.error);
        let scaled = check("like = 'b'\nscale = '2'").evaluate(&case(&[0.0, 4.1]), Some(&case(&[0.0, 4.0])));
        assert!((scaled.expect("recorded").error - 0.05).abs() < 1e-12);
    }

    #[test]
    fn another_member_is_the_reference() {
        let like = check("like = 'b'");
        let [own, alike, other] = [&[1.0][..], &[1.005], &[1.5]].map(case);
        let is_met = |other: &StoredCase| like.evaluate(&own, Some(other)).map(|found| found.met);
        assert_eq!((is_met(&alike), is_met(&other), like.evaluate(&own, None)), (Some(true), Some(false), None));
        assert_eq!(check("reference = 'y'").evaluate(&own, None), None, "y was not recorded");
        // The largest load of a path, as its status states it
        let mut case = case(&[0.0]);
        let limit = check("reference = '0.5'\nat = 'limit'");
        assert_eq!(limit.evaluate(&case, None), None);
        let stop = |load: f64| StopRecord { limit: [("x".to_string(), load)].into(), ..StopRecord::default() };
        for (load, met) in [(0.503, true), (0.51, false)] {
            case.record.solver.stop = Some(stop(load));
            assert_eq!(limit.evaluate(&case, None).map(|found| found.met), Some(met), "{load}");
        }
    }
}
