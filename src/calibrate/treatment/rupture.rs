//! Data points after the rupture of a test piece, and the beginning of a curve that does not start at zero.
//!
//! *Rupture*: the stress falls below half of its largest level and stays there to the end, while the stretch does not go back. The data points from
//! the first one below 90 % of that level on are left out. So are final data points in which the stretch has jumped back by more than half and the
//! piece carries less than 2 % of that level, although it carried more at a smaller stretch before: an extensometer on a broken piece. The level of a
//! data point is the smaller of its own stress and the median of itself and two neighbours on either side: a single data point far above its
//! neighbours is not a level from which a piece breaks, and does not show that a piece carries load after a rupture. *Beginning*: the least-squares
//! parabola through the first data points, up to a strain of 0.3 (or half of the largest strain), does not pass through zero; for a neo-Hookean curve
//! it misses zero by 1 % of the stress at the end. Or the stress stays below 2 % of that at the end over more than a tenth of these strains; for a
//! neo-Hookean curve it does so over a fiftieth. This stress is the median of a data point and two neighbours on either side.
//!
//! Limits: three or more successive data points far above the others count as a level.

use crate::calibrate::{Mode, Sample};
use crate::math::statistics::{extent, median};
use nalgebra::{DMatrix, DVector};

/// Number of neighbours on either side of a data point
const NEAR: usize = 2;
/// Shares of the largest level below which a piece is broken, and above which it is whole \[–\]
const BROKEN: f64 = 0.5;
const WHOLE: f64 = 0.9;
/// Ratio to the stretch measure at the largest level below which the stretch has gone back \[–\]
const BACK: f64 = 0.98;
/// Relative decrease of |ln λ| within one data point that only a broken piece shows, and relative stress below which it carries no load \[–\]
const SNAP: f64 = 0.5;
const NOTHING: f64 = 0.02;

/// Number of data points of one loading before the rupture.
pub fn before(samples: &[Sample]) -> usize {
    let side: Vec<f64> = samples.iter().map(|s| if s.stretch < 1.0 { -s.stress } else { s.stress }).collect();
    before_along(&samples.iter().map(|s| s.stretch.ln().abs()).collect::<Vec<f64>>(), &side)
}

/// Number of rows before the rupture, for rows with these values of |ln λ|, or of another measure that grows from rest, and these stresses, positive
/// along the stretch.
pub fn before_along(amount: &[f64], side: &[f64]) -> usize {
    let all = side.len();
    let medians = levels(side);
    let [low, high] = extent(medians.iter().copied());
    let carried: Vec<f64> = side.iter().zip(&medians).map(|(own, near)| own.min(*near)).collect();
    let Some(top) = (0..all).max_by(|a, b| carried[*a].total_cmp(&carried[*b])) else { return 0 };
    if let Some(whole) = snapped(amount, side, top) {
        return before_along(&amount[..whole], &side[..whole]);
    }
    let least = BACK * amount[top];
    // If the stresses oppose the stretch, the largest level is negative, and there is no rupture
    if high <= -low || carried[top] <= 0.0 || amount[top..].iter().any(|a| *a < least) {
        return all;
    }
    // From the end back to the last data point that carries load; a data point far above its neighbours does not count
    let is_below = |k: &usize, part: f64| side[*k] < part * carried[top] || medians[*k] < BROKEN * carried[top];
    let below = |part: f64| (top..all).rev().take_while(|k| is_below(k, part)).count();
    if below(BROKEN) == 0 { all } else { all - below(WHOLE) }
}

/// Index of the first of the final data points from which on the stretch has jumped back while the piece carries nothing: an extensometer on a broken
/// piece. `top`: index of the largest level.
fn snapped(amount: &[f64], side: &[f64], top: usize) -> Option<usize> {
    let jumps = |k: &usize| amount[k - 1] - amount[*k] > SNAP * amount[top];
    let first = (top + 1..amount.len()).find(jumps)?;
    // An unloaded piece carries nothing only near rest: a whole piece carried more at a smaller stretch before
    let carried = |k: usize| (0..first).any(|i| amount[i] <= amount[k] && side[i] > NOTHING * side[top]);
    let is_broken = |k: usize| side[k].abs() < NOTHING * side[top] && carried(k);
    (first..amount.len()).all(is_broken).then_some(first)
}

/// Medians of each stress and its neighbours.
fn levels(stress: &[f64]) -> Vec<f64> {
    let near = |k: usize| median(&stress[k.saturating_sub(NEAR)..(k + NEAR + 1).min(stress.len())]);
    (0..stress.len()).map(near).collect()
}

