//! What an effect or a constraint is, and what it sees.

use super::rows::{Cone, Piece, Rows};
use super::{Batched, ContactPoints, EvalError, Means, Past, Skew, TransientCoupling};
pub use crate::material::Want;
use crate::math::signal::{Clock, Ramp};
use std::sync::Arc;

/// All that changes during a run. Cloning it is a checkpoint, dropping it a cut step. SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    pub t: f64,
    /// \[3 × nodes + scalars\] displacement \[m\], then the second field (pressures, in units that make them lengths)
    pub x: Vec<f64>,
    /// \[3 × nodes\] velocity \[m/s\]
    pub v: Vec<f64>,
    /// \[3 × nodes\] acceleration \[m/s²\]
    pub a: Vec<f64>,
    /// \[constraints\] multipliers, in the unit that pairs with g (cable: tension \[N\])
    pub lambda: Vec<f64>,
    /// What the integrator remembers besides (BDF2: last x and v; generalised-α: algorithmic acceleration)
    pub memory: Vec<f64>,
    /// Last accepted step \[s\], 0 at the start
    pub dt: f64,
    /// What the effects remember, effect by effect and block by block; zero at rest, empty if none remembers
    pub history: Vec<f64>,
    /// What is known of the signals that are decided on the way; empty if none is
    pub inputs: Vec<Ramp>,
}

impl State {
    /// The time, for signals.
    pub fn clock(&self) -> Clock<'_> {
        Clock { t: self.t, inputs: &self.inputs }
    }

    /// At rest in the reference configuration.
    pub fn rest(nodes: usize, constraints: usize) -> Self {
        let zero = vec![0.0; 3 * nodes];
        Self {
            t: 0.0,
            x: zero.clone(),
            v: zero.clone(),
            a: zero,
            lambda: vec![0.0; constraints],
            memory: Vec::new(),
            dt: 0.0,
            history: Vec::new(),
            inputs: Vec::new(),
        }
    }
}

/// Slopes of the integrator: ∂v/∂x = cv·I \[1/s\], ∂a/∂x = ca·I \[1/s²\]; both 0 in statics.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Rates {
    pub cv: f64,
    pub ca: f64,
}

impl Rates {
    /// Those of steps whose lengths differ by rounding only?
    pub fn is_near(&self, other: &Self) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b.abs();
        near(self.cv, other.cv) && near(self.ca, other.ca)
    }
}

/// What an evaluation sees.
#[derive(Clone, Copy)]
pub struct At<'a> {
    pub t: f64,
    /// Length of the step \[s\], infinite in statics: rates vanish
    pub dt: f64,
    pub x: &'a [f64],
    pub v: &'a [f64],
    pub a: &'a [f64],
    /// x at the start of the step
    pub old: &'a [f64],
    /// History at the start of the step: of the whole state for a system, [blocks × [`Effect::history`]] for an effect
    pub history: &'a [f64],
    pub inputs: &'a [Ramp],
    pub rates: Rates,
}

impl<'a> At<'a> {
    /// The time, for signals.
    pub fn clock(&self) -> Clock<'a> {
        Clock { t: self.t, inputs: self.inputs }
    }
}

/// Which fields an effect reads, beyond x; a static integrator has neither.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Needs {
    pub velocity: bool,
    pub acceleration: bool,
}

/// Unknowns of the contributions (cell, node, cable segment) of an effect: the displacement of some nodes, then scalars
/// of a second field (pressure).
#[derive(Clone, Debug, Default)]
pub struct Blocks {
    offsets: Vec<u32>,
    nodes: Vec<u32>,
    scalar_offsets: Vec<u32>,
    scalars: Vec<u32>,
}

impl Blocks {
    pub fn new<'a>(lists: impl Iterator<Item = &'a [u32]>) -> Self {
        Self::with_scalars(lists.map(|nodes| (nodes, &[][..])))
    }

    /// Node list and unknowns of the second field (their places in `State::x`) of each block.
    pub fn with_scalars<'a>(lists: impl Iterator<Item = (&'a [u32], &'a [u32])>) -> Self {
        let (mut out, mut count) = (Self::default(), 0);
        out.offsets.push(0);
        out.scalar_offsets.push(0);
        for (nodes, scalars) in lists {
            out.nodes.extend_from_slice(nodes);
            out.scalars.extend_from_slice(scalars);
            out.offsets.push(out.nodes.len() as u32);
            out.scalar_offsets.push(out.scalars.len() as u32);
            count += 1;
        }
        debug_assert_eq!(out.len(), count);
        out
    }

    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Nodes of block `b`.
    pub fn nodes(&self, b: usize) -> &[u32] {
        &self.nodes[self.offsets[b] as usize..self.offsets[b + 1] as usize]
    }

    /// Unknowns of the second field of block `b`.
    pub fn scalars(&self, b: usize) -> &[u32] {
        &self.scalars[self.scalar_offsets[b] as usize..self.scalar_offsets[b + 1] as usize]
    }

    /// Places in `State::x` of the unknowns of block `b`: 3·node + component node by node, then the scalars.
    pub fn dofs(&self, b: usize) -> impl Iterator<Item = u32> + '_ {
        let displacements = self.nodes(b).iter().flat_map(|&n| 3 * n..3 * n + 3);
        displacements.chain(self.scalars(b).iter().copied())
    }

    /// Number of unknowns of block `b`.
    pub fn size(&self, b: usize) -> usize {
        3 * self.nodes(b).len() + self.scalars(b).len()
    }

    /// Unknowns of the largest block.
    pub fn largest(&self) -> usize {
        (0..self.len()).map(|b| self.size(b)).max().unwrap_or(0)
    }
}

