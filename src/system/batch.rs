//! Simultaneous evaluation of several blocks of one size.

use super::{At, EvalError, Want};
use crate::material::LaneResponse;
use crate::math::lanes::Lanes;

/// Buffers of [`LANES`](crate::math::lanes::LANES) blocks of one size, zeroed before each evaluation as far as they are read.
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

    pub(super) fn reset(&mut self, n: usize, want: Want) {
        self.energy = Lanes::ZERO;
        self.r[..n].fill(Lanes::ZERO);
        if want == Want::Tangent {
            // Up to the diagonal block of the node, as far as anything is added
            let row = |i: usize| i * n..i * n + (i / 3 * 3 + 3).min(n);
            (0..n).for_each(|i| self.k[row(i)].fill(Lanes::ZERO));
        }
    }
}

/// An effect that evaluates [`LANES`](crate::math::lanes::LANES) blocks at once: what [`Effect::eval`](super::Effect::eval) gives
/// for each, to rounding.
pub trait Batched: Sync {
    /// The blocks `first` to `first` + LANES − 1, where `first` is a multiple of LANES.
    fn eval(&self, at: &At, first: usize, want: Want, out: &mut Batch) -> Result<(), EvalError>;
}
