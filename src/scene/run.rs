//! One run of a scene: steps, records, energies. Neither prints nor writes.

use super::build::Scene;
use super::cable_record::{CableEvent, pulling};
use super::checkpoint::Checkpoint;
use super::control::{ControlError, Fired, Opening};
use super::linear::LinearWork;
use super::probe::{Energies, Moment, columns, largest_stretch, record_cavity};
use super::run_options::RunOptions;
use super::sensitivities::Recorder;
use crate::effect::contact::Counts;
use crate::math::tensor::Vec3;
use crate::solve::{
    Findings, Integrator, Newton, NewtonSettings, Status, Step, StepSettings, Stepper, Totals, initial_acceleration_by,
};
use crate::system::{At, Cost, State};
use std::time::{Duration, Instant};

/// Where a run stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    pub t: f64,
    pub end: f64,
}

/// Result of a run: rows on the time grid, the state of largest load, and what it cost.
pub struct Run {
    pub columns: Vec<String>,
    /// \[rows × columns\] on the time grid, and after every dynamic step where `time_error` sets their length; the first column is
    /// t_s
    pub rows: Vec<Vec<f64>>,
    /// Rows that are written, by `output.series`: all, or those that are due and the last one
    pub written: Vec<usize>,
    /// \[rows × signals\] what was prescribed
    pub signals: Vec<Vec<f64>>,
    /// The `[[event]]`s that happened
    pub events: Vec<Fired>,
    pub status: Status,
    /// Why it could not be steered any further
    pub failure: Option<ControlError>,
    pub totals: Totals,
    pub findings: Findings,
    /// Evaluations of each effect and constraint
    pub costs: Vec<Cost>,
    pub assembly: Duration,
    pub factorisation: Duration,
    pub factorisations: usize,
    pub solve: Duration,
    /// Right sides solved for
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
    /// Cables that went slack, taut, or to the limit of their drive
    pub cable_events: Vec<CableEvent>,
    /// Name and counts of each contact
    pub contacts: Vec<(String, Counts)>,
    /// Which cables pulled where the run could not go on, and what to do
    pub pulling: Option<String>,
}

/// A state to be drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    pub t: f64,
    pub x: Vec<f64>,
}

impl Scene {
    /// Runs all stages. `watch` is called after each accepted step; false stops the run. `states` receives each state on
    /// the time grid.
    pub fn run(&self, watch: &mut dyn FnMut(Progress) -> bool, states: &mut dyn FnMut(&State)) -> Run {
        self.steer(RunOptions::default(), watch, states)
    }

    /// [`Scene::run`] from a saved state, with a controller, and with states to be saved.
    pub fn steer(
        &self,
        options: RunOptions,
        watch: &mut dyn FnMut(Progress) -> bool,
        states: &mut dyn FnMut(&State),
    ) -> Run {
        self.follow(options, watch, states, None)
    }

    /// The same, with derivatives where there is a recorder for them.
    pub(super) fn follow(
        &self,
        mut options: RunOptions,
        watch: &mut dyn FnMut(Progress) -> bool,
        states: &mut dyn FnMut(&State),
        sensitivities: Option<&mut Recorder>,
    ) -> Run {
        let n = &self.spec.numerics;
        let newton = NewtonSettings {
            tolerance: n.tolerance,
            max_iterations: n.max_iterations,
            line_search: n.line_search,
            reuse_factor: n.reuse_factor,
            reuse_threshold: n.reuse_threshold,
            projection: n.projection,
        };
        let mut newton = Newton::by(self.method(), &self.system, newton, self.body.mesh.diagonal());
        newton.points.clone_from(&self.points);
        let steps = StepSettings { cuts: n.cuts, extrapolate: n.extrapolate, time_error: n.time_error.map(|l| l.0) };
        let mut stepper = Stepper::new(&self.system, newton, steps);
        stepper.points = &self.points;
        let budget = n.time_budget.and_then(|b| Duration::try_from_secs_f64(b.0).ok());
        stepper.deadline = budget.and_then(|b| Instant::now().checked_add(b));
        let mut failure = None;
        let mut checkpoint = match options.from.take() {
            Some(checkpoint) => {
                stepper.resume(checkpoint.memory.clone());
                checkpoint
            }
            None => {
                let (checkpoint, outcome) = Checkpoint::new(self);
                failure = outcome.err();
                states(&checkpoint.state);
                checkpoint
            }
        };
        if let (Some(controller), None) = (&mut options.controller, &failure) {
            let (columns, signals) = (self.columns(), self.controls.controlled());
            let Checkpoint { state, control, .. } = &checkpoint;
            let opening = Opening { columns: &columns, signals: &signals, t: state.t, memory: &control.controller };
            failure = controller.begin(&opening).err();
        }
        let status = match failure {
            Some(_) => Status::Interrupted { t: checkpoint.state.t },
            None => self.all_stages(
                &mut checkpoint,
                &mut stepper,
                &mut options,
                (&mut failure, sensitivities),
                watch,
                states,
            ),
        };
        if let (Some(controller), Some(row)) = (&mut options.controller, checkpoint.rows.last()) {
            controller.end(row, status.name());
        }
        let stuck =
            matches!(status, Status::StepTooSmall { .. } | Status::Inverted { .. } | Status::NoEquilibrium { .. });
        let pulling = stuck.then(|| pulling(&self.cables, &checkpoint.state));
        let Newton { factor, sums, assembly_time, .. } = &stepper.newton;
        Run {
            columns: self.columns(),
            written: self.written(&checkpoint.rows),
            rows: checkpoint.rows,
            signals: checkpoint.signals,
            events: checkpoint.control.log,
            status,
            failure,
            totals: stepper.totals,
            findings: stepper.findings,
            costs: by_name(&sums.costs),
            assembly: *assembly_time,
            factorisation: factor.factor_time,
            factorisations: factor.count,
            solve: factor.solve_time,
            solves: factor.solves,
            factor_nnz: factor.nnz(),
            factor_flops: factor.flops(),
            linear: LinearWork::of(factor),
            dofs: self.system.dofs.free.len(),
            peak: checkpoint.peak,
            contacts: self.contacts.iter().map(|c| (c.name.clone(), c.counts(&sums.caches))).collect(),
            pulling: pulling.flatten(),
            last: checkpoint.state,
            cable_events: checkpoint.cables.events,
        }
    }

