//! The equations of a reduced model and Newton's method for them, without allocation.
//!
//! The unknowns are the displacement coordinates q, the pressure coordinates π and the tensions of taut cables. With pressures and tensions the
//! symmetric matrix is that of a saddle point, which is factorised with pivoting.

use super::cable::RunningCable;
use super::dense::Dense;
use super::laws::RunningLaws;
use super::motion::Motion;
use crate::material::{LawSpecError, Want};
use crate::math::vector::norm;
use crate::reduction::forces::CableDrive;
use crate::reduction::model::ReducedModel;
use crate::reduction::points::{Points, StoredPoints, Sums, total};
use std::sync::Arc;

/// Values of the unknowns of a reduced model.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Position {
    /// Displacement coordinates, then pressures
    pub y: Vec<f64>,
    /// \[cables\] tension \[N\]
    pub tensions: Vec<f64>,
    /// \[cables\] whether the length of the cable constrains the body
    pub taut: Vec<bool>,
}

impl Position {
    /// Copies the values of another position.
    pub fn take(&mut self, other: &Self) {
        self.y.copy_from_slice(&other.y);
        self.tensions.copy_from_slice(&other.tensions);
        self.taut.copy_from_slice(&other.taut);
    }

    pub fn clear(&mut self) {
        self.y.fill(0.0);
        self.tensions.fill(0.0);
        self.taut.fill(false);
    }
}

/// The equations with the workspace of their evaluations.
pub struct Equations {
    model: Arc<ReducedModel>,
    points: Vec<Points>,
    laws: RunningLaws,
    pub cables: Vec<RunningCable>,
    /// `None` in static models
    pub motion: Option<Motion>,
    sums: Sums,
    /// \[coordinates\] residual forces
    r: Vec<f64>,
    /// \[coordinates × coordinates\] column ≤ row
    k: Vec<f64>,
    dense: Dense,
    /// \[coordinates + cables\]
    solution: Vec<f64>,
    /// Indices of the taut cables, in the first `taut` entries
    rows: Vec<usize>,
    taut: usize,
}

/// Increment of the coordinates, relative to their amplitudes, below which equilibrium is reached \[–\]: Newton's method squares it.
const REACHED: f64 = 1e-6;
/// Largest number of iterations for one position.
const ITERATIONS: usize = 25;
/// Largest increment of an iteration, relative to the amplitude \[–\].
const LONGEST: f64 = 1.0;
/// Slack below which a cable counts as taut, relative to its length \[–\].
const CLOSED: f64 = 1e-12;

impl Equations {
    pub fn new(model: Arc<ReducedModel>) -> Result<Self, LawSpecError> {
        let own = model.own_sizes();
        let (n, most) = (own.coordinates(), own.coordinates() + model.cables.len());
        let points = |p| Points::new(p, own);
        let mut points = model.points.iter().map(points).collect::<Result<Vec<_>, _>>()?;
        let motion = model.dynamics.as_ref().map(|dynamics| {
            let moving = |(p, stored): (Points, &StoredPoints)| p.moving(&stored.rates, dynamics.dt);
            points = std::mem::take(&mut points).into_iter().zip(&model.points).map(moving).collect();
            Motion::new(dynamics, own.displacements, points.iter().map(Points::memory).sum())
        });
        let cables: Vec<_> = model.cables.iter().map(|c| RunningCable::new(c, own.displacements)).collect();
        Ok(Self {
            points,
            motion,
            laws: RunningLaws::new(&model.compliance, model.inputs.len()),
            sums: Sums::new(own),
            r: vec![0.0; n],
            k: vec![0.0; n * n],
            dense: Dense::new(most),
            solution: vec![0.0; most],
            rows: vec![0; cables.len()],
            taut: 0,
            cables,
            model,
        })
    }

    /// Returns the position at rest.
    pub fn rest(&self) -> Position {
        let cables = self.cables.len();
        Position { y: vec![0.0; self.r.len()], tensions: vec![0.0; cables], taut: vec![false; cables] }
    }

