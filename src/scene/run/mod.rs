//! One run of a scene and its result. This module neither prints nor writes files.

pub(super) mod checkpoint;
mod energy_balance;
pub(super) mod energy_growth;
pub(super) mod follower;
pub(super) mod identity;
pub(super) mod options;
pub(super) mod start;

use super::build::Scene;
use super::build::rules::against_iterations;
use super::control::{ControlError, ControllerRecord, Fired};
use super::linear_solver::{LinearSpec, LinearWork};
use super::notes::collapse::{CollapsedCavity, collapsed};
use super::notes::sunk::{SunkenFacet, sunken};
use super::parts::constraints::{CableEvent, pulling};
use super::record::fields::fields;
use super::record::output::{Field, FieldSpec};
use super::record::recorded::{columns, recorders};
use super::record::recorder::{Energies, Moment, Recorder};
use super::record::stretch;
use super::record::stretch::PointStretch;
use super::sensitivity::columns::Sensitivities;
use crate::effect::contact::Counts;
use crate::math::linear::{Linear, Method};
use crate::math::multigrid::Places;
use crate::math::signal::Clock;
use crate::math::stopwatch::Spent;
use crate::math::tensor::Vec3;
use crate::solve::{Driver, Findings, NewtonSettings, NonlinearSolver, Status, StepSettings, Totals, set_second_field};
use crate::system::{At, Cost, State};
use checkpoint::{Checkpoint, Snapshot};
use energy_growth::EnergyFromNothing;
use follower::RunRecorder;
use options::{RunOptions, Saved};
use start::{place_in_motion, set_start};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Result of a run: rows on the time grid, the state farthest from rest, and the cost.
pub struct Run {
    pub columns: Vec<String>,
    /// Rows \[rows × columns\] on the time grid, and after every dynamic step if `time_error` controls their length; the first column is t_s
    pub rows: Vec<Vec<f64>>,
    /// Rows that are written, by `output.series`: all, or those that are due and the last one
    pub written: Vec<usize>,
    /// Values of the prescribed signals \[rows × signals\]
    pub signals: Vec<Vec<f64>>,
    /// Memory of the recorders, in their order \[rows × numbers\]
    pub memories: Vec<Vec<f64>>,
    /// The `[[event]]`s that happened
    pub events: Vec<Fired>,
    /// The controllers that have set signals, if they have an identity
    pub controllers: Vec<ControllerRecord>,
    pub status: Status,
    /// Error of a signal, of the controller or of the saved state to continue from, which ended the run
    pub failure: Option<ControlError>,
    pub totals: Totals,
    pub findings: Findings,
    /// Energy without work, if it exceeds a tenth of the energy of a dynamic stage
    pub energy_from_nothing: Option<EnergyFromNothing>,
    /// Evaluations of each effect and constraint
    pub costs: Vec<Cost>,
    pub assembly: Duration,
    pub factorisation: Duration,
    pub factorisations: usize,
    /// Number of these factorisations that were of shifted tangents
    pub shifted_factorisations: usize,
    /// Iterations of Newton's method, including those of steps that were not accepted
    pub tried_iterations: usize,
    pub solve: Duration,
    /// Time spent on the forces on contact points in corrections
    pub contact_forces: Duration,
    /// Number of right-hand sides solved for
    pub solves: usize,
    pub factor_nnz: usize,
    /// Additions and multiplications of one factorisation
    pub factor_flops: f64,
    /// How linear systems were solved
    pub linear: LinearWork,
    pub dofs: usize,
    /// The state farthest from rest
    pub peak: Snapshot,
    /// The last accepted state
    pub last: State,
    /// Saved states that the options requested, in order of time and each with its label, if no `on_save` received them
    pub saved: Vec<Saved>,
    /// Events in which cables went slack or taut, or reached the limit of their drive
    pub cable_events: Vec<CableEvent>,
    /// Cavities whose walls have passed through each other
    pub collapsed: Vec<CollapsedCavity>,
    /// Facets that lie inside an obstacle between their contact points, at the end or farthest from rest
    pub sunken: Vec<SunkenFacet>,
    /// Name and counts of each contact
    pub contacts: Vec<(String, Counts)>,
    /// The cables that pulled when the run could not continue, and a remedy
    pub pulling: Option<String>,
    /// Derivatives of the rows, if the options requested them
    pub sensitivities: Option<Sensitivities>,
}