/// Buffers of one block, zeroed before each evaluation.
pub struct Local {
    /// Π_e \[J\], or the share of g
    pub energy: f64,
    /// What the step dissipates \[J\], of a [`Role::Relaxing`]
    pub dissipated: f64,
    /// \[n\] r_e = ∂Π_e/∂x_e \[N\]
    pub r: Vec<f64>,
    /// \[n × n\] row by row; only entries with column ≤ row are read. K_e = ∂r/∂x + cv ∂r/∂v + ca ∂r/∂a \[N/m\]
    pub k: Vec<f64>,
}

impl Local {
    pub fn new(n: usize) -> Self {
        Self { energy: 0.0, dissipated: 0.0, r: vec![0.0; n], k: vec![0.0; n * n] }
    }

    /// r += factor K_e dx on the chosen rows; the dofs are those of the block.
    pub(super) fn add_product(&self, dofs: &[u32], row: impl Fn(u32) -> bool, factor: f64, dx: &[f64], r: &mut [f64]) {
        let n = dofs.len();
        for (i, &to) in dofs.iter().enumerate().filter(|(_, to)| row(**to)) {
            let entry = |(j, from): (usize, &u32)| self.k[i.max(j) * n + i.min(j)] * dx[*from as usize];
            r[to as usize] += factor * dofs.iter().enumerate().map(entry).sum::<f64>();
        }
    }

    pub(super) fn reset(&mut self, n: usize, want: Want) {
        self.energy = 0.0;
        self.dissipated = 0.0;
        self.r[..n].fill(0.0);
        if want == Want::Tangent {
            self.k[..n * n].fill(0.0);
        }
    }
}

/// How far a motion may go before an effect loses its meaning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Share of the motion, 0 to 1
    pub share: f64,
    /// Node that stops it
    pub node: u32,
    /// How far that node is from what it must not pass \[m\]
    pub gap: f64,
}

/// One physical contribution to the residual.
pub trait Effect: Send + Sync {
    fn name(&self) -> &str;
    fn needs(&self) -> Needs {
        Needs::default()
    }
    fn blocks(&self) -> &Blocks;
    /// The means by which alone it sees the body: its blocks are lists of means instead of nodes then, and [`At::x`] is theirs. Such an
    /// effect reads x only, and all of its blocks contribute at every state.
    fn means(&self) -> Option<&Arc<Means>> {
        None
    }
    /// Energy, r_e and K_e of block `b`. What the energy is depends on [`Effect::role`].
    fn eval(&self, at: &At, b: usize, want: Want, out: &mut Local) -> Result<(), EvalError>;
    fn role(&self) -> Role;
    /// s(t) of a [`Role::Load`] or [`Role::Follower`]
    fn intensity(&self, _now: Clock) -> f64 {
        1.0
    }
    /// Numbers that each block carries from step to step, zero at rest
    fn history(&self) -> usize {
        0
    }
    /// The history of block `b` at the end of the accepted step `at`. `new` \[history\] comes with the one at its start.
    fn advance(&self, _at: &At, _b: usize, _new: &mut [f64]) -> Result<(), EvalError> {
        Ok(())
    }
    /// Blocks that contribute at this state, ascending; None where all do. Such an effect has blocks of one size.
    fn active(&self, _at: &At) -> Option<Vec<u32>> {
        None
    }
    /// Couples it parts that meet at one state and part again? Its blocks are those of [`Effect::meeting`] then
    fn meets(&self) -> bool {
        false
    }
    /// What it couples at this state
    fn meeting<'a>(&'a self, _at: &At) -> Option<Box<dyn TransientCoupling + 'a>> {
        None
    }
    /// Do Newton's steps take K_e without its negative eigenvalues, because these would make most tangents indefinite?
    fn semidefinite(&self) -> bool {
        false
    }
    /// The longest part of the motion dx from x that it allows; None where that is all of it
    fn max_step(&self, _x: &[f64], _dx: &[f64]) -> Option<Limit> {
        None
    }
    /// Derivatives by what it reads beyond x; None where that is nothing, or where they are not there
    fn past(&self) -> Option<&dyn Past> {
        None
    }
    /// The part of ∂r/∂x that K_e, which is symmetric, does not hold; None where that is nothing
    fn skew(&self) -> Option<&dyn Skew> {
        None
    }
    /// Its points, where their forces can be given from outside
    fn touching(&self) -> Option<&dyn ContactPoints> {
        None
    }
    /// Its blocks side by side, where it can evaluate them so; all of one size, then
    fn batched(&self) -> Option<&dyn Batched> {
        None
    }
}

