//! Markers that exchange their positions between two rows of a record.
//!
//! Markers have exchanged their tracks in a cycle if, from one row to the next, each of them moves to where the previous marker of the cycle was: the
//! sum of the squared steps with exchanged names is a small share of that with the stated names, the steps are far larger than usual, and the
//! exchange does not worsen the distances to the other markers of the group. Every permutation of tracks consists of such cycles.

use super::error::{MotionError, Swap};
use super::track::Track;
use crate::math::statistics::median;

/// Largest Σ|step|² with exchanged names relative to that with the stated names \[–\]
const PART: f64 = 0.1;
/// Smallest steps of an exchange relative to the median step of its markers \[–\]
const FAR: f64 = 8.0;
/// Largest number of markers in a group for which cycles of every length are tried
const EVERY: usize = 6;
/// Longest cycles tried in larger groups
const LONGEST: usize = 3;

/// Checks the markers of one rigid group for exchanged tracks.
///
/// # Errors
/// [`MotionError::Swapped`] with all exchanges.
pub fn check(time_s: &[f64], group: &[&Track]) -> Result<(), MotionError> {
    let mut swaps: Vec<Swap> = cycles(group.len()).iter().flat_map(|cycle| exchanges(time_s, cycle, group)).collect();
    swaps.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    if swaps.is_empty() { Ok(()) } else { Err(MotionError::Swapped { swaps }) }
}

/// Returns the cycles of two or more of `n` markers, each starting with its smallest index.
fn cycles(n: usize) -> Vec<Vec<usize>> {
    let longest = if n > EVERY { LONGEST } else { n };
    let mut paths: Vec<Vec<usize>> = (0..n).map(|k| vec![k]).collect();
    let mut all = vec![];
    for _ in 1..longest {
        let longer = |path: &Vec<usize>| {
            let next = (path[0] + 1..n).filter(|k| !path.contains(k));
            next.map(|k| [&path[..], &[k]].concat()).collect::<Vec<_>>()
        };
        paths = paths.iter().flat_map(longer).collect();
        all.extend_from_slice(&paths);
    }
    all
}

type Point = [f64; 3];

fn distance(a: Point, b: Point) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// Returns the exchanges of a cycle: the rows at which its markers are found where their predecessors in the cycle were.
fn exchanges(time_s: &[f64], cycle: &[usize], group: &[&Track]) -> Vec<Swap> {
    let of_row = |k: usize| cycle.iter().map(|m| group[*m].points[k]).collect::<Option<Vec<Point>>>();
    let rows: Vec<(usize, Vec<Point>)> = (0..time_s.len()).filter_map(|k| Some((k, of_row(k)?))).collect();
    let n = cycle.len();
    let stated = |w: &[(usize, Vec<Point>)], i: usize| distance(w[0].1[i], w[1].1[i]);
    let steps: Vec<f64> = rows.windows(2).flat_map(|w| (0..n).map(|i| stated(w, i)).collect::<Vec<_>>()).collect();
    let usual = median(&steps);
    let is_swap = |w: &&[(usize, Vec<Point>)]| {
        let exchanged = |i: usize| distance(w[0].1[i], w[1].1[(i + 1) % n]);
        (0..n).all(|i| stated(w, i) > FAR * usual)
            && (0..n).map(|i| exchanged(i).powi(2)).sum::<f64>()
                < PART * (0..n).map(|i| stated(w, i).powi(2)).sum::<f64>()
            && restores(group, cycle, [w[0].0, w[1].0])
    };
    let names = || cycle.iter().map(|m| group[*m].name.clone()).collect();
    rows.windows(2).filter(is_swap).map(|w| Swap { names: names(), time_s: time_s[w[1].0] }).collect()
}

/// Whether the distances to the other markers of the group change no more with exchanged names than with the stated ones; true if there are no other
/// markers.
fn restores(group: &[&Track], cycle: &[usize], [before, now]: [usize; 2]) -> bool {
    let change = |exchanged: usize| {
        let one = |(c, i): (usize, usize)| {
            let (member, named) = (cycle[i], cycle[(i + exchanged) % cycle.len()]);
            let was = distance(group[member].points[before]?, group[c].points[before]?);
            Some((was - distance(group[named].points[now]?, group[c].points[now]?)).powi(2))
        };
        let others = (0..group.len()).filter(|c| !cycle.contains(c));
        others.flat_map(|c| (0..cycle.len()).map(move |i| (c, i))).filter_map(one).sum::<f64>()
    };
    change(1) <= change(0)
}
