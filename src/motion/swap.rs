//! Markers that exchange their positions between two rows of a record.
//!
//! A pair has exchanged its tracks where, from one row to the next, each of the two lies nearer to where the other one was: the sum of the squared
//! steps with exchanged names is below a part of the one with the stated names, the steps are far beyond the usual ones, and, in a rigid group of
//! three or more, exchanged names restore the distances between the markers.

use super::error::{MotionError, Swap};
use super::track::Track;
use crate::math::statistics::median;

/// Part of Σ|step|² that exchanged names may leave \[–\]
const PART: f64 = 0.1;
/// Steps of an exchange over the median step of the two markers \[–\]
const FAR: f64 = 8.0;

/// All exchanges of tracks of one rigid group.
///
/// # Errors
/// [`MotionError::Swapped`] with all of them.
pub fn check(time_s: &[f64], group: &[&Track]) -> Result<(), MotionError> {
    let mut swaps = vec![];
    for (k, a) in group.iter().enumerate() {
        for b in &group[k + 1..] {
            swaps.extend(pair(time_s, a, b, group));
        }
    }
    swaps.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    if swaps.is_empty() { Ok(()) } else { Err(MotionError::Swapped { swaps }) }
}

type Point = [f64; 3];

fn distance(a: Point, b: Point) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

fn pair(time_s: &[f64], a: &Track, b: &Track, group: &[&Track]) -> Vec<Swap> {
    let rows: Vec<(usize, Point, Point)> =
        (0..time_s.len()).filter_map(|k| Some((k, a.points[k]?, b.points[k]?))).collect();
    let steps: Vec<f64> = rows.windows(2).flat_map(|w| [distance(w[0].1, w[1].1), distance(w[0].2, w[1].2)]).collect();
    let usual = median(&steps);
    let is_swap = |w: &&[(usize, Point, Point)]| {
        let [(before, a0, b0), (now, a1, b1)] = [w[0], w[1]];
        let stated = [distance(a0, a1), distance(b0, b1)];
        let exchanged = [distance(b0, a1), distance(a0, b1)];
        let sum = |d: [f64; 2]| d[0].powi(2) + d[1].powi(2);
        stated.iter().all(|d| *d > FAR * usual)
            && sum(exchanged) < PART * sum(stated)
            && restores(group, [a, b], before, now)
    };
    let found = rows.windows(2).filter(is_swap);
    found.map(|w| Swap { first: a.name.clone(), second: b.name.clone(), time_s: time_s[w[1].0] }).collect()
}

/// Whether exchanged names keep the distances to the other markers of the group better than the stated ones; true without another marker.
fn restores(group: &[&Track], [a, b]: [&Track; 2], before: usize, now: usize) -> bool {
    let change = |exchanged: bool| {
        let others = group.iter().filter(|c| c.name != a.name && c.name != b.name);
        let one = |c: &&Track| {
            let (old, new) = (c.points[before]?, c.points[now]?);
            let (from_a, from_b) = if exchanged { (b, a) } else { (a, b) };
            let of =
                |was: &Track, is: &Track| Some(distance(was.points[before]?, old) - distance(is.points[now]?, new));
            Some(of(a, from_a)?.powi(2) + of(b, from_b)?.powi(2))
        };
        others.filter_map(one).sum::<f64>()
    };
    change(true) <= change(false)
}
