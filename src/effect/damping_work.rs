//! Work of a damper within a step, which is its dissipated energy.

use crate::system::{At, BlockValues, Blocks};

/// Returns r_e·(x − old) of block `b` \[J\].
pub(super) fn work(blocks: &Blocks, at: &At, b: usize, out: &BlockValues) -> f64 {
    let dofs = blocks.nodes(b).iter().flat_map(|&n| 3 * n as usize..3 * n as usize + 3);
    dofs.zip(&out.r).map(|(dof, r)| r * (at.x[dof] - at.old[dof])).sum()
}
