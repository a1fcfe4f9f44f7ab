//! Singular value decompositions that terminate for every matrix.

use nalgebra::{DMatrix, DVector, Dyn, SVD};

/// Number of sweeps allowed to nalgebra's iteration for each singular value; it usually takes a few.
const SWEEPS: usize = 100;

/// The thin decomposition with singular values in descending order. nalgebra's iteration does not converge for some matrices with many equal rows;
/// faer's divide and conquer handles those. The singular values of a matrix that is not finite are NaN.
pub fn svd(matrix: DMatrix<f64>, u: bool, v: bool) -> SVD<f64, Dyn, Dyn> {
    if matrix.is_empty() {
        return nothing(&matrix);
    }
    let sweeps = SWEEPS * matrix.nrows().min(matrix.ncols()).max(1);
    if matrix.iter().all(|x| x.is_finite())
        && let Some(found) = matrix.clone().try_svd(u, v, 5.0 * f64::EPSILON, sweeps)
    {
        return found;
    }
    by_faer(&matrix)
}

fn by_faer(m: &DMatrix<f64>) -> SVD<f64, Dyn, Dyn> {
    let k = m.nrows().min(m.ncols());
    match faer::Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)]).thin_svd() {
        Ok(found) if m.iter().all(|x| x.is_finite()) => {
            let (u, s, v) = (found.U(), found.S().column_vector(), found.V());
            SVD {
                u: Some(DMatrix::from_fn(m.nrows(), k, |i, j| u[(i, j)])),
                v_t: Some(DMatrix::from_fn(k, m.ncols(), |i, j| v[(j, i)])),
                singular_values: DVector::from_fn(k, |i, _| s[i]),
            }
        }
        _ => nothing(m),
    }
}

/// The decomposition of an empty matrix, or of one whose singular values are NaN.
fn nothing(m: &DMatrix<f64>) -> SVD<f64, Dyn, Dyn> {
    let k = m.nrows().min(m.ncols());
    SVD {
        u: Some(DMatrix::zeros(m.nrows(), k)),
        v_t: Some(DMatrix::zeros(k, m.ncols())),
        singular_values: DVector::from_element(k, f64::NAN),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both methods reproduce the matrix, with the same singular values, up to the rounding of sums of a few dozen products.
    #[test]
    fn both_methods_agree() {
        for (n, p) in [(40, 3), (3, 3), (2, 5)] {
            let m = DMatrix::from_fn(n, p, |i, j| ((i * 7 + j * 3) % 11) as f64 - 4.0 + (i * j) as f64 / 9.0);
            let [a, b] = [svd(m.clone(), true, true), by_faer(&m)];
            assert!((&a.singular_values - &b.singular_values).amax() < 1e-12 * a.singular_values.max());
            for found in [a, b] {
                assert!((found.recompose().expect("both factors") - &m).amax() < 1e-12 * m.amax());
            }
        }
        let faulty = svd(DMatrix::from_element(3, 2, f64::NAN), true, true);
        assert!(faulty.singular_values.iter().all(|s| s.is_nan()));
        assert!(svd(DMatrix::zeros(4, 0), true, true).singular_values.is_empty());
    }
}
