//! Measured or other reference values against predicted ones, in half-widths of the intervals: a mark for each quantity, a position for each record.

use crate::report::canvas::{At, INK, PALE, SMALL, dashed, figure, fill, italic, mark, mm, page_width, text};
use crate::report::figure::{Figure, LINE, Sample, legend_below, legend_lines, style};
use crate::report::measure::width;
use crate::report::names::with_symbol;
use crate::report::numbers::capital;
use crate::report::plot::{Axis, Plot};
use crate::study::analysis::Analysis;
use crate::study::kinds::validation::findings::{Prediction, ValidationFindings};
use plotters::style::Color;

const LEFT: f64 = 15.0;
const TOP: f64 = 4.0;
const TALL: f64 = 56.0;
const RIGHT: f64 = 4.0;

/// Draws the scores; `None` without a measured prediction.
pub fn draw(a: &Analysis<ValidationFindings>) -> Option<Figure> {
    let scored: Vec<(&Prediction, f64)> = a.predictions.iter().filter_map(|p| Some((p, p.score?))).collect();
    let mut records: Vec<&str> = vec![];
    for (p, _) in &scored {
        if !records.contains(&p.record_label.as_str()) {
            records.push(&p.record_label);
        }
    }
    let mut quantities: Vec<&Prediction> = vec![];
    for (p, _) in &scored {
        if quantities.iter().all(|known| known.quantity != p.quantity) {
            quantities.push(p);
        }
    }
    let look = |p: &Prediction| style(quantities.iter().position(|q| q.quantity == p.quantity).unwrap_or(0));
    let legend = || {
        let band = (Sample::Block(PALE), "inside the interval".to_string());
        let named = quantities.iter().map(|q| {
            let (mark, color) = look(q);
            (Sample::Mark(mark, color), with_symbol(&q.label, &q.symbol, &italic(&q.symbol)))
        });
        std::iter::once(band).chain(named).collect::<Vec<_>>()
    };
    // From the left edge of the page, so that two entries fit into a narrow one
    let room = page_width() - LEFT + 10.0;
    let lines = legend_lines(&legend(), room);
    let slot = (page_width() - RIGHT - LEFT) / records.len().max(1) as f64;
    let longest = records.iter().map(|r| width(r, SMALL)).max().unwrap_or(0);
    let turned = longest > mm(slot);
    let names = if turned { f64::from(longest) / f64::from(mm(1.0)) + 5.0 } else { 8.0 };
    let below = TOP + TALL + names;
    let svg = figure(page_width(), below + LINE * lines + 1.0, "", |area| {
        let frame = [mm(LEFT), mm(TOP), mm(page_width() - RIGHT), mm(TOP + TALL)];
        let x = Axis { step: 1.0, ..Axis::exact(0.0, records.len() as f64, "") };
        let values = scored.iter().map(|(_, s)| *s).chain([-1.2, 1.2]);
        let y = Axis::linear(values, &format!("({} − predicted)/half-width", a.reference()));
        let plot = Plot { area, frame, x, y };
        let (from, to) = (0.0, records.len() as f64);
        fill(area, &[plot.at(from, -1.0), plot.at(to, -1.0), plot.at(to, 1.0), plot.at(from, 1.0)], PALE.to_rgba());
        plot.grid();
        dashed(area, &[plot.at(from, 0.0), plot.at(to, 0.0)], INK, 5, 22.0);
        for (k, record) in records.iter().enumerate() {
            let own: Vec<&(&Prediction, f64)> = scored.iter().filter(|(p, _)| p.record_label == *record).collect();
            for (j, (p, score)) in own.iter().enumerate() {
                let at = k as f64 + 0.1 + 0.8 * (j as f64 + 0.5) / own.len() as f64;
                let (shape, color) = look(p);
                mark(area, shape, plot.at(at, *score), 20, color);
            }
            let place = LEFT + slot * (k as f64 + 0.5);
            match turned {
                true => {
                    let long = width(record, SMALL) / 2;
                    text(area, record, (mm(place) + mm(1.2), mm(TOP + TALL + 2.0) + long), At::Turned, SMALL, INK);
                }
                false => text(area, record, (mm(place), mm(TOP + TALL + 2.0)), At::Below, SMALL, INK),
            }
        }
        plot.axes(false);
        legend_below(area, (LEFT - 10.0, below + 1.0), room, legend());
    });
    let caption = format!(
        "{} minus predicted value of every prediction that can be compared, in half-widths of its 95 % interval on that side, by quantity (marks) and record; \
         within ±1 (grey) the interval contains it.",
        capital(a.reference())
    );
    (!scored.is_empty()).then(|| Figure { name: "score".into(), svg, caption })
}
