//! Directions of Newton's method from the factor of an earlier tangent.
//!
//! The linear system of an iteration is \[K Hᵀ; H −C\] \[du; dλ\] = \[−r − lift; g − carried\] with the rows that hold. Conjugate
//! gradients solve it with \[K₀ Hᵀ; H −C\] as preconditioner, K₀ being the tangent that was factorised last and K, H the present
//! ones (Gould, Hribar & Nocedal, SIAM J. Sci. Comput. 23, 2001; Dollar, Gould, Schilders & Wathen, SIAM J. Matrix Anal. 28,
//! 2006 for C ≠ 0). Each iteration is one product with K and one back-substitution. K₀ is turned with the body first
//! ([`turns`](super::turns)).
//!
//! Accuracy: ‖residual‖ ≤ min(0.1, √error) of the force at hand, which makes Newton's method converge with the order 3/2 (Dembo,
//! Eisenstat & Steihaug, SIAM J. Numer. Anal. 19, 1982), and never below a third of the tolerance of the step.
//!
//! Renewal: a factor is dropped when its last step took more solves than its steps took on average, the factorisation
//! included; where conjugate gradients are slow; where K or K₀ is indefinite on the null space of H; and in statics where one of
//! the softest directions lost half of its stiffness. All by counts, never by the clock, so that the bits of a run stay.

use super::multipliers::Schur;
use super::newton::NewtonDirection;
use super::nodal_rotations::NodalRotations;
use super::{Newton, Step};
use crate::math::linear::{dot, norm};
use crate::math::pcg::{Outcome, pcg};
use crate::math::random::SplitMix;
use crate::system::{Cone, Rates, State, System};
use std::sync::Arc;

/// Products before conjugate gradients give up: a multiple of the price of a factorisation, and the least number.
const PATIENCE: (f64, usize) = (1.5, 8);
/// The loosest relative accuracy of a direction.
const LOOSEST: f64 = 0.1;
/// Accuracy of a direction that is enough for the step, as a share of its tolerance.
const ENOUGH: f64 = 0.3;
/// Softest directions that are watched.
const WATCHED: usize = 3;
/// Share of its stiffness at which a watched direction asks for a new factor.
const SOFTENED: f64 = 0.5;

/// What is known of the tangent K₀ whose factor is kept.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LaggedFactorRecord {
    /// Values of K₀, from which the factor can be made again; empty if none is kept
    pub k: Arc<Vec<f64>>,
    /// \[unknowns\] where the body was
    pub x: Arc<Vec<f64>>,
    /// Solves with it so far, and in the step at hand
    pub solves: [usize; 2],
    /// Steps that it served
    pub steps: usize,
    /// ∂v/∂x and ∂a/∂x in K₀
    pub rates: Rates,
    /// The next step takes a new one
    pub worn: bool,
}

/// The factor that is kept, and the directions that are watched.
#[derive(Default)]
pub(super) struct LaggedFactor {
    pub kept: LaggedFactorRecord,
    /// Factorisations when it was made: later ones have overwritten it
    count: usize,
    /// \[watched × equations\] soft directions v with v·K₀ w = δ_vw
    soft: Vec<Vec<f64>>,
    /// From where the body was to where the step begins
    turns: NodalRotations,
}

impl Newton {
    /// Can directions come from an old factor here? K is to be symmetric, and definite where the rows hold.
    pub(super) fn keeps_factors(&self, system: &System) -> bool {
        self.settings.reuse_factor
            && self.factor.price() >= self.settings.reuse_threshold
            && system.scalar_equations() == 0
            && !system.has_skew_tangent()
            && !system.has_transient_coupling()
            && !self.sums.projected
            && system.constraints.iter().all(|c| !matches!(c.cone(), Cone::Linked | Cone::Watched))
    }

    /// What a saved run has to know of it; nothing if the factor was overwritten.
    pub(super) fn lagged_factor_record(&self) -> LaggedFactorRecord {
        if self.stale.count == self.factor.count { self.stale.kept.clone() } else { LaggedFactorRecord::default() }
    }

    /// Takes over what a saved run had kept.
    pub(super) fn resume_factor(&mut self, kept: LaggedFactorRecord, system: &System) {
        self.factor.move_to(&kept.x);
        if !kept.k.is_empty() && self.factor.factorise(&kept.k).is_ok() {
            self.keep_factor(system, kept.k.to_vec(), &kept.x, kept.rates);
            self.stale.kept = kept;
        }
    }

