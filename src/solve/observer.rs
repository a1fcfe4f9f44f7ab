//! The interface through which a caller follows a run: records, decides about inputs, stops.

use super::{DriverMemory, Integrator, SpanStart, Status};
use crate::system::{Assembled, State};
use std::ops::ControlFlow;

/// An accepted step.
#[derive(Clone, Copy)]
pub struct AcceptedStep<'a> {
    pub integrator: Integrator,
    /// State before the step
    pub past: &'a State,
    /// State at the end of the step
    pub now: &'a State,
    /// Iterations of the nonlinear solver
    pub iterations: usize,
    /// Residual, energies and constraints at `now`
    pub sums: &'a Assembled,
    /// Whether the step ends at a point of the time grid
    pub on_grid: bool,
}

/// A place in the time grids of a sequence of spans.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct GridPosition {
    /// Index of the span
    pub span: usize,
    /// Nominal steps of the span that are done
    pub step: usize,
}

/// A point of the time grid, before the step from it.
#[derive(Clone, Copy)]
pub struct GridPoint<'a> {
    pub position: GridPosition,
    /// Time of the next point \[s\]; none at the end of the last span
    pub next: Option<f64>,
    /// Everything that the driver needs, in addition to the state, to go on from here bit for bit
    pub memory: &'a dyn Fn() -> DriverMemory,
}

/// Follows a run of the [`Driver`](super::Driver).
///
/// A closure `|step: &AcceptedStep| -> bool` is an observer too; it stops the run by returning false. `()` ignores everything.
pub trait StepObserver {
    /// A span begins at `state`.
    fn span_begins(&mut self, _start: &SpanStart, _state: &State) {}

    /// The run is at a point of the time grid. The inputs of the state may be set here; to break ends the run with this status.
    fn grid_point(&mut self, _point: &GridPoint, _state: &mut State) -> ControlFlow<Status> {
        ControlFlow::Continue(())
    }

    /// A step was accepted. To break ends the run as [`Status::Interrupted`].
    fn accepted(&mut self, step: &AcceptedStep) -> ControlFlow<()>;
}

impl<F: FnMut(&AcceptedStep) -> bool> StepObserver for F {
    fn accepted(&mut self, step: &AcceptedStep) -> ControlFlow<()> {
        if self(step) { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }
}

impl StepObserver for () {
    fn accepted(&mut self, _step: &AcceptedStep) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}
