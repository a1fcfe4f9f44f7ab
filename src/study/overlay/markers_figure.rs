//! Measured tracks as marks, recorded points as lines: one panel per coordinate.

use super::markers::{MarkerOverlay, Pair, words};
use crate::report::canvas::{INK, MARKS, SMALL, figure, hollow, mm, page_height};
use crate::report::figure::{Figure, LINE, Sample, WithLegend, apart, legend, stroke, style};
use crate::report::measure::{shortened, width};
use crate::report::plot::{Axis, Plot};

/// Smallest distance between the marks of one marker in a panel \[units\].
const APART: i32 = 54;
/// Largest numbers of markers in the legend, as many as fit on a page below the panels.
const ENTRIES: [f64; 2] = [6.0, 20.0];
/// Lines of the legend above the entries of the markers.
const HEAD: f64 = 2.5;

/// Height of a panel and distance from one to the next \[mm\].
const TALL: f64 = 36.0;
const STEP: f64 = 44.0;

pub fn draw(name: &str, overlay: &MarkerOverlay) -> Figure {
    let (left, top) = (18.0, 4.0);
    let bottom = top + 3.0 * STEP + 6.0;
    let room = (page_height() - bottom - 3.0) / LINE - HEAD;
    let named = overlay.pairs.len().min(room.clamp(ENTRIES[0], ENTRIES[1]) as usize);
    let WithLegend { wide, legend: key, size } = WithLegend::new((left, top, bottom), HEAD + named as f64);
    let svg = figure(size.0, size.1, "", |area| {
        for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
            let upper = top + STEP * axis as f64;
            let simulated = overlay.pairs.iter().flat_map(|p| p.simulated[axis].f.iter().copied());
            let seen = overlay.pairs.iter().flat_map(|p| p.measured.iter().map(|m| m.1[axis]));
            let times = overlay.pairs.iter().flat_map(|p| p.simulated[axis].t.iter().copied());
            let plot = Plot {
                area,
                frame: [mm(left), mm(upper), mm(left + wide), mm(upper + TALL)],
                x: Axis::linear(times, "t [s]"),
                y: Axis::linear(simulated.chain(seen).map(|v| 1e3 * v), &format!("{letter} [mm]")),
            };
            plot.grid();
            for (k, pair) in overlay.pairs.iter().enumerate() {
                let scaled = |v: &[f64]| v.iter().map(|v| 1e3 * v).collect::<Vec<_>>();
                let curve = &pair.simulated[axis];
                stroke(area, &plot.path(&curve.t, &scaled(&curve.f)), k, 10);
                let inside = pair.measured.iter().filter(|(t, _)| *t >= plot.x.lo && *t <= plot.x.hi);
                let places = inside.flat_map(|(t, m)| plot.path(&[*t], &[1e3 * m[axis]]));
                let (shape, color) = style(k);
                apart(places, APART).into_iter().for_each(|at| hollow(area, shape, at, 18, color));
            }
            plot.axes(true);
        }
        let at = |row: f64| (mm(key.0), mm(key.1 + LINE * row));
        let entries = [(Sample::Line(INK), "simulated"), (Sample::Hollow(MARKS[0], INK), "measured")];
        legend(area, at(0.0), &entries.map(|(s, w)| (s, w.to_string())));
        let entry = |(k, pair): (usize, &Pair)| {
            let off = pair.distance.as_ref().map(|d| (1e3 * d.rms_m, 1e3 * d.largest_m));
            let off = off.map_or(String::new(), |(rms, largest)| format!(": rms {rms:.2}, largest {largest:.2} mm"));
            // A long name is shortened, but not the numbers after it
            let room = mm(size.0 - key.0 - 7.0) - width(&off, SMALL);
            (Sample::Stroke(k), shortened(&pair.marker, SMALL, room) + &off)
        };
        let entries: Vec<_> = overlay.pairs.iter().enumerate().take(named).map(entry).collect();
        legend(area, at(HEAD), &entries);
    });
    let all: Vec<String> = overlay.pairs.iter().filter_map(|p| p.distance.as_ref()).map(words).collect();
    let caption = if all.is_empty() { "No row of the tracks is within the run".into() } else { all.join("; ") };
    let count = overlay.pairs.len();
    let more =
        if named < count { format!(" The legend names the first {named} of {count} markers.") } else { String::new() };
    Figure { name: name.into(), svg, caption: format!("{}: {caption}.{more}", overlay.source) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::curve::Curve;

    /// Every marker has its own line style, and as many as fit on a page have a legend entry; otherwise the caption says that some have none.
    #[test]
    fn no_two_markers_look_alike() {
        let of = |count: usize| {
            let still = Curve { t: vec![0.0, 1.0], f: vec![0.0, 1e-3] };
            let pair = |k: usize| Pair {
                marker: format!("marker {k}."),
                measured: vec![],
                simulated: [still.clone(), still.clone(), still.clone()],
                distance: None,
            };
            let overlay = MarkerOverlay { source: "f".into(), pairs: (0..count).map(pair).collect(), note: None };
            let figure = draw("markers", &overlay);
            (figure.svg.matches("marker ").count(), figure.caption.contains("names the first 17 of 25 markers"))
        };
        assert_eq!([of(8), of(25)], [(8, false), (17, true)]);
    }
}