impl Run {
    /// Values of a recorded column, one per row; `None` if no column has this name.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let k = self.columns.iter().position(|c| c == name)?;
        Some(self.rows.iter().map(|row| row[k]).collect())
    }

    /// The saved state with this label, such as `0.5s` or `end`; `None` if there is no such state.
    pub fn checkpoint(&self, label: &str) -> Option<&Checkpoint> {
        self.saved.iter().find(|(known, _)| known == label).map(|(_, checkpoint)| checkpoint)
    }

    /// The time spent on derivatives, which does not count as cost of the run.
    pub fn spent_on_derivatives(&self) -> Spent {
        self.sensitivities.as_ref().map(|found| found.spent).unwrap_or_default()
    }

    /// The time without the parts that do not count as cost of a run: derivatives, and the time spent `elsewhere`, such as on the answers of a controller and
    /// on writing fields.
    pub fn own_time(&self, spent: Spent, elsewhere: Spent) -> Spent {
        spent - self.spent_on_derivatives() - elsewhere
    }
}

impl Scene {
    /// The state from which a run starts.
    pub fn start(&self) -> State {
        let mut state = self.system.rest();
        for body in &self.rigids {
            for (node, v) in body.frame.nodes.iter().zip(body.start) {
                state.v[3 * *node as usize..3 * *node as usize + 3].copy_from_slice(v.as_slice());
            }
        }
        if let Some(start) = &self.spec.start {
            set_start(start, (&self.body.mesh, &self.regions), &self.system, &mut state);
        }
        self.in_place(state)
    }

    /// A state before the first step, in which prescribed nodes are in place and in motion if the first stage is dynamic. A static stage moves them there. The
    /// pressures correspond to the positions of the nodes.
    pub(super) fn in_place(&self, mut state: State) -> State {
        let is_dynamic = self.spans.first().is_some_and(|first| !first.integrator.is_static());
        if is_dynamic {
            place_in_motion(&self.system, &mut state);
        }
        // Without pressures if a law is not defined there, which stops the first step
        _ = set_second_field(&self.system, &mut state);
        if is_dynamic {
            self.system.begin(&mut state);
        }
        state
    }

    /// The fields of a state, in the order of `what`; for a stress one at the nodes and one in the cells, see [`Field`].
    pub fn fields(&self, state: &State, what: &[FieldSpec]) -> Vec<Field> {
        fields(self, state, what)
    }

    /// Values of the prescribed signals at a state.
    pub fn signal_values(&self, state: &State) -> Vec<f64> {
        let now: Clock = state.clock();
        self.signals.iter().map(|s| s.signal.at(now)).collect()
    }

    /// The choice between the direct and the iterative method.
    pub fn method(&self) -> Method {
        let numerics = &self.spec.numerics;
        let linear = match numerics.linear {
            LinearSpec::Auto => Linear::Auto,
            LinearSpec::Direct => Linear::Direct,
            LinearSpec::Iterative => Linear::Iterative,
        };
        let places = || Arc::new(Places { dofs: self.system.dofs.free.clone(), points: self.points.clone() });
        let places = against_iterations(&self.spec, &self.spans).map_or_else(|| Ok(places()), Err);
        Method { linear, factor_memory: numerics.factor_memory.0, places }
    }

    /// Runs all stages.
    pub fn run(&self) -> Run {
        self.run_with(RunOptions::default())
    }

