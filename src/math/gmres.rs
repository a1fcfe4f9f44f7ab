//! Generalised minimal residuals without restarts: x with ‖b − M x‖ ≤ 1e-10 ‖b‖ from products M v alone.
//!
//! Source: Saad & Schultz, SIAM J. Sci. Stat. Comput. 7, 1986, algorithm 3: Arnoldi's basis by modified Gram–Schmidt, the least
//! squares by Givens rotations. Limits: for an M near the identity, which takes a few products; every one is kept.

use super::linear::LinearError;
use super::vector::{dot, norm};

/// ‖b − M x‖/‖b‖
const TOLERANCE: f64 = 1e-10;
/// Products that are tried.
const MOST: usize = 100;

/// Solves M x = b; `apply` gives M v.
pub fn gmres(
    mut apply: impl FnMut(&[f64]) -> Result<Vec<f64>, LinearError>,
    b: &[f64],
) -> Result<Vec<f64>, LinearError> {
    let size = norm(b);
    if size == 0.0 {
        return Ok(b.to_vec());
    }
    let mut basis: Vec<Vec<f64>> = vec![b.iter().map(|b| b / size).collect()];
    // Columns of R, the rotations (c, s) that made them, and the right side they turned
    let (mut r, mut turns, mut rhs) = (Vec::<Vec<f64>>::new(), Vec::<(f64, f64)>::new(), vec![size]);
    while rhs[r.len()].abs() > TOLERANCE * size {
        let k = r.len();
        if k == MOST || !rhs[k].is_finite() {
            return Err(LinearError::Inaccurate { residual: rhs[k].abs() / size });
        }
        let mut w = apply(&basis[k])?;
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
        // Where nothing is left of w the residual is zero, and the loop ends.
        basis.push(w.iter().map(|w| w / rest.max(f64::MIN_POSITIVE)).collect());
    }
    for i in (0..r.len()).rev() {
        rhs[i] /= r[i][i];
        for j in 0..i {
            rhs[j] -= r[i][j] * rhs[i];
        }
    }
    let mut x = vec![0.0; b.len()];
    for (v, y) in basis.iter().zip(&rhs[..r.len()]) {
        x.iter_mut().zip(v).for_each(|(x, v)| *x += y * v);
    }
    Ok(x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix;

    /// M = I + a skew part of norm about 1 on 40 unknowns: M x against b, and a b of one product.
    #[test]
    fn solves_to_its_tolerance() {
        let n = 40;
        let mut random = SplitMix(5);
        let mut skew = vec![0.0; n * n];
        for (i, j) in (0..n).flat_map(|i| (0..i).map(move |j| (i, j))) {
            let value = 0.2 * (random.unit() - 0.5);
            (skew[i * n + j], skew[j * n + i]) = (value, -value);
        }
        let apply = |v: &[f64]| -> Vec<f64> { (0..n).map(|i| v[i] + dot(&skew[i * n..(i + 1) * n], v)).collect() };
        let b: Vec<f64> = (0..n).map(|_| random.unit()).collect();
        let mut products = 0;
        let count = |v: &[f64]| {
            products += 1;
            Ok(apply(v))
        };
        let x = gmres(count, &b).expect("regular");
        let left: Vec<f64> = apply(&x).iter().zip(&b).map(|(a, b)| a - b).collect();
        // The recurrence and the true residual differ by rounding: 1e-13
        assert!(norm(&left) <= 1.001 * TOLERANCE * norm(&b) && products < n, "{:e} {products}", norm(&left));
        let same = gmres(|v| Ok(v.to_vec()), &b).expect("the identity");
        assert!(same.iter().zip(&b).all(|(x, b)| (x - b).abs() < 1e-15));
    }

    #[test]
    fn names_a_singular_matrix() {
        assert_eq!(gmres(|v| Ok(vec![0.0; v.len()]), &[1.0, 2.0]), Err(LinearError::Singular));
        assert_eq!(gmres(|v| Ok(vec![0.0; v.len()]), &[0.0, 0.0]), Ok(vec![0.0, 0.0]));
    }
}
