//! Transfer between levels: a prolongation whose range contains the rigid motions.
//!
//! ```text
//! B_g = Q_g R_g on the nodes of each group g,  P₀ = diag Q_g,  next motions R_g,  P = (I − ω D⁻¹A) P₀,  ω = 4/(3 ρ(D⁻¹A))
//! ```
//!
//! B are the motions of the nodes, D the blocks of the diagonal of A. Source: Vaněk, Mandel & Brezina, Computing 56, 1996, §3 and 4. P₀ R = B
//! exactly; P R = B where A B = 0, that is, away from held nodes.

use super::blocks::{Block, BlockMatrix, add_product, subtract_product};
use crate::math::random::SplitMix;

/// Share of a motion in a group that must be independent of the motions before it: nodes on a line have five independent motions, a single node has
/// three.
const RANK: f64 = 1e-8;
/// Number of products for the largest eigenvalue: an estimate within some per cent is enough, since ω may be up to 2/ρ.
const PRODUCTS: usize = 12;

/// Returns P₀ and the motions of the groups; a motion that a group lacks is zero in both.
pub fn tentative<const B: usize>(
    modes: &[Block<B, 6>],
    group: &[u32],
    groups: usize,
) -> (BlockMatrix<B, 6>, Vec<Block<6, 6>>) {
    let mut members = vec![Vec::new(); groups];
    group.iter().enumerate().for_each(|(i, &g)| members[g as usize].push(i));
    let mut values = modes.to_vec();
    let mut next = vec![[[0.0; 6]; 6]; groups];
    for (nodes, r) in members.iter().zip(&mut next) {
        orthonormalise(&mut values, nodes, r);
    }
    let row_ptr = (0..=group.len() as u32).collect();
    (BlockMatrix { columns: groups, row_ptr, col: group.to_vec(), values }, next)
}

/// Gram–Schmidt, repeated once for orthogonality to rounding (Giraud, Langou & Rozložník 2005): the columns of these nodes become Q, and `r` becomes
/// R.
fn orthonormalise<const B: usize>(q: &mut [Block<B, 6>], nodes: &[usize], r: &mut Block<6, 6>) {
    let dot = |q: &[Block<B, 6>], j: usize, k: usize| -> f64 {
        nodes.iter().map(|&i| (0..B).map(|c| q[i][j][c] * q[i][k][c]).sum::<f64>()).sum()
    };
    for k in 0..6 {
        let before = dot(q, k, k).sqrt();
        for _ in 0..2 {
            for j in 0..k {
                let share = dot(q, j, k);
                r[k][j] += share;
                for &i in nodes {
                    (0..B).for_each(|c| q[i][k][c] -= share * q[i][j][c]);
                }
            }
        }
        let left = dot(q, k, k).sqrt();
        let scale = if left > RANK * before { 1.0 / left } else { 0.0 };
        r[k][k] = if scale > 0.0 { left } else { 0.0 };
        nodes.iter().for_each(|&i| q[i][k].iter_mut().for_each(|v| *v *= scale));
    }
}

/// A lower bound of ρ(D⁻¹A), from x·Ax/x·Dx of the power method; `None` if there is a motion without positive stiffness.
pub fn largest_eigenvalue<const B: usize>(a: &BlockMatrix<B, B>, inverse: &[Block<B, B>]) -> Option<f64> {
    let mut random = SplitMix(1);
    let mut x: Vec<[f64; B]> = (0..a.rows()).map(|_| std::array::from_fn(|_| random.unit() - 0.5)).collect();
    let mut largest = 0.0;
    for _ in 0..PRODUCTS {
        let rows = a.by_rows(|i| {
            let force = a.row_times(i, &x);
            let (mut own, mut next) = ([0.0; B], [0.0; B]);
            add_product(&mut own, &a.values[a.diagonal(i)], &x[i]);
            add_product(&mut next, &inverse[i], &force);
            (next, dot(&x[i], &force), dot(&x[i], &own))
        });
        let (mut stiffness, mut scale, mut size) = (0.0, 0.0, 0.0);
        for (next, force, own) in &rows {
            (stiffness, scale, size) = (stiffness + force, scale + own, size + dot(next, next));
        }
        if !(stiffness > 0.0 && scale > 0.0 && size.is_finite()) {
            return None;
        }
        largest = stiffness / scale;
        let size = size.sqrt();
        x = rows.into_iter().map(|(next, ..)| next.map(|x| x / size)).collect();
    }
    Some(largest)
}

/// Returns P = (I − ω D⁻¹A) P₀.
pub fn smoothed<const B: usize>(
    a: &BlockMatrix<B, B>,
    inverse: &[Block<B, B>],
    tentative: &BlockMatrix<B, 6>,
    omega: f64,
) -> BlockMatrix<B, 6> {
    let mut p = a.times(tentative);
    let rows = p.by_rows(|i| {
        let own = tentative.col[i];
        let of_group = |k: usize| {
            let mut block = if p.col[k] == own { tentative.values[i] } else { [[0.0; B]; 6] };
            for (to, from) in block.iter_mut().zip(&p.values[k]) {
                subtract_product(to, &inverse[i], &from.map(|v| omega * v));
            }
            block
        };
        p.range(i).map(of_group).collect::<Vec<_>>()
    });
    p.values = rows.concat();
    p
}

fn dot<const B: usize>(a: &[f64; B], b: &[f64; B]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
