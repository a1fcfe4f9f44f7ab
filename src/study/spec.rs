//! A study as it stands in a TOML file, and the cases that follow from it.

use super::record::{FamilyRecord, Quantity, Role, StudyRecord};
use crate::math::units::{self, Dimension};
use crate::scene::{SceneError, SceneSpec, from_text, read_scene, read_table};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// `studies/<name>/study.toml`
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudySpec {
    pub kind: Kind,
    pub question: String,
    /// What is expected, written before the run
    pub expectation: String,
    /// Scene file, relative to the study
    pub scene: PathBuf,
    /// Largest error bar that is accepted, as a fraction or in %
    pub tolerance: String,
    #[serde(rename = "variant")]
    pub variants: Vec<VariantSpec>,
    #[serde(rename = "family")]
    pub families: Vec<FamilySpec>,
}

/// The analyses; one of a kind, one line.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    Convergence,
}

/// The scene driven in one way, and the quantities judged there.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VariantSpec {
    pub name: String,
    /// Changes by path
    #[serde(default)]
    pub set: toml::Table,
    #[serde(rename = "quantity")]
    pub quantities: Vec<Quantity>,
}

/// Cases that differ in one thing only.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FamilySpec {
    pub name: String,
    pub role: Role,
    /// Variants it is run in, all if absent
    pub variants: Option<Vec<String>>,
    /// Changes for all members
    #[serde(default)]
    pub set: toml::Table,
    /// Label of a member → its changes
    pub members: toml::Table,
}

/// One scene to be run.
#[derive(Clone, Debug)]
pub struct Case {
    pub id: String,
    pub family: String,
    pub variant: String,
    pub scene_file: PathBuf,
    pub spec: SceneSpec,
    /// The scene with all its changes
    pub text: String,
}

/// A study and its cases.
#[derive(Clone, Debug)]
pub struct Study {
    pub name: String,
    pub file: PathBuf,
    pub record: StudyRecord,
    pub cases: Vec<Case>,
}

impl Study {
    /// Reads `study.toml` and expands it. `changes` are made to every case, last.
    pub fn read(file: &Path, changes: &[(String, toml::Value)]) -> Result<Self, SceneError> {
        let (text, _) = read_table(file)?;
        let spec: StudySpec = from_text(file, &text, "")?;
        let base = file.parent().unwrap_or(Path::new(""));
        let name = std::path::absolute(base)
            .ok()
            .and_then(|p| p.file_name().map(|n| n.to_string_lossy().into_owned()))
            .unwrap_or_else(|| "study".into());
        let content = |place: String, fact: String, remedy: &str| SceneError::Content {
            file: file.into(),
            place,
            fact,
            remedy: remedy.into(),
        };
        let tolerance = units::parse(&spec.tolerance, Dimension::NONE)
            .map_err(|e| content("tolerance".into(), e.to_string(), "write for example \"2 %\""))?;
        let mut cases: Vec<Case> = Vec::new();
        let mut families = Vec::new();
        let known: Vec<String> = spec.variants.iter().map(|v| v.name.clone()).collect();
        for family in &spec.families {
            let wanted = family.variants.as_ref().unwrap_or(&known);
            if let Some(unknown) = wanted.iter().find(|w| !known.contains(w)) {
                let place = format!("family {}", family.name);
                return Err(content(
                    place,
                    format!("there is no variant \"{unknown}\""),
                    "take one of the [[variant]]s",
                ));
            }
            let mut ids: Vec<String> = Vec::new();
            let mut formulation = String::new();
            for variant in spec.variants.iter().filter(|v| wanted.contains(&v.name)) {
                for (label, member) in &family.members {
                    let Some(member) = member.as_table() else {
                        let place = format!("family {}: members.{label}", family.name);
                        return Err(content(place, "it is not a table".into(), "write { \"mesh.cells\" = 4500 }"));
                    };
                    let all: Vec<(String, toml::Value)> = [&variant.set, &family.set, member]
                        .into_iter()
                        .flatten()
                        .map(|(k, v)| (k.clone(), v.clone()))
                        .chain(changes.iter().cloned())
                        .collect();
                    let scene_file = base.join(&spec.scene);
                    let (scene, text) = read_scene(&scene_file, &all)?;
                    formulation = scene.mesh.element.name().into();
                    // The same scene in two families is run once.
                    if let Some(same) = cases.iter().find(|c| c.text == text) {
                        ids.push(same.id.clone());
                        continue;
                    }
                    let id = format!("{}-{}-{label}", family.name, variant.name);
                    ids.push(id.clone());
                    let (family, variant) = (family.name.clone(), variant.name.clone());
                    cases.push(Case { id, family, variant, scene_file, spec: scene, text });
                }
            }
            families.push(FamilyRecord { name: family.name.clone(), role: family.role, formulation, cases: ids });
        }
        let quantities: BTreeMap<String, Vec<Quantity>> =
            spec.variants.iter().map(|v| (v.name.clone(), v.quantities.clone())).collect();
        let record = StudyRecord {
            study: name.clone(),
            kind: "convergence".into(),
            question: spec.question,
            expectation: spec.expectation,
            tolerance,
            quantities,
            variants: known,
            families,
            version: env!("CARGO_PKG_VERSION").into(),
        };
        Ok(Self { name, file: file.into(), record, cases })
    }
}
