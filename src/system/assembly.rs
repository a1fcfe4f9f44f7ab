//! Residual and tangent: one loop over the contributions of all effects and constraints.
//!
//! Blocks are summed in their order, or in that of their [groups](super::groups), so that the result does not depend on how many threads or cases run
//! at the same time.

use super::contribution::{Contribution, Coupling, Kernel, Receiver};
use super::groups::Grouped;
use super::projection::project;
use super::skew;
use super::transient::TransientTangents;
use super::vertex_pairs::triangle;
use super::{Assembled, At, Batched, BlockValues, Blocks, Dofs, EvalError, Means, State, System, Want};
use crate::math::vector::norm;
use std::time::Instant;

impl System {
    /// Sums the residual and, if wanted, the tangent. `increment` \[unknowns\] is a prescribed change of the dofs that are not free, whose forces are
    /// also summed.
    pub fn assemble(
        &self,
        at: &At,
        lambda: &[f64],
        want: Want,
        increment: Option<&[f64]>,
        out: &mut Assembled,
    ) -> Result<(), EvalError> {
        let tangent = want == Want::Tangent;
        out.clear(tangent.then(|| self.pattern.nnz()));
        let mut assembly = Assembly { system: self, want, increment, out, transient: TransientTangents::default() };
        for (e, effect) in self.effects.iter().enumerate() {
            let start = Instant::now();
            let at = &self.inputs_of(e, at);
            let capabilities = effect.capabilities();
            if assembly.out.without_contact_points && capabilities.on_contact_points {
                continue;
            }
            let mut own = self.effect(e);
            own.projected = tangent && (assembly.out.projected || assembly.out.descending && capabilities.semidefinite);
            own.keeps_remainder = tangent && assembly.out.descending && !assembly.out.projected;
            let active = capabilities.active.map(|blocks| blocks.active(at, &mut assembly.out.caches));
            let batched = capabilities.batched.filter(|_| !(tangent && assembly.out.projected));
            let mut forces = assembly.add_effect(&own, e, at, batched, active.as_deref())?;
            if let Some(coupling) = capabilities.transient {
                let kernel = Kernel::Transient(coupling.blocks_at(at, &mut assembly.out.caches));
                let transient = Contribution { kernel, coupling: Coupling::Transient, ..own };
                forces += assembly.add(&transient, at, None)?;
            }
            assembly.finish(e, forces, start);
        }
        for (c, constraint) in self.constraints.iter().enumerate() {
            let start = Instant::now();
            assembly.out.g[c] = constraint.target(at.clock()) + constraint.compliance() * lambda[c];
            let forces = assembly.add(&self.constraint(c, lambda[c]), at, None)?;
            assembly.finish(self.effects.len() + c, forces, start);
        }
        if tangent {
            let Assembly { out, transient, .. } = assembly;
            transient.insert(self, at.x, out);
            skew::add(self, at, increment, out);
        }
        Ok(())
    }

    /// The values g of all constraints at a state.
    pub fn gaps(&self, state: &State) -> Result<Vec<f64>, EvalError> {
        let mut values = BlockValues::new(self.largest());
        let mut gaps = Vec::with_capacity(self.constraints.len());
        for (c, (constraint, lambda)) in self.constraints.iter().zip(&state.lambda).enumerate() {
            let mut g = constraint.target(state.clock()) + constraint.compliance() * lambda;
            let x = self.constraint(c, *lambda).positions(&state.x);
            for b in 0..constraint.blocks().len() {
                values.reset(constraint.blocks().size(b), Want::Energy);
                constraint.eval(&x, b, Want::Energy, &mut values)?;
                g -= values.energy;
            }
            gaps.push(g);
        }
        Ok(gaps)
    }
}

/// One assembly in progress.
struct Assembly<'a> {
    system: &'a System,
    want: Want,
    increment: Option<&'a [f64]>,
    out: &'a mut Assembled,
    transient: TransientTangents,
}

