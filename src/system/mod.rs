//! The waist of the program: effects and constraints give local contributions, [`System`] sums them.
//!
//! Nothing is in the sum unless it is in the list: there is no gravity, damping or dt field and no flag here.

mod assembly;
mod batch;
mod blocks;
mod caches;
mod constraint;
mod contact_points;
mod derivative;
mod dofs;
mod effect;
mod error;
mod means;
mod projection;
mod scatter;
mod skew;
mod state;
mod transient_coupling;

pub use assembly::{Assembled, Cost, System, SystemError};
pub use batch::{Batch, Batched};
pub use blocks::{BlockValues, Blocks};
pub use caches::{CacheKey, Caches};
pub use constraint::{Cone, Constraint, ConstraintValues, Form, Piece, between, pieces};
pub use contact_points::{ContactPoint, ContactPoints};
pub use derivative::ParameterDerivative;
pub use dofs::{Dofs, Prescribed};
pub use effect::{
    ActiveBlocks, Capabilities, Effect, EnergyRole, HistoryVariables, MotionLimit, Needs, PastDerivative, SkewTangent,
    StepLimit, TransientBlocks, TransientCoupling, Want,
};
pub use error::EvalError;
pub use means::Means;
pub use state::{At, Perturbation, Rates, State};
