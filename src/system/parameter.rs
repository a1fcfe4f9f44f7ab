//! Derivatives of a system by a parameter θ at a fixed state, exact or by differences of systems at several θ.

use super::derivative::{add_history, add_residual};
use super::{Assembled, At, ConstraintKind, EvalError, ParameterDerivative, System, Want};
use crate::math::difference::derivatives;

/// A parameter of a system.
pub enum Parameter {
    /// With ∂/∂θ of the effects in closed form
    Exact(Vec<ParameterDerivative>),
    /// With systems at other values of θ
    Difference(Box<SystemDifference>),
}

/// Change of the equations with θ at a fixed state.
#[derive(Clone, Debug, Default)]
pub struct EquationChange {
    /// \[unknowns\] of r + λ ∂c/∂x
    pub residual: Vec<f64>,
    /// \[constraints\] of g
    pub gaps: Vec<f64>,
    /// \[constraints\] of the largest multiplier, where there is one
    pub limits: Vec<f64>,
    /// \[unknowns\] of the dofs that are prescribed or follow others; zero elsewhere
    pub motion: Vec<f64>,
}

impl EquationChange {
    fn zero(system: &System) -> Self {
        let (unknowns, constraints) = (vec![0.0; system.dofs.equation.len()], vec![0.0; system.constraints.len()]);
        Self { residual: unknowns.clone(), gaps: constraints.clone(), limits: constraints, motion: unknowns }
    }

    /// Whether nothing changes.
    pub fn is_zero(&self) -> bool {
        let Self { residual, gaps, limits, motion } = self;
        [residual, gaps, limits, motion].into_iter().all(|values| values.iter().all(|v| *v == 0.0))
    }

    fn flat(self) -> Vec<f64> {
        [self.residual, self.gaps, self.limits, self.motion].concat()
    }

    fn from_flat(mut all: Vec<f64>, system: &System) -> Self {
        let constraints = system.constraints.len();
        let motion = all.split_off(system.dofs.equation.len() + 2 * constraints);
        let limits = all.split_off(system.dofs.equation.len() + constraints);
        let gaps = all.split_off(system.dofs.equation.len());
        Self { residual: all, gaps, limits, motion }
    }
}

impl Parameter {
    /// Derivatives that it has: one that is exact; two by differences, of which the second shows the error of the first.
    pub fn derivatives(&self) -> usize {
        if matches!(self, Self::Exact(_)) { 1 } else { 2 }
    }

    /// The change of the equations for each of its derivatives.
    pub fn change(&mut self, system: &System, at: &At, lambda: &[f64]) -> Result<Vec<EquationChange>, EvalError> {
        match self {
            Self::Exact(terms) => {
                let mut change = EquationChange::zero(system);
                add_residual(system, at, terms, &mut change.residual)?;
                Ok(vec![change])
            }
            Self::Difference(difference) => Ok(difference.change(at, lambda)?.into()),
        }
    }

    /// Whether nothing changes in a body at rest: there the exact derivatives, of laws, are zero.
    pub fn is_idle_at_rest(&mut self, system: &System, at: &At, lambda: &[f64]) -> Result<bool, EvalError> {
        match self {
            Self::Exact(_) => Ok(true),
            _ => Ok(self.change(system, at, lambda)?.iter().all(EquationChange::is_zero)),
        }
    }

    /// Adds the change of the history at the end of the step `at` to `new`, which has an entry for each derivative.
    pub fn add_history(&mut self, system: &System, at: &At, new: &mut [&mut Vec<f64>]) -> Result<(), EvalError> {
        match self {
            Self::Exact(terms) => new.iter_mut().try_for_each(|new| add_history(system, at, terms, new)),
            Self::Difference(_) if at.history.is_empty() => Ok(()),
            Self::Difference(difference) => {
                for (new, change) in new.iter_mut().zip(difference.history(at)?) {
                    new.iter_mut().zip(&change).for_each(|(new, change)| *new += change);
                }
                Ok(())
            }
        }
    }
}

/// A system at nine values of θ.
pub struct SystemDifference {
    /// At the places of [`PLACES`](crate::math::difference::PLACES)
    systems: Vec<System>,
    /// Step of θ
    h: f64,
    sums: Assembled,
}

impl SystemDifference {
    /// Of [variants](super::SystemParts::variant) of one system, in the order of [`PLACES`](crate::math::difference::PLACES).
    pub fn new(systems: Vec<System>, h: f64) -> Self {
        let sums = systems[0].workspace();
        Self { systems, h, sums }
    }

    /// The step of θ.
    pub fn h(&self) -> f64 {
        self.h
    }

    /// The change of the equations at a fixed state, and its one-sided companion.
    pub fn change(&mut self, at: &At, lambda: &[f64]) -> Result<[EquationChange; 2], EvalError> {
        let Self { systems, h, sums } = self;
        let of = |place: usize| values(&systems[place], at, lambda, sums).map(EquationChange::flat);
        Ok(derivatives(*h, of)?.map(|all| EquationChange::from_flat(all, &systems[0])))
    }

    fn history(&mut self, at: &At) -> Result<[Vec<f64>; 2], EvalError> {
        let Self { systems, h, sums } = self;
        derivatives(*h, |place| {
            let mut new = at.history.to_vec();
            systems[place].advance(at, &mut new, &mut sums.costs)?;
            Ok(new)
        })
    }
}

/// The equations of a system at a state, in which the nodes that follow others are where the system puts them.
fn values(system: &System, at: &At, lambda: &[f64], sums: &mut Assembled) -> Result<EquationChange, EvalError> {
    let completed = |field: &[f64]| {
        let mut field = field.to_vec();
        system.ties.complete(&mut field);
        field
    };
    let mut out = EquationChange::zero(system);
    if system.ties.is_empty() {
        system.assemble(at, lambda, Want::Residual, None, sums)?;
    } else {
        let [x, v, a, old] = [at.x, at.v, at.a, at.old].map(completed);
        system.assemble(&At { x: &x, v: &v, a: &a, old: &old, ..*at }, lambda, Want::Residual, None, sums)?;
        for dof in system.ties.nodes().flat_map(|node| 3 * node as usize..3 * node as usize + 3) {
            out.motion[dof] = x[dof];
        }
    }
    out.residual.clone_from(&sums.r);
    out.gaps.clone_from(&sums.g);
    for p in &system.prescribed {
        out.motion[p.dof as usize] = p.signal.at(at.clock());
    }
    for (limit, constraint) in out.limits.iter_mut().zip(&system.constraints) {
        if let ConstraintKind::Bounded(most) = constraint.kind() {
            *limit = most;
        }
    }
    Ok(out)
}
