//! Tests of the steps of a set-up. The behaviour of whole hierarchies is tested by `tests/solver/multigrid.rs`.

#[path = "../../../tests/common/elastic_block.rs"]
mod elastic_block;

use super::*;
use crate::math;
use elastic_block::{Hold, block, random};

/// The blocks equal the matrix, with ones where a component is held.
#[test]
fn blocks_are_the_matrix() {
    let body = block([3, 2, 2], 0.3, Hold::Rolling);
    let nodal = Nodal::new(&body.pattern, &body.places);
    let a = nodal.matrix(&body.pattern, &body.values);
    let x = random(body.pattern.n, 1);
    let blocks = nodal.gather(&x);
    let product: Vec<[f64; 3]> = (0..a.rows()).map(|i| a.row_times(i, &blocks)).collect();
    let mut y = vec![0.0; x.len()];
    nodal.scatter(&product, &mut y);
    // Sums of about fifty products of numbers below 2
    assert!(y.iter().zip(body.times(&x)).all(|(y, z)| (y - z).abs() < 1e-13));
    let held = (0..a.rows())
        .flat_map(|i| (0..3).map(move |c| (i, c)))
        .filter(|&(i, c)| a.values[a.diagonal(i)][c][c] == 1.0 && a.row_times(i, &blocks)[c] == 0.0);
    assert_eq!(held.count(), 3 * a.rows() - body.pattern.n);
}

/// P₀ R = B to the rounding of an orthogonalisation, and P R = B where A B = 0, here for a free body. Numbers are below 1.
#[test]
fn rigid_motions_are_in_the_range() {
    let body = block([6, 5, 4], 0.3, Hold::Free);
    let a = Nodal::new(&body.pattern, &body.places).matrix(&body.pattern, &body.values);
    let modes = body.places.rigid_modes(&[]);
    for k in 0..6 {
        let motion: Vec<[f64; 3]> = modes.iter().map(|m| m[k]).collect();
        assert!((0..a.rows()).all(|i| a.row_times(i, &motion).iter().all(|f| f.abs() < 1e-13)), "motion {k} is rigid");
        assert!(motion.iter().flatten().any(|u| u.abs() > 0.1), "motion {k} is one");
    }
    let (group, groups) = aggregate(&a, STRONG);
    let (p, next) = tentative(&modes, &group, groups);
    let smooth = smoothed(&a, &inverses(&a, &vec![[0.0; 3]; a.rows()]).expect("positive"), &p, 0.7);
    for (p, bound) in [(p, 1e-14), (smooth, 1e-13)] {
        for k in 0..6 {
            let coarse: Vec<[f64; 6]> = next.iter().map(|m| m[k]).collect();
            for (i, m) in modes.iter().enumerate() {
                let image = p.row_times(i, &coarse);
                assert!(image.iter().zip(&m[k]).all(|(a, b)| (a - b).abs() < bound), "motion {k}, node {i}");
            }
        }
    }
}

/// Columns of P₀ are orthonormal; those that a group of fewer than three nodes lacks are zero.
#[test]
fn tentative_columns_are_orthonormal_or_absent() {
    let body = block([2, 2, 2], 0.3, Hold::Free);
    let modes = body.places.rigid_modes(&[]);
    // Groups of one node, of two, and of the rest
    let group: Vec<u32> = (0..modes.len() as u32).map(|i| [0, 1, 1].get(i as usize).copied().unwrap_or(2)).collect();
    let (p, next) = tentative(&modes, &group, 3);
    let rank = |g: usize| (0..6).filter(|&k| next[g][k][k] > 0.0).count();
    assert_eq!([rank(0), rank(1), rank(2)], [3, 5, 6]);
    let gram = p.transposed().times(&p);
    for (g, next) in next.iter().enumerate() {
        let block = gram.values[gram.diagonal(g)];
        for (i, j) in (0..6).flat_map(|i| (0..6).map(move |j| (i, j))) {
            let expected = if i == j && next[i][i] > 0.0 { 1.0 } else { 0.0 };
            assert!((block[i][j] - expected).abs() < 1e-14, "group {g}: {i}, {j}");
        }
    }
}
