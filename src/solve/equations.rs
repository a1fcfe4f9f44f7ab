//! The equations of the current step, assembled: residual, tangent, constraints, and the error of a state.

use super::linear::multipliers;
use super::{Failure, Limit, Step};
use crate::math::statistics::larger;
use crate::math::vector::norm;
use crate::system::{Assembled, ConstraintKind, ConstraintValues, State, System, Want};
use std::time::{Duration, Instant};

/// Share of a Newton step below which its limit prevents any motion of the body \[–\].
const JAMMED: f64 = 1e-10;
/// Size relative to the length of the body below which a displacement counts as zero \[–\].
const REST: f64 = 1e-8;
/// Size relative to the length of the body below which a gap is rounding \[–\].
const CLOSED: f64 = 1e-12;
/// Displacement relative to the length of the body above which an iteration is diverging, so that the displacement does not increase the estimate of
/// rounding \[–\].
const LOST: f64 = 1e5;

/// The sums over the effects, and the data needed to judge them.
pub struct Equations {
    pub sums: Assembled,
    /// Wall time of all evaluations
    pub assembly_time: Duration,
    /// ‖diag K‖ of the last tangent \[N/m\], for the rounding of forces; entries with displacements longer than the body are scaled by displacement
    /// over body length
    pub stiffness: f64,
    /// Length of the body \[m\], for the rounding of forces
    pub(super) length: f64,
    /// Limit of the run, after which nothing is assembled
    pub limit: Limit,
    /// \[constraints\] g at the start of the step, if the law of a constraint depends on it
    old: Vec<f64>,
}

/// Error of a state: the larger of the errors of forces and of constraints, relative to their scales.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ScaledError {
    /// Error with the forces relative to the largest Σ‖r_e‖ of any effect
    pub exact: f64,
    /// Error in which forces at the rounding level of the stiffest part count as no more than the tolerance
    pub above_rounding: f64,
    /// Whether the forces are at the rounding level of the stiffest part
    pub is_rounding: bool,
}

impl Equations {
    pub(super) fn new(system: &System, length: f64) -> Self {
        Self {
            sums: Assembled { descending: true, ..system.workspace() },
            assembly_time: Duration::ZERO,
            stiffness: 0.0,
            length,
            limit: Limit::default(),
            old: vec![0.0; system.constraints.len()],
        }
    }

    /// Begins the step to `next`: refuses inputs that are not finite, evaluates what the laws of the constraints need at the last state, and removes
    /// the transient entries of the last step from the pattern of the tangent.
    pub(super) fn begin(&mut self, step: &Step, targets: &[(usize, f64)], next: &State) -> Result<(), Failure> {
        step.check_inputs(targets, next)?;
        if step.system.constraints.iter().any(|c| c.kind() == ConstraintKind::Linked) {
            self.old = step.system.gaps(step.past).map_err(Failure::Eval)?;
        }
        self.sums.reset_pattern(&step.system.pattern);
        Ok(())
    }

    pub(super) fn evaluate(
        &mut self,
        step: &Step,
        next: &mut State,
        want: Want,
        increment: Option<&[f64]>,
    ) -> Result<(), Failure> {
        self.go_on()?;
        let start = Instant::now();
        let State { x, v, a, .. } = next;
        step.integrator.kinematics(step.past, step.dt, x, v, a);
        let result = step.system.assemble(&step.at(next), &next.lambda, want, increment, &mut self.sums);
        self.assembly_time += start.elapsed();
        result.map_err(Failure::Eval)
    }

    /// Fails if the limit of the run is reached.
    pub(super) fn go_on(&self) -> Result<(), Failure> {
        if self.limit.reached().is_some() { Err(Failure::LimitReached) } else { Ok(()) }
    }

    /// Evaluates residual and tangent of an iteration, and stores the stiffness of the tangent.
    pub(super) fn linearise(
        &mut self,
        step: &Step,
        next: &mut State,
        increment: Option<&[f64]>,
    ) -> Result<(), Failure> {
        self.evaluate(step, next, Want::Tangent, increment)?;
        self.stiffness = self.present_stiffness(step.system, &next.x);
        Ok(())
    }

