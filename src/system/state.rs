//! The state of a run, and the inputs of one evaluation.

use crate::math::signal::{Clock, Known};

/// Everything that changes during a run, in SI units. A clone is a checkpoint of the mechanics.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    pub t: f64,
    /// \[3 × nodes + scalars\] displacement \[m\], then the second field (pressures, scaled to lengths)
    pub x: Vec<f64>,
    /// \[3 × nodes + scalars\] velocity \[m/s\]
    pub v: Vec<f64>,
    /// \[3 × nodes + scalars\] acceleration \[m/s²\]
    pub a: Vec<f64>,
    /// \[constraints\] multipliers, in the unit that is conjugate to g (for a cable, the tension \[N\])
    pub lambda: Vec<f64>,
    /// Further variables of the integrator (BDF2: previous x and v; generalised-α: algorithmic acceleration; at a start, the known accelerations)
    pub memory: Vec<f64>,
    /// Last accepted step \[s\], 0 at the start
    pub dt: f64,
    /// History variables of the effects, effect by effect and block by block; zero at rest, empty if no effect has any
    pub history: Vec<f64>,
    /// The known part of the signals that are set during the run; empty without such signals
    pub inputs: Vec<Known>,
}

impl State {
    /// The time, for signals.
    pub fn clock(&self) -> Clock<'_> {
        Clock { t: self.t, inputs: &self.inputs }
    }

    /// The inputs of an evaluation at this state itself, not at the end of a step: `old` is x, no time has passed, and the rates do not depend on x.
    ///
    /// ```
    /// use durometer::prelude::*;
    ///
    /// let state = State { t: 0.5, ..State::rest(8, 0) };
    /// // The inputs of a static step from rest
    /// let old = State::rest(8, 0).x;
    /// let at = At { dt: f64::INFINITY, old: &old, ..state.at() };
    /// assert!(at.is_static() && at.t == 0.5 && at.x.len() == 24);
    /// ```
    pub fn at(&self) -> At<'_> {
        let Self { t, x, v, a, history, inputs, .. } = self;
        At { t: *t, dt: 0.0, x, v, a, old: x, history, inputs, rates: Rates::default() }
    }

    /// A state at rest in the reference configuration.
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

/// Derivatives of the rates with respect to x that the integrator implies: ∂v/∂x = cv·I \[1/s\], ∂a/∂x = ca·I \[1/s²\]; both 0 in statics.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Rates {
    pub cv: f64,
    pub ca: f64,
}

impl Rates {
    /// Whether both belong to steps whose lengths differ only by rounding.
    pub fn is_near(&self, other: &Self) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b.abs();
        near(self.cv, other.cv) && near(self.ca, other.ca)
    }
}

/// Inputs of one evaluation; [`State::at`] builds them.
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
    /// History at the start of the step: the whole history of the state for a system, [blocks × `HistoryVariables::size`] for an effect
    pub history: &'a [f64],
    pub inputs: &'a [Known],
    pub rates: Rates,
}

impl<'a> At<'a> {
    /// Whether the evaluation is static: time only orders the loads, and rates vanish.
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

/// Derivatives of the inputs of an evaluation with respect to a parameter.
#[derive(Clone, Copy)]
pub struct Perturbation<'a> {
    pub x: &'a [f64],
    /// Derivative of v at fixed x, as for `a`, without the part that K contains through cv and ca
    pub v: &'a [f64],
    pub a: &'a [f64],
    pub old: &'a [f64],
    /// Derivative of the history, with the extent of [`At::history`]
    pub history: &'a [f64],
}
