//! One run of a scene: steps, records, energies. Neither prints nor writes.

use super::build::Scene;
use super::cable_record::{CableLog, Event, pulling};
use super::probe::{Energies, Moment, cavity_columns, largest_stretch, record_cavity};
use super::slopes::Recorder;
use crate::math::tensor::Vec3;
use crate::solve::{Findings, Newton, NewtonSettings, Status, StepSettings, Stepper, Totals, initial_acceleration};
use crate::system::{At, Cost, Role, State, System, Want};
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
    /// [rows × columns], the first column is t_s
    pub rows: Vec<Vec<f64>>,
    pub status: Status,
    pub totals: Totals,
    pub findings: Findings,
    /// Name and time of each effect and constraint
    pub costs: Vec<(String, Duration)>,
    pub assembly: Duration,
    pub factorisation: Duration,
    pub factorisations: usize,
    pub solve: Duration,
    pub factor_nnz: usize,
    pub dofs: usize,
    /// The state farthest from rest
    pub peak: Snapshot,
    /// The last accepted state
    pub last: State,
    /// Cables that went slack, taut, or to the limit of their drive
    pub events: Vec<Event>,
    /// Which cables pulled where the run could not go on, and what to do
    pub pulling: Option<String>,
}

/// A state to be drawn.
#[derive(Clone, Debug)]
pub struct Snapshot {
    pub t: f64,
    pub x: Vec<f64>,
}

/// Integrals along the path.
struct Ledger {
    energies: Energies,
    /// Per effect: energy at the last state
    effect: Vec<f64>,
    /// Per constraint: g at the last state
    g: Vec<f64>,
    residual: Vec<f64>,
}

impl Scene {
    /// Runs all stages. `watch` is called after each accepted step; false stops the run. `states` receives each state on
    /// the time grid.
    pub fn run(&self, watch: &mut dyn FnMut(Progress) -> bool, states: &mut dyn FnMut(&State)) -> Run {
        self.follow(watch, states, None)
    }

    /// The same, with derivatives where there is a recorder for them.
    pub(super) fn follow(
        &self,
        watch: &mut dyn FnMut(Progress) -> bool,
        states: &mut dyn FnMut(&State),
        mut slopes: Option<&mut Recorder>,
    ) -> Run {
        let n = &self.spec.numerics;
        let newton = NewtonSettings {
            tolerance: n.tolerance,
            max_iterations: n.max_iterations,
            line_search: n.line_search,
            reuse_factor: n.reuse_factor,
            projection: n.projection,
        };
        let newton = Newton::new(&self.system, newton, self.body.mesh.diagonal());
        let steps = StepSettings { cuts: n.cuts, extrapolate: n.extrapolate };
        let mut stepper = Stepper::new(&self.system, newton, steps);
        stepper.points = &self.body.mesh.points;
        let budget = n.time_budget.and_then(|b| Duration::try_from_secs_f64(b.0).ok());
        stepper.deadline = budget.and_then(|b| Instant::now().checked_add(b));
        let mut state = self.start();
        let end = self.spans.last().map_or(0.0, |s| s.end);
        let mut ledger = Ledger::new(&self.system, &state);
        let mut rows = vec![self.record(&state, &ledger.residual, ledger.energies, 0)];
        let mut iterations = 0;
        let moved = |state: &State| largest(&state.x[..3 * self.body.mesh.points.len()]);
        let mut log = CableLog::default();
        let mut peak = (moved(&state), Snapshot { t: 0.0, x: state.x.clone() });
        states(&state);
        let mut status = Status::Converged;
        for span in &self.spans {
            if span.integrator.needs_initial_acceleration() {
                match initial_acceleration(&self.system, &state) {
                    Ok(a) => state.a = a,
                    Err(why) => {
                        status = Status::StepTooSmall { t: state.t, why };
                        break;
                    }
                }
            }
            if let Some(slopes) = &mut slopes {
                slopes.begin(span.integrator, &state);
            }
            status = stepper.run(*span, &mut state, |past, now, newton, on_grid| {
                ledger.book(&self.system, past, now, newton);
                log.note(&self.cables, now);
                if let Some(slopes) = &mut slopes {
                    slopes.step(span.integrator, past, now, on_grid);
                }
                iterations += newton.iterations;
                if on_grid {
                    let since_last = std::mem::take(&mut iterations);
                    rows.push(self.record(now, &newton.sums.r, ledger.energies, since_last));
                    states(now);
                    let size = moved(now);
                    if size > peak.0 {
                        peak = (size, Snapshot { t: now.t, x: now.x.clone() });
                    }
                }
                watch(Progress { t: now.t, end })
            });
            if status != Status::Converged {
                break;
            }
        }
        let stuck = matches!(status, Status::StepTooSmall { .. } | Status::Inverted { .. });
        let pulling = stuck.then(|| pulling(&self.cables, &state));
        let Newton { factor, sums, assembly_time, .. } = &stepper.newton;
        Run {
            columns: self.columns(),
            rows,
            status,
            totals: stepper.totals,
            findings: stepper.findings,
            costs: by_name(&sums.costs),
            assembly: *assembly_time,
            factorisation: factor.factor_time,
            factorisations: factor.count,
            solve: factor.solve_time,
            factor_nnz: factor.nnz(),
            dofs: self.system.dofs.free.len(),
            peak: peak.1,
            pulling: pulling.flatten(),
            last: state,
            events: log.events,
        }
    }

