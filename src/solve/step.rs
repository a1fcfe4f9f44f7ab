//! The step to be solved, and the inputs of an evaluation at its end.

use super::{Failure, Integrator};
use crate::system::{At, EnergyRole, Rates, State, System};

/// The time step from `past` over `dt`.
#[derive(Clone, Copy)]
pub struct Step<'a> {
    pub system: &'a System,
    pub integrator: Integrator,
    pub past: &'a State,
    pub dt: f64,
}

impl Step<'_> {
    /// Inputs of an evaluation at `next`, whose v and a must already belong to its x.
    pub fn at<'b>(&'b self, next: &'b State) -> At<'b> {
        let State { t, x, v, a, inputs, .. } = next;
        let Self { integrator, past, dt, .. } = *self;
        At {
            t: *t,
            dt: if integrator.is_static() { f64::INFINITY } else { dt },
            x,
            v,
            a,
            old: &past.x,
            history: &past.history,
            inputs,
            rates: self.rates(),
        }
    }

    /// Prescribed dofs with their values at the end of the step.
    pub fn targets(&self, next: &State) -> Vec<(usize, f64)> {
        self.system.prescribed.iter().map(|p| (p.dof as usize, p.signal.at(next.clock()))).collect()
    }

    /// Refuses a step in which a prescribed dof, a load or a constraint is not finite at its end.
    pub(super) fn check_inputs(&self, targets: &[(usize, f64)], next: &State) -> Result<(), Failure> {
        let (system, now) = (self.system, next.clock());
        let given = |role| matches!(role, EnergyRole::Load | EnergyRole::Follower);
        let motion = targets.iter().find(|(_, value)| !value.is_finite());
        let motion = motion.map(|(dof, _)| format!("the displacement of node {}", dof / 3));
        let load = || system.effects.iter().find(|e| given(e.role()) && !e.intensity(now).is_finite());
        let constraint = || system.constraints.iter().find(|c| !c.target(now).is_finite());
        let faulty = motion.or_else(|| load().map(|e| e.name().into()));
        match faulty.or_else(|| constraint().map(|c| c.name().into())) {
            Some(input) => Err(Failure::NotFinite { input }),
            None => Ok(()),
        }
    }

    /// \[unknowns\] the prescribed motion that remains from `state`; `None` if nothing remains.
    pub(super) fn remaining(&self, targets: &[(usize, f64)], state: &State) -> Option<Vec<f64>> {
        if targets.iter().all(|&(dof, value)| state.x[dof] == value) {
            return None;
        }
        let mut increment = vec![0.0; state.x.len()];
        targets.iter().for_each(|&(dof, value)| increment[dof] = value - state.x[dof]);
        Some(increment)
    }

    /// ∂v/∂x and ∂a/∂x of the step.
    pub fn rates(&self) -> Rates {
        self.integrator.rates(self.past, self.dt)
    }
}
