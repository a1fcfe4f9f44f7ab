//! Residual and tangent: one loop over the declared effects and constraints.
//!
//! Blocks are evaluated and summed in their order, so the result does not depend on how many cases run beside it.

use super::means::Coupled;
use super::projection::project;
use super::scatter::{Scatter, sum_batches};
use super::transient_coupling::TransientTangents;
use super::{
    At, BlockValues, Blocks, Caches, Cone, Constraint, Dofs, Effect, EnergyRole, EvalError, Means, MotionLimit,
    Prescribed, State, Want,
};
use crate::math::linear::norm;
use crate::math::low_rank::Pattern;
use crate::math::sparse::{SkewMatrix, SymPattern};
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Why a system cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SystemError {
    #[error("degree of freedom {component} of node {node} is prescribed twice; remove one of the two constraints")]
    PrescribedTwice { node: u32, component: u32 },
    #[error("the scene has no effect: add at least an [[effect]] of kind \"elastic\"")]
    NoEffect,
    #[error("every node is prescribed: there is nothing to solve")]
    NothingFree,
}

/// Time spent in the evaluations of one effect or constraint.
#[derive(Clone, Debug, PartialEq)]
pub struct Cost {
    pub name: String,
    /// EnergyRole of an effect; None for a constraint
    pub role: Option<EnergyRole>,
    pub time: Duration,
    pub evaluations: usize,
}

/// Effects, constraints and the sparsity that follows from them.
pub struct System {
    pub effects: Vec<Box<dyn Effect>>,
    pub constraints: Vec<Box<dyn Constraint>>,
    pub prescribed: Vec<Prescribed>,
    pub dofs: Dofs,
    /// Of the blocks that stay
    pub pattern: Arc<Pattern>,
    /// Per effect, then per constraint: slot of each local entry with column ≤ row, block after block
    slots: Vec<Vec<u32>>,
    largest: usize,
    /// Effects with a skew part of the tangent
    pub(crate) skewed: Vec<usize>,
    /// Effects that couple what meets
    pub(crate) meeting: Vec<usize>,
    /// Are there points that slide, and whose forces can be given?
    pub(crate) slides: bool,
    /// Per effect: where its history lies in that of the state
    histories: Vec<Range<usize>>,
}

/// Sums at one state.
#[derive(Debug)]
pub struct Assembled {
    /// \[unknowns\] r(x) + λ ∂c/∂x \[N\]; at a prescribed dof it is the reaction
    pub r: Vec<f64>,
    /// Values of K in `pattern` \[N/m\]
    pub k: Vec<f64>,
    /// That of the system, with room for parts that met
    pub pattern: Arc<Pattern>,
    /// Where the entries of the system's pattern are in a wider one; empty where there is none
    pub(crate) moved: Vec<u32>,
    /// What the tangent has beside K, on the equations \[N/m\]; empty where no effect declares any
    pub skew: SkewMatrix,
    /// \[equations\] Σ K_e d of the prescribed increment d, if one was given \[N\]
    pub lift: Vec<f64>,
    /// Per constraint: g = target + compliance λ − c
    pub g: Vec<f64>,
    /// Per constraint: ∂c/∂x · d of the prescribed increment d, if one was given
    pub carried: Vec<f64>,
    /// Per constraint: \[equations\] ∂c/∂x on the free dofs
    pub gradient: Vec<Vec<f64>>,
    /// Largest effect's Σ_e ‖r_e‖ \[N\]: the yardstick of convergence
    pub scale: f64,
    /// Per effect: its energy \[J\]
    pub energy: Vec<f64>,
    /// Per effect: what the step dissipates \[J\], beside the energy of a dissipative one
    pub dissipated: Vec<f64>,
    /// Wanted: tangents of effects without the negative eigenvalues of their blocks
    pub projected: bool,
    /// Wanted: the same of the effects that ask for it, [`Effect::semidefinite`]
    pub descending: bool,
    /// Per effect, then per constraint
    pub costs: Vec<Cost>,
    /// Of the run that these sums belong to
    pub caches: Caches,
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