    /// Starts a time step; has no effect on static models.
    pub fn begin(&mut self) {
        self.motion.iter_mut().for_each(Motion::begin);
        self.begin_points();
    }

    /// Starts the points at the state before the step.
    fn begin_points(&mut self) {
        let Some(motion) = &self.motion else { return };
        let mut history = &motion.state().history[..];
        for points in &mut self.points {
            let (own, rest) = history.split_at(points.memory());
            points.begin(&motion.state().x, own);
            history = rest;
        }
    }

    /// Ends a time step at a position; false if the history of the points is undefined there.
    pub fn accept(&mut self, at: &Position) -> bool {
        let Self { motion, points, sums, model, .. } = self;
        let Some(motion) = motion else { return true };
        let q = &at.y[..model.sizes.displacements];
        motion.accept(q, |mut past, mut next| {
            points.iter().all(|points| {
                let (from, past_rest) = past.split_at(points.memory());
                let (to, next_rest) = std::mem::take(&mut next).split_at_mut(points.memory());
                (past, next) = (past_rest, next_rest);
                points.advance(q, from, to, sums).is_ok()
            })
        })
    }

    /// Returns to rest under these inputs; has no effect on static models.
    pub fn reset(&mut self, inputs: &[f64]) {
        let zero = vec![0.0; self.model.sizes.displacements];
        self.motion.iter_mut().for_each(|motion| motion.reset(&zero));
        self.begin();
        let accelerations = self.start(inputs);
        self.motion.iter_mut().for_each(|motion| motion.reset(&accelerations));
    }

    /// Returns the accelerations of the displacement coordinates at rest under these inputs, from the forces that the inertia must balance.
    fn start(&mut self, inputs: &[f64]) -> Vec<f64> {
        let (rest, n) = (self.rest(), self.model.sizes.displacements);
        let mass = self.model.dynamics.as_ref().filter(|d| d.integrator.needs_initial_acceleration());
        let factor = mass.and_then(|dynamics| super::dynamics::factor(&dynamics.mass, n));
        let Some(factor) = factor else { return vec![0.0; n] };
        // Nothing moves yet: neither accelerations nor velocities contribute to the forces
        let motion = self.motion.take();
        let defined = self.linearise(inputs, &rest);
        self.motion = motion;
        let forces = nalgebra::DVector::from_fn(n, |i, _| if defined { -self.r[i] } else { 0.0 });
        factor.solve(&forces).as_slice().to_vec()
    }

    /// Performs one Newton iteration from a position, with the cables that are taut there; false if the result is not finite.
    pub fn iterate(&mut self, inputs: &[f64], at: &mut Position) -> bool {
        self.linearise(inputs, at) && self.advance(inputs, at).is_some()
    }

    /// Solves for the equilibrium of these inputs by Newton's method, starting from `at`. Returns whether it was reached, and the number of
    /// iterations. If not, `at` is meaningless.
    pub fn solve(&mut self, inputs: &[f64], at: &mut Position) -> (bool, usize) {
        for iteration in 1..=ITERATIONS {
            if !self.linearise(inputs, at) {
                return (false, iteration);
            }
            if iteration == 1 {
                for (c, cable) in self.cables.iter().enumerate() {
                    let is_long = cable.by_length() && cable.gap(inputs, at.tensions[c]) < -CLOSED * cable.length;
                    at.taut[c] |= is_long;
                }
            }
            let Some(size) = self.advance(inputs, at) else { return (false, iteration) };
            if size <= REACHED && self.settle_cables(inputs, at) {
                return (true, iteration);
            }
        }
        (false, ITERATIONS)
    }

    /// Computes forces and tangent at the current position, or for a dynamic model at the end of its last step; false if they are undefined, or if no
    /// step has ended.
    pub fn linearise_present(&mut self, inputs: &[f64], at: &Position) -> bool {
        if !self.motion.iter_mut().all(Motion::go_back) {
            return false;
        }
        // A step that has failed since then started at the current state
        self.begin_points();
        let defined = self.linearise(inputs, at);
        self.motion.iter_mut().for_each(Motion::go_on);
        defined
    }

