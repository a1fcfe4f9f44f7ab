//! The task that a calibration study sets a case, read from `[calibration]` and from `measured` of its variant.

use crate::calibrate::Weighting;
use crate::calibrate::inverse::{Calibration, InverseError, Measured, MeasuredSpec, Settings};
use crate::math::units::{self, Dimension};
use crate::scene::Constant;
use crate::study::expand::Case;
use crate::study::record::Quantity;
use serde::Deserialize;
use sha2::{Digest, Sha256};
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

/// A case that waits for the constants of a calibration.
#[derive(Clone, Debug)]
pub struct After {
    /// Variant whose finest mesh gives them
    pub variant: String,
    /// Law of this case that is replaced
    pub law: String,
}

/// The case with the law of `source` and the constants found there, and these constants as they are called in it.
pub fn with_constants(case: &Case, after: &After, source: &Case, found: &Calibration) -> Option<(Case, Vec<Constant>)> {
    let plan = source.plan.as_ref()?;
    let name = &plan.constants.first()?.law;
    let mut law = source.spec.laws.get(name)?.clone();
    law.remove("provenance");
    let own = plan.constants.iter().zip(&found.constants).filter(|(c, _)| c.law == *name);
    let mut constants = vec![];
    for (c, f) in own {
        law.insert(c.key.clone(), if f.unit == "Pa" { format!("{} Pa", f.value).into() } else { f.value.into() });
        constants.push(Constant { law: after.law.clone(), key: c.key.clone() });
    }
    let mut scene: toml::Table = case.text.parse().ok()?;
    scene.get_mut("laws")?.as_table_mut()?.insert(after.law.clone(), law.clone().into());
    let mut case = Case { text: toml::to_string(&scene).ok()?, ..case.clone() };
    case.spec.laws.insert(after.law.clone(), law);
    Some((case, constants))
}

/// A case of a calibration.
#[derive(Clone, Debug)]
pub struct Plan {
    pub constants: Vec<Constant>,
    pub measured: Measured,
    pub x: String,
    pub y: String,
    pub settings: Settings,
    /// SHA-256 of all that is asked and of the table
    pub sha256: String,
}

impl Plan {
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
            sha256: Sha256::digest(asked).iter().map(|b| format!("{b:02x}")).collect(),
        })
    }
}
