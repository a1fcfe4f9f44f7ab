//! The keys of a study file that all kinds of study share.

use crate::math::units::{self, Dimension};
use crate::scene::{SceneError, from_text};
use crate::study::kind::{StoredExpansion, StudyScope};
use crate::study::kinds::{self, KINDS};
use crate::study::spec::Mistake;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::{Deserializer, Error};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// The keys of `studies/<name>/study.toml` that all kinds of study share.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct StudySpec {
    /// Kind of the study
    pub kind: KindName,
    /// The question that the study answers
    pub question: String,
    /// The expectation, written before the run
    pub expectation: String,
    /// Scene file, relative to the study
    pub scene: PathBuf,
    /// Largest accepted error bar, as a fraction or in %
    pub tolerance: String,
}

impl StudySpec {
    /// Parses the tolerance.
    pub fn tolerance(&self) -> Result<f64, Mistake> {
        let mistake = |fact: String, remedy: &str| -> Mistake { ("tolerance".into(), fact, remedy.into()) };
        let tolerance = units::parse(&self.tolerance, Dimension::NONE)
            .map_err(|e| mistake(e.to_string(), "write for example \"2 %\""))?;
        if tolerance > 0.0 && tolerance < 1.0 {
            return Ok(tolerance);
        }
        Err(mistake(format!("it is {tolerance}"), "it lies between 0 and 1; write for example \"2 %\""))
    }
}

/// The name of a kind in the registry of kinds.
#[derive(Clone, Debug)]
pub struct KindName(pub String);

impl JsonSchema for KindName {
    fn schema_name() -> Cow<'static, str> {
        "KindName".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "enum": KINDS.map(|kind| kind.name) })
    }
}

impl<'de> Deserialize<'de> for KindName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        const NAMES: [&str; KINDS.len()] = {
            let mut names = [""; KINDS.len()];
            let mut k = 0;
            while k < KINDS.len() {
                names[k] = KINDS[k].name;
                k += 1;
            }
            names
        };
        let name = String::deserialize(deserializer)?;
        if NAMES.contains(&name.as_str()) { Ok(Self(name)) } else { Err(D::Error::unknown_variant(&name, &NAMES)) }
    }
}

/// Reads a study file: its common keys, and the expansion that its kind makes of the other keys.
pub fn parse(file: &Path, text: &str, scope: StudyScope) -> Result<(StudySpec, StoredExpansion), SceneError> {
    let spec: StudySpec = from_text(file, text, "")?;
    let kind = kinds::find(&spec.kind.0).expect("the name was read from the registry");
    let expansion = (kind.expand)(file, text, scope)?;
    Ok((spec, expansion))
}
