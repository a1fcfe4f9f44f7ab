//! The core interface of the program: effects and constraints provide local contributions, and [`System`] sums them.
//!
//! Only effects and constraints in the lists of the system enter the sums: there are no fields or flags for gravity, damping or a time step here.

mod assembled;
mod assembly;
mod batch;
mod blocks;
mod caches;
mod constraint;
mod contact_points;
mod contribution;
mod derivative;
mod dofs;
mod effect;
mod equations;
mod error;
pub mod friction;
mod gradient;
mod groups;
mod means;
mod parameter;
mod projection;
mod reactions;
mod skew;
mod sparsity;
mod state;
mod ties;
mod transient;
mod variant;
mod vertex_pairs;

pub use assembled::{Assembled, Cost};
pub use batch::{Batch, Batched};
pub use blocks::{BlockValues, Blocks};
pub use caches::{CacheKey, Caches};
pub use constraint::{
    Constraint, ConstraintKind, ConstraintValues, LawPiece, LinearFunction, bounded_multiplier, constraint_law,
};
pub use contact_points::{ContactPoint, ContactPoints, ContactPotential, NormalLaw};
pub use derivative::{ParameterDerivative, add_history_derivative, add_residual_derivative};
pub use dofs::{Dofs, Prescribed};
pub use effect::{
    ActiveBlocks, Capabilities, Effect, EnergyRole, HistoryVariables, MotionLimit, Needs, PastDerivative,
    PolynomialLoad, SkewTangent, StepLimit, Strain, TransientBlocks, TransientCoupling, TurningBody,
    UnsymmetricTangent, Want,
};
pub use equations::{System, SystemError};
pub use error::EvalError;
pub use gradient::Gradient;
pub use means::Means;
pub use parameter::{EquationChange, SystemDifference, SystemParameter, Variants};
pub use reactions::{WantedRows, add_products, constraint_changes, keep_prescribed};
pub use state::{At, Perturbation, Rates, State};
pub use ties::Ties;
pub use variant::SystemParts;
