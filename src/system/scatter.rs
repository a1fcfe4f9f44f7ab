//! The way of local blocks into the sums, one at a time or [`LANES`] side by side, in block order.

use super::{Assembled, At, Batch, Batched, BlockValues, Blocks, Dofs, EvalError, System, Want};
use crate::math::lanes::{LANES, Lanes};

/// Adds local blocks to the sums, in block order.
pub(super) struct Scatter<'a> {
    pub system: &'a System,
    pub list: &'a Blocks,
    /// Of the effect or row, block after block
    pub slots: &'a [u32],
    /// Slots that were passed
    pub next: usize,
}

impl Scatter<'_> {
    pub fn add(
        &mut self,
        b: usize,
        local: &BlockValues,
        factor: f64,
        want: Want,
        increment: Option<&[f64]>,
        out: &mut Assembled,
    ) {
        let n = self.list.size(b);
        for (dof, r) in self.list.dofs(b).zip(&local.r) {
            out.r[dof as usize] += factor * r;
        }
        if want < Want::Tangent {
            return;
        }
        let slots = &self.slots[self.next..self.next + n * (n + 1) / 2];
        self.next += slots.len();
        let mut s = slots.iter();
        for i in 0..n {
            for (value, &slot) in local.k[i * n..i * n + i + 1].iter().zip(&mut s) {
                if slot != Dofs::FIXED {
                    out.k[slot as usize] += factor * value;
                }
            }
        }
        if let Some(d) = increment {
            self.lift(b, local, factor, d, out);
        }
    }

    /// r and K of one lane of a batch.
    #[inline]
    fn add_lane(&mut self, b: usize, batch: &Batch, lane: usize, want: Want, out: &mut Assembled) {
        for (&node, r) in self.list.nodes(b).iter().zip(batch.r.chunks_exact(3)) {
            let to = &mut out.r[3 * node as usize..][..3];
            to.iter_mut().zip(r).for_each(|(to, r)| *to += r.0[lane]);
        }
        if want < Want::Tangent {
            return;
        }
        let n = batch.r.len();
        let slots = &self.slots[self.next..self.next + n * (n + 1) / 2];
        self.next += slots.len();
        let mut start = 0;
        for (i, row) in batch.k.chunks_exact(n).enumerate() {
            for (value, &slot) in row[..=i].iter().zip(&slots[start..=start + i]) {
                if let Some(to) = out.k.get_mut(slot as usize) {
                    *to += value.0[lane];
                }
            }
            start += i + 1;
        }
    }

    /// lift += K_e d_e, where d is zero on free dofs.
    pub fn lift(&self, b: usize, local: &BlockValues, factor: f64, d: &[f64], out: &mut Assembled) {
        let n = self.list.size(b);
        for (j, from) in self.list.dofs(b).enumerate() {
            let dj = factor * d[from as usize];
            if dj == 0.0 {
                continue;
            }
            for (i, to) in self.list.dofs(b).enumerate() {
                let equation = self.system.dofs.equation[to as usize];
                if equation != Dofs::FIXED {
                    out.lift[equation as usize] += local.k[i.max(j) * n + i.min(j)] * dj;
                }
            }
        }
    }
}

/// Adds energies, Σ‖r_e‖ and sums of effect `e` over its whole batches; returns the first block that is in none.
pub(super) fn sum_batches(
    batched: &dyn Batched,
    at: &At,
    want: Want,
    increment: Option<&[f64]>,
    scatter: &mut Scatter,
    (e, forces): (usize, &mut f64),
    out: &mut Assembled,
) -> Result<usize, EvalError> {
    let whole = scatter.list.len() / LANES * LANES;
    if whole == 0 {
        return Ok(0);
    }
    let n = scatter.list.size(0);
    let (mut batch, mut local) = (Batch::new(n), BlockValues::new(n));
    for first in (0..whole).step_by(LANES) {
        batch.reset(n, want);
        batched.eval(at, first, want, &mut batch)?;
        let squares = batch.r.iter().fold(Lanes::ZERO, |sum, r| sum + *r * *r);
        for lane in 0..LANES {
            out.energy[e] += batch.energy.0[lane];
            *forces += squares.0[lane].sqrt();
            scatter.add_lane(first + lane, &batch, lane, want, out);
            if let Some(d) = increment.filter(|_| want == Want::Tangent) {
                local.k.iter_mut().zip(&batch.k).for_each(|(to, from)| *to = from.0[lane]);
                scatter.lift(first + lane, &local, 1.0, d, out);
            }
        }
    }
    Ok(whole)
}
