//! The matrix: hard cases downwards, variants across. A disc matches its references, a ring has none; a triangle stopped with a stated reason
//! (pointing up if demanded, down if accepted); a cross failed.

use crate::report::canvas::{
    Area, At, INK, LABEL, Mark, PALE, PALETTE, RGB, SMALL, block, figure, line, mark, mm, page_height, page_width, text,
};
use crate::report::figure::{Drawn, Figure, LINE, Sample, drawn, legend_below, legend_lines, numbered};
use crate::report::measure::{shortened, width};
use crate::study::case_outcome::CaseOutcome;
use crate::study::kinds::robustness::analysis::{JudgedCase, RobustnessFindings};
use crate::study::store::results::Results;

const ROW: f64 = 3.9;
const COLUMN: f64 = 6.2;
/// Height for the rotated names of the variants \[mm\]
const HEAD: f64 = 43.6;
/// Height of the group headings, and extra height of those that would overlap their neighbours \[mm\]
const GROUP: f64 = 5.6;
const RAISED: f64 = 2.0;
/// Height of the legend without its lines \[mm\]
const FOOT: f64 = 4.8;
/// Width at which the legend has two columns, and its largest number of lines then: five outcomes \[mm\]
const LEAST_WIDE: f64 = 86.0;
const MOST_LINES: f64 = 3.0;
/// Smallest number of cases that makes a matrix
const LEAST: usize = 4;
/// Background of the heading of a suite
const BAND: RGB = RGB(0xf0, 0xf0, 0xf0);

fn look(outcome: CaseOutcome) -> (Mark, RGB, &'static str) {
    match outcome {
        CaseOutcome::Pass => (Mark::Circle, PALETTE[0], "matches references"),
        CaseOutcome::Unchecked => (Mark::Ring, PALETTE[5], "no reference"),
        CaseOutcome::Demanded => (Mark::Triangle, PALETTE[2], "stops as demanded"),
        CaseOutcome::Stopped => (Mark::Down, PALETTE[4], "stops as is accepted"),
        CaseOutcome::Inaccurate | CaseOutcome::Fail => (Mark::Cross, PALETTE[1], "fails"),
    }
}

/// A line of a sheet: the heading of a suite or one of its cases.
#[derive(Clone, Copy, PartialEq)]
struct Line<'a> {
    suite: &'a str,
    member: Option<&'a str>,
}

/// Draws one figure for each sheet of lines and columns; nothing for fewer than four cases, which the table lists.
pub fn draw(store: &Results, a: &RobustnessFindings) -> Vec<Drawn> {
    if a.cases.len() < LEAST {
        return vec![];
    }
    let mut cases: Vec<(&str, &str)> = vec![];
    for c in &a.cases {
        if !cases.contains(&(c.suite.as_str(), c.member.as_str())) {
            cases.push((&c.suite, &c.member));
        }
    }
    let room = page_height() - HEAD - FOOT - LINE * MOST_LINES;
    let pages = pages(&cases, (room / ROW).floor().max(2.0) as usize);
    let name = |l: &Line| l.member.map_or(0, |m| width(&written(store, m), SMALL));
    let names = f64::from(pages.iter().flatten().map(name).max().unwrap_or(0)) / f64::from(mm(1.0)) + 6.0;
    let across = ((page_width() - names - 3.0) / COLUMN).floor().max(1.0) as usize;
    let shown = |lines: &[Line], v: &&String| {
        let here = |c: &JudgedCase| lines.contains(&Line { suite: &c.suite, member: Some(&c.member) });
        a.cases.iter().any(|c| c.variant == **v && here(c))
    };
    let mut sheets: Vec<(&[Line], Vec<&String>)> = vec![];
    for lines in pages.iter().map(Vec::as_slice) {
        let variants: Vec<&String> = store.study.variants.iter().filter(|v| shown(lines, v)).collect();
        sheets.extend(variants.chunks(across).map(|variants| (lines, variants.to_vec())));
    }
    let of = |(k, (lines, variants)): (usize, &(&[Line], Vec<&String>))| {
        drawn("matrix", || sheet(store, a, (lines, variants, names), k, sheets.len()))
    };
    sheets.iter().enumerate().filter_map(of).collect()
}

/// Distributes the cases, as (suite, case) in order, under the headings of their suites over sheets of at most `tallest` lines. A suite stays on one
/// sheet, or continues under a repeated heading if it is longer.
fn pages<'a>(cases: &[(&'a str, &'a str)], tallest: usize) -> Vec<Vec<Line<'a>>> {
    let mut pages: Vec<Vec<Line>> = vec![];
    for part in cases.chunk_by(|a, b| a.0 == b.0).flat_map(|suite| suite.chunks(tallest - 1)) {
        let heading = Line { suite: part[0].0, member: None };
        let own = std::iter::once(heading).chain(part.iter().map(|(suite, case)| Line { suite, member: Some(case) }));
        match pages.last_mut() {
            Some(page) if page.len() + part.len() < tallest => page.extend(own),
            _ => pages.push(own.collect()),
        }
    }
    pages
}

/// The name of a case in words; the sign of an exponent is kept: `dt 1e−3`.
fn written(store: &Results, member: &str) -> String {
    let letters: Vec<char> = member.chars().collect();
    let is_sign = |k: usize| {
        k > 1
            && letters[k - 1] == 'e'
            && letters[k - 2].is_ascii_digit()
            && letters.get(k + 1).is_some_and(char::is_ascii_digit)
    };
    let word = |(k, c): (usize, &char)| match c {
        '-' if is_sign(k) => '−',
        '-' => '_',
        c => *c,
    };
    store.study.member(&letters.iter().enumerate().map(word).collect::<String>())
}

