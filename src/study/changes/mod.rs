//! Changes from one result of a study to another, judged by the error bars.
//!
//! ```text
//! E_n = |new − old|/√(h_old² + h_new²)        h: half-width of the error bar on the side of the other value
//! ```
//!
//! A change is beyond the error bars if E_n > 1 (ISO/IEC 17043, 2010, annex B). A value without an error bar is judged by a tolerance. Compared are all
//! values that the study judges, with and without error bars: peaks, or largest changes of quantities that do not start at zero.
//!
//! The verdict has changed if only one result has a verdict, if a decision of the earlier result differs or is missing in the later one, or if one
//! result recommends a setting that the other finds beyond the tolerance. Its wording alone does not decide: it quotes costs, which differ from run to
//! run.

mod stored;

use crate::report::ReportError;
use crate::study::claim::Claim;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use stored::{ComparedCase, StoredSummary};

/// Relative change below which a difference is rounding, whatever was built or run \[–\].
const ROUNDING: f64 = 1e-9;

/// How far a value moved.
#[derive(Serialize, Clone, Copy, Debug, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Judgement {
    /// It did not move beyond rounding
    Same,
    /// It moved within the error bars, or within the tolerance if there are none
    Within,
    Beyond,
}

/// A value in both results.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Change {
    pub what: String,
    pub unit: String,
    pub old: f64,
    pub new: f64,
    /// (new − old)/old \[–\], positive if the value moves away from zero; `None` if the old value is zero
    pub relative: Option<f64>,
    /// E_n; `None` if a result states no error bar
    pub normalised: Option<f64>,
    pub judgement: Judgement,
}

/// A decision that differs or is missing in the later result.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Decision {
    pub what: String,
    pub old: String,
    pub new: Option<String>,
}

/// A setting that affects how values are judged and differs between the two studies.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct ChangedSetting {
    pub what: String,
    pub old: String,
    pub new: String,
}

/// Everything that differs between two results.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Changes {
    pub study: [String; 2],
    pub version: [String; 2],
    pub tolerance: [f64; 2],
    /// Settings that affect how values are judged and that differ: the value of a run that counts, the reference, absolute tolerances
    pub settings: Vec<ChangedSetting>,
    pub verdict: [String; 2],
    /// Whether the verdicts differ in more than numbers
    pub verdict_changed: bool,
    pub decisions: Vec<Decision>,
    /// Whether a result lacks decisions because an earlier version wrote it; then decisions are not compared
    pub undecided: [bool; 2],
    /// Common cases that were computed from different inputs: scene, files or mesh
    pub inputs: Vec<String>,
    /// Cases that only the earlier result has
    pub missing: Vec<String>,
    pub added: Vec<String>,
    /// Case, old status, new status
    pub statuses: Vec<(String, String, String)>,
    /// Case, old cells, new cells
    pub meshes: Vec<(String, usize, usize)>,
    /// CPU time of the common cases \[s\]
    pub cpu_s: [f64; 2],
    pub values: Vec<Change>,
    /// Compared values that have an error bar in one result only
    pub unmatched: Vec<String>,
    /// Values that only the earlier result judges, except those of missing cases
    pub gone: Vec<String>,
    /// Values that only the later result judges, except those of added cases
    pub new: Vec<String>,
}

impl Changes {
    /// Whether something became worse or changed by more than its uncertainty: the verdict, a value beyond its error bar, a case or value that is gone,
    /// or a case that no longer converges.
    pub fn is_beyond(&self) -> bool {
        let lost = |(_, old, new): &(String, String, String)| old == CONVERGED && new != CONVERGED;
        self.verdict_changed
            || !self.missing.is_empty()
            || !self.gone.is_empty()
            || self.statuses.iter().any(lost)
            || self.values.iter().any(|v| v.judgement == Judgement::Beyond)
    }
}

const CONVERGED: &str = "Converged";

