//! The task that a calibration study gives to a case, read from `[calibration]` and from `measured` of its variant.

use crate::calibrate::inverse::{Bounds, InverseError, Measured, MeasuredSpec, OffsetAxis, Settings};
use crate::calibrate::{Loss, Weighting};
use crate::math::units::{self, Dimension};
use crate::scene::{ParameterKey, SensitivityError, changes, hint, read_scene};
use crate::schema::AnyTable;
use crate::storage;
use crate::study::spec::Mistake;
use crate::study::store::identity::Identity;
use crate::study::store::record::StudyQuantity;
use crate::wording::all;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The table `[calibration]` of a study
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CalibrationSpec {
    /// Numbers to find, as keys of the scene: `laws.rubber.mu`, `effect.inertia.density`. The search starts from the values of the scene
    pub unknown: Vec<String>,
    /// Smallest and largest value of a number; if absent, the range in which its law is defined or the number is meaningful
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, [serde_json::Value; 2]>")]
    pub bounds: Bounds,
    /// Measure of the error of a data point
    pub weighting: Weighting,
    /// Weight of data points far from the curve
    #[serde(default)]
    pub loss: Loss,
    /// The homogeneous piece that the usual evaluation of the test takes for the whole specimen
    pub gauge: Option<GaugeSpec>,
    /// Whether profile-likelihood intervals are computed too, at the cost of further forward solves
    #[serde(default)]
    pub profile: bool,
    /// Accuracy to which a scene can reproduce a curve: directions in the space of the constants that change it by less are not searched
    pub accuracy: Option<String>,
    /// Whether the corners of the dimensions known by ranges are run, too
    #[serde(default)]
    pub corners: bool,
    /// Wall time of the search in one case; the next run continues from its answer
    pub time_budget: Option<String>,
}

/// A homogeneous piece of the specimen
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GaugeSpec {
    /// Gauge length, with its unit
    pub length: String,
    /// Area of its cross-section, with its unit
    pub section: String,
}

/// `[use]`: a scene that uses the law, to show what its constants leave open there.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UseSpec {
    /// Scene file, relative to the study
    pub scene: PathBuf,
    /// Law of the scene that is replaced by the one with the constants found
    pub law: String,
    /// The quantity that is compared
    pub quantity: StudyQuantity,
    /// Changes of all members
    #[serde(default, deserialize_with = "changes::by_path")]
    #[schemars(with = "AnyTable")]
    pub set: toml::Table,
    /// Label of a member → its changes: meshes from coarse to fine
    #[serde(deserialize_with = "changes::of_members")]
    #[schemars(with = "AnyTable")]
    pub members: toml::Table,
}

impl UseSpec {
    /// Refuses unknowns that do not determine which of their laws replaces the law of the scene.
    pub fn check(&self, unknown: &[String]) -> Result<(), Mistake> {
        if used_law(unknown.iter().map(String::as_str), &self.law).is_some() {
            return Ok(());
        }
        let law = &self.law;
        let fact = format!("none of the unknowns {} says which law takes the place of \"{law}\"", all(unknown));
        let remedy =
            "leave out [use], or find constants of one law, or of several among which one has the name of its law";
        Err(("use.law".into(), fact, remedy.into()))
    }
}

/// The law among these constants (`laws.rubber.mu`) that replaces `law` in another scene: the one of the same name, or the only one.
pub fn used_law<'a>(constants: impl IntoIterator<Item = &'a str>, law: &str) -> Option<&'a str> {
    let laws = constants.into_iter().filter_map(|key| Some(key.strip_prefix("laws.")?.split_once('.')?.0));
    let laws: BTreeSet<&str> = laws.collect();
    let only = laws.first().filter(|_| laws.len() == 1);
    laws.get(law).or(only).copied()
}

/// A further curve that the same constants must reproduce, from a scene of its own.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CurveSpec {
    /// Name of the curve
    pub name: String,
    /// Scene file, relative to the study
    pub scene: PathBuf,
    /// Changes of that scene
    #[serde(default, deserialize_with = "changes::by_path")]
    #[schemars(with = "AnyTable")]
    pub set: toml::Table,
    /// Label of a member of a family → further changes in the case of that member; if absent, a curve of the scene of the study has the changes of the
    /// family
    #[serde(default, deserialize_with = "changes::of_members")]
    #[schemars(with = "AnyTable")]
    pub members: toml::Table,
    /// Measured curve that the scene must reproduce
    pub measured: MeasuredSpec,
}

/// A measured curve and its counterpart in the scene.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct MeasuredPlan {
    pub name: String,
    pub measured: Measured,
    pub x: String,
    pub y: String,
    pub specimen: Option<String>,
    pub offsets: Vec<OffsetAxis>,
}