    /// Computes forces and tangent at a position; false if a law or a cable is undefined there.
    pub fn linearise(&mut self, inputs: &[f64], at: &Position) -> bool {
        let Self { model, points, laws, cables, motion, sums, r, k, .. } = self;
        let (n, u) = (r.len(), model.sizes.displacements);
        if !laws.bring(&model.constants, points, inputs, |part| &part.own) {
            return false;
        }
        sums.clear(Want::Tangent);
        if points.iter().any(|points| points.add(&at.y, Want::Tangent, sums).is_err()) {
            return false;
        }
        r.iter_mut().zip(&sums.r).for_each(|(r, sum)| *r = total(sum));
        k.iter_mut().zip(&sums.k).for_each(|(k, sum)| *k = total(sum));
        let m = model.sizes.pressures;
        for (i, row) in laws.compliance.chunks_exact(m.max(1)).enumerate() {
            r[u + i] -= row.iter().zip(&at.y[u..]).map(|(c, p)| c * p).sum::<f64>();
            k[(u + i) * n + u..=(u + i) * n + u + i].iter_mut().zip(row).for_each(|(k, c)| *k -= c);
        }
        let q = &at.y[..u];
        if let Some(motion) = motion {
            motion.add(q, n, r, k);
        }
        for load in &model.loads {
            let intensity = load.intensity.at(inputs);
            load.force.add(q, intensity, &mut r[..u]);
            load.force.add_derivative(q, intensity, n, k);
        }
        for (c, cable) in cables.iter_mut().enumerate() {
            if cable.evaluate(q).is_err() {
                return false;
            }
            let tension = match &cable.drive {
                CableDrive::Tension(tension) => tension.at(inputs).max(0.0),
                CableDrive::Length { .. } => at.tensions[c],
            };
            if tension != 0.0 {
                r.iter_mut().zip(&cable.gradient).for_each(|(r, g)| *r += tension * g);
                if cable.add_hessian(tension, n, k).is_err() {
                    return false;
                }
            }
        }
        true
    }

    /// Factorises the equations with the taut cables at the linearised position.
    pub fn factorise(&mut self, at: &Position) {
        let Self { cables, k, dense, rows, r, .. } = self;
        let n = r.len();
        self.taut = 0;
        for c in (0..cables.len()).filter(|&c| at.taut[c]) {
            rows[self.taut] = c;
            self.taut += 1;
        }
        let rows = &rows[..self.taut];
        let compliance = |c: usize| match cables[c].drive {
            CableDrive::Length { compliance, .. } => compliance,
            CableDrive::Tension(_) => 0.0,
        };
        // A cable does not depend on pressures
        let of_cable = |c: usize, j: usize| cables[c].gradient.get(j).copied().unwrap_or(0.0);
        dense.factorise(n + rows.len(), |i, j| match (i.checked_sub(n), j.checked_sub(n)) {
            (None, None) => k[i.max(j) * n + i.min(j)],
            (Some(c), None) => of_cable(rows[c], j),
            (None, Some(c)) => of_cable(rows[c], i),
            (Some(a), Some(b)) => {
                if a == b {
                    -compliance(rows[a])
                } else {
                    0.0
                }
            }
        });
    }

