//! Solution of the linear systems of a scene: `[numerics] linear` and `factor_memory`, and its record in a run.

use crate::math::linear::{Factor, GradientCounts};
use crate::math::multigrid::Size;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::{Deserializer, Error};
use std::borrow::Cow;

/// `linear`: chosen by operation counts, or as requested.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LinearSpec {
    /// By the operation counts of both methods
    #[default]
    Auto,
    /// By a factorisation
    Direct,
    /// By a Krylov method with a multigrid hierarchy
    Iterative,
}

/// A size of memory such as "16 GB" \[GB\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MemorySpec(pub f64);

impl Default for MemorySpec {
    fn default() -> Self {
        Self(16.0)
    }
}

impl<'de> Deserialize<'de> for MemorySpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        let units = [("GB", 1.0), ("MB", 1e-3)];
        let read =
            units.iter().find_map(|(unit, size)| Some((text.strip_suffix(unit)?.trim().parse::<f64>().ok()?, size)));
        match read {
            Some((number, size)) if number > 0.0 && number.is_finite() => Ok(Self(number * size)),
            _ => Err(D::Error::custom(format!(
                "\"{text}\" is no size of memory; write for example \"16 GB\" or \"500 MB\""
            ))),
        }
    }
}

impl JsonSchema for MemorySpec {
    fn schema_name() -> Cow<'static, str> {
        "MemorySpec".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let what = "A size of memory in GB or MB.";
        let pattern = "^[0-9.]+(?:[eE][+-]?[0-9]+)? *(?:GB|MB)$";
        json_schema!({ "type": "string", "pattern": pattern, "description": what, "examples": ["16 GB"] })
    }
}

/// How the linear systems of a run were solved.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearWork {
    /// Reason for this method
    pub why: String,
    /// The last hierarchy; `None` with the direct method
    pub hierarchy: Option<Size>,
    /// Number of right-hand sides solved iteratively to full accuracy, and of their iterations
    pub gradients: GradientCounts,
    /// Number of factorisations made because the iterations found negative curvature or were slow
    pub fallbacks: usize,
}

impl LinearWork {
    pub(super) fn of(factor: &Factor) -> Self {
        let hierarchy = factor.multigrid().map(|m| m.size);
        Self { why: factor.why.clone(), hierarchy, gradients: factor.gradients, fallbacks: factor.fallbacks }
    }
}
