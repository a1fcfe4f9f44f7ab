//! Laws with one shape constant per term: P = Σ c_k φ(λ; θ_k), c_k ≥ 0.
//!
//! The factors are eliminated (variable projection: Golub & Pereyra, SIAM J. Numer. Anal. 10, 1973; gradient and Gauss–Newton matrix after Kaufman,
//! BIT 15, 1975): f(θ) = min_{c ≥ 0} ½‖Φ(θ)c − p̂‖², and argmin's trust region (Steihaug's conjugate gradients) searches θ alone, from several
//! starts. Gauss–Newton steps in all constants then converge to rounding. From the answer to nearly the same data these steps alone suffice; the
//! trust region is used if they do not settle, or if a term without a factor would reappear.
//!
//! If the columns at −x equal those at x, as for Ogden's law with λ₂ = 1 and λ₃ = 1/λ (planar tests and simple shear), every minimum has mirror
//! images, of which the one with x ≥ 0 is taken.
//!
//! The starts are the best of all choices of N different points of a grid of θ: five that differ in more than one point (where N is three or more),
//! then the next best. Columns of the grid are reduced by one QR, so that a choice costs N × N.

use super::rows::{WeightedRows, padded, side_by_side};
use super::solver_check::SolverCheck;
use crate::calibrate::FitError;
use crate::material::ShapedTerm;
use crate::math::nonnegative::{few_weights, reduce};
use crate::math::svd::svd;
use argmin::core::{CostFunction, Error, Executor, Gradient, Hessian, State};
use argmin::solver::trustregion::{Steihaug, TrustRegion};
use nalgebra::{DMatrix, DVector};

/// Largest number of starts, and how many of them are far apart
const STARTS: usize = 12;
const APART: usize = 5;
/// Iterations of the trust region between two checks of the gradient, and the largest number of checks
const LEG: u64 = 8;
const LEGS: usize = 60;
/// Gradient relative to the misfit below which Gauss–Newton steps take over \[–\]
const GRADIENT: f64 = 1e-6;
/// Relative difference of the misfits ‖r‖ below which two starts arrived at the same minimum \[–\]
const SAME: f64 = 1e-6;
/// Relative difference of the shapes below which two minima are one \[–\]
const NEIGHBOURS: f64 = 1e-3;
/// Share of the misfit that counts as zero: r along the columns where no step lowers it, and the gain from other factors \[–\]
const FLAT: f64 = 1e-7;
/// Relative decrease of the misfit in a step below which a fit ends; and the same for one fit among many, with n data points, where it leaves √(2nε)
/// of a standard error
const ROUNDING: f64 = 1e-13;
const NEAR: f64 = 1e-10;
/// Relative difference of the columns at x and −x that is rounding \[–\]
const MIRRORED: f64 = 1e-9;
/// Largest norm of a column, so that products of columns do not overflow \[–\]: beyond it an exponential law counts as not defined
const LARGEST: f64 = 1e100;
/// Value of the objective where the law is not defined \[–\]; a step there is rejected
const WALL: f64 = 1e12;

/// The lowest minimum, and other results of the search.
pub struct Separable {
    pub least: Minimum,
    /// Minima with different shapes of the terms that count, in the order of their misfit
    pub others: Vec<Minimum>,
    pub check: SolverCheck,
    /// Whether shapes with the opposite sign give the same stresses at every data point
    pub mirrored: bool,
}

/// Factors and shape constants of the terms, the term with the largest factor first.
pub struct Minimum {
    /// c_k \[Pa\]
    pub factors: Vec<f64>,
    /// θ_k \[–\]
    pub shapes: Vec<f64>,
    /// Shape variables at which the search ended, from which it can continue
    pub at: Vec<f64>,
}

/// The objective with its factors eliminated.
struct Projected<'a> {
    family: &'a ShapedTerm,
    rows: &'a WeightedRows,
    reach: f64,
}

/// Best factors at some shapes.
struct Projection {
    c: Vec<f64>,
    columns: Vec<DVector<f64>>,
    residual: DVector<f64>,
}

