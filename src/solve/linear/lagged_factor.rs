//! Directions of Newton's method with the factor of an earlier tangent.
//!
//! The linear system of an iteration is \[K Hᵀ; H −C\] \[du; dλ\] = \[−r − lift; g − carried\] with the active constraints. It is solved by conjugate
//! gradients with \[K₀ Hᵀ; H −C\] as preconditioner, where K₀ is the tangent that was factorised last and K, H are the current ones (Gould, Hribar &
//! Nocedal, SIAM J. Sci. Comput. 23, 2001; Dollar, Gould, Schilders & Wathen, SIAM J. Matrix Anal. 28, 2006 for C ≠ 0); with pressures, and where
//! contact has a remainder, generalised minimal residuals are used instead. Each iteration takes one product with K and one back-substitution. K₀ is
//! first rotated with the body ([`nodal_rotations`](super::nodal_rotations)).
//!
//! Accuracy: ‖residual‖ ≤ min(0.1, √error) relative to the current force, which makes Newton's method converge with order 3/2 (Dembo, Eisenstat &
//! Steihaug, SIAM J. Numer. Anal. 19, 1982), but never below a third of the tolerance of the step.
//!
//! Reuse: [`LinearSystem::may_reuse_factor`](crate::solve::LinearSystem) decides whether the equations of a step allow it at all. After each step,
//! [`LaggedFactor::decide_reuse`] decides whether the next one reuses the factor: it does not if the step took more solves than the steps with this
//! factor took on average, counting the factorisation. Within a step, [`LaggedFactor::direction`] declines if the Krylov method is slow; if K or K₀
//! is indefinite on the null space of H; and, in statics, if one of the softest directions has lost half of its stiffness. All decisions are based on
//! counts, never on the clock, so that a run is reproducible bit for bit.

use super::multipliers::Schur;
use super::nodal_rotations::NodalRotations;
use super::problem::{LinearProblem, NewtonDirection};
use super::stability::negative_eigenvalues;
use crate::math::gmres::gmres;
use crate::math::linear::Factor;
use crate::math::pcg::{Outcome, pcg};
use crate::math::random::SplitMix;
use crate::math::tensor::Vec3;
use crate::math::vector::{dot, norm};
use crate::system::{Assembled, Rates, System};
use std::sync::Arc;

/// Number of products after which the Krylov method gives up: a multiple of the cost of a factorisation, and a smallest number.
const PATIENCE: (f64, usize) = (1.5, 8);
/// Loosest relative accuracy of a direction.
const LOOSEST: f64 = 0.1;
/// Sufficient accuracy of a direction for the step, relative to its tolerance.
const ENOUGH: f64 = 0.3;
/// Number of softest directions that are monitored.
const WATCHED: usize = 3;
/// Share of its stiffness below which a monitored direction requires a new factor.
const SOFTENED: f64 = 0.5;

/// The tangent K₀ that was factorised for reuse, and its use so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LaggedFactorRecord {
    /// Values of K₀, from which the factor can be recomputed; empty if none is stored
    pub k: Arc<Vec<f64>>,
    /// \[unknowns\] displacements at which K₀ is the tangent
    pub x: Arc<Vec<f64>>,
    /// Number of solves with the factor in earlier steps, and in the current step
    pub solves: [usize; 2],
    /// Number of steps that used the factor
    pub steps: usize,
    /// ∂v/∂x and ∂a/∂x in K₀
    pub rates: Rates,
    /// Whether the next step does not reuse the factor and begins with a new one
    pub renew: bool,
}

/// The lagged factor, with the directions that are monitored.
#[derive(Default)]
pub(super) struct LaggedFactor {
    record: LaggedFactorRecord,
    /// Count of factorisations when it was computed: later ones have overwritten it
    count: usize,
    /// \[monitored × equations\] soft directions v with v·K₀ w = δ_vw
    soft: Vec<Vec<f64>>,
    /// Rotations from the state of K₀ to the start of the step
    rotations: NodalRotations,
}

