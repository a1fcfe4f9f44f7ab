//! A measured curve laid over a recorded one, and the distance between them.
//!
//! ```text
//! d = f(x) − m at the measured x within the range of both,  ‖d‖₂/‖m‖₂ with ‖d‖₂ = √(1/X ∫ d² dx),  max |d|/max |m|
//! ```
//!
//! The recorded curve f is linear between its rows, and the integral is over the measured points in the order of increasing x. Over a column other than
//! time, only the first long branch between two turning points in x counts, for both curves ([`mod@branch`]).

pub mod branch;
pub mod distance;
pub mod figure;
pub mod in_study;
pub mod markers;
mod markers_figure;
pub mod markers_in_study;

use crate::report::numbers::significant;
use crate::report::{ReportError, export};
use crate::scene::{Measured, Run, Scene};
use crate::study::curve::{Curve, l2};
use crate::wording::all;
use branch::{branch, function};
use distance::{Distance, Overlay, origin};
use markers::MarkerOverlay;
use std::path::Path;

/// The overlays that the scene requests.
pub fn overlays(scene: &Scene, run: &Run) -> Vec<Overlay> {
    let column = |name: &str| run.column(name).expect("checked when the scene was built");
    let one = |measured: &Measured| {
        let (x, y) = (column(&measured.over), column(&measured.column));
        Overlay { distance: distance(measured, &x, &y), measured: measured.clone(), x, y }
    };
    scene.measured.curves.iter().map(one).collect()
}

fn distance(measured: &Measured, x: &[f64], y: &[f64]) -> Option<Distance> {
    let f = function(x, y)?;
    let rows = branch(&measured.x);
    let of = |values: &[f64], rows: &[usize]| rows.iter().map(|k| values[*k]).collect::<Vec<f64>>();
    let t = Curve { t: of(&measured.x, &rows), f: vec![] }.common(&f);
    let (from, to) = (*t.first()?, *t.last()?);
    let in_range: Vec<usize> = rows.iter().copied().filter(|k| (from..=to).contains(&measured.x[*k])).collect();
    let m = of(&measured.y, &in_range);
    let f: Vec<f64> = t.iter().map(|t| f.at(*t)).collect();
    let d: Vec<f64> = f.iter().zip(&m).map(|(f, m)| f - m).collect();
    let most = |v: &[f64]| v.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let given = !measured.half_widths.is_empty();
    let widths = given.then(|| of(&measured.half_widths, &in_range));
    let inside = widths.map(|w| d.iter().zip(&w).filter(|(d, w)| d.abs() <= **w).count());
    let Measured { column, over, source, columns, .. } = measured;
    // For a position, the simulated place at rest
    let start = Curve { t: vec![], f: y.to_vec() }.start();
    let changes: Vec<f64> = m.iter().map(|m| m - start).collect();
    let (l2, largest) = (l2(&t, &d) / l2(&t, &changes), most(&d) / most(&changes));
    (t.len() >= 2 && l2.is_finite()).then(|| Distance {
        column: column.clone(),
        over: over.clone(),
        file: source.clone(),
        columns: columns.clone(),
        points: t.len(),
        on_branch: rows.len(),
        in_table: measured.x.len(),
        from,
        to,
        l2,
        largest,
        inside,
    })
}

/// Notes on measured curves that have no range in common with the recorded one, or most of whose points are left out.
pub fn notes(overlays: &[Overlay]) -> Vec<String> {
    overlays.iter().filter_map(|o| o.distance.as_ref().map_or_else(|| Some(apart(o)), left_out)).collect()
}

/// The note on a measured curve without a range in common with the recorded one.
fn apart(Overlay { measured, x, y, .. }: &Overlay) -> String {
    let words = |x: &[f64], y: &[f64]| {
        let range =
            function(x, y).map(|c| format!("{} to {}", significant(c.t[0], 3), significant(c.t[c.t.len() - 1], 3)));
        range.unwrap_or_else(|| "one value".into())
    };
    let Measured { column, over, source, columns, .. } = measured;
    let source = origin(source, columns);
    let (own, other) = (words(x, y), words(&measured.x, &measured.y));
    format!(
        "{column} has no distance from {source}: their branches have no range of {over} in common, {own} simulated and {other} measured"
    )
}

/// The note on a measured curve if less than half of its points are compared.
fn left_out(d: &Distance) -> Option<String> {
    let Distance { column, over, points, on_branch, in_table, .. } = d;
    let file = d.origin_words();
    let reasons = [
        (
            in_table.saturating_sub(*on_branch),
            format!(
                "off its first long branch between two turning points of {over} (sort the rows if they are not in the order of the test)"
            ),
        ),
        (on_branch.saturating_sub(*points), "outside of the range of the run".into()),
    ];
    let reasons: Vec<String> = reasons.iter().filter(|(n, _)| *n > 0).map(|(n, why)| format!("{n} {why}")).collect();
    (2 * points < *in_table).then(|| {
        format!("{column} is compared with {} points of {file}: left out are {}", d.share_words(), all(&reasons))
    })
}

