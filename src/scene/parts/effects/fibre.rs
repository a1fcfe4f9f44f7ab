//! Effect `fibre`: elastic fibres along polylines or helices through the body.

use super::part::EffectPart;
use crate::effect::{FibrePoint, Fibres};
use crate::math::disjoint_sets::DisjointSets;
use crate::math::tensor::Vec3;
use crate::math::units::Decimals;
use crate::mesh::attach::attach;
use crate::mesh::error::point;
use crate::mesh::polyline::{Helix, cut};
use crate::scene::build::builder::Builder;
use crate::scene::build::held_planes::note_halved;
use crate::scene::error::SceneError;
use crate::scene::record::recorder::{Moment, Recorder};
use crate::scene::text::quantity::{Angle, Force, Length};
use crate::system::Effect;
use crate::wording::few;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

/// Largest number of points in the message about fibres that leave the body.
const LISTED: usize = 5;
/// Distance, relative to the size of the body, by which points on its surface may lie outside due to rounding \[–\].
const ROUNDING: f64 = 1e-9;
/// Largest number of segments of one entry, far more than a mesh here could make use of.
const MOST_SEGMENTS: f64 = 1e6;

/// Elastic fibres of equal stiffness.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FibreSpec {
    /// Prefix of the columns; `fibre` if absent
    #[serde(default = "fibre")]
    pub name: String,
    /// Lines of the fibres at rest
    pub along: FibreAlong,
    /// Axial stiffness of one fibre
    #[serde(rename = "EA")]
    pub axial: Force,
    /// Whether the fibre resists being shorter than at rest
    pub compression: bool,
    /// Longest segment; the mean edge length of the cells if absent
    pub spacing: Option<Length>,
    /// Largest distance of points outside of the body
    #[serde(default)]
    pub reach: Length,
}

fn fibre() -> String {
    "fibre".into()
}

/// Lines of fibres at rest.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(tag = "kind", transform = crate::schema::kind_alone)]
pub enum FibreAlong {
    /// One fibre through the points of each list
    Polylines {
        /// Points of each fibre, in order
        lines: Vec<Vec<[Length; 3]>>,
    },
    /// Fibres wound about an axis
    Helix(HelixSpec),
}

/// Helices about an axis; exactly one of `pitch`, `angle` and `turns`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HelixSpec {
    /// Start and end of the axis
    pub axis: [[Length; 3]; 2],
    /// Radius of the helices
    pub radius: Length,
    /// Length along the axis per turn
    pub pitch: Option<Length>,
    /// Angle between the fibre and the axis
    pub angle: Option<Angle>,
    /// Number of windings from one end of the axis to the other
    pub turns: Option<f64>,
    /// Hand of the helices
    pub hand: Hand,
    /// Number of fibres of each hand, evenly spaced about the axis
    #[serde(default = "one")]
    pub count: usize,
    /// Angle of the first fibre about the axis, at its start
    #[serde(default)]
    pub phase: Angle,
}

fn one() -> usize {
    1
}

/// Hand of helices.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Hand {
    /// Right-handed, like a common screw
    Right,
    /// Left-handed
    Left,
    /// Fibres of both hands, in equal numbers
    Both,
}

impl Hand {
    /// Signs of the hands: 1 for right, −1 for left.
    pub(super) fn signs(self) -> &'static [f64] {
        match self {
            Self::Right => &[1.0],
            Self::Left => &[-1.0],
            Self::Both => &[1.0, -1.0],
        }
    }
}

