//! The state of a run, and the inputs of one evaluation.

use crate::math::signal::{Clock, Known};

/// Everything that changes during a run, in SI units. A clone of it is a checkpoint of the mechanics.
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
    /// Further variables of the integrator (BDF2: last x and v; generalised-α: algorithmic acceleration; at a start the known accelerations)
    pub memory: Vec<f64>,
    /// Last accepted step \[s\], 0 at the start
    pub dt: f64,
    /// History variables of the effects, effect by effect and block by block; zero at rest, empty if no effect has any
    pub history: Vec<f64>,
    /// The signals that are decided during the run, as they are known; empty if there are none
    pub inputs: Vec<Known>,
}

impl State {
    /// The time, for signals.
    pub fn clock(&self) -> Clock<'_> {
        Clock { t: self.t, inputs: &self.inputs }
    }

    /// The inputs of an evaluation at this state, which no step has led to: `old` is x, no time has passed, and the rates do not depend on x.
    ///
    /// ```
    /// use durometer::prelude::*;
    ///
    /// let state = State { t: 0.5, ..State::rest(8, 0) };
    /// // That of a static step from rest
    /// let old = State::rest(8, 0).x;
    /// let at = At { dt: f64::INFINITY, old: &old, ..state.at() };
    /// assert!(at.is_static() && at.t == 0.5 && at.x.len() == 24);
    /// ```
    pub fn at(&self) -> At<'_> {
        let Self { t, x, v, a, history, inputs, .. } = self;
        At { t: *t, dt: 0.0, x, v, a, old: x, history, inputs, rates: Rates::default() }
    }

    /// Rest in the reference configuration.
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

/// Derivatives of the rates by x that the integrator implies: ∂v/∂x = cv·I \[1/s\], ∂a/∂x = ca·I \[1/s²\]; both 0 in statics.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Rates {
    pub cv: f64,
    pub ca: f64,
}

impl Rates {
    /// Whether both belong to steps whose lengths differ by rounding only.
    pub fn is_near(&self, other: &Self) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b.abs();
        near(self.cv, other.cv) && near(self.ca, other.ca)
    }
}

/// Inputs of one evaluation; [`State::at`] makes one.
#[derive(Clone, Copy)]
pub struct At<'a> {
    pub t: f64,
    /// Length of the step \[s\]: infinite in statics, where rates vanish, and 0 at the start of a stage
    pub dt: f64,
    pub x: &'a [f64],
    pub v: &'a [f64],
    pub a: &'a [f64],
    /// x at the start of the step
    pub old: &'a [f64],
    /// History at the start of the step: of the whole state for a system, [blocks × `HistoryVariables::size`] for an effect
    pub history: &'a [f64],
    pub inputs: &'a [Known],
    pub rates: Rates,
}

impl<'a> At<'a> {
    /// Whether time only orders the loads, and nothing has a rate.
    pub fn is_static(&self) -> bool {
        self.dt.is_infinite()
    }

    /// Whether no time has passed since the last state: `x` is `old`, and the rates are those of v.
    pub fn is_start(&self) -> bool {
        self.dt == 0.0
    }

    /// The time, for signals.
    pub fn clock(&self) -> Clock<'a> {
        Clock { t: self.t, inputs: self.inputs }
    }
}

/// Derivatives of the inputs of an evaluation by a parameter.
#[derive(Clone, Copy)]
pub struct Perturbation<'a> {
    pub x: &'a [f64],
    /// Of v and a at fixed x, without the part that K contains through cv and ca
    pub v: &'a [f64],
    pub a: &'a [f64],
    pub old: &'a [f64],
    /// As in [`At`]: of the whole state for a system, of its blocks for an effect
    pub history: &'a [f64],
}
