//! Simultaneous evaluation of several blocks of one size.

use super::{At, EvalError, Want};
use crate::math::lanes::Lanes;

/// Buffers of [`LANES`](crate::math::lanes::LANES) blocks of one size, zeroed before each evaluation.
pub struct Batch {
    /// Π_e \[J\]
    pub energy: Lanes,
    /// \[n\] r_e \[N\]
    pub r: Vec<Lanes>,
    /// \[n × n\] K_e row by row; only entries with column ≤ row are read \[N/m\]
    pub k: Vec<Lanes>,
}

impl Batch {
    pub fn new(n: usize) -> Self {
        Self { energy: Lanes::ZERO, r: vec![Lanes::ZERO; n], k: vec![Lanes::ZERO; n * n] }
    }

    pub(super) fn reset(&mut self, n: usize, want: Want) {
        self.energy = Lanes::ZERO;
        self.r[..n].fill(Lanes::ZERO);
        if want == Want::Tangent {
            self.k[..n * n].fill(Lanes::ZERO);
        }
    }
}

/// An effect that evaluates [`LANES`](crate::math::lanes::LANES) blocks at once: what [`Effect::eval`](super::Effect::eval) gives
/// for each, to rounding.
pub trait Batched: Sync {
    /// The blocks `first` to `first` + LANES − 1, where `first` is a multiple of LANES.
    fn eval(&self, at: &At, first: usize, want: Want, out: &mut Batch) -> Result<(), EvalError>;
}
