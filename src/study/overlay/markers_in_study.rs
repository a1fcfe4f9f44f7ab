//! Distances of recorded points of the cases of a study from measured markers: one figure per variant, and the distances of all cases.

use super::distance::MarkerDistance;
use super::in_study::{SHOWN, shown};
use crate::report::canvas::{At, INK, MARKS, PALE, PALETTE, SMALL, figure, hollow, line, mark, mm, page_width, text};
use crate::report::figure::{Drawn, Figure, LINE, Sample, drawn, legend, legend_below, legend_lines};
use crate::report::measure::width;
use crate::report::plot::{Axis, Plot};
use crate::report::table::{Table, headings};
use crate::study::store::record::{CaseRecord, StoredCase};
use crate::study::store::results::Results;

const TOP: f64 = 4.0;
/// Height of a case in the row of a marker, and smallest height of a row \[mm\]
const CASE: f64 = 2.6;
const LEAST: f64 = 6.0;

/// The figure of every variant whose cases are compared with markers.
pub fn figures(store: &Results) -> Vec<Drawn> {
    let draw_one = |variant: &String| {
        let of = |c: &&StoredCase| c.is_of(variant) && !c.record.markers.is_empty();
        let cases: Vec<&StoredCase> = store.cases.iter().filter(of).collect();
        let name = format!("markers-{variant}");
        (!cases.is_empty()).then(|| drawn(&name, || draw(store, &name, variant, &cases)))?
    };
    store.study.variants.iter().filter_map(draw_one).collect()
}

/// Draws one row per marker, with a filled mark at the root mean square and an open one at the largest distance for each case.
fn draw(store: &Results, name: &str, variant: &str, all: &[&StoredCase]) -> Figure {
    let cases = shown(all);
    let mut rows: Vec<(&str, &str)> = vec![];
    for d in cases.iter().flat_map(|c| &c.record.markers) {
        if !rows.contains(&(d.file.as_str(), d.marker.as_str())) {
            rows.push((&d.file, &d.marker));
        }
    }
    let widest = rows.iter().map(|(_, marker)| width(marker, SMALL)).max().unwrap_or(0);
    let left = (f64::from(widest) / f64::from(mm(1.0)) + 5.0).min(0.5 * page_width());
    let each = LEAST.max(CASE * cases.len() as f64 + 1.6);
    let wide = 110.0_f64.min(page_width() - left - 5.0);
    let bottom = TOP + each * rows.len() as f64;
    let below = bottom + 13.0;
    let entry =
        |(k, c): (usize, &&StoredCase)| (Sample::Mark(MARKS[k % MARKS.len()], PALETTE[k % SHOWN]), c.record.id.clone());
    let entries: Vec<(Sample, String)> = cases.iter().enumerate().map(entry).collect();
    let lines = legend_lines(&entries, wide);
    let far = cases.iter().flat_map(|c| &c.record.markers).map(|d| 1e3 * d.largest_m);
    let svg = figure(left + wide + 5.0, below + LINE * (lines + 1.0), "", |area| {
        let plot = Plot {
            area,
            frame: [mm(left), mm(TOP), mm(left + wide), mm(bottom)],
            x: Axis::linear(far.chain([0.0]), "distance from the marker [mm]"),
            y: Axis::exact(rows.len() as f64, 0.0, ""),
        };
        plot.grid_x();
        for (k, (file, marker)) in rows.iter().enumerate() {
            let top = mm(TOP + each * k as f64);
            line(area, &[(mm(left), top), (mm(left + wide), top)], PALE, 4);
            text(area, marker, (mm(left - 2.0), top + mm(0.5 * each)), At::Right, SMALL, INK);
            for (j, case) in cases.iter().enumerate() {
                let own = case.record.markers.iter().find(|d| d.file == *file && d.marker == *marker);
                let Some(d) = own else { continue };
                let y = k as f64 + (j as f64 + 0.5) / cases.len() as f64;
                let (shape, color) = (MARKS[j % MARKS.len()], PALETTE[j % SHOWN]);
                let [rms, largest] = [d.rms_m, d.largest_m].map(|v| plot.at(1e3 * v, y));
                line(area, &[rms, largest], color, 5);
                hollow(area, shape, largest, 22, color);
                mark(area, shape, rms, 22, color);
            }
        }
        plot.axis_x();
        legend_below(area, (left, below), wide, entries);
        let at = |x: f64| (mm(x), mm(below + LINE * lines));
        legend(area, at(left), &[(Sample::Mark(MARKS[0], INK), "root mean square".into())]);
        legend(area, at(left + 36.0), &[(Sample::Hollow(MARKS[0], INK), "largest".into())]);
    });
    let files: std::collections::BTreeSet<&str> = rows.iter().map(|(file, _)| *file).collect();
    let files: Vec<&str> = files.into_iter().collect();
    let rest = if cases.len() < all.len() { " Of each family the finest mesh is shown." } else { "" };
    let caption = format!(
        "Distances of recorded points from measured markers ({}), {}: root mean square over the rows of the tracks within the run, and the largest one.{rest}",
        files.join(", "),
        store.study.label(variant)
    );
    Figure { name: name.into(), svg, caption }
}

/// Table of the distances of the recorded points of all cases from measured markers; `None` without such distances.
pub fn table(store: &Results) -> Option<Table> {
    let row = |r: &CaseRecord, d: &MarkerDistance| {
        let [rms, largest] = [d.rms_m, d.largest_m].map(|v| format!("{:.2}", 1e3 * v));
        let point = d.point.replace('_', " ");
        vec![
            r.id.clone(),
            d.marker.clone(),
            point,
            d.file.clone(),
            d.rows.to_string(),
            rms,
            largest,
            format!("{:.3}", d.largest_at_s),
        ]
    };
    let rows: Vec<Vec<String>> =
        store.cases.iter().flat_map(|c| c.record.markers.iter().map(|d| row(&c.record, d))).collect();
    (!rows.is_empty()).then(|| Table {
        name: "markers",
        caption: "Distances of recorded points from measured markers at the rows of the tracks within the run: root mean square and largest.".into(),
        columns: headings(&[
            ("Case", "", false),
            ("Marker", "", false),
            ("Point", "", false),
            ("File", "", false),
            ("Rows", "", true),
            ("RMS", "mm", true),
            ("Largest", "mm", true),
            ("At", "s", true),
        ]),
        rows,
        pick: None,
    })
}