/// A further curve of a case.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CurvePlan {
    pub curve: MeasuredPlan,
    pub scene_file: PathBuf,
    /// Its scene with all changes
    pub text: String,
    /// Changes of its scene in every case, and those in the cases of a member
    #[serde(skip)]
    set: Vec<Change>,
    #[serde(skip)]
    members: BTreeMap<String, Vec<Change>>,
}

/// A key of a scene and the value that it is set to.
type Change = (String, toml::Value);

/// The case that a plan is made for.
pub struct Member<'a> {
    pub scene_file: &'a Path,
    pub label: &'a str,
    /// Changes of all members of its family, its own changes, and those of the command line
    pub family: &'a [Change],
    pub own: &'a [Change],
    pub given: &'a [Change],
}

/// A case of a calibration.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CalibrationPlan {
    pub constants: Vec<ParameterKey>,
    pub bounds: Bounds,
    /// The curve of the scene of the case
    pub curve: MeasuredPlan,
    pub more: Vec<CurvePlan>,
    pub settings: Settings,
    /// SHA-256 of the task, of the tables and of the other scenes, without the time budget
    pub sha256: String,
}

impl MeasuredPlan {
    fn new(base: &Path, name: &str, spec: &MeasuredSpec) -> Result<Self, InverseError> {
        if (1..spec.offsets.len()).any(|k| spec.offsets[..k].contains(&spec.offsets[k])) {
            let (key, text) = ("measured.offsets", format!("{:?}", spec.offsets));
            return Err(InverseError::Setting { key, text, fact: "each of slack and zero once".into() });
        }
        Ok(Self {
            name: name.into(),
            measured: Measured::read(base, spec)?,
            x: spec.x.is.clone(),
            y: spec.y.is.clone(),
            specimen: spec.specimen.clone(),
            offsets: spec.offsets.clone(),
        })
    }
}

impl CurvePlan {
    fn new(base: &Path, spec: &CurveSpec) -> Result<Self, InverseError> {
        let curve = MeasuredPlan::new(base, &spec.name, &spec.measured)?;
        let scene_file = base.join(&spec.scene);
        let pairs = |set: &toml::Table| set.clone().into_iter().collect::<Vec<_>>();
        let set = pairs(&spec.set);
        let (_, text) = read_scene(&scene_file, &set)?;
        let member = |(label, changes): (&String, &toml::Value)| match changes.as_table() {
            Some(changes) => Ok((label.clone(), pairs(changes))),
            None => {
                let fact = "it is not a table; write { \"mesh.cells\" = 4500 }".into();
                Err(InverseError::Setting { key: "curve.members", text: label.clone(), fact })
            }
        };
        let members = spec.members.iter().map(member).collect::<Result<_, _>>()?;
        Ok(Self { curve, scene_file, text, set, members })
    }

    /// The plan of this curve in the case of a member. A curve of the same scene file has the changes of the case unless it has its own for the member.
    /// The changes of the case do not apply to another scene, which is refused unless it has its own.
    fn of(&self, m: &Member) -> Result<Self, InverseError> {
        let is_same = self.scene_file == m.scene_file;
        let given = if is_same { m.given } else { &[] };
        let changes = match self.members.get(m.label) {
            Some(own) => [&self.set[..], own, given].concat(),
            None if is_same => [&self.set[..], m.family, m.own, given].concat(),
            None if m.family.is_empty() && m.own.is_empty() => self.set.clone(),
            None => {
                let keys: Vec<&str> = m.family.iter().chain(m.own).map(|(key, _)| key.as_str()).collect();
                let (curve, member) = (self.curve.name.clone(), m.label.into());
                return Err(InverseError::OtherScene { curve, member, keys: keys.join(", ") });
            }
        };
        let (_, text) = read_scene(&self.scene_file, &changes)?;
        Ok(Self { text, ..self.clone() })
    }
}

impl CalibrationPlan {
    /// Builds the plan of a variant; `base` is the folder of the study.
    pub fn new(
        base: &Path,
        spec: &CalibrationSpec,
        (name, measured): (&str, &MeasuredSpec),
        more: &[CurveSpec],
    ) -> Result<Self, InverseError> {
        let constants = spec.unknown.iter().map(|text| text.parse()).collect::<Result<Vec<ParameterKey>, _>>();
        let constants = constants.map_err(SensitivityError::from)?;
        let curve = MeasuredPlan::new(base, name, measured)?;
        let more = more.iter().map(|c| CurvePlan::new(base, c)).collect::<Result<Vec<_>, _>>()?;
        let all = std::iter::once(&curve).chain(more.iter().map(|c| &c.curve));
        Measured::check_repeats(all.map(|c| (&*c.name, &c.measured)))?;
        let settings = settings(spec)?;
        let asked = format!(
            "{:?} {:?} {measured:?} {:?} {:?} {:?}",
            Settings { time_budget: None, ..settings.clone() },
            (&spec.unknown, &spec.bounds),
            curve.measured.sha256,
            more.iter().map(|c| &c.curve).collect::<Vec<_>>(),
            scenes_of(&more)
        );
        Ok(Self { constants, bounds: spec.bounds.clone(), curve, more, settings, sha256: storage::sha256(asked) })
    }

