//! The trait of a physical effect, and the optional capabilities of one.

use super::{At, Batched, BlockValues, Blocks, Caches, ContactPoints, EvalError, Means, Perturbation};
pub use crate::material::Want;
use crate::math::signal::Clock;
use std::sync::Arc;

/// One physical contribution to the residual, given block by block (cell, node, cable segment).
///
/// Evaluations are pure: what may be kept from one to the next is in the [`Caches`] of the caller, and changes no result.
pub trait Effect: Send + Sync {
    fn name(&self) -> &str;
    /// Place of the effect in the energy balance.
    fn role(&self) -> EnergyRole;
    fn blocks(&self) -> &Blocks;
    /// Energy, r_e and K_e of block `b`. The meaning of the energy depends on [`Effect::role`].
    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError>;
    /// s(t) of a [`EnergyRole::Load`] or [`EnergyRole::Follower`].
    fn intensity(&self, _now: Clock) -> f64 {
        1.0
    }
    /// Everything optional: by default the effect reads x only and sums all of its blocks.
    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities::default()
    }
}

/// A shared effect, which probes or other effects read too.
impl<E: Effect + ?Sized> Effect for Arc<E> {
    fn name(&self) -> &str {
        (**self).name()
    }
    fn role(&self) -> EnergyRole {
        (**self).role()
    }
    fn blocks(&self) -> &Blocks {
        (**self).blocks()
    }
    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        (**self).eval(at, b, want, out)
    }
    fn intensity(&self, now: Clock) -> f64 {
        (**self).intensity(now)
    }
    fn capabilities(&self) -> Capabilities<'_> {
        (**self).capabilities()
    }
}

/// Optional capabilities of an effect; the default has none of them.
#[derive(Clone, Copy, Default)]
pub struct Capabilities<'a> {
    /// Fields that the effect reads in addition to x
    pub needs: Needs,
    /// Weighted means by which alone the effect depends on the body: its blocks are then lists of means instead of nodes, and
    /// [`At::x`] holds the means. Such an effect reads x only, and all of its blocks contribute at every state.
    pub means: Option<&'a Arc<Means>>,
    /// Whether Newton's method uses K_e without its negative eigenvalues, because these would make most tangents indefinite
    pub semidefinite: bool,
    /// Variables that each block carries from step to step
    pub history: Option<&'a dyn HistoryVariables>,
    /// Derivatives by the inputs other than x; absent if there are no such inputs, or if the derivatives are not implemented
    pub past: Option<&'a dyn PastDerivative>,
    /// The skew part of ∂r/∂x, which the symmetric K_e does not contain
    pub skew: Option<&'a dyn SkewTangent>,
    /// The unsymmetric part of ∂r/∂x that the symmetric K_e leaves out
    pub unsymmetric: Option<&'a dyn UnsymmetricTangent>,
    /// Selection of the blocks that contribute at a state; absent if all do
    pub active: Option<&'a dyn ActiveBlocks>,
    /// Blocks that exist at one state only, in addition to those of the effect
    pub transient: Option<&'a dyn TransientCoupling>,
    /// Limit of the motion within one iteration or step
    pub step_limit: Option<&'a dyn StepLimit>,
    /// Nodes that move together as a body that turns
    pub turning: Option<&'a dyn TurningBody>,
    /// Contact points for corrections
    pub contact_points: Option<&'a dyn ContactPoints>,
    /// Whether assemblies [without contact points](super::Assembled::without_contact_points) leave the effect out
    pub on_contact_points: bool,
    /// Name of the contact whose friction this is, with the [elastic slip](super::friction::HISTORY) of each of its points as history
    pub friction_of: Option<&'a str>,
    /// The residual of a load per unit of its intensity, where it is a polynomial of x
    pub polynomial: Option<&'a dyn PolynomialLoad>,
    /// Whether the residual is a constant matrix times the velocity or the acceleration
    pub linear_in_rates: bool,
    /// Evaluation of several blocks at once; all blocks then have one size
    pub batched: Option<&'a dyn Batched>,
}

impl Capabilities<'_> {
    /// History variables of one block.
    pub fn history_size(&self) -> usize {
        self.history.map_or(0, HistoryVariables::size)
    }
}

/// Rates that an effect reads in addition to x; a static integrator has neither.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Needs {
    pub velocity: bool,
    pub acceleration: bool,
}

/// Place of an effect in the energy balance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnergyRole {
    /// Energy ψ with r = ∂ψ/∂x
    Stored,
    /// Energy ψ with r = ∂ψ/∂x, of parts that are in contact at times and are not held together
    Contact,
    /// Energy ½ v·Mv with r = M a
    Kinetic,
    /// Energy: dissipation of the step, r·(x − old)
    Dissipative,
    /// As [`EnergyRole::Dissipative`], between parts in contact
    Friction,
    /// Energy ψ, stored; the part of r beyond ∂ψ/∂x relaxes, and its work over the step is [`BlockValues::dissipated`]
    Relaxing,
    /// Energy φ per unit intensity, r = s(t) ∂φ/∂x: the load does the work −∫ s dφ
    Load,
    /// A load without a potential. Energy: of the step, ∫ dφ per unit intensity with r = s(t) dφ/dx; its work is −∫ s dφ
    Follower,
}