    /// From where `checkpoint` is to the end, or to where it stops.
    fn all_stages(
        &self,
        checkpoint: &mut Checkpoint,
        stepper: &mut Stepper,
        options: &mut RunOptions,
        (failure, mut sensitivities): (&mut Option<ControlError>, Option<&mut Recorder>),
        watch: &mut dyn FnMut(Progress) -> bool,
        states: &mut dyn FnMut(&State),
    ) -> Status {
        let end = self.spans.last().map_or(0.0, |s| s.end);
        // The last point of the grid, for a run that ends between two.
        let mut kept = None;
        while checkpoint.span < self.spans.len() {
            let span = self.spans[checkpoint.span];
            if checkpoint.step == 0 && !checkpoint.decided {
                if span.integrator.needs_initial_acceleration() {
                    match initial_acceleration_by(self.method(), &self.system, &checkpoint.state) {
                        Ok(a) => checkpoint.state.a = a,
                        Err(why) => {
                            options.save_end(kept.as_ref());
                            return Status::StepTooSmall { t: checkpoint.state.t, why };
                        }
                    }
                }
                stepper.begin(span.integrator, &mut checkpoint.state);
                if let Some(sensitivities) = &mut sensitivities {
                    sensitivities.begin(span.integrator, &checkpoint.state);
                }
            }
            while checkpoint.step < span.steps() {
                let goal = span.point(checkpoint.step + 1);
                match self.decide(checkpoint, stepper, options, Some(goal)) {
                    Ok(true) => {
                        options.save_end(Some(checkpoint));
                        return Status::Converged;
                    }
                    Ok(false) => {}
                    Err(why) => {
                        *failure = Some(why);
                        options.save_end(kept.as_ref());
                        return Status::Interrupted { t: checkpoint.state.t };
                    }
                }
                if options.at_end {
                    kept = Some(checkpoint.clone());
                }
                let Checkpoint { state, balance, cables, rows, signals, peak, .. } = &mut *checkpoint;
                let every = stepper.settings.time_error.is_some() && !span.integrator.is_static();
                let mut iterations = 0;
                let mut accepted = |past: &State, now: &State, newton: &Newton, on_grid: bool| {
                    balance.book(&self.system, past, now, newton);
                    cables.note(&self.cables, now);
                    let recorded = on_grid || every;
                    if let Some(sensitivities) = &mut sensitivities {
                        sensitivities.step(span.integrator, past, now, recorded);
                    }
                    iterations += newton.iterations;
                    if recorded {
                        let since_last = std::mem::take(&mut iterations);
                        let dt = now.t - past.t;
                        let step = Step { system: &self.system, integrator: span.integrator, past, dt };
                        let at = step.at(now);
                        rows.push(self.record(now, Some(&at), &newton.sums.r, balance.energies, since_last));
                        signals.push(self.signal_values(now));
                        if on_grid {
                            states(now);
                        }
                        if self.size(&now.x) > self.size(&peak.x) {
                            *peak = Snapshot { t: now.t, x: now.x.clone() };
                        }
                    }
                    watch(Progress { t: now.t, end })
                };
                let (status, steps) = match span.integrator {
                    // Its points are its own: nothing is decided in between
                    Integrator::ArcLength { max_steps } => {
                        (stepper.trace(span, max_steps, state, &mut accepted), span.steps())
                    }
                    _ => (stepper.advance(span, state, goal, &mut accepted), 1),
                };
                if status != Status::Converged {
                    options.save_end(kept.as_ref());
                    return status;
                }
                (checkpoint.step, checkpoint.decided) = (checkpoint.step + steps, false);
            }
            (checkpoint.span, checkpoint.step) = (checkpoint.span + 1, 0);
        }
        if let Err(why) = self.decide(checkpoint, stepper, options, None) {
            *failure = Some(why);
        }
        options.save_end(Some(checkpoint));
        Status::Converged
    }

