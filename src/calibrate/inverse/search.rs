//! Least squares over forward solves: argmin's trust region (Steihaug's conjugate gradients) on the Gauss–Newton matrix.
//!
//! f(z) = ½‖w(ŷ(θ(z)) − y)‖²/‖wy‖². u = ln θ of constants that are positive by their law, else θ over what changes the curve by its own
//! size; u = u₀ + Tz, T = V diag(1/σ) from the SVD of w∂ŷ/∂u/‖wy‖ at the start, so that the region is a sphere of curves and
//! constants that compensate each other are no narrow valley. A forward solve that fails costs as much as a wall: the step is taken
//! back and the region shrinks. The search ends where a full Gauss–Newton step would lower f
//! by less than 1e-6 of it, a change of the constants by 1e-3 √n of their standard deviation, or by less than rounding.
//!
//! argmin asks for value, gradient and matrix one after the other; one forward solve answers all three.

use super::Measured;
use super::model::{Answer, Failure, SceneModel, Unknown};
use crate::calibrate::solve::rows::padded;
use crate::math::svd::svd;
use crate::scene::Progress;
use argmin::core::{
    CostFunction, Error, Executor, Gradient, Hessian, IterState, KV, Problem, Solver, State, TerminationReason,
    TerminationStatus,
};
use argmin::solver::trustregion::{Steihaug, TrustRegion};
use nalgebra::{DMatrix, DVector};
use std::cell::{Cell, RefCell};
use std::rc::Rc;

/// f where there is no answer; f(θ = 0) is ½
const WALL: f64 = 1e12;
/// Predicted decrease of f that is none: as a part of f, and as f itself (rounding of the forward solves)
const STILL: f64 = 1e-6;
const ROUNDING: f64 = 1e-16;
/// Radius of the trust region at the start, and at most: relative change of the curve
const RADIUS: f64 = 0.5;
const LARGEST: f64 = 2.0;
const ITERATIONS: u64 = 40;
/// Singular values below this part of the largest do not stretch the region further
const FLAT: f64 = 1e-4;

/// Result of a search.
pub struct Found {
    pub values: Vec<f64>,
    pub answer: Answer,
    /// Forward solves, and how many of them failed
    pub solves: usize,
    pub failed: usize,
    /// The last step was below what counts
    pub settled: bool,
}

/// Wants \[data points\] and the scale ‖wy‖ of the objective.
pub struct Weights {
    pub w: Vec<f64>,
    pub size: f64,
}

/// Searches from `start` \[SI\]. The error is the one of the start itself.
pub fn search(
    model: &SceneModel,
    measured: &Measured,
    weights: &Weights,
    start: &[f64],
    watch: &mut dyn FnMut(Progress) -> bool,
) -> Result<Found, Failure> {
    let answer = model.answer(start, measured, watch)?;
    let coordinates = Coordinates::new(&model.unknown, start, &answer, weights);
    let objective = Objective {
        model,
        measured,
        weights,
        coordinates,
        watch: RefCell::new(watch),
        last: RefCell::default(),
        best: RefCell::default(),
        solves: Cell::new(1),
        failed: Cell::new(0),
        stop: RefCell::default(),
    };
    let z = vec![0.0; start.len()];
    objective.keep(&z, answer);
    let shared = Rc::new(objective);
    let argmin = |z: Vec<f64>| -> Result<bool, Error> {
        let steps = Steihaug::new().with_epsilon(1e-14)?.with_max_iters(2 * z.len() as u64);
        let region = TrustRegion::new(steps).with_radius(RADIUS)?.with_max_radius(LARGEST)?;
        let run = Executor::new(Shared(shared.clone()), UntilSettled(region))
            .configure(|state| state.param(z).max_iters(ITERATIONS))
            .ctrlc(false)
            .run()?;
        Ok(matches!(run.state().get_termination_reason(), Some(TerminationReason::SolverConverged)))
    };
    let outcome = argmin(z);
    if let Some(failure) = shared.stop.borrow_mut().take() {
        return Err(failure);
    }
    let settled = outcome.unwrap_or(false);
    let objective = Rc::into_inner(shared).expect("argmin is done with it");
    let (z, _, answer) = objective.best.into_inner().expect("the start has an answer");
    let values = objective.coordinates.values(&z);
    Ok(Found { values, answer, solves: objective.solves.get(), failed: objective.failed.get(), settled })
}

