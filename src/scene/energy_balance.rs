//! Energies of a run: stored at the state, put in and dissipated along the path.

use super::recorder::Energies;
use crate::solve::AcceptedStep;
use crate::system::{At, EnergyRole, State, System, Want};

/// Integrals along the path.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct EnergyBalance {
    pub energies: Energies,
    /// Per effect: energy at the last state
    pub effect: Vec<f64>,
    /// Per constraint: g at the last state
    pub g: Vec<f64>,
    /// \[unknowns\] residual at the last state \[N\]
    pub residual: Vec<f64>,
}

impl EnergyBalance {
    pub(super) fn new(system: &System, rest: &State) -> Self {
        let mut sums = system.workspace();
        let rates = Default::default();
        let State { t, x, v, a, history, inputs, .. } = rest;
        let at = At { t: *t, dt: 0.0, x, v, a, old: x, history, inputs, rates };
        // An effect that is not defined at rest stops the first step; its energy is then of no use.
        let defined = system.assemble(&at, &rest.lambda, Want::Energy, None, &mut sums).is_ok();
        let effect = if defined { sums.energy } else { vec![0.0; system.effects.len()] };
        let g = if defined { sums.g } else { vec![0.0; system.constraints.len()] };
        Self { energies: Energies::default(), effect, g, residual: vec![0.0; rest.x.len()] }
    }

    /// Adds an accepted step.
    pub(super) fn add_step(&mut self, system: &System, step: &AcceptedStep) {
        let AcceptedStep { past, now, sums, .. } = *step;
        self.energies.elastic = 0.0;
        self.energies.kinetic = 0.0;
        for (e, effect) in system.effects.iter().enumerate() {
            let energy = sums.energy[e];
            self.energies.dissipated += sums.dissipated[e];
            match effect.role() {
                EnergyRole::Stored | EnergyRole::Contact | EnergyRole::Relaxing => self.energies.elastic += energy,
                EnergyRole::Kinetic => self.energies.kinetic += energy,
                EnergyRole::Dissipative | EnergyRole::Friction => self.energies.dissipated += energy,
                EnergyRole::Load => {
                    let mean = 0.5 * (effect.intensity(past.clock()) + effect.intensity(now.clock()));
                    self.energies.work -= mean * (energy - self.effect[e]);
                }
                EnergyRole::Follower => {
                    let mean = 0.5 * (effect.intensity(past.clock()) + effect.intensity(now.clock()));
                    self.energies.work -= mean * energy;
                }
            }
            self.effect[e] = energy;
        }
        // A constraint does the work −∫ λ d(target − g): of a cable, tension times the length drawn in, also where its drive yields.
        for (c, constraint) in system.constraints.iter().enumerate() {
            let mean = 0.5 * (past.lambda[c] + now.lambda[c]);
            let moved = constraint.target(now.clock()) - constraint.target(past.clock()) - (sums.g[c] - self.g[c]);
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