    /// The factor of `k`, just made and not shifted, may serve later steps.
    pub(super) fn keep_factor(&mut self, system: &System, k: Vec<f64>, x: &[f64], rates: Rates) {
        self.stale.kept =
            LaggedFactorRecord { k: k.into(), rates, x: x.to_vec().into(), ..LaggedFactorRecord::default() };
        self.stale.turns = NodalRotations::default();
        self.stale.count = self.factor.count;
        let watches = rates == Rates::default() && self.factor.counts();
        self.stale.soft = if watches { self.softest(system) } else { Vec::new() };
    }

    /// On the iterative path: a hierarchy of the present tangent, for a direction that is no more accurate than the error asks for.
    pub(super) fn renew_hierarchy(&mut self, step: &Step, next: &State) -> bool {
        if self.factor.multigrid().is_none() {
            return false;
        }
        self.fit_factor(step.system);
        self.factor.move_to(&next.x);
        let stands = self.factor.factorise(&self.sums.k).is_ok() && !self.factor.fell_back();
        if stands {
            self.keep_factor(step.system, self.sums.k.clone(), &next.x, step.rates());
        }
        stands
    }

    /// Is there a factor for a direction of this step?
    pub(super) fn has_factor(&self, rates: Rates, first: bool) -> bool {
        let LaggedFactor { kept, count, .. } = &self.stale;
        let stands = !kept.k.is_empty() && *count == self.factor.count && kept.rates.is_near(&rates);
        stands && !(first && kept.worn)
    }

    /// A step ended: is the factor worth keeping?
    pub(super) fn judge_factor(&mut self) {
        let price = self.factor.price();
        let LaggedFactorRecord { solves: [all, here], steps, worn, .. } = &mut self.stale.kept;
        *all += *here;
        *steps += 1;
        *worn = *here as f64 > (price + *all as f64) / *steps as f64;
        *here = 0;
    }

    /// K₀⁻¹ on random directions: the softest ones of the body prevail. K₀-orthonormal.
    fn softest(&mut self, system: &System) -> Vec<Vec<f64>> {
        let n = system.dofs.free.len();
        let mut random = SplitMix(1);
        let mut columns: Vec<f64> = (0..WATCHED * n).map(|_| random.unit() - 0.5).collect();
        self.factor.solve_roughly(&mut columns);
        let mut soft: Vec<Vec<f64>> = Vec::new();
        let mut product = vec![0.0; n];
        for column in columns.chunks_exact(n) {
            let mut v = column.to_vec();
            system.pattern.multiply(&self.stale.kept.k, &v, &mut product);
            for w in &soft {
                let share = dot(w, &product);
                v.iter_mut().zip(w).for_each(|(v, w)| *v -= share * w);
            }
            system.pattern.multiply(&self.stale.kept.k, &v, &mut product);
            let size = dot(&v, &product);
            if size > 0.0 {
                soft.push(v.iter().map(|v| v / size.sqrt()).collect());
            }
        }
        soft
    }

    /// Has a watched direction, made to keep the rows, lost much of its stiffness? On the null space of H it is 1 − |Hv|²_S⁻¹
    /// under K₀.
    fn has_softened(&self, system: &System, schur: &Schur, held: &Held) -> bool {
        let mut product = vec![0.0; system.dofs.free.len()];
        let w = self.stale.soft.len();
        if w == 0 {
            return false;
        }
        let (mut now, mut then) = (nalgebra::DMatrix::zeros(w, w), nalgebra::DMatrix::identity(w, w));
        let mut moved = Vec::new();
        let mut soft = self.stale.soft.clone();
        soft.iter_mut().for_each(|v| self.stale.turns.turn(v));
        let crossings: Vec<Vec<f64>> = soft.iter().map(|v| held.cross(&self.sums.gradient, v)).collect();
        for (mut v, crossing) in soft.into_iter().zip(&crossings) {
            let multipliers = held.multipliers(crossing);
            held.subtract(schur, &multipliers, &mut v);
            moved.push((v, multipliers));
        }
        for j in 0..w {
            system.pattern.multiply(&self.sums.k, &moved[j].0, &mut product);
            for i in 0..w {
                now[(i, j)] = dot(&moved[i].0, &product);
                then[(i, j)] -= dot(&crossings[i], &moved[j].1);
            }
        }
        // now − ½ then is definite as long as no combination fell to one half.
        (now - then * SOFTENED).cholesky().is_none()
    }

