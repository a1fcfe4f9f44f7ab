//! A running reduced model: computes, from inputs, the equilibrium or the end of a time step, the quantities and their error bars, without
//! allocation.
//!
//! The error of a dynamic model is estimated by a model with more modes and points that follows it, with one linear solution per step. With e the
//! distance of the enriched solution from the model, in the enriched space, a step starts from E q + e of the last step, evaluates the residual
//! forces ρ of the full model there, including inertia and all history of the points, and solves the linearised error dynamics (c_a M + c_v C + K) Δe
//! = −ρ. The estimate of a quantity is its difference between the two models.
//!
//! Hierarchical estimates: Bank & Smith, *SIAM J. Numer. Anal.* 30 (1993); for reduced models Hain, Ohlberger, Radic & Urban, *Adv. Comput.
//! Math.* 45 (2019). Limits: errors outside the enriched space are not detected, and enter the bar only by its calibration.

use super::equations::{Equations, Position};
use super::motion::Motion;
use super::residual::Residual;
use crate::material::LawSpecError;
use crate::math::tensor::Vec3;
use crate::reduction::forces::CableDrive;
use crate::reduction::inputs::largest_part;
use crate::reduction::model::{ReducedModel, TimeEstimate};
use crate::reduction::quantities::{ReducedReading, winding};
use crate::system::State;
use std::sync::Arc;

/// A model at its current equilibrium.
pub struct Twin {
    model: Arc<ReducedModel>,
    equations: Equations,
    residual: Option<Residual>,
    /// The error estimate of a dynamic model
    shadow: Option<Shadow>,
    /// Inputs of the current equilibrium
    inputs: Vec<f64>,
    /// Whether they are within their ranges; for a dynamic model, whether they always were, never changed faster than in the runs from which it was
    /// made, and no more time has passed than in these
    in_range: bool,
    /// Whether a step has ended since the last rest state, where the body is undeformed and need not be in equilibrium
    stepped: bool,
    at: Position,
    /// Position at the start of the step, and at the end of its last part
    start: Position,
    last: Position,
    trial: Vec<f64>,
    /// Values that quantities keep between steps, and those at the start of the step
    memory: Vec<f64>,
    kept: Vec<f64>,
    values: Vec<f64>,
    estimates: Vec<f64>,
    bars: Vec<f64>,
    /// \[coordinates + cables\]
    change: Vec<f64>,
    /// \[3 × coordinates\]
    slopes: Vec<f64>,
}

/// The state of a model between two steps, from which it continues bit for bit.
#[derive(Clone, Debug, PartialEq)]
pub struct TwinState {
    inputs: Vec<f64>,
    in_range: bool,
    stepped: bool,
    at: Position,
    /// Displacement coordinates, their rates and the history of the points of a dynamic model; `None` for a static one
    motion: Option<State>,
    memory: Vec<f64>,
    values: Vec<f64>,
    estimates: Vec<f64>,
    bars: Vec<f64>,
    shadow: Option<Box<ShadowState>>,
}

/// Counts of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepReport {
    /// Number of Newton iterations
    pub iterations: usize,
    /// Number of parts into which the change of the inputs was divided
    pub parts: usize,
}

/// Reason why a step has no result. The model stays at its last equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum StepError {
    #[error("{given} inputs were given, and the model has {wanted}")]
    Count { given: usize, wanted: usize },
    #[error("input {0} is not a finite number")]
    NotFinite(usize),
    #[error("the law is not defined at this value of input {0}; stay in the ranges")]
    Constant(usize),
    #[error("no equilibrium was found between the last inputs and these; give smaller changes, or stay in the ranges")]
    NoEquilibrium,
}

/// Largest number of iterations of one step.
const ITERATIONS: usize = 400;
/// Smallest part of a change of the inputs \[–\].
const SMALLEST: f64 = 1.0 / 256.0;

