//! Parametric bodies as their `body.toml` declares them.

use super::GenerateError;
use crate::math::units::{self, Dimension};
use crate::storage::{self, TEXT_LIMIT};
use crate::wording::hint;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// A parametric body: `meshes/<name>/body.toml`.
#[derive(Clone, PartialEq, Debug, Deserialize)]
pub struct ParametricBody {
    #[serde(skip)]
    pub name: String,
    /// Incremented when the geometry changes for the same parameters
    pub version: u32,
    pub summary: String,
    #[serde(default)]
    pub parameters: BTreeMap<String, BodyParameter>,
    #[serde(default)]
    pub regions: BTreeMap<String, BodyPart>,
    #[serde(default)]
    pub paths: BTreeMap<String, BodyPart>,
    /// Features to which a graded size can refer
    #[serde(default)]
    pub features: BTreeMap<String, BodyPart>,
}

/// A parameter: a length if its default has a unit, otherwise a plain number.
#[derive(Clone, PartialEq, Debug, Deserialize)]
pub struct BodyParameter {
    pub default: String,
    pub meaning: String,
}

/// A region (with its dimension), path or feature.
#[derive(Clone, PartialEq, Debug, Deserialize)]
pub struct BodyPart {
    pub dim: Option<u8>,
    pub meaning: String,
}

impl BodyParameter {
    /// Returns the dimension of the parameter: length or none.
    pub fn dimension(&self) -> Dimension {
        if self.default.trim().ends_with('m') { Dimension::LENGTH } else { Dimension::NONE }
    }
}

impl ParametricBody {
    /// Reads the declaration of a body; an unknown name is refused with the nearest known one.
    pub fn load(home: &Path, name: &str) -> Result<Self, GenerateError> {
        let known = names(home);
        if !known.iter().any(|n| n == name) {
            return Err(unknown("body", name, &known));
        }
        let path = home.join("meshes").join(name).join("body.toml");
        let text = storage::read_text(&path, TEXT_LIMIT).map_err(|e| GenerateError::io(&path, &e))?;
        let bad = |e: toml::de::Error| GenerateError::Declaration {
            file: path.clone(),
            fact: e.to_string().trim().replace('\n', " "),
        };
        let mut body: Self = toml::from_str(&text).map_err(bad)?;
        body.name = name.to_string();
        Ok(body)
    }

    /// Reads a parameter as given in a scene: `"7.5 mm"`, `"4"` → SI value.
    pub fn parse(&self, name: &str, text: &str) -> Result<f64, GenerateError> {
        let parameter = self.parameter(name)?;
        let fact = |e: units::UnitError| GenerateError::Parameter {
            body: self.name.clone(),
            name: name.into(),
            fact: e.to_string(),
        };
        units::parse(text, parameter.dimension()).map_err(fact)
    }

    /// Returns the declaration of a parameter.
    pub fn parameter(&self, name: &str) -> Result<&BodyParameter, GenerateError> {
        let what = format!("parameter of {}", self.name);
        self.parameters.get(name).ok_or_else(|| unknown(&what, name, self.parameters.keys()))
    }

    /// Returns all parameters: the defaults, overridden by the `given` values in SI.
    pub fn resolve(&self, given: &BTreeMap<String, f64>) -> Result<BTreeMap<String, f64>, GenerateError> {
        let mut all = BTreeMap::new();
        for (name, parameter) in &self.parameters {
            all.insert(name.clone(), self.parse(name, &parameter.default)?);
        }
        for (name, &value) in given {
            self.parameter(name)?;
            if !value.is_finite() {
                let fact = format!("{value} is not a finite number");
                return Err(GenerateError::Parameter { body: self.name.clone(), name: name.clone(), fact });
            }
            all.insert(name.clone(), value);
        }
        Ok(all)
    }

    /// Refuses a feature that the body does not have.
    pub fn check_feature(&self, name: &str) -> Result<(), GenerateError> {
        let what = format!("feature of {}", self.name);
        if self.features.contains_key(name) { Ok(()) } else { Err(unknown(&what, name, self.features.keys())) }
    }
}

/// Names of all parametric bodies, sorted.
pub fn names(home: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(home.join("meshes")).into_iter().flatten().flatten();
    let bodies = entries.filter(|e| e.path().join("body.toml").is_file());
    let mut names: Vec<String> = bodies.filter_map(|e| e.file_name().into_string().ok()).collect();
    names.sort();
    names
}

fn unknown<'a>(what: &str, name: &str, known: impl IntoIterator<Item = &'a String>) -> GenerateError {
    let known: Vec<&String> = known.into_iter().collect();
    GenerateError::Unknown { what: what.into(), name: name.into(), hint: hint(name, &known) }
}
