//! Consistent initial acceleration.

use super::Failure;
use crate::math::linear::Factor;
use crate::system::{At, Rates, State, System, Want};

/// A slope ∂a/∂x [1/s²] far above ω² of every mode, so that M = (K(ca) − K(0))/ca keeps its digits beside the stiffness.
const STEEP: f64 = 1e12;

/// Solves M a = −r(x, v, 0, λ) on the free dofs: r is linear in a, so M = (K(ca) − K(0))/ca.
pub fn initial_acceleration(system: &System, state: &State) -> Result<Vec<f64>, Failure> {
    let zero = vec![0.0; state.x.len()];
    let mut sums = system.workspace();
    let mut tangent = |ca: f64| {
        let rates = Rates { cv: 0.0, ca };
        // No time passes: what relaxes has its force of the last state.
        let State { t, x, v, history, inputs, .. } = state;
        let at = At { t: *t, dt: 0.0, x, v, a: &zero, old: x, history, inputs, rates };
        system.assemble(&at, &state.lambda, Want::Tangent, None, &mut sums).map_err(Failure::Eval)?;
        Ok((sums.k.clone(), system.restrict(&sums.r)))
    };
    let (without, mut force) = tangent(0.0)?;
    let (mut mass, _) = tangent(STEEP)?;
    mass.iter_mut().zip(&without).for_each(|(m, k)| *m = (*m - k) / STEEP);
    force.iter_mut().for_each(|f| *f = -*f);
    // A second field has no mass and starts at rest.
    for e in (0..force.len()).filter(|&e| system.dofs.is_scalar(e)) {
        mass[system.pattern.col_ptr[e] as usize] = 1.0;
        force[e] = 0.0;
    }
    let mut factor = Factor::new(system.pattern.clone());
    factor.factorise(&mass).and_then(|()| factor.solve(&mass, &mut force)).map_err(Failure::Linear)?;
    let mut a = zero;
    system.dofs.free.iter().zip(force).for_each(|(&dof, value)| a[dof as usize] = value);
    Ok(a)
}
