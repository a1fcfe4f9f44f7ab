//! Record of a cable: tensions, lengths and slip, and the times at which it goes slack or taut.

use crate::effect::Cable;
use crate::scene::body::Body;
use crate::scene::build::drive::Drive;
use crate::scene::record::recorder::{Moment, Recorder};
use crate::system::{Gradient, State};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A cable with its drive, for probes.
pub struct NamedCable {
    pub name: String,
    pub cable: Arc<Cable>,
    /// Radius of the patches of its guides \[m\]; `None` for a cable through points
    pub guide_radius: Option<f64>,
    /// Source of the tension at the pull point; with friction the multipliers of the other segments follow
    pub drive: Drive,
    pub by_length: bool,
    pub friction: bool,
    /// Whether the tension of each segment and the slip through each guide are recorded. They are if the scene gives a coefficient of friction, even 0, so
    /// that the columns do not depend on its value
    pub by_segment: bool,
    /// 1/EA \[1/N\]; 0 if the cable does not stretch
    pub softness: f64,
    /// Tension at which the drive yields \[N\]; infinite if it never does
    pub most: f64,
}

/// Event in which a cable went slack or taut, or reached the limit of its drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CableEvent {
    /// Time of the first accepted state after the event \[s\]
    pub t: f64,
    pub cable: String,
    pub what: Condition,
}

/// Condition of a cable that is driven by length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Condition {
    Slack,
    Taut,
    /// At `max_tension`: the drive yields
    Yielding,
}

impl Condition {
    /// Name as in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Slack => "slack",
            Self::Taut => "taut",
            Self::Yielding => "yielding",
        }
    }
}

impl Recorder for NamedCable {
    /// The columns: tension at the pull point and length; the length drawn in, unless it equals the change of length; with a coefficient of friction also the
    /// tension at the end and of each segment, and the slip through each guide.
    fn columns(&self) -> Vec<String> {
        let name = &self.name;
        let mut out = vec![format!("{name}_tension_N"), format!("{name}_length_m")];
        if self.by_segment || self.softness > 0.0 || self.most < f64::INFINITY {
            out.push(format!("{name}_drawn_m"));
        }
        if self.by_segment {
            let n = self.cable.segments();
            out.push(format!("{name}_end_tension_N"));
            out.extend((1..=n).map(|s| format!("{name}_tension_{s}_N")));
            out.extend((1..n).map(|k| format!("{name}_slip_{k}_m")));
        }
        out
    }

    /// Values of the columns \[SI\].
    fn record(&self, now: &Moment) -> Vec<f64> {
        let state = now.state;
        let tensions = self.tensions(state);
        let lengths = self.cable.lengths(&state.x);
        let mut out = vec![tensions[0], lengths.iter().sum()];
        if out.len() == self.columns().len() {
            return out;
        }
        let passed = self.passed(&tensions, &lengths);
        out.push(passed[0]);
        if self.by_segment {
            out.push(tensions[tensions.len() - 1]);
            out.extend_from_slice(&tensions);
            out.extend_from_slice(&passed[1..]);
        }
        out
    }

    /// Gradients of tension, length, length drawn in and length passed through each guide, which is softness × rest × tension − length from there on, with the
    /// same tension everywhere; not used for a cable with friction.
    fn gradients(&self, _: &Body, state: &State, _: &[f64]) -> Vec<Option<Gradient>> {
        let (tension, rest) = (self.drive.gradient(), self.cable.lengths_at_rest());
        let passed = |from: usize| {
            let softness = self.softness * rest[from..].iter().sum::<f64>();
            Gradient {
                x: self.cable.length_gradient(&state.x, from).iter().map(|(dof, w)| (*dof, -w)).collect(),
                lambda: tension.lambda.iter().map(|(c, w)| (*c, w * softness)).collect(),
                ..Gradient::default()
            }
        };
        let length = Gradient::of_displacements(self.cable.length_gradient(&state.x, 0));
        let mut out = vec![tension.clone(), length, passed(0)];
        if self.by_segment {
            // Tension at the end, and tension of each segment
            out.extend(vec![tension.clone(); 1 + rest.len()]);
            out.extend((1..rest.len()).map(passed));
        }
        out.truncate(self.columns().len());
        out.into_iter().map(Some).collect()
    }