impl Projected<'_> {
    fn columns(&self, x: &[f64]) -> Option<Vec<DVector<f64>>> {
        let wall = self.family.wall();
        let one = |x: &f64| {
            let theta = (self.family.shape)(*x, self.reach).0;
            let column = self.rows.column(|s| (self.family.tau)(theta, s));
            (x.abs() <= wall && column.norm() <= LARGEST).then_some(column)
        };
        x.iter().map(one).collect()
    }

    /// c_k ∂φ/∂x of each term
    fn derivatives(&self, x: &[f64], c: &[f64]) -> Vec<DVector<f64>> {
        let one = |(x, c): (&f64, &f64)| {
            let (theta, by) = (self.family.shape)(*x, self.reach);
            self.rows.column(|s| (self.family.tau_by_shape)(theta, s)) * (*c * by)
        };
        x.iter().zip(c).map(one).collect()
    }

    fn residual(&self, columns: &[DVector<f64>], c: &[f64]) -> DVector<f64> {
        columns.iter().zip(c).fold(self.rows.target.clone(), |r, (a, c)| r - a * *c)
    }

    /// Whether shapes at −x give the same stresses as at x, checked at the end of the grid, where they differ most.
    fn is_mirrored(&self) -> bool {
        let x = self.family.grid.last().copied().unwrap_or_default();
        let pair = self.columns(&[x]).zip(self.columns(&[-x]));
        pair.is_some_and(|(a, b)| (&a[0] - &b[0]).norm() <= MIRRORED * a[0].norm())
    }

    /// The best factors at some shapes; `None` if the law is not defined.
    fn at(&self, x: &[f64]) -> Option<Projection> {
        let columns = self.columns(x)?;
        let (r, d) = reduce(&side_by_side(&columns), &self.rows.target);
        let c = few_weights(&r, &d, &(0..x.len()).collect::<Vec<_>>()).0;
        let residual = self.residual(&columns, &c);
        Some(Projection { c, columns, residual })
    }

    /// Kaufman's Jacobian: c_k ∂φ/∂x without its projection on the span of the terms that count, and the residual.
    fn jacobian(&self, x: &[f64]) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let p = self.at(x)?;
        let mut derivatives = self.derivatives(x, &p.c);
        let support: Vec<_> = p.columns.iter().zip(&p.c).filter(|(_, c)| **c > 0.0).map(|(a, _)| a.clone()).collect();
        if !support.is_empty() {
            let q = padded(&side_by_side(&support), support.len()).qr().q();
            for s in &mut derivatives {
                let long = s.clone().resize_vertically(q.nrows(), 0.0);
                *s = (&long - &q * (q.transpose() * &long)).resize_vertically(self.rows.len(), 0.0);
            }
        }
        Some((side_by_side(&derivatives), p.residual))
    }
}

impl CostFunction for Projected<'_> {
    type Param = Vec<f64>;
    type Output = f64;
    fn cost(&self, x: &Vec<f64>) -> Result<f64, Error> {
        Ok(self.at(x).map_or(WALL, |p| 0.5 * p.residual.norm_squared()))
    }
}

impl Gradient for Projected<'_> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;
    fn gradient(&self, x: &Vec<f64>) -> Result<Vec<f64>, Error> {
        let (j, r) = self.jacobian(x).ok_or_else(|| Error::msg("a step was accepted where the law is not defined"))?;
        Ok((-(j.transpose() * r)).iter().copied().collect())
    }
}

impl Hessian for Projected<'_> {
    type Param = Vec<f64>;
    type Hessian = Vec<Vec<f64>>;
    fn hessian(&self, x: &Vec<f64>) -> Result<Vec<Vec<f64>>, Error> {
        let (j, _) = self.jacobian(x).ok_or_else(|| Error::msg("a step was accepted where the law is not defined"))?;
        let h = j.transpose() * &j;
        Ok(h.row_iter().map(|r| r.iter().copied().collect()).collect())
    }
}

