//! Training of a dynamic reduced model from transient runs.
//!
//! Mass and constant damping are projected exactly. The points are selected for the forces along the modes at states of the runs, including viscosity
//! and the history of relaxing parts, which follow from the states by the time-stepping rule. Error bars are based on whole runs.

use super::basis::Basis;
use super::body_points::{BodyPoints, Place, PointForce};
use super::full_state::FullState;
use super::sampling::{Selection, select_for, stored};
use super::steps_of_runs::steps_of_runs;
use super::train::{Projected, assemble, bars, check_names, left_out, project};
use crate::math::vector::dot;
use crate::reduction::error::ReductionError;
use crate::reduction::forces::{block_forces, check_parts, unsupported};
use crate::reduction::inputs::{Input, signals};
use crate::reduction::model::{Bar, Origin, ReducedModel, TimeEstimate};
use crate::reduction::points::{Points, Sums};
use crate::reduction::running::dynamics::Dynamics;
use crate::reduction::running::twin::Twin;
use crate::scene::Scene;
use crate::solve::Integrator;
use crate::system::{At, Effect, EnergyRole, Rates};

/// Transient runs of a scene from rest, whose inputs are controlled signals, from which dynamic reduced models can be made.
pub struct TransientTraining<'a> {
    scene: &'a Scene,
    points: BodyPoints<'a>,
    inputs: Vec<Input>,
    /// States at the ends of the steps of each run
    runs: &'a [Vec<FullState>],
    names: Vec<String>,
    time: (Integrator, f64),
}

/// Largest number of states from which the modes are made.
const SNAPSHOTS: usize = 240;
/// Largest number of rows of the equations for the weights.
const MOST_ROWS: usize = 1200;
/// Smallest number of states from which the rows are taken.
const FEWEST_STATES: usize = 30;
/// Number of modes of the enriched model per mode of the model.
const ENRICHED: usize = 2;
/// Tolerance for the points of the enriched model, relative to that of the model \[–\].
const FINER: f64 = 0.1;
/// Remedy for a model that cannot run because of the mass of its modes.
const REMEDY: &str = "give every part of the body an inertia; where the body can move as a whole, as one that slides, the strains of its modes do not tell that motion from others: \
                      take fewer modes, hold the body, or take bdf2 or implicit_euler, which need no acceleration at the start";

/// Returns the integrator and the time step of a scene; refuses a scene with parts that have no reduced form in dynamics.
pub(in crate::reduction) fn check_in_time(scene: &Scene) -> Result<(Integrator, f64), ReductionError> {
    let time = steps_in_time(scene)?;
    let by_rates = |effect: &dyn Effect| {
        let is = |blocks: &crate::system::Blocks| std::ptr::eq(blocks, effect.blocks());
        let acts_at_points =
            scene.viscous.iter().any(|e| is(e.blocks())) || scene.relaxing.iter().any(|e| is(e.blocks()));
        effect.capabilities().linear_in_rates || acts_at_points
    };
    check_parts(scene, by_rates)?;
    Ok(time)
}

impl<'a> TransientTraining<'a> {
    /// Prepares a training from the states of training runs after each step, for models that provide the recorded columns `names`.
    ///
    /// # Errors
    ///
    /// [`ReductionError`]: parts of the scene without a reduced form, or runs that do not belong to the scene.
    pub fn new(scene: &'a Scene, runs: &'a [Vec<FullState>], names: &[String]) -> Result<Self, ReductionError> {
        let time = check_in_time(scene)?;
        check_names(scene, runs.iter().flatten(), names)?;
        let points = BodyPoints::of(scene)?;
        Ok(Self { scene, points, inputs: signals(scene, 0)?, runs, names: names.to_vec(), time })
    }

