//! The few dense rows beside K: step of the multipliers from the Schur complement, with complementarity.

use crate::math::linear::{Factor, LinearError, dot};
use crate::system::Assembled;

/// Solves 0 ≤ w = q + S μ ⟂ μ ≥ 0 on the one-sided rows and w = 0 on the others, for symmetric positive definite S
/// (m × m, row by row), by principal pivoting with the least index (Murty 1974). m is a handful.
pub fn complementarity(s: &[f64], q: &[f64], one_sided: &[bool]) -> Option<Vec<f64>> {
    let m = q.len();
    let mut active = vec![true; m];
    // Each subset is visited at most once.
    for _ in 0..(1usize << m.min(16)) {
        let rows: Vec<usize> = (0..m).filter(|&i| active[i]).collect();
        let k = rows.len();
        let matrix = nalgebra::DMatrix::from_fn(k, k, |a, b| s[rows[a] * m + rows[b]]);
        let rhs = nalgebra::DVector::from_fn(k, |a, _| -q[rows[a]]);
        let solution = if k == 0 { rhs } else { matrix.lu().solve(&rhs)? };
        let mut mu = vec![0.0; m];
        for (a, &i) in rows.iter().enumerate() {
            mu[i] = solution[a];
        }
        let violated = (0..m).find(|&i| {
            let w = q[i] + dot(&s[i * m..(i + 1) * m], &mu);
            one_sided[i] && if active[i] { mu[i] < 0.0 } else { w < 0.0 }
        });
        match violated {
            None => return mu.iter().all(|v| v.is_finite()).then_some(mu),
            Some(i) => active[i] = !active[i],
        }
    }
    None
}

/// Z = K⁻¹ Hᵀ and S = H Z of the current factorisation.
#[derive(Default)]
pub(super) struct Schur {
    /// [constraints × equations]
    pub z: Vec<f64>,
    /// [constraints × constraints]
    pub s: Vec<f64>,
    /// Negative eigenvalues of S
    pub negative: usize,
}

impl Schur {
    pub fn new(factor: &mut Factor, sums: &Assembled) -> Result<Self, LinearError> {
        let m = sums.gradient.len();
        let mut z = sums.gradient.concat();
        if m == 0 {
            return Ok(Self::default());
        }
        factor.solve(&sums.k, &mut z)?;
        let n = z.len() / m;
        let s: Vec<f64> =
            (0..m * m).map(|ij| dot(&sums.gradient[ij / m], &z[(ij % m) * n..(ij % m + 1) * n])).collect();
        let symmetric = nalgebra::DMatrix::from_fn(m, m, |i, j| 0.5 * (s[i * m + j] + s[j * m + i]));
        let negative = symmetric.symmetric_eigenvalues().iter().filter(|&&e| e < 0.0).count();
        Ok(Self { z, s, negative })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holds_complementarity() {
        let s = [2.0, 0.5, 0.5, 1.0];
        for q in [[-1.0, 1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, -1.0], [-1.0, 0.0]] {
            let mu = complementarity(&s, &q, &[true, true]).expect("S is positive definite");
            for i in 0..2 {
                let w = q[i] + dot(&s[2 * i..2 * i + 2], &mu);
                assert!(mu[i] >= 0.0 && w > -1e-15 && (w * mu[i]).abs() < 1e-15, "q = {q:?}, row {i}");
            }
            let both = complementarity(&s, &q, &[false, false]).expect("regular");
            assert!((0..2).all(|i| (q[i] + dot(&s[2 * i..2 * i + 2], &both)).abs() < 1e-15));
        }
    }
}
