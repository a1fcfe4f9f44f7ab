//! The end of a loading at which the stretch is held while the stress relaxes: these data points are not part of the loading.
//!
//! With a = |ln λ|, each row as the median of itself and its neighbours, a hold begins at the first row from which on a stays within a band of its
//! largest value in the loading. The band is the range of the errors of a, at least ½ % and at most 2 % of that value. Rows after the loading count
//! as long as they stay in the band, because the extremum of a hold is any one of its rows, by chance. The band must hold at least a tenth of the
//! rows of the loading, and eight times as many as any other band of its width beyond the first 5 % of a (otherwise the test proceeds in steps, or
//! the rows are dense), without a slope: the means of its two halves differ by less than a quarter of its width (at the peak of a sine they differ by
//! half). And the stress must relax: from the first to the last third its mean falls by ½ % and four standard errors or more, but not to less than
//! half, which is a rupture.
//!
//! Limits: the band counts rows regardless of their times; a hold of few rows, with a drift of the stretch, or after other holds remains part of the
//! loading.

use super::cycle::{medians, path, scatter};
use crate::calibrate::Sample;
use crate::math::statistics::mean;
use std::ops::Range;

/// Smallest and largest width of the band relative to the largest a \[–\]: the accuracy to which a machine holds a stretch, and the return that ends
/// a branch
const BAND: [f64; 2] = [0.005, 0.02];
/// Least number of rows of a hold, and their least share of the rows of the loading \[–\]
const ROWS: usize = 8;
const PART: f64 = 0.1;
/// Least ratio of the number of its rows to that of any other band
const MORE: usize = 8;
/// Share of the largest a up to which a test may dwell at its beginning \[–\]
const BEGINNING: f64 = 0.05;
/// Share of the band by which the means of its halves may differ \[–\]
const FLAT: f64 = 0.25;
/// Least share of the stress that relaxes, least number of standard errors of its fall, and least share that remains \[–\]
const RELAXED: f64 = 0.005;
const ERRORS: f64 = 4.0;
const STAYS: f64 = 0.5;

/// A hold at the end of a loading.
#[derive(Clone, PartialEq, Debug)]
pub struct Hold {
    /// Its rows after the one that reached the stretch; the loading ends before them
    pub rows: Range<usize>,
    /// Share of the stress that has relaxed in the last third of its rows \[–\]
    pub relaxed: f64,
}

/// The hold at the end of a loading, where rows are those of the samples in the order of the test; `None` if there is no evident hold.
pub fn at_the_end(samples: &[Sample], loading: Range<usize>) -> Option<Hold> {
    let stress: Vec<f64> = samples.iter().map(|s| s.stress.abs()).collect();
    along(&path(&samples.iter().collect::<Vec<_>>()), &stress, loading)
}

/// The hold at the end of a loading for rows with these values of a, which grow from rest, and these magnitudes of the stress.
pub fn along(raw: &[f64], stress: &[f64], loading: Range<usize>) -> Option<Hold> {
    let a = medians(raw);
    let top = a[loading.clone()].iter().copied().fold(0.0, f64::max);
    let band = scatter(raw).clamp(BAND[0] * top, BAND[1] * top);
    let inside = |k: &usize| a[*k] >= top - band;
    let reached = loading.clone().rev().take_while(inside).last()?;
    let end = (loading.end..a.len()).find(|k| !inside(k)).unwrap_or(a.len());
    let (held, ramp) = (reached + 1..end, loading.start..reached);
    let long = held.len() >= ROWS && held.len() as f64 >= PART * (end - loading.start) as f64;
    if !long || held.len() < MORE * most_within(&a[ramp], band, BEGINNING * top) || !is_flat(&a[held.clone()], band) {
        return None;
    }
    relaxed(&stress[held.clone()], stress[reached]).map(|relaxed| Hold { rows: held, relaxed })
}

/// Largest number of values above `least` that lie within a band of this width.
fn most_within(values: &[f64], band: f64, least: f64) -> usize {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|a| *a > least).collect();
    sorted.sort_by(f64::total_cmp);
    let within = |k: usize| sorted.partition_point(|a| *a <= sorted[k] + band) - k;
    (0..sorted.len()).map(within).max().unwrap_or(0)
}

/// Whether the values have no slope within the band.
fn is_flat(values: &[f64], band: f64) -> bool {
    let (first, second) = values.split_at(values.len() / 2);
    (mean(second) - mean(first)).abs() <= FLAT * band
}