impl LaggedFactor {
    /// The record for a checkpoint; empty if the factor was overwritten.
    pub fn record(&self, factor: &Factor) -> LaggedFactorRecord {
        if self.count == factor.count { self.record.clone() } else { LaggedFactorRecord::default() }
    }

    /// Recomputes the factor of a record.
    pub fn resume(&mut self, factor: &mut Factor, record: LaggedFactorRecord, system: &System) {
        factor.move_to(&record.x);
        if !record.k.is_empty() && factor.factorise(&record.k).is_ok() {
            self.store(factor, system, record.k.to_vec(), &record.x, record.rates);
            self.record = record;
        }
    }

    /// Stores what is needed to reuse the factor of `k`, which was just computed and not shifted.
    pub fn store(&mut self, factor: &mut Factor, system: &System, k: Vec<f64>, x: &[f64], rates: Rates) {
        self.record = LaggedFactorRecord { k: k.into(), rates, x: x.to_vec().into(), ..LaggedFactorRecord::default() };
        self.rotations = NodalRotations::default();
        self.count = factor.count;
        let watches = rates == Rates::default() && factor.has_inertia();
        self.soft = if watches { self.softest(factor, system) } else { Vec::new() };
    }

    /// Whether the factor may be reused for a direction of a step with these rates; for the `first` direction only if the last step did not decide
    /// otherwise.
    pub fn may_be_reused(&self, factor: &Factor, rates: Rates, first: bool) -> bool {
        let Self { record, count, .. } = self;
        let is_valid = !record.k.is_empty() && *count == factor.count && record.rates.is_near(&rates);
        is_valid && !(first && record.renew)
    }

    /// Ends a step: decides whether the next one reuses the factor.
    pub fn decide_reuse(&mut self, factor: &Factor) {
        let cost = factor.relative_cost();
        let LaggedFactorRecord { solves: [all, here], steps, renew, .. } = &mut self.record;
        *all += *here;
        *steps += 1;
        *renew = *here as f64 > (cost + *all as f64) / *steps as f64;
        *here = 0;
    }

    /// Soft directions: K₀⁻¹ applied to random ones, in which the softest ones of the body prevail, made K₀-orthonormal.
    fn softest(&self, factor: &mut Factor, system: &System) -> Vec<Vec<f64>> {
        let n = system.dofs.free.len();
        let mut random = SplitMix(1);
        let mut force = |i: usize| if system.dofs.is_scalar(i % n) { 0.0 } else { random.unit() - 0.5 };
        let mut columns: Vec<f64> = (0..WATCHED * n).map(&mut force).collect();
        factor.solve_roughly(&mut columns);
        let mut soft: Vec<Vec<f64>> = Vec::new();
        let mut product = vec![0.0; n];
        for column in columns.chunks_exact(n) {
            let mut v = column.to_vec();
            system.pattern.multiply(&self.record.k, &v, &mut product);
            for w in &soft {
                let share = dot(w, &product);
                v.iter_mut().zip(w).for_each(|(v, w)| *v -= share * w);
            }
            system.pattern.multiply(&self.record.k, &v, &mut product);
            let size = dot(&v, &product);
            if size > 0.0 {
                soft.push(v.iter().map(|v| v / size.sqrt()).collect());
            }
        }
        soft
    }

    /// Whether a monitored direction, made consistent with the constraints, has lost much of its stiffness. On the null space of H the stiffness
    /// under K₀ is 1 − |Hv|²_S⁻¹.
    fn has_softened(&self, system: &System, sums: &Assembled, schur: &Schur, held: &HeldConstraints) -> bool {
        let mut product = vec![0.0; system.dofs.free.len()];
        let w = self.soft.len();
        if w == 0 {
            return false;
        }
        let (mut now, mut then) = (nalgebra::DMatrix::zeros(w, w), nalgebra::DMatrix::identity(w, w));
        let mut constrained = Vec::new();
        let mut soft = self.soft.clone();
        soft.iter_mut().for_each(|v| self.rotations.rotate(v));
        let crossings: Vec<Vec<f64>> = soft.iter().map(|v| held.cross(&sums.gradient, v)).collect();
        for (mut v, crossing) in soft.into_iter().zip(&crossings) {
            let multipliers = held.multipliers(crossing);
            held.subtract(schur, &multipliers, &mut v);
            constrained.push((v, multipliers));
        }
        for j in 0..w {
            system.pattern.multiply(&sums.k, &constrained[j].0, &mut product);
            for i in 0..w {
                now[(i, j)] = dot(&constrained[i].0, &product);
                then[(i, j)] -= dot(&crossings[i], &constrained[j].1);
            }
        }
        // now − ½ then is definite as long as no combination has fallen to one half
        (now - then * SOFTENED).cholesky().is_none()
    }