/// A shared effect, which probes or other effects look at too.
impl<E: Effect + ?Sized> Effect for Arc<E> {
    fn name(&self) -> &str {
        (**self).name()
    }
    fn needs(&self) -> Needs {
        (**self).needs()
    }
    fn blocks(&self) -> &Blocks {
        (**self).blocks()
    }
    fn means(&self) -> Option<&Arc<Means>> {
        (**self).means()
    }
    fn eval(&self, at: &At, b: usize, want: Want, out: &mut Local) -> Result<(), EvalError> {
        (**self).eval(at, b, want, out)
    }
    fn role(&self) -> Role {
        (**self).role()
    }
    fn intensity(&self, now: Clock) -> f64 {
        (**self).intensity(now)
    }
    fn history(&self) -> usize {
        (**self).history()
    }
    fn advance(&self, at: &At, b: usize, new: &mut [f64]) -> Result<(), EvalError> {
        (**self).advance(at, b, new)
    }
    fn active(&self, at: &At) -> Option<Vec<u32>> {
        (**self).active(at)
    }
    fn meets(&self) -> bool {
        (**self).meets()
    }
    fn meeting<'a>(&'a self, at: &At) -> Option<Box<dyn TransientCoupling + 'a>> {
        (**self).meeting(at)
    }
    fn semidefinite(&self) -> bool {
        (**self).semidefinite()
    }
    fn max_step(&self, x: &[f64], dx: &[f64]) -> Option<Limit> {
        (**self).max_step(x, dx)
    }
    fn past(&self) -> Option<&dyn Past> {
        (**self).past()
    }
    fn skew(&self) -> Option<&dyn Skew> {
        (**self).skew()
    }
    fn touching(&self) -> Option<&dyn ContactPoints> {
        (**self).touching()
    }
    fn batched(&self) -> Option<&dyn Batched> {
        (**self).batched()
    }
}

/// Place of an effect in the energy balance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Energy ψ with r = ∂ψ/∂x
    Stored,
    /// Energy ψ with r = ∂ψ/∂x, of what touches at times and does not hold parts together
    Contact,
    /// Energy ½ v·Mv with r = M a
    Kinetic,
    /// Energy: what the step dissipates, r·(x − old)
    Dissipative,
    /// Energy ψ, stored; what r has beyond ∂ψ/∂x fades, and its work over the step is `Local::dissipated`
    Relaxing,
    /// Energy φ per unit intensity, r = s(t) ∂φ/∂x: the load does the work −∫ s dφ
    Load,
    /// A load without a potential. Energy: of the step, ∫ dφ per unit intensity with r = s(t) dφ/dx; its work is −∫ s dφ
    Follower,
}

/// One exact row g(x, t, λ) = target(t) + compliance·λ − Σ_b c_b(x), with a multiplier λ that is the answer (cable: tension).
///
/// The residual gets λ ∂c/∂x, the tangent λ ∂²c/∂x²: with `Π + λ (c − target) − ½ compliance λ²` as the Lagrangian.
pub trait Constraint: Send + Sync {
    fn name(&self) -> &str;
    fn cone(&self) -> Cone;
    /// Unit of g: a length or volume to which |g| is compared
    fn scale(&self) -> f64;
    fn target(&self, now: Clock) -> f64;
    /// ∂g/∂λ ≥ 0: of a cable, how much longer a newton makes it \[m/N\]. It stores ½ compliance λ² \[J\].
    fn compliance(&self) -> f64 {
        0.0
    }
    fn blocks(&self) -> &Blocks;
    /// As [`Effect::means`]
    fn means(&self) -> Option<&Arc<Means>> {
        None
    }
    /// c_b, ∂c_b/∂x, ∂²c_b/∂x² of block `b` in `energy`, `r`, `k`. A [`Cone::Watched`] row needs no second derivative.
    fn eval(&self, x: &[f64], b: usize, want: Want, out: &mut Local) -> Result<(), EvalError>;
    /// The law of a [`Cone::Linked`] row, which is row `c` of the system.
    fn pieces(&self, _c: usize, _rows: &Rows) -> Vec<Piece> {
        Vec::new()
    }
    /// What row `c` dissipates \[J\] between two states, `[past, now]` of g and λ of all rows, by the trapezoidal rule.
    fn dissipated(&self, _c: usize, _g: [&[f64]; 2], _lambda: [&[f64]; 2]) -> f64 {
        0.0
    }
}