    /// R K₀⁻¹ Rᵀ on columns.
    fn solve_turned(&mut self, columns: &mut [f64]) {
        let n = self.sums.increment_force.len();
        columns.chunks_exact_mut(n).for_each(|column| self.stale.turns.turn_back(column));
        self.factor.solve_roughly(columns);
        columns.chunks_exact_mut(n).for_each(|column| self.stale.turns.turn(column));
    }

    /// The direction of an iteration by the factor that is kept; None where it does not serve. `error` is that of the state, where
    /// the step begins if it is the `first`.
    pub(super) fn direction_by_old_factor(
        &mut self,
        system: &System,
        state: &State,
        increment: Option<&[f64]>,
        (error, first): (f64, bool),
    ) -> Option<NewtonDirection> {
        if first {
            self.stale.turns = NodalRotations::new(system, &self.points, &self.stale.kept.x, &state.x);
        }
        let (n, m) = (system.dofs.free.len(), state.lambda.len());
        let rhs = self.right_side(system, increment.is_some());
        let mut columns = rhs.clone();
        self.sums.gradient.iter().for_each(|h| columns.extend(h));
        self.solve_turned(&mut columns);
        self.stale.kept.solves[1] += 1 + m;
        let z = columns.split_off(n);
        let mut x = columns;
        let rows: Vec<usize> = (0..m).collect();
        let schur = Schur::of(z, system, &rows, &self.sums.gradient);
        if self.negative(system, &schur).is_some_and(|n| n > 0) {
            return None;
        }
        let shift: Vec<f64> = (0..m).map(|c| -self.sums.increment_gap[c] - dot(&self.sums.gradient[c], &x)).collect();
        let (mut lambda, holds) = match m {
            0 => Default::default(),
            _ => schur.multipliers(system, &self.rows(state), &shift)?,
        };
        let held = Held::new(holds, &schur, m)?;
        if first && self.has_softened(system, &schur, &held) {
            return None;
        }
        let change: Vec<f64> = lambda.iter().zip(&state.lambda).map(|(new, old)| new - old).collect();
        schur.z.chunks_exact(n).zip(&change).for_each(|(z, d)| x.iter_mut().zip(z).for_each(|(x, z)| *x -= z * d));
        let mut left = vec![0.0; n];
        system.pattern.multiply(&self.sums.k, &x, &mut left);
        left.iter_mut().zip(&rhs).for_each(|(left, rhs)| *left = rhs - *left);
        let gradient = &self.sums.gradient;
        gradient.iter().zip(&change).for_each(|(h, d)| left.iter_mut().zip(h).for_each(|(l, h)| *l -= h * d));
        let enough = ENOUGH * self.settings.tolerance * self.sums.scale;
        let bound = enough.max(LOOSEST.min(error.sqrt()) * norm(&rhs));
        left.resize(n + held.rows.len(), 0.0);
        let most = self.factor.patience(PATIENCE.0).max(PATIENCE.1);
        let (values, factor, turns) = (&self.sums.k, &mut self.factor, &self.stale.turns);
        let multiply = |v: &[f64]| {
            let mut product = vec![0.0; v.len()];
            system.pattern.multiply(values, &v[..n], &mut product[..n]);
            for (&c, d) in held.rows.iter().zip(&v[n..]) {
                product.iter_mut().zip(&gradient[c]).for_each(|(p, h)| *p += d * h);
            }
            product
        };
        let precondition = |r: &[f64]| {
            let mut z = r[..n].to_vec();
            turns.turn_back(&mut z);
            factor.solve_roughly(&mut z);
            turns.turn(&mut z);
            let multipliers = held.multipliers(&held.cross(gradient, &z));
            held.subtract(&schur, &multipliers, &mut z);
            z.extend(multipliers);
            z
        };
        let (outcome, iterations) = pcg(multiply, precondition, &left, bound, most);
        self.stale.kept.solves[1] += iterations;
        let Outcome::Solved(rest) = outcome else { return None };
        x.iter_mut().zip(&rest).for_each(|(x, d)| *x += d);
        for (&c, d) in held.rows.iter().zip(&rest[n..]) {
            lambda[c] = system.constraints[c].cone().admit(lambda[c] + d);
        }
        Some(NewtonDirection::new(system, increment, &x, lambda))
    }
}

/// The rows that hold in a direction.
struct Held {
    rows: Vec<usize>,
    /// S⁻¹ on them
    inverse: nalgebra::DMatrix<f64>,
}

impl Held {
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

    /// S⁻¹ of it
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
