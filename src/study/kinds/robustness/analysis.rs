//! Results of scenes that are hard for simulators: the matrix of case × variant, and maps of where a scene can be solved.
//!
//! Pure: stored cases in, [`RobustnessFindings`] out. A case passes when it converges and meets its references; one that converges but has no
//! reference is unchecked. It is stopped when it ends with a stated reason instead of an answer: as demanded, if convergence would be wrong or the
//! limit has a reference, or as accepted. Everything else is a failure: a missed reference, a wrong status at the end, a number that is not finite, a
//! panic, or running out of time.

use crate::report::numbers::percent;
use crate::solve::Status;
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
    /// Reason for a stop or failure
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    pub findings: Vec<CheckResult>,
    pub status: String,
    pub steps: usize,
    /// Iterations, including those of rejected steps
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

    /// Returns the outcome of every case by its id, including the points of maps.
    pub fn outcomes(&self) -> BTreeMap<String, CaseOutcome> {
        let suites = self.cases.iter().map(|c| (c.case.clone(), c.outcome));
        suites.chain(self.maps.iter().flat_map(Map::outcomes)).collect()
    }
}

/// Analyses the stored cases.
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
    // Here a status is a result
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
        let is_it =
            |o: &&StoredCase| o.record.family == r.family && o.record.variant == r.variant && o.record.member == *like;
        // A run that stopped early cannot be a reference at the end, which it did not reach
        stored.iter().find(is_it).filter(|o| o.record.converged() || c.at == check::Moment::Limit)
    };
    // A reference at the end says nothing about a run that did not get there
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
            None => Some("a reference needs what was not recorded, or a run that has no answer".to_string()),
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
        (if found.is_empty() { CaseOutcome::Unchecked } else { CaseOutcome::Pass }, None)
    } else {
        // Ends that include `Converged` accept a stop but do not demand one. In a run that stopped, only the limit is compared
        let demands = |ends: &Vec<String>| ends.iter().all(|end| end != Status::Converged.name());
        let is_demanded = !found.is_empty() || suite.ends.as_ref().is_some_and(demands);
        (if is_demanded { CaseOutcome::Demanded } else { CaseOutcome::Stopped }, Some(detail()))
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

/// The numbers of cases of all suites by outcome, as a sentence.
fn counted(a: &RobustnessFindings) -> String {
    let parts = [
        (CaseOutcome::Pass, "matches its references", "match their references"),
        (CaseOutcome::Unchecked, "converges and has no reference", "converge and have no reference"),
        (CaseOutcome::Demanded, "stops as demanded", "stop as demanded"),
        (
            CaseOutcome::Stopped,
            "stops with a stated reason where that is accepted",
            "stop with a stated reason where that is accepted",
        ),
    ];
    let words = |(outcome, one, more): (CaseOutcome, &str, &str)| match a.count(outcome) {
        0 => None,
        1 => Some(format!("1 {one}")),
        n => Some(format!("{n} {more}")),
    };
    let fail = match a.count(CaseOutcome::Fail) {
        0 => "none fails".into(),
        1 => "1 fails".into(),
        n => format!("{n} fail"),
    };
    let parts: Vec<String> = parts.into_iter().filter_map(words).collect();
    let and = if parts.is_empty() { "" } else { ", and " };
    format!("Of {}, {}{and}{fail}.", count(a.cases.len(), "case"), parts.join(", "))
}

fn verdict(a: &RobustnessFindings, missing: usize) -> String {
    let mut words = vec![];
    if !a.cases.is_empty() {
        words.push(counted(a));
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
    use crate::study::store::record::{REFUSED, Series};
    use crate::study::store::solver_record::StopRecord;
    use CaseOutcome::{Demanded, Fail, Pass, Stopped, Unchecked};

    fn suite(ends: Option<&[&str]>, checks: Vec<Check>) -> SuiteRecord {
        let ends = ends.map(|ends| ends.iter().map(|end| end.to_string()).collect());
        SuiteRecord { family: "suite".into(), setup: String::new(), ends, checks }
    }

    /// A run that ended with this status and these values of x.
    fn case(status: &str, x: [f64; 3]) -> StoredCase {
        let columns = [("x".to_string(), x.to_vec())].into();
        let mut case = StoredCase::new(Default::default(), Series { t_s: vec![0.0, 0.5, 1.0], columns });
        case.record.status = status.into();
        case
    }

    /// A check of x against 1.
    fn check(at: &str) -> Check {
        serde_json::from_value(serde_json::json!({
            "what": "x", "measured": "x", "reference": "1", "at": at, "bound": "both", "accept": 0.01, "source": "a closed form"
        }))
        .expect("a check")
    }

    /// A converged run with a value in the middle that is not finite fails, although its end is sound; one that stopped states its own reason.
    #[test]
    fn a_value_in_the_middle_that_is_not_finite_fails_a_run() {
        let outcome = |middle: f64, status: &str| {
            let judged = judge(&suite(None, vec![]), &case(status, [0.0, middle, 1.0]), &[]);
            (judged.outcome, judged.reason)
        };
        assert_eq!(outcome(0.5, "Converged"), (Unchecked, None));
        for strange in [f64::NAN, f64::INFINITY] {
            let why = "x is not finite at t = 0.500000 s".to_string();
            assert_eq!(outcome(strange, "Converged"), (Fail, Some(why)));
            assert_eq!(outcome(strange, "StepTooSmall").0, Stopped);
        }
    }

    /// Only a run that was compared passes; a stop is demanded if an answer would be wrong or if the limit was compared.
    #[test]
    fn an_outcome_says_whether_anything_was_compared_or_demanded() {
        let outcome = |ends: Option<&[&str]>, at: &[&str], status: &str| {
            let mut case = case(status, [0.0, 0.5, 1.0]);
            let limit = [("x".to_string(), 1.0)].into();
            case.record.solver.stop = Some(StopRecord { limit, ..StopRecord::default() });
            judge(&suite(ends, at.iter().map(|at| check(at)).collect()), &case, &[]).outcome
        };
        let either: Option<&[&str]> = Some(&["Converged", "NoEquilibrium"]);
        for (ends, at, status, right) in [
            (None, &[][..], "Converged", Unchecked),
            (either, &[], "Converged", Unchecked),
            (None, &["end"], "Converged", Pass),
            (None, &["every"], "Converged", Fail),
            (None, &[], "NoEquilibrium", Stopped),
            (either, &[], "NoEquilibrium", Stopped),
            (either, &["end"], "NoEquilibrium", Stopped),
            (either, &["limit"], "NoEquilibrium", Demanded),
            (Some(&["NoEquilibrium"]), &[], "NoEquilibrium", Demanded),
            (Some(&[REFUSED]), &[], REFUSED, Demanded),
            (Some(&[REFUSED]), &[], "Converged", Fail),
            (None, &["end"], "NoEquilibrium", Fail),
            (None, &[], "TimeBudget", Fail),
        ] {
            assert_eq!(outcome(ends, at, status), right, "{status}, ends {ends:?}, checks at {at:?}");
        }
    }

    /// A check against a run that stopped has no reference at its end, even if the numbers agree.
    #[test]
    fn a_run_that_stopped_is_no_reference() {
        let like = Check { reference: None, like: Some("other".into()), ..check("end") };
        let (suite, own) = (suite(None, vec![like]), case("Converged", [0.0, 0.5, 1.0]));
        for (status, right) in [("Converged", Pass), ("StepTooSmall", Fail)] {
            let mut other = case(status, [0.0, 0.5, 1.0]);
            other.record.member = "other".into();
            assert_eq!(judge(&suite, &own, &[other]).outcome, right, "{status}");
        }
    }

    #[test]
    fn the_verdict_counts_every_outcome_apart() {
        let of = |outcomes: &[CaseOutcome]| {
            let judged = |o: &CaseOutcome| JudgedCase {
                outcome: *o,
                ..judge(&suite(None, vec![]), &case("Converged", [0.0; 3]), &[])
            };
            let cases = outcomes.iter().map(judged).collect();
            verdict(&RobustnessFindings { suites: vec![], cases, maps: vec![] }, 0)
        };
        assert_eq!(
            of(&[Pass, Unchecked, Unchecked, Demanded, Stopped, Stopped]),
            "Of 6 cases, 1 matches its references, 2 converge and have no reference, 1 stops as demanded, \
             2 stop with a stated reason where that is accepted, and none fails."
        );
        assert_eq!(of(&[Pass, Fail]), "Of 2 cases, 1 matches its references, and 1 fails.");
        assert_eq!(of(&[Fail, Fail]), "Of 2 cases, 2 fail.");
    }
}
