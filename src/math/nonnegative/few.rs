//! Nonnegative least squares with a handful of columns: exact, by trying every subset.

use nalgebra::{DMatrix, DVector};

/// Returns R and Qᵀp of the QR decomposition of a matrix, which is all that least squares in its columns need.
pub fn reduce(a: &DMatrix<f64>, p: &DVector<f64>) -> (DMatrix<f64>, DVector<f64>) {
    let n = a.ncols();
    let qr = a.clone().resize_vertically(a.nrows().max(n), 0.0).qr();
    let mut d = p.clone().resize_vertically(a.nrows().max(n), 0.0);
    qr.q_tr_mul(&mut d);
    (qr.r(), d.resize_vertically(n, 0.0))
}

/// Minimises ‖Rc − d‖ over c ≥ 0 in the picked columns: of the least-squares solutions with positive factors, over all subsets, the best one is the
/// minimum of this convex problem. Returns the factors, and the part of ‖d‖² that they explain.
pub fn few_weights(r: &DMatrix<f64>, d: &DVector<f64>, picked: &[usize]) -> (Vec<f64>, f64) {
    let n = picked.len();
    let mut best = (vec![0.0; n], 0.0);
    // The full set comes first: if its solution is feasible, it is the minimum
    for mask in (1..1_usize << n).rev() {
        let own: Vec<usize> = (0..n).filter(|k| mask >> k & 1 == 1).collect();
        let a = r.select_columns(&own.iter().map(|k| picked[*k]).collect::<Vec<_>>());
        let qr = a.qr();
        let mut q = d.clone();
        qr.q_tr_mul(&mut q);
        let head = q.rows(0, own.len()).into_owned();
        let Some(c) = qr.r().solve_upper_triangular(&head) else { continue };
        if c.iter().any(|c| *c <= 0.0 || !c.is_finite()) {
            continue;
        }
        let explained = head.norm_squared();
        if explained > best.1 {
            let mut full = vec![0.0; n];
            own.iter().zip(&c).for_each(|(k, c)| full[*k] = *c);
            best = (full, explained);
        }
        if own.len() == n {
            break;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Karush–Kuhn–Tucker conditions: no factor is negative, and the residual is orthogonal to the columns with positive factors and points away from
    /// the others.
    #[test]
    fn the_conditions_of_the_minimum_hold() {
        let entry = |i: usize, k: usize| ((1 + i) as f64 * (0.3 + 0.41 * k as f64)).sin();
        let a = DMatrix::from_fn(9, 4, entry);
        let mut zeros = 0;
        for n in 0..20 {
            let p = DVector::from_fn(9, |i, _| (1.7 * (i + n) as f64 * (1.0 + 0.1 * n as f64)).cos());
            let (r, d) = reduce(&a, &p);
            let c = DVector::from_vec(few_weights(&r, &d, &[0, 1, 2, 3]).0);
            let slope = a.transpose() * (&p - &a * &c);
            for k in 0..4 {
                zeros += usize::from(c[k] == 0.0);
                assert!(
                    c[k] >= 0.0 && slope[k] < 1e-12 && (c[k] == 0.0 || slope[k].abs() < 1e-12),
                    "{n} {k}: {c} {slope}"
                );
            }
        }
        assert!(zeros > 10, "the bound matters in some of the cases");
    }
}
