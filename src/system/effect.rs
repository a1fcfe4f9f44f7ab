//! The trait of physical effects, and their optional capabilities.

use super::{At, Batched, BlockValues, Blocks, Caches, ContactPoints, EvalError, Means, Perturbation};
pub use crate::material::Want;
use crate::math::signal::Clock;
use std::sync::Arc;

/// One physical contribution to the residual, evaluated block by block (cell, node, cable segment).
///
/// Evaluations are pure: data may be kept between them only in the [`Caches`] of the caller, and must not change any result.
pub trait Effect: Send + Sync {
    fn name(&self) -> &str;
    /// The role of the effect in the energy balance.
    fn role(&self) -> EnergyRole;
    fn blocks(&self) -> &Blocks;
    /// Evaluates energy, r_e and K_e of block `b`. The meaning of the energy depends on [`Effect::role`].
    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError>;
    /// The intensity s(t) of a [`EnergyRole::Load`] or [`EnergyRole::Follower`].
    fn intensity(&self, _now: Clock) -> f64 {
        1.0
    }
    /// The optional capabilities: by default the effect reads only x and sums all of its blocks.
    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities::default()
    }
}

/// A shared effect, which probes or other effects also read.
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
    /// Weighted means through which alone the effect depends on the body: its blocks are then lists of means instead of nodes, and [`At::x`] holds
    /// the means. Such an effect reads only x, and all of its blocks contribute at every state.
    pub means: Option<&'a Arc<Means>>,
    /// Whether Newton's method uses K_e without its negative eigenvalues, because these would make most tangents indefinite
    pub semidefinite: bool,
    /// Variables that each block carries from step to step
    pub history: Option<&'a dyn HistoryVariables>,
    /// Derivatives with respect to the inputs other than x; absent if there are no such inputs, or if the derivatives are not implemented
    pub past: Option<&'a dyn PastDerivative>,
    /// The skew part of ∂r/∂x, which the symmetric K_e does not contain
    pub skew: Option<&'a dyn SkewTangent>,
    /// The unsymmetric part of ∂r/∂x that the symmetric K_e leaves out
    pub unsymmetric: Option<&'a dyn UnsymmetricTangent>,
    /// Selection of the blocks that contribute at a state; absent if all do
    pub active: Option<&'a dyn ActiveBlocks>,
    /// Blocks that exist only at one state, in addition to those of the effect
    pub transient: Option<&'a dyn TransientCoupling>,
    /// Limit of the motion within one iteration or step
    pub step_limit: Option<&'a dyn StepLimit>,
    /// Nodes that a stiff body carries when it rotates
    pub turning: Option<&'a dyn TurningBody>,
    /// Contact points for corrections
    pub contact_points: Option<&'a dyn ContactPoints>,
    /// Whether assemblies [without contact points](super::Assembled::without_contact_points) leave the effect out
    pub on_contact_points: bool,
    /// Name of the contact to which this friction belongs; the history is the [elastic slip](super::friction::HISTORY) of each of its points
    pub friction_of: Option<&'a str>,
    /// The residual of a load per unit of its intensity, if it is a polynomial of x
    pub polynomial: Option<&'a dyn PolynomialLoad>,
    /// Whether the residual is a constant matrix times the velocity or the acceleration
    pub linear_in_rates: bool,
    /// Evaluation of several blocks at once; requires that all blocks have one size
    pub batched: Option<&'a dyn Batched>,
}

impl Capabilities<'_> {
    /// Number of history variables of one block.
    pub fn history_size(&self) -> usize {
        self.history.map_or(0, HistoryVariables::size)
    }
}

/// Rates that an effect reads in addition to x; a static integrator provides neither.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Needs {
    pub velocity: bool,
    pub acceleration: bool,
}

/// Role of an effect in the energy balance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnergyRole {
    /// Energy ψ with r = ∂ψ/∂x
    Stored,
    /// Energy ψ with r = ∂ψ/∂x, between parts that are sometimes in contact and are not bonded
    Contact,
    /// Energy ½ v·Mv with r = M a
    Kinetic,
    /// The energy is the dissipation of the step, r·(x − old)
    Dissipative,
    /// Dissipation as in [`EnergyRole::Dissipative`], between parts in contact
    Friction,
    /// Stored energy ψ; the part of r beyond ∂ψ/∂x relaxes, and its work over the step is [`BlockValues::dissipated`]
    Relaxing,
    /// Energy φ per unit intensity, r = s(t) ∂φ/∂x: the load does the work −∫ s dφ
    Load,
    /// A load without a potential, r = s(t) dφ/dx. The energy is that of the step, ∫ dφ per unit intensity; the load does the work −∫ s dφ
    Follower,
}