    /// Builds the model with this number of modes, as [`Training::model`](crate::reduction::Training::model) does, with error bars that hold for
    /// whole runs like those of `held_back`, which are not used for training; without such runs the model has no bars.
    ///
    /// # Errors
    ///
    /// The errors of [`Training::model`](crate::reduction::Training::model).
    pub fn model(
        &self,
        modes: usize,
        sampling: Option<f64>,
        held_back: &[Vec<FullState>],
    ) -> Result<ReducedModel, ReductionError> {
        let (mut model, basis) = self.without_estimate(modes, sampling, held_back)?;
        if held_back.is_empty() {
            return Ok(model);
        }
        let finer = sampling.map(|tolerance| FINER * tolerance);
        let (enriched, richer) = self.without_estimate(ENRICHED * modes, finer, held_back)?;
        let estimate = TimeEstimate {
            enriched: Box::new(enriched),
            embedding: self.embedding(&basis, &richer),
            bars: vec![Bar { factor: 1.0, floor: 0.0 }; model.quantities.len()],
            runs: held_back.len(),
            steps: held_back.iter().map(Vec::len).max().unwrap_or(0),
        };
        model.estimate_in_time = Some(estimate);
        let bars = calibrated(&model, held_back)?;
        model.estimate_in_time.iter_mut().for_each(|e| e.bars.clone_from(&bars));
        model.sound()
    }

    /// Returns the singular values of the displacements and of the pressures of the states, relative to the first.
    ///
    /// # Errors
    ///
    /// The errors of [`TransientTraining::model`].
    pub fn singular_values(&self) -> Result<(Vec<f64>, Vec<f64>), ReductionError> {
        let basis = Basis::of(self.scene, &self.points, &self.snapshots(), 1)?;
        Ok((basis.singular_values, basis.pressure_values))
    }

    /// Returns the steps of each run that are used, at most `most` in total.
    fn taken(&self, most: usize) -> Vec<Vec<usize>> {
        steps_of_runs(self.runs.iter().map(Vec::len), most)
    }

    /// Returns states of the runs, no more than needed.
    fn snapshots(&self) -> Vec<&[f64]> {
        let taken = self.taken(SNAPSHOTS);
        self.runs.iter().zip(&taken).flat_map(|(run, steps)| steps.iter().map(|&k| &run[k].x[..])).collect()
    }

    fn without_estimate(
        &self,
        modes: usize,
        sampling: Option<f64>,
        held_back: &[Vec<FullState>],
    ) -> Result<(ReducedModel, Basis), ReductionError> {
        let Self { scene, points, runs, time: (integrator, dt), .. } = self;
        let space = Projected::of(scene, points, &self.snapshots(), modes)?;
        let selection = match sampling {
            Some(tolerance) => {
                let forces = self.forces(&space)?.into_iter().map(Ok);
                select_for(points, &space.at_points, &space.basis, (forces, space.amplitudes), tolerance)?
            }
            None => Selection::all(points.weights().len()),
        };
        let mut model = assemble(
            (scene, points),
            &space,
            (&selection, &self.inputs, &self.names),
            (&mut runs.iter().flatten(), self.origin(held_back)),
        )?;
        let moving = &space.basis.modes[..space.basis.displacements];
        let matrix = |kinetic: bool| constant_matrix(scene, moving, kinetic);
        model.dynamics = Some(Dynamics {
            integrator: *integrator,
            dt: *dt,
            mass: matrix(true)?,
            damping: matrix(false)?,
            changes: self.changes(held_back),
            duration: *dt * runs.iter().chain(held_back).map(Vec::len).max().unwrap_or(0) as f64,
        });
        // For example a mass that is not positive
        match model.fault() {
            None => Ok((model, space.basis)),
            Some(fact) => Err(unsupported("the scene".into(), fact, REMEDY)),
        }
    }

    fn origin(&self, held_back: &[Vec<FullState>]) -> Origin {
        Origin {
            version: env!("CARGO_PKG_VERSION").into(),
            scene: self.scene.text.clone(),
            cells: self.scene.body.mesh.cell_count(),
            dofs: self.scene.system.dofs.free.len(),
            points: self.points.weights().len(),
            training: self.runs.len(),
            held_back: held_back.len(),
            ..Origin::default()
        }
    }

