//! Keys of a scene whose value is a number, with respect to which a run can be differentiated: `laws.rubber.mu`, `effect.gravity.direction.1`.

use crate::math::units::{self, Dimension, UnitError};
use crate::scene::text::overrides;
use crate::scene::text::overrides::OverrideError;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;
use toml::{Table, Value};

/// Reason why a path does not lead to a number of a scene.
#[derive(Debug, thiserror::Error)]
pub enum KeyError {
    #[error("\"{text}\" is no path to a key of a scene; write for example laws.rubber.mu, or effect.gravity.density")]
    Form { text: String },
    #[error(transparent)]
    NoKey(#[from] OverrideError),
    #[error("{key} is {is}, and a derivative is by one number")]
    NoNumber { key: ParameterKey, is: String },
    #[error("{key}: {source}")]
    Unit { key: ParameterKey, source: UnitError },
}

/// A key of a scene, given by a path as in [`overrides`].
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ParameterKey(String);

impl fmt::Display for ParameterKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl FromStr for ParameterKey {
    type Err = KeyError;

    fn from_str(text: &str) -> Result<Self, KeyError> {
        if text.contains('.') && text.split('.').all(|step| !step.is_empty()) {
            return Ok(Self(text.into()));
        }
        Err(KeyError::Form { text: text.into() })
    }
}

/// A constant of a law, given by the name of its table below `laws` and its key.
pub struct LawConstant<'a> {
    pub law: &'a str,
    pub key: &'a str,
}

impl ParameterKey {
    /// The key of a constant of a law, from the name of the law's table below `laws`.
    pub fn of_law(law: &str, key: &str) -> Self {
        Self(format!("laws.{law}.{key}"))
    }

    /// The law and the constant, if the key is a constant of a law.
    pub fn law_constant(&self) -> Option<LawConstant<'_>> {
        let (law, key) = self.0.strip_prefix("laws.")?.split_once('.')?;
        Some(LawConstant { law, key })
    }

    /// Whether the key is a number of the mesh itself, not of its regions.
    pub fn makes_mesh(&self) -> bool {
        self.0.starts_with("mesh.") && !self.0.starts_with("mesh.regions.")
    }

    /// The first step of the path.
    pub(in crate::scene) fn root(&self) -> &str {
        self.0.split('.').next().unwrap_or("")
    }

    /// The path.
    pub fn path(&self) -> &str {
        &self.0
    }

    /// The number that a scene has at this key.
    ///
    /// # Errors
    ///
    /// Where there is no value, or the value is not a number.
    pub fn value(&self, scene: &Table) -> Result<KeyValue, KeyError> {
        let found = overrides::find(scene, &self.0)?;
        let value = KeyValue::of(found).map_err(|is| KeyError::NoNumber { key: self.clone(), is })?;
        let Some(unit) = self.unit_of_point(scene).filter(|_| value.unit.is_none()) else { return Ok(value) };
        let (_, _, factor, dimension) =
            units::parts(&format!("1 {unit}")).map_err(|source| KeyError::Unit { key: self.clone(), source })?;
        Ok(KeyValue { factor, dimension, ..value })
    }

    /// Unit of a value among the points of a signal, which a different key of its table states.
    fn unit_of_point<'a>(&self, scene: &'a Table) -> Option<&'a str> {
        let (signal, place) = self.0.rsplit_once(".of.")?;
        let is_value = place.split_once('.').is_some_and(|(_, column)| column == "1");
        let unit = is_value.then(|| overrides::find(scene, &format!("{signal}.unit")).ok())?;
        unit?.as_str()
    }
}

/// The number of a key with its unit.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyValue {
    /// The number as in the file
    pub number: f64,
    /// Unit; `None` for a number without quotes, whose unit another key may state
    pub unit: Option<String>,
    /// Factor from the unit to SI
    pub factor: f64,
    pub dimension: Dimension,
}

impl KeyValue {
    /// The number of a value of a scene.
    ///
    /// # Errors
    ///
    /// Where the value is not a number; the error describes the value.
    pub fn of(value: &Value) -> Result<Self, String> {
        match value {
            Value::Float(number) => Ok(Self::plain(*number)),
            Value::Integer(number) => Ok(Self::plain(*number as f64)),
            Value::String(text) => {
                let (number, unit, factor, dimension) =
                    units::parts(text).map_err(|_| format!("the text \"{text}\""))?;
                Ok(Self { number, unit: Some(unit.into()), factor, dimension })
            }
            Value::Boolean(value) => Err(format!("{value}")),
            Value::Table(table) => {
                let known = table.keys().cloned().collect::<Vec<_>>().join(", ");
                Err(format!("a table with the keys {known}"))
            }
            Value::Array(list) => Err(format!("a list of {}; add the index, from 0", list.len())),
            Value::Datetime(_) => Err("a date".into()),
        }
    }

    fn plain(number: f64) -> Self {
        Self { number, unit: None, factor: 1.0, dimension: Dimension::NONE }
    }

    /// The value in SI.
    pub fn si(&self) -> f64 {
        self.number * self.factor
    }

    /// Another number in the same unit, as it is written in a file.
    pub fn written(&self, number: f64) -> Value {
        match self.unit.as_deref() {
            None => Value::Float(number),
            Some(unit) => Value::String(format!("{number} {unit}").trim_end().into()),
        }
    }

    /// A value in SI, written in the unit of the file.
    pub fn written_si(&self, value: f64) -> Value {
        self.written(value / self.factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_unit() {
        let scene: Table =
            "[a]\nrho = \"1.1 g/cm^3\"\nd = [0, 1.5]\nname = \"tip\"\nshare = \"2 %\"".parse().expect("TOML");
        let value = |path: &str| path.parse::<ParameterKey>().expect("a path").value(&scene);
        let rho = value("a.rho").expect("a density");
        assert!((rho.si() - 1100.0).abs() < 1e-9);
        assert_eq!(rho.written(1.2), Value::String("1.2 g/cm^3".into()));
        assert_eq!(value("a.d.0").expect("a number").written(-0.25), Value::Float(-0.25));
        assert_eq!(value("a.share").expect("a share").si(), 0.02);
        for (path, says) in [
            ("a.name", "a.name is the text \"tip\""),
            ("a.d", "a.d is a list of 2; add the index, from 0"),
            ("a.d.2", "there is no \"2\"; known: 0, 1"),
            ("a.rhoo", "did you mean `rho`?"),
        ] {
            let message = value(path).expect_err(path).to_string();
            assert!(message.contains(says), "{message}");
        }
        let points: Table =
            "[a]\ns = { kind = \"points\", of = [[0, 0], [2, 15]], unit = \"mm\" }".parse().expect("TOML");
        let value = |path: &str| path.parse::<ParameterKey>().expect("a path").value(&points).expect("a number");
        assert_eq!((value("a.s.of.1.1").si(), value("a.s.of.1.1").dimension), (15.0 * 1e-3, Dimension::LENGTH));
        assert_eq!(value("a.s.of.1.1").written_si(0.5), Value::Float(500.0));
        assert_eq!(value("a.s.of.1.0").si(), 2.0, "its time");
        assert!("rho".parse::<ParameterKey>().is_err() && "a..b".parse::<ParameterKey>().is_err());
    }
}
