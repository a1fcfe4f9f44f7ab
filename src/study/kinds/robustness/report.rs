//! Report of a robustness study: the matrix, every reference, the maps.

use crate::report::figure::drawn;
use crate::report::numbers::measured;
use crate::report::table::{Table, headings};
use crate::study::analysis::Analysis;
use crate::study::case_outcome::CaseOutcome;
use crate::study::content::Content;
use crate::study::kinds::robustness::analysis::{JudgedCase, RobustnessFindings};
use crate::study::kinds::robustness::check::CheckResult;
use crate::study::kinds::robustness::figures::failed;
use crate::study::kinds::robustness::figures::matrix;
use crate::study::kinds::robustness::figures::region;
use crate::study::kinds::robustness::map::{Grade, Map};
use crate::study::store::results::Results;
use crate::study::tables;
use serde_json::{Map as Json, json};

pub fn content(store: &Results, a: &Analysis<RobustnessFindings>) -> Content {
    let mut analysis = Json::new();
    analysis.insert("cases".into(), json!(a.cases));
    analysis.insert("maps".into(), json!(a.maps));
    analysis.insert("incomplete".into(), json!(a.incomplete));
    let maps = a.maps.iter().filter(|m| m.panels.iter().any(|p| !p.points.is_empty()));
    let outcomes = a.outcomes();
    // Cases that converge without a reference support nothing
    let is_tested = outcomes.values().any(|o| !matches!(o, CaseOutcome::Unchecked | CaseOutcome::Stopped));
    let fails = outcomes.values().any(|o| *o == CaseOutcome::Fail);
    let supported = is_tested && !fails && a.incomplete.is_empty();
    Content {
        facts: facts(a),
        sentences: a.suites.iter().filter_map(|s| sentence(a, &s.family, &s.setup)).chain(words_of_maps(a)).collect(),
        analysis,
        tables: [refusals(a), table_of_maps(a)].into_iter().filter(|t| !t.rows.is_empty()).collect(),
        folded: vec![("Every hard case", every(a)), ("Every case", tables::cases(store))],
        figures: matrix::draw(store, a)
            .into_iter()
            .chain(maps.filter_map(|map| drawn("map", || region::draw(map))))
            .chain(drawn("failed", || failed::draw(store, a)))
            .collect(),
        decisions: outcomes.iter().map(|(case, outcome)| (case.clone(), outcome.name().into())).collect(),
        outcomes,
        ..Content::new(a, supported, ("References", references(a)))
    }
}

fn facts(a: &RobustnessFindings) -> Vec<(String, String)> {
    let outcomes = [
        (CaseOutcome::Pass, "match their references"),
        (CaseOutcome::Unchecked, "converge and have no reference"),
        (CaseOutcome::Demanded, "stop as demanded"),
        (CaseOutcome::Stopped, "stop with a stated reason, as is accepted"),
        (CaseOutcome::Fail, "fail"),
    ];
    let counts = outcomes.into_iter().map(|(o, words)| (a.count(o).to_string(), words.to_string()));
    let findings: usize = a.cases.iter().map(|c| c.findings.len()).sum();
    let mut out: Vec<_> = if a.cases.is_empty() { vec![] } else { counts.collect() };
    if findings > 0 {
        out.push((findings.to_string(), "comparisons with a reference".into()));
    }
    out
}

/// The result of a suite in words.
fn sentence(a: &RobustnessFindings, suite: &str, setup: &str) -> Option<String> {
    let own: Vec<&JudgedCase> = a.cases.iter().filter(|c| c.suite == suite).collect();
    let count = |o: CaseOutcome| own.iter().filter(|c| c.outcome == o).count();
    if own.is_empty() {
        return None;
    }
    let worst = own.iter().flat_map(|c| &c.findings).filter(|f| f.accept > 0.0 && f.error.is_finite());
    let worst = worst.max_by(|x, y| (x.error / x.accept).total_cmp(&(y.error / y.accept)));
    let near = worst.map_or(String::new(), |f| {
        let [error, accept] = [format!("{:.1e}", f.error), format!("{:.0e}", f.accept)].map(|n| n.replace('-', "−"));
        format!("; nearest to its bound: {}, error {error} of {accept} accepted", f.what)
    });
    let outcomes = CaseOutcome::ALL.map(|o| (count(o), o.name())).into_iter().filter(|(n, _)| *n > 0);
    let parts: Vec<String> = outcomes.map(|(n, name)| format!("{n} {name}")).collect();
    Some(format!("{}: {setup} {}{near}.", suite.replace('-', " "), parts.join(", ")))
}

fn words_of_maps(a: &RobustnessFindings) -> impl Iterator<Item = String> {
    a.maps.iter().filter(|m| m.panels.iter().any(|p| !p.points.is_empty())).map(|m| {
        let counts = m.panels.iter().map(|p| {
            let n = |g: Grade| p.points.iter().filter(|q| q.grade == g).count();
            let parts = [
                (n(Grade::Right), "right"),
                (n(Grade::Reference), "the reference"),
                (n(Grade::Unjudged), "without a reference"),
                (n(Grade::Poor), "poor"),
                (n(Grade::Wrong), "silently wrong"),
                (n(Grade::Stated), "stopped with a status"),
                (n(Grade::Broken), "not finite"),
            ];
            let parts: Vec<String> = parts.iter().filter(|(n, _)| *n > 0).map(|(n, w)| format!("{n} {w}")).collect();
            format!("{}: {}", p.label, parts.join(", "))
        });
        let counts: Vec<String> = counts.collect();
        format!("Map {}: {} Of {} points each, {}.", m.family, m.setup, m.panels[0].points.len(), counts.join("; "))
    })
}