/// Strain up to which the beginning is examined, and the least number of data points in it
const REACH: f64 = 0.3;
const ROWS: usize = 6;
/// Largest share of the stress at the end of the beginning by which the curve may miss zero, and the number of standard errors \[–\]
const MISS: f64 = 0.04;
const ERRORS: f64 = 4.0;

/// Share of the stress at the end of the beginning below which a piece carries no load, and share of the strain there up to which that is usual \[–\]
const FLAT: f64 = 0.02;
const USUAL: f64 = 0.1;

/// A beginning that does not pass through zero.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Beginning {
    /// Stress at rest \[Pa\], and its share of the stress at the strain `to`
    Offset { stress: f64, part: f64, to: f64 },
    /// Strain up to which the piece carries less than 2 % of the stress at the strain `to`
    Slack { strain: f64, to: f64 },
}

/// The fault of the beginning of a curve, if it does not pass through zero.
pub fn beginning(samples: &[Sample], mode: Mode) -> Option<Beginning> {
    let strain = |s: &Sample| mode.strain(s.stretch).abs();
    let reach = REACH.min(0.5 * samples.iter().map(strain).fold(0.0, f64::max));
    let first: Vec<&Sample> = samples.iter().take_while(|s| strain(s) <= reach).collect();
    let (n, end) = (first.len(), first.iter().map(|s| strain(s)).fold(0.0, f64::max));
    if mode == Mode::Biaxial || n < ROWS {
        return None;
    }
    let size = first.iter().map(|s| s.stress.abs()).fold(0.0, f64::max);
    // One noisy data point does not end it
    let levels = levels(&first.iter().map(|s| s.stress).collect::<Vec<f64>>());
    let still = first.iter().zip(&levels).take_while(|(_, level)| level.abs() <= FLAT * size);
    let flat: Vec<f64> = still.map(|(s, _)| strain(s)).collect();
    if let Some(strain) = flat.last().filter(|e| **e > USUAL * end && flat.len() > 2) {
        return Some(Beginning::Slack { strain: *strain, to: end });
    }
    let a = DMatrix::from_fn(n, 3, |k, j| (strain(first[k]) / end).powi(j as i32));
    let b = DVector::from_iterator(n, first.iter().map(|s| s.stress));
    let normal = (a.transpose() * &a).try_inverse()?;
    let c = &normal * a.transpose() * &b;
    let error = ((&b - &a * &c).norm_squared() / (n - 3) as f64 * normal[(0, 0)]).sqrt();
    let found = Beginning::Offset { stress: c[0], part: c[0].abs() / size, to: end };
    (c[0].abs() > MISS * size && c[0].abs() > ERRORS * error).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(rows: impl Iterator<Item = (f64, f64)>) -> Vec<Sample> {
        rows.map(|(stretch, stress)| Sample {
            mode: Mode::Uniaxial,
            stretch,
            second: 1.0,
            stress,
            line: 1,
            specimen: 0,
        })
        .collect()
    }

    fn law(l: f64) -> f64 {
        1e5 * (l - 1.0 / (l * l))
    }

    #[test]
    fn a_broken_piece_ends_the_curve() {
        let up = || (0..60).map(|k| 1.0 + 0.05 * f64::from(k));
        let pulled = curve(up().map(|l| (l, law(l))));
        assert_eq!(before(&pulled), 60);
        let torn =
            |from: usize, rest: f64| curve(up().enumerate().map(|(k, l)| (l, if k < from { law(l) } else { rest })));
        assert_eq!([before(&torn(50, 0.0)), before(&torn(59, 300.0)), before(&torn(40, -500.0))], [50, 59, 40]);
        // Neither unloading nor softening is a rupture
        let unloaded: Vec<Sample> = pulled.iter().chain(pulled.iter().rev()).copied().collect();
        assert_eq!(before(&unloaded), 120);
        // The extensometer snaps back with the broken piece; a quick unloading to rest has no such data points
        let with = |rows: &[(f64, f64)]| curve(up().map(|l| (l, law(l))).chain(rows.iter().copied()));
        assert_eq!(before(&with(&[(1.35, 20.0), (1.33, -10.0), (1.32, 0.0)])), 60);
        let unloaded = [&[(2.0, 1.2e5), (1.3, 4e4), (1.0, 10.0)][..], &[(1.02, 10.0)]];
        assert!(unloaded.into_iter().all(|rows| before(&with(rows)) == 60 + rows.len()));
        let soft = curve(up().map(|l| (l, law(l.min(2.5)) * 0.9)));
        assert_eq!(before(&soft), 60);
        // Stresses opposite to the stretch, of which the first one is noise with the other sign
        let turned = curve(up().enumerate().map(|(k, l)| (l, if k == 0 { 5.0 } else { -law(l) })));
        assert_eq!(before(&turned), 60);
        let pressed =
            curve((0..20).map(|k| 1.0 - 0.03 * f64::from(k)).map(|l| (l, if l < 0.5 { 0.0 } else { law(l) })));
        assert_eq!(before(&pressed), pressed.iter().filter(|s| s.stress < 0.0 || s.stretch == 1.0).count());
    }

    /// One data point far above the others, anywhere in a short or long curve: the curve stays whole, and a rupture after it is found in the right
    /// place. In the tail of a broken piece it does not count as load.
    #[test]
    fn a_spike_is_no_rupture() {
        for n in [3_usize, 5, 10, 40, 200] {
            let whole = curve((1..=n).map(|k| 1.0 + k as f64 / n as f64).map(|l| (l, law(l))));
            let broken = n - n / 4;
            for k in 0..n {
                let with = |factor: f64| {
                    let mut rows = whole.clone();
                    rows[k].stress *= factor;
                    rows
                };
                assert_eq!([before(&with(2.5)), before(&with(100.0))], [n, n], "{k} of {n}");
                let mut torn = with(10.0);
                torn[broken..].iter_mut().for_each(|s| s.stress *= 1e-3);
                if n >= 10 && k + 3 < broken {
                    assert_eq!(before(&torn), broken, "{k} of {n}");
                }
            }
        }
        let mut tail =
            curve((0..60).map(|k| 1.0 + 0.05 * f64::from(k)).map(|l| (l, if l < 3.0 { law(l) } else { 0.0 })));
        let broken = before(&tail);
        tail[50].stress = 5.0 * law(3.0);
        assert_eq!([broken, before(&tail)], [40, 40]);
    }

    /// A test continues after the piece has begun to tear: the stress falls over many data points, with the noise of the machine, down to a tenth.
    #[test]
    fn a_slow_rupture_ends_the_curve_where_it_begins() {
        let noise = |k: u32| 1.0 + 0.02 * f64::from(k * 7 % 5) / 4.0;
        let at = |k: u32| {
            let l = 1.0 + 0.01 * f64::from(k);
            let left = 1.0 - 0.045 * f64::from(k.saturating_sub(150).min(20));
            (l, law(l) * left * noise(k))
        };
        let whole = before(&curve((0..300).map(at)));
        assert!((150..156).contains(&whole), "{whole}");
        // A piece that keeps more than half of its stress is not broken
        let partly = |k: u32| (at(k).0, law(at(k).0) * if k < 150 { 1.0 } else { 0.7 } * noise(k));
        assert_eq!(before(&curve((0..200).map(partly))), 200);
    }

    #[test]
    fn a_curve_that_misses_zero_is_noticed() {
        let up = |from: u32| (from..80).map(|k| 1.0 + 0.01 * f64::from(k));
        let of = |samples: Vec<Sample>| beginning(&samples, Mode::Uniaxial);
        assert_eq!(of(curve(up(0).map(|l| (l, law(l))))), None);
        assert_eq!(of(curve(up(4).map(|l| (l, law(l))))), None, "no data point at rest");
        let Some(Beginning::Offset { stress, .. }) = of(curve(up(0).map(|l| (l, law(l) + 5e3)))) else {
            panic!("5 kPa")
        };
        assert!((stress / 5e3 - 1.0).abs() < 0.2, "{stress}");
        for slack in [0.05, 0.1, 0.2] {
            let Some(Beginning::Slack { strain, .. }) = of(curve(up(0).map(|l| (l, law((l - slack).max(1.0)))))) else {
                panic!("{slack}")
            };
            assert!((strain - slack).abs() < 0.02, "{strain}");
        }
        // One noisy data point inside the slack
        for noisy in 0..8 {
            let mut rows = curve(up(0).map(|l| (l, law((l - 0.1).max(1.0)))));
            rows[noisy].stress += 0.05 * law(1.2);
            let Some(Beginning::Slack { strain, .. }) = of(rows) else { panic!("data point {noisy}") };
            assert!((strain - 0.1).abs() < 0.02, "{strain}");
        }
        let pressed = curve((0..60).map(|k| 1.0 - 0.01 * f64::from(k)).map(|l| (l, law(l))));
        assert_eq!(beginning(&pressed, Mode::Uniaxial), None);
    }
}
