//! The waist of the program: effects and constraints give local contributions, [`System`] sums them.
//!
//! Nothing is in the sum unless it is in the list: there is no gravity, damping or dt field and no flag here.

mod assembly;
mod batch;
mod contact_points;
mod derivative;
mod dofs;
mod error;
mod means;
mod projection;
mod rows;
mod scatter;
mod skew;
mod traits;
mod transient_coupling;

pub use assembly::{Assembled, Cost, System, SystemError};
pub use batch::{Batch, Batched};
pub use contact_points::{ContactPoint, ContactPoints};
pub use derivative::{Direction, Past, Term};
pub use dofs::{Dofs, Prescribed};
pub use error::EvalError;
pub use means::Means;
pub use rows::{Cone, Form, Piece, Rows, between, pieces};
pub use skew::Skew;
pub use traits::{At, Blocks, Constraint, Effect, Limit, Local, Needs, Rates, Role, State, Want};
pub use transient_coupling::TransientCoupling;