    /// Returns the plan for the case of a member; without further curves it is the same for all cases.
    ///
    /// # Errors
    ///
    /// A curve whose scene is refused, or whose changes for the member are not given.
    pub fn of(self: &Arc<Self>, member: &Member) -> Result<Arc<Self>, InverseError> {
        if self.more.is_empty() {
            return Ok(self.clone());
        }
        let more = self.more.iter().map(|c| c.of(member)).collect::<Result<Vec<_>, _>>()?;
        let sha256 = storage::sha256(format!("{} {:?}", self.sha256, scenes_of(&more)));
        Ok(Arc::new(Self { more, sha256, ..(**self).clone() }))
    }

    /// Refuses changes of a curve for a member that is not in `known`.
    pub fn check_members(&self, known: &[&String]) -> Result<(), InverseError> {
        let mut named = self.more.iter().flat_map(|c| c.members.keys().map(|label| (&c.curve.name, label)));
        if let Some((curve, label)) = named.find(|(_, label)| !known.contains(label)) {
            let fact = format!(
                "no family of the variant has this member, in whose case curve {curve} is to be changed; {}",
                hint(label, known)
            );
            return Err(InverseError::Setting { key: "curve.members", text: label.clone(), fact });
        }
        Ok(())
    }
}

/// Digests of the scenes of the curves.
fn scenes_of(curves: &[CurvePlan]) -> Vec<String> {
    curves.iter().map(|c| Identity::of(&c.scene_file, &c.text, "", &[]).sha256).collect()
}

fn settings(spec: &CalibrationSpec) -> Result<Settings, InverseError> {
    let section = Dimension::LENGTH.times(Dimension::LENGTH, 1);
    let gauge = spec.gauge.as_ref().map(|g| {
        let read = |key, text: &String, wanted| {
            let positive = |value: f64| {
                if value > 0.0 { Ok(value) } else { Err(units::UnitError::NotANumber { text: text.clone() }) }
            };
            units::parse(text, wanted).and_then(positive).map_err(|fact| InverseError::Gauge {
                key,
                text: text.clone(),
                fact,
            })
        };
        Ok::<_, InverseError>([read("length", &g.length, Dimension::LENGTH)?, read("section", &g.section, section)?])
    });
    let positive = |key: &'static str, text: &Option<String>, wanted, example: &str| {
        let refuse = |text: &String, fact: String| InverseError::Setting { key, text: text.clone(), fact };
        let read = |text: &String| match units::parse(text, wanted) {
            Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
            Ok(_) => Err(refuse(text, format!("it must be above zero; write for example \"{example}\""))),
            Err(why) => Err(refuse(text, why.to_string())),
        };
        text.as_ref().map(read).transpose()
    };
    let usual = Settings::new(spec.weighting);
    let accuracy = positive("calibration.accuracy", &spec.accuracy, Dimension::NONE, "1 %")?;
    if let (Some(_), Some(text)) = (accuracy.filter(|a| *a >= 1.0), &spec.accuracy) {
        let fact = "a curve that may be wrong by its own size determines nothing; write for example \"1 %\"".into();
        return Err(InverseError::Setting { key: "calibration.accuracy", text: text.clone(), fact });
    }
    Ok(Settings {
        loss: spec.loss,
        gauge: gauge.transpose()?,
        profile: spec.profile,
        accuracy: accuracy.unwrap_or(usual.accuracy),
        time_budget: positive("calibration.time_budget", &spec.time_budget, Dimension::TIME, "30 min")?,
        ..usual
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_law_that_is_used_has_its_name_or_is_the_only_one() {
        let of = |constants: &[&str]| used_law(constants.iter().copied(), "skin").map(String::from);
        assert_eq!(of(&["laws.core.mu", "laws.skin.mu"]).as_deref(), Some("skin"));
        assert_eq!(of(&["effect.0.density", "laws.core.mu", "laws.core.nu"]).as_deref(), Some("core"));
        assert_eq!((of(&["laws.core.mu", "laws.rim.mu"]), of(&["effect.0.density"]), of(&[])), (None, None, None));
    }
}