    /// What happens at a point of the grid, unless it has happened; true to end the run here.
    fn decide(
        &self,
        checkpoint: &mut Checkpoint,
        stepper: &Stepper,
        options: &mut RunOptions,
        next: Option<f64>,
    ) -> Result<bool, ControlError> {
        if std::mem::replace(&mut checkpoint.decided, true) {
            return Ok(false);
        }
        let Checkpoint { state, control, rows, .. } = &mut *checkpoint;
        let row = rows.last().expect("the first row is the state at rest");
        let controller = options.controller.as_deref_mut();
        let orders = self.controls.decide(control, state, row, next, controller)?;
        if options.wants_states() {
            checkpoint.memory = stepper.memory();
            options.save(checkpoint, orders.save);
        }
        Ok(orders.stop)
    }

    fn written(&self, rows: &[Vec<f64>]) -> Vec<usize> {
        let time = |k: usize| rows[k][0];
        let due = |k: &usize| {
            let schedule = self.spec.output.series.as_ref();
            *k + 1 == rows.len() || schedule.is_none_or(|s| s.due(k.checked_sub(1).map(time), time(*k)))
        };
        (0..rows.len()).filter(due).collect()
    }

    /// Names of the recorded columns.
    pub fn columns(&self) -> Vec<String> {
        columns(&self.probes, &self.cables, &self.cavities, (&self.rigids, &self.contacts))
    }

    pub(super) fn record(
        &self,
        state: &State,
        step: Option<&At>,
        residual: &[f64],
        energies: Energies,
        iterations: usize,
    ) -> Vec<f64> {
        let moment = Moment { state, residual, energies, scene: self };
        let probes = self.probes.iter().flat_map(|p| p.record(&moment));
        let cables = self.cables.iter().flat_map(|c| c.record(state));
        let cavities = self.cavities.iter().flat_map(|c| record_cavity(c, state));
        let rigids = self.rigids.iter().flat_map(|b| b.record(&state.x));
        let contacts = rigids.chain(self.contacts.iter().flat_map(|c| c.record(&state.x, step)));
        let last = std::iter::once(iterations as f64);
        std::iter::once(state.t).chain(probes).chain(cables).chain(cavities).chain(contacts).chain(last).collect()
    }

    /// Largest principal stretch at each node: mean over the cells there, weighted with their volume.
    pub fn nodal_stretch(&self, x: &[f64]) -> Vec<f64> {
        let mesh = &self.body.mesh;
        let mut sums = vec![(0.0, 0.0); mesh.points.len()];
        for (cell, points) in self.elastic.iter().flat_map(|e| e.deformation(x)) {
            for (weight, f) in points {
                let stretch = largest_stretch(&f);
                for &node in mesh.cell(cell as usize) {
                    let sum: &mut (f64, f64) = &mut sums[node as usize];
                    *sum = (sum.0 + weight * stretch, sum.1 + weight);
                }
            }
        }
        sums.into_iter().map(|(sum, weight)| if weight > 0.0 { sum / weight } else { 1.0 }).collect()
    }

    /// Largest squared displacement of a node \[m²\].
    fn size(&self, x: &[f64]) -> f64 {
        let nodes = x[..3 * self.body.mesh.points.len()].chunks_exact(3);
        nodes.map(|u| u[0] * u[0] + u[1] * u[1] + u[2] * u[2]).fold(0.0, f64::max)
    }

    /// Deformed positions \[m\].
    pub fn positions(&self, x: &[f64]) -> Vec<Vec3> {
        let displaced = |(k, p): (usize, &Vec3)| p + Vec3::from_column_slice(&x[3 * k..3 * k + 3]);
        self.body.mesh.points.iter().enumerate().map(displaced).collect()
    }
}

/// Times of the evaluations, one entry for consecutive constraints of one name.
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