impl Twin {
    /// Starts the model at rest, with all inputs at their values at the start of the scene; if these are unknown, or the model is dynamic, at zero or
    /// at the ends of their ranges nearest to zero.
    ///
    /// # Errors
    ///
    /// A law is unknown to this program, such as one registered by another program.
    pub fn new(model: impl Into<Arc<ReducedModel>>) -> Result<Self, LawSpecError> {
        let model: Arc<ReducedModel> = model.into();
        let equations = Equations::new(model.clone())?;
        let residual = model.estimate.as_ref().map(|e| Residual::new(e, model.sizes)).transpose()?;
        let shadow = model.estimate_in_time.as_ref().map(Shadow::new).transpose()?;
        let rest = equations.rest();
        let (quantities, inputs) = (model.quantities.len(), model.inputs.len());
        let memory: usize = model.quantities.iter().map(|q| q.reading.memory()).sum();
        let mut twin = Self {
            residual,
            shadow,
            inputs: vec![0.0; inputs],
            in_range: true,
            stepped: false,
            start: rest.clone(),
            last: rest.clone(),
            trial: vec![0.0; inputs],
            kept: vec![0.0; memory],
            memory: vec![0.0; memory],
            values: vec![0.0; quantities],
            estimates: vec![0.0; quantities],
            bars: vec![f64::INFINITY; quantities],
            change: vec![0.0; rest.y.len() + rest.tensions.len()],
            slopes: vec![0.0; 3 * rest.y.len()],
            at: rest,
            equations,
            model,
        };
        twin.reset();
        Ok(twin)
    }

    pub fn model(&self) -> &ReducedModel {
        &self.model
    }

    /// Returns to rest.
    pub fn reset(&mut self) {
        self.at.clear();
        (self.in_range, self.stepped) = (true, false);
        self.memory.fill(0.0);
        self.inputs.iter_mut().zip(&self.model.inputs).for_each(|(u, i)| *u = i.at_start());
        self.estimates.fill(0.0);
        self.bars.fill(f64::INFINITY);
        self.equations.reset(&self.inputs);
        self.shadow.iter_mut().for_each(Shadow::reset);
        self.read_quantities();
    }

    /// Returns the current state, to be restored later.
    pub fn save(&self) -> TwinState {
        TwinState {
            inputs: self.inputs.clone(),
            in_range: self.in_range,
            stepped: self.stepped,
            at: self.at.clone(),
            motion: self.equations.motion.as_ref().map(|m| m.state().clone()),
            memory: self.memory.clone(),
            values: self.values.clone(),
            estimates: self.estimates.clone(),
            bars: self.bars.clone(),
            shadow: self.shadow.as_ref().map(|s| Box::new(s.save())),
        }
    }

    /// Restores a state of this model, which then continues bit for bit.
    ///
    /// # Panics
    ///
    /// If the state belongs to a model of different sizes.
    pub fn restore(&mut self, state: &TwinState) {
        self.inputs.copy_from_slice(&state.inputs);
        (self.in_range, self.stepped) = (state.in_range, state.stepped);
        self.at.take(&state.at);
        if let (Some(motion), Some(state)) = (&mut self.equations.motion, &state.motion) {
            motion.restore(state);
        }
        self.estimates.copy_from_slice(&state.estimates);
        self.bars.copy_from_slice(&state.bars);
        if let (Some(shadow), Some(state)) = (&mut self.shadow, &state.shadow) {
            shadow.restore(state);
        }
        self.memory.copy_from_slice(&state.memory);
        self.values.copy_from_slice(&state.values);
    }

    /// Returns the length of a step \[s\] of a dynamic model; `None` for a static one.
    pub fn dt(&self) -> Option<f64> {
        self.model.dynamics.as_ref().map(|d| d.dt)
    }

    /// Returns the time since the last rest state \[s\] of a dynamic model; `None` for a static one.
    pub fn time(&self) -> Option<f64> {
        self.equations.motion.as_ref().map(|m| m.state().t)
    }

    /// Returns the displacement coordinates of a dynamic model with their velocities and accelerations; `None` for a static one.
    pub fn motion(&self) -> Option<&State> {
        self.equations.motion.as_ref().map(Motion::state)
    }

    /// Returns ½ v·Mv \[J\] of a dynamic model; `None` for a static one.
    pub fn kinetic_energy(&self) -> Option<f64> {
        self.equations.motion.as_ref().map(Motion::kinetic_energy)
    }

    /// Inputs of the current equilibrium in SI.
    pub fn inputs(&self) -> &[f64] {
        &self.inputs
    }

