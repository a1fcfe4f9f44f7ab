//! Projection to the nearest positive semidefinite block: K_e = V Λ Vᵀ with the negative eigenvalues set to zero (Teran, Sifakis, Irving & Fedkiw,
//! Robust quasistatic finite elements and flesh simulation, SCA 2005, who project at each quadrature point).
//!
//! Limits: only the displacement part of a block is projected; couplings to a second field are unchanged. Newton's method with projected blocks
//! converges only linearly, since the matrix differs from ∂r/∂x.

use super::BlockValues;
use nalgebra::DMatrix;

/// Projects the part of the first `displacements` of the `n` unknowns of a block; a positive semidefinite block is unchanged.
pub(super) fn project(local: &mut BlockValues, n: usize, displacements: usize) {
    let entry = |i: usize, j: usize| local.k[i.max(j) * n + i.min(j)];
    let eigen = DMatrix::from_fn(displacements, displacements, entry).symmetric_eigen();
    for (value, v) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()).filter(|(e, _)| **e < 0.0) {
        for i in 0..displacements {
            for j in 0..=i {
                local.k[i * n + j] -= value * v[i] * v[j];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A block of 3 × 3 with a second field: [\[1, 2\], \[2, 1\]] has the eigenvalues 3 and −1, and becomes 3/2 [\[1, 1\], \[1, 1\]].
    #[test]
    fn takes_the_negative_part_away_and_nothing_else() {
        let mut local = BlockValues::new(4);
        let rows = [[1.0, 0.0, 0.0, 0.0], [2.0, 1.0, 0.0, 0.0], [0.0, 0.0, 5.0, 0.0], [7.0, 8.0, 9.0, -4.0]];
        local.k.copy_from_slice(&rows.concat());
        project(&mut local, 4, 3);
        let wanted = [[1.5, 0.0, 0.0, 0.0], [1.5, 1.5, 0.0, 0.0], [0.0, 0.0, 5.0, 0.0], [7.0, 8.0, 9.0, -4.0]].concat();
        for i in 0..4 {
            for j in 0..=i {
                assert!((local.k[4 * i + j] - wanted[4 * i + j]).abs() < 1e-14, "{:?}", local.k);
            }
        }
    }
}
