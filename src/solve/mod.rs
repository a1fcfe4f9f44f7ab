//! The nonlinear solution in time. Sees only `math` and `system`, never an effect by name.

mod continuation;
mod correction;
mod failure;
mod gauss_seidel;
mod integrator;
mod line_search;
mod multipliers;
mod newton;
mod path;
mod residual_search;
mod rigid;
mod sensitivity;
mod stale;
mod start;
mod status;
mod step;
mod stepper;
mod tangent;
mod turns;

pub use continuation::TurningPoint;
pub use failure::Failure;
pub use integrator::Integrator;
pub use newton::{Newton, NewtonSettings, Solved};
pub use rigid::{Motion, MotionKind};
pub use sensitivity::Differentiator;
pub use stale::Kept;
pub use start::initial_acceleration;
pub use status::{Culprit, Status};
pub use step::Step;
pub use stepper::{Findings, Memory, Past, Span, StepSettings, Stepper, Totals};
