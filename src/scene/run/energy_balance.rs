//! Energies of a run: stored at the state, supplied and dissipated along the path.
//!
//! Work and dissipation count from the start, elastic and kinetic energy belong to the state: over a run, the work minus the dissipated energy is the change
//! of elastic + kinetic energy. Relaxing parts that are loaded at the start store an energy that is included in the initial dissipation: they release it
//! later.

use super::energy_growth::EnergyGrowth;
use crate::scene::record::recorder::Energies;
use crate::solve::AcceptedStep;
use crate::system::{EnergyRole, State, System, Want};

/// Relative difference up to which the change of a prescribed displacement is that of its signal \[–\]
const FOLLOWS: f64 = 1e-9;

/// Integrals along the path.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::scene) struct EnergyBalance {
    pub energies: Energies,
    /// Energy of each effect at the last state
    pub effect: Vec<f64>,
    /// g of each constraint at the last state
    pub g: Vec<f64>,
    /// Residual at the last state \[unknowns\] \[N\]
    pub residual: Vec<f64>,
    /// Energy that appears without work
    pub growth: EnergyGrowth,
}

impl EnergyBalance {
    pub(in crate::scene) fn new(system: &System, rest: &State) -> Self {
        let mut sums = system.workspace();
        // An effect that is not defined at rest stops the first step; its energy is then not needed.
        let defined = system.assemble(&rest.at(), &rest.lambda, Want::Energy, None, &mut sums).is_ok();
        let has_begun = rest.history.iter().any(|value| *value != 0.0);
        let held = if defined && has_begun { sums.dissipated.iter().sum() } else { 0.0 };
        let effect = if defined { sums.energy } else { vec![0.0; system.effects.len()] };
        let g = if defined { sums.g } else { vec![0.0; system.constraints.len()] };
        let (energies, growth) = (Energies { dissipated: held, ..Energies::default() }, EnergyGrowth::default());
        let mut balance = Self { energies, effect, g, residual: vec![0.0; rest.x.len()], growth };
        balance.store(system, &rest.lambda);
        balance
    }

    /// Updates the elastic and kinetic energy from those of the effects, and from the multipliers λ of compliant constraints.
    fn store(&mut self, system: &System, lambda: &[f64]) {
        let Energies { elastic, kinetic, .. } = &mut self.energies;
        (*elastic, *kinetic) = (0.0, 0.0);
        for (effect, energy) in system.effects.iter().zip(&self.effect) {
            match effect.role() {
                EnergyRole::Stored | EnergyRole::Contact | EnergyRole::Relaxing => *elastic += energy,
                EnergyRole::Kinetic => *kinetic += energy,
                EnergyRole::Dissipative | EnergyRole::Friction | EnergyRole::Load | EnergyRole::Follower => {}
            }
        }
        for (constraint, lambda) in system.constraints.iter().zip(lambda) {
            *elastic += 0.5 * constraint.compliance() * lambda.powi(2);
        }
    }

    /// Adds an accepted step.
    pub(super) fn add_step(&mut self, system: &System, step: &AcceptedStep) {
        let AcceptedStep { past, now, sums, .. } = *step;
        for (e, effect) in system.effects.iter().enumerate() {
            let energy = sums.energy[e];
            self.energies.dissipated += sums.dissipated[e];
            match effect.role() {
                EnergyRole::Stored | EnergyRole::Contact | EnergyRole::Relaxing | EnergyRole::Kinetic => {}
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
        // A constraint does the work −∫ λ d(target − g): for a cable, the tension times the length drawn in, even if its drive yields.
        for (c, constraint) in system.constraints.iter().enumerate() {
            let mean = 0.5 * (past.lambda[c] + now.lambda[c]);
            let moved = constraint.target(now.clock()) - constraint.target(past.clock()) - (sums.g[c] - self.g[c]);
            let lost = constraint.dissipated(c, [&self.g, &sums.g], [&past.lambda, &now.lambda]);
            self.energies.work += lost - mean * moved;
            self.energies.dissipated += lost;
        }
        self.store(system, &now.lambda);
        self.g.copy_from_slice(&sums.g);
        for p in &system.prescribed {
            let dof = p.dof as usize;
            let (from, to) = (p.signal.at(past.clock()), p.signal.at(now.clock()));
            let moved = now.x[dof] - past.x[dof];
            // The first static step moves prescribed dofs from rest to their positions, along an arbitrary path.
            let follows = (moved - (to - from)).abs() <= FOLLOWS * from.abs().max(to.abs());
            let [first, second] = if follows { p.signal.increments([past.clock(), now.clock()]) } else { [moved; 2] };
            self.energies.work += 0.5 * (self.residual[dof] * first + sums.r[dof] * second);
        }
        self.residual.copy_from_slice(&sums.r);
        if !step.integrator.is_static() {
            self.growth.add(now.t, self.energies);
        }
    }
}
