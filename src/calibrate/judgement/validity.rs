//! Range of stretch in which a fitted law is within a tolerance of the data.

use super::misfit::{Residual, residuals};
use crate::calibrate::sample::{Test, by_test};
use crate::calibrate::{Sample, ValidRange, Validity};

/// Misfit, relative to the rms stress of the fitted data points, below which a range does not end: at small stretches it is noise, slack or the
/// resolution of the machine \[–\]
pub const FLOOR: f64 = 0.02;

/// Share of the data points, those nearest to rest, that a range may leave out: slack and offsets of the zero are large compared with their stresses
/// \[–\]
const LEFT_OUT: f64 = 0.1;

/// The range of validity for each test of these data points, given the stresses of the law; `fitted`: the residuals of the fitted data points.
pub fn validity(samples: &[Sample], law: impl Fn(&Sample) -> f64, fitted: &[Residual], tolerance: f64) -> Validity {
    let budget = FLOOR * FLOOR * fitted.iter().map(|r| r.measured.powi(2)).sum::<f64>();
    let of = |(test, own): (Test, Vec<Sample>)| {
        let amount = |r: &Residual| r.reach.ln().abs();
        let is_off_rest = |r: &Residual| r.reach != 1.0 && (!test.has_sides() || (r.reach < 1.0) == test.compression);
        let mut rows: Vec<Residual> = residuals(&own, &law).into_iter().filter(is_off_rest).collect();
        rows.sort_by(|a, b| amount(a).total_cmp(&amount(b)));
        let most = (LEFT_OUT * rows.len() as f64) as usize;
        let after = |skipped: usize| {
            let (to, from) = range(&rows[skipped..], tolerance, budget)?;
            let first = (skipped > 0).then_some(rows.get(skipped)?.reach);
            Some((to, from.or(first)))
        };
        let found = (0..=most).find_map(after);
        ValidRange { test, from: found.and_then(|(_, from)| from), to: found.map(|(to, _)| to) }
    };
    Validity { tolerance, tests: by_test(samples).into_iter().map(of).collect() }
}

/// End of the range of rows by distance from rest, and its beginning if it is not the first row.
fn range(rows: &[Residual], tolerance: f64, budget: f64) -> Option<(f64, Option<f64>)> {
    let (mut r2, mut p2) = (0.0, 0.0);
    let sums = rows.iter().map(|row| {
        (r2, p2) = (r2 + row.residual.powi(2), p2 + row.measured.powi(2));
        (r2, tolerance * tolerance * p2)
    });
    // A range that continues beyond a bad fit is not to be trusted
    let sums: Vec<(f64, f64)> = sums.take_while(|(r2, allowed)| *r2 <= allowed + budget).collect();
    let to = sums.iter().rposition(|(r2, allowed)| r2 <= allowed)?;
    let from = sums[..to].iter().rposition(|(r2, allowed)| r2 > allowed).map(|k| rows[k + 1].reach);
    Some((rows[to].reach, from))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::Mode;

    /// Stretches 1.05, 1.10, … with these residuals over a stress that grows by 10 kPa from row to row.
    fn tension(residuals: &[f64]) -> (Option<f64>, Option<f64>) {
        let row = |k: usize| Sample {
            mode: Mode::Uniaxial,
            stretch: 1.0 + 0.05 * (k + 1) as f64,
            second: 1.0,
            stress: 1e4 * (k + 1) as f64,
            line: k as u64,
            specimen: 0,
        };
        let samples: Vec<Sample> = (0..residuals.len()).map(row).collect();
        let law = |s: &Sample| s.stress - residuals[s.line as usize];
        let found = validity(&samples, law, &super::residuals(&samples, law), 0.1);
        (found.tests[0].from, found.tests[0].to)
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
