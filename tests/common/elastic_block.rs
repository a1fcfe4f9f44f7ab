//! Blocks of linear tetrahedra, linear elasticity, E = 1: node positions off the grid by up to 15 % of its width, held at x = 0. The unit tests of the
//! multigrid hierarchy include this file too, where `math` is that of the library.

#![allow(dead_code)]

use super::math::multigrid::Places;
use super::math::ordering::fill_reducing;
use super::math::random::SplitMix;
use super::math::sparse::SymPattern;
use super::math::tensor::{Mat3, Vec3};
use std::sync::Arc;

pub struct Body {
    pub pattern: Arc<SymPattern>,
    pub values: Vec<f64>,
    pub places: Arc<Places>,
}

/// How the nodes at x = 0 are held.
#[derive(Clone, Copy, PartialEq)]
pub enum Hold {
    Clamped,
    /// u_x only, and what stops a rigid motion
    Rolling,
    Free,
}

pub fn block([nx, ny, nz]: [usize; 3], nu: f64, hold: Hold) -> Body {
    let node = |[i, j, k]: [usize; 3]| (i * (ny + 1) + j) * (nz + 1) + k;
    let boxes =
        |n: [usize; 3]| (0..n[0]).flat_map(move |i| (0..n[1]).flat_map(move |j| (0..n[2]).map(move |k| [i, j, k])));
    let mut random = SplitMix(3);
    let mut off = || 0.3 * (random.unit() - 0.5);
    let at: Vec<[usize; 3]> = boxes([nx + 1, ny + 1, nz + 1]).collect();
    let points: Vec<Vec3> = at.iter().map(|n| Vec3::from(n.map(|i| i as f64 + off()))).collect();
    let paths = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let cells: Vec<Vec<usize>> = boxes([nx, ny, nz])
        .flat_map(|corner| paths.map(|path| (corner, path)))
        .map(|(mut corner, path)| {
            let first = node(corner);
            std::iter::once(first)
                .chain(path.map(|d| {
                    corner[d] += 1;
                    node(corner)
                }))
                .collect()
        })
        .collect();
    let pairs = |list: &[usize]| {
        let list = list.to_vec();
        (0..list.len()).flat_map(move |a| {
            let list = list.clone();
            (0..a).map(move |b| (list[a] as u32, list[b] as u32))
        })
    };
    let graph = SymPattern::from_pairs(points.len(), cells.iter().flat_map(|c| pairs(c)));
    let held = |n: usize, c: usize| match hold {
        Hold::Clamped => at[n][0] == 0,
        Hold::Rolling => at[n][0] == 0 && (c == 0 || at[n] == [0, 0, 0] || (c == 2 && at[n] == [0, 1, 0])),
        Hold::Free => false,
    };
    let (mut equation, mut dofs) = (vec![usize::MAX; 3 * points.len()], Vec::new());
    for n in fill_reducing(&graph) {
        for c in (0..3).filter(|&c| !held(n as usize, c)) {
            equation[3 * n as usize + c] = dofs.len();
            dofs.push(3 * n + c as u32);
        }
    }
    let equations: Vec<Vec<usize>> = cells
        .iter()
        .map(|c| c.iter().flat_map(|n| (0..3).map(move |k| 3 * n + k)).map(|dof| equation[dof]).collect())
        .collect();
    let free = |list: &Vec<usize>| pairs(&list.iter().copied().filter(|&e| e != usize::MAX).collect::<Vec<_>>());
    let pattern = SymPattern::from_pairs(dofs.len(), equations.iter().flat_map(free));
    let mut values = vec![0.0; pattern.nnz()];
    let (mu, lambda) = (0.5 / (1.0 + nu), nu / ((1.0 + nu) * (1.0 - 2.0 * nu)));
    for (cell, e) in cells.iter().zip(&equations) {
        let edge = |k: usize| points[cell[k]] - points[cell[0]];
        let edges = Mat3::from_columns(&[edge(1), edge(2), edge(3)]);
        let rows = edges.try_inverse().expect("a cell has a volume");
        let mut g = [Vec3::zeros(); 4];
        (0..3).for_each(|k| g[k + 1] = rows.row(k).transpose());
        g[0] = -(g[1] + g[2] + g[3]);
        let volume = edges.determinant().abs() / 6.0;
        for (p, q) in (0..12).flat_map(|p| (0..12).map(move |q| (p, q))) {
            let ([a, i], [b, j]) = ([p / 3, p % 3], [q / 3, q % 3]);
            if e[p] == usize::MAX || e[q] == usize::MAX || e[q] > e[p] {
                continue;
            }
            let same = if i == j { mu * g[a].dot(&g[b]) } else { 0.0 };
            let slot = pattern.slot(e[p] as u32, e[q] as u32).expect("a pair of a cell");
            values[slot as usize] += volume * (lambda * g[a][i] * g[b][j] + mu * g[a][j] * g[b][i] + same);
        }
    }
    Body { pattern: pattern.into(), values, places: Places { dofs, points }.into() }
}

impl Body {
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        self.pattern.multiply(&self.values, x, &mut y);
        y
    }
}

pub fn random(n: usize, seed: u64) -> Vec<f64> {
    let mut random = SplitMix(seed);
    (0..n).map(|_| random.unit() - 0.5).collect()
}