    /// Runs all stages with optional callbacks, a controller, derivatives, a saved state to start from, or states to be saved. A saved state of another scene,
    /// mesh or controller ends the run before its first step, with the reason in [`Run::failure`].
    pub fn run_with(&self, mut options: RunOptions) -> Run {
        let refused = options.restart.as_ref().and_then(|restart| {
            let controller = options.controller.as_deref().filter(|_| !options.other_controller);
            restart.check(self).and_then(|()| controller.map_or(Ok(()), |c| restart.check_controller(self, c))).err()
        });
        options.restart = options.restart.filter(|_| refused.is_none());
        let mut driver = self.driver();
        let bytes = driver.steps.solver.linear.factor.bytes() as u64;
        let admitted = options.on_sized.take().is_none_or(|on_sized| on_sized(bytes));
        let limit = &mut driver.steps.solver.equations.limit;
        limit.stop.clone_from(&options.stop);
        limit.iterations_left = options.most_iterations;
        driver.steps.solver.on_iteration.clone_from(&options.on_iteration);
        driver.steps.settings.diagnosis = !options.undiagnosed;
        let from = options.restart.as_ref().map(|checkpoint| checkpoint.position);
        if let Some(checkpoint) = &options.restart {
            driver.resume(checkpoint.memory.clone());
        }
        let mut recorder = RunRecorder::new(self, options, refused);
        let mut state = recorder.checkpoint.state.clone();
        let status = match (&recorder.failure, &recorder.not_finite) {
            (Some(_), _) => Status::Interrupted { t: state.t },
            (None, Some(_)) => Status::Converged,
            _ if !admitted => Status::Interrupted { t: state.t },
            // A stop that ended the run before it was saved still ends it
            _ if recorder.checkpoint.control.stopped => Status::Converged,
            _ => driver.run_spans(&self.spans, from, &mut state, &mut recorder),
        };
        let status = match recorder.not_finite.take() {
            Some(column) => Status::NotFinite { t: recorder.last_time(), column },
            None => status,
        };
        let (checkpoint, saved, options, failure) = recorder.finish(&status);
        let stuck =
            matches!(status, Status::StepTooSmall { .. } | Status::Inverted { .. } | Status::NoEquilibrium { .. });
        let pulling = stuck.then(|| pulling(&self.cables, &state));
        let columns = self.columns();
        let enclosing = self.cavities.iter().filter(|cavity| cavity.encloses);
        let sensitivities = options.sensitivities.map(|recorder| recorder.finish(&columns, &checkpoint.rows));
        let (peak, mesh) = (&checkpoint.peak, &self.body.mesh);
        let sunken = sunken(mesh, &self.contacts, &[(state.t, &state.x), (peak.t, &peak.x)]);
        let NonlinearSolver { equations, linear, iterations, .. } = &driver.steps.solver;
        let (factor, sums) = (&linear.factor, &equations.sums);
        Run {
            sunken,
            collapsed: collapsed(enclosing.map(|c| &c.name[..]), &columns, &checkpoint.rows),
            columns,
            written: self.written(&checkpoint.rows),
            rows: checkpoint.rows,
            signals: checkpoint.signals,
            memories: checkpoint.memories,
            events: checkpoint.control.log,
            controllers: checkpoint.control.controllers,
            status,
            failure,
            totals: driver.totals,
            findings: driver.findings,
            energy_from_nothing: checkpoint.balance.growth.finding(),
            costs: by_name(&sums.costs),
            assembly: equations.assembly_time,
            factorisation: factor.factor_time,
            factorisations: factor.count,
            shifted_factorisations: linear.shifted,
            tried_iterations: *iterations,
            solve: factor.solve_time,
            contact_forces: linear.contact_forces,
            solves: factor.solves,
            factor_nnz: factor.nnz(),
            factor_flops: factor.flops(),
            linear: LinearWork::of(factor),
            dofs: self.system.dofs.free.len(),
            peak: checkpoint.peak,
            contacts: self.contacts.iter().map(|c| (c.name.clone(), c.counts(&sums.caches))).collect(),
            pulling: pulling.flatten(),
            last: state,
            saved,
            cable_events: checkpoint.cables.events,
            sensitivities,
        }
    }