/// Reason why two results are not compared.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    #[error(transparent)]
    Report(#[from] ReportError),
    #[error(
        "{old} holds a study of kind \"{old_kind}\", {new} one of kind \"{new_kind}\"; give two results of one study"
    )]
    Kinds { old: String, old_kind: String, new: String, new_kind: String },
    #[error("{old} and {new} have no case and no value in common; give two results of one study")]
    NothingInCommon { old: String, new: String },
}

/// Compares the results in two folders. `tolerance` is the accepted relative change of a value without an error bar.
///
/// # Errors
/// Folders without a result, or with results that cannot be compared.
pub fn compare(old: &Path, new: &Path, tolerance: f64) -> Result<Changes, CompareError> {
    let (a, b) = (StoredSummary::read(old)?, StoredSummary::read(new)?);
    let name = |path: &Path| path.display().to_string();
    if a.kind != b.kind {
        let (old_kind, new_kind) = (a.kind, b.kind);
        return Err(CompareError::Kinds { old: name(old), old_kind, new: name(new), new_kind });
    }
    let changes = between(&a, &b, tolerance);
    if changes.values.is_empty() && changes.missing.len() == a.cases.len() {
        return Err(CompareError::NothingInCommon { old: name(old), new: name(new) });
    }
    Ok(changes)
}

fn between(a: &StoredSummary, b: &StoredSummary, tolerance: f64) -> Changes {
    let cases: BTreeMap<&str, &ComparedCase> = b.cases.iter().map(|c| (c.id.as_str(), c)).collect();
    let common: Vec<(&ComparedCase, &ComparedCase)> =
        a.cases.iter().filter_map(|c| Some((c, *cases.get(c.id.as_str())?))).collect();
    let values = values_between(a, b, &common, tolerance);
    let decisions = decisions_between(a, b);
    let (missing, added) = (cases_of_one(a, b), cases_of_one(b, a));
    Changes {
        study: [a.study.clone(), b.study.clone()],
        version: [a.version.clone(), b.version.clone()],
        tolerance: [a.tolerance, b.tolerance],
        settings: settings_between(a, b),
        verdict: [a.verdict.clone(), b.verdict.clone()],
        verdict_changed: a.differs_in_support(b)
            || !decisions.is_empty()
            || differ_in_setting(a, b)
            || differ_in_setting(b, a),
        decisions,
        undecided: [a.decisions.is_none(), b.decisions.is_none()],
        inputs: (common.iter())
            .filter(|(o, n)| o.identity.as_ref().zip(n.identity.as_ref()).is_some_and(|(old, new)| old != new))
            .map(|(o, _)| o.id.clone())
            .collect(),
        statuses: (common.iter().filter(|(o, n)| o.status != n.status))
            .map(|(o, n)| (o.id.clone(), o.status.clone(), n.status.clone()))
            .collect(),
        meshes: (common.iter().filter(|(o, n)| o.mesh.cells != n.mesh.cells))
            .map(|(o, n)| (o.id.clone(), o.mesh.cells, n.mesh.cells))
            .collect(),
        cpu_s: [common.iter().map(|(o, _)| o.cpu_s).sum(), common.iter().map(|(_, n)| n.cpu_s).sum()],
        unmatched: a.in_both(b).into_iter().filter(|what| a.has_bar(what) != b.has_bar(what)).collect(),
        gone: a.values_without(b, &missing),
        new: b.values_without(a, &added),
        values,
        missing,
        added,
    }
}

/// The cases that only `from` has.
fn cases_of_one(from: &StoredSummary, of: &StoredSummary) -> Vec<String> {
    let known: BTreeSet<&str> = of.cases.iter().map(|c| c.id.as_str()).collect();
    from.cases.iter().filter(|c| !known.contains(c.id.as_str())).map(|c| c.id.clone()).collect()
}

