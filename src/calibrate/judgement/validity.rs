//! Range of stretch in which a fitted law is within a tolerance of the data.

use super::misfit::Residual;
use crate::calibrate::{Mode, Validity};

/// Misfit below this part of the rms stress of the fitted data points does not end a range: at small stretches it is noise, slack or the resolution
/// of the machine \[–\]
const FLOOR: f64 = 0.02;

/// Part of the data points, those nearest to rest, that a range may leave out: slack and offsets of the zero are large against their stresses \[–\]
const LEFT_OUT: f64 = 0.1;

/// The range on both sides of rest; `fitted` are the residuals of the fitted data points.
pub fn validity(all: &[Residual], fitted: &[Residual], modes: &[Mode], tolerance: f64) -> Validity {
    let budget = FLOOR * FLOOR * fitted.iter().map(|r| r.measured.powi(2)).sum::<f64>();
    let side = |tension: bool| {
        let on_side = |r: &&Residual| modes.contains(&r.mode) && if tension { r.reach > 1.0 } else { r.reach < 1.0 };
        let mut rows: Vec<_> = all.iter().filter(on_side).collect();
        rows.sort_by(|a, b| (a.reach - 1.0).abs().total_cmp(&(b.reach - 1.0).abs()));
        let most = (LEFT_OUT * rows.len() as f64) as usize;
        let after = |skipped: usize| {
            let (to, from) = range(&rows[skipped..], tolerance, budget)?;
            let first = (skipped > 0).then_some(rows.get(skipped)?.reach);
            Some((to, from.or(first)))
        };
        (0..=most).find_map(after)
    };
    let (compression, tension) = (side(false), side(true));
    Validity {
        tolerance,
        compression_to: compression.map(|s| s.0),
        compression_from: compression.and_then(|s| s.1),
        tension_to: tension.map(|s| s.0),
        tension_from: tension.and_then(|s| s.1),
    }
}

/// End of the range of rows by distance from rest, and where it begins if not at the first of them.
fn range(rows: &[&Residual], tolerance: f64, budget: f64) -> Option<(f64, Option<f64>)> {
    let (mut r2, mut p2) = (0.0, 0.0);
    let sums = rows.iter().map(|row| {
        (r2, p2) = (r2 + row.residual.powi(2), p2 + row.measured.powi(2));
        (r2, tolerance * tolerance * p2)
    });
    // A range beyond one where the fit was bad is not to be trusted
    let sums: Vec<(f64, f64)> = sums.take_while(|(r2, allowed)| *r2 <= allowed + budget).collect();
    let to = sums.iter().rposition(|(r2, allowed)| r2 <= allowed)?;
    let from = sums[..to].iter().rposition(|(r2, allowed)| r2 > allowed).map(|k| rows[k + 1].reach);
    Some((rows[to].reach, from))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stretches 1.05, 1.10, … with these residuals over a stress that grows by 10 kPa from row to row.
    fn tension(residuals: &[f64]) -> (Option<f64>, Option<f64>) {
        let row = |(k, residual): (usize, &f64)| {
            let (stretch, measured) = (1.0 + 0.05 * (k + 1) as f64, 1e4 * (k + 1) as f64);
            Residual {
                mode: Mode::Uniaxial,
                stretch,
                reach: stretch,
                measured,
                law: measured - residual,
                residual: *residual,
                line: 2,
            }
        };
        let all: Vec<Residual> = residuals.iter().enumerate().map(row).collect();
        let found = validity(&all, &all, &[Mode::Uniaxial], 0.1);
        (found.tension_from, found.tension_to)
    }

    #[test]
    fn slack_does_not_end_the_range_and_a_bad_middle_does() {
        let mut residuals = [100.0; 20];
        assert_eq!(tension(&residuals), (None, Some(2.0)));
        residuals[0] = 2e4;
        residuals[1] = 1.5e4;
        let (from, to) = tension(&residuals);
        assert!(from.is_some_and(|from| from <= 1.15) && to == Some(2.0), "{from:?} {to:?}");
        let mut residuals = [100.0; 20];
        residuals[8..12].fill(1e5);
        let (_, to) = tension(&residuals);
        assert!(to.is_some_and(|to| to < 1.45), "{to:?}");
    }
}
