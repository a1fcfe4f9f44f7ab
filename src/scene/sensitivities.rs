//! A run and, in the same pass, the derivatives of what it records.

use super::build::Scene;
use super::run::{Progress, Run};
use super::run_options::RunOptions;
use super::sensitivity::{Constant, Sensitivity, SensitivityError};
use crate::solve::{Failure, Integrator};
use crate::system::State;
use std::time::Instant;

/// Derivatives of the rows of a [`Run`] by some constants.
pub struct Sensitivities {
    /// Columns of the run that have a derivative, in their order: all but t_s, newton_iterations and those of the probes
    /// `energy` and `stretch`
    pub columns: Vec<String>,
    pub constants: Vec<Constant>,
    /// \[rows × columns × constants\] in the unit of the column per SI unit of the constant; row by row beside `Run::rows`, with
    /// fewer rows only where `stopped` says why
    pub rows: Vec<Vec<Vec<f64>>>,
    /// Time \[s\] from which on there is no derivative: a bifurcation, or a limit point
    pub stopped: Option<(f64, Failure)>,
    /// Numeric factorisations and right sides solved for the derivatives, beside those of the run
    pub factorisations: usize,
    pub solves: usize,
    /// What the derivatives took, which is in no other time of the run \[s\]
    pub wall: f64,
    /// The same on the clock of the thread \[s\]
    pub cpu: f64,
}

impl Scene {
    /// [`Scene::run`] with the derivatives of its rows by `constants`. A run that ends early has those of the rows so far.
    pub fn run_with_sensitivities(
        &self,
        constants: &[Constant],
        watch: &mut dyn FnMut(Progress) -> bool,
        states: &mut dyn FnMut(&State),
    ) -> Result<(Run, Sensitivities), SensitivityError> {
        let mut recorder = Recorder::new(self, constants)?;
        let run = self.follow(RunOptions::default(), watch, states, Some(&mut recorder));
        let factor = &recorder.sensitivity.solver.factor;
        let (factorisations, solves) = (factor.count, factor.solves);
        Ok((run, Sensitivities { factorisations, solves, ..recorder.sensitivities }))
    }
}

/// Goes along with a run.
pub(super) struct Recorder<'a> {
    sensitivity: Sensitivity<'a>,
    sensitivities: Sensitivities,
}

impl<'a> Recorder<'a> {
    fn new(scene: &'a Scene, constants: &[Constant]) -> Result<Self, SensitivityError> {
        let sensitivity = Sensitivity::new(scene, constants)?;
        let (columns, constants) = (sensitivity.columns(), constants.to_vec());
        let rest = vec![vec![0.0; constants.len()]; columns.len()];
        let sensitivities = Sensitivities {
            columns,
            constants,
            rows: vec![rest],
            stopped: None,
            factorisations: 0,
            solves: 0,
            wall: 0.0,
            cpu: 0.0,
        };
        Ok(Self { sensitivity, sensitivities })
    }

    /// A stage begins at `state`.
    pub(super) fn begin(&mut self, integrator: Integrator, state: &State) {
        self.timed(state.t, |sensitivity| sensitivity.solver.begin(integrator, state).map(|()| None));
    }

    /// A step was accepted.
    pub(super) fn step(&mut self, integrator: Integrator, past: &State, now: &State, on_grid: bool) {
        self.timed(now.t, |sensitivity| sensitivity.step(integrator, past, now, on_grid));
    }

    fn timed(&mut self, t: f64, work: impl FnOnce(&mut Sensitivity) -> Result<Option<Vec<Vec<f64>>>, Failure>) {
        if self.sensitivities.stopped.is_some() {
            return;
        }
        let (wall, cpu) = (Instant::now(), cpu_time::ThreadTime::now());
        match work(&mut self.sensitivity) {
            Ok(row) => self.sensitivities.rows.extend(row),
            Err(why) => self.sensitivities.stopped = Some((t, why)),
        }
        self.sensitivities.wall += wall.elapsed().as_secs_f64();
        self.sensitivities.cpu += cpu.elapsed().as_secs_f64();
    }
}
