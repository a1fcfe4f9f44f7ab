//! Growth of time and memory with the number of cells: fitted laws, and the prediction for twice the largest number of cells.

use crate::report::canvas::{At, PALETTE, SMALL, dashed, figure, hollow, line, mark, mm, text};
use crate::report::figure::{Figure, Sample, legend_below, legend_lines, style};
use crate::report::names::title;
use crate::report::numbers::with_error;
use crate::report::panels::{Panels, letter};
use crate::report::plot::{Axis, Plot};
use crate::study::kinds::cost::findings::{CostFindings, Grows, GrowthLaw};
use crate::study::store::results::Results;

const LEFT: f64 = 15.0;
const EACH: f64 = 70.0;
const GAP: f64 = 18.0;
const TOP: f64 = 6.0;
const TALL: f64 = 50.0;
/// Height from one row of panels to the next \[mm\]
const ROW: f64 = TALL + 19.0;
/// Smallest width of a panel \[mm\]
const LEAST: f64 = 60.0;

/// Draws the growth laws of a variant; `None` if it has none. The figure is named after its variant if several variants have laws.
pub fn draw(store: &Results, a: &CostFindings, variant: &str) -> Option<Figure> {
    let laws: Vec<&GrowthLaw> = a.growth.iter().filter(|l| l.variant == variant).collect();
    if laws.is_empty() {
        return None;
    }
    let is_only = laws.len() == a.growth.len();
    let mut formulations: Vec<&str> = laws.iter().map(|l| l.formulation.as_str()).collect();
    formulations.dedup();
    let unit = |l: &GrowthLaw| if l.of == Grows::Time { 1.0 } else { 1e-6 };
    let look =
        |l: &GrowthLaw| style(formulations.iter().position(|f| *f == l.formulation).unwrap_or(0) % PALETTE.len());
    let kinds: Vec<Grows> =
        [Grows::Time, Grows::Memory].into_iter().filter(|k| laws.iter().any(|l| l.of == *k)).collect();
    let panels = Panels::new(kinds.len(), (LEFT, GAP, 5.0), (LEAST, EACH));
    let wide = panels.width();
    let bottom = TOP + TALL + (panels.rows() - 1.0) * ROW + 14.5;
    let entry = |(k, name): (usize, &&str)| {
        let (m, c) = style(k % PALETTE.len());
        (Sample::Mark(m, c), title(name))
    };
    let entries: Vec<(Sample, String)> = formulations.iter().enumerate().map(entry).collect();
    let svg = figure(wide, bottom + 4.2 * legend_lines(&entries, wide - LEFT), "", |area| {
        for (k, kind) in kinds.iter().enumerate() {
            let own: Vec<&&GrowthLaw> = laws.iter().filter(|l| l.of == *kind).collect();
            let (label, heading) = match kind {
                Grows::Time => ("CPU time [s]", "Time of a case"),
                Grows::Memory => ("largest resident set [MB]", "Memory"),
            };
            let frame = panels.frame(k, (TOP, ROW), TALL).map(mm);
            let x = Axis::log(own.iter().flat_map(|l| l.points.iter().map(|p| p.0).chain([l.next_cells])), "cells");
            // Measured values and the ends of the lines
            let value = |l: &GrowthLaw| {
                let ends = [l.points[0].0, l.points[l.points.len() - 1].0].map(|n| l.law.at(n));
                let all = l.points.iter().map(|p| p.1).chain(ends).chain([l.next.value]);
                all.map(|v| v * unit(l)).collect::<Vec<_>>()
            };
            let all: Vec<f64> = own.iter().flat_map(|l| value(l)).collect();
            // Headroom for one line of text per law
            let most = all.iter().copied().fold(0.0, f64::max);
            let least = all.iter().copied().fold(f64::INFINITY, f64::min);
            let room = most * (most / least).powf(0.09 * own.len() as f64);
            let plot = Plot { area, frame, x, y: Axis::log(all.into_iter().chain([room]), label) };
            plot.grid();
            for (row, l) in own.iter().enumerate() {
                let (shape, color) = look(l);
                let at = |n: f64| plot.at(n, unit(l) * l.law.at(n));
                let (first, last) = (l.points[0].0, l.points[l.points.len() - 1].0);
                line(area, &[at(first), at(last)], color, 7);
                let next = plot.at(l.next_cells, unit(l) * l.next.value);
                dashed(area, &[at(last), next], color, 7, 25.0);
                for (n, v) in &l.points {
                    mark(area, shape, plot.at(*n, unit(l) * v), 24, color);
                }
                hollow(area, shape, next, 24, color);
                let words = format!("{}: exponent {}", title(&l.formulation), with_error(l.law.q, l.law.half));
                text(area, &words, (frame[0] + 40, frame[1] + 60 + 85 * row as i32), At::Left, SMALL, color);
            }
            plot.axes(true);
            plot.title(letter(k, kinds.len()), heading);
        }
        legend_below(area, (LEFT, bottom), wide - LEFT, entries);
    });
    let caption = format!(
        "Growth with the cells, {}: measured (full marks), fitted power law with the 95 % interval of its exponent, and what is expected \
         of twice the most cells before anything is run there (hollow): by the law, but no less than what was measured.",
        store.study.label(variant)
    );
    let name = if is_only { "growth".into() } else { format!("growth-{variant}") };
    Some(Figure { name, svg, caption })
}
