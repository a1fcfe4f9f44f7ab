//! Nonnegative least squares with columns that may be nearly dependent, such as those of a Prony series.
//!
//! Ordinary least squares if the solution is feasible; otherwise the convex problem is solved by clarabel, its active set is solved by QR, and the
//! Karush–Kuhn–Tucker conditions are restored factor by factor (Lawson & Hanson, *Solving Least Squares Problems*, 1974, ch. 23), as they are from a guess of the active set.

use crate::math::convex::{NonnegativeConeT, Unfinished, minimum};
use nalgebra::{DMatrix, DVector};

/// Size relative to the largest factor below which a factor of clarabel counts as zero \[–\], with columns of length 1
const ZERO: f64 = 1e-7;
/// Gradient of a factor at zero that counts as zero, relative to ‖y‖ \[–\]
const FLAT: f64 = 1e-11;

/// Returns the factors c ≥ 0 that minimise ‖Ac − y‖; they are exactly zero where the bound is active. A `guess` of the columns with positive factors, as
/// those of a similar problem, saves the convex program where it leads to the minimum.
pub fn dense_weights(a: &DMatrix<f64>, y: &DVector<f64>, guess: Option<&[usize]>) -> Result<DVector<f64>, Unfinished> {
    let n = a.ncols();
    let length: Vec<f64> = a.column_iter().map(|c| c.norm()).map(|l| if l > 0.0 { l } else { 1.0 }).collect();
    let scaled = DMatrix::from_fn(a.nrows(), n, |i, k| a[(i, k)] / length[k]);
    let natural = |z: DVector<f64>| DVector::from_fn(n, |k, _| z[k] / length[k]);
    let all: Vec<usize> = (0..n).collect();
    if let Some(z) = least_squares(&scaled, y, &all).filter(|z| z.iter().all(|z| *z >= 0.0)) {
        return Ok(natural(z));
    }
    let size = y.norm();
    if let Some(z) = guess.map(|g| restored(&scaled, y, g.to_vec())).filter(|z| is_minimum(&scaled, y, z)) {
        return Ok(natural(z));
    }
    let first = convex(&scaled, y, size)?;
    let largest = first.amax();
    Ok(natural(restored(&scaled, y, (0..n).filter(|k| first[*k] > ZERO * largest).collect())))
}

/// Factors with the columns of `active`, which gains and loses columns until the conditions of Karush, Kuhn and Tucker hold; the best of its sets.
fn restored(a: &DMatrix<f64>, y: &DVector<f64>, mut active: Vec<usize>) -> DVector<f64> {
    let (n, size) = (a.ncols(), y.norm());
    let mut z = DVector::zeros(n);
    // Each pass adds or removes a factor
    for _ in 0..10 * (n + 1) {
        let Some(next) = least_squares(a, y, &active) else { break };
        if let Some(worst) =
            active.iter().copied().filter(|k| next[*k] <= 0.0).min_by(|a, b| next[*a].total_cmp(&next[*b]))
        {
            active.retain(|k| *k != worst);
            continue;
        }
        if (y - a * &next).norm() <= (y - a * &z).norm() {
            z = next;
        }
        let gradient = a.tr_mul(&(y - a * &z));
        let outside = (0..n).filter(|k| !active.contains(k));
        match outside.max_by(|a, b| gradient[*a].total_cmp(&gradient[*b])).filter(|k| gradient[*k] > FLAT * size) {
            Some(k) => {
                active.push(k);
                active.sort_unstable();
                // A column admitted only because of rounding would enter and leave repeatedly
                if least_squares(a, y, &active).is_none_or(|z| z[k] <= 0.0) {
                    break;
                }
            }
            None => break,
        }
    }
    z
}

/// Whether no column at zero would reduce the residual: the condition of the minimum for a solution of least squares in its positive factors.
fn is_minimum(a: &DMatrix<f64>, y: &DVector<f64>, z: &DVector<f64>) -> bool {
    let gradient = a.tr_mul(&(y - a * z));
    gradient.iter().zip(z.iter()).all(|(g, z)| *z > 0.0 || *g <= FLAT * y.norm())
}

/// Least squares in the `picked` columns, zero in the others; `None` if these columns are linearly dependent.
fn least_squares(a: &DMatrix<f64>, y: &DVector<f64>, picked: &[usize]) -> Option<DVector<f64>> {
    if picked.is_empty() || a.nrows() < picked.len() {
        return None;
    }
    let qr = a.select_columns(picked).qr();
    let mut d = y.clone();
    qr.q_tr_mul(&mut d);
    let c = qr.r().solve_upper_triangular(&d.rows(0, picked.len()).into_owned())?;
    let mut all = DVector::zeros(a.ncols());
    picked.iter().zip(c.iter()).for_each(|(k, c)| all[*k] = *c);
    all.iter().all(|c| c.is_finite()).then_some(all)
}

/// The factors by clarabel, for columns of length 1.
fn convex(a: &DMatrix<f64>, y: &DVector<f64>, size: f64) -> Result<DVector<f64>, Unfinished> {
    let n = a.ncols();
    let (h, f) = (a.tr_mul(a), a.tr_mul(y) / size.max(f64::MIN_POSITIVE));
    let (bound, zero) = (DMatrix::from_diagonal_element(n, n, -1.0), DVector::zeros(n));
    minimum((&h, &-f), (&bound, &zero), &[NonnegativeConeT(n)], None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::statistics::smaller;

    /// The minimum over all subsets of columns, by trying each.
    fn every_subset(a: &DMatrix<f64>, y: &DVector<f64>) -> f64 {
        let n = a.ncols();
        let sets = (1..1_usize << n).map(|mask| (0..n).filter(|k| mask >> k & 1 == 1).collect::<Vec<_>>());
        let fits = sets.filter_map(|set| least_squares(a, y, &set)).filter(|z| z.iter().all(|z| *z >= 0.0));
        fits.map(|z| (y - a * z).norm()).fold(y.norm(), smaller)
    }

    /// Six decays, some of which the data contradict: the solution is the best of all subsets, and bounds are active in most of the cases.
    #[test]
    fn the_best_of_all_subsets_is_found() {
        let times: Vec<f64> = (0..60).map(|k| 0.05 * 1.15_f64.powi(k)).collect();
        let a =
            DMatrix::from_fn(60, 6, |i, k| if k == 0 { 1.0 } else { (-times[i] / 0.1 / 4_f64.powi(k as i32)).exp() });
        let mut zeros = 0;
        for n in 0..40 {
            let y = DVector::from_fn(60, |i, _| {
                let t = times[i];
                2.0 + (-t / (0.3 + 0.2 * f64::from(n))).exp() + 0.02 * ((7 * i + 3 * n as usize) as f64).sin()
            });
            let c = dense_weights(&a, &y, None).expect("solved");
            for guess in [&[][..], &[0], &[1, 3, 5], &[0, 1, 2, 3, 4, 5]] {
                let guessed = dense_weights(&a, &y, Some(guess)).expect("solved");
                assert!((guessed - &c).amax() <= 1e-9 * c.amax(), "{n}: with a guess of {guess:?}");
            }
            let (own, best) = ((&y - &a * &c).norm(), every_subset(&a, &y));
            zeros += c.iter().filter(|c| **c == 0.0).count();
            assert!(c.iter().all(|c| *c >= 0.0) && own <= best * (1.0 + 1e-9), "{n}: {own} above {best}");
        }
        assert!(zeros > 40, "the bounds matter: {zeros}");
    }
}
