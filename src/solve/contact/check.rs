//! Conditions of contact on a step in addition to its equations, whose residual is measured by forces: no unilateral point is inside its obstacle,
//! and none has passed through its obstacle within the step. Contact with a barrier satisfies both by itself.

use crate::solve::nonlinear_solver::NonlinearSolver;
use crate::solve::{Failure, Step};
use crate::system::{ContactPoint, Dofs, EvalError, State, System};

/// Depth, relative to the length of the body, to which a unilateral point may be inside its obstacle, unless the tolerance of the equilibrium is
/// larger \[–\].
const INSIDE: f64 = 1e-5;
/// Size, relative to the normal, below which a component of it is rounding \[–\].
const ALONG: f64 = 1e-9;

/// Refuses a step whose prescribed displacements alone move a unilateral point inside its obstacle: no force changes that, and its multiplier is
/// undefined.
pub(in crate::solve) fn check_prescribed_points(step: &Step, guess: &State) -> Result<(), Failure> {
    if step.system.with_contact_points().next().is_none() {
        return Ok(());
    }
    let mut end = guess.x.clone();
    step.targets(guess).into_iter().for_each(|(dof, value)| end[dof] = value);
    for (effect, points) in step.system.with_contact_points() {
        if let Some(point) = points.inside(&end, 0.0).iter().find(|point| is_prescribed(point, step.system)) {
            return Err(Failure::Jammed { effect: effect.into(), node: point.nodes[0], gap: point.gap });
        }
    }
    Ok(())
}

/// Refuses the solution `next` of a step if a point is inside its obstacle or has passed through it.
pub(in crate::solve) fn check_solution(solver: &mut NonlinearSolver, step: &Step, next: &State) -> Result<(), Failure> {
    let depth = solver.equations.length * INSIDE.max(solver.settings.tolerance);
    let caches = &mut solver.equations.sums.caches;
    for (effect, points) in step.system.with_contact_points() {
        let inside = points.inside(&next.x, depth);
        let inside = inside.first().map(|point| (point.nodes[0], point.gap));
        if let Some((node, gap)) = inside.or_else(|| points.passed([&next.x, &step.past.x], caches)) {
            return Err(Failure::Eval(EvalError::Crossed { effect: effect.into(), node, gap }));
        }
    }
    Ok(())
}

/// Whether no free dof moves the point along its normal.
fn is_prescribed(point: &ContactPoint, system: &System) -> bool {
    let least = ALONG * point.normal.norm();
    let is_free = |dof: usize| system.dofs.equation[dof] != Dofs::FIXED;
    let moves = |node: u32, share: f64| {
        let along = |i: usize| (share * point.normal[i]).abs() > least;
        system.ties.has(node) || (0..3).any(|i| along(i) && is_free(3 * node as usize + i))
    };
    !point.nodes.iter().zip(&point.shares).any(|(&node, &share)| moves(node, share))
}
