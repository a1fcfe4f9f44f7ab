//! One scene of a study, and how a case that waits takes the constants of a calibration.

use crate::calibrate::inverse::Calibration;
use crate::scene::{Body, ParameterKey, SceneError, SceneSpec, from_text, mesh_sha256, named_files};
use crate::study::calibration_plan::CalibrationPlan;
use crate::study::store::identity::Identity;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// One scene to be run.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "SentCase")]
pub struct Case {
    pub id: String,
    pub family: String,
    pub variant: String,
    pub member: String,
    pub scene_file: PathBuf,
    /// The same as `text`, from which it is read again
    #[serde(skip_serializing)]
    pub spec: SceneSpec,
    /// The scene with all its changes
    pub text: String,
    /// Constants to be found; without them the scene is run as it is
    #[serde(serialize_with = "within")]
    pub plan: Option<Arc<CalibrationPlan>>,
    /// Waits for the constants of a calibration
    pub after: Option<After>,
    /// Keys that its columns are differentiated by
    pub derivatives: Vec<ParameterKey>,
}

/// A case that waits for the constants of a calibration.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct After {
    /// Variant whose finest mesh gives them
    pub variant: String,
    /// Law of this case that is replaced
    pub law: String,
}

/// A case as another process reads it.
#[derive(Deserialize)]
struct SentCase {
    id: String,
    family: String,
    variant: String,
    member: String,
    scene_file: PathBuf,
    text: String,
    plan: Option<CalibrationPlan>,
    after: Option<After>,
    derivatives: Vec<ParameterKey>,
}

impl TryFrom<SentCase> for Case {
    type Error = SceneError;

    fn try_from(sent: SentCase) -> Result<Self, SceneError> {
        let SentCase { id, family, variant, member, scene_file, text, plan, after, derivatives } = sent;
        let spec = from_text(&scene_file, &text, "")?;
        let plan = plan.map(Arc::new);
        Ok(Self { id, family, variant, member, scene_file, spec, text, plan, after, derivatives })
    }
}

fn within<S: serde::Serializer>(plan: &Option<Arc<CalibrationPlan>>, serializer: S) -> Result<S::Ok, S::Error> {
    plan.as_deref().serialize(serializer)
}

impl Case {
    /// Identity of the result of this case on its body; without one that of a case that has none.
    pub fn identity(&self, body: Option<&Body>) -> Identity {
        self.identity_on(body.map_or_else(String::new, mesh_sha256))
    }

    /// The same on a mesh of this digest.
    pub fn identity_on(&self, mesh_sha256: String) -> Identity {
        let of_plan = self.plan.as_ref().map_or("", |plan| plan.sha256.as_str());
        let keys = self.derivatives.iter().map(|key| format!(" {key}"));
        let asked = std::iter::once(of_plan.to_string()).chain(keys).collect::<String>();
        Identity::of(&self.scene_file, &self.text, &asked, mesh_sha256)
    }

    /// The files that its scenes name, with the SHA-256 of what they hold now; without one where a file cannot be read.
    pub fn files(&self) -> BTreeMap<PathBuf, String> {
        let more = self.plan.iter().flat_map(|plan| &plan.more);
        let scenes = more.map(|curve| (&curve.scene_file, curve.text.as_str()));
        let named = |(file, text): (&PathBuf, &str)| {
            let base = file.parent().unwrap_or(Path::new("")).to_path_buf();
            let files = text.parse().map_or_else(|_| vec![], |scene| named_files(file, &scene));
            files.into_iter().map(move |f| (base.join(f.file), f.sha256))
        };
        scenes.chain([(&self.scene_file, self.text.as_str())]).flat_map(named).collect()
    }

    /// This case with the law of `source` and the constants found there, and these constants as they are called in it;
    /// `None` for a case that does not wait.
    pub fn with_constants(&self, source: &Case, found: &Calibration) -> Option<(Case, Vec<ParameterKey>)> {
        let after = self.after.as_ref()?;
        let plan = source.plan.as_ref()?;
        let name = plan.constants.first()?.law_constant()?.law;
        let mut law = source.spec.laws.get(name)?.clone();
        law.remove("provenance");
        let of_laws = plan.constants.iter().zip(&found.constants).filter_map(|(c, f)| Some((c.law_constant()?, f)));
        let own = of_laws.filter(|(c, _)| c.law == name);
        let mut constants = vec![];
        for (c, f) in own {
            law.insert(c.key.into(), if f.unit == "Pa" { format!("{} Pa", f.value).into() } else { f.value.into() });
            constants.push(ParameterKey::of_law(&after.law, c.key));
        }
        let mut scene: toml::Table = self.text.parse().ok()?;
        scene.get_mut("laws")?.as_table_mut()?.insert(after.law.clone(), law.clone().into());
        let mut case = Case { text: toml::to_string(&scene).ok()?, ..self.clone() };
        case.spec.laws.insert(after.law.clone(), law);
        Some((case, constants))
    }
}
