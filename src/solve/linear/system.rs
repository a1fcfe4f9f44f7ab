//! The strategy for the linear systems: direct or iterative, with a new or a lagged factor, with K shifted towards positive definiteness if the
//! constrained tangent is indefinite, and with the constraints treated by a Schur complement.
//!
//! [`LinearSystem::may_reuse_factor`] decides whether a step may reuse the factor of an earlier step; [`lagged_factor`](super::lagged_factor) decides
//! whether the next step does.

use super::lagged_factor::{LaggedFactor, LaggedFactorRecord};
use super::multipliers::Schur;
use super::problem::{LinearProblem, NewtonDirection};
use super::stability::negative_eigenvalues;
use crate::math::linear::{Factor, Method};
use crate::math::tensor::Vec3;
use crate::solve::equations::Equations;
use crate::solve::newton::settings::NewtonSettings;
use crate::solve::{Failure, Solution, Step};
use crate::system::{Assembled, ConstraintKind, State, System};
use std::sync::Arc;
use std::time::Duration;

/// Stiffness, relative to the largest diagonal entry, that the shift assumes for a direction without stiffness \[–\].
const SOFTEST: f64 = 1e-9;
/// Smallest shift, relative to the diagonal \[–\].
const FIRST_SHIFT: f64 = 1e-3;
/// Growth of the shift from one attempt to the next \[–\].
const SHIFT_GROWTH: f64 = 10.0;
/// Shift, relative to the diagonal, beyond which shifting is useless \[–\].
const LARGEST_SHIFT: f64 = 1e3;

/// Solves the linear systems of a run. Its factor is reused from step to step.
pub struct LinearSystem {
    /// The choice between the direct and the iterative method
    pub method: Method,
    pub factor: Factor,
    /// \[nodes\] X, for rotating a lagged factor with the body; or empty
    pub points: Vec<Vec3>,
    /// Number of factorisations of shifted tangents so far
    pub shifted: usize,
    /// Time spent on the forces of contact points in corrections
    pub contact_forces: Duration,
    /// Whether tangents are used without a shift, even if they are indefinite
    pub(in crate::solve) keeps_indefinite: bool,
    lagged: LaggedFactor,
}

impl LinearSystem {
    pub(in crate::solve) fn new(method: Method, system: &System) -> Self {
        let factor = Factor::by(method.clone(), system.pattern.clone(), system.definiteness());
        Self {
            method,
            factor,
            points: Vec::new(),
            shifted: 0,
            contact_forces: Duration::ZERO,
            keeps_indefinite: false,
            lagged: LaggedFactor::default(),
        }
    }

    /// Whether the equations allow the reuse of a lagged factor. K must be symmetric, and definite where the constraints hold.
    pub(in crate::solve) fn may_reuse_factor(
        &self,
        settings: &NewtonSettings,
        system: &System,
        sums: &Assembled,
    ) -> bool {
        settings.reuse_factor
            && self.factor.relative_cost() >= settings.reuse_threshold
            && !system.has_skew_tangent()
            && !system.has_transient_coupling()
            && !sums.projected
            && system
                .constraints
                .iter()
                .all(|c| !matches!(c.kind(), ConstraintKind::Linked | ConstraintKind::Monitored))
    }

    /// Computes the direction of an iteration with the lagged factor, or with a new hierarchy of the iterative method; `None` if neither succeeds.
    /// `error` is that of the state, which is the start of the step if this is the `first` iteration.
    pub(in crate::solve) fn direction_by_lagged_factor(
        &mut self,
        problem: &LinearProblem,
        tolerance: f64,
        error: f64,
        first: bool,
    ) -> Option<NewtonDirection> {
        let Self { factor, points, lagged, .. } = self;
        let reused = lagged.may_be_reused(factor, problem.step.rates(), first);
        let found = reused.then(|| lagged.direction(factor, points, problem, tolerance, error, first)).flatten();
        if found.is_some() || !self.renew_hierarchy(problem) {
            return found;
        }
        let Self { factor, points, lagged, .. } = self;
        lagged.direction(factor, points, problem, tolerance, error, first)
    }

    /// Computes the direction by one application of the lagged factor, if it is valid.
    pub(in crate::solve) fn rough_direction(
        &mut self,
        problem: &LinearProblem,
        first: bool,
    ) -> Option<NewtonDirection> {
        let Self { factor, points, lagged, .. } = self;
        let valid = lagged.may_be_reused(factor, problem.step.rates(), false);
        let rough = valid.then(|| lagged.rough(factor, points, problem, first)).flatten()?;
        Some(problem.direction(&rough.x, rough.lambda))
    }

    /// Iterative method: sets up a hierarchy of the current tangent, for a direction that is only as accurate as the error requires. Returns whether
    /// it succeeded.
    fn renew_hierarchy(&mut self, problem: &LinearProblem) -> bool {
        if self.factor.multigrid().is_none() {
            return false;
        }
        let sums = &problem.equations.sums;
        self.fit(problem.system(), sums);
        self.factor.move_to(&problem.state.x);
        // A set-up temporarily needs much memory; the stored tangent is no longer used
        self.lagged = LaggedFactor::default();
        let renewed = self.factor.factorise(&sums.k).is_ok() && !self.factor.fell_back();
        if renewed {
            let (x, rates) = (&problem.state.x, problem.step.rates());
            self.lagged.store(&mut self.factor, problem.system(), sums.k.clone(), x, rates);
        }
        renewed
    }