    /// Performs one Newton step; returns the increment relative to the amplitudes, `None` if it is not finite.
    fn advance(&mut self, inputs: &[f64], at: &mut Position) -> Option<f64> {
        self.factorise(at);
        let Self { model, cables, r, solution, rows, taut, dense, .. } = self;
        let n = r.len();
        solution[..n].iter_mut().zip(&*r).for_each(|(s, r)| *s = -r);
        for (to, &c) in solution[n..].iter_mut().zip(&rows[..*taut]) {
            *to = cables[c].gap(inputs, at.tensions[c]);
        }
        dense.solve(&mut solution[..n + *taut]);
        if solution[..n + *taut].iter().any(|x| !x.is_finite()) {
            return None;
        }
        let u = model.sizes.displacements;
        let moved = norm(&solution[..u]) / model.amplitudes[0];
        let pressed = match model.amplitudes[1] {
            0.0 => 0.0,
            amplitude => norm(&solution[u..n]) / amplitude,
        };
        let share = (LONGEST / moved).min(1.0);
        at.y.iter_mut().zip(&solution[..n]).for_each(|(y, d)| *y += share * d);
        for (&c, d) in rows[..*taut].iter().zip(&solution[n..]) {
            at.tensions[c] += share * d;
        }
        Some(moved.max(pressed))
    }

    /// Releases cables that would push and tightens those that are too long; returns true if nothing changed.
    fn settle_cables(&mut self, inputs: &[f64], at: &mut Position) -> bool {
        let u = self.model.sizes.displacements;
        let mut settled = true;
        for (c, cable) in self.cables.iter_mut().enumerate().filter(|(_, c)| c.by_length()) {
            if at.taut[c] && at.tensions[c] < 0.0 {
                (at.taut[c], at.tensions[c], settled) = (false, 0.0, false);
            } else if !at.taut[c] {
                let evaluated = cable.evaluate(&at.y[..u]).is_ok();
                let is_long = evaluated && cable.gap(inputs, 0.0) < -CLOSED * cable.length;
                at.taut[c] = is_long;
                settled &= !is_long;
            }
        }
        settled
    }

    /// Adds the change −∂r/∂u due to the laws that depend on input `k`.
    fn change_of_laws(&mut self, k: usize, inputs: &[f64], at: &Position, out: &mut [f64]) {
        let Self { model, points, sums, .. } = self;
        let u = model.sizes.displacements;
        for law in &model.constants.laws {
            for &part in &law.parts {
                let Some(along) = law.derivative(k, inputs) else { continue };
                sums.clear(Want::Residual);
                let Ok(bulk) = points[part].add_derivative(&at.y, along, sums) else { continue };
                out.iter_mut().zip(&sums.r).take(u).for_each(|(out, sum)| *out -= total(sum));
                let (Some(change), Some(kappa)) = (bulk, points[part].bulk_modulus()) else { continue };
                // C = C₀ κ₀/κ of this part
                let of = &model.constants.parts[part];
                let rate = change * of.kappa / (kappa * kappa);
                for (out, row) in out[u..].iter_mut().zip(of.own.chunks_exact(model.sizes.pressures.max(1))) {
                    *out -= rate * row.iter().zip(&at.y[u..]).map(|(c, p)| c * p).sum::<f64>();
                }
            }
        }
    }

    /// Computes the derivative of the unknowns \[coordinates, then cables\] with respect to input `k`, at a position that has been linearised and
    /// factorised.
    pub fn change(&mut self, k: usize, inputs: &[f64], at: &Position, out: &mut [f64]) {
        out.fill(0.0);
        self.change_of_laws(k, inputs, at, out);
        let Self { model, cables, r, rows, taut, dense, .. } = self;
        let (n, u) = (r.len(), model.sizes.displacements);
        for load in &model.loads {
            load.force.add(&at.y[..u], -load.intensity.rates[k], &mut out[..u]);
        }
        for cable in cables.iter() {
            if let CableDrive::Tension(tension) = &cable.drive
                && tension.at(inputs) > 0.0
            {
                out.iter_mut().zip(&cable.gradient).for_each(|(out, g)| *out -= tension.rates[k] * g);
            }
        }
        for (to, &c) in out[n..].iter_mut().zip(&rows[..*taut]) {
            if let CableDrive::Length { free, .. } = &cables[c].drive {
                *to = free.rates[k];
            }
        }
        dense.solve(&mut out[..n + *taut]);
        // Restore the order of the cables
        for place in (0..*taut).rev() {
            out.swap(n + place, n + rows[place]);
        }
    }
}
