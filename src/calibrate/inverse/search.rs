//! Least squares over forward solves: argmin's trust region (Steihaug's conjugate gradients) on the Gauss–Newton matrix.
//!
//! f(z) = ½‖w(ŷ(θ(z)) − y)‖²/‖wy‖², z = ln θ of constants that are positive by their law, else θ/|θ₀|. A forward solve that fails
//! costs as much as a wall: the step is taken back and the region shrinks. The search ends where a full Gauss–Newton step would lower f
//! by less than 1e-6 of it, a change of the constants by 1e-3 √n of their standard deviation, or by less than rounding.
//!
//! argmin asks for value, gradient and matrix one after the other; one forward solve answers all three.

use super::Measured;
use super::model::{Answer, Failure, SceneModel, Unknown};
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
/// Radius of the trust region at the start, and at most: factors of e in positive constants
const RADIUS: f64 = 0.5;
const LARGEST: f64 = 2.0;
const ITERATIONS: u64 = 40;

/// What a search found.
pub struct Found {
    pub values: Vec<f64>,
    pub answer: Answer,
    /// Forward solves, and how many of them failed
    pub solves: usize,
    pub failed: usize,
    /// The last step was below what counts
    pub settled: bool,
}

/// Wants [rows] and the scale ‖wy‖ of the objective.
pub struct Weights {
    pub w: Vec<f64>,
    pub size: f64,
}

/// Searches from `start` [SI]. The error is the one of the start itself.
pub fn search(
    model: &SceneModel,
    measured: &Measured,
    weights: &Weights,
    start: &[f64],
    watch: &mut dyn FnMut(Progress) -> bool,
) -> Result<Found, Failure> {
    let objective = Objective {
        model,
        measured,
        weights,
        watch: RefCell::new(watch),
        last: RefCell::default(),
        best: RefCell::default(),
        solves: Cell::new(0),
        failed: Cell::new(0),
        stop: RefCell::default(),
    };
    let z: Vec<f64> = model.unknown.iter().zip(start).map(|(u, v)| scaled(u, *v)).collect();
    let shared = Rc::new(objective);
    if let Some(failure) = shared.evaluate(&z) {
        return Err(failure);
    }
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
    let values = model.unknown.iter().zip(&z).map(|(u, z)| value(u, *z)).collect();
    Ok(Found { values, answer, solves: objective.solves.get(), failed: objective.failed.get(), settled })
}

fn is_positive(u: &Unknown) -> bool {
    u.parameter.bounds.0 >= 0.0 && u.start > 0.0
}

/// θ → z
fn scaled(u: &Unknown, value: f64) -> f64 {
    if is_positive(u) { value.ln() } else { value / scale(u) }
}

/// z → θ
fn value(u: &Unknown, z: f64) -> f64 {
    if is_positive(u) { z.exp() } else { z * scale(u) }
}

/// ∂θ/∂z
fn rate(u: &Unknown, z: f64) -> f64 {
    if is_positive(u) { z.exp() } else { scale(u) }
}

fn scale(u: &Unknown) -> f64 {
    if u.start == 0.0 { 1.0 } else { u.start.abs() }
}

/// Value, gradient and Gauss–Newton matrix at z.
#[derive(Clone)]
struct Point {
    z: Vec<f64>,
    f: f64,
    gradient: Vec<f64>,
    matrix: Vec<Vec<f64>>,
}

struct Objective<'a> {
    model: &'a SceneModel,
    measured: &'a Measured,
    weights: &'a Weights,
    watch: RefCell<&'a mut dyn FnMut(Progress) -> bool>,
    last: RefCell<Option<Point>>,
    best: RefCell<Option<(Vec<f64>, f64, Answer)>>,
    solves: Cell<usize>,
    failed: Cell<usize>,
    /// A mistake of the input, or Ctrl-C: no constants would help
    stop: RefCell<Option<Failure>>,
}

impl Objective<'_> {
    /// One forward solve at z, unless it was the last one. The failure is left to the caller at the start, and a wall later on.
    fn evaluate(&self, z: &[f64]) -> Option<Failure> {
        if self.last.borrow().as_ref().is_some_and(|p| p.z == z) {
            return None;
        }
        let unknown = &self.model.unknown;
        let values: Vec<f64> = unknown.iter().zip(z).map(|(u, z)| value(u, *z)).collect();
        self.solves.set(self.solves.get() + 1);
        let p = z.len();
        match self.model.answer(&values, self.measured, &mut **self.watch.borrow_mut()) {
            Ok(answer) => {
                let Weights { w, size } = self.weights;
                let r = DVector::from_fn(w.len(), |i, _| w[i] * (answer.y[i] - self.measured.y[i]) / size);
                let j =
                    DMatrix::from_fn(w.len(), p, |i, k| w[i] * answer.slopes[(i, k)] * rate(&unknown[k], z[k]) / size);
                let f = 0.5 * r.norm_squared();
                let matrix = j.transpose() * &j;
                let matrix = matrix.row_iter().map(|r| r.iter().copied().collect()).collect();
                let gradient = (j.transpose() * &r).iter().copied().collect();
                *self.last.borrow_mut() = Some(Point { z: z.to_vec(), f, gradient, matrix });
                if self.best.borrow().as_ref().is_none_or(|(_, least, _)| f < *least) {
                    *self.best.borrow_mut() = Some((z.to_vec(), f, answer));
                }
                None
            }
            Err(failure) => {
                self.failed.set(self.failed.get() + 1);
                let (gradient, matrix) = (vec![0.0; p], vec![vec![0.0; p]; p]);
                *self.last.borrow_mut() = Some(Point { z: z.to_vec(), f: WALL, gradient, matrix });
                Some(failure)
            }
        }
    }

    fn at(&self, z: &[f64]) -> Result<Point, Error> {
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
        // Directions that the data do not see have no step either
        let svd = h.svd(true, true);
        let step = svd.solve(&g, 1e-14 * svd.singular_values.max()).unwrap_or_else(|_| DVector::zeros(p));
        let decrease = 0.5 * g.dot(&step);
        if decrease <= STILL * state.get_cost() || decrease <= ROUNDING {
            return TerminationStatus::Terminated(TerminationReason::SolverConverged);
        }
        TerminationStatus::NotTerminated
    }
}
