//! Tangents of blocks that exist only at one state. They are inserted after all others, into a wider pattern than that of the system if they need it.

use super::{Assembled, BlockValues, Blocks, Dofs, System};
use crate::math::low_rank::Pattern;
use std::sync::Arc;

/// Tangents of blocks without slots.
#[derive(Default)]
pub(super) struct TransientTangents {
    /// Equations of a block, [`Dofs::FIXED`] where a dof is prescribed, and its K_e, row by row
    blocks: Vec<(Vec<u32>, Vec<f64>)>,
}

impl TransientTangents {
    /// Stores K_e of a block.
    pub fn push(&mut self, system: &System, blocks: &Blocks, b: usize, values: &BlockValues) {
        let n = blocks.size(b);
        let equations = blocks.dofs(b).map(|dof| system.dofs.equation[dof as usize]).collect();
        self.blocks.push((equations, values.k[..n * n].to_vec()));
    }

    /// Moves K into a pattern that also contains these blocks, and adds them.
    pub fn insert(&self, system: &System, x: &[f64], out: &mut Assembled) {
        if !self.fit(&out.pattern) {
            self.widen(system, x, out);
        }
        if out.widened.is_empty() {
            return;
        }
        let mut k = vec![0.0; out.pattern.nnz()];
        out.widened.iter().zip(&out.k).for_each(|(&slot, value)| k[slot as usize] = *value);
        for (equations, values) in &self.blocks {
            let n = equations.len();
            for i in 0..n {
                for j in (0..=i).filter(|&j| equations[i] != Dofs::FIXED && equations[j] != Dofs::FIXED) {
                    let slot = out.pattern.slot(equations[i], equations[j]).expect("the pattern was made to fit");
                    k[slot as usize] += values[i * n + j];
                }
            }
        }
        out.k = k;
    }

    /// Whether the pattern contains every pair of the blocks.
    fn fit(&self, pattern: &Pattern) -> bool {
        self.blocks.iter().all(|(equations, _)| pairs(equations).all(|(i, j)| pattern.slot(i, j).is_some()))
    }

    /// Extends the pattern by the pairs of the blocks and by those that may be coupled soon.
    fn widen(&self, system: &System, x: &[f64], out: &mut Assembled) {
        let of_nodes = |nodes: &Vec<u32>| -> Vec<u32> {
            nodes.iter().flat_map(|n| 3 * n..3 * n + 3).map(|dof| system.dofs.equation[dof as usize]).collect()
        };
        let mut candidates: Vec<Vec<u32>> = Vec::new();
        for coupling in system.effects.iter().filter_map(|e| e.capabilities().transient) {
            candidates.extend(coupling.candidates(x, &mut out.caches).iter().map(of_nodes));
        }
        let lists = || candidates.iter().chain(self.blocks.iter().map(|b| &b.0));
        let wider = out.pattern.with_pairs(lists().flat_map(|list| pairs(list)));
        out.widened = system.pattern.slots_in(&wider);
        out.pattern = Arc::new(wider);
    }
}

fn pairs(equations: &[u32]) -> impl Iterator<Item = (u32, u32)> + '_ {
    let free = || equations.iter().copied().filter(|e| *e != Dofs::FIXED);
    free().flat_map(move |i| free().take_while(move |j| *j != i).map(move |j| (i, j)))
}
