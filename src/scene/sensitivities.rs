//! Derivatives of the rows of a run, computed in the same pass.

use super::build::Scene;
use super::sensitivity::{Constant, Sensitivity, SensitivityError};
use crate::solve::{AcceptedStep, Failure, Integrator};
use crate::system::State;
use std::time::Instant;

/// Derivatives of the rows of a [`Run`](super::Run) by some constants.
pub struct Sensitivities {
    /// Columns of the run that have a derivative, in their order: all but t_s, newton_iterations and those of the probes
    /// `energy` and `stretch`
    pub columns: Vec<String>,
    pub constants: Vec<Constant>,
    /// \[rows × columns × constants\] in the unit of the column per SI unit of the constant; one entry for each of `Run::rows`,
    /// fewer only where `stopped` says why. NaN where a column has no derivative, like the curvature of a straight line
    pub rows: Vec<Vec<Vec<f64>>>,
    /// Time \[s\] from which on there is no derivative: a bifurcation, or a limit point
    pub stopped: Option<(f64, Failure)>,
    /// Numeric factorisations and right sides solved for the derivatives, in addition to those of the run
    pub factorisations: usize,
    pub solves: usize,
    /// Wall time of the derivatives, which is in no other time of the run \[s\]
    pub wall: f64,
    /// CPU time of the derivatives \[s\]
    pub cpu: f64,
}

/// Computes the derivatives of the rows while a scene runs: [`RunOptions::sensitivities`](super::RunOptions::sensitivities).
pub struct SensitivityRecorder<'a> {
    sensitivity: Sensitivity<'a>,
    sensitivities: Sensitivities,
}

impl<'a> SensitivityRecorder<'a> {
    /// For derivatives by `constants`; an error where the scene has none.
    pub fn new(scene: &'a Scene, constants: &[Constant]) -> Result<Self, SensitivityError> {
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

    /// A step was accepted, which the recorders have taken over into their memory.
    pub(super) fn step(&mut self, step: &AcceptedStep, memory: &[f64], recorded: bool) {
        self.timed(step.now.t, |sensitivity| sensitivity.step(step, memory, recorded));
    }

    /// The derivatives, of the rows so far where the run ended early.
    pub(super) fn finish(self) -> Sensitivities {
        let factor = &self.sensitivity.solver.factor;
        let (factorisations, solves) = (factor.count, factor.solves);
        Sensitivities { factorisations, solves, ..self.sensitivities }
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