/// From z to the constants.
struct Coordinates {
    /// Of each constant: positive, and the unit of u where it is not
    kinds: Vec<(bool, f64)>,
    u0: DVector<f64>,
    t: DMatrix<f64>,
}

impl Coordinates {
    fn new(unknown: &[Unknown], start: &[f64], answer: &Answer, weights: &Weights) -> Self {
        let p = start.len();
        let of_theta =
            DMatrix::from_fn(weights.w.len(), p, |i, k| weights.w[i] * answer.sensitivities[(i, k)] / weights.size);
        let kind = |k: usize| {
            let length = of_theta.column(k).norm();
            let positive = unknown[k].parameter.bounds.0 >= 0.0 && start[k] > 0.0;
            (positive, if length > 0.0 { 1.0 / length } else { start[k].abs().max(1.0) })
        };
        let kinds: Vec<(bool, f64)> = (0..p).map(kind).collect();
        let u0 = DVector::from_fn(p, |k, _| if kinds[k].0 { start[k].ln() } else { start[k] / kinds[k].1 });
        let mut own = Self { kinds, u0, t: DMatrix::identity(p, p) };
        let j = of_theta * own.rates(&vec![0.0; p]);
        let svd = svd(padded(&j, p), false, true);
        let (sigma, vt) = (svd.singular_values, svd.v_t.expect("asked for"));
        let stretch = |k: usize| if sigma.max() > 0.0 { sigma[k].max(FLAT * sigma.max()).recip() } else { 1.0 };
        own.t = DMatrix::from_fn(p, p, |i, k| vt[(k, i)] * stretch(k));
        own
    }

    fn u(&self, z: &[f64]) -> DVector<f64> {
        &self.u0 + &self.t * DVector::from_column_slice(z)
    }

    /// θ at z
    fn values(&self, z: &[f64]) -> Vec<f64> {
        let one = |(u, (positive, unit)): (&f64, &(bool, f64))| if *positive { u.exp() } else { u * unit };
        self.u(z).iter().zip(&self.kinds).map(one).collect()
    }

    /// ∂θ/∂z
    fn rates(&self, z: &[f64]) -> DMatrix<f64> {
        let one = |(u, (positive, unit)): (&f64, &(bool, f64))| if *positive { u.exp() } else { *unit };
        let by_u: Vec<f64> = self.u(z).iter().zip(&self.kinds).map(one).collect();
        DMatrix::from_fn(z.len(), z.len(), |i, k| by_u[i] * self.t[(i, k)])
    }
}

/// Value, gradient and Gauss–Newton matrix at z.
#[derive(Clone)]
struct SearchPoint {
    z: Vec<f64>,
    f: f64,
    gradient: Vec<f64>,
    matrix: Vec<Vec<f64>>,
}

struct Objective<'a> {
    model: &'a SceneModel,
    measured: &'a Measured,
    weights: &'a Weights,
    coordinates: Coordinates,
    watch: RefCell<&'a mut dyn FnMut(Progress) -> bool>,
    last: RefCell<Option<SearchPoint>>,
    best: RefCell<Option<(Vec<f64>, f64, Answer)>>,
    solves: Cell<usize>,
    failed: Cell<usize>,
    /// A mistake of the input, or Ctrl-C: no constants would help
    stop: RefCell<Option<Failure>>,
}