    /// With a second field: unknown 3·nodes + k is a scalar, hosted for the numbering by node `hosts\[k\]`, one of the nodes
    /// of every block it is in.
    pub fn with_scalars(
        nodes: usize,
        hosts: &[u32],
        effects: Vec<Box<dyn Effect>>,
        constraints: Vec<Box<dyn Constraint>>,
        prescribed: Vec<Prescribed>,
    ) -> Result<Self, SystemError> {
        if effects.is_empty() {
            return Err(SystemError::NoEffect);
        }
        let mut seen = vec![false; 3 * nodes];
        for p in &prescribed {
            if std::mem::replace(&mut seen[p.dof as usize], true) {
                return Err(SystemError::PrescribedTwice { node: p.dof / 3, component: p.dof % 3 });
            }
        }
        // A row that is only watched puts nothing into the tangent.
        let acting = || constraints.iter().filter(|c| c.cone() != Cone::Watched);
        let all = || {
            let of_rows = acting().map(|c| (c.means(), c.blocks()));
            effects.iter().map(|e| (e.capabilities().means, e.blocks())).chain(of_rows)
        };
        let blocks = || all().filter(|(means, _)| means.is_none()).map(|(_, list)| list);
        let coupled = Coupled::new(all().filter_map(|(means, list)| means.map(|means| (means, list))));
        let dofs = Dofs::new(nodes, hosts, &prescribed, blocks(), &coupled);
        if dofs.free.is_empty() {
            return Err(SystemError::NothingFree);
        }
        let pattern = {
            let dofs = &dofs;
            let pairs = blocks().flat_map(move |list| {
                (0..list.len()).flat_map(move |b| {
                    let equations = equations(dofs, list, b);
                    (0..equations.len()).flat_map(move |i| {
                        let equations = equations.clone();
                        (0..i).map(move |j| (equations[i], equations[j]))
                    })
                })
            });
            let free = pairs.filter(|p| p.0 != Dofs::FIXED && p.1 != Dofs::FIXED);
            let sparse = SymPattern::from_pairs(dofs.free.len(), free);
            Arc::new(Pattern { low_rank: coupled.low_rank(dofs).into(), ..sparse.into() })
        };
        let slots = |means: Option<&Arc<Means>>, list: &Blocks| match means {
            Some(means) => coupled.slots(&pattern, means, list),
            None => slots(&dofs, &pattern, list),
        };
        let of_effects = effects.iter().map(|e| slots(e.capabilities().means, e.blocks()));
        let of_rows = constraints.iter().map(|c| match c.cone() {
            Cone::Watched => Vec::new(),
            _ => slots(c.means(), c.blocks()),
        });
        let slots = of_effects.chain(of_rows).collect();
        let all = effects.iter().map(|e| e.blocks()).chain(constraints.iter().map(|c| c.blocks()));
        let largest = all.map(Blocks::largest).max().unwrap_or(0);
        let mut histories: Vec<Range<usize>> = Vec::new();
        for e in &effects {
            let start = histories.last().map_or(0, |h| h.end);
            histories.push(start..start + e.blocks().len() * e.capabilities().history_size());
        }
        let skewed = (0..effects.len()).filter(|&e| effects[e].capabilities().skew.is_some()).collect();
        let meeting = (0..effects.len()).filter(|&e| effects[e].capabilities().transient.is_some()).collect();
        let slides = effects.iter().filter_map(|e| e.capabilities().contact_points).any(|points| points.has_friction());
        Ok(Self { effects, constraints, prescribed, dofs, pattern, slots, largest, skewed, meeting, slides, histories })
    }

    /// Where the history of effect `e` lies in that of the state.
    pub(super) fn histories(&self, e: usize) -> Range<usize> {
        self.histories[e].clone()
    }

    /// Slots of the local entries of effect or row `i`.
    pub(super) fn slots(&self, i: usize) -> &[u32] {
        &self.slots[i]
    }

    /// Unknowns of the largest block.
    pub(super) fn largest(&self) -> usize {
        self.largest
    }

    /// Room for the sums.
    pub fn workspace(&self) -> Assembled {
        let n = self.dofs.free.len();
        let of_effects = self.effects.iter().map(|e| (e.name(), Some(e.role())));
        let names = of_effects.chain(self.constraints.iter().map(|c| (c.name(), None)));
        Assembled {
            r: vec![0.0; self.dofs.equation.len()],
            k: vec![0.0; self.pattern.nnz()],
            pattern: self.pattern.clone(),
            moved: Vec::new(),
            skew: SkewMatrix::default(),
            lift: vec![0.0; n],
            g: vec![0.0; self.constraints.len()],
            carried: vec![0.0; self.constraints.len()],
            gradient: vec![vec![0.0; n]; self.constraints.len()],
            scale: 0.0,
            energy: vec![0.0; self.effects.len()],
            dissipated: vec![0.0; self.effects.len()],
            projected: false,
            descending: false,
            costs: names
                .map(|(name, role)| Cost { name: name.into(), role, time: Duration::ZERO, evaluations: 0 })
                .collect(),
            caches: Caches::default(),
        }
    }