    /// Cables with friction are refused earlier.
    fn is_differentiable(&self) -> bool {
        true
    }
}

impl NamedCable {
    /// Columns of the tensions: at the pull point, and, with a coefficient of friction, of each segment.
    pub fn tension_columns(&self) -> Vec<String> {
        let segments = if self.by_segment { self.cable.segments() } else { 0 };
        let own = (1..=segments).map(|s| format!("{}_tension_{s}_N", self.name));
        std::iter::once(format!("{}_tension_N", self.name)).chain(own).collect()
    }

    /// Tension of each segment \[N\].
    fn tensions(&self, state: &State) -> Vec<f64> {
        let n = self.cable.segments();
        match &self.drive {
            Drive::Multiplier(c) if self.friction => state.lambda[*c..c + n].to_vec(),
            Drive::Multiplier(c) => vec![state.lambda[*c]; n],
            Drive::Prescribed(signal) => vec![signal.at(state.clock()).max(0.0); n],
        }
    }

    /// Length of cable that has passed the start of each segment towards the pull point \[m\]: Σ_{s≥k} (l₀_s + T_s l₀_s/EA − l_s).
    fn passed(&self, tensions: &[f64], lengths: &[f64]) -> Vec<f64> {
        let rest = self.cable.lengths_at_rest();
        let mut sum = 0.0;
        let mut out: Vec<f64> = (0..rest.len())
            .rev()
            .map(|s| {
                sum += rest[s] * (1.0 + self.softness * tensions[s]) - lengths[s];
                sum
            })
            .collect();
        out.reverse();
        out
    }

    /// The condition of the cable; `None` for a cable driven by tension.
    fn condition(&self, state: &State) -> Option<Condition> {
        let tension = self.tensions(state)[0];
        self.by_length.then_some(match tension {
            0.0 => Condition::Slack,
            // 1e-9 allows for rounding of a tension at its limit.
            _ if tension >= self.most * (1.0 - 1e-9) => Condition::Yielding,
            _ => Condition::Taut,
        })
    }
}

/// Events of the cables of a run; a part of every saved state.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub(in crate::scene) struct CableLog {
    last: Vec<Option<Condition>>,
    pub(in crate::scene) events: Vec<CableEvent>,
}

impl CableLog {
    /// Records the changes of condition at an accepted state.
    pub(in crate::scene) fn note(&mut self, cables: &[NamedCable], state: &State) {
        let now: Vec<Option<Condition>> = cables.iter().map(|c| c.condition(state)).collect();
        let before = std::mem::replace(&mut self.last, now);
        for (cable, (before, now)) in cables.iter().zip(before.iter().zip(&self.last)) {
            if let (Some(before), Some(now)) = (before, now)
                && before != now
            {
                self.events.push(CableEvent { t: state.t, cable: cable.name.clone(), what: *now });
            }
        }
    }
}

/// The cables that pull at the last good state, for the message of a run that could not continue.
pub(in crate::scene) fn pulling(cables: &[NamedCable], state: &State) -> Option<String> {
    let taut = |c: &&NamedCable| matches!(c.condition(state), Some(Condition::Taut | Condition::Yielding));
    let say = |c: &NamedCable| {
        let tensions = c.tensions(state);
        let drawn = c.passed(&tensions, &c.cable.lengths(&state.x))[0];
        format!("{} holds {:.4} N with {:.4} mm drawn in", c.name, tensions[0], drawn * 1e3)
    };
    let all: Vec<String> = cables.iter().filter(taut).map(say).collect();
    let remedy = "pull less, or let the drive yield with max_tension";
    (!all.is_empty()).then(|| format!("{}: {remedy}", all.join(", ")))
}