    /// Names of the recorded columns.
    pub fn columns(&self) -> Vec<String> {
        let probes = self.probes.iter().flat_map(|p| p.columns());
        let cables = self.cables.iter().flat_map(|c| c.columns());
        let cavities = self.cavities.iter().flat_map(cavity_columns);
        let last = std::iter::once("newton_iterations".to_string());
        std::iter::once("t_s".to_string()).chain(probes).chain(cables).chain(cavities).chain(last).collect()
    }

    fn record(&self, state: &State, residual: &[f64], energies: Energies, iterations: usize) -> Vec<f64> {
        let moment = Moment { state, residual, energies, scene: self };
        let probes = self.probes.iter().flat_map(|p| p.record(&moment));
        let cables = self.cables.iter().flat_map(|c| c.record(state));
        let cavities = self.cavities.iter().flat_map(|c| record_cavity(c, state));
        let last = std::iter::once(iterations as f64);
        std::iter::once(state.t).chain(probes).chain(cables).chain(cavities).chain(last).collect()
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

    /// Deformed positions [m].
    pub fn positions(&self, x: &[f64]) -> Vec<Vec3> {
        let displaced = |(k, p): (usize, &Vec3)| p + Vec3::from_column_slice(&x[3 * k..3 * k + 3]);
        self.body.mesh.points.iter().enumerate().map(displaced).collect()
    }
}

impl Ledger {
    fn new(system: &System, rest: &State) -> Self {
        let mut sums = system.workspace();
        let rates = Default::default();
        let State { t, x, v, a, history, .. } = rest;
        let at = At { t: *t, dt: 0.0, x, v, a, old: x, history, rates };
        // An effect that is not defined at rest stops the first step; its energy is then of no use.
        let defined = system.assemble(&at, &rest.lambda, Want::Energy, None, &mut sums).is_ok();
        let effect = if defined { sums.energy } else { vec![0.0; system.effects.len()] };
        let g = if defined { sums.g } else { vec![0.0; system.constraints.len()] };
        Self { energies: Energies::default(), effect, g, residual: vec![0.0; rest.x.len()] }
    }

    /// Books the step from `past` to `now`; the sums of `newton` belong to `now`.
    fn book(&mut self, system: &System, past: &State, now: &State, newton: &Newton) {
        let sums = &newton.sums;
        self.energies.elastic = 0.0;
        self.energies.kinetic = 0.0;
        for (e, effect) in system.effects.iter().enumerate() {
            let energy = sums.energy[e];
            self.energies.dissipated += sums.dissipated[e];
            match effect.role() {
                Role::Stored | Role::Relaxing => self.energies.elastic += energy,
                Role::Kinetic => self.energies.kinetic += energy,
                Role::Dissipative => self.energies.dissipated += energy,
                Role::Load => {
                    let mean = 0.5 * (effect.intensity(past.t) + effect.intensity(now.t));
                    self.energies.work -= mean * (energy - self.effect[e]);
                }
                Role::Follower => {
                    let mean = 0.5 * (effect.intensity(past.t) + effect.intensity(now.t));
                    self.energies.work -= mean * energy;
                }
            }
            self.effect[e] = energy;
        }
        // A row does the work −∫ λ d(target − g): of a cable, tension times what is drawn in, also where its drive yields.
        for (c, constraint) in system.constraints.iter().enumerate() {
            let mean = 0.5 * (past.lambda[c] + now.lambda[c]);
            let moved = constraint.target(now.t) - constraint.target(past.t) - (sums.g[c] - self.g[c]);
            let lost = constraint.dissipated(c, [&self.g, &sums.g], [&past.lambda, &now.lambda]);
            self.energies.work += lost - mean * moved;
            self.energies.dissipated += lost;
            self.energies.elastic += 0.5 * constraint.compliance() * now.lambda[c].powi(2);
        }
        self.g.copy_from_slice(&sums.g);
        for p in &system.prescribed {
            let dof = p.dof as usize;
            let mean = 0.5 * (self.residual[dof] + sums.r[dof]);
            self.energies.work += mean * (now.x[dof] - past.x[dof]);
        }
        self.residual.copy_from_slice(&sums.r);
    }
}

fn largest(x: &[f64]) -> f64 {
    x.chunks_exact(3).map(|u| u[0] * u[0] + u[1] * u[1] + u[2] * u[2]).fold(0.0, f64::max)
}

/// Times of the evaluations, one entry for rows of one name that follow each other.
fn by_name(costs: &[Cost]) -> Vec<(String, Duration)> {
    let mut out: Vec<(String, Duration)> = Vec::new();
    for cost in costs {
        match out.last_mut() {
            Some((name, time)) if *name == cost.name => *time += cost.time,
            _ => out.push((cost.name.clone(), cost.time)),
        }
    }
    out
}
