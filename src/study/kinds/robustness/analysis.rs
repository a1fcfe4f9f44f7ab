//! Results of scenes that break simulators: the matrix of case × variant, and maps of where a scene holds.
//!
//! Pure: stored cases in, [`Analysis`] out. A case passes when it ends as it should and meets its references; it is refused when it
//! ends with a stated reason instead of an answer, where that is right; everything else is a failure: a reference that was missed,
//! another end than the right one, a number that is not finite, a panic, the end of the time.

use crate::report::numbers::percent;
use crate::study::kinds::robustness::check::{self, Check, Finding};
use crate::study::kinds::robustness::map;
use crate::study::kinds::robustness::map::Map;
use crate::study::kinds::robustness::outcome::Outcome;
use crate::study::kinds::robustness::record::{RobustnessRecord, SuiteRecord};
use crate::study::record::{PANICKED, StoredCase, StudyRecord};
use serde::Serialize;
use std::collections::BTreeMap;

/// A case of a suite.
#[derive(Clone, Debug, Serialize, PartialEq)]
pub struct Judged {
    pub case: String,
    pub suite: String,
    pub member: String,
    pub variant: String,
    pub outcome: Outcome,
    /// Why it was refused or failed
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    pub findings: Vec<Finding>,
    pub status: String,
    pub steps: usize,
    pub newton_iterations: usize,
    pub cuts: usize,
    pub wall_s: f64,
}

/// Everything that is said about a study of kind `robustness`.
#[derive(Clone, Debug, Serialize, PartialEq)]
pub struct Analysis {
    pub suites: Vec<SuiteRecord>,
    pub cases: Vec<Judged>,
    pub maps: Vec<Map>,
    /// (id, what is wrong)
    pub missing: Vec<(String, String)>,
    pub verdict: String,
}

impl Analysis {
    pub fn count(&self, outcome: Outcome) -> usize {
        self.cases.iter().filter(|c| c.outcome == outcome).count()
    }

    /// Outcome by case, also of the points of maps.
    pub fn outcomes(&self) -> BTreeMap<String, Outcome> {
        let suites = self.cases.iter().map(|c| (c.case.clone(), c.outcome));
        suites.chain(self.maps.iter().flat_map(Map::outcomes)).collect()
    }
}

/// Analyses what is there.
pub fn analyse(study: &StudyRecord, robustness: &RobustnessRecord, stored: &[StoredCase]) -> Analysis {
    let mut cases = vec![];
    for suite in &robustness.suites {
        let family = study.families.iter().find(|f| f.name == suite.family);
        let ids = family.into_iter().flat_map(|f| &f.cases);
        cases.extend(ids.filter_map(|id| Some(judge(suite, stored.iter().find(|c| c.record.id == *id)?, stored))));
    }
    let maps: Vec<Map> = robustness.maps.iter().map(|m| map::analyse(m, study, stored)).collect();
    let missing = (study.families.iter().flat_map(|f| &f.cases))
        .filter(|id| stored.iter().all(|c| c.record.id != **id))
        .map(|id| (id.clone(), "has no result".into()))
        .collect();
    let mut out = Analysis { suites: robustness.suites.clone(), cases, maps, missing, verdict: String::new() };
    out.verdict = verdict(&out);
    out
}

fn judge(suite: &SuiteRecord, case: &StoredCase, stored: &[StoredCase]) -> Judged {
    let r = &case.record;
    let converged = r.converged();
    let applied: Vec<&Check> = suite.checks.iter().filter(|c| c.applies(case)).collect();
    let other = |c: &Check| {
        let like = c.like.as_ref()?;
        stored.iter().find(|o| o.record.family == r.family && o.record.variant == r.variant && o.record.member == *like)
    };
    // A reference at the end of a run says nothing of a run that did not come there
    let due = |c: &&&Check| converged || c.at == check::Moment::Limit;
    let found: Vec<Option<Finding>> = applied.iter().filter(due).map(|c| c.evaluate(case, other(c))).collect();
    let right = match &suite.ends {
        Some(ends) => ends.contains(&r.status),
        None if applied.iter().any(|c| c.at != check::Moment::Limit) => converged,
        None => r.status != PANICKED && r.status != "TimeBudget",
    };
    let detail = || r.status_detail.clone().unwrap_or_else(|| r.status.clone());
    let strange = || {
        let last = |v: &Vec<f64>| v.last().is_some_and(|x| !x.is_finite());
        case.series.columns.iter().find(|(_, v)| last(v)).map(|(name, _)| format!("{name} is not finite at the end"))
    };
    let missed = || {
        let one = |f: &Option<Finding>| match f {
            None => Some("a reference needs what was not recorded".to_string()),
            Some(f) if !f.met => {
                Some(format!("{}: {:.6e}, not {:.6e} (error {:.1e})", f.what, f.measured, f.reference, f.error))
            }
            Some(_) => None,
        };
        found.iter().find_map(one)
    };
    let (outcome, reason) = if !right {
        let wrong = if converged { "it converged, where no answer is right".into() } else { detail() };
        (Outcome::Fail, Some(wrong))
    } else if let Some(why) = strange().filter(|_| converged).or_else(missed) {
        (Outcome::Fail, Some(why))
    } else if converged {
        (Outcome::Pass, None)
    } else {
        (Outcome::Refused, Some(detail()))
    };
    Judged {
        case: r.id.clone(),
        suite: suite.family.clone(),
        member: r.member.clone(),
        variant: r.variant.clone(),
        outcome,
        reason,
        findings: found.into_iter().flatten().collect(),
        status: r.status.clone(),
        steps: r.steps,
        newton_iterations: r.newton_iterations,
        cuts: r.cuts,
        wall_s: r.wall_s,
    }
}

fn verdict(a: &Analysis) -> String {
    let [pass, refused, fail] = [Outcome::Pass, Outcome::Refused, Outcome::Fail].map(|o| a.count(o));
    let mut words = vec![];
    if !a.cases.is_empty() {
        words.push(format!(
            "Of {} hard cases {pass} pass, {refused} are refused with a reason, as is right there, {fail} fail.",
            a.cases.len()
        ));
    }
    for map in &a.maps {
        let shares = map.panels.iter().map(|p| format!("{} on {}", p.label, percent(p.holds)));
        let shares: Vec<String> = shares.collect();
        if !shares.is_empty() {
            words.push(format!("Map {}: right answers {} of the points.", map.family, shares.join(", ")));
        }
    }
    if words.is_empty() {
        return "No verdict: no case has a result.".into();
    }
    if !a.missing.is_empty() {
        words.push(format!("{} case(s) have no result.", a.missing.len()));
    }
    words.join(" ")
}
