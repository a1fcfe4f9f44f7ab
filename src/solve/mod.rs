//! The nonlinear solution in time. Sees only `math` and `system`, never an effect by name.

mod arc_length;
mod correction;
mod failure;
mod gauss_seidel;
mod integrator;
mod lagged_factor;
mod limit_points;
mod line_search;
mod multipliers;
mod newton;
mod nodal_rotations;
mod residual_search;
mod rigid;
mod sensitivity;
mod stability;
mod start;
mod status;
mod step;
mod stepper;
mod tangent;

pub use arc_length::TurningPoint;
pub use failure::Failure;
pub use integrator::Integrator;
pub use lagged_factor::Kept;
pub use newton::{Newton, NewtonSettings, Solved};
pub use rigid::{Motion, MotionKind};
pub use sensitivity::Differentiator;
pub use start::{initial_acceleration, initial_acceleration_by};
pub use status::{Culprit, Status};
pub use step::Step;
pub use stepper::{Findings, Memory, Past, Span, StepSettings, Stepper, Totals};
