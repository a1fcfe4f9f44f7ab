//! A number that a case must meet: two formulas in what was recorded, compared.
//!
//! Variables are the columns of the CSV in their units, `steps`, `newton_iterations` and `cuts` of the whole run, and, in braces,
//! values of the scene in SI: `{laws.rubber.E}`. With m measured and r the reference over the rows that are compared:
//!
//! ```text
//! error = max |m − r| / max s        s the scale, |r| if none is given; at_most: m − r where positive; at_least: r − m
//! ```

use crate::math::formula::Formula;
use crate::math::units;
use crate::scene::{hint, overrides};
use crate::study::store::record::StoredCase;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[[suite.check]]`
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CheckSpec {
    /// The comparison, in words
    pub what: String,
    /// Formula of recorded columns that is compared
    pub measured: String,
    /// Formula of the reference; or `like`, or `first`
    pub reference: Option<String>,
    /// The same formula in another member, same variant; with `reference`, the reference is evaluated there
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
    /// Formula of the size that errors are divided by
    pub scale: Option<String>,
    /// Where the reference comes from
    pub source: String,
    /// Members it holds for, all if absent
    pub members: Option<Vec<String>>,
    /// Variants it holds for, all if absent
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

/// A check as it is stored with the study.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Check {
    pub what: String,
    pub measured: String,
    /// Absent: the measured formula, in `like` or at the first row
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
    /// Where the error is largest
    pub measured: f64,
    pub reference: f64,
    pub error: f64,
    pub accept: f64,
    pub met: bool,
}

impl Check {
    /// Fact and remedy of what cannot be checked.
    pub fn new(spec: &CheckSpec, known: &[String]) -> Result<Self, (String, String)> {
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
        for member in spec.like.iter().chain(spec.members.iter().flatten()) {
            if !known.contains(member) {
                return Err((place(format!("there is no member \"{member}\"")), hint(member, known)));
            }
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

    /// Columns that a case must record for it.
    pub fn columns(&self) -> Vec<String> {
        if self.at == Moment::Limit {
            return vec![];
        }
        let texts = [Some(&self.measured), self.reference.as_ref(), self.scale.as_ref()];
        let formulas = texts.into_iter().flatten().filter_map(|text| Formula::new(text, 1.0).ok());
        let names = formulas.flat_map(|f| f.variables().to_vec());
        names
            .filter(|n| !n.contains('.') && !["t_s", "steps", "newton_iterations", "cuts"].contains(&n.as_str()))
            .collect()
    }

    /// Whether it applies to this case.
    pub fn applies(&self, case: &StoredCase) -> bool {
        let within = |list: &Option<Vec<String>>, name: &String| list.as_ref().is_none_or(|l| l.contains(name));
        let itself = self.like.as_ref() == Some(&case.record.member);
        within(&self.members, &case.record.member) && within(&self.variants, &case.record.variant) && !itself
    }

    /// Compares a case; `other` is the one that it is to be like. `None` where something that it needs was not recorded.
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
        let size = match &self.scale {
            Some(scale) => values(scale, case, self.at)?,
            None => reference.clone(),
        };
        let size = size.iter().map(|s| s.abs()).fold(0.0, f64::max);
        let off = |m: f64, r: f64| match self.bound {
            Bound::Both => (m - r).abs(),
            Bound::AtMost => (m - r).max(0.0),
            Bound::AtLeast => (r - m).max(0.0),
        };
        // NaN is the worst
        let worse = |a: f64, b: f64| if b.is_nan() || a.is_nan() { b.is_nan() } else { b > a };
        let pairs = measured.iter().zip(&reference).map(|(&m, &r)| (off(m, r), m, r));
        let (off, measured, reference) = pairs.reduce(|a, b| if worse(a.0, b.0) { b } else { a })?;
        // Nothing is off by nothing, whatever the size
        let error = if off == 0.0 { 0.0 } else { off / size };
        let (what, source) = (self.what.clone(), self.source.clone());
        Some(CheckResult { what, source, measured, reference, error, accept: self.accept, met: error <= self.accept })
    }
}

/// Values of a formula at the rows of a moment.
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
