//! Constants of laws that are known within intervals, and the derivatives of recorded quantities by them.
//!
//! A law file of `durometer fit` has the key `mu_interval` next to the constant `mu`, in `[provenance]`: the ends of its 95 % interval. It has no
//! covariance, so constants count as independent of each other.

use crate::math::units::{self, Dimension};
use crate::scene::{ParameterKey, Run, SceneSpec, Sensitivities, extreme};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A constant with its interval, and derivatives of the extremes by it.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct InputRecord {
    /// `laws.rubber.mu`
    pub constant: String,
    /// Half of its 95 % interval \[SI\]
    pub half_width: f64,
    /// Column → derivative of its largest departure from the start \[unit of the column per SI unit of the constant\]
    pub derivatives: BTreeMap<String, f64>,
}

/// The constants of the laws of a scene whose files give an interval, with the half widths \[SI\].
pub fn uncertain_constants(spec: &SceneSpec) -> Vec<(ParameterKey, f64)> {
    let mut found = vec![];
    for (law, table) in &spec.laws {
        let Some(provenance) = table.get("provenance").and_then(toml::Value::as_table) else { continue };
        for (name, value) in provenance {
            let ends = value.as_array().map(|ends| ends.iter().filter_map(number).collect::<Vec<_>>());
            if let (Some(key), Some([low, high])) = (name.strip_suffix("_interval"), ends.as_deref())
                && table.contains_key(key)
                && high > low
            {
                found.push((ParameterKey::of_law(law, key), 0.5 * (high - low)));
            }
        }
    }
    found
}

/// A number in SI units; constants of laws are pressures or have no unit.
fn number(value: &toml::Value) -> Option<f64> {
    let text = || units::parse(value.as_str()?, Dimension::PRESSURE).ok();
    value.as_float().or_else(|| value.as_integer().map(|n| n as f64)).or_else(text).filter(|x| x.is_finite())
}

/// Derivatives of the extremes of all columns; none where they stop before one.
pub fn inputs(constants: &[(ParameterKey, f64)], run: &Run, sensitivities: &Sensitivities) -> Vec<InputRecord> {
    let column = |name: &String| {
        let k = run.columns.iter().position(|c| c == name)?;
        sensitivities.rows.get(extreme(run.rows.iter().map(|row| row[k]))?.at)
    };
    let record = |(n, (constant, half_width)): (usize, &(ParameterKey, f64))| {
        let derivative = |(j, name): (usize, &String)| {
            let d = column(name)?[j][n] - sensitivities.rows[0][j][n];
            d.is_finite().then(|| (name.clone(), d))
        };
        InputRecord {
            constant: constant.to_string(),
            half_width: *half_width,
            derivatives: sensitivities.columns.iter().enumerate().filter_map(derivative).collect(),
        }
    };
    constants.iter().enumerate().map(record).collect()
}