    /// Sums residual and, if wanted, tangent. `increment` \[unknowns\] is a prescribed change whose forces go into `lift`.
    pub fn assemble(
        &self,
        at: &At,
        lambda: &[f64],
        want: Want,
        increment: Option<&[f64]>,
        out: &mut Assembled,
    ) -> Result<(), EvalError> {
        out.r.fill(0.0);
        out.lift.fill(0.0);
        out.scale = 0.0;
        if want == Want::Tangent {
            out.clear_tangent(self);
        }
        let mut met = TransientTangents::default();
        let mut local = BlockValues::new(self.largest);
        for (e, effect) in self.effects.iter().enumerate() {
            let start = Instant::now();
            let capabilities = effect.capabilities();
            let mut sum = 0.0;
            let mut scatter = Scatter { system: self, list: effect.blocks(), slots: &self.slots[e], next: 0 };
            out.energy[e] = 0.0;
            out.dissipated[e] = 0.0;
            let at = &At { history: &at.history[self.histories[e].clone()], ..*at };
            let single = match capabilities.batched.filter(|_| !(out.projected && want == Want::Tangent)) {
                Some(batched) => sum_batches(batched, at, want, increment, &mut scatter, (e, &mut sum), out)?,
                None => 0,
            };
            if let Some(means) = capabilities.means {
                sum += self.add_effect_by_means((e, means), at, want, increment, out)?;
            }
            if self.meeting.contains(&e) {
                sum += self.add_meeting((e, &mut met), at, want, increment, out)?;
            }
            let active = capabilities.active.map(|list| list.active(at, &mut out.caches));
            let all = if capabilities.means.is_some() { 0 } else { effect.blocks().len() };
            for i in single..active.as_ref().map_or(all, Vec::len) {
                let b = active.as_ref().map_or(i, |list| list[i] as usize);
                let n = effect.blocks().size(b);
                if active.is_some() {
                    scatter.next = b * n * (n + 1) / 2;
                }
                local.reset(n, want);
                effect.eval(at, b, want, &mut local)?;
                if (out.projected || out.descending && capabilities.semidefinite) && want == Want::Tangent {
                    project(&mut local, n, 3 * effect.blocks().nodes(b).len());
                }
                out.energy[e] += local.energy;
                out.dissipated[e] += local.dissipated;
                sum += norm(&local.r[..n]);
                scatter.add(b, &local, 1.0, want, increment, out);
            }
            out.scale = f64::max(out.scale, sum);
            out.costs[e].time += start.elapsed();
            out.costs[e].evaluations += 1;
        }
        for (c, constraint) in self.constraints.iter().enumerate() {
            let start = Instant::now();
            let i = self.effects.len() + c;
            let mut scatter = Scatter { system: self, list: constraint.blocks(), slots: &self.slots[i], next: 0 };
            let mut sum = 0.0;
            let watched = constraint.cone() == Cone::Watched;
            out.g[c] = constraint.target(at.clock()) + constraint.compliance() * lambda[c];
            out.gradient[c].fill(0.0);
            out.carried[c] = 0.0;
            if let Some(means) = constraint.means() {
                sum += self.add_row_by_means((c, means), at.x, lambda[c], (want, increment), out)?;
            }
            for b in (0..constraint.blocks().len()).filter(|_| constraint.means().is_none()) {
                let n = constraint.blocks().size(b);
                local.reset(n, want);
                constraint.eval(at.x, b, want, &mut local)?;
                out.g[c] -= local.energy;
                sum += lambda[c].abs() * norm(&local.r[..n]);
                for (dof, r) in constraint.blocks().dofs(b).zip(&local.r[..n]) {
                    match self.dofs.equation[dof as usize] {
                        Dofs::FIXED => out.carried[c] += increment.map_or(0.0, |d| r * d[dof as usize]),
                        equation => out.gradient[c][equation as usize] += r,
                    }
                }
                if !watched {
                    scatter.add(b, &local, lambda[c], want, increment, out);
                }
            }
            out.scale = f64::max(out.scale, sum);
            out.costs[i].time += start.elapsed();
            out.costs[i].evaluations += 1;
        }
        if want == Want::Tangent && !self.meeting.is_empty() {
            out.take_in(self, &met, at.x);
        }
        if want == Want::Tangent && !self.skewed.is_empty() {
            self.add_skew(at, increment, out);
        }
        Ok(())
    }

