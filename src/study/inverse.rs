//! The task that a calibration study sets a case, read from `[calibration]` and from `measured` of its variant.

use crate::calibrate::Weighting;
use crate::calibrate::inverse::{InverseError, Measured, MeasuredSpec, Settings};
use crate::math::units::{self, Dimension};
use crate::scene::Constant;
use crate::storage;
use crate::study::store::record::Quantity;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// `[calibration]`
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibrationSpec {
    /// Constants to be found, as in the scene: `laws.rubber.mu`. They start at its values.
    pub unknown: Vec<String>,
    /// Measure of the error of a data point
    pub weighting: Weighting,
    /// The homogeneous piece that the usual reading of the test takes for the whole
    pub gauge: Option<GaugeSpec>,
    /// Intervals by profile likelihood too, for some forward solves more
    #[serde(default)]
    pub profile: bool,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GaugeSpec {
    pub length: String,
    pub section: String,
}

/// `[use]`: a scene that takes the law, to see what its constants leave open there.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UseSpec {
    /// Scene file, relative to the study
    pub scene: PathBuf,
    /// Its law that is replaced by the one with the constants that were found
    pub law: String,
    /// The quantity that is compared
    pub quantity: Quantity,
    /// Changes for all members
    #[serde(default)]
    pub set: toml::Table,
    /// Label of a member → its changes: meshes from coarse to fine
    pub members: toml::Table,
}

/// A case of a calibration.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CalibrationPlan {
    pub constants: Vec<Constant>,
    pub measured: Measured,
    pub x: String,
    pub y: String,
    pub settings: Settings,
    /// SHA-256 of all that is asked and of the table
    pub sha256: String,
}

impl CalibrationPlan {
    /// `base`: folder of the study.
    pub fn new(base: &Path, spec: &CalibrationSpec, measured: &MeasuredSpec) -> Result<Self, InverseError> {
        let constants = spec.unknown.iter().map(|text| text.parse()).collect::<Result<Vec<Constant>, _>>()?;
        let section = Dimension::LENGTH.times(Dimension::LENGTH, 1);
        let gauge = spec.gauge.as_ref().map(|g| {
            let read = |key, text: &String, wanted| {
                let positive = |value: f64| {
                    if value > 0.0 { Ok(value) } else { Err(units::UnitError::NotANumber { text: text.clone() }) }
                };
                units::parse(text, wanted).and_then(positive).map_err(|fact| InverseError::Gauge {
                    key,
                    text: text.clone(),
                    fact,
                })
            };
            Ok::<_, InverseError>([
                read("length", &g.length, Dimension::LENGTH)?,
                read("section", &g.section, section)?,
            ])
        });
        let gauge = gauge.transpose()?;
        let curve = Measured::read(base, measured)?;
        let asked = format!("{spec:?} {measured:?} {}", curve.sha256);
        Ok(Self {
            constants,
            measured: curve,
            x: measured.x.is.clone(),
            y: measured.y.is.clone(),
            settings: Settings { weighting: spec.weighting, gauge, profile: spec.profile },
            sha256: storage::sha256(asked),
        })
    }
}
