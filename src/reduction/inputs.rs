//! The inputs of a reduced model, and the forces and lengths that depend on them.

use super::error::ReductionError;
use crate::math::signal::{Clock, Known};
use crate::math::units::within;
use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// An input with the range covered by the training runs, in SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Input {
    /// Name of the signal, with its unit at the end
    pub name: String,
    /// Smallest and largest value
    pub range: [f64; 2],
    /// Value at the start of the scene, if known
    #[serde(default)]
    pub start: Option<f64>,
    /// Whether searches leave it unchanged, such as a constant of a law or the acceleration of a weight
    #[serde(default)]
    pub held: bool,
}

impl Input {
    /// Builds a driving input for a scene that gives it no value.
    pub fn new(name: impl Into<String>, range: [f64; 2]) -> Self {
        Self { name: name.into(), range, start: None, held: false }
    }

    /// Returns the value at which a model starts: that of the scene, or else zero, limited to the range.
    pub fn at_start(&self) -> f64 {
        self.start.map_or(self.unloaded(), |start| start.clamp(self.range[0], self.range[1]))
    }

    /// Whether a value is within the range, apart from rounding in its unit.
    pub fn contains(&self, value: f64) -> bool {
        within(value, self.range.into())
    }

    /// Returns zero, or the end of the range nearest to zero.
    pub fn unloaded(&self) -> f64 {
        0.0_f64.clamp(self.range[0], self.range[1])
    }
}

/// Largest change of an input in one part of a step, relative to its range, if quantities count turns, so that the count does not depend on the
/// previous inputs \[–\].
pub const SHARE: f64 = 1.0 / 16.0;
/// Smallest part into which such a change is divided, for changes far beyond the ranges \[–\].
const CUT: f64 = 1.0 / 64.0;

/// Returns the largest part of a change of the inputs in which each of them changes by at most [`SHARE`] of its range.
pub fn largest_part(inputs: &[Input], from: impl Fn(usize) -> f64, to: &[f64]) -> f64 {
    let changes = to.iter().zip(inputs).enumerate();
    let shares = changes.map(|(k, (to, input))| (to - from(k)).abs() / (input.range[1] - input.range[0]));
    (SHARE / shares.fold(SHARE, f64::max)).max(CUT)
}

/// The affine function c + Σ r_k u_k of the inputs u.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Affine {
    pub constant: f64,
    pub rates: Vec<f64>,
}

/// Number of intervals of the duration of a scene; at their ends nothing may have changed except by the inputs.
const PARTS: u32 = 1000;
/// Change of a signal relative to its size below which it is rounding \[–\].
const ROUNDING: f64 = 1e-12;

impl Affine {
    /// Identifies the function `f` of the inputs; an error if it is not affine, or depends on time in a scene that ends at `end` \[s\].
    pub fn identify(what: &str, inputs: &[Input], end: f64, f: impl Fn(Clock) -> f64) -> Result<Self, ReductionError> {
        let at = |t: f64, u: &[f64]| {
            let inputs: Vec<Known> = u.iter().map(|&u| Known::constant(u)).collect();
            f(Clock { t, inputs: &inputs })
        };
        let low: Vec<f64> = inputs.iter().map(|i| i.range[0]).collect();
        let at_low = at(0.0, &low);
        let rate = |k: usize| {
            let mut u = low.clone();
            u[k] = inputs[k].range[1];
            (at(0.0, &u) - at_low) / (inputs[k].range[1] - inputs[k].range[0])
        };
        let rates: Vec<f64> = (0..inputs.len()).map(rate).collect();
        let constant = at_low - rates.iter().zip(&low).map(|(r, u)| r * u).sum::<f64>();
        let affine = Self { constant, rates };
        let size = inputs.iter().zip(&affine.rates).fold(affine.constant.abs(), |size, (input, rate)| {
            size + rate.abs() * input.range[0].abs().max(input.range[1].abs())
        });
        for n in 0..=PARTS {
            let t = end * f64::from(n) / f64::from(PARTS);
            let share = |k: usize| ((n as usize + k + 1) as f64 * 0.618).fract();
            let within = |(k, i): (usize, &Input)| i.range[0] + share(k) * (i.range[1] - i.range[0]);
            let u: Vec<f64> = inputs.iter().enumerate().map(within).collect();
            if (at(t, &u) - affine.at(&u)).abs() > ROUNDING * size {
                return Err(ReductionError::Unsupported {
                    what: what.into(),
                    why: "its drive depends on time, or bends with an input".into(),
                    remedy: "make its signal constant, or one of the inputs".into(),
                });
            }
        }
        Ok(affine)
    }

    pub fn at(&self, inputs: &[f64]) -> f64 {
        self.constant + self.rates.iter().zip(inputs).map(|(r, u)| r * u).sum::<f64>()
    }

    /// Whether the function has this number of inputs and is finite.
    pub fn is_sound(&self, inputs: usize) -> bool {
        self.rates.len() == inputs && self.rates.iter().chain([&self.constant]).all(|x| x.is_finite())
    }
}

/// Returns the inputs of a scene that are its controlled signals, each with a range. Refuses a scene without signals if there are no `others`,
/// because nothing could change.
pub fn signals(scene: &Scene, others: usize) -> Result<Vec<Input>, ReductionError> {
    let names = scene.controls.controlled();
    let unsupported = |what: String, why: &str, remedy: &str| ReductionError::Unsupported {
        what,
        why: why.into(),
        remedy: remedy.into(),
    };
    if scene.start().inputs.len().max(scene.controls.memory().programs.len()) != names.len() {
        let why = "events and formulas of columns decide them from what was recorded";
        return Err(unsupported("a signal of the scene".into(), why, "leave these decisions to a controller"));
    }
    if names.is_empty() && others == 0 {
        return Err(unsupported("a scene without inputs".into(), "nothing changes", "give the study an [[input]]"));
    }
    let input = |(name, range): (String, Option<(f64, f64)>)| match range {
        Some((low, high)) => Ok(Input::new(name, [low, high])),
        None => Err(unsupported(format!("input {name}"), "it has no range", "give it one")),
    };
    names.into_iter().zip(scene.controls.ranges()).map(input).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::signal::Signal;

    /// A model starts at the value of its scene, but never outside its range; without a value it starts at zero, or at the nearest end of the range.
    #[test]
    fn inputs_begin_within_their_ranges() {
        let at_start = |range: [f64; 2], start: Option<f64>| Input { start, ..Input::new("pull_N", range) }.at_start();
        assert_eq!(
            [Some(1.5), Some(9.0), Some(-9.0), None].map(|start| at_start([-2.0, 2.0], start)),
            [1.5, 2.0, -2.0, 0.0]
        );
        assert_eq!([[1.0, 5.0], [-5.0, -1.0]].map(|range| at_start(range, None)), [1.0, -1.0]);
    }

    #[test]
    fn a_pulse_within_the_scene_is_no_constant() {
        let inputs = [Input::new("pull_N", [0.0, 2.0])];
        for end in [1e-3, 1.0, 1e4] {
            let load = |pulse: f64| {
                move |now: Clock| {
                    let share = now.t / end;
                    3.0 * Signal::Input(0).at(now) + if (0.2..0.25).contains(&share) { pulse } else { 0.0 }
                }
            };
            let found = Affine::identify("load", &inputs, end, load(0.0)).expect("affine");
            assert!((found.at(&[1.5]) - 4.5).abs() < 1e-14, "{found:?}");
            assert!(Affine::identify("load", &inputs, end, load(1e-3)).is_err());
        }
    }
}
