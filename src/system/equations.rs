//! The system of equations: effects, constraints, and the resulting sparsity.

use super::contribution::{Contribution, Coupling, Kernel, Receiver};
use super::sparsity::{Slots, Sparsity, TangentBlocks};
use super::{
    Assembled, At, Blocks, Caches, Constraint, ConstraintKind, ContactPoint, ContactPoints, Cost, Dofs, Effect,
    EnergyRole, EvalError, Means, MotionLimit, Prescribed, State, Strain, Ties,
};
use crate::math::linear::Definiteness;
use crate::math::low_rank::Pattern;
use crate::math::signal::Clock;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Reason why a system cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SystemError {
    #[error("degree of freedom {component} of node {node} is prescribed twice; remove one of the two constraints")]
    PrescribedTwice { node: u32, component: u32 },
    #[error("the scene has no effect: add at least an [[effect]] of kind \"elastic\"")]
    NoEffect,
    #[error("every node is prescribed: there is nothing to solve")]
    NothingFree,
    #[error("{what} differ; a derivative needs the same equations with other values")]
    Structure { what: String },
}

/// A system of equations: effects, constraints, and the resulting sparsity.
pub struct System {
    pub effects: Vec<Box<dyn Effect>>,
    pub constraints: Vec<Box<dyn Constraint>>,
    pub prescribed: Vec<Prescribed>,
    pub dofs: Arc<Dofs>,
    /// Nodes that follow others and have no equations
    pub ties: Ties,
    /// Pattern of all blocks except transient ones
    pub pattern: Arc<Pattern>,
    /// Slots per effect, then per constraint
    pub(super) slots: Arc<Vec<Slots>>,
    /// Number of unknowns of the largest block
    pub(super) largest: usize,
    /// Per effect: range of its variables in the history of the state
    pub(super) histories: Vec<Range<usize>>,
}

impl System {
    pub fn new(
        nodes: usize,
        effects: Vec<Box<dyn Effect>>,
        constraints: Vec<Box<dyn Constraint>>,
        prescribed: Vec<Prescribed>,
    ) -> Result<Self, SystemError> {
        Self::with_scalars(nodes, &[], effects, constraints, prescribed)
    }

    /// Builds a system with a second field: unknown 3·nodes + k is a scalar. For the numbering it belongs to node `hosts[k]`, which is one of the
    /// nodes of every block that contains the scalar.
    pub fn with_scalars(
        nodes: usize,
        hosts: &[u32],
        effects: Vec<Box<dyn Effect>>,
        constraints: Vec<Box<dyn Constraint>>,
        prescribed: Vec<Prescribed>,
    ) -> Result<Self, SystemError> {
        Self::tied(nodes, hosts, effects, constraints, prescribed, Ties::default())
    }

    /// Builds a system as [`Self::with_scalars`], with nodes that follow others; none of these is prescribed, and no effect that selects its blocks
    /// acts on them.
    pub fn tied(
        nodes: usize,
        hosts: &[u32],
        effects: Vec<Box<dyn Effect>>,
        constraints: Vec<Box<dyn Constraint>>,
        prescribed: Vec<Prescribed>,
        ties: Ties,
    ) -> Result<Self, SystemError> {
        let effects: Vec<Box<dyn Effect>> = effects.into_iter().map(|effect| ties.effect(effect)).collect();
        let constraints: Vec<Box<dyn Constraint>> =
            constraints.into_iter().map(|constraint| ties.constraint(constraint)).collect();
        if effects.is_empty() {
            return Err(SystemError::NoEffect);
        }
        let mut seen = vec![false; 3 * nodes];
        for p in &prescribed {
            if std::mem::replace(&mut seen[p.dof as usize], true) {
                return Err(SystemError::PrescribedTwice { node: p.dof / 3, component: p.dof % 3 });
            }
        }
        let none = Blocks::default();
        let of_effects = effects.iter().map(|e| {
            let capabilities = e.capabilities();
            let in_groups = capabilities.means.is_none() && capabilities.active.is_none();
            TangentBlocks { blocks: e.blocks(), means: capabilities.means, in_groups }
        });
        let of_constraints = constraints.iter().map(|c| match c.kind() {
            // A monitored constraint does not contribute to the tangent
            ConstraintKind::Monitored => TangentBlocks { blocks: &none, means: None, in_groups: false },
            _ => TangentBlocks { blocks: c.blocks(), means: c.means(), in_groups: false },
        });
        let all: Vec<TangentBlocks> = of_effects.chain(of_constraints).collect();
        let Sparsity { dofs, pattern, slots } =
            Sparsity::new(nodes, hosts, (&prescribed, &ties), &all).ok_or(SystemError::NothingFree)?;
        let lists = effects.iter().map(|e| e.blocks()).chain(constraints.iter().map(|c| c.blocks()));
        let largest = lists.map(Blocks::largest).max().unwrap_or(0);
        let mut histories: Vec<Range<usize>> = Vec::new();
        for e in &effects {
            let start = histories.last().map_or(0, |h| h.end);
            histories.push(start..start + e.blocks().len() * e.capabilities().history_size());
        }
        let (dofs, pattern, slots) = (Arc::new(dofs), Arc::new(pattern), Arc::new(slots));
        Ok(Self { effects, constraints, prescribed, dofs, ties, pattern, slots, largest, histories })
    }