impl EffectPart for FibreSpec {
    fn build(&self, place: &str, builder: &mut Builder) -> Result<Box<dyn Effect>, SceneError> {
        builder.check_name(place, &self.name)?;
        let positive = |key: &str, value: f64, unit: &str| {
            let fact = || format!("{key} is {value} {unit}");
            if value > 0.0 { Ok(value) } else { Err(builder.content(place, fact(), "give a positive one")) }
        };
        let stiffness = positive("EA", self.axial.0, "N")?;
        self.spacing.iter().try_for_each(|spacing| positive("spacing", spacing.0, "m").map(|_| ()))?;
        if self.reach.0 < 0.0 {
            let fact = format!("reach is {} mm", self.reach.0 * 1e3);
            return Err(builder.content(place, fact, "give zero or a positive length"));
        }
        let lines = self.lines(builder, place)?;
        let lines = embedded(builder, place, &lines, (&self.name, self.reach.0))?;
        note_gaps(builder, &self.name, &lines);
        let fibres = Arc::new(Fibres::new(self.name.clone(), &lines, stiffness, self.compression));
        let (count, length) = (fibres.lengths().count(), fibres.lengths().sum::<f64>());
        let of = lines.len();
        let name = &self.name;
        builder.notes.push(format!("{name}: {of} fibre(s) of {count} segments, {:.4} mm long together", length * 1e3));
        builder.gathered.recorders.push(Box::new(Recorded { name: name.clone(), fibres: fibres.clone() }));
        Ok(Box::new(fibres))
    }

    fn words(&self) -> String {
        let sides = if self.compression { "tension and compression" } else { "tension only" };
        let along = match &self.along {
            FibreAlong::Polylines { lines } => format!("along {} polyline(s)", lines.len()),
            FibreAlong::Helix(helix) => helix.words(),
        };
        format!("{}, {along}, EA = {} N, {sides}", self.name, self.axial)
    }

    fn note(&self, builder: &mut Builder) {
        let lines = self.lines(builder, &self.name).expect("the effect was built of them");
        note_halved(builder, &self.name, (&lines, "fibres"), "EA");
    }

    fn no_limit(&self) -> Option<&'static str> {
        Some("fibres are lines, which cut into the body as ln 1/h")
    }
}

impl FibreSpec {
    /// The fibres as polylines, divided according to the spacing.
    fn lines(&self, builder: &Builder, place: &str) -> Result<Vec<Vec<Vec3>>, SceneError> {
        let spacing = self.spacing.as_ref().map_or_else(|| builder.body.mesh.mean_edge(), |spacing| spacing.0);
        match &self.along {
            FibreAlong::Polylines { lines } => polylines(builder, place, lines, spacing),
            FibreAlong::Helix(helix) => helix.lines(builder, place, spacing),
        }
    }
}

/// The lines of the file, divided according to the spacing.
fn polylines(
    builder: &Builder,
    place: &str,
    lines: &[Vec<[Length; 3]>],
    spacing: f64,
) -> Result<Vec<Vec<Vec3>>, SceneError> {
    if lines.is_empty() {
        return Err(builder.content(place, "there are no lines", "write lines = [[[x, y, z], [x, y, z]]]"));
    }
    let mut out = Vec::new();
    let mut faults = Vec::new();
    let mut segments = 0.0;
    for (k, line) in lines.iter().enumerate() {
        let points: Vec<Vec3> = line.iter().map(|p| Vec3::from(p.map(|x| x.0))).collect();
        if points.len() < 2 {
            faults.push(format!("line {} has {} point(s)", k + 1, points.len()));
            continue;
        }
        if let Some(i) = points.windows(2).position(|p| p[0] == p[1]) {
            faults.push(format!("points {} and {} of line {} are both at {}", i + 1, i + 2, k + 1, point(&points[i])));
            continue;
        }
        segments += points.windows(2).map(|p| (p[1] - p[0]).norm()).sum::<f64>() / spacing;
        out.push(points);
    }
    if !faults.is_empty() {
        return Err(builder.content(
            place,
            faults.join("; "),
            "a line has at least two points, each apart from the last",
        ));
    }
    check_count(builder, place, segments)?;
    Ok(out.iter().map(|line| cut(line, spacing)).collect())
}

