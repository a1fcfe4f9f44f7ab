//! The branch of a curve that is compared: the rows from one turning point in x to the next.
//!
//! A row is a turning point if x moves back from it by more than a *reversal*. Noise, rounded values and holds move back by a little, cycles and loops
//! by a good part of the range of x. Reversals are tried in a sequence that doubles; the one used is twice the smallest with which some branch covers
//! half of the range. A smaller one would let noise cut the curve into pieces, and noise that leaves half of it in one piece hardly ever moves back by
//! twice as much.
//!
//! The branch that counts is the first that is at least half as long as the longest one: a body that sags turns before it is lifted.
//!
//! Limits: noise of 5 % of the range or more, or of some dozen rows, may end the branch early; rows in random order have no branch.

use crate::study::curve::Curve;
use std::ops::RangeInclusive;

/// Reversals that are tried, relative to the range of x \[–\]. With twice the largest one every curve has a branch of that length, since its first row
/// is at least half of the range away from some other row
const REVERSALS: [f64; 5] = [0.0125, 0.025, 0.05, 0.1, 0.2];
/// Smallest length of a branch relative to the range of x, and of the branch that counts relative to the longest one \[–\]
const LONG: f64 = 0.5;

/// The rows of the branch that counts, in the order of increasing x; empty if x does not change.
pub fn branch(x: &[f64]) -> Vec<usize> {
    let [least, most] = x.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(*v), b.max(*v)]);
    let range = most - least;
    if x.is_empty() || range <= 0.0 {
        return vec![];
    }
    let length = |rows: &RangeInclusive<usize>| (x[*rows.end()] - x[*rows.start()]).abs();
    let longest = |all: &[RangeInclusive<usize>]| all.iter().map(length).fold(0.0, f64::max);
    let is_enough = |reversal: &f64| longest(&branches(x, reversal * range)) >= LONG * range;
    let [.., largest] = REVERSALS;
    let reversal = 2.0 * REVERSALS.into_iter().find(is_enough).unwrap_or(largest) * range;
    let all = branches(x, reversal);
    let least = LONG * longest(&all);
    let mut rows: Vec<usize> = all.into_iter().find(|rows| length(rows) >= least).into_iter().flatten().collect();
    rows.sort_by(|a, b| x[*a].total_cmp(&x[*b]));
    rows
}

/// Branches in the order of the rows, each from the last row with its initial value to the first row with its final value.
fn branches(x: &[f64], reversal: f64) -> Vec<RangeInclusive<usize>> {
    let Some(away) = x.iter().position(|v| (v - x[0]).abs() >= reversal) else { return vec![] };
    let leaves = |from: usize, until: usize| (from..until).rev().find(|k| x[*k] == x[from]).unwrap_or(from);
    let mut found = vec![];
    let (mut sign, mut start, mut end) = ((x[away] - x[0]).signum(), leaves(0, away), away);
    for k in away..x.len() {
        let ahead = sign * (x[k] - x[end]);
        if ahead > 0.0 {
            end = k;
        } else if -ahead >= reversal {
            found.push(start..=end);
            (sign, start, end) = (-sign, leaves(end, k), k);
        }
    }
    found.push(start..=end);
    found
}