/// Finds the minima. `warm`: the only start, if a fit to nearly the same data is known. `goes_on` is called before each start and may stop the
/// search.
pub fn solve(
    (family, terms): (&ShapedTerm, usize),
    rows: &WeightedRows,
    reach: f64,
    warm: Option<&[f64]>,
    goes_on: impl Fn() -> Result<(), FitError>,
) -> Result<Separable, FitError> {
    let problem = Projected { family, rows, reach };
    let mirrored = problem.is_mirrored();
    let minimum = |end: &End, order| minimum(&problem, end, order, mirrored);
    if let Some(end) = warm.and_then(|x| finish(&problem, x.to_vec(), NEAR)).filter(|end| end.settled) {
        let least = minimum(&end, (0..terms).collect());
        return Ok(Separable { least, others: vec![], check: SolverCheck::Starts { starts: 1, agree: 1 }, mirrored });
    }
    let starts = warm.map_or_else(|| starts(&problem, terms), |x| vec![x.to_vec()]);
    let mut ends = Vec::new();
    for x in &starts {
        goes_on()?;
        let x = search(family, rows, reach, x)?;
        ends.extend(finish(&problem, x, ROUNDING));
    }
    ends.sort_by(|a, b| a.misfit.total_cmp(&b.misfit));
    let Some(best) = ends.first() else {
        return Err(FitError::Solver { solver: "argmin", status: "no start lies where the law is defined".into() });
    };
    // Below rounding all misfits are equal
    let agree = ends.iter().filter(|e| e.misfit <= best.misfit * (1.0 + SAME) + 1e-12).count();
    let by_factor = |end: &End| {
        let mut order: Vec<usize> = (0..terms).collect();
        order.sort_by(|a, b| end.c[*b].total_cmp(&end.c[*a]));
        minimum(end, order)
    };
    // A warm start keeps the order of terms of its answer, so that the constants can be compared
    let least = if warm.is_none() { by_factor(best) } else { minimum(best, (0..terms).collect()) };
    let mut others: Vec<Minimum> = vec![];
    for other in ends[1..].iter().filter(|e| e.settled).map(by_factor) {
        if !least.is_near(&other) && !others.iter().any(|o| o.is_near(&other)) {
            others.push(other);
        }
    }
    Ok(Separable { least, others, check: SolverCheck::Starts { starts: starts.len(), agree }, mirrored })
}

fn minimum(problem: &Projected<'_>, End { x, c, .. }: &End, order: Vec<usize>, mirrored: bool) -> Minimum {
    let at: Vec<f64> = order.iter().map(|k| if mirrored { x[*k].abs() } else { x[*k] }).collect();
    Minimum {
        factors: order.iter().map(|k| c[*k] * problem.rows.unit).collect(),
        shapes: at.iter().map(|x| (problem.family.shape)(*x, problem.reach).0).collect(),
        at,
    }
}

impl Minimum {
    /// Whether the terms that count have the same shapes.
    fn is_near(&self, other: &Minimum) -> bool {
        let shapes = |m: &Minimum| {
            let own = m.shapes.iter().zip(&m.factors).filter(|(_, c)| **c > 0.0).map(|(theta, _)| *theta);
            let mut own: Vec<f64> = own.collect();
            own.sort_by(f64::total_cmp);
            own
        };
        let (a, b) = (shapes(self), shapes(other));
        a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= NEIGHBOURS * (1.0 + a.abs()))
    }
}

/// The best choices of grid points, the first ones far apart.
fn starts(problem: &Projected<'_>, terms: usize) -> Vec<Vec<f64>> {
    let defined = problem.family.grid.iter().filter_map(|x| Some((*x, problem.columns(&[*x])?.remove(0))));
    let (grid, columns): (Vec<f64>, Vec<_>) = defined.unzip();
    if grid.len() < terms {
        return vec![];
    }
    let (r, d) = reduce(&side_by_side(&columns), &problem.rows.target);
    let mut choices: Vec<Vec<usize>> = vec![vec![]];
    for _ in 0..terms {
        let longer = |c: Vec<usize>| {
            let from = c.last().map_or(0, |k| k + 1);
            (from..grid.len()).map(move |k| [c.clone(), vec![k]].concat()).collect::<Vec<_>>()
        };
        choices = choices.into_iter().flat_map(longer).collect();
    }
    // Terms without a factor cannot move: choices with fewer of them come first, then those that explain more of the stresses
    let rate = |c: &Vec<usize>| {
        let (factors, explained) = few_weights(&r, &d, c);
        (factors.iter().filter(|c| **c == 0.0).count(), -explained)
    };
    let mut rated: Vec<_> = choices.iter().map(|c| (rate(c), c)).collect();
    rated.sort_by(|((n, a), _), ((m, b), _)| n.cmp(m).then(a.total_cmp(b)));
    let shared = terms.saturating_sub(2).max(usize::from(terms == 2));
    let mut chosen: Vec<&Vec<usize>> = Vec::new();
    for (_, c) in &rated {
        let apart = |o: &&Vec<usize>| o.iter().filter(|k| c.contains(k)).count() <= shared;
        if chosen.len() < APART && chosen.iter().all(apart) {
            chosen.push(c);
        }
    }
    let others: Vec<_> = rated.iter().map(|(_, c)| *c).filter(|c| !chosen.contains(c)).collect();
    chosen.extend(others.into_iter().take(STARTS - chosen.len()));
    chosen.into_iter().map(|c| c.iter().map(|k| grid[*k]).collect()).collect()
}

