//! Derivatives of a system with respect to a parameter θ at a fixed state: exact, by differences of systems at several values of θ, or the sum of
//! both.

use super::derivative::{add_history, add_residual};
use super::{Assembled, At, ConstraintKind, EvalError, ParameterDerivative, System, Want};
use crate::math::difference::{by_best_step, derivatives, disagreement};
use crate::math::statistics::larger;
use std::convert::Infallible;
use std::sync::Arc;

/// Change of a gap when θ changes by its own size, relative to the scale of the constraint, below which its error is not measured relative to it
/// \[–\]: the gap of a rigid part changes with the square of an angle, and its change is rounding compared with its terms.
const LEAST_GAP: f64 = 1e-2;

/// A parameter of a system, given by effects in closed form, by systems at other values of θ, or by both if θ enters in two ways.
pub struct SystemParameter<'a> {
    terms: Vec<ParameterDerivative>,
    difference: Option<SystemDifference<'a>>,
}

/// Derivatives of the equations with respect to θ at a fixed state.
#[derive(Clone, Debug, Default)]
pub struct EquationChange {
    /// \[unknowns\] derivative of r + λ ∂c/∂x
    pub residual: Vec<f64>,
    /// \[constraints\] derivative of g
    pub gaps: Vec<f64>,
    /// \[constraints\] derivative of the largest multiplier, if there is one
    pub limits: Vec<f64>,
    /// \[unknowns\] derivative of the dofs that are prescribed or follow others; zero elsewhere
    pub motion: Vec<f64>,
}

impl EquationChange {
    fn zero(system: &System) -> Self {
        let (unknowns, constraints) = (vec![0.0; system.dofs.equation.len()], vec![0.0; system.constraints.len()]);
        Self { residual: unknowns.clone(), gaps: constraints.clone(), limits: constraints, motion: unknowns }
    }

    /// Whether all derivatives are zero.
    pub fn is_zero(&self) -> bool {
        let Self { residual, gaps, limits, motion } = self;
        [residual, gaps, limits, motion].into_iter().all(|values| values.iter().all(|v| *v == 0.0))
    }

    fn flat(self) -> Vec<f64> {
        [self.residual, self.gaps, self.limits, self.motion].concat()
    }

    fn from_flat(mut all: Vec<f64>, system: &System) -> Self {
        let [gaps, limits, motion] = ends(system);
        let motion = all.split_off(motion);
        let limits = all.split_off(limits);
        let gaps = all.split_off(gaps);
        Self { residual: all, gaps, limits, motion }
    }
}

/// Offsets of gaps, limits and motions in the flattened form.
fn ends(system: &System) -> [usize; 3] {
    let (unknowns, constraints) = (system.dofs.equation.len(), system.constraints.len());
    [unknowns, unknowns + constraints, unknowns + 2 * constraints]
}

impl<'a> SystemParameter<'a> {
    /// A parameter with ∂/∂θ of the effects in closed form.
    pub fn exact(terms: Vec<ParameterDerivative>) -> Self {
        Self { terms, difference: None }
    }

    /// A parameter with ∂/∂θ of these effects in closed form; everything else that depends on θ is differentiated by differences.
    pub fn with_difference(terms: Vec<ParameterDerivative>, difference: SystemDifference<'a>) -> Self {
        Self { terms, difference: Some(difference) }
    }

    /// Number of derivatives: one if it is exact; two by differences, the second of which shows the error of the first.
    pub fn derivatives(&self) -> usize {
        if self.difference.is_none() { 1 } else { 2 }
    }

    /// Returns the change of the equations for each derivative of the parameter.
    pub fn change(&mut self, system: &System, at: &At, lambda: &[f64]) -> Result<Vec<EquationChange>, EvalError> {
        let mut changes = match &mut self.difference {
            None => vec![EquationChange::zero(system)],
            Some(difference) => difference.change(system, at, lambda)?.into(),
        };
        changes.iter_mut().try_for_each(|change| add_residual(system, at, &self.terms, &mut change.residual))?;
        Ok(changes)
    }

    /// Returns, for each derivative of the parameter, the change of `count` values that depend on the system but not on its state. The values are of
    /// two kinds, one in each half.
    pub fn of_system(&self, count: usize, values: &dyn Fn(&System) -> Vec<f64>) -> Vec<Vec<f64>> {
        match &self.difference {
            None => vec![vec![0.0; count]],
            Some(difference) => difference.of_system(values).into(),
        }
    }

    /// Whether nothing changes in a body at rest; the exact derivatives are those of laws, which are zero there.
    pub fn is_idle_at_rest(&mut self, system: &System, at: &At, lambda: &[f64]) -> Result<bool, EvalError> {
        match &mut self.difference {
            None => Ok(true),
            Some(difference) => Ok(difference.change(system, at, lambda)?.iter().all(EquationChange::is_zero)),
        }
    }