    /// Adapts the factor to the pattern of the tangent: the elimination order is that of the system as long as there is no contact between surfaces.
    pub(in crate::solve) fn fit(&mut self, system: &System, sums: &Assembled) {
        let in_order = Arc::ptr_eq(&sums.pattern, &system.pattern);
        self.factor.take_pattern(&sums.pattern, in_order);
    }

    /// Computes the Schur complement of all constraints with the current factorisation.
    pub(in crate::solve) fn schur(&mut self, system: &System, sums: &Assembled) -> Result<Schur, Failure> {
        let rows: Vec<usize> = (0..system.constraints.len()).collect();
        Schur::new(&mut self.factor, sums, system, &rows, &sums.gradient).map_err(Failure::Linear)
    }

    /// Whether a tangent has been shifted since there were `shifted` shifts, possibly because the iterative method has no factor to fall back on:
    /// only then are tangents shifted at stable states.
    pub(in crate::solve) fn is_shifted_since(&self, shifted: usize) -> bool {
        self.shifted > shifted && self.factor.multigrid().is_some()
    }

    /// Factorises K and counts the negative eigenvalues of the constrained tangent; `None` if that fails.
    pub(in crate::solve) fn count(&mut self, system: &System, sums: &Assembled) -> Option<usize> {
        self.factor.factorise_counting(&sums.k).ok()?;
        let schur = self.schur(system, sums).ok()?;
        self.negative(system, sums, &schur)
    }

    /// Number of negative eigenvalues of the factorised constrained tangent; `None` if they are not counted.
    pub(in crate::solve) fn negative(&self, system: &System, sums: &Assembled, schur: &Schur) -> Option<usize> {
        negative_eigenvalues(&self.factor, system, sums, schur)
    }

    /// Factorises K, shifts it as long as the constrained tangent has negative eigenvalues, and forms S = H K⁻¹ Hᵀ. The factor of an unshifted K is
    /// stored if it is `for_reuse`. The search for the shift starts one growth step below the last shift of the solve (Wächter & Biegler, Math.
    /// Program. 106, 2006, algorithm IC).
    pub(in crate::solve) fn factorise(
        &mut self,
        step: &Step,
        next: &State,
        equations: &mut Equations,
        for_reuse: bool,
        solution: &mut Solution,
    ) -> Result<Schur, Failure> {
        let (system, limit, sums) = (step.system, &equations.limit, &mut equations.sums);
        let mut shift = 0.0;
        self.fit(system, sums);
        self.factor.move_to(&next.x);
        let own = sums.pattern.diagonal(&sums.k);
        let alone: Vec<f64> = (0..own.len()).map(|j| sums.k[sums.pattern.on_diagonal(j)]).collect();
        let largest = own.iter().fold(0.0, |m: f64, d| m.max(d.abs()));
        loop {
            if limit.reached().is_some() {
                return Err(Failure::LimitReached);
            }
            let factorised = self.factor.factorise(&sums.k).map_err(Failure::Linear);
            match factorised.and_then(|()| self.schur(system, sums)) {
                Ok(schur) => {
                    let unstable = self.negative(system, sums, &schur);
                    if shift == 0.0 {
                        solution.unstable_modes = unstable;
                    }
                    if self.keeps_indefinite || unstable.is_none_or(|n| n == 0) || shift > LARGEST_SHIFT {
                        if for_reuse && shift == 0.0 && !self.factor.fell_back() {
                            self.lagged.store(&mut self.factor, system, sums.k.clone(), &next.x, step.rates());
                        }
                        return Ok(schur);
                    }
                }
                Err(failure) if failure.is_of_memory() => return Err(failure),
                Err(_) if !sums.remainder.is_empty() => {
                    // The remainder is too large compared with K
                    sums.remainder.entries.clear();
                    continue;
                }
                Err(failure) if shift > LARGEST_SHIFT => return Err(failure),
                Err(_) => {}
            }
            // Shift by a growing fraction of the diagonal: a compromise between Newton's step and steepest descent
            let larger = match shift {
                0.0 => FIRST_SHIFT.max(solution.shift / SHIFT_GROWTH),
                _ => SHIFT_GROWTH * shift,
            };
            for (j, own) in own.iter().enumerate() {
                let k = sums.pattern.on_diagonal(j);
                let away = if system.dofs.is_scalar(j) { -larger } else { larger };
                sums.k[k] = alone[j] + away * own.abs().max(SOFTEST * largest);
            }
            shift = larger;
            self.shifted += 1;
            (solution.regularised, solution.shift) = (true, shift);
        }
    }

    /// Ends a step: decides whether the next one reuses the lagged factor.
    pub(in crate::solve) fn end_step(&mut self) {
        self.lagged.decide_reuse(&self.factor);
    }

    /// The record of the lagged factor for a checkpoint; empty if the factor was overwritten.
    pub(in crate::solve) fn lagged_factor_record(&self) -> LaggedFactorRecord {
        self.lagged.record(&self.factor)
    }

    /// Recomputes the lagged factor of a checkpoint.
    pub(in crate::solve) fn resume(&mut self, record: LaggedFactorRecord, system: &System) {
        self.lagged.resume(&mut self.factor, record, system);
    }
}
