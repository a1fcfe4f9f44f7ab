//! Flexible GMRES without restarts: x with ‖b − A x‖ ≤ bound from products A v and approximate inverses P⁻¹ r.
//!
//! Source: Saad, SIAM J. Sci. Comput. 14, 1993, algorithm 2.2: the Arnoldi basis of A P⁻¹ by modified Gram–Schmidt, the least-squares problem by
//! Givens rotations. Neither A nor P need be symmetric or definite. Limits: all directions are stored, so that P has to be close to A.

use super::linear::LinearError;
use super::vector::{dot, norm};

/// Solves A x = b with at most `most` products; returns x and the number of products that it took.
///
/// # Errors
///
/// [`LinearError::Inaccurate`] if the residual is still above the `bound`, [`LinearError::Singular`] if A P⁻¹ is singular, and the errors of
/// `precondition`.
pub fn gmres(
    mut multiply: impl FnMut(&[f64]) -> Vec<f64>,
    mut precondition: impl FnMut(&[f64]) -> Result<Vec<f64>, LinearError>,
    b: &[f64],
    bound: f64,
    most: usize,
) -> Result<(Vec<f64>, usize), LinearError> {
    let (mut x, size) = (vec![0.0; b.len()], norm(b));
    if size <= bound {
        return Ok((x, 0));
    }
    let mut basis: Vec<Vec<f64>> = vec![b.iter().map(|b| b / size).collect()];
    // P⁻¹ times the basis, the columns of R, the Givens rotations (c, s) that produced them, and the rotated right-hand side
    let (mut directions, mut r) = (Vec::<Vec<f64>>::new(), Vec::<Vec<f64>>::new());
    let (mut turns, mut rhs) = (Vec::<(f64, f64)>::new(), vec![size]);
    // NaN is not below the bound.
    while rhs[r.len()].abs() > bound || rhs[r.len()].is_nan() {
        let k = r.len();
        if k == most || !rhs[k].is_finite() {
            return Err(LinearError::Inaccurate { residual: rhs[k].abs() / size });
        }
        let z = precondition(&basis[k])?;
        let mut w = multiply(&z);
        directions.push(z);
        let mut column: Vec<f64> = Vec::with_capacity(k + 1);
        for v in &basis {
            let h = dot(&w, v);
            w.iter_mut().zip(v).for_each(|(w, v)| *w -= h * v);
            column.push(h);
        }
        for (i, &(c, s)) in turns.iter().enumerate() {
            (column[i], column[i + 1]) = (c * column[i] + s * column[i + 1], c * column[i + 1] - s * column[i]);
        }
        let rest = norm(&w);
        let length = column[k].hypot(rest);
        if length == 0.0 {
            return Err(LinearError::Singular);
        }
        let (c, s) = (column[k] / length, rest / length);
        column[k] = length;
        rhs.push(-s * rhs[k]);
        rhs[k] *= c;
        turns.push((c, s));
        r.push(column);
        // If w vanishes, the residual is zero and the loop ends.
        basis.push(w.iter().map(|w| w / rest.max(f64::MIN_POSITIVE)).collect());
    }
    for i in (0..r.len()).rev() {
        rhs[i] /= r[i][i];
        for j in 0..i {
            rhs[j] -= r[i][j] * rhs[i];
        }
    }
    for (z, y) in directions.iter().zip(&rhs[..r.len()]) {
        x.iter_mut().zip(z).for_each(|(x, z)| *x += y * z);
    }
    Ok((x, r.len()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix;

    const TOLERANCE: f64 = 1e-10;

    /// D (I + a skew part of norm about 1) on 40 unknowns, with a D of both signs that also serves as P.
    #[test]
    fn solves_to_its_bound() {
        let n = 40;
        let mut random = SplitMix(5);
        let mut skew = vec![0.0; n * n];
        for (i, j) in (0..n).flat_map(|i| (0..i).map(move |j| (i, j))) {
            let value = 0.2 * (random.unit() - 0.5);
            (skew[i * n + j], skew[j * n + i]) = (value, -value);
        }
        let d: Vec<f64> = (0..n).map(|i| (1.0 + i as f64) * if i % 3 == 0 { -1.0 } else { 1.0 }).collect();
        let multiply =
            |v: &[f64]| -> Vec<f64> { (0..n).map(|i| d[i] * (v[i] + dot(&skew[i * n..(i + 1) * n], v))).collect() };
        let precondition = |r: &[f64]| Ok(r.iter().zip(&d).map(|(r, d)| r / d).collect());
        let b: Vec<f64> = (0..n).map(|_| random.unit()).collect();
        let bound = TOLERANCE * norm(&b);
        let (x, products) = gmres(multiply, precondition, &b, bound, n).expect("regular");
        let left: Vec<f64> = multiply(&x).iter().zip(&b).map(|(a, b)| a - b).collect();
        // The residual of the recurrence and the true residual differ by rounding: 1e-13
        assert!(norm(&left) <= 1.001 * bound && products < n, "{:e} {products}", norm(&left));
        let slow = gmres(multiply, precondition, &b, bound, products - 1);
        assert!(matches!(slow, Err(LinearError::Inaccurate { .. })), "{slow:?}");
        let same = |v: &[f64]| v.to_vec();
        let (x, products) = gmres(same, |r| Ok(r.to_vec()), &b, bound, n).expect("the identity");
        assert!(x.iter().zip(&b).all(|(x, b)| (x - b).abs() < 1e-15) && products == 1);
    }

    #[test]
    fn names_a_singular_matrix() {
        let zero = |v: &[f64]| vec![0.0; v.len()];
        let same = |v: &[f64]| Ok(v.to_vec());
        assert_eq!(gmres(zero, same, &[1.0, 2.0], 1e-10, 5), Err(LinearError::Singular));
        assert_eq!(gmres(zero, same, &[0.0, 0.0], 1e-10, 5), Ok((vec![0.0, 0.0], 0)));
        let undefined = |v: &[f64]| vec![f64::NAN; v.len()];
        assert!(matches!(gmres(undefined, same, &[1.0, 2.0], 1e-10, 5), Err(LinearError::Inaccurate { .. })));
    }
}