    /// Range of the variables of effect `e` in the history of the state.
    pub fn history_of(&self, e: usize) -> Range<usize> {
        self.histories[e].clone()
    }

    /// Number of unknowns of the largest block, excluding transient ones.
    pub(super) fn largest(&self) -> usize {
        self.largest
    }

    /// The inputs of effect `e`, with its own part of the history.
    pub(super) fn inputs_of<'a>(&self, e: usize, at: &At<'a>) -> At<'a> {
        At { history: &at.history[self.history_of(e)], ..*at }
    }

    /// Contribution of effect `e`, without its transient blocks.
    pub(super) fn effect(&self, e: usize) -> Contribution<'_> {
        let effect = &*self.effects[e];
        Contribution {
            kernel: Kernel::Effect(effect),
            coupling: self.coupling(e, effect.capabilities().means),
            receiver: Receiver::Effect(e),
            weight: Some(1.0),
            projected: false,
            keeps_remainder: false,
        }
    }

    /// Contribution of constraint `c` with the multiplier λ.
    pub(super) fn constraint(&self, c: usize, lambda: f64) -> Contribution<'_> {
        let constraint = &*self.constraints[c];
        Contribution {
            kernel: Kernel::Constraint(constraint),
            coupling: self.coupling(self.effects.len() + c, constraint.means()),
            receiver: Receiver::Constraint(c),
            weight: (constraint.kind() != ConstraintKind::Monitored).then_some(lambda),
            projected: false,
            keeps_remainder: false,
        }
    }

    fn coupling<'a>(&'a self, i: usize, means: Option<&'a Arc<Means>>) -> Coupling<'a> {
        match (means, &self.slots[i]) {
            (Some(means), Slots::Entries(slots)) => Coupling::Means(means, slots),
            (_, Slots::Entries(slots)) => Coupling::Dofs(slots),
            (_, Slots::Groups(groups)) => Coupling::Groups(groups),
        }
    }

    /// Creates empty sums, with the workspace of a run.
    pub fn workspace(&self) -> Assembled {
        let of_effects = self.effects.iter().map(|e| (e.name(), Some(e.role())));
        let names = of_effects.chain(self.constraints.iter().map(|c| (c.name(), None)));
        let cost = |(name, role): (&str, _)| Cost { name: name.into(), role, time: Duration::ZERO, evaluations: 0 };
        Assembled::new(self.dofs.equation.len(), self.dofs.free.len(), self.pattern.clone(), names.map(cost).collect())
    }

    /// Whether any effect describes contact.
    pub fn has_contact(&self) -> bool {
        self.effects.iter().any(|e| e.role() == EnergyRole::Contact)
    }

    /// Whether a prescribed force, pressure or tension differs between the two times.
    pub fn forces_change(&self, from: Clock, to: Clock) -> bool {
        self.forces().any(|e| e.intensity(from) != e.intensity(to))
    }

    /// Whether any effect has mass.
    pub fn has_mass(&self) -> bool {
        self.effects.iter().any(|effect| effect.role() == EnergyRole::Kinetic)
    }

    /// Whether a prescribed force, pressure, tension or displacement is nonzero at a time.
    pub fn acts_at(&self, now: Clock) -> bool {
        self.forces().any(|e| e.intensity(now) != 0.0) || self.prescribed.iter().any(|p| p.signal.at(now) != 0.0)
    }

    /// The effects with a prescribed intensity: forces, pressures, tensions.
    fn forces(&self) -> impl Iterator<Item = &dyn Effect> {
        let given = |e: &&dyn Effect| matches!(e.role(), EnergyRole::Load | EnergyRole::Follower);
        self.effects.iter().map(AsRef::as_ref).filter(given)
    }

    /// Whether the tangent of any effect has a skew part.
    pub fn has_skew_tangent(&self) -> bool {
        self.effects.iter().any(|e| e.capabilities().skew.is_some())
    }

    /// Whether any effect has blocks that exist only at one state.
    pub fn has_transient_coupling(&self) -> bool {
        self.effects.iter().any(|e| e.capabilities().transient.is_some())
    }

    /// Whether there are contact points with friction whose forces can be prescribed.
    pub fn has_frictional_points(&self) -> bool {
        self.with_contact_points().any(|(_, points)| points.has_friction())
    }

    /// The effects that have contact points, with their names.
    pub fn with_contact_points(&self) -> impl Iterator<Item = (&str, &dyn ContactPoints)> {
        self.effects.iter().filter_map(|e| Some((e.name(), e.capabilities().contact_points?)))
    }

    /// The contact points of each effect that has them, by [`ContactPoints::points`].
    pub fn contact_points(
        &self,
        x_old: [&[f64]; 2],
        dt: f64,
        margin: f64,
        caches: &mut Caches,
    ) -> Vec<Vec<ContactPoint<'_>>> {
        let mut all = Vec::new();
        for (name, effect) in self.with_contact_points() {
            let first = self.elastic_slips_of(name).map_or(0, |slips| slips.start);
            let points = effect.points(x_old, dt, margin, caches).into_iter();
            all.push(points.map(|point| ContactPoint { history: point.history + first, ..point }).collect());
        }
        all
    }

    /// Sets the normal forces N \[N\] of the points of each effect that has contact points.
    pub fn set_contact_forces<'f>(&self, x: &mut [f64], forces: impl Iterator<Item = &'f [f64]>, caches: &mut Caches) {
        self.with_contact_points().zip(forces).for_each(|((_, effect), forces)| effect.set_forces(x, forces, caches));
    }

    /// The largest displacement of a free dof in x \[m\].
    pub fn largest_displacement(&self, x: &[f64]) -> f64 {
        let moving = self.dofs.free.iter().filter(|dof| **dof < self.dofs.displacements);
        moving.fold(0.0, |most: f64, &dof| most.max(x[dof as usize].abs()))
    }

    /// Rotates the stiff bodies that the motion dx from x would stretch, [`TurningBody`](super::TurningBody). Returns whether there are any.
    pub fn turn(&self, x: &[f64], dx: &mut [f64], strain: Strain) -> bool {
        let mut any = false;
        for body in self.effects.iter().filter_map(|e| e.capabilities().turning) {
            body.turn(x, dx, strain);
            any = true;
        }
        any
    }

    /// The nodes of each stiff body that rotates without strain.
    pub fn turning_bodies(&self) -> impl Iterator<Item = &[u32]> {
        self.effects.iter().filter(|e| e.capabilities().turning.is_some()).map(|e| e.blocks().nodes(0))
    }

    /// The largest share of the motion dx from x that all effects admit; `None` if all of it is admissible.
    pub fn max_step(&self, x: &[f64], dx: &[f64], caches: &mut Caches) -> Option<(&str, MotionLimit)> {
        let limits = self.effects.iter().filter_map(|e| {
            let limit = e.capabilities().step_limit?.max_step(x, dx, caches)?;
            Some((e.name(), limit))
        });
        limits.filter(|(_, l)| l.share < 1.0).min_by(|a, b| a.1.share.total_cmp(&b.1.share))
    }

    /// Range of the elastic slips of the points of a contact in the history of the state; `None` without friction.
    pub fn elastic_slips_of(&self, contact: &str) -> Option<Range<usize>> {
        let e = self.effects.iter().position(|e| e.capabilities().friction_of == Some(contact))?;
        Some(self.history_of(e))
    }

    /// Resets the elastic slips of all contacts in a history of the state to zero.
    pub fn forget_elastic_slips(&self, history: &mut [f64]) {
        let frictions = (0..self.effects.len()).filter(|&e| self.effects[e].capabilities().friction_of.is_some());
        frictions.for_each(|e| history[self.history_of(e)].fill(0.0));
    }

    /// Advances the histories to the end of the accepted step `at`; `new` holds those at its start and receives those at its end.
    pub fn advance(&self, at: &At, new: &mut [f64], sums: &mut Assembled) -> Result<(), EvalError> {
        for (e, effect) in self.effects.iter().enumerate() {
            let Some(history) = effect.capabilities().history else { continue };
            let start = Instant::now();
            let at = self.inputs_of(e, at);
            history.advance_all(&at, &mut new[self.history_of(e)], &mut sums.caches)?;
            sums.costs[e].time += start.elapsed();
        }
        Ok(())
    }

    /// Sets the histories of a state from which a body starts instead of from rest; zeros at rest, and for an effect that is not defined there, which stops the
    /// first step.
    pub fn begin(&self, state: &mut State) {
        let mut all = vec![0.0; state.history.len()];
        if state.x[..self.dofs.displacements as usize].iter().all(|x| *x == 0.0) {
            state.history = all;
            return;
        }
        for (e, effect) in self.effects.iter().enumerate() {
            let Some(variables) = effect.capabilities().history else { continue };
            let at = self.inputs_of(e, &state.at());
            let own = &mut all[self.history_of(e)];
            let mut blocks = own.chunks_exact_mut(variables.size()).enumerate();
            if blocks.try_for_each(|(b, history)| variables.begin(&at, b, history)).is_err() {
                own.fill(0.0);
            }
        }
        state.history = all;
    }

    /// The histories for differences about a state, [`HistoryVariables::take_side`](super::HistoryVariables::take_side).
    pub fn history_on_its_side(&self, at: &At) -> Result<Vec<f64>, EvalError> {
        let mut history = at.history.to_vec();
        for (e, effect) in self.effects.iter().enumerate() {
            let Some(variables) = effect.capabilities().history else { continue };
            let at = self.inputs_of(e, at);
            let mut blocks = history[self.history_of(e)].chunks_exact_mut(variables.size()).enumerate();
            blocks.try_for_each(|(b, history)| variables.take_side(&at, b, history))?;
        }
        Ok(history)
    }

    /// Restricts a field \[unknowns\] to the free dofs \[equations\].
    pub fn restrict(&self, full: &[f64]) -> Vec<f64> {
        self.dofs.free.iter().map(|&dof| full[dof as usize]).collect()
    }

    /// Writes values of the free dofs \[equations\] into a field \[unknowns\], and updates the nodes that follow others.
    pub fn expand(&self, free: &[f64], full: &mut [f64]) {
        self.dofs.free.iter().zip(free).for_each(|(&dof, value)| full[dof as usize] = *value);
        self.ties.complete(full);
    }

    /// A state at rest in the reference configuration.
    pub fn rest(&self) -> State {
        let zero = vec![0.0; self.dofs.equation.len()];
        State {
            t: 0.0,
            x: zero.clone(),
            v: zero.clone(),
            a: zero,
            lambda: vec![0.0; self.constraints.len()],
            memory: Vec::new(),
            dt: 0.0,
            history: vec![0.0; self.histories.last().map_or(0, |h| h.end)],
            inputs: Vec::new(),
        }
    }

    /// Number of equations of the second field, which is the number of negative pivots at a stable equilibrium.
    pub fn scalar_equations(&self) -> usize {
        (0..self.dofs.free.len()).filter(|&e| self.dofs.is_scalar(e)).count()
    }

    /// The definiteness that the tangent of a stable equilibrium has.
    pub fn definiteness(&self) -> Definiteness {
        if self.scalar_equations() == 0 { Definiteness::Positive } else { Definiteness::Saddle }
    }
}
