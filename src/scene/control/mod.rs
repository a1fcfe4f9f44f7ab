//! Protocols that are decided during a run: events, formulas of recorded columns, controllers.
//!
//! Everything is decided at the points of the time grid, in this order: events, the controller, then every input for the next point. Nothing here is called
//! within a step.

mod controller;
mod error;
mod event;
mod input;
mod memory;
mod prepare;
pub mod process;
pub mod recording;
mod signals;
pub mod spec;
pub mod strict_json;

pub use controller::{Controller, Observation, Opening, Reply, SignalSetting};
pub use error::ControlError;
pub use memory::{ControlMemory, ControllerRecord, Fired};
pub(super) use prepare::build_controls;
pub(super) use signals::SignalBuilder;

use crate::math::signal::Known;
use crate::math::units::within;
use crate::system::State;
use event::{Event, Then, fire, look};
pub(super) use input::{Input, Source};
use input::{known, values};
use memory::{Past, Program};

/// Inputs and events of a scene.
#[derive(Clone, Debug, Default)]
pub struct Controls {
    inputs: Vec<Input>,
    events: Vec<Event>,
}

/// Requests to the run that were made at a point of the grid.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Orders {
    pub stop: bool,
    pub save: bool,
}

impl Controls {
    /// Memory before the first step.
    pub fn memory(&self) -> ControlMemory {
        let initial = |source: &Source| if let Source::Controlled { initial, .. } = source { *initial } else { 0.0 };
        ControlMemory {
            programs: vec![Program::default(); self.inputs.len()],
            outside: self.inputs.iter().map(|i| initial(&i.source)).collect(),
            events: vec![Past::default(); self.events.len()],
            ..ControlMemory::default()
        }
    }

    /// Names of the signals that are set from outside.
    pub fn controlled(&self) -> Vec<String> {
        self.outside().map(|k| self.inputs[k].signal.clone()).collect()
    }

    /// Values in a memory of the signals that are set from outside, in the order of their names.
    pub fn values_from_outside(&self, memory: &ControlMemory) -> Vec<f64> {
        self.outside().map(|k| memory.outside[k]).collect()
    }

    /// Smallest and largest value of each signal that is set from outside and declares a range, in the order of their names; `None` for the others.
    pub fn ranges(&self) -> Vec<Option<(f64, f64)>> {
        let range = |k: usize| match self.inputs[k].source {
            Source::Controlled { range, .. } => range,
            _ => None,
        };
        self.outside().map(range).collect()
    }

    /// Refuses values from outside that are not within their ranges.
    fn check_ranges(&self, values: &[f64], t: f64) -> Result<(), ControlError> {
        for ((signal, range), &value) in self.controlled().into_iter().zip(self.ranges()).zip(values) {
            if let Some((low, high)) = range.filter(|range| !value.is_nan() && !within(value, *range)) {
                return Err(ControlError::OutOfRange { signal, value, t, low, high });
            }
        }
        Ok(())
    }

    /// Whether any signal is decided during the run.
    pub fn has_inputs(&self) -> bool {
        !self.inputs.is_empty()
    }

    /// Whether these known courses fit the inputs, one for each.
    pub(super) fn admit(&self, known: &[Known]) -> bool {
        known.len() == self.inputs.len()
            && self.inputs.iter().zip(known).all(|(input, known)| input.source.admits(*known))
    }

    fn outside(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.inputs.len()).filter(|&k| matches!(self.inputs[k].source, Source::Controlled { .. }))
    }

    /// Sets the inputs of the initial state. `record` returns the recorded row at a state; formulas use the row without inputs.
    pub(super) fn start(
        &self,
        memory: &mut ControlMemory,
        state: &mut State,
        record: impl Fn(&State) -> Vec<f64>,
    ) -> Result<(), ControlError> {
        if self.inputs.is_empty() && self.events.is_empty() {
            return Ok(());
        }
        state.inputs = vec![Known::constant(0.0); self.inputs.len()];
        let values = values(&self.inputs, memory, &record(state), state.t)?;
        state.inputs = known((&self.inputs, memory), [(state.t, &values); 2]);
        look(&self.events, memory, &record(state));
        Ok(())
    }

    /// Decides events, the controller and the inputs at a state whose row was recorded, for the time `next` if there is one.
    pub(super) fn decide<'c>(
        &self,
        memory: &mut ControlMemory,
        state: &mut State,
        row: &[f64],
        next: Option<f64>,
        controller: Option<&mut (dyn Controller + 'c)>,
    ) -> Result<Orders, ControlError> {
        let now: Vec<f64> =
            self.inputs.iter().zip(&state.inputs).map(|(input, known)| input.source.at(*known, state.t)).collect();
        let rest = fire(&self.events, memory, row, &now, state.dt);
        let mut orders = Orders { stop: rest.contains(&Then::Stop), save: rest.contains(&Then::Save) };
        memory.stopped = orders.stop;
        let Some(next) = next else { return Ok(orders) };
        if let Some(controller) = controller {
            let outside: Vec<usize> = self.outside().collect();
            let mut signals: Vec<f64> = outside.iter().map(|&k| memory.outside[k]).collect();
            let reply = controller.step(&Observation { row, next }, &mut signals)?;
            self.check_ranges(&signals, state.t)?;
            if memory.set.last().is_none_or(|(_, past)| *past != signals) {
                memory.set.push((state.t, signals.clone()));
            }
            outside.iter().zip(signals).for_each(|(&k, value)| memory.outside[k] = value);
            orders = Orders { stop: orders.stop || reply.stop, save: orders.save || reply.save };
            if !reply.memory.is_null() {
                memory.controller = reply.memory;
            }
            memory.stopped = orders.stop;
        }
        if !self.inputs.is_empty() {
            let values = values(&self.inputs, memory, row, next)?;
            state.inputs = known((&self.inputs, memory), [(state.t, &now), (next, &values)]);
        }
        Ok(orders)
    }
}
