//! The nonlinear solution in time. Sees only `math` and `system`, never an effect by name.

mod integrator;
mod multipliers;
mod newton;
mod sensitivity;
mod start;
mod step;
mod stepper;

pub use integrator::Integrator;
pub use newton::{Failure, Newton, NewtonSettings, Solved};
pub use sensitivity::Differentiator;
pub use start::initial_acceleration;
pub use step::Step;
pub use stepper::{Memory, Past, Span, Status, StepSettings, Stepper, Totals};
