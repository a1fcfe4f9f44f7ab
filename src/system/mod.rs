//! The waist of the program: effects and constraints give local contributions, [`System`] sums them.
//!
//! Nothing is in the sum unless it is in the list: there is no gravity, damping or dt field and no flag here.

mod assembly;
mod batch;
mod contract;
mod derivative;
mod dofs;
mod means;
mod meeting;
mod projection;
mod rows;
mod scatter;
mod skew;
mod touching;
mod undefined;

pub use assembly::{Assembled, Cost, System, SystemError};
pub use batch::{Batch, Batched};
pub use contract::{At, Blocks, Constraint, Effect, Limit, Local, Needs, Rates, Role, State, Want};
pub use derivative::{Direction, Past, Term};
pub use dofs::{Dofs, Prescribed};
pub use means::Means;
pub use meeting::Meeting;
pub use rows::{Cone, Form, Piece, Rows, between, pieces};
pub use skew::Skew;
pub use touching::{Touch, Touching};
pub use undefined::EvalError;