    /// Applies R K₀⁻¹ Rᵀ to columns.
    fn solve_rotated(&self, factor: &mut Factor, n: usize, columns: &mut [f64]) {
        columns.chunks_exact_mut(n).for_each(|column| self.rotations.rotate_back(column));
        factor.solve_roughly(columns);
        columns.chunks_exact_mut(n).for_each(|column| self.rotations.rotate(column));
    }

    /// Computes the direction by one application of the factor, before the Krylov method; `None` if the constrained tangent of the factor has
    /// negative eigenvalues.
    pub fn rough(
        &mut self,
        factor: &mut Factor,
        points: &[Vec3],
        problem: &LinearProblem,
        first: bool,
    ) -> Option<RoughDirection> {
        let (system, state, sums) = (problem.system(), problem.state, &problem.equations.sums);
        if first {
            self.rotations = NodalRotations::new(system, points, &self.record.x, &state.x);
        }
        let (n, m) = (system.dofs.free.len(), state.lambda.len());
        let mut x = problem.right_side();
        sums.gradient.iter().for_each(|h| x.extend(h));
        self.solve_rotated(factor, n, &mut x);
        let z = x.split_off(n);
        let rows: Vec<usize> = (0..m).collect();
        let schur = Schur::of(z, system, &rows, &sums.gradient);
        if negative_eigenvalues(factor, system, sums, &schur).is_some_and(|n| n > 0) {
            return None;
        }
        let (lambda, holds) = match m {
            0 => Default::default(),
            _ => schur.multipliers(system, &problem.equations.rows(state), &problem.shift(&x))?,
        };
        let change: Vec<f64> = lambda.iter().zip(&state.lambda).map(|(new, old)| new - old).collect();
        schur.z.chunks_exact(n).zip(&change).for_each(|(z, d)| x.iter_mut().zip(z).for_each(|(x, z)| *x -= z * d));
        Some(RoughDirection { x, lambda, change, schur, holds })
    }