impl EnergyRole {
    /// The name of the role in records.
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

/// Variables that each block of an effect carries from step to step; they are zero at rest.
pub trait HistoryVariables {
    /// Number of variables of one block.
    fn size(&self) -> usize;
    /// Computes the variables of block `b` at the end of the accepted step `at`. `new` holds those at its start on entry.
    fn advance(&self, at: &At, b: usize, new: &mut [f64]) -> Result<(), EvalError>;
    /// Computes the variables of block `b` if the body starts at the state `at` instead of at rest. `new` holds zeros on entry.
    fn begin(&self, _: &At, _b: usize, _new: &mut [f64]) -> Result<(), EvalError> {
        Ok(())
    }
    /// Computes the variables of all blocks in turn, as [`Self::advance`] does for one.
    fn advance_all(&self, at: &At, new: &mut [f64], _caches: &mut Caches) -> Result<(), EvalError> {
        new.chunks_exact_mut(self.size()).enumerate().try_for_each(|(b, new)| self.advance(at, b, new))
    }
    /// Replaces the variables of block `b` if r_e has a kink at them: the new ones give the same r_e at this state, and continue it smoothly on the
    /// side of the kink on which the state is. Differences of r_e and of [`Self::advance`] are taken with them.
    fn take_side(&self, _: &At, _b: usize, _history: &mut [f64]) -> Result<(), EvalError> {
        Ok(())
    }
}

/// Derivatives of an effect with respect to its inputs other than x.
pub trait PastDerivative {
    /// Computes the change of r_e along v, a, `old` and the history of the perturbation at fixed x; [`Perturbation::x`] is not read.
    fn along(&self, at: &At, by: &Perturbation, b: usize, out: &mut BlockValues) -> Result<(), EvalError>;
    /// Computes the change of the history of block `b` at the end of the step, along x, `old` and the history of the perturbation. `new` holds the
    /// change at the start on entry.
    fn advance_along(&self, _: &At, _: &Perturbation, _b: usize, _new: &mut [f64]) -> Result<(), EvalError> {
        Ok(())
    }
}

/// A load whose residual is its intensity times a polynomial of x.
pub trait PolynomialLoad {
    /// Degree of the polynomial.
    fn degree(&self) -> usize;
    /// Computes r_e of block `b` at unit intensity, which the load itself need not have at any time.
    fn unit_residual(&self, x: &[f64], b: usize, out: &mut BlockValues);
}

/// The skew part A = ½(∂r/∂x − (∂r/∂x)ᵀ) of the tangent of an effect.
pub trait SkewTangent {
    /// Blocks of A, which differ from those of the effect: unknowns on which A is zero may be left out.
    fn blocks(&self) -> &Blocks;
    /// Writes A_e of block `b` to `out.k` \[n × n\] row by row; only entries with column < row are read.
    fn eval(&self, at: &At, b: usize, out: &mut BlockValues);
}

/// The part of ∂r/∂x that the symmetric K_e of an effect leaves out. Newton's method includes it in its directions where that saves iterations.
pub trait UnsymmetricTangent {
    /// Writes ∂r_e/∂x − K_e of block `b` to `out.k` \[n × n\] row by row, all entries.
    fn eval(&self, at: &At, b: usize, out: &mut BlockValues) -> Result<(), EvalError>;
}

/// Selection of the blocks of an effect that contribute at a state; all blocks have one size.
pub trait ActiveBlocks {
    /// Indices of the contributing blocks, in ascending order.
    fn active(&self, at: &At, caches: &mut Caches) -> Vec<u32>;
}

/// Coupling of parts that come into contact at one state and separate again.
pub trait TransientCoupling {
    /// The blocks that exist at this state.
    fn blocks_at<'a>(&'a self, at: &At, caches: &mut Caches) -> Box<dyn TransientBlocks + 'a>;
    /// Lists of nodes that may be coupled soon. They depend only on x, so that a resumed run has the same sparsity pattern.
    fn candidates(&self, x: &[f64], caches: &mut Caches) -> Vec<Vec<u32>>;
    /// Whether there can be blocks with this node at some state.
    fn may_have(&self, node: u32) -> bool;
}

/// Blocks that exist only at one state.
pub trait TransientBlocks {
    fn blocks(&self) -> &Blocks;
    /// Evaluates block `b`, as [`Effect::eval`] does.
    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError>;
}

/// Limit of the motion within which an effect remains defined.
pub trait StepLimit {
    /// The largest admissible share of the motion dx from x; `None` if all of it is admissible.
    fn max_step(&self, x: &[f64], dx: &[f64], caches: &mut Caches) -> Option<MotionLimit>;
}

/// Nodes that a stiff body carries. A motion of them that is linear in the increment would stretch the body when it rotates.
pub trait TurningBody {
    /// Changes the motion dx from x into one that rotates the body as dx does, with the strain that is linear in dx, or with the strain of x.
    fn turn(&self, x: &[f64], dx: &mut [f64], strain: Strain);
}

/// The strain of a [`TurningBody`] after a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strain {
    /// The strain before the motion, for an extrapolated motion
    Kept,
    /// The strain that is linear in the motion, for a direction of Newton's method
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