/// The branch that counts as a function of x, with the mean of values at equal x; `None` if x does not change.
pub fn function(x: &[f64], y: &[f64]) -> Option<Curve> {
    let rows = branch(x);
    let equal: Vec<&[usize]> = rows.chunk_by(|a, b| x[*a] == x[*b]).collect();
    let mean = |rows: &&[usize]| rows.iter().map(|k| y[*k]).sum::<f64>() / rows.len() as f64;
    (equal.len() > 1)
        .then(|| Curve { t: equal.iter().map(|rows| x[rows[0]]).collect(), f: equal.iter().map(mean).collect() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix;

    /// Returns 600 rows from 0 to 59.
    fn ramp() -> Vec<f64> {
        (0..600).map(|k| 59.0 * f64::from(k) / 599.0).collect()
    }

    fn noisy(x: &[f64], deviation: f64) -> Vec<f64> {
        let mut random = SplitMix(7);
        x.iter().map(|x| x + deviation * random.normal()).collect()
    }

    fn share(x: &[f64]) -> f64 {
        branch(x).len() as f64 / x.len() as f64
    }

    #[test]
    fn noise_and_rounding_end_no_branch() {
        assert_eq!(branch(&ramp()), (0..600).collect::<Vec<_>>());
        for deviation in [0.02, 0.05, 0.1, 0.3, 1.0, 2.0] {
            let found = share(&noisy(&ramp(), deviation));
            assert!(found > 0.93, "{deviation}: {found}");
            let down: Vec<f64> = noisy(&ramp(), deviation).into_iter().rev().collect();
            assert!(share(&down) > 0.93, "{deviation}: {}", share(&down));
        }
        for step in [0.1, 0.5, 2.0] {
            let found = share(&ramp().iter().map(|x| (x / step).round() * step).collect::<Vec<_>>());
            assert!(found > 1.0 - 2.0 * step / 59.0, "{step}: {found}");
        }
    }

    /// Holds before, within and after the loading do not end the branch.
    #[test]
    fn holds_end_no_branch() {
        let (x, middle) = (ramp(), ramp()[300]);
        let held = [&[0.0; 200][..], &x[..300], &[middle; 200], &x[300..]].concat();
        // An exact hold before the loading does not belong to the branch
        assert_eq!(branch(&held).len(), 800);
        assert!(share(&noisy(&held, 0.1)) > 0.99);
        let after = [&x[..], &[59.0; 300]].concat();
        assert_eq!(branch(&after).len(), 600);
    }

    /// With three cycles, exact or with noise of 1.5 % of the range, the first loading counts.
    #[test]
    fn the_first_of_several_cycles_counts() {
        let up = ramp();
        let down: Vec<f64> = up.iter().rev().copied().collect();
        let cycles = [&up[..], &down[..], &up[..], &down[..], &up[..], &down[..]].concat();
        for deviation in [0.0, 0.1, 0.9] {
            let rows = branch(&noisy(&cycles, deviation));
            let (first, last) = (rows.iter().min().copied(), rows.iter().max().copied());
            assert!(first < Some(30) && last > Some(570) && last < Some(630), "{deviation}: {first:?} to {last:?}");
        }
        // A first cycle to a third of the range, then a full one
        let grown = [&up[..200], &down[400..], &up[..]].concat();
        assert_eq!(branch(&grown).iter().min(), Some(&400));
        // Small cycles about a rising mean belong to one branch
        let small: Vec<f64> = (0..600).map(|k| 0.1 * f64::from(k) + 4.0 * (0.2 * f64::from(k)).sin()).collect();
        assert!(share(&small) > 0.9, "{}", share(&small));
    }

    #[test]
    fn a_body_that_sags_counts_from_its_lifting_on() {
        let of = |x: &[f64], y: &[f64]| function(x, y).expect("a branch");
        let sag = of(&[0.0, 4.6, 1.0, 30.0, 55.0, 50.0], &[0.0, 9.0, 1.0, 2.0, 3.0, 4.0]);
        assert_eq!(sag, Curve { t: vec![1.0, 30.0, 55.0], f: vec![1.0, 2.0, 3.0] });
        // A loop that closes slightly beyond its start is compared along its loading
        let closed = of(&[0.0, 30.0, 55.0, 30.0, -0.1], &[0.0, 2.0, 3.0, 1.0, 0.0]);
        assert_eq!(closed, Curve { t: vec![0.0, 30.0, 55.0], f: vec![0.0, 2.0, 3.0] });
        let back = of(&[3.0, 2.0, 1.0, 2.0, 3.0], &[0.0, 1.0, 2.0, 7.0, 7.0]);
        assert_eq!(back, Curve { t: vec![1.0, 2.0, 3.0], f: vec![2.0, 1.0, 0.0] });
        // Equal x in between give one value
        let held = of(&[0.0, 1.0, 1.0, 2.0], &[0.0, 1.0, 2.0, 3.0]);
        assert_eq!(held, Curve { t: vec![0.0, 1.0, 2.0], f: vec![0.0, 1.5, 3.0] });
        assert_eq!((function(&[2.0], &[1.0]), function(&[1.0, 1.0], &[0.0, 1.0])), (None, None));
        assert_eq!(branch(&[]), Vec::<usize>::new());
    }
}
