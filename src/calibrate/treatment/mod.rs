//! Treatments of the data points before a fit: the requested one, and alternatives.

pub(super) mod condense;
pub(super) mod corrections;
pub(super) mod cycle;
pub(super) mod group;
pub(super) mod hold;
pub(super) mod order;
pub(super) mod prepare;
pub(super) mod rupture;
pub(super) mod toe_line;

use crate::calibrate::Sample;
use cycle::Cycle;
use serde::{Deserialize, Serialize};

/// The requested treatment of the data points; a field that is `None` leaves them unchanged.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Preparation {
    /// The loading that is fitted; `None`: the first one, with a warning if there are more branches
    pub cycle: Option<Cycle>,
    /// Number of first data points whose mean stress becomes zero
    pub zero: Option<usize>,
    /// Noise level, such as `2 kPa`
    pub toe: Option<String>,
}

impl Preparation {
    /// This preparation, completed by another one.
    pub(super) fn or(&self, other: &Self) -> Self {
        Self {
            cycle: self.cycle.or(other.cycle),
            zero: self.zero.or(other.zero),
            toe: self.toe.clone().or_else(|| other.toe.clone()),
        }
    }
}

/// A treatment that was not chosen.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Treatment {
    WithoutZero,
    WithoutToe,
    WithoutSlack,
    LastLoading,
    EveryRow,
    /// Includes the data points of a hold at the end of the loading
    WithHold,
    /// Includes the data points after the rupture
    WithRupture,
}

impl Treatment {
    pub fn words(self) -> &'static str {
        match self {
            Self::WithoutZero => "without zeroing",
            Self::WithoutToe => "without toe compensation",
            Self::WithoutSlack => "without slack",
            Self::LastLoading => "on the last loading",
            Self::EveryRow => "on every data point, unloading too",
            Self::WithHold => "with the hold at the peak, whose relaxation `durometer prony` fits",
            Self::WithRupture => "with the data points after rupture",
        }
    }
}

/// The samples under another treatment.
#[derive(Clone, Debug)]
pub struct Alternative {
    pub treatment: Treatment,
    /// Whether the treatment that the fit uses was not requested
    pub unasked: bool,
    pub samples: Vec<Sample>,
}
