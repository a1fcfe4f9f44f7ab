//! Data points after the rupture of a test piece, and the beginning of a curve that does not start at zero.
//!
//! *Rupture*: the stress falls below half of its largest value and stays there to the end, while the stretch does not go back. The data points
//! from the first one below 90 % of the largest stress on are left out. *Beginning*: the parabola of least squares through the first
//! data points, up to a strain of 0.3 (or half of the largest one), does not go through zero; a Neo-Hookean curve makes it miss by 1 % of
//! the stress at the end. Or the stress stays below 2 % of that at the end over more than a tenth of these strains; a Neo-Hookean curve
//! does so over a fiftieth.

use crate::calibrate::{Mode, Sample};
use nalgebra::{DMatrix, DVector};

/// Parts of the largest stress below which a piece is broken, and above which it is whole \[–\]
const BROKEN: f64 = 0.5;
const WHOLE: f64 = 0.9;
/// The stretch has gone back where it is below this part of the one at the largest stress \[–\]
const BACK: f64 = 0.98;

/// How many of these data points of one loading come before the rupture.
pub fn before(samples: &[Sample]) -> usize {
    let side = |s: &Sample| if s.stretch < 1.0 { -s.stress } else { s.stress };
    let all = samples.len();
    // Of stresses against the stretch the largest one is negative, and no rupture
    let size = |k: &usize| side(&samples[*k]).abs();
    let Some(top) = (0..all).max_by(|a, b| size(a).total_cmp(&size(b))) else { return 0 };
    let largest = side(&samples[top]);
    let after = &samples[top..];
    let amount = |s: &Sample| s.stretch.ln().abs();
    let least = BACK * amount(&samples[top]);
    if largest <= 0.0 || !after.iter().all(|s| amount(s) >= least) {
        return all;
    }
    // From the end back to the last data point that carries
    let low = |part: f64| after.iter().rev().take_while(|s| side(s) < part * largest).count();
    if low(BROKEN) == 0 { all } else { all - low(WHOLE) }
}

/// Strain up to which the beginning is looked at, and data points of it at least
const REACH: f64 = 0.3;
const ROWS: usize = 6;
/// Part of the stress at the end of the beginning that the curve may miss zero by, and how many standard errors \[–\]
const MISS: f64 = 0.04;
const ERRORS: f64 = 4.0;

/// Part of the stress at the end of the beginning below which a piece does not carry, and part of the strain there up to which that is usual \[–\]
const FLAT: f64 = 0.02;
const USUAL: f64 = 0.1;

/// A beginning that does not go through zero.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Beginning {
    /// Stress at rest \[Pa\], its part of the stress at the strain `to`
    Offset { stress: f64, part: f64, to: f64 },
    /// Strain up to which the piece carries less than 2 % of the stress at the strain `to`
    Slack { strain: f64, to: f64 },
}

/// The beginning of a curve, where it does not go through zero.
pub fn beginning(samples: &[Sample], mode: Mode) -> Option<Beginning> {
    let strain = |s: &Sample| mode.strain(s.stretch).abs();
    let reach = REACH.min(0.5 * samples.iter().map(strain).fold(0.0, f64::max));
    let first: Vec<&Sample> = samples.iter().take_while(|s| strain(s) <= reach).collect();
    let (n, end) = (first.len(), first.iter().map(|s| strain(s)).fold(0.0, f64::max));
    if mode == Mode::Biaxial || n < ROWS {
        return None;
    }
    let size = first.iter().map(|s| s.stress.abs()).fold(0.0, f64::max);
    let flat: Vec<f64> = first.iter().take_while(|s| s.stress.abs() <= FLAT * size).map(|s| strain(s)).collect();
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
        // Unloading is no rupture, and neither is softening
        let unloaded: Vec<Sample> = pulled.iter().chain(pulled.iter().rev()).copied().collect();
        assert_eq!(before(&unloaded), 120);
        let soft = curve(up().map(|l| (l, law(l.min(2.5)) * 0.9)));
        assert_eq!(before(&soft), 60);
        // Stresses against the stretch, whose first one is noise of the other sign
        let turned = curve(up().enumerate().map(|(k, l)| (l, if k == 0 { 5.0 } else { -law(l) })));
        assert_eq!(before(&turned), 60);
        let pressed =
            curve((0..20).map(|k| 1.0 - 0.03 * f64::from(k)).map(|l| (l, if l < 0.5 { 0.0 } else { law(l) })));
        assert_eq!(before(&pressed), pressed.iter().filter(|s| s.stress < 0.0 || s.stretch == 1.0).count());
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
        let pressed = curve((0..60).map(|k| 1.0 - 0.01 * f64::from(k)).map(|l| (l, law(l))));
        assert_eq!(beginning(&pressed, Mode::Uniaxial), None);
    }
}
