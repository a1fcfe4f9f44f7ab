//! The nonlinear solution in time. It uses only `math` and `system`, and never refers to an effect by name.
//!
//! From the outside inwards:
//!
//! | Step | Where | Decides |
//! |---|---|---|
//! | A run | [`Driver::run_spans`] in `driver` | order of spans and grid points, [`Limit`]s, counts; calls the [`StepObserver`] |
//! | From one grid point to the next | a `StepStrategy`: `cut_steps`, `arc_length`, `contact::corrected_steps` | the length of each step: when it is cut (at most [`StepSettings::cuts`] times), repeated, or doubled again |
//! | One step | `StepSolver::solve` in `step_solver` | initial values (`prediction`; for impacts `contact::landing`) and fallbacks, the conditions of contact on a solution (`contact::check`); `diagnosis` and `arc_length::limit_points` find the reason of a failure |
//! | Nonlinear solve | [`NonlinearSolver::solve`] in `newton`, `contact::correction` with `contact::gauss_seidel`, or `arc_length::path` | the iterations; `newton::convergence` holds the acceptance test, `equations` the error that it judges, `newton::globalisation` the length along a direction |
//! | Linear system | [`LinearSystem`] in `linear::system` | factorisation, shift to positive definiteness, reuse of the factor of an earlier step (`linear::lagged_factor`), constraints (`linear::multipliers`), skew parts (`linear::tangent`) |
//!
//! [`SpanStart`] determines how a span continues from the one before it. [`Integrator`] maps displacements to velocities and accelerations, [`Step`]
//! is the step to be solved, and [`Status`] the end of a run with its remedy. [`Differentiator`] computes derivatives of the states of a run with
//! respect to parameters, and [`adjoints`] those of functionals of a state with respect to residuals of its equations.

mod arc_length;
mod contact;
mod cut_steps;
mod diagnosis;
mod driver;
mod driver_memory;
mod equations;
mod integrator;
mod limit;
mod linear;
mod newton;
mod nonlinear_solver;
mod observer;
mod prediction;
mod second_field;
mod sensitivity;
mod span_start;
mod start;
mod status;
mod step;
mod step_settings;
mod step_solver;
mod step_strategy;
mod time_span;
mod totals;

pub use arc_length::path::TurningPoint;
pub use diagnosis::free_motions::{Motion, MotionKind, free_motions};
pub use driver::Driver;
pub use driver_memory::DriverMemory;
pub use equations::Equations;
pub use integrator::{Integrator, integrator_order, integrator_title};
pub use limit::Limit;
pub use linear::lagged_factor::LaggedFactorRecord;
pub use linear::system::LinearSystem;
pub use newton::failure::Failure;
pub use newton::iteration::{IterationReport, OnIteration};
pub use newton::settings::NewtonSettings;
pub use newton::solution::Solution;
pub use nonlinear_solver::NonlinearSolver;
pub use observer::{AcceptedStep, GridPoint, GridPosition, StepObserver};
pub use prediction::{PastPoint, Prediction};
pub use second_field::set_second_field;
pub use sensitivity::Differentiator;
pub use sensitivity::adjoint::{Adjoint, adjoints};
pub use span_start::SpanStart;
pub use start::{initial_acceleration, initial_acceleration_by};
pub use status::{Culprit, Status};
pub use step::Step;
pub use step_settings::{MOST_CUTS, StepSettings};
pub use step_solver::StepSolver;
use step_strategy::Stability;
pub use time_span::TimeSpan;
pub use totals::{Findings, Totals};