fn check_count(builder: &Builder, place: &str, segments: f64) -> Result<(), SceneError> {
    if segments <= MOST_SEGMENTS {
        return Ok(());
    }
    let fact = format!("the fibres have {segments:.0} segments");
    Err(builder.content(place, fact, "take a longer `spacing`, or fewer turns; check the units"))
}

impl HelixSpec {
    /// The fibres as polylines.
    fn lines(&self, builder: &Builder, place: &str, spacing: f64) -> Result<Vec<Vec<Vec3>>, SceneError> {
        let [start, end] = self.axis.map(|p| Vec3::from(p.map(|x| x.0)));
        let (height, radius) = ((end - start).norm(), self.radius.0);
        let refuse = |fact: String, remedy: &str| Err(builder.content(place, fact, remedy));
        if height == 0.0 {
            return refuse("the axis of the helix has no length".into(), "give two points that are apart");
        }
        if radius <= 0.0 {
            return refuse(format!("the radius of the helix is {} mm", radius * 1e3), "give a positive one");
        }
        if self.count == 0 {
            return refuse("the helix has a count of 0".into(), "give at least 1");
        }
        let turns = match (self.pitch, self.angle, self.turns) {
            (Some(pitch), None, None) if pitch.0 > 0.0 => height / pitch.0,
            (None, Some(angle), None) if (0.0..FRAC_PI_2).contains(&angle.0) => height * angle.0.tan() / (TAU * radius),
            (None, None, Some(turns)) if turns >= 0.0 && turns.is_finite() => turns,
            (Some(pitch), None, None) => {
                let remedy = "give a positive one, and `hand` for the direction";
                return refuse(format!("the pitch of the helix is {} mm", pitch.0 * 1e3), remedy);
            }
            (None, Some(angle), None) => {
                let fact = format!("the angle between the helix and its axis is {}°", angle.0.to_degrees());
                return refuse(fact, "give one from 0° to below 90°, and `hand` for the direction");
            }
            (None, None, Some(turns)) => {
                return refuse(
                    format!("the helix has {turns} turns"),
                    "give none or more, and `hand` for the direction",
                );
            }
            (None, None, None) => {
                return refuse("the helix has no steepness".into(), "give `pitch`, `angle` or `turns`");
            }
            _ => {
                return refuse(
                    "the steepness of the helix is given twice".into(),
                    "give one of `pitch`, `angle`, `turns`",
                );
            }
        };
        let hands = self.hand.signs();
        let fibres = (hands.len() * self.count) as f64;
        check_count(builder, place, fibres * (height.hypot(TAU * radius * turns) / spacing).max(24.0 * turns))?;
        let fibre = |hand: f64, k: usize| {
            let phase = self.phase.0 + TAU * k as f64 / self.count as f64;
            Helix { start, end, radius, turns: hand * turns, phase }.points(spacing)
        };
        Ok(hands.iter().flat_map(|&hand| (0..self.count).map(move |k| fibre(hand, k))).collect())
    }

    fn words(&self) -> String {
        let steepness = match (self.pitch, self.angle, self.turns) {
            (Some(pitch), ..) => format!("pitch {:.4} mm", pitch.0 * 1e3),
            (_, Some(angle), _) => format!("{:.4}° to the axis", angle.0.to_degrees()),
            (.., turns) => format!("{} turns", turns.unwrap_or_default()),
        };
        let hand = match self.hand {
            Hand::Right => "right-handed",
            Hand::Left => "left-handed",
            Hand::Both => "of each hand",
        };
        format!("{} helices {hand}, radius {:.4} mm, {steepness}", self.count, self.radius.0 * 1e3)
    }
}

