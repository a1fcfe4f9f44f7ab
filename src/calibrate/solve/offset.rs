//! Strain offset of a curve: how data points move with it, and which curves have one.

use crate::calibrate::sample::sides;
use crate::calibrate::{FittableLaw, Mode, Sample};
use crate::material::Parameter;
use crate::math::units::Dimension;
use serde::Serialize;
use std::str::FromStr;

/// The offset as an unknown.
pub const OFFSET: Parameter =
    Parameter::new("slack", "e₀", Dimension::NONE, Parameter::ANY, "strain before the specimen carries load");

/// Curves whose strain offset is fitted.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SlackChoice {
    /// Curves that have data points without stress
    #[default]
    Auto,
    Yes,
    No,
}

impl FromStr for SlackChoice {
    type Err = String;
    fn from_str(word: &str) -> Result<Self, String> {
        match word {
            "auto" => Ok(Self::Auto),
            "yes" => Ok(Self::Yes),
            "no" => Ok(Self::No),
            _ => Err(format!("\"{word}\" is no choice of slack; known: auto, yes, no")),
        }
    }
}

/// Offset of the curve of a specimen in one mode.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Offset {
    pub specimen: usize,
    pub mode: Mode,
    /// Measured strain at which the specimen begins to carry load \[–\]
    pub strain: f64,
    /// 1 in tension, −1 in compression
    pub side: f64,
    /// Beginning of its fitted data points, as a strain towards its side \[–\]: zero, or noise below it
    pub begin: f64,
}

impl Offset {
    /// Whether a data point belongs to this curve. A data point on the other side of rest that was not fitted does not, and keeps its strain.
    pub fn is_of(&self, s: &Sample) -> bool {
        self.specimen == s.specimen && self.mode == s.mode && self.side * s.mode.strain(s.stretch) >= self.begin
    }

    /// The data point with its strain reduced by this part of the slack.
    pub fn shifted(&self, s: &Sample, by: f64) -> Sample {
        let strain = s.mode.strain(s.stretch) - by;
        Sample { stretch: if self.side * strain > 0.0 { s.mode.stretch(strain) } else { 1.0 }, ..*s }
    }

    /// ∂P/∂e₀ \[Pa\] at a data point without its slack.
    pub fn slope(&self, model: FittableLaw, values: &[f64], s: &Sample) -> f64 {
        if !self.is_of(s) || s.stretch == 1.0 { 0.0 } else { -slope(model, values, s) }
    }
}

/// The reason why a curve has no single offset: in a test on both sides of rest, each side has its own.
pub fn no_single_offset<'a>(mode: Mode, curve: impl Iterator<Item = &'a Sample>) -> Option<&'static str> {
    match mode {
        Mode::Biaxial => Some("a biaxial test has two strains, and no single offset"),
        _ if sides(curve) == [true, true] => {
            Some("a test to both sides of rest has no single offset: fit each side alone, with --range")
        }
        _ => None,
    }
}

/// ∂P/∂e \[Pa\] of the law at a data point, by central differences, to 1e-9.
pub fn slope(model: FittableLaw, values: &[f64], s: &Sample) -> f64 {
    const H: f64 = 1e-5;
    let strain = s.mode.strain(s.stretch);
    let at = |e: f64| model.at(values, &Sample { stretch: s.mode.stretch(e), ..*s });
    (at(strain + H) - at(strain - H)) / (2.0 * H)
}

/// The data points with the slack removed.
pub fn removed(samples: &[Sample], offsets: &[Offset]) -> Vec<Sample> {
    let one = |s: &Sample| offsets.iter().find(|o| o.is_of(s)).map_or(*s, |o| o.shifted(s, o.strain));
    samples.iter().map(one).collect()
}
