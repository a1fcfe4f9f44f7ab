//! The matrix: hard cases downwards, variants across; a disc passes, a triangle stopped with a stated reason, a cross failed.

use crate::report::canvas::{Area, At, INK, LABEL, Mark, PALE, PALETTE, RGB, SMALL, figure, line, mark, mm, text};
use crate::report::figure::{Drawn, Figure, Sample, drawn, legend};
use crate::study::kinds::robustness::analysis::RobustnessFindings;
use crate::study::kinds::robustness::outcome::CaseOutcome;
use crate::study::store::results::Results;

const ROW: f64 = 3.9;
const COLUMN: f64 = 6.2;
/// Room for the names of the cases, and for the turned ones of the variants \[mm\]
const NAMES: f64 = 74.0;
const HEAD: f64 = 43.6;
/// Height of the headings of groups, and of those that would meet their neighbours \[mm\]
const GROUP: f64 = 5.6;
const RAISED: f64 = 2.0;
/// Rows on a sheet; more go into a second block next to it
const TALLEST: usize = 62;

pub fn color(outcome: CaseOutcome) -> (Mark, RGB) {
    match outcome {
        CaseOutcome::Pass => (Mark::Circle, PALETTE[0]),
        CaseOutcome::Stopped => (Mark::Triangle, PALETTE[4]),
        CaseOutcome::Inaccurate | CaseOutcome::Fail => (Mark::Cross, PALETTE[1]),
    }
}

/// `None` without a case. One figure for each sheet of rows.
pub fn draw(store: &Results, a: &RobustnessFindings) -> Vec<Drawn> {
    let mut rows: Vec<(&str, &str)> = vec![];
    for c in &a.cases {
        if !rows.contains(&(c.suite.as_str(), c.member.as_str())) {
            rows.push((&c.suite, &c.member));
        }
    }
    let sheets: Vec<&[(&str, &str)]> = rows.chunks(TALLEST).collect();
    let of = |(k, rows): (usize, &&[(&str, &str)])| drawn("matrix", || sheet(store, a, rows, k, sheets.len()));
    sheets.iter().enumerate().filter_map(of).collect()
}

fn sheet(store: &Results, a: &RobustnessFindings, rows: &[(&str, &str)], number: usize, of: usize) -> Figure {
    let shown = |v: &&String| {
        let here = |c: &&crate::study::kinds::robustness::analysis::JudgedCase| {
            c.variant == **v && rows.contains(&(c.suite.as_str(), c.member.as_str()))
        };
        a.cases.iter().any(|c| here(&c))
    };
    let variants: Vec<&String> = store.study.variants.iter().filter(shown).collect();
    let width = NAMES + COLUMN * variants.len() as f64 + 30.0;
    // The legend has three lines
    let height = HEAD + (ROW * rows.len() as f64).max(14.0) + 4.0;
    let svg = figure(width, height, "", |area| {
        for (k, variant) in variants.iter().enumerate() {
            let x = NAMES + COLUMN * (k as f64 + 0.5);
            let name = store.study.labels.get(*variant).unwrap_or(variant);
            turned(area, name, x);
            line(area, &[(mm(x), mm(HEAD)), (mm(x), mm(height - 4.0))], PALE, 4);
        }
        groups(store, area, &variants);
        let mut before = "";
        for (k, (suite, member)) in rows.iter().enumerate() {
            let y = mm(HEAD + ROW * (k as f64 + 0.5));
            if *suite != before {
                let top = mm(HEAD + ROW * k as f64);
                line(area, &[(0, top), (mm(NAMES + COLUMN * variants.len() as f64), top)], PALE, 4);
                text(area, &suite.replace('-', " "), (mm(0.5), y), At::Left, SMALL, INK);
                before = suite;
            }
            text(area, &store.study.member(&member.replace('-', "_")), (mm(NAMES - 2.0), y), At::Right, SMALL, INK);
            for (j, variant) in variants.iter().enumerate() {
                let found = a.cases.iter().find(|c| c.suite == *suite && c.member == *member && c.variant == **variant);
                if let Some(c) = found {
                    let (shape, color) = color(c.outcome);
                    mark(area, shape, (mm(NAMES + COLUMN * (j as f64 + 0.5)), y), 34, color);
                }
            }
        }
        let entry = |(o, words): (CaseOutcome, &str)| (Sample::Mark(color(o).0, color(o).1), words.to_string());
        let entries =
            [(CaseOutcome::Pass, "pass"), (CaseOutcome::Stopped, "stopped"), (CaseOutcome::Fail, "fail")].map(entry);
        legend(area, (mm(width - 24.0), mm(HEAD + 3.0)), &entries);
    });
    let part = if of > 1 { format!(" (part {} of {of})", number + 1) } else { String::new() };
    let caption = format!(
        "Hard cases{part}: a disc ended as it should and met its references, a triangle has no answer and says why, as is right there, \
         a cross failed. An empty place was not asked for."
    );
    Figure { name: if of > 1 { format!("matrix-{}", number + 1) } else { "matrix".into() }, svg, caption }
}

/// Headings over the columns of a group, with a line across them.
fn groups(store: &Results, area: &Area, variants: &[&String]) {
    let group = |v: &String| store.study.groups.get(v).map(String::as_str);
    let (mut from, mut end, mut is_raised) = (0, i32::MIN, false);
    for run in variants.chunk_by(|a, b| group(a) == group(b)) {
        if let Some(heading) = group(run[0]) {
            let edge = |k: usize| NAMES + COLUMN * k as f64;
            let (left, right) = (mm(edge(from) + 0.8), mm(edge(from + run.len()) - 0.8));
            let (middle, half) = ((left + right) / 2, crate::report::canvas::width(heading, SMALL) / 2);
            is_raised = !is_raised && middle - half < end + mm(1.0);
            line(area, &[(left, mm(GROUP + 2.4)), (right, mm(GROUP + 2.4))], INK, 5);
            text(area, heading, (middle, mm(if is_raised { RAISED } else { GROUP })), At::Middle, SMALL, INK);
            end = middle + half;
        }
        from += run.len();
    }
}

/// Names that are too long for a column stand upright.
fn turned(area: &Area, name: &str, x: f64) {
    let long = crate::report::canvas::width(name, LABEL) / 2;
    text(area, name, (mm(x) + mm(1.2), mm(HEAD - 2.0) - long), At::Turned, LABEL, INK);
}