    /// Whether the inputs are within the ranges for which the model was made; for a dynamic model, whether the history since the rest state is like
    /// the runs from which it was made: within these ranges, no faster and no longer.
    pub fn in_range(&self) -> bool {
        self.in_range
    }

    /// The current equilibrium.
    pub fn position(&self) -> &Position {
        &self.at
    }

    /// The quantities, in the order of the model.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Estimated errors of the quantities: values of the full model minus these values.
    pub fn estimates(&self) -> &[f64] {
        &self.estimates
    }

    /// Error bars of the quantities; infinite outside the ranges, and for a model without an estimate.
    pub fn bars(&self) -> &[f64] {
        &self.bars
    }

    /// Moves to the equilibrium of these inputs in SI; a dynamic model takes one time step, at whose end the inputs have these values.
    ///
    /// # Errors
    ///
    /// [`StepError`]; the model stays where it was.
    pub fn step(&mut self, inputs: &[f64]) -> Result<StepReport, StepError> {
        let wanted = self.inputs.len();
        if inputs.len() != wanted {
            return Err(StepError::Count { given: inputs.len(), wanted });
        }
        if let Some(k) = inputs.iter().position(|u| !u.is_finite()) {
            return Err(StepError::NotFinite(k));
        }
        let changed = (0..wanted).any(|k| inputs[k] != self.inputs[k] && self.model.constants.has(k));
        if let Some(k) = changed.then(|| self.model.constants.undefined(inputs)).flatten() {
            return Err(StepError::Constant(k));
        }
        self.start.take(&self.at);
        self.last.take(&self.at);
        self.kept.copy_from_slice(&self.memory);
        self.equations.begin();
        if let Some(motion) = &self.equations.motion {
            motion.predict(&mut self.at.y[..self.model.sizes.displacements]);
        }
        let most = self.largest_part(inputs);
        let (mut done, mut part) = (0.0, most);
        let (mut iterations, mut parts) = (0, 0);
        while done < 1.0 {
            if done + part >= 1.0 {
                self.trial.copy_from_slice(inputs);
            } else {
                for (k, to) in inputs.iter().enumerate() {
                    let from = self.begins_at(k);
                    self.trial[k] = from + (done + part) * (to - from);
                }
            }
            let (reached, taken) = self.equations.solve(&self.trial, &mut self.at);
            iterations += taken;
            if reached {
                self.last.take(&self.at);
                (done, parts) = (done + part, parts + 1);
                part = (2.0 * part).min(most).min(1.0 - done);
                if done < 1.0 && self.model.dynamics.is_none() {
                    self.read_quantities();
                }
            } else {
                self.at.take(&self.last);
                part *= 0.5;
                if part < SMALLEST * most || iterations > ITERATIONS * parts.max(1) {
                    return Err(self.no_equilibrium());
                }
            }
        }
        if !self.equations.accept(&self.at) {
            return Err(self.no_equilibrium());
        }
        let within = self.model.inputs.iter().zip(inputs).all(|(i, u)| i.contains(*u));
        let dynamics = self.model.dynamics.as_ref();
        let time = self.time().unwrap_or(0.0);
        self.in_range =
            within && dynamics.is_none_or(|d| self.in_range && d.allows(&self.inputs, inputs) && d.covers(time));
        self.stepped = true;
        self.inputs.copy_from_slice(inputs);
        self.read_quantities();
        self.estimate();
        Ok(StepReport { iterations, parts })
    }

    /// Returns the value of an input from which a step changes it. From rest, where the body is undeformed, this is the unloaded value, so that loads
    /// of the scene are also applied in parts.
    fn begins_at(&self, k: usize) -> f64 {
        if self.stepped { self.inputs[k] } else { self.model.inputs[k].unloaded() }
    }

    /// Returns the largest part of the change to these inputs that is made at once: all of it in a time step, and if no rotations are counted.
    fn largest_part(&self, inputs: &[f64]) -> f64 {
        if self.model.dynamics.is_some() || self.memory.is_empty() {
            return 1.0;
        }
        largest_part(&self.model.inputs, |k| self.begins_at(k), inputs)
    }

    /// Returns to the start of the step.
    fn no_equilibrium(&mut self) -> StepError {
        self.at.take(&self.start);
        self.memory.copy_from_slice(&self.kept);
        self.read_quantities();
        StepError::NoEquilibrium
    }

