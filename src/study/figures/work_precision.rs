//! Work–precision diagrams: errors of settings against their cost with the Pareto front, and two levels for comparison.

use crate::report::canvas::{GREY, INK, Mark, Point, RGB, dashed, fill, italic, line, mark};
use crate::report::figure::{Sample, UNRESOLVED};
use crate::report::plot::Plot;
use plotters::style::Color;

/// A case with its cost and its error.
pub struct CostPoint {
    pub cost: f64,
    /// Error \[%\]
    pub error: f64,
    /// The error including U(f*) \[%\]
    pub bar: f64,
    pub look: (Mark, RGB),
    /// Whether it can be on the front
    pub may_be_chosen: bool,
}

/// Draws the grid and two levels \[%\]: errors below U(f*) are not resolved, and errors below the tolerance are acceptable.
pub fn levels(plot: &Plot, uncertainty: Option<f64>, tolerance: f64) {
    if let Some(u) = uncertainty.filter(|u| *u > plot.y.lo) {
        let (a, b) = (plot.at(plot.x.lo, u.min(plot.y.hi)), plot.at(plot.x.hi, plot.y.lo));
        fill(plot.area, &[a, (b.0, a.1), b, (a.0, b.1)], UNRESOLVED.to_rgba());
    }
    plot.grid();
    dashed(plot.area, &[plot.at(plot.x.lo, tolerance), plot.at(plot.x.hi, tolerance)], INK, 7, 25.0);
}

/// Legend entries of the two levels.
pub fn level_entries() -> [(Sample, String); 2] {
    [(Sample::Dashed(INK), "tolerance".into()), (Sample::Block(UNRESOLVED), format!("below U({})", italic("f*")))]
}

/// The settings whose error no cheaper one undercuts, cheapest first.
fn front(settings: &[CostPoint]) -> Vec<&CostPoint> {
    let mut front: Vec<&CostPoint> = settings.iter().filter(|s| s.may_be_chosen).collect();
    front.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut best = f64::INFINITY;
    front.retain(|s| {
        let is_better = s.error < best;
        best = best.min(s.error);
        is_better
    });
    front
}

/// Draws the front as a staircase, and each setting with the whisker of its error bar.
pub fn draw(plot: &Plot, settings: &[CostPoint]) {
    let area = plot.area;
    let place = |s: &CostPoint| plot.floored(s.cost, s.error);
    let mut stairs: Vec<Point> = vec![];
    for p in front(settings).into_iter().map(place) {
        stairs.extend(stairs.last().map(|last| (p.0, last.1)));
        stairs.push(p);
    }
    stairs.extend(stairs.last().map(|last| (plot.frame[2], last.1)));
    line(area, &stairs, GREY, 8);
    // An error bar below the axis is not drawn
    for s in settings.iter().filter(|s| s.bar > plot.y.lo) {
        let (end, color) = (plot.at(s.cost, s.bar), s.look.1);
        line(area, &[place(s), end], color, 4);
        line(area, &[(end.0 - 14, end.1), (end.0 + 14, end.1)], color, 4);
    }
    for s in settings {
        mark(area, s.look.0, place(s), 26, s.look.1);
    }
}

/// Legend entries of the front and the levels.
pub fn entries() -> impl Iterator<Item = (Sample, String)> {
    std::iter::once((Sample::Line(GREY), "Pareto front".into())).chain(level_entries())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::figure::style;

    #[test]
    fn the_front_has_what_no_cheaper_setting_beats() {
        let setting = |(cost, error, may_be_chosen): (f64, f64, bool)| {
            let look = style(0);
            CostPoint { cost, error, bar: error, look, may_be_chosen }
        };
        let settings = [
            (8.0, 1.0, true),
            (1.0, 9.0, true),
            (3.0, 4.0, true),
            (4.0, 4.0, true),
            (2.0, 10.0, true),
            // A lucky seed, which may not be chosen
            (1.5, 0.5, false),
        ];
        let settings = settings.map(setting);
        let found: Vec<(f64, f64)> = front(&settings).into_iter().map(|s| (s.cost, s.error)).collect();
        assert_eq!(found, [(1.0, 9.0), (3.0, 4.0), (8.0, 1.0)]);
        assert!(front(&[]).is_empty());
    }
}