/// The lines with the weights by which the body carries their points. Points outside of the body, by at most `reach` \[m\], cause a note.
fn embedded(
    builder: &mut Builder,
    place: &str,
    lines: &[Vec<Vec3>],
    (name, reach): (&str, f64),
) -> Result<Vec<Vec<FibrePoint>>, SceneError> {
    let (points, mesh) = (lines.concat(), &builder.body.mesh);
    let found = attach(mesh, &points, f64::INFINITY).expect("everything is within an infinite reach");
    let beyond = |distance: f64| -> Vec<(&Vec3, f64)> {
        points.iter().zip(found.iter().map(|a| a.outside)).filter(|(_, outside)| *outside > distance).collect()
    };
    let most = found.iter().map(|a| a.outside).fold(0.0, f64::max);
    let refused = beyond(reach + ROUNDING * mesh.diagonal());
    if !refused.is_empty() {
        let listed = refused.iter().take(LISTED);
        let listed: Vec<String> = listed.map(|(at, d)| format!("{} by {:.4} mm", point(at), d * 1e3)).collect();
        let more = if refused.len() > LISTED { ", …" } else { "" };
        let fact = format!(
            "{} of {} points of the fibres are outside of the body by more than {:.4} mm, the furthest by {:.4} mm: {}{more}",
            refused.len(),
            points.len(),
            reach * 1e3,
            most * 1e3,
            listed.join(", ")
        );
        return Err(builder.content(
            place,
            fact,
            "move them inside, or give a `reach` for those that are on its surface",
        ));
    }
    let outside = beyond(ROUNDING * mesh.diagonal()).len();
    if outside > 0 {
        builder.notes.push(format!(
            "{name}: {outside} of {} points are outside of the body, by up to {:.4} mm, and move as if the cell next to them went on to there",
            points.len(),
            Decimals(most * 1e3)
        ));
    }
    let mut weights = found.into_iter().map(|a| a.weights);
    let line = |line: &Vec<Vec3>| line.iter().copied().zip(weights.by_ref()).collect();
    Ok(lines.iter().map(line).collect())
}

/// Adds a note on fibres that cross a gap from one part of the body to another.
fn note_gaps(builder: &mut Builder, name: &str, lines: &[Vec<FibrePoint>]) {
    let mesh = &builder.body.mesh;
    let mut pieces = DisjointSets::new(mesh.points.len());
    (0..mesh.cell_count()).for_each(|c| pieces.join(mesh.cell(c)));
    let mut piece = |(_, weights): &FibrePoint| weights.first().map(|(node, _)| pieces.first(*node));
    let segments = lines.iter().flat_map(|line| line.windows(2));
    let across: Vec<String> = segments
        .filter(|ends| piece(&ends[0]) != piece(&ends[1]))
        .map(|ends| format!("{} to {}", point(&ends[0].0), point(&ends[1].0)))
        .collect();
    if !across.is_empty() {
        builder.notes.push(format!(
            "{name}: segments that join parts of the body which no cells join: {}; the fibre holds these parts together; let it end at the gap \
             unless it runs free across it",
            few(&across)
        ));
    }
}

/// Columns of fibres: `<name>_tension_{mean,max}_N` and `<name>_stretch_{min,mean,max}`, means by length.
struct Recorded {
    name: String,
    fibres: Arc<Fibres>,
}

impl Recorder for Recorded {
    fn columns(&self) -> Vec<String> {
        let columns = ["tension_mean_N", "tension_max_N", "stretch_min", "stretch_mean", "stretch_max"];
        columns.map(|c| format!("{}_{c}", self.name)).into()
    }

    fn record(&self, now: &Moment) -> Vec<f64> {
        let stretches: Vec<f64> = self.fibres.stretches(&now.state.x).collect();
        let tensions: Vec<f64> = stretches.iter().map(|&s| self.fibres.tension(s)).collect();
        let whole: f64 = self.fibres.lengths().sum();
        let mean = |of: &[f64]| of.iter().zip(self.fibres.lengths()).map(|(v, l)| v * l).sum::<f64>() / whole;
        let most = |of: &[f64]| of.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let least = stretches.iter().copied().fold(f64::INFINITY, f64::min);
        vec![mean(&tensions), most(&tensions), least, mean(&stretches), most(&stretches)]
    }
}