    /// Computes the direction of an iteration; `None` if the factor is not to be reused. `error` is that of the state, which is the start of the step
    /// if this is the `first` iteration. The direction is as accurate as `error` and the `tolerance` of the step require.
    pub fn direction(
        &mut self,
        factor: &mut Factor,
        points: &[Vec3],
        problem: &LinearProblem,
        tolerance: f64,
        error: f64,
        first: bool,
    ) -> Option<NewtonDirection> {
        let (system, state, sums) = (problem.system(), problem.state, &problem.equations.sums);
        let (n, m) = (system.dofs.free.len(), state.lambda.len());
        let rhs = problem.right_side();
        self.record.solves[1] += 1 + m;
        let RoughDirection { mut x, mut lambda, change, schur, holds } = self.rough(factor, points, problem, first)?;
        let held = HeldConstraints::new(holds, &schur, m)?;
        if first && self.has_softened(system, sums, &schur, &held) {
            return None;
        }
        let mut left = vec![0.0; n];
        system.pattern.multiply(&sums.k, &x, &mut left);
        sums.remainder.add_product(&x, &mut left);
        left.iter_mut().zip(&rhs).for_each(|(left, rhs)| *left = rhs - *left);
        let gradient = &sums.gradient;
        gradient.iter().zip(&change).for_each(|(h, d)| left.iter_mut().zip(h).for_each(|(l, h)| *l -= h * d));
        let enough = ENOUGH * tolerance * sums.scale;
        let bound = enough.max(LOOSEST.min(error.sqrt()) * norm(&rhs));
        left.resize(n + held.rows.len(), 0.0);
        let most = factor.patience(PATIENCE.0).max(PATIENCE.1);
        let (values, rotations) = (&sums.k, &self.rotations);
        let multiply = |v: &[f64]| {
            let mut product = vec![0.0; v.len()];
            system.pattern.multiply(values, &v[..n], &mut product[..n]);
            sums.remainder.add_product(&v[..n], &mut product[..n]);
            for (&c, d) in held.rows.iter().zip(&v[n..]) {
                product.iter_mut().zip(&gradient[c]).for_each(|(p, h)| *p += d * h);
            }
            product
        };
        let mut precondition = |r: &[f64]| {
            let mut z = r[..n].to_vec();
            rotations.rotate_back(&mut z);
            factor.solve_roughly(&mut z);
            rotations.rotate(&mut z);
            let multipliers = held.multipliers(&held.cross(gradient, &z));
            held.subtract(&schur, &multipliers, &mut z);
            z.extend(multipliers);
            z
        };
        let is_symmetric = sums.remainder.is_empty();
        let (rest, iterations) = if system.scalar_equations() == 0 && is_symmetric {
            match pcg(multiply, precondition, &left, bound, most) {
                (Outcome::Solved(rest), iterations) => (Some(rest), iterations),
                (_, iterations) => (None, iterations),
            }
        } else {
            let solved = gmres(multiply, |r| Ok(precondition(r)), &left, bound, most).ok();
            solved.map_or((None, most), |(rest, iterations)| (Some(rest), iterations))
        };
        self.record.solves[1] += iterations;
        let rest = rest?;
        x.iter_mut().zip(&rest).for_each(|(x, d)| *x += d);
        for (&c, d) in held.rows.iter().zip(&rest[n..]) {
            lambda[c] = system.constraints[c].kind().admit(lambda[c] + d);
        }
        Some(problem.direction(&x, lambda))
    }
}

/// A direction by one application of a lagged factor.
pub(super) struct RoughDirection {
    /// \[equations\]
    pub x: Vec<f64>,
    /// \[constraints\] multipliers after the step; `change` is their change
    pub lambda: Vec<f64>,
    change: Vec<f64>,
    schur: Schur,
    holds: Vec<bool>,
}

/// The constraints that are active in a direction.
struct HeldConstraints {
    rows: Vec<usize>,
    /// S⁻¹ on them
    inverse: nalgebra::DMatrix<f64>,
}

impl HeldConstraints {
    fn new(holds: Vec<bool>, schur: &Schur, m: usize) -> Option<Self> {
        let rows: Vec<usize> = (0..m).filter(|&c| holds[c]).collect();
        let s = nalgebra::DMatrix::from_fn(rows.len(), rows.len(), |i, j| schur.s[rows[i] * m + rows[j]]);
        let inverse = if rows.is_empty() { s } else { s.try_inverse()? };
        Some(Self { inverse, rows })
    }

    /// H v
    fn cross(&self, gradient: &[Vec<f64>], v: &[f64]) -> Vec<f64> {
        self.rows.iter().map(|&c| dot(&gradient[c], v)).collect()
    }

    /// S⁻¹ w
    fn multipliers(&self, crossing: &[f64]) -> Vec<f64> {
        let of_row = |i: usize| (0..crossing.len()).map(|j| self.inverse[(i, j)] * crossing[j]).sum();
        (0..crossing.len()).map(of_row).collect()
    }

    /// v −= Z w
    fn subtract(&self, schur: &Schur, multipliers: &[f64], v: &mut [f64]) {
        for (&c, w) in self.rows.iter().zip(multipliers) {
            let z = &schur.z[c * v.len()..(c + 1) * v.len()];
            v.iter_mut().zip(z).for_each(|(v, z)| *v -= w * z);
        }
    }
}
