//! Contributions to the sums: the block-by-block evaluation, the map from local unknowns to those of the system, and the weight.

use super::groups::Groups;
use super::{At, BlockValues, Blocks, Constraint, Effect, EvalError, Means, TransientBlocks, UnsymmetricTangent, Want};
use std::borrow::Cow;

/// The local evaluations of one effect or constraint.
pub(super) enum Kernel<'a> {
    Effect(&'a dyn Effect),
    /// Blocks of an effect that exist only at this state
    Transient(Box<dyn TransientBlocks + 'a>),
    Constraint(&'a dyn Constraint),
}

impl Kernel<'_> {
    pub fn blocks(&self) -> &Blocks {
        match self {
            Self::Effect(effect) => effect.blocks(),
            Self::Transient(blocks) => blocks.blocks(),
            Self::Constraint(constraint) => constraint.blocks(),
        }
    }

    /// Evaluates energy (or c), r and K of block `b`.
    pub fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        match self {
            Self::Effect(effect) => effect.eval(at, b, want, out),
            Self::Transient(blocks) => blocks.eval(at, b, want, out),
            Self::Constraint(constraint) => constraint.eval(at.x, b, want, out),
        }
    }
}

/// Map from the local unknowns of blocks to those of the system.
#[derive(Clone, Copy)]
pub(super) enum Coupling<'a> {
    /// The unknowns of the blocks are dofs; the slot in K of each local entry with column ≤ row, block after block
    Dofs(&'a [u32]),
    /// The unknowns are dofs, and all blocks of the effect contribute, in groups
    Groups(&'a Groups),
    /// The unknowns are weighted means of the displacement; the slots are those of the inner matrix of the low-rank part
    Means(&'a Means, &'a [u32]),
    /// The unknowns are dofs of a block without slots: it is inserted into a widened pattern after all others
    Transient,
}

/// The sums of the system that a contribution enters.
#[derive(Clone, Copy)]
pub(super) enum Receiver {
    /// Energy and dissipation of this effect
    Effect(usize),
    /// Value and gradient of this constraint
    Constraint(usize),
}

/// One summand of residual, tangent, and values of constraints.
pub(super) struct Contribution<'a> {
    pub kernel: Kernel<'a>,
    pub coupling: Coupling<'a>,
    pub receiver: Receiver,
    /// Factor of r and K in the sums: 1 for an effect, λ for a constraint, `None` for a constraint that does not act on the body
    pub weight: Option<f64>,
    /// Whether negative eigenvalues are removed from the blocks of the tangent
    pub projected: bool,
    /// Whether the part that the blocks of the tangent leave out is stored separately
    pub keeps_remainder: bool,
}

impl<'a> Contribution<'a> {
    /// The means through which the contribution depends on the body, if it does.
    pub fn means(&self) -> Option<&'a Means> {
        match self.coupling {
            Coupling::Means(means, _) => Some(means),
            _ => None,
        }
    }

    pub fn is_transient(&self) -> bool {
        matches!(self.coupling, Coupling::Transient)
    }

    /// The displacements that its kernel reads: x, or the means of x if it depends on the body through means.
    pub fn positions<'x>(&self, x: &'x [f64]) -> Cow<'x, [f64]> {
        self.means().map_or(x.into(), |means| means.of(x).into())
    }

    /// The unsymmetric part of its tangent, if it is to be stored.
    pub fn unsymmetric(&self) -> Option<&'a dyn UnsymmetricTangent> {
        match self.kernel {
            Kernel::Effect(effect) if self.keeps_remainder => effect.capabilities().unsymmetric,
            _ => None,
        }
    }

    /// weight|; 0 for a constraint that does not act on the body.
    pub fn size(&self) -> f64 {
        self.weight.map_or(0.0, f64::abs)
    }
}