impl EnergyRole {
    /// The name in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stored => "stored",
            Self::Contact => "contact",
            Self::Kinetic => "kinetic",
            Self::Dissipative => "dissipative",
            Self::Friction => "friction",
            Self::Relaxing => "relaxing",
            Self::Load => "load",
            Self::Follower => "follower",
        }
    }
}

/// Variables that each block of an effect carries from step to step, zero at rest.
pub trait HistoryVariables {
    /// Variables of one block.
    fn size(&self) -> usize;
    /// The variables of block `b` at the end of the accepted step `at`. `new` holds those at its start.
    fn advance(&self, at: &At, b: usize, new: &mut [f64]) -> Result<(), EvalError>;
    /// The variables of block `b` of a body that begins at the state `at` in place of rest. `new` holds zeros.
    fn begin(&self, _: &At, _b: usize, _new: &mut [f64]) -> Result<(), EvalError> {
        Ok(())
    }
    /// The variables of all blocks, one after the other, as [`Self::advance`] gives them.
    fn advance_all(&self, at: &At, new: &mut [f64], _caches: &mut Caches) -> Result<(), EvalError> {
        new.chunks_exact_mut(self.size()).enumerate().try_for_each(|(b, new)| self.advance(at, b, new))
    }
    /// Puts variables in place of those of block `b` at which r_e has a kink: at this state they give the same r_e, which continues smoothly on the side on
    /// which the state is. Differences of r_e and of [`Self::advance`] are taken with them.
    fn take_side(&self, _: &At, _b: usize, _history: &mut [f64]) -> Result<(), EvalError> {
        Ok(())
    }
}

/// Derivatives of an effect by its inputs other than x.
pub trait PastDerivative {
    /// The change of r_e along v, a, `old` and the history of the perturbation, at fixed x; [`Perturbation::x`] is not read.
    fn along(&self, at: &At, by: &Perturbation, b: usize, out: &mut BlockValues) -> Result<(), EvalError>;
    /// The change of the history of block `b` at the end of the step, along x, `old` and the history of the perturbation.
    /// `new` holds the change at the start.
    fn advance_along(&self, _: &At, _: &Perturbation, _b: usize, _new: &mut [f64]) -> Result<(), EvalError> {
        Ok(())
    }
}

/// A load whose residual is its intensity times a polynomial of x.
pub trait PolynomialLoad {
    /// Degree of the polynomial.
    fn degree(&self) -> usize;
    /// r_e of block `b` at an intensity of one, which the load itself need not have at any time.
    fn unit_residual(&self, x: &[f64], b: usize, out: &mut BlockValues);
}

/// The skew part A = ½(∂r/∂x − (∂r/∂x)ᵀ) of the tangent of an effect.
pub trait SkewTangent {
    /// Blocks of A, which are not those of the effect: unknowns on which A is zero may be missing.
    fn blocks(&self) -> &Blocks;
    /// A_e of block `b` in `out.k` \[n × n\] row by row; only entries with column < row are read.
    fn eval(&self, at: &At, b: usize, out: &mut BlockValues);
}

/// The part of ∂r/∂x that the symmetric K_e of an effect leaves out. Newton's method adds it to its directions where that saves iterations.
pub trait UnsymmetricTangent {
    /// ∂r_e/∂x − K_e of block `b` in `out.k` \[n × n\] row by row, all entries.
    fn eval(&self, at: &At, b: usize, out: &mut BlockValues) -> Result<(), EvalError>;
}

/// Selection of the blocks of an effect that contribute at a state; all blocks have one size.
pub trait ActiveBlocks {
    /// Blocks in ascending order.
    fn active(&self, at: &At, caches: &mut Caches) -> Vec<u32>;
}

/// Coupling of parts that come into contact at one state and separate again.
pub trait TransientCoupling {
    /// The blocks that exist at this state.
    fn blocks_at<'a>(&'a self, at: &At, caches: &mut Caches) -> Box<dyn TransientBlocks + 'a>;
    /// Lists of nodes that may be coupled soon. They depend on x alone, so that a resumed run has the same sparsity pattern.
    fn candidates(&self, x: &[f64], caches: &mut Caches) -> Vec<Vec<u32>>;
    /// Whether blocks with this node exist at some state.
    fn may_have(&self, node: u32) -> bool;
}

/// Blocks that exist at one state.
pub trait TransientBlocks {
    fn blocks(&self) -> &Blocks;
    /// As [`Effect::eval`].
    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError>;
}

/// Limit of the motion within which an effect remains defined.
pub trait StepLimit {
    /// The largest admissible share of the motion dx from x; None if all of it is admissible.
    fn max_step(&self, x: &[f64], dx: &[f64], caches: &mut Caches) -> Option<MotionLimit>;
}

/// Nodes that a stiff body carries: their motion, linear in the increment, would stretch a body that turns.
pub trait TurningBody {
    /// Changes the motion dx from x to one that turns the body as dx does, with the strain that is linear in dx, or with that of x.
    fn turn(&self, x: &[f64], dx: &mut [f64], strain: Strain);
}

/// The strain of a [`TurningBody`] after a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strain {
    /// As before the motion: of a motion that is extrapolated
    Kept,
    /// Linear in the motion: of a direction of Newton's method
    Linear,
}

/// The largest admissible share of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionLimit {
    /// Share of the motion, 0 to 1
    pub share: f64,
    /// Node that limits the motion
    pub node: u32,
    /// Distance of that node from the obstacle \[m\]
    pub gap: f64,
}
