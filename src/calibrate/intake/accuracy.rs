//! Accuracy of a measurement: bounds of the errors that all data points of a test share, and that no residual shows.

use crate::calibrate::FitError;
use crate::math::units::{self, Dimension};
use serde::{Deserialize, Deserializer, Serialize, de};
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// An error that all data points of a test share.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SharedError {
    /// Zero of the stress \[Pa\], different for each curve
    StressZero,
    /// Zero of the force \[N\], different for each curve
    ForceZero,
    /// Scale of the load cell, or of a cross-section that all test pieces share: P(1 + δ) \[–\]
    StressScale,
    /// Cross-section of one test piece: P(1 + δ), different for each curve \[–\]
    AreaScale,
    /// Zero of the strain \[–\], different for each curve
    StrainZero,
    /// Scale of the gauge length or the extensometer: e(1 + δ) \[–\]
    StrainScale,
    /// Compliance of machine and grips: e − δ PA/L \[m/N\]
    Compliance,
    /// Poisson's ratio of a foam \[–\]
    Poisson,
    /// Mean stress of the first data points, which was subtracted \[Pa\], different for each curve
    Zeroing,
    /// Strain at which the line of the toe reaches zero stress, which was subtracted \[–\], different for each curve
    Toe,
}

impl SharedError {
    /// All errors that can be stated, with their keys, dimensions and names
    pub const ALL: [(Self, &'static str, Dimension, &'static str); 8] = [
        (Self::StressZero, "stress_zero", Dimension::PRESSURE, "zero of the stress"),
        (Self::ForceZero, "force_zero", Dimension::FORCE, "zero of the force"),
        (Self::StressScale, "stress_scale", Dimension::NONE, "scale of the stress"),
        (Self::AreaScale, "area_scale", Dimension::NONE, "scale of the cross-section"),
        (Self::StrainZero, "strain_zero", Dimension::NONE, "zero of the strain"),
        (Self::StrainScale, "strain_scale", Dimension::NONE, "scale of the strain"),
        (Self::Compliance, "compliance", Dimension::COMPLIANCE, "compliance of the machine"),
        (Self::Poisson, "poisson", Dimension::NONE, "Poisson's ratio"),
    ];

    /// SI unit of the half-width
    pub fn unit(self) -> &'static str {
        match self {
            Self::StressZero | Self::Zeroing => "Pa",
            Self::ForceZero => "N",
            Self::StressScale | Self::AreaScale | Self::StrainZero | Self::StrainScale | Self::Poisson | Self::Toe => {
                "–"
            }
            Self::Compliance => "m/N",
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Zeroing => "scatter of the zero",
            Self::Toe => "scatter of the toe",
            stated => Self::ALL.into_iter().find(|(kind, ..)| *kind == stated).expect("all others are listed").3,
        }
    }

    /// Whether the error belongs to a correction of the data points, whose scatter determines it.
    pub fn is_of_a_correction(self) -> bool {
        matches!(self, Self::Zeroing | Self::Toe)
    }

    /// Stated errors that this correction removes from its curve.
    pub fn taken_off(self) -> &'static [Self] {
        match self {
            Self::Zeroing => &[Self::StressZero, Self::ForceZero],
            Self::Toe => &[Self::StrainZero],
            _ => &[],
        }
    }

    /// Whether each specimen has a different value of the error.
    pub fn is_of_a_curve(self) -> bool {
        matches!(self, Self::StressZero | Self::ForceZero | Self::AreaScale | Self::StrainZero)
            || self.is_of_a_correction()
    }
}

impl fmt::Display for SharedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Half-widths of the 95 % intervals of the shared errors \[SI\]; errors that are not given count as zero.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Accuracy(pub BTreeMap<SharedError, f64>);

/// Largest half-width that is accepted \[SI\]
const LARGEST: f64 = 1e30;

impl Accuracy {
    fn set(&mut self, key: &str, text: &str) -> Result<(), FitError> {
        let refuse = |reason: String| FitError::Accuracy { key: key.into(), text: text.into(), reason };
        let Some((kind, _, dimension, _)) = SharedError::ALL.into_iter().find(|(_, known, ..)| *known == key) else {
            let known: Vec<_> = SharedError::ALL.iter().map(|(_, known, ..)| *known).collect();
            return Err(refuse(format!("there is no such error; known: {}", known.join(", "))));
        };
        let value = units::parse(text, dimension).map_err(|e| refuse(e.to_string()))?;
        if !(value > 0.0 && value < LARGEST) {
            return Err(refuse(
                "must be above zero and below 1e30 in SI units: the half-width of a 95 % interval".into(),
            ));
        }
        self.0.insert(kind, value);
        Ok(())
    }

    /// These errors, completed by others.
    pub fn or(&self, other: &Self) -> Self {
        let mut all = other.0.clone();
        all.extend(&self.0);
        Self(all)
    }
}

/// Parses `KEY=VALUE`, as on the command line.
impl FromStr for Accuracy {
    type Err = FitError;
    fn from_str(text: &str) -> Result<Self, FitError> {
        let mut one = Self::default();
        let absent = || FitError::Accuracy {
            key: text.into(),
            text: String::new(),
            reason: "write KEY=VALUE, such as stress_zero=0.5kPa".into(),
        };
        let (key, value) = text.split_once('=').ok_or_else(absent)?;
        one.set(key.trim(), value.trim().trim_matches('"'))?;
        Ok(one)
    }
}

/// Reads `[accuracy]` of a card, a table of texts.
impl<'de> Deserialize<'de> for Accuracy {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let mut all = Self::default();
        for (key, text) in BTreeMap::<String, String>::deserialize(from)? {
            all.set(&key, &text).map_err(de::Error::custom)?;
        }
        Ok(all)
    }
}

/// Writes a map of keys to half-widths \[SI\].
impl Serialize for Accuracy {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_map(&self.0)
    }
}
