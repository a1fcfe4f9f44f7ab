//! Conversion of a symmetric matrix of scalar entries to blocks of 3 × 3, one for each pair of nodes.
//!
//! A component without an equation has a one on the diagonal and zeros elsewhere in its row.

use super::blocks::{Block, BlockMatrix};
use super::places::Places;
use crate::math::sparse::{SymPattern, accumulate};

/// The structure of the block matrix, built once for a pattern.
pub struct Nodal {
    /// \[equations\] block row and component of each equation
    component: Vec<(u32, u8)>,
    row_ptr: Vec<u32>,
    col: Vec<u32>,
    /// \[blocks\] index of the transposed block
    mirror: Vec<u32>,
}

impl Nodal {
    pub fn new(pattern: &SymPattern, places: &Places) -> Self {
        let component = places.components();
        let nodes = component.last().map_or(0, |last| last.0 as usize + 1);
        // Nodes below the diagonal, column by column
        let mut below = vec![Vec::new(); nodes];
        for (j, &(node, _)) in component.iter().enumerate() {
            let rows = &pattern.row_idx[pattern.col_ptr[j] as usize..pattern.col_ptr[j + 1] as usize];
            below[node as usize].extend(rows.iter().map(|&i| component[i as usize].0).filter(|&i| i > node));
        }
        let mut row_ptr = vec![0u32; nodes + 1];
        for (j, below) in below.iter_mut().enumerate() {
            below.sort_unstable();
            below.dedup();
            row_ptr[j + 1] += 1 + below.len() as u32;
            below.iter().for_each(|&i| row_ptr[i as usize + 1] += 1);
        }
        accumulate(&mut row_ptr);
        let blocks = row_ptr[nodes] as usize;
        let (mut next, mut col, mut mirror) = (row_ptr.clone(), vec![0u32; blocks], vec![0u32; blocks]);
        let mut take = |i: usize| {
            next[i] += 1;
            next[i] - 1
        };
        // The blocks of row j before the diagonal were set by the columns before
        for (j, below) in below.iter().enumerate() {
            let own = take(j);
            (col[own as usize], mirror[own as usize]) = (j as u32, own);
            for &i in below {
                let (upper, lower) = (take(j), take(i as usize));
                (col[upper as usize], mirror[upper as usize]) = (i, lower);
                (col[lower as usize], mirror[lower as usize]) = (j as u32, upper);
            }
        }
        Self { component, row_ptr, col, mirror }
    }

    pub fn matrix(&self, pattern: &SymPattern, values: &[f64]) -> BlockMatrix<3, 3> {
        let mut blocks: Vec<Block<3, 3>> = vec![[[0.0; 3]; 3]; self.col.len()];
        let nodes = self.row_ptr.len() - 1;
        let diagonal = |i: usize| {
            let range = self.row_ptr[i] as usize..self.row_ptr[i + 1] as usize;
            range.start + self.col[range].partition_point(|&j| (j as usize) < i)
        };
        (0..nodes).for_each(|i| (0..3).for_each(|c| blocks[diagonal(i)][c][c] = 1.0));
        for (j, &(node, cj)) in self.component.iter().enumerate() {
            let mut k = diagonal(node as usize);
            let entries = pattern.col_ptr[j] as usize..pattern.col_ptr[j + 1] as usize;
            for (&i, &value) in pattern.row_idx[entries.clone()].iter().zip(&values[entries]) {
                let (row, ci) = self.component[i as usize];
                while self.col[k] < row {
                    k += 1;
                }
                blocks[k][ci as usize][cj as usize] = value;
                blocks[self.mirror[k] as usize][cj as usize][ci as usize] = value;
            }
        }
        BlockMatrix { columns: nodes, row_ptr: self.row_ptr.clone(), col: self.col.clone(), values: blocks }
    }

    /// Gathers values by nodes, with zeros where there is no equation.
    pub fn gather(&self, v: &[f64]) -> Vec<[f64; 3]> {
        let mut out = vec![[0.0; 3]; self.row_ptr.len() - 1];
        self.component.iter().zip(v).for_each(|(&(node, c), v)| out[node as usize][c as usize] = *v);
        out
    }

    /// Scatters values by nodes back to the equations.
    pub fn scatter(&self, v: &[[f64; 3]], out: &mut [f64]) {
        out.iter_mut().zip(&self.component).for_each(|(out, &(node, c))| *out = v[node as usize][c as usize]);
    }
}
