//! Results of scenes that break simulators: the matrix of case × variant, and maps of where a scene holds.
//!
//! Pure: stored cases in, [`RobustnessFindings`] out. A case passes when it ends as it should and meets its references; it is stopped when it
//! ends with a stated reason instead of an answer, where the study accepts that; everything else is a failure: a reference that was missed,
//! another end than the right one, a number that is not finite, a panic, the end of the time.

use crate::report::numbers::percent;
use crate::study::analysis::{self, Analysis};
use crate::study::case_outcome::CaseOutcome;
use crate::study::kinds::robustness::check::{self, Check, CheckResult};
use crate::study::kinds::robustness::map;
use crate::study::kinds::robustness::map::Map;
use crate::study::kinds::robustness::record::{RobustnessRecord, SuiteRecord};
use crate::study::store::record::{NOT_RUN, StoredCase, StudyRecord};
use crate::wording::count;
use serde::Serialize;
use std::collections::BTreeMap;

/// A case of a suite.
#[derive(Clone, Debug, Serialize, PartialEq)]
pub struct JudgedCase {
    pub case: String,
    pub suite: String,
    pub member: String,
    pub variant: String,
    pub outcome: CaseOutcome,
    /// Why it was stopped or failed
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    pub findings: Vec<CheckResult>,
    pub status: String,
    pub steps: usize,
    /// Iterations, with those of refused steps
    pub newton_iterations: usize,
    pub cuts: usize,
    pub wall_s: f64,
}

/// Findings of a robustness study.
#[derive(Clone, Debug, PartialEq)]
pub struct RobustnessFindings {
    pub suites: Vec<SuiteRecord>,
    pub cases: Vec<JudgedCase>,
    pub maps: Vec<Map>,
}

impl RobustnessFindings {
    pub fn count(&self, outcome: CaseOutcome) -> usize {
        self.cases.iter().filter(|c| c.outcome == outcome).count()
    }

    /// Outcome by case, also of the points of maps.
    pub fn outcomes(&self) -> BTreeMap<String, CaseOutcome> {
        let suites = self.cases.iter().map(|c| (c.case.clone(), c.outcome));
        suites.chain(self.maps.iter().flat_map(Map::outcomes)).collect()
    }
}

/// Analyses what is there.
pub fn analyse(
    study: &StudyRecord,
    robustness: &RobustnessRecord,
    stored: &[StoredCase],
) -> Analysis<RobustnessFindings> {
    let mut cases = vec![];
    for suite in &robustness.suites {
        let family = study.families.iter().find(|f| f.name == suite.family);
        let ids = family.into_iter().flat_map(|f| &f.cases);
        cases.extend(ids.filter_map(|id| Some(judge(suite, stored.iter().find(|c| c.record.id == *id)?, stored))));
    }
    let maps: Vec<Map> = robustness.maps.iter().map(|m| map::analyse(m, study, stored)).collect();
    // A status is a result here
    let incomplete: Vec<(String, String)> = (study.families.iter().flat_map(|f| &f.cases))
        .filter(|id| stored.iter().all(|c| c.record.id != **id))
        .map(|id| (id.clone(), NOT_RUN.into()))
        .collect();
    let found = RobustnessFindings { suites: robustness.suites.clone(), cases, maps };
    let verdict = verdict(&found, incomplete.len());
    let failed = found.cases.iter().filter(|c| c.outcome == CaseOutcome::Fail);
    let warnings = failed.map(|c| format!("{} fails: {}.", c.case, c.reason.as_deref().unwrap_or("no reason")));
    let warnings = warnings.chain(robustness.left_out.iter().cloned()).chain(analysis::warnings(&incomplete)).collect();
    Analysis { tolerance: study.tolerance, found, incomplete, warnings, verdict }
}

