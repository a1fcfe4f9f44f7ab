//! The trait of step strategies, which take a run from one point of the time grid to the next.

use super::step_solver::StepSolver;
use super::{Solution, Status, TurningPoint};
use crate::system::State;

/// A strategy that chooses and solves the steps between two points of the time grid. The [`Driver`](super::Driver) calls `begin`, then `step` until
/// `is_done`, with `accepted` after each accepted step.
pub(super) trait StepStrategy<'a>: Send {
    /// Prepares the steps from `state` to the time `goal` \[s\].
    fn begin(&mut self, steps: &mut StepSolver<'a>, state: &State, goal: f64) -> Result<(), Status>;

    /// Tries one step from `state`.
    fn step(&mut self, steps: &mut StepSolver<'a>, state: &State) -> StepOutcome;

    /// Called after the last step was accepted and observed: returns its findings, and prepares the next step.
    fn accepted(
        &mut self,
        steps: &mut StepSolver<'a>,
        past: &State,
        now: &State,
        solution: &Solution,
    ) -> (Stability, Option<TurningPoint>);

    /// Whether the goal is reached.
    fn is_done(&self) -> bool;

    /// Whether the strategy runs to the end of the span at once, without its time grid.
    fn ignores_grid(&self) -> bool {
        false
    }

    /// Current number of cuts of the nominal step.
    fn cuts(&self) -> u32 {
        0
    }
}

/// Result of one trial step.
pub(super) enum StepOutcome {
    Solved(Box<SolvedStep>),
    /// The step did not converge; a shorter one is to be tried
    Cut,
    /// The time error of the step was too large; a shorter one is to be tried
    Repeat,
    /// No step is possible
    Failed(Status),
}

/// A solved step that is to be accepted.
pub(super) struct SolvedStep {
    pub next: State,
    pub solution: Solution,
    /// Whether it ends at a point of the time grid
    pub on_grid: bool,
    /// Whether its time error is too large, and it cannot be cut any further
    pub coarse: bool,
}

/// Stability of an accepted equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stability {
    NotJudged,
    /// The linear solver does not count negative eigenvalues
    NotCounted,
    /// Number of negative eigenvalues of the constrained tangent
    UnstableModes(usize),
}

impl From<Option<usize>> for Stability {
    fn from(modes: Option<usize>) -> Self {
        modes.map_or(Self::NotCounted, Self::UnstableModes)
    }
}