/// The share of the stress that has relaxed at the end, relative to the stress at the beginning; `None` if it does not relax.
fn relaxed(stress: &[f64], peak: f64) -> Option<f64> {
    let third = stress.len() / 3;
    let (first, last) = (mean(&stress[..third]), mean(&stress[stress.len() - third..]));
    let noise = scatter_of_mean(stress, third);
    let fall = first - last;
    let relaxes = fall >= (RELAXED * first).max(ERRORS * noise) && last >= STAYS * first;
    relaxes.then(|| 1.0 - last / peak.max(first))
}

/// Standard error of the difference of two means of `count` values each, from the difference of each value from its neighbours (Gasser, Sroka &
/// Jennen-Steinmetz, Biometrika 73, 1986).
fn scatter_of_mean(values: &[f64], count: usize) -> f64 {
    let bends = values.windows(3).map(|w| (w[1] - 0.5 * (w[0] + w[2])).powi(2) / 1.5);
    (bends.sum::<f64>() / (values.len() - 2) as f64 * 2.0 / count as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::Mode;

    /// Data points of a law that loses this share of its stress in the rows at the largest stretch of the test so far.
    fn test(stretches: impl Iterator<Item = f64>, part: f64) -> Vec<Sample> {
        let (mut top, mut rows) = (1.0_f64, 0.0);
        let sample = |stretch: f64| {
            rows = if stretch > top + 1e-9 { 0.0 } else { rows + 1.0 };
            top = top.max(stretch);
            let kept = 1.0 - part * (1.0 - (-0.1_f64 * rows).exp());
            let stress = 4e4 * (stretch - stretch.powi(-2)) * kept;
            Sample { mode: Mode::Uniaxial, stretch, second: 1.0, stress, line: 1, specimen: 0 }
        };
        stretches.map(sample).collect()
    }

    fn up(rows: u32) -> impl Iterator<Item = f64> + Clone {
        (0..rows).map(move |k| 1.0 + f64::from(k) / f64::from(rows - 1))
    }

    fn found(samples: &[Sample]) -> Option<usize> {
        at_the_end(samples, 0..samples.len()).map(|h| h.rows.start)
    }

    #[test]
    fn a_hold_ends_the_loading() {
        let held = |n: usize| up(50).chain(std::iter::repeat_n(2.0, n));
        let hold = at_the_end(&test(held(30), 0.2), 0..80).expect("30 rows of relaxation");
        assert!(hold.rows == (50..80) && (hold.relaxed - 0.2).abs() < 0.02, "{hold:?}");
        // The noise of a hold of 200 rows, whose largest value ends the branch in the fourth row
        let noise = (0..200).map(|k| 2.0 + 1e-4 * f64::from(k * 7919 % 200 - 100) / 100.0);
        let noisy = test(up(50).chain(noise), 0.2);
        assert_eq!(at_the_end(&noisy, 0..54).map(|h| h.rows.start), Some(50));
        // A piece that is straightened or preloaded first dwells at the beginning
        assert_eq!(found(&test(std::iter::repeat_n(1.01, 20).chain(held(30)), 0.2)), Some(70));
        let pressed: Vec<Sample> = test(held(30), 0.2)
            .into_iter()
            .map(|s| Sample { stretch: 1.0 / s.stretch, stress: -s.stress, ..s })
            .collect();
        assert_eq!(found(&pressed), Some(50));
    }

    #[test]
    fn other_ends_of_a_loading_are_no_hold() {
        let none = |stretches: Vec<f64>, why: &str| assert_eq!(found(&test(stretches.into_iter(), 0.2)), None, "{why}");
        none(up(50).collect(), "a loading");
        none(up(3000).collect(), "dense rows");
        none(up(50).chain([2.0; 5]).collect(), "the last row a few times");
        none(vec![1.0, 1.2, 1.5, 2.0], "four rows");
        none(up(6).flat_map(|l| [l; 20]).collect(), "a test in steps, each with its relaxation");
        none((0..400).map(|k| 1.5 - 0.5 * (std::f64::consts::PI * f64::from(k) / 400.0).cos()).collect(), "a sine");
        none(up(400).map(|l| 1.0 + (l - 1.0).powi(2)).collect(), "a slow start");
        none(up(50).map(|l| 1.0 + (1.0 - (-8.0 * (l - 1.0)).exp())).collect(), "a machine that slows down");
        let held = || up(50).chain(std::iter::repeat_n(2.0, 30));
        assert_eq!(found(&test(held(), 0.0)), None, "an elastic piece, whose data points are all those of the law");
        let torn = |(k, s): (usize, Sample)| Sample { stress: if k > 60 { 0.0 } else { s.stress }, ..s };
        let torn: Vec<Sample> = test(held(), 0.0).into_iter().enumerate().map(torn).collect();
        assert_eq!(found(&torn), None, "a rupture");
    }
}