    /// Takes one time step by one iteration from `start`, with the tensions and taut cables of another model; false if the result is not finite.
    fn follow(&mut self, inputs: &[f64], start: impl Iterator<Item = f64>, of: &Position) -> bool {
        self.equations.begin();
        self.at.y.iter_mut().zip(start).for_each(|(y, start)| *y = start);
        self.at.tensions.copy_from_slice(&of.tensions);
        self.at.taut.copy_from_slice(&of.taut);
        if !(self.equations.iterate(inputs, &mut self.at) && self.equations.accept(&self.at)) {
            return false;
        }
        self.inputs.copy_from_slice(inputs);
        self.read_quantities();
        true
    }

    /// Computes errors and bars at the current equilibrium.
    fn estimate(&mut self) {
        let Self { model, residual, shadow, equations, inputs, in_range, at, values, estimates, bars, .. } = self;
        let Some(all) = model.bars() else { return };
        let known = match (residual, &model.estimate, shadow) {
            (Some(residual), Some(of), _) => residual.estimate((model, of), &equations.cables, (inputs, at), estimates),
            (_, _, Some(shadow)) => shadow.follow(inputs, at, values, estimates),
            _ => false,
        };
        for ((bar, estimate), of) in bars.iter_mut().zip(estimates.iter()).zip(all) {
            *bar = if *in_range && known { of.factor * (estimate.abs() + of.floor) } else { f64::INFINITY };
        }
    }

    fn read_quantities(&mut self) {
        let Self { model, equations, at, inputs, memory, values, .. } = self;
        let q = &at.y[..model.sizes.displacements];
        // Lengths must be those of this position
        equations.cables.iter_mut().for_each(|cable| drop(cable.evaluate(q)));
        let mut first = 0;
        for (value, quantity) in values.iter_mut().zip(&model.quantities) {
            let own = &mut memory[first..first + quantity.reading.memory()];
            first += own.len();
            *value = match &quantity.reading {
                ReducedReading::Tension(c) => match &equations.cables[*c].drive {
                    CableDrive::Tension(tension) => tension.at(inputs).max(0.0),
                    CableDrive::Length { .. } => at.tensions[*c],
                },
                ReducedReading::Length(c) => equations.cables[*c].length,
                ReducedReading::Volume { load, rest } => rest - model.loads[*load].force.potential(q),
                ReducedReading::Intensity(load) => model.loads[*load].intensity.at(inputs),
                ReducedReading::Value(polynomial) => {
                    let mut value = [0.0];
                    polynomial.add(q, 1.0, &mut value);
                    value[0]
                }
                ReducedReading::Turned { direction, rest, axis } => {
                    let mut now = [0.0; 3];
                    direction.add(q, 1.0, &mut now);
                    winding(*rest, *axis).remember(Vec3::from(now), own);
                    own[0]
                }
            };
        }
    }

    /// Computes the derivatives of the quantities with respect to the inputs \[quantities × inputs\] at the current equilibrium; for a dynamic model,
    /// with respect to the inputs at the end of its last step. NaN at rest, before the first step: the undeformed body need not be in equilibrium,
    /// and no cable is taut yet.
    pub fn sensitivities(&mut self, out: &mut [f64]) {
        let inputs = self.inputs.len();
        if !(self.stepped && self.equations.linearise_present(&self.inputs, &self.at)) {
            out.fill(f64::NAN);
            return;
        }
        self.equations.factorise(&self.at);
        for k in 0..inputs {
            let Self { equations, change, at, .. } = self;
            equations.change(k, &self.inputs, at, change);
            let mut first = 0;
            for quantity in 0..self.values.len() {
                out[quantity * inputs + k] = self.along(quantity, k, first);
                first += self.model.quantities[quantity].reading.memory();
            }
        }
    }

