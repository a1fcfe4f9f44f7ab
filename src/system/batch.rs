//! Simultaneous evaluation of several blocks of one size.

use super::{At, EvalError, Want};
use crate::material::LaneResponse;
use crate::math::lanes::Lanes;
use std::ops::Range;

/// Buffers for [`LANES`](crate::math::lanes::LANES) blocks of one size.
pub struct Batch {
    /// Energy Π_e \[J\]
    pub energy: Lanes,
    /// \[n\] residual r_e \[N\]
    pub r: Vec<Lanes>,
    /// \[n × n\] tangent K_e \[N/m\] row by row; only entries with column ≤ row are read
    pub k: Vec<Lanes>,
    /// Workspace for the responses at the points of the blocks
    pub responses: Vec<LaneResponse>,
}

impl Batch {
    pub fn new(n: usize) -> Self {
        Self { energy: Lanes::ZERO, r: vec![Lanes::ZERO; n], k: vec![Lanes::ZERO; n * n], responses: Vec::new() }
    }

    /// Zeroes energy and r before an evaluation of blocks of `n` unknowns.
    pub(super) fn reset(&mut self, n: usize) {
        self.energy = Lanes::ZERO;
        self.r[..n].fill(Lanes::ZERO);
    }

    /// Zeroes these rows of K_e.
    pub fn clear_rows(&mut self, n: usize, rows: Range<usize>) {
        self.k[rows.start * n..rows.end * n].fill(Lanes::ZERO);
    }
}

/// An effect that evaluates [`LANES`](crate::math::lanes::LANES) blocks at once, with the same results as [`Effect::eval`](super::Effect::eval) for
/// each block, up to rounding.
pub trait Batched: Sync {
    /// Evaluates the blocks `first` to `first` + LANES − 1, where `first` is a multiple of LANES. Energy and r are zero on entry. If the tangent is
    /// wanted, every entry of K_e with column ≤ row must be set, because it still holds the values of other blocks.
    fn eval(&self, at: &At, first: usize, want: Want, out: &mut Batch) -> Result<(), EvalError>;
}