impl Assembly<'_> {
    /// Adds the blocks of effect `index`, or those of `active` if there is such a list; returns Σ_e ‖r_e‖ of its forces.
    fn add_effect(
        &mut self,
        of: &Contribution,
        index: usize,
        at: &At,
        batched: Option<&dyn Batched>,
        active: Option<&[u32]>,
    ) -> Result<f64, EvalError> {
        let (Coupling::Groups(groups), Kernel::Effect(effect)) = (of.coupling, &of.kernel) else {
            return self.add(of, at, active);
        };
        // A placeholder for an effect that does not vary
        if effect.blocks().is_empty() {
            return Ok(0.0);
        }
        let (want, increment, equation) = (self.want, self.increment, &self.system.dofs.equation[..]);
        let grouped =
            Grouped { effect: *effect, index, groups, batched, projected: of.projected, want, increment, equation };
        grouped.add(at, self.out)
    }

    /// Adds a contribution, restricted to the blocks of `active` if there is such a list; returns Σ_e ‖r_e‖ of its forces.
    fn add(&mut self, of: &Contribution, at: &At, active: Option<&[u32]>) -> Result<f64, EvalError> {
        let (blocks, x) = (of.kernel.blocks(), of.positions(at.x));
        let at = &At { x: &x, ..*at };
        let mut forces = 0.0;
        let mut values = BlockValues::new(if of.is_transient() { blocks.largest() } else { self.system.largest() });
        let mut sums = of.means().map(|means| MeanSums::new(means, self.increment));
        let mut next = 0;
        for i in 0..active.map_or(blocks.len(), <[u32]>::len) {
            let b = active.map_or(i, |list| list[i] as usize);
            let n = blocks.size(b);
            let start = if active.is_some() { b * triangle(n) } else { next };
            next = start + triangle(n);
            values.reset(n, self.want);
            of.kernel.eval(at, b, self.want, &mut values)?;
            if of.projected {
                project(&mut values, n, 3 * blocks.nodes(b).len());
            }
            if let Some(unsymmetric) = of.unsymmetric() {
                let mut part = BlockValues::new(n);
                unsymmetric.eval(at, b, &mut part)?;
                self.add_remainder(blocks, b, |i, j| part.k[i * n + j]);
            }
            match &mut sums {
                Some(sums) => sums.add(blocks, b, &values),
                None => {
                    self.add_energy(of, values.energy, values.dissipated);
                    forces += of.size() * norm(&values.r[..n]);
                    self.add_vector(of, blocks, b, &values.r);
                }
            }
            if let (Want::Tangent, Some(weight)) = (self.want, of.weight) {
                match of.coupling {
                    Coupling::Dofs(slots) | Coupling::Means(_, slots) => {
                        add_matrix(&mut self.out.k, &slots[start..next], n, &values.k, weight);
                    }
                    Coupling::Groups(_) => unreachable!("the blocks of groups are added by groups"),
                    Coupling::Transient => self.transient.push(self.system, blocks, b, &values),
                }
                match &mut sums {
                    Some(sums) => sums.add_increment_force(blocks, b, &values, weight),
                    None => self.add_increment_force(blocks, b, &values, weight),
                }
            }
        }
        if let Some(sums) = sums {
            forces += of.size() * sums.forces;
            self.spread(of, &sums);
        }
        Ok(forces)
    }

    /// Adds the part of the tangent of block `b` that K leaves out, on the free dofs.
    fn add_remainder(&mut self, blocks: &Blocks, b: usize, entry: impl Fn(usize, usize) -> f64) {
        let equations: Vec<u32> = blocks.dofs(b).map(|dof| self.system.dofs.equation[dof as usize]).collect();
        let free = || equations.iter().enumerate().filter(|(_, equation)| **equation != Dofs::FIXED);
        for ((i, &row), (j, &column)) in free().flat_map(|row| free().map(move |column| (row, column))) {
            let value = entry(i, j);
            if value != 0.0 {
                self.out.remainder.entries.push((row, column, value));
            }
        }
    }

    fn add_energy(&mut self, of: &Contribution, energy: f64, dissipated: f64) {
        match of.receiver {
            Receiver::Effect(e) => {
                self.out.energy[e] += energy;
                self.out.dissipated[e] += dissipated;
            }
            Receiver::Constraint(c) => self.out.g[c] -= energy,
        }
    }

    /// Adds r of block `b` to the residual, and to the gradient of a constraint.
    fn add_vector(&mut self, of: &Contribution, blocks: &Blocks, b: usize, r: &[f64]) {
        for (dof, r) in blocks.dofs(b).zip(r) {
            if let Receiver::Constraint(c) = of.receiver {
                self.add_gradient(c, dof, *r);
            }
            if let Some(weight) = of.weight {
                self.out.r[dof as usize] += weight * r;
            }
        }
    }

    /// Adds ∂c/∂x at a dof to the gradient if the dof is free; otherwise its product with the prescribed increment.
    fn add_gradient(&mut self, c: usize, dof: u32, value: f64) {
        match self.system.dofs.equation[dof as usize] {
            Dofs::FIXED => self.out.increment_gap[c] += self.increment.map_or(0.0, |d| value * d[dof as usize]),
            equation => self.out.gradient[c][equation as usize] += value,
        }
    }

    /// Adds weight · K_e d_e on the free dofs of block `b`; the prescribed increment d is zero on these dofs.
    fn add_increment_force(&mut self, blocks: &Blocks, b: usize, values: &BlockValues, weight: f64) {
        let Some(d) = self.increment else { return };
        let n = blocks.size(b);
        for (j, from) in blocks.dofs(b).enumerate() {
            let dj = weight * d[from as usize];
            if dj == 0.0 {
                continue;
            }
            for (i, to) in blocks.dofs(b).enumerate() {
                let equation = self.system.dofs.equation[to as usize];
                if equation != Dofs::FIXED {
                    self.out.increment_force[equation as usize] += values.k[i.max(j) * n + i.min(j)] * dj;
                }
            }
        }
    }

    /// Adds the sums over means to those of the system.
    fn spread(&mut self, of: &Contribution, sums: &MeanSums) {
        self.add_energy(of, sums.energy, sums.dissipated);
        sums.means.spread(&sums.r, |dof, r| {
            if let Receiver::Constraint(c) = of.receiver {
                self.add_gradient(c, dof, r);
            }
            if let Some(weight) = of.weight {
                self.out.r[dof as usize] += weight * r;
            }
        });
        if sums.increment.is_some() {
            sums.means.spread(&sums.increment_force, |dof, force| {
                let equation = self.system.dofs.equation[dof as usize];
                if let Some(to) = self.out.increment_force.get_mut(equation as usize) {
                    *to += force;
                }
            });
        }
    }

    /// Completes the sums and the cost of effect or constraint `i`.
    fn finish(&mut self, i: usize, forces: f64, start: Instant) {
        self.out.scale = f64::max(self.out.scale, forces);
        self.out.costs[i].time += start.elapsed();
        self.out.costs[i].evaluations += 1;
    }
}