    /// Returns the largest change of each input per step over all runs.
    fn changes(&self, held_back: &[Vec<FullState>]) -> Vec<f64> {
        let of = |k: usize| {
            let range = self.inputs[k].range;
            let of_run = |run: &Vec<FullState>| {
                let values = std::iter::once(0.0_f64.clamp(range[0], range[1])).chain(run.iter().map(|s| s.inputs[k]));
                let values: Vec<f64> = values.collect();
                values.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max)
            };
            self.runs.iter().chain(held_back).map(of_run).fold(0.0, f64::max)
        };
        (0..self.inputs.len()).map(of).collect()
    }

    /// Returns the forces at all points for some of the states of the runs, in the space of a model.
    fn forces(&self, space: &Projected) -> Result<Vec<Vec<PointForce>>, ReductionError> {
        let Self { points, runs, time: (_, dt), .. } = self;
        let (n, modes) = (space.basis.displacements, space.basis.modes.len());
        let places: Vec<Place> = points.places().collect();
        let all = Selection::all(places.len());
        let mut parts = vec![];
        for ((part, kind), of) in points.kinds().zip(stored(points, &all, (&space.at_points, &space.basis), None)) {
            let sizes = crate::reduction::points::Sizes { displacements: n, pressures: modes - n, tests: 0 };
            let own: Vec<usize> = (0..places.len()).filter(|p| points.kind(&places[*p]) == (part, kind)).collect();
            parts.push((Points::new(&of, sizes)?.moving(&of.rates, *dt), own, Sums::new(sizes)));
        }
        let undefined = |e: crate::material::LawError| ReductionError::Law(e.to_string());
        let mut out = vec![];
        for (run, taken) in runs.iter().zip(self.taken((MOST_ROWS / modes).max(FEWEST_STATES))) {
            let fields: Vec<&[f64]> = run.iter().map(|s| &s.x[..]).collect();
            let mut last = vec![0.0; modes];
            let mut memories: Vec<Vec<f64>> = parts.iter().map(|(p, _, _)| vec![0.0; p.memory()]).collect();
            for (step, y) in project(points, &space.basis, &fields).into_iter().enumerate() {
                let is_taken = taken.contains(&step);
                let mut forces: Vec<PointForce> = vec![([0.0; 9], 0.0); if is_taken { places.len() } else { 0 }];
                for ((part, own, sums), memory) in parts.iter_mut().zip(&mut memories) {
                    part.begin(&last[..n], memory);
                    if is_taken {
                        let found = part.forces(&y, sums).map_err(undefined)?;
                        own.iter().zip(found).for_each(|(&p, force)| forces[p] = force);
                    }
                    let mut next = memory.clone();
                    part.advance(&y[..n], memory, &mut next, sums).map_err(undefined)?;
                    *memory = next;
                }
                if is_taken {
                    out.push(forces);
                }
                last = y;
            }
        }
        Ok(out)
    }

    /// Returns the modes of a basis in terms of those of a richer one that contains them \[coordinates of the richer space × coordinates of the
    /// poorer one\].
    fn embedding(&self, basis: &Basis, richer: &Basis) -> Vec<f64> {
        let fields: Vec<&[f64]> = basis.modes.iter().map(|m| &m[..]).collect();
        let columns = project(&self.points, richer, &fields);
        (0..richer.modes.len()).flat_map(|row| columns.iter().map(move |column| column[row])).collect()
    }
}