fn judge(suite: &SuiteRecord, case: &StoredCase, stored: &[StoredCase]) -> JudgedCase {
    let r = &case.record;
    let converged = r.converged();
    let applied: Vec<&Check> = suite.checks.iter().filter(|c| c.applies(case)).collect();
    let other = |c: &Check| {
        let like = c.like.as_ref()?;
        stored.iter().find(|o| o.record.family == r.family && o.record.variant == r.variant && o.record.member == *like)
    };
    // A reference at the end of a run says nothing of a run that did not come there
    let due = |c: &&&Check| converged || c.at == check::Moment::Limit;
    let found: Vec<Option<CheckResult>> = applied.iter().filter(due).map(|c| c.evaluate(case, other(c))).collect();
    let right = match &suite.ends {
        Some(ends) => ends.contains(&r.status),
        None if applied.iter().any(|c| c.at != check::Moment::Limit) => converged,
        None => !r.broke() && r.status != "TimeBudget",
    };
    let detail = || r.status_detail.clone().unwrap_or_else(|| r.status.clone());
    let strange = || {
        let first = |v: &Vec<f64>| v.iter().position(|x| !x.is_finite());
        let found = case.series.columns.iter().find_map(|(name, v)| Some((name, first(v)?)));
        found.map(|(name, row)| format!("{name} is not finite at t = {:.6} s", case.series.t_s[row]))
    };
    let missed = || {
        let one = |f: &Option<CheckResult>| match f {
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
        (CaseOutcome::Fail, Some(wrong))
    } else if let Some(why) = strange().filter(|_| converged).or_else(missed) {
        (CaseOutcome::Fail, Some(why))
    } else if converged {
        (CaseOutcome::Pass, None)
    } else {
        (CaseOutcome::Stopped, Some(detail()))
    };
    JudgedCase {
        case: r.id.clone(),
        suite: suite.family.clone(),
        member: r.member.clone(),
        variant: r.variant.clone(),
        outcome,
        reason,
        findings: found.into_iter().flatten().collect(),
        status: r.status.clone(),
        steps: r.steps,
        newton_iterations: r.all_iterations(),
        cuts: r.cuts,
        wall_s: r.wall_s,
    }
}

fn verdict(a: &RobustnessFindings, missing: usize) -> String {
    let [pass, stopped, fail] = [CaseOutcome::Pass, CaseOutcome::Stopped, CaseOutcome::Fail].map(|o| a.count(o));
    let mut words = vec![];
    if !a.cases.is_empty() {
        let stops = match stopped {
            0 => String::new(),
            1 => ", 1 has no answer and stops with the stated reason".into(),
            n => format!(", {n} have no answer and stop with the stated reason"),
        };
        words.push(format!(
            "Of {} {pass} {}{stops}, {fail} {}.",
            count(a.cases.len(), "case"),
            if pass == 1 { "passes" } else { "pass" },
            if fail == 1 { "fails" } else { "fail" }
        ));
    }
    for map in &a.maps {
        let share = |p: &map::Panel| match p.holds {
            Some(share) => format!("{} {}", p.label, percent(share)),
            None => format!("{} has no judged point", p.label),
        };
        let shares = map.panels.iter().map(share);
        let shares: Vec<String> = shares.collect();
        if !shares.is_empty() {
            words.push(format!(
                "Map {}, share of the judged points with a right answer: {}.",
                map.family,
                shares.join(", ")
            ));
        }
    }
    if words.is_empty() {
        return "No verdict: no case has a result.".into();
    }
    match missing {
        0 => {}
        1 => words.push("One case has no result.".into()),
        _ => words.push(format!("{missing} cases have no result.")),
    }
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::store::record::Series;

    /// A run that converged with a value in its middle that is no number fails, though its end is sound; one that has stopped says why itself.
    #[test]
    fn a_value_in_the_middle_that_is_not_finite_fails_a_run() {
        let (family, setup) = ("suite".to_string(), String::new());
        let suite = SuiteRecord { family, setup, ends: None, checks: vec![] };
        let outcome = |middle: f64, status: &str| {
            let columns = [("x".to_string(), vec![0.0, middle, 1.0])].into();
            let mut case = StoredCase::new(Default::default(), Series { t_s: vec![0.0, 0.5, 1.0], columns });
            case.record.status = status.into();
            let judged = judge(&suite, &case, &[]);
            (judged.outcome, judged.reason)
        };
        assert_eq!(outcome(0.5, "Converged"), (CaseOutcome::Pass, None));
        for strange in [f64::NAN, f64::INFINITY] {
            let why = "x is not finite at t = 0.500000 s".to_string();
            assert_eq!(outcome(strange, "Converged"), (CaseOutcome::Fail, Some(why)));
            assert_eq!(outcome(strange, "StepTooSmall").0, CaseOutcome::Stopped);
        }
    }
}
