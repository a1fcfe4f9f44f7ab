//! A cable of a scene: its path through guides and rings, its drive, and what a run records of it.

use super::drive::Drive;
use crate::effect::{Cable, CableLength, CableTension, Guide, Pull, cable_friction};
use crate::math::signal::Signal;
use crate::math::tensor::Vec3;
use crate::math::units::Dimension;
use crate::mesh::embed::{ball_weights, embed};
use crate::mesh::error::point;
use crate::scene::build::part;
use crate::scene::builder::Builder;
use crate::scene::error::{SceneError, hint};
use crate::scene::protocol::extremes;
use crate::scene::protocol::{check_tension, note_let_out};
use crate::scene::quantity::{Force, GuideRadius, Length};
use crate::scene::recorder::{Change, Moment, Recorder};
use crate::scene::spec::DriveSpec;
use crate::solve::TimeSpan;
use crate::system::{Constraint, Effect, State};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// `[[constraint]]` of kind `cable`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CableSpec {
    #[serde(default = "cable")]
    pub name: String,
    /// Path of the body, or `guides` with `pull_point`
    pub path: Option<String>,
    pub guides: Option<Vec<[Length; 3]>>,
    pub pull_point: Option<[Length; 3]>,
    /// Points fixed in space between pull point and guides
    #[serde(default)]
    pub rings: Vec<RingSpec>,
    pub guide_radius: GuideRadius,
    pub drive: DriveSpec,
    /// Axial stiffness; a cable without one does not stretch
    #[serde(rename = "EA")]
    pub axial: Option<Force>,
    /// Tension at which a drive by length yields
    pub max_tension: Option<Force>,
    /// Coefficient of friction at guides and rings; none means the same tension everywhere
    pub friction: Option<f64>,
}

/// A ring fixed in space.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RingSpec {
    pub at: [Length; 3],
    /// Number of guides between the pull point and the ring
    pub after: usize,
}

fn cable() -> String {
    "cable".into()
}

fn vector(p: &[Length; 3]) -> Vec3 {
    Vec3::new(p[0].0, p[1].0, p[2].0)
}

/// A cable with its drive, for probes.
pub struct NamedCable {
    pub name: String,
    pub cable: Arc<Cable>,
    /// The tension at the pull point; with friction the multipliers of the other segments follow
    pub drive: Drive,
    pub by_length: bool,
    pub friction: bool,
    /// 1/EA \[1/N\], 0 if it does not stretch
    pub softness: f64,
    /// Tension at which the drive yields \[N\], infinite if it never does
    pub most: f64,
}

/// A point on the path of a cable: its name in messages, and whether it is fixed in space.
struct Stop {
    name: String,
    fixed: bool,
    guide: Guide,
}

pub(in crate::scene) fn build_cable(
    builder: &mut Builder,
    place: &str,
    spec: &CableSpec,
    spans: &[TimeSpan],
    effects: &mut Vec<Box<dyn Effect>>,
    constraints: &mut Vec<Box<dyn Constraint>>,
) -> Result<NamedCable, SceneError> {
    check_values(builder, place, spec)?;
    let (pull_point, stops) = find_stops(builder, place, spec)?;
    let fixed = fixed_length(pull_point, &stops);
    let guides = stops.into_iter().map(|s| s.guide).collect();
    let cable = Arc::new(Cable::new(spec.name.clone(), pull_point, guides));
    let lengths = cable.lengths_at_rest();
    let rest: f64 = lengths.iter().sum();
    let softness = spec.axial.as_ref().map_or(0.0, |ea| 1.0 / ea.0);
    let most = spec.max_tension.as_ref().map_or(f64::INFINITY, |t| t.0);
    let row = constraints.len();
    let drive = match &spec.drive {
        DriveSpec::Length { signal } => {
            let named = format!("{}_shortening_m", spec.name);
            let shortening = builder.signal(place, named, signal, Dimension::LENGTH)?;
            if softness == 0.0 && most == f64::INFINITY {
                check_shortening(builder, place, &shortening, rest - fixed, spans)?;
            }
            note_let_out(builder, &spec.name, &shortening, spans);
            match spec.friction {
                Some(mu) => {
                    let pull = Pull::Length { shortening, most };
                    constraints.extend(cable_friction::constraints(cable.clone(), pull, mu, softness));
                }
                None => {
                    let compliance = softness * rest;
                    let row = CableLength { cable: cable.clone(), shortening, rest, compliance, most };
                    constraints.push(Box::new(row));
                }
            }
            Drive::Multiplier(row)
        }
        DriveSpec::Tension { signal } => {
            let named = format!("{}_imposed_tension_N", spec.name);
            let tension = builder.signal(place, named, signal, Dimension::FORCE)?;
            check_tension(builder, place, &tension, spans)?;
            match spec.friction {
                Some(mu) => {
                    constraints.extend(cable_friction::constraints(
                        cable.clone(),
                        Pull::Tension(tension),
                        mu,
                        softness,
                    ));
                    Drive::Multiplier(row)
                }
                None => {
                    effects.push(Box::new(CableTension { cable: cable.clone(), tension: tension.clone() }));
                    Drive::Prescribed(tension)
                }
            }
        }
    };
    let by_length = matches!(spec.drive, DriveSpec::Length { .. });
    let friction = spec.friction.is_some();
    Ok(NamedCable { name: spec.name.clone(), cable, drive, by_length, friction, softness, most })
}

