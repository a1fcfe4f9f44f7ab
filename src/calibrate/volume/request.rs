//! The request for a fit of the change of volume.

use crate::calibrate::{Role, Sign, StretchRange};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// The test that gave the data.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum VolumeTest {
    /// Strain along and across a uniaxial load
    Lateral,
    /// Pressure over volume
    Bulk,
}

impl VolumeTest {
    /// Name in files and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lateral => "lateral",
            Self::Bulk => "bulk",
        }
    }

    /// Name of the measured values whose errors are fitted.
    pub(super) fn responses(self) -> &'static str {
        match self {
            Self::Lateral => "lateral strains",
            Self::Bulk => "pressures",
        }
    }
}

impl std::str::FromStr for VolumeTest {
    type Err = String;
    fn from_str(word: &str) -> Result<Self, String> {
        match word {
            "lateral" => Ok(Self::Lateral),
            "bulk" => Ok(Self::Bulk),
            _ => Err(format!("\"{word}\" is not a kind of experiment; known: lateral, bulk")),
        }
    }
}

/// Request for a fit.
#[derive(Clone, PartialEq, Debug)]
pub struct VolumeRequest {
    pub data: PathBuf,
    /// Tables of further specimens of the same test
    pub more: Vec<PathBuf>,
    pub test: VolumeTest,
    /// Names of columns, or numbers such as `#3`
    pub columns: BTreeMap<Role, String>,
    pub units: BTreeMap<Role, String>,
    /// Volumetric part of a bulk test; by default the one with the smallest misfit
    pub volumetric: Option<String>,
    /// Stretches in the direction of the load that are fitted; `None`: all
    pub range: Option<StretchRange>,
    /// Direction of load whose strain the table counts as positive; `None`: tension, unless the column is called compressive
    pub positive: Option<Sign>,
}

impl VolumeRequest {
    pub fn new(data: impl Into<PathBuf>, test: VolumeTest) -> Self {
        Self {
            data: data.into(),
            more: vec![],
            test,
            columns: BTreeMap::new(),
            units: BTreeMap::new(),
            volumetric: None,
            range: None,
            positive: None,
        }
    }
}