/// Returns the integrator and the time step of a scene; an error if they change, or do not allow a model with the same steps.
fn steps_in_time(scene: &Scene) -> Result<(Integrator, f64), ReductionError> {
    let refuse = |what: &str, why: &str, remedy: &str| Err(unsupported(what.into(), why, remedy));
    let Some(first) = scene.spans.first() else {
        return refuse("a scene without stages", "it has no step", "give it a stage");
    };
    let (integrator, dt) = (first.integrator, first.dt);
    if integrator.is_static() {
        return refuse("a static stage", "it has no time", "give it a dynamic integrator, or leave `motion` out");
    }
    if integrator.is_linearised() {
        let why = "it accepts steps that are no solutions";
        return refuse(&format!("the integrator {}", integrator.name()), why, "take implicit_euler");
    }
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b;
    if scene.spans.iter().any(|s| s.integrator != integrator || !near(s.dt, dt)) {
        return refuse("a scene whose stages differ", "a model has one integrator and one step", "give it one stage");
    }
    if scene.spans.iter().any(|s| !near(s.end - s.start, s.steps() as f64 * dt)) {
        return refuse("a stage that ends within a step", "a model has one step", "make the duration a multiple of dt");
    }
    if scene.spec.numerics.time_error.is_some() {
        return refuse("numerics.time_error", "a model has one step", "leave it out, and take a short dt");
    }
    if scene.spec.start.is_some() {
        return refuse("[start]", "a model begins at rest", "leave it out");
    }
    Ok((integrator, dt))
}

/// Returns Vᵀ M V of the inertia, or Vᵀ C V of constant damping matrices, for displacement modes.
fn constant_matrix(scene: &Scene, modes: &[Vec<f64>], kinetic: bool) -> Result<Vec<f64>, ReductionError> {
    let n = modes.len();
    let mut out = vec![0.0; n * n];
    for effect in scene.system.effects.iter().filter(|e| e.capabilities().linear_in_rates) {
        if (effect.role() == EnergyRole::Kinetic) != kinetic {
            continue;
        }
        let rest = scene.system.rest();
        for (j, mode) in modes.iter().enumerate() {
            let (v, a) = if kinetic { (&rest.x, mode) } else { (mode, &rest.x) };
            let rates = Rates { cv: 1.0, ca: 1.0 };
            let (x, history) = (&rest.x, &[][..]);
            let force = block_forces(&**effect, &At { t: 0.0, dt: 1.0, x, v, a, old: x, history, inputs: &[], rates })?;
            modes.iter().enumerate().for_each(|(i, test)| out[i * n + j] += dot(test, &force));
        }
    }
    // The matrices are symmetric except for rounding
    let symmetric = |k: usize| 0.5 * (out[k] + out[k % n * n + k / n]);
    Ok((0..n * n).map(symmetric).collect())
}

/// Error and estimate of each quantity at a state.
type StateErrors = Vec<(f64, f64)>;

/// Returns the errors of the model in whole runs that were not used for training, and their estimates: \[runs\]\[steps × quantities\].
pub fn errors_in_time(model: &ReducedModel, runs: &[Vec<FullState>]) -> Result<Vec<Vec<StateErrors>>, ReductionError> {
    let mut twin = Twin::new(model.clone())?;
    let mut of_run = |run: &Vec<FullState>| {
        twin.reset();
        // After a failed step the time of the model is no longer that of the run
        let mut failed = false;
        let step = |state: &FullState| {
            failed = failed || twin.step(&state.inputs).is_err();
            let pairs = state.values.iter().zip(twin.values()).zip(twin.estimates());
            let one = |((full, value), estimate): ((&f64, &f64), &f64)| {
                if failed { (f64::INFINITY, 0.0) } else { (full - value, *estimate) }
            };
            pairs.map(one).collect()
        };
        run.iter().map(step).collect()
    };
    Ok(runs.iter().map(&mut of_run).collect())
}

/// Returns error bars that hold at every step of runs that were held back: the runs, not their steps, are drawn independently.
fn calibrated(model: &ReducedModel, held_back: &[Vec<FullState>]) -> Result<Vec<Bar>, ReductionError> {
    let all = errors_in_time(model, held_back)?;
    let failed = all.iter().filter(|run| run.iter().flatten().any(|(error, _)| !error.is_finite())).count();
    if failed > left_out(all.len()) {
        return Err(ReductionError::NoEquilibrium { failed, states: all.len() });
    }
    let samples: Vec<&[_]> = all.iter().map(Vec::as_slice).collect();
    Ok(bars(model, &samples))
}
