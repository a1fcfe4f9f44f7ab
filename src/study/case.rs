//! One scene of a study, and how a case that waits for a calibration takes its constants.

use crate::calibrate::inverse::Calibration;
use crate::material::registry::is_of_library;
use crate::scene::{Body, ParameterKey, SceneError, SceneSpec, from_text, mesh_sha256, named_files};
use crate::study::calibration_plan::{CalibrationPlan, used_law};
use crate::study::store::identity::Identity;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// One scene to run.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "SentCase")]
pub struct Case {
    pub id: String,
    pub family: String,
    pub variant: String,
    pub member: String,
    pub scene_file: PathBuf,
    /// The scene parsed from `text`, from which it is read again
    #[serde(skip_serializing)]
    pub spec: SceneSpec,
    /// The scene with all its changes
    pub text: String,
    /// Constants to find; without them the scene is run unchanged
    #[serde(serialize_with = "within")]
    pub plan: Option<Arc<CalibrationPlan>>,
    /// The calibration whose constants this case waits for
    pub after: Option<After>,
    /// Keys with respect to which its columns are differentiated
    pub derivatives: Vec<ParameterKey>,
}

/// The bodies of the scenes of a case.
pub struct Bodies {
    /// Body of the scene that is run
    pub own: Body,
    /// Bodies of the further curves of a calibration
    pub curves: Vec<Body>,
}

impl Bodies {
    /// SHA-256 digests of the meshes, in the order of the scenes.
    pub fn sha256(&self) -> Vec<String> {
        std::iter::once(&self.own).chain(&self.curves).map(mesh_sha256).collect()
    }
}

/// Scene file, specification and text of a scene.
pub type CaseScene<'a> = (&'a Path, Cow<'a, SceneSpec>, &'a str);

/// A case that waits for the constants of a calibration.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct After {
    /// Variant whose finest mesh provides them
    pub variant: String,
    /// Law of this case that they replace
    pub law: String,
}

/// A case as it is deserialised in another process.
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
    /// The scene that is run, followed by the scenes of the further curves of a calibration.
    ///
    /// # Errors
    ///
    /// A curve whose scene is refused.
    pub fn scenes(&self) -> Result<Vec<CaseScene<'_>>, SceneError> {
        let mut scenes: Vec<CaseScene> = vec![(&self.scene_file, Cow::Borrowed(&self.spec), &self.text)];
        for curve in self.plan.iter().flat_map(|plan| &plan.more) {
            let spec = from_text(&curve.scene_file, &curve.text, "")?;
            scenes.push((&curve.scene_file, Cow::Owned(spec), &curve.text));
        }
        Ok(scenes)
    }

    /// Loads the bodies of its scenes. `progress` receives the output lines of the mesher.
    ///
    /// # Errors
    ///
    /// A scene without a valid mesh.
    pub fn bodies(&self, progress: &mut dyn FnMut(&str)) -> Result<Bodies, SceneError> {
        let own = Body::load(&self.scene_file, &self.spec.mesh, progress)?;
        let curves = self.scenes()?.into_iter().skip(1);
        let curves = curves.map(|(file, spec, _)| Body::load(file, &spec.mesh, progress)).collect::<Result<_, _>>()?;
        Ok(Bodies { own, curves })
    }

    /// Whether a scene uses a law registered in this process: the identity of the result does not tell which law had this name.
    pub fn has_registered_law(&self) -> bool {
        let is_registered =
            |law: &toml::Table| law.get("law").and_then(toml::Value::as_str).is_some_and(|name| !is_of_library(name));
        self.scenes().is_ok_and(|scenes| scenes.iter().any(|(_, spec, _)| spec.laws.values().any(is_registered)))
    }

    /// The identity of the result of this case on meshes with these digests, in the order of its scenes; without digests, the identity of a case
    /// without a mesh.
    pub fn identity(&self, meshes: &[String]) -> Identity {
        let of_plan = self.plan.as_ref().map_or("", |plan| plan.sha256.as_str());
        let keys = self.derivatives.iter().map(|key| format!(" {key}"));
        let asked = std::iter::once(of_plan.to_string()).chain(keys).collect::<String>();
        Identity::of(&self.scene_file, &self.text, &asked, meshes)
    }

    /// The files that its scenes name, with the SHA-256 of their present content; without a digest for files that cannot be read.
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

    /// Returns this case with the law of `source` and the constants found there, and the keys of these constants in this case; `None` if the case does
    /// not wait for any.
    pub fn with_constants(&self, source: &Case, found: &Calibration) -> Option<(Case, Vec<ParameterKey>)> {
        let after = self.after.as_ref()?;
        let plan = source.plan.as_ref()?;
        let name = used_law(plan.constants.iter().map(ParameterKey::path), &after.law)?;
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
