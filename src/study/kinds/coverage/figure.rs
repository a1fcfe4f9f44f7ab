//! The ratio of bar to true error for every error bar, problem by problem.

use crate::report::canvas::{
    At, INK, Mark as Shape, PALE, RGB, SMALL, dashed, figure, line, mark, mm, page_width, text,
};
use crate::report::figure::{Figure, LINE, Sample, legend_below, legend_lines, style};
use crate::report::measure::width;
use crate::report::names::title;
use crate::report::panels::letter;
use crate::report::plot::{Axis, Plot};
use crate::study::analysis::Analysis;
use crate::study::kinds::coverage::analysis::CoverageFindings;
use crate::study::kinds::coverage::mark::{Estimator, Mark, Standing};

const LEFT: f64 = 14.0;
const TOP: f64 = 7.0;
const TALL: f64 = 62.0;
const GAP: f64 = 14.0;
const RIGHT: f64 = 4.0;
const GREY: RGB = RGB(0xc4, 0xc4, 0xc4);
/// Smallest and largest ratio that is drawn; ratios beyond are drawn at the edge.
const LEAST: f64 = 0.1;
const MOST: f64 = 1000.0;

/// Draws the ratios; `None` without a bar.
pub fn draw(a: &Analysis<CoverageFindings>) -> Option<Figure> {
    let (mut problems, mut formulations): (Vec<&str>, Vec<&str>) = (vec![], vec![]);
    for m in &a.marks {
        if !problems.contains(&m.problem.as_str()) {
            problems.push(&m.problem);
        }
        if !formulations.contains(&m.formulation.as_str()) {
            formulations.push(&m.formulation);
        }
    }
    if problems.is_empty() {
        return None;
    }
    let mut entries: Vec<(Sample, String)> = (formulations.iter().enumerate())
        .map(|(k, f)| {
            let (shape, color) = style(k);
            (Sample::Mark(shape, color), title(f))
        })
        .collect();
    entries.push((Sample::Mark(Shape::Circle, GREY), "truth uncertain".into()));
    entries.push((Sample::Mark(Shape::Cross, GREY), "refused".into()));
    let names = f64::from(problems.iter().map(|p| width(p, SMALL)).max().unwrap_or(0)) / f64::from(mm(1.0));
    let bottom = TOP + 2.0 * TALL + GAP;
    let below = bottom + names + 7.0;
    let wide = page_width() - RIGHT - LEFT;
    let height = below + LINE * legend_lines(&entries, wide);
    let svg = figure(page_width(), height, "", |area| {
        for (k, estimator) in Estimator::ALL.into_iter().enumerate() {
            let top = TOP + k as f64 * (TALL + GAP);
            let frame = [mm(LEFT), mm(top), mm(LEFT + wide), mm(top + TALL)];
            let x = Axis { step: 1.0, ..Axis::exact(0.0, problems.len() as f64, "") };
            let y =
                Axis { lo: LEAST / 1.3, hi: MOST * 1.3, ..Axis::log([LEAST, MOST].into_iter(), "bar / true error") };
            let plot = Plot { area, frame, x, y };
            plot.grid();
            for k in 1..problems.len() {
                line(area, &[plot.at(k as f64, LEAST / 1.3), plot.at(k as f64, MOST * 1.3)], PALE, 3);
            }
            let own = |m: &&Mark| m.estimator == estimator;
            for grey in [true, false] {
                let shown = a
                    .marks
                    .iter()
                    .filter(own)
                    .filter(|m| matches!(m.standing, Standing::TruthUncertain | Standing::Refused) == grey);
                for m in shown {
                    let (shape, color) = look(m, &formulations);
                    mark(area, shape, plot.at(place(m, &problems, &a.marks), m.ratio().clamp(LEAST, MOST)), 13, color);
                }
            }
            dashed(area, &[plot.at(0.0, 1.0), plot.at(problems.len() as f64, 1.0)], INK, 6, 22.0);
            plot.axes(false);
            plot.title(letter(k, Estimator::ALL.len()), estimator.words());
        }
        let strip = wide / problems.len() as f64;
        for (k, name) in problems.iter().enumerate() {
            let at = (mm(LEFT + strip * (k as f64 + 0.5)) + mm(1.2), mm(bottom + 2.0) + width(name, SMALL) / 2);
            text(area, name, at, At::Turned, SMALL, INK);
        }
        legend_below(area, (LEFT, below - 1.0), wide, entries);
    });
    let caption = "Error bar over true error, (a) from one run, (b) of the finest mesh of a family of many. Below 1 the truth is outside of \
                   the bar. Within a problem from left to right: ν in the order of the study. Grey: the truth is not known to a tenth of the \
                   bar. Grey crosses: a study refuses the family, which diverges, locks, or does not resolve the thinnest wall."
        .into();
    Some(Figure { name: "coverage".into(), svg, caption })
}

fn look(m: &Mark, formulations: &[&str]) -> (Shape, RGB) {
    let k = formulations.iter().position(|f| *f == m.formulation).unwrap_or(0);
    match m.standing {
        Standing::Counted => style(k),
        Standing::TruthUncertain => (Shape::Circle, GREY),
        Standing::Refused => (Shape::Cross, GREY),
    }
}

/// The position in the strip of its problem, grouped by material and then in the order of the bars.
fn place(m: &Mark, problems: &[&str], all: &[Mark]) -> f64 {
    let k = problems.iter().position(|p| *p == m.problem).unwrap_or(0);
    let own: Vec<&Mark> = all.iter().filter(|o| o.problem == m.problem && o.estimator == m.estimator).collect();
    let at = own.iter().position(|o| std::ptr::eq(*o, m)).unwrap_or(0);
    k as f64 + 0.06 + 0.88 * (at as f64 + 0.5) / own.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulations_differ_without_colour() {
        let names = ["tet4", "tet10", "tet4_up", "tet10_up", "tet10_p0"];
        let shapes: Vec<Shape> = (0..names.len()).map(|k| style(k).0).collect();
        assert!(shapes.iter().enumerate().all(|(k, shape)| !shapes[..k].contains(shape) && *shape != Shape::Cross));
    }
}
