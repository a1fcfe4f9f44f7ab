//! The interface through which a caller follows a run: records it, sets inputs, and stops it.

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
    /// Number of iterations of the nonlinear solver
    pub iterations: usize,
    /// Residual, energies and constraints at `now`
    pub sums: &'a Assembled,
    /// Whether the step ends at a point of the time grid
    pub on_grid: bool,
}

/// A position in the time grids of a sequence of spans.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct GridPosition {
    /// Index of the span
    pub span: usize,
    /// Number of completed nominal steps of the span
    pub step: usize,
}

/// A point of the time grid, before the step from it.
#[derive(Clone, Copy)]
pub struct GridPoint<'a> {
    pub position: GridPosition,
    /// Time of the next point \[s\]; `None` at the end of the last span
    pub next: Option<f64>,
    /// Returns the data that the driver needs, in addition to the state, to continue from here bit for bit
    pub memory: &'a dyn Fn() -> DriverMemory,
}

/// An observer of a run of the [`Driver`](super::Driver).
///
/// A closure `|step: &AcceptedStep| -> bool` is also an observer; it stops the run by returning false. `()` ignores everything.
pub trait StepObserver {
    /// Called when a span starts at `state`.
    fn span_begins(&mut self, _start: &SpanStart, _state: &State) {}

    /// Called at each point of the time grid. The inputs of the state may be set here; returning `Break` ends the run with the given status.
    fn grid_point(&mut self, _point: &GridPoint, _state: &mut State) -> ControlFlow<Status> {
        ControlFlow::Continue(())
    }

    /// Called when a step was accepted. Returning `Break` ends the run as [`Status::Interrupted`].
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