/// Sums over the blocks of a contribution that depends on the body through means.
struct MeanSums<'a> {
    means: &'a Means,
    energy: f64,
    dissipated: f64,
    /// Σ_e ‖B r_e‖
    forces: f64,
    /// \[3 × means\] r_w
    r: Vec<f64>,
    /// \[3 × means\] means of the prescribed increment
    increment: Option<Vec<f64>>,
    /// \[3 × means\] weight · K_w times the increment
    increment_force: Vec<f64>,
}

impl<'a> MeanSums<'a> {
    fn new(means: &'a Means, increment: Option<&[f64]>) -> Self {
        let (r, increment) = (vec![0.0; 3 * means.len()], increment.map(|d| means.of(d)));
        Self { means, energy: 0.0, dissipated: 0.0, forces: 0.0, increment_force: r.clone(), r, increment }
    }

    fn add(&mut self, blocks: &Blocks, b: usize, values: &BlockValues) {
        self.energy += values.energy;
        self.dissipated += values.dissipated;
        self.forces += self.means.norm(blocks.nodes(b), &values.r[..blocks.size(b)]);
        blocks.dofs(b).zip(&values.r).for_each(|(dof, r)| self.r[dof as usize] += r);
    }

    fn add_increment_force(&mut self, blocks: &Blocks, b: usize, values: &BlockValues, weight: f64) {
        if let Some(increment) = &self.increment {
            let dofs: Vec<u32> = blocks.dofs(b).collect();
            values.add_product(&dofs, |_| true, weight, increment, &mut self.increment_force);
        }
    }
}

/// Adds weight · K_e of a block of `n` unknowns to the values in these slots.
fn add_matrix(to: &mut [f64], slots: &[u32], n: usize, k: &[f64], weight: f64) {
    let mut start = 0;
    for (i, row) in k.chunks_exact(n).take(n).enumerate() {
        for (value, &slot) in row[..=i].iter().zip(&slots[start..=start + i]) {
            // Slots of prescribed dofs are beyond the end
            if let Some(to) = to.get_mut(slot as usize) {
                *to += weight * value;
            }
        }
        start += i + 1;
    }
}