fn check_values(builder: &Builder, place: &str, spec: &CableSpec) -> Result<(), SceneError> {
    if let GuideRadius::Ball(radius) = spec.guide_radius {
        let fact = format!("guide_radius is {} mm", radius * 1e3);
        if radius <= 0.0 {
            return Err(builder.content(place, fact, "give a positive length, at least the size of a cell"));
        }
        let diagonal = builder.body.mesh.diagonal();
        if radius > diagonal {
            let fact = format!("{fact}, and the body is {:.4} mm from corner to corner", diagonal * 1e3);
            return Err(builder.content(place, fact, "a guide would be the mean of the whole body; check the unit"));
        }
    }
    let positive = |key: &str, value: &Option<Force>, remedy: &str| match value {
        Some(v) if v.0 <= 0.0 => Err(builder.content(place, format!("{key} is {} N", v.0), remedy)),
        _ => Ok(()),
    };
    positive("EA", &spec.axial, "give a positive one, or none for a cable that does not stretch")?;
    positive("max_tension", &spec.max_tension, "give a positive one, or none for a drive that never yields")?;
    if let Some(mu) = spec.friction
        && !(mu >= 0.0 && mu.is_finite())
    {
        return Err(builder.content(place, format!("friction is {mu}"), "a coefficient of friction is not negative"));
    }
    if let DriveSpec::Tension { .. } = spec.drive {
        if spec.max_tension.is_some() {
            let fact = "max_tension limits a drive by length, and this one is a tension";
            return Err(builder.content(place, fact, "remove it, or take drive = { kind = \"length\", signal = … }"));
        }
        if spec.axial.is_some() && spec.friction.is_none() {
            let fact = "under a prescribed tension without friction the body does not feel EA";
            return Err(builder.content(place, fact, "remove it, or take drive = { kind = \"length\", signal = … }"));
        }
    }
    Ok(())
}

/// The pull point and the places from there to the end.
fn find_stops(builder: &Builder, place: &str, spec: &CableSpec) -> Result<(Vec3, Vec<Stop>), SceneError> {
    let (points, pull) = match (&spec.path, &spec.guides, &spec.pull_point) {
        (Some(path), None, None) => {
            let Some(known) = builder.body.paths.get(path) else {
                let names: Vec<&String> = builder.body.paths.keys().collect();
                let remedy = format!("{}; or give `guides` and `pull_point`", hint(path, &names));
                return Err(builder.content(place, format!("the mesh has no path \"{path}\""), remedy));
            };
            (known.guides.iter().map(|p| Vec3::from(*p)).collect::<Vec<_>>(), Vec3::from(known.pull_point))
        }
        (None, Some(guides), Some(pull)) => (guides.iter().map(vector).collect(), vector(pull)),
        _ => {
            let fact = "a cable runs along a path";
            return Err(builder.content(place, fact, "give either `path`, or both `guides` and `pull_point`"));
        }
    };
    if points.is_empty() {
        return Err(builder.content(place, "the cable has no guide", "give at least one point inside the body"));
    }
    if let Some((k, ring)) = spec.rings.iter().enumerate().find(|(_, r)| r.after >= points.len()) {
        let fact =
            format!("ring {} is after guide {}, and the cable ends at guide {}", k + 1, ring.after, points.len());
        return Err(builder.content(place, fact, "a cable ends in the body: place its rings before the last guide"));
    }
    let mut stops = Vec::new();
    for (k, &at) in points.iter().enumerate() {
        for (r, ring) in spec.rings.iter().enumerate().filter(|(_, ring)| ring.after == k) {
            let guide = Guide { point: vector(&ring.at), weights: Vec::new() };
            stops.push(Stop { name: format!("ring {}", r + 1), fixed: true, guide });
        }
        let guide = build_guide(builder, &format!("{place}: guide {}", k + 1), at, spec.guide_radius)?;
        stops.push(Stop { name: format!("guide {}", k + 1), fixed: false, guide });
    }
    let mut before = (pull, "the pull point".to_string());
    for stop in &stops {
        if (stop.guide.point - before.0).norm() <= 1e-9 * builder.body.mesh.diagonal() {
            let fact = format!("{} coincides with {} at {}", stop.name, before.1, point(&before.0));
            return Err(builder.content(place, fact, "the cable has no direction between them: move or remove one"));
        }
        before = (stop.guide.point, stop.name.clone());
    }
    Ok((pull, stops))
}

