//! Blocks that are there at one state only: parts that meet, and may part again. The tangent has room for them beside the pattern of the
//! blocks that stay, and gets more where they need it.

use super::projection::project;
use super::scatter::Scatter;
use super::{Assembled, At, BlockValues, Blocks, Dofs, EvalError, System, Want};
use crate::math::linear::norm;
use crate::math::low_rank::Pattern;
use std::sync::Arc;

/// Tangents of blocks that have no slots.
#[derive(Default)]
pub(super) struct TransientTangents {
    /// Equations of a block, [`Dofs::FIXED`] where a dof is prescribed, and its K_e, row by row
    blocks: Vec<(Vec<u32>, Vec<f64>)>,
}

impl TransientTangents {
    /// Keeps K_e of a block.
    pub fn push(&mut self, system: &System, list: &Blocks, b: usize, local: &BlockValues) {
        let n = list.size(b);
        let equations = list.dofs(b).map(|dof| system.dofs.equation[dof as usize]).collect();
        self.blocks.push((equations, local.k[..n * n].to_vec()));
    }

    /// Does the pattern hold every pair of the blocks?
    fn fits(&self, pattern: &Pattern) -> bool {
        self.blocks.iter().all(|(equations, _)| pairs(equations).all(|(i, j)| pattern.slot(i, j).is_some()))
    }
}

fn pairs(equations: &[u32]) -> impl Iterator<Item = (u32, u32)> + '_ {
    let free = || equations.iter().copied().filter(|e| *e != Dofs::FIXED);
    free().flat_map(move |i| free().take_while(move |j| *j != i).map(move |j| (i, j)))
}

impl System {
    /// Energy and residual of what effect `e` couples here; its tangents into `met`. Returns Σ‖r_e‖.
    pub(super) fn add_meeting(
        &self,
        (e, met): (usize, &mut TransientTangents),
        at: &At,
        want: Want,
        increment: Option<&[f64]>,
        out: &mut Assembled,
    ) -> Result<f64, EvalError> {
        let effect = &self.effects[e];
        let capabilities = effect.capabilities();
        let Some(coupling) = capabilities.transient else { return Ok(0.0) };
        let meeting = coupling.blocks_at(at, &mut out.caches);
        let list = meeting.blocks();
        let mut scatter = Scatter { system: self, list, slots: &[], next: 0 };
        let mut local = BlockValues::new(list.largest());
        let mut sum = 0.0;
        for b in 0..list.len() {
            let n = list.size(b);
            local.reset(n, want);
            meeting.eval(at, b, want, &mut local)?;
            out.energy[e] += local.energy;
            sum += norm(&local.r[..n]);
            scatter.add(b, &local, 1.0, Want::Residual, None, out);
            if want == Want::Tangent {
                if out.projected || out.descending && capabilities.semidefinite {
                    project(&mut local, n, n);
                }
                if let Some(d) = increment {
                    scatter.lift(b, &local, 1.0, d, out);
                }
                met.push(self, list, b, &local);
            }
        }
        Ok(sum)
    }
}

impl Assembled {
    /// Gives back the room of parts that met: the next tangent has what its own state asks for.
    pub fn forget_meetings(&mut self, system: &System) {
        if !self.moved.is_empty() {
            self.pattern = system.pattern.clone();
            self.moved.clear();
        }
    }

    /// Values of K before the blocks that stay are added.
    pub(super) fn clear_tangent(&mut self, system: &System) {
        self.k.clear();
        self.k.resize(system.pattern.nnz(), 0.0);
    }

    /// Puts K of the blocks that stay, and of those that met, into a pattern that holds both.
    pub(super) fn take_in(&mut self, system: &System, met: &TransientTangents, x: &[f64]) {
        if !met.fits(&self.pattern) {
            let of_nodes = |nodes: &Vec<u32>| -> Vec<u32> {
                nodes.iter().flat_map(|n| 3 * n..3 * n + 3).map(|dof| system.dofs.equation[dof as usize]).collect()
            };
            let mut room: Vec<Vec<u32>> = Vec::new();
            for coupling in system.effects.iter().filter_map(|e| e.capabilities().transient) {
                room.extend(coupling.candidates(x, &mut self.caches).iter().map(of_nodes));
            }
            let lists = || room.iter().chain(met.blocks.iter().map(|b| &b.0));
            let wider = self.pattern.with_pairs(lists().flat_map(|list| pairs(list)));
            self.moved = system.pattern.slots_in(&wider);
            self.pattern = Arc::new(wider);
        }
        if self.moved.is_empty() {
            return;
        }
        let mut k = vec![0.0; self.pattern.nnz()];
        self.moved.iter().zip(&self.k).for_each(|(&slot, value)| k[slot as usize] = *value);
        for (equations, values) in &met.blocks {
            let n = equations.len();
            for i in 0..n {
                for j in (0..=i).filter(|&j| equations[i] != Dofs::FIXED && equations[j] != Dofs::FIXED) {
                    let slot = self.pattern.slot(equations[i], equations[j]).expect("the pattern was made to fit");
                    k[slot as usize] += values[i * n + j];
                }
            }
        }
        self.k = k;
    }
}