    /// Adds the change of the history at the end of the step `at` to `new`, which has an entry for each derivative.
    pub fn add_history(&mut self, system: &System, at: &At, new: &mut [&mut Vec<f64>]) -> Result<(), EvalError> {
        if at.history.is_empty() {
            return Ok(());
        }
        new.iter_mut().try_for_each(|new| add_history(system, at, &self.terms, new))?;
        if let Some(difference) = &mut self.difference {
            for (new, change) in new.iter_mut().zip(difference.history(system, at)?) {
                new.iter_mut().zip(&change).for_each(|(new, change)| *new += change);
            }
        }
        Ok(())
    }
}

/// Variants of one system at nine values of θ, for each of several steps.
pub trait Variants: Send + Sync {
    /// Size of θ, to which the steps are relative.
    fn size(&self) -> f64;
    /// Returns the step size for an index into [`STEPS`](crate::math::difference::STEPS), and the [variants](super::SystemParts::variant) in the
    /// order of [`PLACES`](crate::math::difference::PLACES); `None` if the system cannot be built at one of these values. At least one index has
    /// them.
    fn systems(&self, step: usize) -> Option<(f64, &[System])>;
}

/// The derivative of a system by differences over values of θ; at each state the step with the smallest error is used.
pub struct SystemDifference<'a> {
    variants: Arc<dyn Variants + 'a>,
    sums: Assembled,
}

impl<'a> SystemDifference<'a> {
    /// Prepares differences of variants of `system`.
    pub fn new(system: &System, variants: Arc<dyn Variants + 'a>) -> Self {
        Self { variants, sums: system.workspace() }
    }

    /// Returns the change of the equations of `system` at a fixed state, and its one-sided companion.
    fn change(&mut self, system: &System, at: &At, lambda: &[f64]) -> Result<[EquationChange; 2], EvalError> {
        let Self { variants, sums } = self;
        let history = system.history_on_its_side(at)?;
        let at = &At { history: &history, ..*at };
        let derive = |step: usize| {
            let (h, systems) = variants.systems(step)?;
            let of = |place: usize| values(&systems[place], at, lambda, sums).map(EquationChange::flat);
            Some(derivatives(h, of))
        };
        let size = variants.size();
        let [gaps, limits, motion] = ends(system);
        let error = |[a, b]: &[Vec<f64>; 2]| {
            let parts = [0..gaps, limits..motion, motion..a.len()];
            let of_parts = parts.into_iter().map(|part| disagreement(&a[part.clone()], &b[part]));
            let of_gaps = system.constraints.iter().zip(gaps..limits).map(|(constraint, c)| {
                let least = LEAST_GAP * constraint.scale() / size;
                disagreement(&[a[c], least], &[b[c], least])
            });
            of_parts.chain(of_gaps).fold(0.0, f64::max)
        };
        let found = by_best_step(derive, error).expect("variants for some step")?;
        Ok(found.map(|all| EquationChange::from_flat(all, system)))
    }

    fn of_system(&self, values: &dyn Fn(&System) -> Vec<f64>) -> [Vec<f64>; 2] {
        let derive = |step: usize| {
            let (h, systems) = self.variants.systems(step)?;
            Some(derivatives(h, |place| Ok::<_, Infallible>(values(&systems[place]))))
        };
        let error = |[a, b]: &[Vec<f64>; 2]| {
            let half = a.len() / 2;
            larger(disagreement(&a[..half], &b[..half]), disagreement(&a[half..], &b[half..]))
        };
        let Ok(found) = by_best_step(derive, error).expect("variants for some step");
        found
    }

    fn history(&mut self, system: &System, at: &At) -> Result<[Vec<f64>; 2], EvalError> {
        let Self { variants, sums } = self;
        let history = system.history_on_its_side(at)?;
        let at = &At { history: &history, ..*at };
        let derive = |step: usize| {
            let (h, systems) = variants.systems(step)?;
            let of = |place: usize| {
                let mut new = at.history.to_vec();
                systems[place].advance(at, &mut new, sums)?;
                Ok(new)
            };
            Some(derivatives(h, of))
        };
        by_best_step(derive, |[a, b]| disagreement(a, b)).expect("variants for some step")
    }
}

/// The values of the equations of a system at a state; nodes that follow others are at the positions that this system prescribes.
fn values(system: &System, at: &At, lambda: &[f64], sums: &mut Assembled) -> Result<EquationChange, EvalError> {
    let mut out = EquationChange::zero(system);
    if system.ties.is_empty() {
        system.assemble(at, lambda, Want::Residual, None, sums)?;
    } else {
        let [x, v, a, old] = [at.x, at.v, at.a, at.old].map(|field| system.ties.completed(field));
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
