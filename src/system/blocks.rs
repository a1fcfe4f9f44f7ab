//! Blocks: the unknowns of one local contribution, and the buffers for its values.

use crate::material::Want;

/// The unknowns of the local contributions (cell, node, cable segment) of an effect: the displacements of some nodes, then scalars of a second field
/// (pressure).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Blocks {
    offsets: Vec<u32>,
    nodes: Vec<u32>,
    scalar_offsets: Vec<u32>,
    scalars: Vec<u32>,
}

impl Blocks {
    pub fn new<'a>(lists: impl Iterator<Item = &'a [u32]>) -> Self {
        Self::with_scalars(lists.map(|nodes| (nodes, &[][..])))
    }

    /// Builds blocks from the node list and the unknowns of the second field (their indices in `State::x`) of each block.
    pub fn with_scalars<'a>(lists: impl Iterator<Item = (&'a [u32], &'a [u32])>) -> Self {
        let (mut out, mut count) = (Self::default(), 0);
        out.offsets.push(0);
        out.scalar_offsets.push(0);
        for (nodes, scalars) in lists {
            out.nodes.extend_from_slice(nodes);
            out.scalars.extend_from_slice(scalars);
            out.offsets.push(out.nodes.len() as u32);
            out.scalar_offsets.push(out.scalars.len() as u32);
            count += 1;
        }
        debug_assert_eq!(out.len(), count);
        out
    }

    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Nodes of block `b`.
    pub fn nodes(&self, b: usize) -> &[u32] {
        &self.nodes[self.offsets[b] as usize..self.offsets[b + 1] as usize]
    }

    /// Unknowns of the second field of block `b`.
    pub fn scalars(&self, b: usize) -> &[u32] {
        &self.scalars[self.scalar_offsets[b] as usize..self.scalar_offsets[b + 1] as usize]
    }

    /// Indices in `State::x` of the unknowns of block `b`: 3·node + component node by node, then the scalars.
    pub fn dofs(&self, b: usize) -> impl Iterator<Item = u32> + '_ {
        let displacements = self.nodes(b).iter().flat_map(|&n| 3 * n..3 * n + 3);
        displacements.chain(self.scalars(b).iter().copied())
    }

    /// Number of unknowns of block `b`.
    pub fn size(&self, b: usize) -> usize {
        3 * self.nodes(b).len() + self.scalars(b).len()
    }

    /// Number of unknowns of the largest block.
    pub fn largest(&self) -> usize {
        (0..self.len()).map(|b| self.size(b)).max().unwrap_or(0)
    }
}

/// Buffers of one block, zeroed before each evaluation.
pub struct BlockValues {
    /// Π_e \[J\], or c_b of a constraint
    pub energy: f64,
    /// Dissipation of the step \[J\], for an effect that relaxes; at the start of a run the energy that it holds and can give back
    pub dissipated: f64,
    /// \[n\] r_e = ∂Π_e/∂x_e \[N\]
    pub r: Vec<f64>,
    /// \[n × n\] K_e = ∂r/∂x + cv ∂r/∂v + ca ∂r/∂a \[N/m\] row by row; only entries with column ≤ row are read
    pub k: Vec<f64>,
}

impl BlockValues {
    pub fn new(n: usize) -> Self {
        Self { energy: 0.0, dissipated: 0.0, r: vec![0.0; n], k: vec![0.0; n * n] }
    }

    /// Adds factor K_e dx to r at the chosen dofs; `dofs` are those of the block.
    pub(super) fn add_product(
        &self,
        dofs: &[u32],
        chosen: impl Fn(u32) -> bool,
        factor: f64,
        dx: &[f64],
        r: &mut [f64],
    ) {
        let n = dofs.len();
        for (i, &to) in dofs.iter().enumerate().filter(|(_, to)| chosen(**to)) {
            let entry = |(j, from): (usize, &u32)| self.k[i.max(j) * n + i.min(j)] * dx[*from as usize];
            r[to as usize] += factor * dofs.iter().enumerate().map(entry).sum::<f64>();
        }
    }

    /// Zeroes the entries of a block of `n` unknowns.
    pub(super) fn reset(&mut self, n: usize, want: Want) {
        self.energy = 0.0;
        self.dissipated = 0.0;
        self.r[..n].fill(0.0);
        if want == Want::Tangent {
            self.k[..n * n].fill(0.0);
        }
    }
}
