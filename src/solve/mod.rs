//! The nonlinear solution in time. Sees only `math` and `system`, never an effect by name.

mod integrator;
mod multipliers;
mod newton;
mod start;
mod stepper;

pub use integrator::Integrator;
pub use newton::{Failure, Newton, NewtonSettings, Solved, Step};
pub use start::initial_acceleration;
pub use stepper::{Span, Status, StepSettings, Stepper, Totals};