impl Objective<'_> {
    /// One forward solve at z, unless it was the last one. A failure leaves a wall.
    fn evaluate(&self, z: &[f64]) -> Option<Failure> {
        if self.last.borrow().as_ref().is_some_and(|p| p.z == z) {
            return None;
        }
        let values = self.coordinates.values(z);
        self.solves.set(self.solves.get() + 1);
        let p = z.len();
        match self.model.answer(&values, self.measured, &mut **self.watch.borrow_mut()) {
            Ok(answer) => {
                self.keep(z, answer);
                None
            }
            Err(failure) => {
                self.failed.set(self.failed.get() + 1);
                let (gradient, matrix) = (vec![0.0; p], vec![vec![0.0; p]; p]);
                *self.last.borrow_mut() = Some(SearchPoint { z: z.to_vec(), f: WALL, gradient, matrix });
                Some(failure)
            }
        }
    }

    /// Keeps an answer as the last one, and as the best where it is.
    fn keep(&self, z: &[f64], answer: Answer) {
        let Weights { w, size } = self.weights;
        let r = DVector::from_fn(w.len(), |i, _| w[i] * (answer.y[i] - self.measured.y[i]) / size);
        let j = DMatrix::from_fn(w.len(), z.len(), |i, k| w[i] * answer.sensitivities[(i, k)] / size)
            * self.coordinates.rates(z);
        let f = 0.5 * r.norm_squared();
        let matrix = (j.transpose() * &j).row_iter().map(|r| r.iter().copied().collect()).collect();
        let gradient = (j.transpose() * &r).iter().copied().collect();
        *self.last.borrow_mut() = Some(SearchPoint { z: z.to_vec(), f, gradient, matrix });
        if self.best.borrow().as_ref().is_none_or(|(_, least, _)| f < *least) {
            *self.best.borrow_mut() = Some((z.to_vec(), f, answer));
        }
    }

    fn at(&self, z: &[f64]) -> Result<SearchPoint, Error> {
        match self.evaluate(z) {
            Some(failure @ (Failure::Input(_) | Failure::Interrupted)) => {
                *self.stop.borrow_mut() = Some(failure);
                Err(Error::msg("stopped"))
            }
            _ => Ok(self.last.borrow().clone().expect("an evaluation leaves a point")),
        }
    }
}

/// argmin owns its problem; the caller reads the best answer from it afterwards.
struct Shared<'a>(Rc<Objective<'a>>);

impl CostFunction for Shared<'_> {
    type Param = Vec<f64>;
    type Output = f64;
    fn cost(&self, z: &Vec<f64>) -> Result<f64, Error> {
        Ok(self.0.at(z)?.f)
    }
}

impl Gradient for Shared<'_> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;
    fn gradient(&self, z: &Vec<f64>) -> Result<Vec<f64>, Error> {
        Ok(self.0.at(z)?.gradient)
    }
}

impl Hessian for Shared<'_> {
    type Param = Vec<f64>;
    type Hessian = Vec<Vec<f64>>;
    fn hessian(&self, z: &Vec<f64>) -> Result<Vec<Vec<f64>>, Error> {
        Ok(self.0.at(z)?.matrix)
    }
}

/// The state of argmin's trust region.
type At = IterState<Vec<f64>, Vec<f64>, (), Vec<Vec<f64>>, (), f64>;

/// argmin's trust region has no test of its own: this adds the one on the predicted decrease ½gᵀH⁻¹g.
struct UntilSettled<S>(S);

impl<O, S: Solver<O, At>> Solver<O, At> for UntilSettled<S> {
    fn name(&self) -> &str {
        self.0.name()
    }

    fn init(&mut self, problem: &mut Problem<O>, state: At) -> Result<(At, Option<KV>), Error> {
        self.0.init(problem, state)
    }

    fn next_iter(&mut self, problem: &mut Problem<O>, state: At) -> Result<(At, Option<KV>), Error> {
        self.0.next_iter(problem, state)
    }

    fn terminate(&mut self, state: &At) -> TerminationStatus {
        let (Some(g), Some(h)) = (state.get_gradient(), state.get_hessian()) else {
            return TerminationStatus::NotTerminated;
        };
        let p = g.len();
        let g = DVector::from_column_slice(g);
        let h = DMatrix::from_fn(p, p, |i, k| h[i][k]);
        // Directions that the data do not determine have no step either
        let svd = svd(h, true, true);
        let step = svd.solve(&g, 1e-14 * svd.singular_values.max()).unwrap_or_else(|_| DVector::zeros(p));
        let decrease = 0.5 * g.dot(&step);
        if decrease <= STILL * state.get_cost() || decrease <= ROUNDING {
            return TerminationStatus::Terminated(TerminationReason::SolverConverged);
        }
        TerminationStatus::NotTerminated
    }
}