/// A guide point must lie inside the body, also where a ball would still find some of it.
fn build_guide(builder: &Builder, place: &str, at: Vec3, radius: GuideRadius) -> Result<Guide, SceneError> {
    let mesh = &builder.body.mesh;
    let embedded = embed(mesh, at).map_err(|e| part(builder.file, place, e))?;
    let weights = match radius {
        GuideRadius::Point => embedded.weights,
        GuideRadius::Ball(radius) => ball_weights(mesh, at, radius).map_err(|e| part(builder.file, place, e))?,
    };
    Ok(Guide { point: at, weights })
}

/// Refuses a shortening by more than the length inside the body. A signal that is decided during the run is not checked here.
fn check_shortening(
    builder: &Builder,
    place: &str,
    shortening: &Signal,
    free: f64,
    spans: &[TimeSpan],
) -> Result<(), SceneError> {
    if shortening.has_inputs() {
        return Ok(());
    }
    let (_, (t, most)) = extremes(shortening, spans);
    // A signal without a value is refused with its formula.
    if most < free || !most.is_finite() {
        return Ok(());
    }
    let (mm, free) = (most * 1e3, free * 1e3);
    let fact =
        format!("the cable is shortened by {mm:.4} mm at t = {t:.4} s, and only {free:.4} mm of it can get shorter");
    Err(builder.content(place, fact, "pull less, or let the drive yield with max_tension"))
}

/// Length between points that are fixed in space \[m\].
fn fixed_length(pull_point: Vec3, stops: &[Stop]) -> f64 {
    let mut before = (pull_point, true);
    let mut sum = 0.0;
    for stop in stops {
        if before.1 && stop.fixed {
            sum += (stop.guide.point - before.0).norm();
        }
        before = (stop.guide.point, stop.fixed);
    }
    sum
}

/// A cable that went slack, taut, or to the limit of its drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CableEvent {
    /// Time of the first accepted state after it \[s\]
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
    /// Columns: tension at the pull point and length; what was taken in where that is not the change of length; with friction
    /// the tension at the end, of each segment, and the slip through each guide.
    fn columns(&self) -> Vec<String> {
        let name = &self.name;
        let mut out = vec![format!("{name}_tension_N"), format!("{name}_length_m")];
        if self.friction || self.softness > 0.0 || self.most < f64::INFINITY {
            out.push(format!("{name}_drawn_m"));
        }
        if self.friction {
            let n = self.cable.segments();
            out.push(format!("{name}_end_tension_N"));
            out.extend((1..=n).map(|s| format!("{name}_tension_{s}_N")));
            out.extend((1..n).map(|k| format!("{name}_slip_{k}_m")));
        }
        out
    }

    /// Values of its columns, SI.
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
        if self.friction {
            out.push(tensions[tensions.len() - 1]);
            out.extend_from_slice(&tensions);
            out.extend_from_slice(&passed[1..]);
        }
        out
    }

    /// Change of its columns with a change of the state; none of a cable with friction.
    fn derivative(&self, by: &Change) -> Option<Vec<f64>> {
        let (state, change) = (by.state, by.change);
        let tension = self.drive.answer(change);
        let length = self.cable.lengthening(&state.x, &change.x);
        let rest: f64 = self.cable.lengths_at_rest().iter().sum();
        let mut out = vec![tension, length, self.softness * rest * tension - length];
        out.truncate(self.columns().len());
        Some(out)
    }

    /// Cables with friction are refused before.
    fn is_differentiable(&self) -> bool {
        true
    }
}

impl NamedCable {
    /// Tension of each segment \[N\].
    fn tensions(&self, state: &State) -> Vec<f64> {
        let n = self.cable.segments();
        match &self.drive {
            Drive::Multiplier(c) if self.friction => state.lambda[*c..c + n].to_vec(),
            Drive::Multiplier(c) => vec![state.lambda[*c]; n],
            Drive::Prescribed(signal) => vec![signal.at(state.clock()).max(0.0); n],
        }
    }

    /// Cable that has passed the start of each segment towards the pull point \[m\]: Σ_{s≥k} (l₀_s + T_s l₀_s/EA − l_s).
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

    /// Its condition; `None` for a cable driven by tension.
    fn condition(&self, state: &State) -> Option<Condition> {
        let tension = self.tensions(state)[0];
        self.by_length.then_some(match tension {
            0.0 => Condition::Slack,
            // 1e-9: rounding of a tension at its limit.
            _ if tension >= self.most * (1.0 - 1e-9) => Condition::Yielding,
            _ => Condition::Taut,
        })
    }
}

/// Follows the cables of a run; a part of every saved state.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub(in crate::scene) struct CableLog {
    last: Vec<Option<Condition>>,
    pub(in crate::scene) events: Vec<CableEvent>,
}

impl CableLog {
    /// Notes what has changed at an accepted state.
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

/// Which cables pull at the last good state, for the message of a run that could not go on.
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
