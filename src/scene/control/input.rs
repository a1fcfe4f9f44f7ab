//! Signals that are decided during a run: by events, by recorded columns, or from outside.
//!
//! An input is decided at each point tₙ of the time grid for the next one, tₙ₊₁, from the row recorded at tₙ. Within the step it is linear, so that a step
//! that is cut applies only a part of the change. A function of time that no event replaces at that point is followed exactly, with its values and rates at
//! any time. Evaluations look inputs up in the state and remain pure.

use super::ControlError;
use super::memory::{ControlMemory, Program};
use crate::math::formula::Formula;
use crate::math::signal::{Clock, Known, Ramp, Signal};

/// Source of the value of an input.
#[derive(Clone, Debug)]
pub enum Source {
    /// A signal that events replace by other signals
    Switched { own: Signal, others: Vec<Other> },
    /// A formula in recorded columns; `event`: the event from which its time counts
    Formula { formula: Formula, event: Option<usize>, variables: Vec<Variable> },
    /// Set from outside
    Controlled { initial: f64, range: Option<(f64, f64)> },
}

impl Source {
    /// The value before the first step; 0 for a formula, whose columns are not yet recorded.
    pub(super) fn initial(&self) -> Known {
        match self {
            Self::Switched { own, .. } if own.has_inputs() => Known::constant(own.at(0.0)),
            Self::Switched { .. } => Known::Follows { signal: 0, since: 0.0 },
            Self::Controlled { initial, .. } => Known::constant(*initial),
            Self::Formula { .. } => Known::constant(0.0),
        }
    }

    /// Whether the source has the signal that `known` says it follows.
    pub(super) fn admits(&self, known: Known) -> bool {
        match (known, self) {
            (Known::Ramp(_), _) => true,
            (Known::Follows { signal, .. }, Self::Switched { others, .. }) => signal <= others.len(),
            (Known::Follows { .. }, _) => false,
        }
    }

    /// The value of the known input at time `t`.
    pub(super) fn at(&self, known: Known, t: f64) -> f64 {
        match (known, self) {
            (Known::Ramp(ramp), _) => ramp.at(t),
            (Known::Follows { signal: 0, .. }, Self::Switched { own, .. }) => own.at(t),
            (Known::Follows { signal, since }, Self::Switched { others, .. }) => {
                others[signal - 1].signal.at(t - since)
            }
            (Known::Follows { .. }, _) => 0.0,
        }
    }

    /// The function of time that the input follows from `t` on, if nothing in it is decided during the run. After a switch it is followed once the transition
    /// is complete, and not before the end of the first step.
    fn followed(&self, program: Program, t: f64) -> Option<Known> {
        let Self::Switched { own, others } = self else { return None };
        let Program { other, since, .. } = program;
        match other {
            None => (!own.has_inputs()).then_some(Known::Follows { signal: 0, since: 0.0 }),
            Some(i) => {
                let Other { signal, over, .. } = &others[i];
                (t > since && t - since >= *over && !signal.has_inputs())
                    .then_some(Known::Follows { signal: 1 + i, since })
            }
        }
    }
}

/// A signal that an event switches to.
#[derive(Clone, Debug)]
pub struct Other {
    pub event: usize,
    pub signal: Signal,
    /// Duration of the transition from the old value \[s\]
    pub over: f64,
}

/// A variable of a formula.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Variable {
    Time,
    /// Index of the recorded column
    Column(usize),
}

/// An input of a scene.
#[derive(Clone, Debug)]
pub struct Input {
    /// Name of the signal that the input is, or is a part of
    pub signal: String,
    pub source: Source,
}

impl Input {
    /// Whether this input, with index `k`, is in use at present: part of a signal that an event sets is in use only from that event until the next one.
    fn is_in_force(&self, k: usize, inputs: &[Self], memory: &ControlMemory) -> bool {
        inputs.iter().zip(&memory.programs).filter(|(input, _)| input.signal == self.signal).all(|(input, program)| {
            let Source::Switched { own, others } = &input.source else { return true };
            program.other.map_or(own, |i| &others[i].signal).reads(k)
        })
    }
}

/// The known values of all inputs from `t` to `next`, given their values at both times.
pub(super) fn known(
    (inputs, memory): (&[Input], &ControlMemory),
    [(t, now), (next, ahead)]: [(f64, &[f64]); 2],
) -> Vec<Known> {
    let of = |k: usize| {
        let ramp = Ramp { start: t, from: now[k], end: next, to: ahead[k] };
        inputs[k].source.followed(memory.programs[k], t).unwrap_or(Known::Ramp(ramp))
    };
    (0..inputs.len()).map(of).collect()
}

/// Values of all inputs at `t`, from the columns recorded last. Inputs on which others depend come first in the list. A formula that is not in use is not
/// evaluated, and its value is zero.
pub(super) fn values(inputs: &[Input], memory: &ControlMemory, row: &[f64], t: f64) -> Result<Vec<f64>, ControlError> {
    let (mut values, mut ahead) = (Vec::with_capacity(inputs.len()), Vec::<Known>::with_capacity(inputs.len()));
    for (k, input) in inputs.iter().enumerate() {
        let value = match &input.source {
            Source::Switched { own, others } => {
                let Program { other, since, from } = memory.programs[k];
                let clock = |t| Clock { t, inputs: &ahead };
                match other.map(|i| &others[i]) {
                    None => own.at(clock(t)),
                    Some(Other { signal, over, .. }) => {
                        let goal = signal.at(clock(t - since));
                        let share = if *over > 0.0 { ((t - since) / over).min(1.0) } else { 1.0 };
                        if share < 1.0 { from + share * (goal - from) } else { goal }
                    }
                }
            }
            Source::Formula { .. } if !input.is_in_force(k, inputs, memory) => 0.0,
            Source::Formula { formula, event, variables } => {
                let since = event.and_then(|e| memory.events[e].last).unwrap_or(0.0);
                let variable = |v: &Variable| match v {
                    Variable::Time => t - since,
                    Variable::Column(c) => row[*c],
                };
                formula.value(&variables.iter().map(variable).collect::<Vec<_>>())
            }
            Source::Controlled { .. } => memory.outside[k],
        };
        if !value.is_finite() {
            return Err(ControlError::NotFinite { signal: input.signal.clone(), value, t });
        }
        values.push(value);
        ahead.push(Known::constant(value));
    }
    Ok(values)
}