    /// Whether any effect describes contact.
    pub fn has_contact(&self) -> bool {
        self.effects.iter().any(|e| matches!(e.role(), super::EnergyRole::Contact))
    }

    /// The longest part of the motion dx from x that all effects allow; None where that is all of it.
    pub fn max_step(&self, x: &[f64], dx: &[f64], caches: &mut Caches) -> Option<(&str, MotionLimit)> {
        let limits = self.effects.iter().filter_map(|e| {
            let limit = e.capabilities().step_limit?.max_step(x, dx, caches)?;
            Some((e.name(), limit))
        });
        limits.filter(|(_, l)| l.share < 1.0).min_by(|a, b| a.1.share.total_cmp(&b.1.share))
    }

    /// The histories at the end of the accepted step `at` into `new`, which comes with those at its start.
    pub fn advance(&self, at: &At, new: &mut [f64], costs: &mut [Cost]) -> Result<(), EvalError> {
        for (e, effect) in self.effects.iter().enumerate() {
            let Some(history) = effect.capabilities().history else { continue };
            let start = Instant::now();
            let at = At { history: &at.history[self.histories[e].clone()], ..*at };
            for (b, new) in new[self.histories[e].clone()].chunks_exact_mut(history.size()).enumerate() {
                history.advance(&at, b, new)?;
            }
            costs[e].time += start.elapsed();
        }
        Ok(())
    }

    /// Residual on the free dofs, \[equations\].
    pub fn restrict(&self, full: &[f64]) -> Vec<f64> {
        self.dofs.free.iter().map(|&dof| full[dof as usize]).collect()
    }

    /// A state at rest in the reference configuration.
    pub fn rest(&self) -> State {
        let zero = vec![0.0; self.dofs.equation.len()];
        let lambda = vec![0.0; self.constraints.len()];
        let history = vec![0.0; self.histories.last().map_or(0, |h| h.end)];
        State {
            t: 0.0,
            x: zero.clone(),
            v: zero.clone(),
            a: zero,
            lambda,
            memory: Vec::new(),
            dt: 0.0,
            history,
            inputs: Vec::new(),
        }
    }

    /// Equations of the second field: so many negative pivots belong to a stable equilibrium.
    pub fn scalar_equations(&self) -> usize {
        (0..self.dofs.free.len()).filter(|&e| self.dofs.is_scalar(e)).count()
    }

    /// The values g of all rows at a state.
    pub fn gaps(&self, state: &State) -> Result<Vec<f64>, EvalError> {
        let mut local = BlockValues::new(self.largest);
        let mut gaps = Vec::with_capacity(self.constraints.len());
        for (row, lambda) in self.constraints.iter().zip(&state.lambda) {
            let mut g = row.target(state.clock()) + row.compliance() * lambda;
            let seen = row.means().map(|means| means.of(&state.x));
            for b in 0..row.blocks().len() {
                local.reset(row.blocks().size(b), Want::Energy);
                row.eval(seen.as_ref().unwrap_or(&state.x), b, Want::Energy, &mut local)?;
                g -= local.energy;
            }
            gaps.push(g);
        }
        Ok(gaps)
    }
}

fn equations(dofs: &Dofs, list: &Blocks, b: usize) -> std::rc::Rc<[u32]> {
    list.dofs(b).map(|dof| dofs.equation[dof as usize]).collect()
}

fn slots(dofs: &Dofs, pattern: &Pattern, list: &Blocks) -> Vec<u32> {
    let mut out = Vec::new();
    for b in 0..list.len() {
        let equations = equations(dofs, list, b);
        for (i, &row) in equations.iter().enumerate() {
            for &column in &equations[..=i] {
                out.push(if row == Dofs::FIXED || column == Dofs::FIXED {
                    Dofs::FIXED
                } else {
                    pattern.slot(row, column).expect("the pattern holds every pair of a block")
                });
            }
        }
    }
    out
}
