//! Simultaneous evaluation of several blocks of one size.

use super::{At, EvalError, Want};
use crate::material::LaneResponse;
use crate::math::lanes::Lanes;
use std::ops::Range;

/// Buffers of [`LANES`](crate::math::lanes::LANES) blocks of one size.
pub struct Batch {
    /// Π_e \[J\]
    pub energy: Lanes,
    /// \[n\] r_e \[N\]
    pub r: Vec<Lanes>,
    /// \[n × n\] K_e row by row; only entries with column ≤ row are read \[N/m\]
    pub k: Vec<Lanes>,
    /// Memory for the responses at the points of the blocks
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

/// An effect that evaluates [`LANES`](crate::math::lanes::LANES) blocks at once: what [`Effect::eval`](super::Effect::eval) gives
/// for each, to rounding.
pub trait Batched: Sync {
    /// The blocks `first` to `first` + LANES − 1, where `first` is a multiple of LANES. Energy and r are zero before. Where the tangent is wanted,
    /// every entry with column ≤ row is set: K_e holds those of other blocks.
    fn eval(&self, at: &At, first: usize, want: Want, out: &mut Batch) -> Result<(), EvalError>;
}