    /// Returns the derivative of a quantity along the change of the unknowns and of input `k`; its memory begins at `first`.
    fn along(&mut self, quantity: usize, k: usize, first: usize) -> f64 {
        let Self { model, equations, at, change, memory, slopes, inputs, .. } = self;
        let (n, u) = (at.y.len(), model.sizes.displacements);
        let q = &at.y[..u];
        let dot = |a: &[f64]| a.iter().zip(&change[..u]).map(|(a, d)| a * d).sum::<f64>();
        match &model.quantities[quantity].reading {
            ReducedReading::Tension(c) => match &equations.cables[*c].drive {
                CableDrive::Tension(tension) if tension.at(inputs) > 0.0 => tension.rates[k],
                CableDrive::Tension(_) => 0.0,
                CableDrive::Length { .. } => change[n + c],
            },
            ReducedReading::Length(c) => dot(&equations.cables[*c].gradient),
            ReducedReading::Intensity(load) => model.loads[*load].intensity.rates[k],
            ReducedReading::Volume { load, .. } => {
                slopes[..u].fill(0.0);
                model.loads[*load].force.add(q, -1.0, &mut slopes[..u]);
                dot(&slopes[..u])
            }
            ReducedReading::Value(polynomial) => {
                slopes[..u].fill(0.0);
                polynomial.add_derivative(q, 1.0, u, &mut slopes[..u]);
                dot(&slopes[..u])
            }
            ReducedReading::Turned { direction, rest, axis } => {
                let mut now = [0.0; 3];
                direction.add(q, 1.0, &mut now);
                let along = winding(*rest, *axis).gradient(Vec3::from(now), &memory[first..]);
                slopes[..3 * u].fill(0.0);
                direction.add_derivative(q, 1.0, u, &mut slopes[..3 * u]);
                slopes[..3 * u].chunks_exact(u).zip(along.iter()).map(|(row, a)| a * dot(row)).sum()
            }
        }
    }
}

/// The enriched model and its distance from the model.
struct Shadow {
    twin: Box<Twin>,
    /// \[coordinates of the enriched model × coordinates of the model\]
    embedding: Vec<f64>,
    /// \[coordinates of the enriched model\] e
    distance: Vec<f64>,
    /// \[coordinates of the enriched model\] E y
    embedded: Vec<f64>,
    /// Whether a step failed: then there is no estimate until the next rest state
    lost: bool,
}

/// The state of a [`Shadow`].
#[derive(Clone, Debug, PartialEq)]
struct ShadowState {
    twin: TwinState,
    distance: Vec<f64>,
    lost: bool,
}

impl Shadow {
    fn new(of: &TimeEstimate) -> Result<Self, LawSpecError> {
        let n = of.enriched.sizes.coordinates();
        Ok(Self {
            twin: Box::new(Twin::new((*of.enriched).clone())?),
            embedding: of.embedding.clone(),
            distance: vec![0.0; n],
            embedded: vec![0.0; n],
            lost: false,
        })
    }

    /// Returns to rest.
    fn reset(&mut self) {
        self.twin.reset();
        self.distance.fill(0.0);
        self.lost = false;
    }

    fn save(&self) -> ShadowState {
        ShadowState { twin: self.twin.save(), distance: self.distance.clone(), lost: self.lost }
    }

    fn restore(&mut self, state: &ShadowState) {
        self.twin.restore(&state.twin);
        self.distance.copy_from_slice(&state.distance);
        self.lost = state.lost;
    }

    /// Follows the model to the end of its step; the estimates are the quantities of the enriched model minus `values`. False if there are none.
    fn follow(&mut self, inputs: &[f64], at: &Position, values: &[f64], estimates: &mut [f64]) -> bool {
        let Self { twin, embedding, distance, embedded, lost } = self;
        let rows = embedding.chunks_exact(at.y.len());
        for (sum, row) in embedded.iter_mut().zip(rows) {
            *sum = row.iter().zip(&at.y).map(|(e, y)| e * y).sum();
        }
        let start = embedded.iter().zip(distance.iter()).map(|(y, e)| y + e);
        *lost = *lost || !twin.follow(inputs, start, at);
        if *lost {
            return false;
        }
        let reached = distance.iter_mut().zip(&twin.position().y).zip(embedded.iter());
        reached.for_each(|((e, z), y)| *e = z - y);
        let differences = estimates.iter_mut().zip(twin.values()).zip(values);
        differences.for_each(|((estimate, other), value)| *estimate = other - value);
        estimates.iter().all(|e| e.is_finite())
    }
}