/// Writes a number with five digits, whatever its size.
fn plain(x: f64) -> String {
    if x == 0.0 || (1e-3..1e5).contains(&x.abs()) { format!("{x:.5}") } else { format!("{x:.4e}") }
}

fn references(a: &RobustnessFindings) -> Table {
    let row = |c: &JudgedCase, f: &CheckResult| {
        vec![
            c.case.clone(),
            f.what.clone(),
            plain(f.measured),
            plain(f.reference),
            format!("{:.1e}", f.error),
            format!("{:.0e}", f.accept),
            f.source.clone(),
        ]
    };
    Table {
        name: "references",
        caption: "Every number that has a reference: where its error is largest, what was measured and what is right, the error \
                  over the size of the reference, and what is accepted."
            .into(),
        columns: headings(&[
            ("Case", "", false),
            ("Quantity", "", false),
            ("Measured", "", true),
            ("Reference", "", true),
            ("Error", "", true),
            ("Accepted", "", true),
            ("Source", "", false),
        ]),
        rows: a.cases.iter().flat_map(|c| c.findings.iter().map(move |f| row(c, f))).collect(),
        pick: None,
    }
}

fn refusals(a: &RobustnessFindings) -> Table {
    let stated = a.cases.iter().filter(|c| c.reason.is_some());
    let row = |c: &JudgedCase| {
        let outcome = c.outcome.name().to_string();
        vec![c.case.clone(), outcome, c.status.clone(), c.reason.clone().unwrap_or_default()]
    };
    Table {
        name: "refusals",
        caption: "What has no answer, and why: as the suite demands, as it accepts, or as a failure.".into(),
        columns: headings(&[("Case", "", false), ("Outcome", "", false), ("Status", "", false), ("Reason", "", false)]),
        rows: stated.map(row).collect(),
        pick: None,
    }
}

fn every(a: &RobustnessFindings) -> Table {
    let row = |c: &JudgedCase| {
        let setup = a.suites.iter().find(|s| s.family == c.suite).map_or("", |s| &s.setup);
        vec![
            c.case.clone(),
            setup.to_string(),
            c.outcome.name().into(),
            c.status.clone(),
            c.steps.to_string(),
            c.newton_iterations.to_string(),
            c.cuts.to_string(),
            measured(c.wall_s),
        ]
    };
    Table {
        name: "hard-cases",
        caption: "Every case with its set-up and its cost.".into(),
        columns: headings(&[
            ("Case", "", false),
            ("Set-up", "", false),
            ("Outcome", "", false),
            ("Status", "", false),
            ("Steps", "", true),
            ("Newton", "", true),
            ("Cuts", "", true),
            ("Wall", "s", true),
        ]),
        rows: a.cases.iter().map(row).collect(),
        pick: None,
    }
}

fn table_of_maps(a: &RobustnessFindings) -> Table {
    let rows = a.maps.iter().flat_map(|m: &Map| {
        m.panels.iter().flat_map(move |p| {
            // A column that consists of references has no answers to count
            let judged = move |x: usize| p.points.iter().any(|q| q.at[0] == x && q.grade != Grade::Reference);
            (m.axes[0].values.iter().enumerate()).filter(move |(x, _)| judged(*x)).map(move |(x, value)| {
                let here: Vec<_> = p.points.iter().filter(|q| q.at[0] == x && q.grade != Grade::Reference).collect();
                let right = here.iter().filter(|q| q.grade == Grade::Right).count();
                vec![
                    m.family.clone(),
                    p.label.clone(),
                    format!("{} = {value}", m.axes[0].symbol),
                    format!("{right} of {}", here.len()),
                    format!("{:.2}", p.iterations[x]),
                    format!("{:.2}", p.cuts[x]),
                ]
            })
        })
    });
    Table {
        name: "maps",
        caption: "Along the first axis of each map: points with a right answer, of those that are not the reference, Newton iterations per step and cuts per run, means \
                  over the other axis."
            .into(),
        columns: headings(&[
            ("Map", "", false),
            ("Step", "", false),
            ("At", "", false),
            ("Right", "", false),
            ("Iterations per step", "", true),
            ("Cuts", "", true),
        ]),
        rows: rows.collect(),
        pick: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_have_minus_signs_and_words_their_hyphens() {
        let finding = CheckResult {
            what: "free-edge angle".into(),
            source: String::new(),
            measured: 1.0,
            reference: 1.0,
            error: 2.5e-7,
            accept: 1e-3,
            met: true,
        };
        let case = JudgedCase {
            case: "plate".into(),
            suite: "thin-plates".into(),
            member: String::new(),
            variant: String::new(),
            outcome: CaseOutcome::Pass,
            reason: None,
            findings: vec![finding],
            status: String::new(),
            steps: 1,
            newton_iterations: 1,
            cuts: 0,
            wall_s: 1.0,
        };
        let found = RobustnessFindings { suites: vec![], cases: vec![case], maps: vec![] };
        let words = sentence(&found, "thin-plates", "A one-edge-held plate.").expect("a case");
        let near = "nearest to its bound: free-edge angle, error 2.5e−7 of 1e−3 accepted.";
        assert_eq!(words, format!("thin plates: A one-edge-held plate. 1 pass; {near}"));
    }
}