/// Runs argmin's trust region, which has no convergence test of its own, in legs until the gradient is small or the objective no longer falls.
fn search(family: &ShapedTerm, rows: &WeightedRows, reach: f64, start: &[f64]) -> Result<Vec<f64>, FitError> {
    let fail = |e: Error| FitError::Solver { solver: "argmin", status: e.to_string() };
    let own = || Projected { family, rows, reach };
    let mut x = start.to_vec();
    let mut before = own().cost(&x).map_err(fail)?;
    if before == WALL {
        return Ok(x);
    }
    for _ in 0..LEGS {
        let gradient = own().gradient(&x).map_err(fail)?;
        let size = gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
        if size <= GRADIENT * before {
            break;
        }
        let steps = Steihaug::new().with_epsilon(1e-14).map_err(fail)?.with_max_iters(2 * x.len() as u64);
        let solver = TrustRegion::new(steps).with_radius(0.5).and_then(|s| s.with_max_radius(4.0)).map_err(fail)?;
        let run = Executor::new(own(), solver)
            .configure(|state| state.param(x.clone()).max_iters(LEG))
            .run()
            .map_err(fail)?;
        let cost = run.state().get_best_cost();
        if cost < before {
            x.clone_from(run.state().get_best_param().ok_or_else(|| fail(Error::msg("no answer")))?);
        }
        if cost >= before * (1.0 - 1e-9) {
            break;
        }
        before = cost;
    }
    Ok(x)
}

/// The result of the Gauss–Newton steps.
struct End {
    /// ‖r‖ \[–\]
    misfit: f64,
    x: Vec<f64>,
    c: Vec<f64>,
    /// Whether the misfit falls no further, neither by a step nor by other factors
    settled: bool,
}

/// Gauss–Newton in all constants of the terms that count, each step halved until the misfit falls; it ends when the relative decrease of the misfit
/// is below `flat`.
fn finish(problem: &Projected<'_>, mut x: Vec<f64>, flat: f64) -> Option<End> {
    let Projection { mut c, mut columns, residual: mut r } = problem.at(&x)?;
    let mut settled = false;
    for _ in 0..30 {
        let own: Vec<usize> = (0..x.len()).filter(|k| c[*k] > 0.0).collect();
        let derivatives = problem.derivatives(&x, &c);
        let j: Vec<_> =
            own.iter().map(|k| columns[*k].clone()).chain(own.iter().map(|k| derivatives[*k].clone())).collect();
        if j.is_empty() {
            break;
        }
        let size: Vec<f64> = j.iter().map(|c| if c.norm() > 0.0 { c.norm() } else { 1.0 }).collect();
        let scaled: Vec<_> = j.iter().zip(&size).map(|(c, n)| c / *n).collect();
        // The step follows from the triangular factor of the columns, which has the same singular values
        let (triangle, d) = reduce(&side_by_side(&scaled), &r);
        let svd = svd(triangle, true, true);
        let Ok(step) = svd.solve(&d, 1e-10 * svd.singular_values.max()) else { break };
        let moved = |t: f64| {
            let (mut x, mut c) = (x.clone(), c.clone());
            for (n, k) in own.iter().enumerate() {
                c[*k] += t * step[n] / size[n];
                x[*k] += t * step[own.len() + n] / size[own.len() + n];
            }
            let columns = problem.columns(&x)?;
            let r = problem.residual(&columns, &c);
            (c.iter().all(|c| *c >= 0.0)).then_some((x, c, columns, r))
        };
        let better = (0..12).filter_map(|n| moved(0.5_f64.powi(n))).find(|(_, _, _, new)| new.norm() < r.norm());
        let Some((next, factors, there, residual)) = better else {
            // The gain of a full step would be rounding
            settled = d.norm() <= FLAT * r.norm();
            break;
        };
        let still = residual.norm() > r.norm() * (1.0 - flat);
        (x, c, columns, r) = (next, factors, there, residual);
        if still {
            settled = true;
            break;
        }
    }
    let misfit = r.norm();
    // Compares with the best factors for these shapes: a term that vanished does not reappear
    settled &= problem.at(&x)?.residual.norm() >= misfit * (1.0 - FLAT);
    Some(End { misfit, x, c, settled })
}