/// Compares the values that both results judge: by their error bars if both have one, otherwise by the tolerance.
fn values_between(
    a: &StoredSummary,
    b: &StoredSummary,
    common: &[(&ComparedCase, &ComparedCase)],
    tolerance: f64,
) -> Vec<Change> {
    let claims: BTreeMap<&str, &Claim> = b.claims.iter().map(|c| (c.what.as_str(), c)).collect();
    let mut values: Vec<Change> =
        a.claims.iter().filter_map(|old| Some(of_claims(old, claims.get(old.what.as_str())?))).collect();
    for (old, new) in common {
        for (column, what) in old.values(a) {
            if a.has_bar(&what) && b.has_bar(&what) {
                continue;
            }
            let Some((quantity, (value, now, words))) = b.judged(new, column).zip(values_of(old, new, column)) else {
                continue;
            };
            let accepted = (tolerance * value.abs()).max(quantity.absolute_tolerance.unwrap_or(0.0));
            values.push(without_bar(what + words, &quantity.unit, (value, now), accepted));
        }
    }
    values
}

/// The decisions of the earlier result that differ or are missing in the later one.
fn decisions_between(a: &StoredSummary, b: &StoredSummary) -> Vec<Decision> {
    let Some((old, new)) = a.decisions.as_ref().zip(b.decisions.as_ref()) else { return vec![] };
    let changed = old.iter().filter(|(what, decision)| new.get(*what) != Some(*decision));
    let of = |(what, old): (&String, &String)| Decision {
        what: what.clone(),
        old: old.clone(),
        new: new.get(what).cloned(),
    };
    changed.map(of).collect()
}

/// Settings that affect how both studies judge values, and that differ.
fn settings_between(a: &StoredSummary, b: &StoredSummary) -> Vec<ChangedSetting> {
    let both = a.settings.iter().filter_map(|(what, old)| Some((what, old, b.settings.get(what)?)));
    both.filter(|(_, old, new)| old != new)
        .map(|(what, old, new)| ChangedSetting { what: what.clone(), old: old.clone(), new: new.clone() })
        .collect()
}

/// Whether the setting that one result recommends is beyond the tolerance in the other one.
fn differ_in_setting(one: &StoredSummary, other: &StoredSummary) -> bool {
    one.recommended().is_some_and(|case| other.recommended().is_some() && !other.accepts(case))
}

/// The values of a column by which two results are compared, and a suffix for its name. If one of the results lacks judged values, because an earlier
/// version wrote it and its curves are not stored, the recorded extremes of both are used.
fn values_of(old: &ComparedCase, new: &ComparedCase, column: &str) -> Option<(f64, f64, &'static str)> {
    let judged = old.judged.get(column).zip(new.judged.get(column));
    let recorded = || Some((old.probes.get(column)?.peak, new.probes.get(column)?.peak, ", recorded extreme"));
    judged.map(|(old, new)| (*old, *new, "")).or_else(recorded)
}

fn of_claims(old: &Claim, new: &Claim) -> Change {
    let change = new.value - old.value;
    let up = change > 0.0;
    let half = |c: &Claim, upwards: bool| if upwards { c.interval[1] - c.value } else { c.value - c.interval[0] };
    let bars = half(old, up).hypot(half(new, !up));
    // Two exact values that differ are beyond any error bar
    let normalised = if change == 0.0 { 0.0 } else { change.abs() / bars };
    let judgement = if is_rounding(old.value, new.value) {
        Judgement::Same
    } else if normalised <= 1.0 {
        Judgement::Within
    } else {
        Judgement::Beyond
    };
    change_of(old.what.clone(), &new.unit, (old.value, new.value), Some(normalised), judgement)
}

fn without_bar(what: String, unit: &str, (old, new): (f64, f64), accepted: f64) -> Change {
    let judgement = if is_rounding(old, new) {
        Judgement::Same
    } else if (new - old).abs() <= accepted {
        Judgement::Within
    } else {
        Judgement::Beyond
    };
    change_of(what, unit, (old, new), None, judgement)
}

fn is_rounding(old: f64, new: f64) -> bool {
    (new - old).abs() <= ROUNDING * old.abs().max(new.abs())
}

fn change_of(
    what: String,
    unit: &str,
    (old, new): (f64, f64),
    normalised: Option<f64>,
    judgement: Judgement,
) -> Change {
    let relative = (old != 0.0).then(|| (new - old) / old);
    Change { what, unit: unit.into(), old, new, relative, normalised, judgement }
}
