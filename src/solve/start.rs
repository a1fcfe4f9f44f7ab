//! Consistent initial accelerations.

use super::Failure;
use crate::math::linear::{Definiteness, Factor, Method};
use crate::system::{Assembled, At, Rates, State, System, Want};

/// A derivative ∂a/∂x \[1/s²\] far above ω² of every mode, so that M = (K(ca) − K(0))/ca keeps its digits in spite of the stiffness.
const STEEP: f64 = 1e12;

/// Solves M a = −r(x, v, 0, λ) on the free dofs; prescribed accelerations are those of the state.
pub fn initial_acceleration(system: &System, state: &State) -> Result<Vec<f64>, Failure> {
    initial_acceleration_by(Method::default(), system, state)
}

/// Computes [`initial_acceleration`] with this choice between direct and iterative linear solvers.
pub fn initial_acceleration_by(method: Method, system: &System, state: &State) -> Result<Vec<f64>, Failure> {
    let mut given = vec![0.0; state.x.len()];
    system.prescribed.iter().for_each(|p| given[p.dof as usize] = state.a[p.dof as usize]);
    system.ties.complete(&mut given);
    Start::new(method, system, state, &given)?.solve(system, None, given)
}

/// The start of a stage: r, K = ∂r/∂x, and M.
pub(super) struct Start {
    /// The sums at the given acceleration
    pub sums: Assembled,
    mass: Vec<f64>,
    factor: Factor,
}

impl Start {
    /// Assembles and factorises M = (K(ca) − K(0))/ca, since r is linear in a.
    pub fn new(method: Method, system: &System, state: &State, a: &[f64]) -> Result<Self, Failure> {
        let mut sums = system.workspace();
        let mut assemble = |ca| {
            let at = before(state, a, Rates { cv: 0.0, ca });
            system.assemble(&at, &state.lambda, Want::Tangent, None, &mut sums).map_err(Failure::Eval)?;
            Ok(sums.k.clone())
        };
        let mut mass = assemble(STEEP)?;
        let without = assemble(0.0)?;
        mass.iter_mut().zip(&without).for_each(|(m, k)| *m = (*m - k) / STEEP);
        // A second field has no mass, and no acceleration at the start
        for e in (0..system.dofs.free.len()).filter(|&e| system.dofs.is_scalar(e)) {
            mass[sums.pattern.on_diagonal(e)] = 1.0;
        }
        let mut factor = Factor::by(method, sums.pattern.clone(), Definiteness::Positive);
        factor.move_to(&state.x);
        factor.factorise(&mass).map_err(Failure::Linear)?;
        Ok(Self { sums, mass, factor })
    }

    /// Returns M⁻¹(−r) on the free dofs \[unknowns\], and `given` elsewhere; r is `residual` \[equations\], or that of the state if it is `None`.
    pub fn solve(&mut self, system: &System, residual: Option<Vec<f64>>, given: Vec<f64>) -> Result<Vec<f64>, Failure> {
        let mut force = residual.unwrap_or_else(|| system.restrict(&self.sums.r));
        for (e, force) in force.iter_mut().enumerate() {
            *force = if system.dofs.is_scalar(e) { 0.0 } else { -*force };
        }
        self.factor.solve(&self.mass, &mut force).map_err(Failure::Linear)?;
        let mut a = given;
        system.expand(&force, &mut a);
        Ok(a)
    }

    /// Returns M v \[equations\] for velocities v of these equations, with the others at rest.
    pub fn momentum(&self, v: &[(usize, f64)]) -> Vec<f64> {
        let n = self.sums.pattern.n;
        let (mut all, mut momentum) = (vec![0.0; n], vec![0.0; n]);
        v.iter().for_each(|&(equation, v)| all[equation] = v);
        self.sums.pattern.multiply(&self.mass, &all, &mut momentum);
        momentum
    }
}

/// Inputs of an evaluation before the first step. No time passes: relaxing effects have the force of the last state, and dampers the force of its
/// velocities.
pub(super) fn before<'a>(state: &'a State, a: &'a [f64], rates: Rates) -> At<'a> {
    At { a, rates, ..state.at() }
}