fn sheet(
    store: &Results,
    a: &RobustnessFindings,
    (lines, variants, names): (&[Line], &[&String], f64),
    number: usize,
    of: usize,
) -> Figure {
    let edge = |k: f64| mm(names + COLUMN * k);
    let bottom = HEAD + ROW * lines.len() as f64;
    let right = edge(variants.len() as f64);
    let entry = |o: CaseOutcome| {
        let (shape, color, words) = look(o);
        (Sample::Mark(shape, color), words.to_string())
    };
    let entries: Vec<_> = CaseOutcome::ALL.into_iter().filter(|o| a.count(*o) > 0).map(entry).collect();
    let wide = (names + COLUMN * variants.len() as f64 + 3.0).max(LEAST_WIDE);
    let across = wide - 4.0;
    let svg = figure(wide, bottom + FOOT + LINE * legend_lines(&entries, across), "", |area| {
        for (k, variant) in variants.iter().enumerate() {
            let name = store.study.labels.get(*variant).unwrap_or(variant);
            turned(area, name, names + COLUMN * (k as f64 + 0.5));
            line(area, &[(edge(k as f64 + 0.5), mm(HEAD)), (edge(k as f64 + 0.5), mm(bottom))], PALE, 4);
        }
        groups(store, area, variants, names);
        for (k, l) in lines.iter().enumerate() {
            let (top, y) = (mm(HEAD + ROW * k as f64), mm(HEAD + ROW * (k as f64 + 0.5)));
            let Some(member) = l.member else {
                block(area, (0, top), (right, mm(HEAD + ROW * (k as f64 + 1.0))), BAND);
                let heading = shortened(&l.suite.replace('-', " "), SMALL, mm(wide - 1.6));
                text(area, &heading, (mm(0.8), y), At::Left, SMALL, INK);
                continue;
            };
            text(area, &written(store, member), (mm(names - 2.0), y), At::Right, SMALL, INK);
            for (j, variant) in variants.iter().enumerate() {
                let is_it = |c: &&JudgedCase| c.suite == l.suite && c.member == member && c.variant == **variant;
                if let Some(c) = a.cases.iter().find(is_it) {
                    let (shape, color, _) = look(c.outcome);
                    mark(area, shape, (edge(j as f64 + 0.5), y), 34, color);
                }
            }
        }
        legend_below(area, (2.0, bottom + 5.0), across, entries);
    });
    let (name, part) = numbered("matrix", number, of);
    let caption = format!(
        "Hard cases{part}: a disc converged and matches its references; a ring converged and has none, so that nothing is said of its answer; a \
         triangle has no answer and says why, upright where the suite demands that, on its tip where it accepts that; a cross failed. An empty \
         place was not asked for."
    );
    Figure { name, svg, caption }
}

/// Draws headings over the columns of each group, underlined across the group.
fn groups(store: &Results, area: &Area, variants: &[&String], names: f64) {
    let group = |v: &String| store.study.groups.get(v).map(String::as_str);
    let (mut from, mut end, mut is_raised) = (0, i32::MIN, false);
    for run in variants.chunk_by(|a, b| group(a) == group(b)) {
        if let Some(heading) = group(run[0]) {
            let edge = |k: usize| names + COLUMN * k as f64;
            let (left, right) = (mm(edge(from) + 0.8), mm(edge(from + run.len()) - 0.8));
            let (middle, half) = ((left + right) / 2, width(heading, SMALL) / 2);
            is_raised = !is_raised && middle - half < end + mm(1.0);
            line(area, &[(left, mm(GROUP + 2.4)), (right, mm(GROUP + 2.4))], INK, 5);
            text(area, heading, (middle, mm(if is_raised { RAISED } else { GROUP })), At::Middle, SMALL, INK);
            end = middle + half;
        }
        from += run.len();
    }
}

/// Draws a name that is too long for its column vertically.
fn turned(area: &Area, name: &str, x: f64) {
    let name = shortened(name, LABEL, mm(HEAD - GROUP - 4.5));
    let long = width(&name, LABEL) / 2;
    text(area, &name, (mm(x) + mm(1.2), mm(HEAD - 2.0) - long), At::Turned, LABEL, INK);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_case_is_without_the_heading_of_its_suite() {
        let names: Vec<String> = (0..200).map(|k| format!("case {k}")).collect();
        let suite = |k: usize| {
            if k < 50 {
                "a"
            } else if k < 65 {
                "b"
            } else {
                "c"
            }
        };
        let cases: Vec<(&str, &str)> = names.iter().enumerate().map(|(k, n)| (suite(k), n.as_str())).collect();
        let pages = pages(&cases, 62);
        let shown = pages.iter().flatten().filter_map(|l| Some((l.suite, l.member?)));
        assert_eq!(shown.collect::<Vec<_>>(), cases);
        for page in &pages {
            assert!(page.len() <= 62 && page[0].member.is_none());
            assert!(page.windows(2).all(|w| w[1].suite == w[0].suite || w[1].member.is_none()));
        }
        let of_b = |page: &&Vec<Line>| page.iter().any(|l| l.suite == "b");
        assert_eq!(pages.iter().filter(of_b).count(), 1);
    }
}