/// Draws measured curves over recorded ones as `<name>-compare-1.svg`, `.png`, `.pdf` and so on in `dir`, and tracks over recorded points as
/// `<name>-markers-1.svg`.
pub fn save(dir: &Path, name: &str, overlays: &[Overlay], tracks: &[MarkerOverlay]) -> Result<(), ReportError> {
    let curves = overlays.iter().enumerate().map(|(k, o)| figure::draw(&format!("{name}-compare-{}", k + 1), o));
    let tracks = tracks.iter().enumerate().map(|(k, o)| markers_figure::draw(&format!("{name}-markers-{}", k + 1), o));
    for figure in curves.chain(tracks) {
        export::save(dir, &figure)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(x: &[f64], y: &[f64]) -> Measured {
        let name = |s: &str| s.to_string();
        let (x, y, half_widths) = (x.to_vec(), y.to_vec(), vec![]);
        Measured {
            column: name("f"),
            over: name("x"),
            source: name("m.csv"),
            columns: String::new(),
            x,
            y,
            half_widths,
        }
    }

    #[test]
    fn points_within_their_uncertainty_are_counted() {
        // d = 0, 0.1, 0.2 at x = 0, 0.5, 1; the point at 3 is outside the run
        let mut m = measured(&[0.0, 0.5, 1.0, 3.0], &[0.0, 1.0, 2.0, 6.0]);
        let inside = |m: &Measured| distance(m, &[0.0, 1.0], &[0.0, 2.2]).expect("a common range").inside;
        assert_eq!(inside(&m), None);
        m.half_widths = vec![0.01, 0.11, 0.15, 9.0];
        assert_eq!(inside(&m), Some(2));
    }

    #[test]
    fn distance_of_two_lines() {
        // m = 2x and f = 2.2x on [0, 1]: 10 % in both norms, whatever the grid of f.
        let d = distance(&measured(&[0.0, 0.5, 1.0, 3.0], &[0.0, 1.0, 2.0, 6.0]), &[0.0, 0.3, 1.0], &[0.0, 0.66, 2.2]);
        let d = d.expect("a common range");
        assert_eq!((d.points, d.from, d.to), (3, 0.0, 1.0));
        assert!((d.l2 - 0.1).abs() < 1e-15 && (d.largest - 0.1).abs() < 1e-15, "{d:?}");
    }

    /// A loop is compared along its loading; a curve outside the range of the run has no distance.
    #[test]
    fn what_is_left_out_is_noted() {
        let (x, y) = ([3.0, 2.0, 1.0, 2.0, 3.0], [0.0, 1.0, 2.0, 7.0, 7.0]);
        let d = distance(&measured(&x, &y), &[3.0, 1.0], &[0.0, 2.0]).expect("a common range");
        assert_eq!((d.l2, d.largest, d.points, d.on_branch, d.in_table), (0.0, 0.0, 3, 3, 5));
        assert_eq!(left_out(&d), None);
        let few = left_out(&Distance { points: 2, ..d }).expect("most are left out");
        assert!(
            few.contains("f is compared with 2 of 5 points of m.csv: left out are 2 off")
                && few.ends_with("and 1 outside of the range of the run"),
            "{few}"
        );
        let (far, x, y) = (measured(&[5.0, 6.0], &[1.0, 1.0]), vec![0.0, 1.0], vec![0.0, 1.0]);
        let overlay = Overlay { distance: distance(&far, &x, &y), measured: far, x, y };
        let notes = notes(&[overlay]);
        assert!(
            notes[0].contains("f has no distance from m.csv")
                && notes[0].contains("0 to 1.00 simulated and 5.00 to 6.00 measured"),
            "{notes:?}"
        );
    }

    /// A curve of half the height at 60 points, with noise in x of 1 % of its range: all of it is compared, and the distance of one half is found.
    #[test]
    fn a_noisy_curve_is_compared_whole() {
        let x: Vec<f64> = (0..60).map(|k| f64::from(k) + 0.6 * (1.7 * f64::from(k) * f64::from(k)).sin()).collect();
        let y: Vec<f64> = x.iter().map(|x| 2.0 * x).collect();
        let d = distance(&measured(&x, &y), &[0.0, 70.0], &[0.0, 70.0]).expect("a common range");
        assert!(d.points >= 58 && (d.l2 - 0.5).abs() < 1e-12, "{d:?}");
    }
}
