//! Signals of a scene, and their inputs that are decided during the run.

use super::input::{Input, Other, Source};
use super::spec::{EventSpec, ThenSpec};
use crate::math::signal::{Known, Signal};
use crate::math::units::Dimension;
use crate::scene::signal::{SignalError, SignalSpec, Site};
use std::path::Path;

/// Collects inputs while the signals of a scene are built.
pub(in crate::scene) struct SignalBuilder<'a> {
    pub(super) specs: &'a [EventSpec],
    pub(super) inputs: Vec<Input>,
}

impl<'a> SignalBuilder<'a> {
    pub(in crate::scene) fn new(specs: &'a [EventSpec]) -> Self {
        Self { specs, inputs: Vec::new() }
    }

    /// The values of the inputs before the first step.
    pub(in crate::scene) fn initial(&self) -> Vec<Known> {
        self.inputs.iter().map(|input| input.source.initial()).collect()
    }

    /// Name of event `e` for messages and the log.
    pub(super) fn name(&self, e: usize) -> String {
        self.specs[e].name.clone().unwrap_or_else(|| format!("event {}", e + 1))
    }

    /// Place of event `e` in the scene, for messages.
    pub(super) fn place(&self, e: usize) -> String {
        let name = self.specs[e].name.as_ref().map_or_else(String::new, |n| format!(" ({n})"));
        format!("event {}{name}", e + 1)
    }

    /// The signal of this name, with the signals by which events replace it. An error names the event in which it is.
    pub(in crate::scene) fn signal(
        &mut self,
        name: &str,
        spec: &SignalSpec,
        dimension: Dimension,
        base: &Path,
    ) -> Result<Signal, (Option<String>, SignalError)> {
        let mut site = Site { base, name, inputs: &mut self.inputs, event: None, depth: 0, delayed: false };
        let own = spec.build(dimension, &mut site).map_err(|e| (None, e))?;
        let mut others = Vec::new();
        for e in 0..self.specs.len() {
            for then in &self.specs[e].then {
                let ThenSpec::Switch { signal, to, over } = then else { continue };
                if signal != name {
                    continue;
                }
                let mut site = Site { base, name, inputs: &mut self.inputs, event: Some(e), depth: 0, delayed: false };
                let signal = to.build(dimension, &mut site).map_err(|error| (Some(self.place(e)), error))?;
                others.push(Other { event: e, signal, over: over.map_or(0.0, |t| t.0) });
            }
        }
        if others.is_empty() {
            return Ok(own);
        }
        let signals = std::iter::once(&own).chain(others.iter().map(|other| &other.signal)).cloned().collect();
        self.inputs.push(Input { signal: name.into(), source: Source::Switched { own, others } });
        Ok(Signal::Switched { input: self.inputs.len() - 1, signals })
    }
}
