//! A measured curve laid over a recorded one, and how far apart they are.
//!
//! ```text
//! d = f(x) − m at the measured x within the range of both,  ‖d‖₂/‖m‖₂ with ‖d‖₂ = √(1/X ∫ d² dx),  max |d|/max |m|
//! ```
//!
//! f is linear between its rows. Over another column than time both curves count along their first long branch between two turning points
//! in x.

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
use distance::{Distance, Overlay};
use markers::MarkerOverlay;
use std::ops::Range;
use std::path::Path;

/// The overlays that the scene asks for.
pub fn overlays(scene: &Scene, run: &Run) -> Vec<Overlay> {
    let column = |name: &str| run.column(name).expect("checked when the scene was built");
    let one = |measured: &Measured| {
        let (x, y) = (column(&measured.over), column(&measured.column));
        Overlay { distance: distance(measured, &x, &y), measured: measured.clone(), x, y }
    };
    scene.measured.curves.iter().map(one).collect()
}

fn distance(measured: &Measured, x: &[f64], y: &[f64]) -> Option<Distance> {
    let (m, f) = (branch(&measured.x, &measured.y)?, branch(x, y)?);
    let t = m.common(&f);
    let (from, to) = (*t.first()?, *t.last()?);
    let of = |c: &Curve| -> Vec<f64> { t.iter().map(|t| c.at(*t)).collect() };
    let (m, f) = (of(&m), of(&f));
    let d: Vec<f64> = f.iter().zip(&m).map(|(f, m)| f - m).collect();
    let most = |v: &[f64]| v.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let given = !measured.half_widths.is_empty();
    let widths = given.then(|| branch(&measured.x, &measured.half_widths)).flatten().map(|w| of(&w));
    let inside = widths.map(|w| d.iter().zip(&w).filter(|(d, w)| d.abs() <= **w).count());
    let Measured { column, over, source, .. } = measured;
    // Of a position the simulated place at rest
    let start = Curve { t: vec![], f: y.to_vec() }.start();
    let changes: Vec<f64> = m.iter().map(|m| m - start).collect();
    let (l2, largest) = (l2(&t, &d) / l2(&t, &changes), most(&d) / most(&changes));
    (t.len() >= 2 && l2.is_finite()).then(|| Distance {
        column: column.clone(),
        over: over.clone(),
        file: source.clone(),
        points: t.len(),
        from,
        to,
        l2,
        largest,
        inside,
    })
}

/// Least length of the branch that counts, as a share of the longest one: a body that sags turns before it is lifted \[–\]
const BRANCH: f64 = 0.5;

/// The first branch between two turning points of x that is about as long as the longest one, by ascending x; none if x does not change.
fn branch(x: &[f64], y: &[f64]) -> Option<Curve> {
    let mut branches: Vec<Range<usize>> = vec![];
    let mut start = 0;
    while start + 1 < x.len() {
        let up = x[start + 1] > x[start];
        let steps = x[start..].windows(2).take_while(|w| w[0] != w[1] && (w[1] > w[0]) == up).count();
        branches.push(start..start + steps + 1);
        start += steps.max(1);
    }
    let length = |range: &Range<usize>| (x[range.end - 1] - x[range.start]).abs();
    let longest = branches.iter().map(length).fold(0.0, f64::max);
    let counts = branches.into_iter().find(|range| range.len() > 1 && length(range) >= BRANCH * longest)?;
    let (mut t, mut f) = (x[counts.clone()].to_vec(), y[counts].to_vec());
    if t.first() > t.last() {
        t.reverse();
        f.reverse();
    }
    Some(Curve { t, f })
}

/// A note for each measured curve that has no range in common with the recorded one.
pub fn apart(overlays: &[Overlay]) -> impl Iterator<Item = String> + '_ {
    let words = |x: &[f64], y: &[f64]| {
        let range =
            branch(x, y).map(|c| format!("{} to {}", significant(c.t[0], 3), significant(c.t[c.t.len() - 1], 3)));
        range.unwrap_or_else(|| "one value".into())
    };
    overlays.iter().filter(|overlay| overlay.distance.is_none()).map(move |Overlay { measured, x, y, .. }| {
        let Measured { column, over, source, .. } = measured;
        let (own, other) = (words(x, y), words(&measured.x, &measured.y));
        format!(
            "{column} has no distance from {source}: their branches have no range of {over} in common, {own} simulated and {other} measured"
        )
    })
}

/// Draws measured curves over recorded ones, `<name>-compare-1.svg`, `.png`, `.pdf` and so on in `dir`, and tracks over recorded points,
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
        Measured { column: name("f"), over: name("x"), source: name("m.csv"), x, y, half_widths }
    }

    #[test]
    fn points_within_their_uncertainty_are_counted() {
        // d = 0, 0.1, 0.2 at x = 0, 0.5, 1; the point at 3 is beyond the run
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

    #[test]
    fn a_loop_counts_along_its_first_long_branch() {
        // A body that sags before it is lifted
        let sag = branch(&[0.0, 4.6, 1.0, 30.0, 55.0, 50.0], &[0.0, 9.0, 1.0, 2.0, 3.0, 4.0]);
        assert_eq!(sag, Some(Curve { t: vec![1.0, 30.0, 55.0], f: vec![1.0, 2.0, 3.0] }));
        // A loop that is closed a little beyond its start is compared as it is loaded
        let closed = branch(&[0.0, 30.0, 55.0, 30.0, -0.1], &[0.0, 2.0, 3.0, 1.0, 0.0]);
        assert_eq!(closed, Some(Curve { t: vec![0.0, 30.0, 55.0], f: vec![0.0, 2.0, 3.0] }));
        assert_eq!(branch(&[2.0], &[1.0]), None);
        let (x, y) = ([3.0, 2.0, 1.0, 2.0, 3.0], [0.0, 1.0, 2.0, 7.0, 7.0]);
        assert_eq!(branch(&x, &y), Some(Curve { t: vec![1.0, 2.0, 3.0], f: vec![2.0, 1.0, 0.0] }));
        assert_eq!(branch(&[1.0, 1.0], &[0.0, 1.0]), None);
        let d = distance(&measured(&x, &y), &[3.0, 1.0], &[0.0, 2.0]).expect("a common range");
        assert_eq!((d.l2, d.largest), (0.0, 0.0));
        let (far, x, y) = (measured(&[5.0, 6.0], &[1.0, 1.0]), vec![0.0, 1.0], vec![0.0, 1.0]);
        let overlay = Overlay { distance: distance(&far, &x, &y), measured: far, x, y };
        let note = apart(&[overlay]).next().expect("nothing in common");
        assert!(
            note.contains("f has no distance from m.csv")
                && note.contains("0 to 1.00 simulated and 5.00 to 6.00 measured"),
            "{note}"
        );
    }
}