    /// The driver of a run, with the settings of `[numerics]`.
    pub(super) fn driver(&self) -> Driver<'_> {
        let begun = Instant::now();
        let n = &self.spec.numerics;
        let settings = NewtonSettings {
            tolerance: n.tolerance,
            accuracy: n.accuracy,
            max_iterations: n.max_iterations,
            line_search: n.line_search,
            reuse_factor: n.reuse_factor,
            reuse_threshold: n.reuse_threshold,
            projection: n.projection,
        };
        let mut solver = NonlinearSolver::with_method(self.method(), &self.system, settings, self.body.mesh.diagonal());
        solver.linear.points.clone_from(&self.points);
        let steps = StepSettings {
            cuts: n.cuts,
            extrapolate: n.extrapolate,
            time_error: n.time_error.map(|l| l.0),
            diagnosis: true,
        };
        let mut driver = Driver::new(&self.system, solver, steps);
        driver.steps.points = &self.points;
        let budget = n.time_budget.and_then(|b| Duration::try_from_secs_f64(b.0).ok());
        let left = budget.map(|budget| budget.saturating_sub(self.set_up));
        driver.steps.solver.equations.limit.deadline = left.and_then(|left| begun.checked_add(left));
        driver
    }

    fn written(&self, rows: &[Vec<f64>]) -> Vec<usize> {
        let time = |k: usize| rows[k][0];
        let due = |k: &usize| {
            let schedule = self.spec.output.series.as_ref();
            *k + 1 == rows.len() || schedule.is_none_or(|s| s.due(k.checked_sub(1).map(time), time(*k)))
        };
        (0..rows.len()).filter(due).collect()
    }

    /// All recorders, in the order of the columns.
    pub fn recorders(&self) -> impl Iterator<Item = &dyn Recorder> {
        recorders(&self.probes, &self.cables, &self.cavities, &self.rigids, &self.contacts)
    }

    /// Names of the recorded columns.
    pub fn columns(&self) -> Vec<String> {
        columns(self.recorders())
    }

    /// Memory of the recorders before the first state.
    pub(super) fn memory(&self) -> Vec<f64> {
        self.recorders().flat_map(|r| r.memory()).collect()
    }

    /// Updates the memory of the recorders with an accepted state.
    pub(super) fn remember(&self, state: &State, mut memory: &mut [f64]) {
        for recorder in self.recorders() {
            let (own, rest) = memory.split_at_mut(recorder.memory().len());
            recorder.remember(&self.body, state, own);
            memory = rest;
        }
    }

    /// The recorders, each with its memory.
    pub fn with_memories<'m>(&'m self, mut memory: &'m [f64]) -> impl Iterator<Item = (&'m dyn Recorder, &'m [f64])> {
        self.recorders().map(move |recorder| {
            let (own, rest) = memory.split_at(recorder.memory().len());
            memory = rest;
            (recorder, own)
        })
    }

    pub(super) fn record(
        &self,
        state: &State,
        step: Option<&At>,
        residual: &[f64],
        energies: Energies,
        iterations: usize,
        memory: &[f64],
    ) -> Vec<f64> {
        let moment = |memory| Moment { body: &self.body, state, step, residual, energies, memory };
        let values = self.with_memories(memory).flat_map(|(r, memory)| r.record(&moment(memory)));
        std::iter::once(state.t).chain(values).chain(std::iter::once(iterations as f64)).collect()
    }

    /// Largest principal stretch at each node: the mean over the surrounding cells, weighted by their volume.
    pub fn nodal_stretch(&self, x: &[f64]) -> Vec<f64> {
        let mesh = &self.body.mesh;
        let mut sums = vec![(0.0, 0.0); mesh.points.len()];
        for PointStretch { cell, weight, largest, .. } in stretch::points(&self.elastic, x) {
            for &node in mesh.cell(cell as usize) {
                let sum: &mut (f64, f64) = &mut sums[node as usize];
                *sum = (sum.0 + weight * largest, sum.1 + weight);
            }
        }
        sums.into_iter().map(|(sum, weight)| if weight > 0.0 { sum / weight } else { 1.0 }).collect()
    }

    /// Largest squared displacement of a node \[m²\].
    pub(super) fn largest_squared_displacement(&self, x: &[f64]) -> f64 {
        let nodes = x[..3 * self.body.mesh.points.len()].chunks_exact(3);
        nodes.map(|u| u[0] * u[0] + u[1] * u[1] + u[2] * u[2]).fold(0.0, f64::max)
    }

    /// Deformed positions \[m\].
    pub fn positions(&self, x: &[f64]) -> Vec<Vec3> {
        let displaced = |(k, p): (usize, &Vec3)| p + Vec3::from_column_slice(&x[3 * k..3 * k + 3]);
        self.body.mesh.points.iter().enumerate().map(displaced).collect()
    }
}

/// Times of the evaluations, with one entry for consecutive constraints of the same name.
fn by_name(costs: &[Cost]) -> Vec<Cost> {
    let mut out: Vec<Cost> = Vec::new();
    for cost in costs {
        match out.last_mut() {
            Some(last) if last.name == cost.name => last.time += cost.time,
            _ => out.push(cost.clone()),
        }
    }
    out
}