    /// Advances the history of `next`, the solution of the step, to the end of the step.
    pub(super) fn advance_history(&mut self, step: &Step, next: &mut State) -> Result<(), Failure> {
        let start = Instant::now();
        let mut history = std::mem::take(&mut next.history);
        let result = step.system.advance(&step.at(next), &mut history, &mut self.sums);
        if step.integrator.is_one_iteration() {
            step.system.forget_elastic_slips(&mut history);
        }
        next.history = history;
        self.assembly_time += start.elapsed();
        result.map_err(Failure::Eval)
    }

    /// Error of the state to which the sums belong. Forces below 4ε ‖k‖ L, with k_i = K_ii max(1, |x_i|/L), are at the rounding level: K u is a sum
    /// of terms of size K_ii x_i, even if the body moves as a whole.
    pub(super) fn error(&self, system: &System, state: &State, tolerance: f64) -> ScaledError {
        self.error_at_stiffness(system, state, tolerance, self.stiffness)
    }

    /// Error of the state to which the sums belong, with ‖diag K‖ of the tangent in the sums.
    pub(super) fn error_at_tangent(&self, system: &System, state: &State, tolerance: f64) -> ScaledError {
        self.error_at_stiffness(system, state, tolerance, self.present_stiffness(system, &state.x))
    }

    fn present_stiffness(&self, system: &System, x: &[f64]) -> f64 {
        let mut diagonal = self.sums.pattern.diagonal(&self.sums.k);
        let moving = |dof: u32| dof < system.dofs.displacements;
        for (k, &dof) in diagonal.iter_mut().zip(&system.dofs.free).filter(|(_, dof)| moving(**dof)) {
            *k *= (x[dof as usize].abs() / self.length).clamp(1.0, LOST);
        }
        norm(&diagonal)
    }

    fn error_at_stiffness(&self, system: &System, state: &State, tolerance: f64, stiffness: f64) -> ScaledError {
        let residual = norm(&system.restrict(&self.sums.r));
        let rows = multipliers::error(system, &self.rows(state));
        let scaled = |floor: f64| {
            let scale = self.sums.scale.max(floor / tolerance);
            larger(if residual == 0.0 { 0.0 } else { residual / scale }, rows)
        };
        let rounding = 4.0 * f64::EPSILON * stiffness * self.length;
        ScaledError { exact: scaled(0.0), above_rounding: scaled(rounding), is_rounding: residual <= rounding }
    }

    /// The displacement \[m\], but not less than the largest one that counts as rest.
    pub(super) fn visible(&self, displacement: f64) -> f64 {
        displacement.max(REST * self.length)
    }

    /// The values of the constraints at `state`, to which the sums belong.
    pub(super) fn rows<'a>(&'a self, state: &'a State) -> ConstraintValues<'a> {
        ConstraintValues {
            now: state.clock(),
            g: &self.sums.g,
            lambda: &state.lambda,
            old: &self.old,
            force: self.sums.scale,
        }
    }

    /// −r − lift \[equations\]; the lift is included only if a prescribed increment remains.
    pub(super) fn right_side(&self, system: &System, lifted: bool) -> Vec<f64> {
        let mut y = system.restrict(&self.sums.r);
        y.iter_mut().zip(&self.sums.increment_force).for_each(|(y, lift)| *y = -*y - if lifted { *lift } else { 0.0 });
        y
    }

    /// Node with the largest component of the residual.
    pub(super) fn worst_node(&self, system: &System) -> u32 {
        let largest = |a: &&u32, b: &&u32| self.sums.r[**a as usize].abs().total_cmp(&self.sums.r[**b as usize].abs());
        system.dofs.free.iter().max_by(largest).map_or(0, |dof| dof / 3)
    }

    /// The largest share of the motion dx from x that no effect forbids.
    pub(super) fn longest(&mut self, system: &System, x: &[f64], dx: &[f64]) -> Result<f64, Failure> {
        match system.max_step(x, dx, &mut self.sums.caches) {
            None => Ok(1.0),
            Some((effect, limit)) if limit.share < JAMMED || limit.gap < CLOSED * self.length => {
                Err(Failure::Jammed { effect: effect.into(), node: limit.node, gap: limit.gap })
            }
            Some((_, limit)) => Ok(limit.share),
        }
    }
}
