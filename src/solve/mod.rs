//! The nonlinear solution in time. Sees only `math` and `system`, never an effect by name.
//!
//! From the outside in:
//!
//! | Step | Where | Decides |
//! |---|---|---|
//! | A run | [`Driver::run_spans`] in `driver` | order of spans and grid points, [`Limit`]s, counts; calls the [`StepObserver`] |
//! | From one grid point to the next | a `StepStrategy`: `cut_steps`, `arc_length`, `corrected_steps` | the length of each step: when it is cut (at most [`StepSettings::cuts`] times), repeated, grows again |
//! | One step | `StepSolver::solve` in `step_solver` | initial values (`prediction`, of impacts `landing`) and fallbacks, what contact asks of a solution (`contact_check`); `diagnosis` and `limit_points` name the reason of a failure |
//! | Nonlinear solve | [`NonlinearSolver::solve`] in `newton`, `contact_correction` with `gauss_seidel`, or `equilibrium_path` for arc length | the iterations; `convergence` holds the acceptance test, `equations` the error it sees, `globalisation` the length along a direction |
//! | Linear system | [`LinearSystem`] in `linear_system` | factorisation, shift to positive definiteness, when the factor of an earlier step is reused (`lagged_factor`), the constraints (`multipliers`), skew parts (`tangent`) |
//!
//! [`Integrator`] maps displacements to velocities and accelerations, [`Step`] is the step to be solved, [`Status`] the end of a run
//! with its remedy. [`Differentiator`] takes derivatives of the states of a run by parameters, [`adjoints`] those of functionals of a state by
//! what is left in its equations.

mod adjoint;
mod arc_length;
mod contact_check;
mod contact_correction;
mod contact_law;
mod convergence;
mod corrected_steps;
mod cut_steps;
mod diagnosis;
mod driver;
mod driver_memory;
mod equations;
mod equilibrium_path;
mod failure;
mod free_bodies;
mod free_motions;
mod gauss_seidel;
mod globalisation;
mod integrator;
mod iteration;
mod lagged_factor;
mod landing;
mod limit;
mod limit_points;
mod linear_problem;
mod linear_system;
mod multipliers;
mod newton;
mod newton_settings;
mod nodal_rotations;
mod nonlinear_solver;
mod observer;
mod prediction;
mod rigid_motions;
mod sensitivity;
mod solution;
mod stability;
mod start;
mod status;
mod step;
mod step_settings;
mod step_solver;
mod step_strategy;
mod tangent;
mod time_span;
mod totals;

pub use adjoint::{Adjoint, adjoints};
pub use driver::Driver;
pub use driver_memory::DriverMemory;
pub use equations::Equations;
pub use equilibrium_path::TurningPoint;
pub use failure::Failure;
pub use free_motions::{Motion, MotionKind, free_motions};
pub use integrator::{Integrator, integrator_title};
pub use iteration::{IterationReport, OnIteration};
pub use lagged_factor::LaggedFactorRecord;
pub use limit::Limit;
pub use linear_system::LinearSystem;
pub use newton_settings::NewtonSettings;
pub use nonlinear_solver::NonlinearSolver;
pub use observer::{AcceptedStep, GridPoint, GridPosition, StepObserver};
pub use prediction::{PastPoint, Prediction};
pub use sensitivity::Differentiator;
pub use solution::Solution;
pub use start::{initial_acceleration, initial_acceleration_by};
pub use status::{Culprit, Status};
pub use step::Step;
pub use step_settings::{MOST_CUTS, StepSettings};
pub use step_solver::StepSolver;
use step_strategy::Stability;
pub use time_span::TimeSpan;
pub use totals::{Findings, Totals};
