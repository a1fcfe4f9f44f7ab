//! Range of stretch in which a fitted law is within a tolerance of the data.

use super::misfit::Residual;
use crate::calibrate::{Mode, Validity};

/// Misfit below this part of the rms stress of the fitted data points does not end a range: at small stretches it is noise, slack or the resolution
/// of the machine \[–\]
const FLOOR: f64 = 0.02;

/// The range on both sides of rest; `fitted` are the residuals of the fitted data points.
pub fn validity(all: &[Residual], fitted: &[Residual], modes: &[Mode], tolerance: f64) -> Validity {
    let budget = FLOOR * FLOOR * fitted.iter().map(|r| r.measured.powi(2)).sum::<f64>();
    let side = |tension: bool| {
        let on_side =
            |r: &&Residual| modes.contains(&r.mode) && if tension { r.stretch > 1.0 } else { r.stretch < 1.0 };
        let mut rows: Vec<_> = all.iter().filter(on_side).collect();
        rows.sort_by(|a, b| (a.stretch - 1.0).abs().total_cmp(&(b.stretch - 1.0).abs()));
        let (mut r2, mut p2) = (0.0, 0.0);
        let sums = rows.iter().map(|row| {
            (r2, p2) = (r2 + row.residual.powi(2), p2 + row.measured.powi(2));
            (r2, tolerance * tolerance * p2)
        });
        // A range beyond one where the fit was bad is not to be trusted
        let sums: Vec<(f64, f64)> = sums.take_while(|(r2, allowed)| *r2 <= allowed + budget).collect();
        let to = sums.iter().rposition(|(r2, allowed)| r2 <= allowed)?;
        let from = sums[..to].iter().rposition(|(r2, allowed)| r2 > allowed).map(|k| rows[k + 1].stretch);
        Some((rows[to].stretch, from))
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
