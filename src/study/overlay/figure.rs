//! Figure with a measured curve as marks and the recorded one as a line.

use crate::report::canvas::{At, INK, MARKS, PALETTE, RGB, SMALL, figure, hollow, line, mm, text};
use crate::report::figure::{Figure, LINE, Sample, WithLegend, legend};
use crate::report::numbers::capital;
use crate::report::plot::{Axis, Plot};
use crate::scene::Measured;
use crate::scene::column::{label, words as named};
use crate::study::overlay::distance::Overlay;

/// Sentence of a caption about the error bars
pub(super) const BARS: &str = " Bars are the 95 % intervals of the measured values.";

/// The measured values and the ends of their error bars.
pub(super) fn reach(measured: &Measured) -> impl Iterator<Item = f64> + '_ {
    let ends = measured.y.iter().zip(&measured.half_widths).flat_map(|(y, w)| [y - w, y + w]);
    measured.y.iter().copied().chain(ends)
}

/// Draws an error bar at each measured value.
pub(super) fn bars(plot: &Plot, measured: &Measured, color: RGB) {
    for ((x, y), w) in measured.x.iter().zip(&measured.y).zip(&measured.half_widths) {
        line(plot.area, &plot.path(&[*x, *x], &[y - w, y + w]), color, 10);
    }
}

pub fn draw(name: &str, overlay: &Overlay) -> Figure {
    let Overlay { measured, x, y, distance } = overlay;
    let (left, top, tall) = (18.0, 4.0, 60.0);
    let words = distance.as_ref().map_or_else(
        || vec!["no common range".to_string()],
        |d| {
            let far = [format!("L2 {:.2} %", 100.0 * d.l2), format!("largest {:.2} %", 100.0 * d.largest)];
            let inside = d.inside.map(|n| format!("{n} of {} within bars", d.points));
            far.into_iter().chain([format!("{} points", d.share_words())]).chain(inside).collect()
        },
    );
    let WithLegend { wide, legend: key, size } =
        WithLegend::new((left, top, top + tall + 12.0), 2.5 + words.len() as f64);
    let svg = figure(size.0, size.1, "", |area| {
        let both = |a: &[f64], b: &[f64]| a.iter().chain(b).copied().collect::<Vec<_>>().into_iter();
        let plot = Plot {
            area,
            frame: [mm(left), mm(top), mm(left + wide), mm(top + tall)],
            x: Axis::linear(both(x, &measured.x), &label(&measured.over)),
            y: Axis::linear(y.iter().copied().chain(reach(measured)), &label(&measured.column)),
        };
        plot.grid();
        line(area, &plot.path(x, y), PALETTE[0], 10);
        bars(&plot, measured, PALETTE[1]);
        for at in plot.path(&measured.x, &measured.y) {
            hollow(area, MARKS[0], at, 22, PALETTE[1]);
        }
        plot.axes(true);
        let at = |row: f64| (mm(key.0), mm(key.1 + LINE * row));
        let entries = [(Sample::Line(PALETTE[0]), "simulated"), (Sample::Hollow(MARKS[0], PALETTE[1]), "measured")];
        legend(area, at(0.0), &entries.map(|(s, w)| (s, w.to_string())));
        for (k, words) in words.iter().enumerate() {
            text(area, words, at(2.5 + k as f64), At::Left, SMALL, INK);
        }
    });
    let bars = if measured.half_widths.is_empty() { "" } else { BARS };
    let caption = format!(
        "{} over {}: {}.{bars}",
        capital(&named(&measured.column).0),
        named(&measured.over).0,
        words.join(", ")
    );
    Figure { name: name.into(), svg, caption }
}
