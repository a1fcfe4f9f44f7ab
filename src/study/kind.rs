//! The trait of a kind of study.

use crate::scene::{ParameterKey, SceneError, from_text};
use crate::study::analysis::Analysis;
use crate::study::calibration_plan::{CalibrationPlan, UseSpec};
use crate::study::content::Content;
use crate::study::curve;
use crate::study::rounds::Round;
use crate::study::spec::{FamilySpec, VariantSpec, WrittenFamilies, refuse};
use crate::study::store::asked::Asks;
use crate::study::store::record::{Role, StoredCase, StudyRecord};
use crate::study::store::results::Results;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{DeserializeOwned, DeserializeSeed, Deserializer, IgnoredAny, MapAccess, Visitor};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A kind of study. The implementing type holds the keys of a study file that only this kind has; keys of other kinds count as unknown.
pub trait StudyKind: DeserializeOwned + JsonSchema {
    /// Value of `kind` in the study file
    const NAME: &'static str;
    /// Part of the study file that the analysis needs, stored as `details` in `study.json`
    type Details: Serialize + DeserializeOwned;
    /// Findings of this kind only; the rest of an analysis is common to all kinds
    type Findings;
    /// Roles that families in a study file of this kind can have; empty if it has no families
    const ROLES: &'static [Role] = &[];
    /// The study of this kind around a scene without a study file, if there is one
    const AROUND: Option<Around> = None;

    /// The keys of the quick subset of the study; all of them if nothing in this kind takes long.
    #[must_use]
    fn quick(self) -> Self {
        self
    }

    /// Returns the variants and families of cases that follow from the keys. `scene` is the scene file of the study, which need not exist.
    fn expand(self, file: &Path, scene: &Path) -> Result<Expansion<Self::Details>, SceneError>;

    /// Work on the results of all cases that is done once and stored in their folder. Its record is [`Results::derived`] in the analysis.
    ///
    /// # Errors
    ///
    /// The reason why it could not be done, in words; the report states it.
    fn derive(
        _results: &Results,
        _details: &Self::Details,
        _dir: &Path,
    ) -> Result<Option<serde_json::Value>, Underived> {
        Ok(None)
    }

    /// Cases that follow from the existing results, with a record of why; a round without members ends the search.
    ///
    /// # Errors
    ///
    /// The reason why they could not be determined, in words.
    fn grow(_results: &Results, _details: &Self::Details, _dir: &Path) -> Result<Option<Round>, String> {
        Ok(None)
    }

    /// Whether [`StudyKind::grow`] may add cases.
    fn grows(_details: &Self::Details) -> bool {
        false
    }

    /// Value of a quantity by which the study judges a case: its peak, or its largest change if it does not start at zero.
    fn judged(case: &StoredCase, quantity: &str, _details: &Self::Details) -> Option<f64> {
        curve::peak(case, quantity)
    }

    /// Analyses the cases that have a result. Cases that are missing or did not converge are listed, not guessed.
    fn analyse(results: &Results, details: &Self::Details) -> Analysis<Self::Findings>;

    /// Text, tables and figures of the analysis.
    fn report(results: &Results, analysis: &Analysis<Self::Findings>) -> Content;
}

/// Reason why [`StudyKind::derive`] could not be done.
#[derive(Debug, thiserror::Error)]
pub enum Underived {
    /// The files or the mesh of the scene have changed: what was derived from the same results before is kept
    #[error("{0}")]
    NotAsComputed(String),
    /// The results themselves are unsuitable: nothing that was derived from them is kept
    #[error("{0}")]
    Refused(String),
}

impl From<String> for Underived {
    fn from(why: String) -> Self {
        Self::Refused(why)
    }
}

/// How much of a study is requested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StudyScope {
    Whole,
    /// The quick subset, see [`StudyKind::quick`]
    Quick,
}

/// Returns the cases that follow from a scene with its changes.
pub type ExpandScene = fn(&Path, &[(String, toml::Value)]) -> Result<StoredExpansion, SceneError>;

/// A study around a single scene.
#[derive(Clone, Copy)]
pub struct Around {
    pub question: &'static str,
    pub expectation: &'static str,
    pub tolerance: &'static str,
    pub expand: ExpandScene,
}

/// The cases and details that a study file requests.
pub struct Expansion<D> {
    pub variants: Vec<VariantSpec>,
    pub families: Vec<FamilySpec>,
    pub rules: RunRules,
    /// Family → columns that its cases must record, if they are not those of the quantities of the variant
    pub columns: BTreeMap<String, Vec<String>>,
    /// Variant → constants to find in its cases
    pub plans: BTreeMap<String, Arc<CalibrationPlan>>,
    /// Scene that uses the constants found
    pub usage: Option<UseSpec>,
    /// Variant → keys with respect to which the cases of its design have derivatives
    pub derivatives: BTreeMap<String, Vec<ParameterKey>>,
    pub details: D,
}

/// An expansion with its details in the form of `study.json`.
pub type StoredExpansion = Expansion<serde_json::Value>;

impl<D> Expansion<D> {
    pub fn new(variants: Vec<VariantSpec>, families: Vec<FamilySpec>, details: D) -> Self {
        Self {
            variants,
            families,
            rules: RunRules::default(),
            columns: BTreeMap::new(),
            plans: BTreeMap::new(),
            usage: None,
            derivatives: BTreeMap::new(),
            details,
        }
    }
}

/// How the cases of a study are run.
#[derive(Clone, Debug)]
pub struct RunRules {
    /// Number of runs of every case except references; the run with the median CPU time is kept
    pub repeats: usize,
    /// Whether the smallest case runs first, so that memory which the allocator keeps after a large case is not attributed to a small one
    pub smallest_first: bool,
    /// Whether a refused scene is a result, and the other cases continue
    pub keep_refusals: bool,
    /// Whether cases with the same scene are run only once
    pub share_cases: bool,
    /// Whether errors of every case are estimated from its run alone
    pub error_estimates: bool,
    /// Whether derivatives with respect to constants with an interval in the law file are computed in every case
    pub input_uncertainty: bool,
    /// Whether these derivatives are known along the curves instead of at their extremes only, and only in cases of a design
    pub along_curves: bool,
    /// Whether the states of every case at the points of its time grid are kept
    pub keep_states: bool,
}

impl RunRules {
    /// The results requested in addition to the curves of the cases.
    pub fn asks(&self) -> Asks {
        Asks { error_estimates: self.error_estimates, input_uncertainty: self.input_uncertainty }
    }
}

impl Default for RunRules {
    fn default() -> Self {
        Self {
            repeats: 1,
            smallest_first: false,
            keep_refusals: false,
            share_cases: true,
            error_estimates: false,
            input_uncertainty: false,
            along_curves: false,
            keep_states: false,
        }
    }
}

/// Work on the results of all cases in a folder.
pub type Derive = fn(&Results, &Path) -> Result<Option<serde_json::Value>, Underived>;

/// Determines cases that follow from the results in a folder.
pub type Grow = fn(&Results, &Path) -> Result<Option<Round>, String>;

/// Values by which the study judges each case, by quantity; empty if `details` of `study.json` cannot be read.
pub type JudgedValues = fn(&StudyRecord, &[StoredCase]) -> Vec<BTreeMap<String, f64>>;

/// An entry of the registry of kinds.
#[derive(Clone, Copy)]
pub struct Kind {
    pub name: &'static str,
    /// Schema of the keys of this kind.
    pub schema: fn(&mut SchemaGenerator) -> Schema,
    /// Reads the keys of this kind from the text of a study file.
    pub expand: fn(&Path, &str, StudyScope) -> Result<StoredExpansion, SceneError>,
    pub around: Option<Around>,
    /// Implements [`StudyKind::derive`]
    pub derive: Derive,
    /// Implements [`StudyKind::grow`]
    pub grow: Grow,
    /// Implements [`StudyKind::grows`]
    pub grows: fn(&StudyRecord) -> bool,
    /// Implements [`StudyKind::judged`]
    pub judged: JudgedValues,
    /// Analyses and reports stored cases; the error tells what is wrong with `details` of `study.json`.
    pub report: fn(&Results) -> Result<Content, serde_json::Error>,
}

impl Kind {
    pub const fn of<K: StudyKind>() -> Self {
        let (schema, expand) = (K::json_schema, expand::<K>);
        let (derive, grow, grows, judged, report) = (derive::<K>, grow::<K>, grows::<K>, judged::<K>, report::<K>);
        Self { name: K::NAME, schema, expand, around: K::AROUND, derive, grow, grows, judged, report }
    }
}

/// The key of a study file that names its scene.
#[derive(Deserialize)]
struct SceneName {
    #[serde(default)]
    scene: PathBuf,
}

fn expand<K: StudyKind>(file: &Path, text: &str, scope: StudyScope) -> Result<StoredExpansion, SceneError> {
    // The reader of the keys knows the roles that only other kinds have. A text that cannot be read here is refused there
    if let (false, Ok(written)) = (K::ROLES.is_empty(), from_text::<WrittenFamilies>(file, text, "")) {
        written.check(K::NAME, K::ROLES).map_err(|mistake| refuse(file, mistake))?;
    }
    let OwnKeys(kind) = from_text::<OwnKeys<K>>(file, text, "")?;
    let kind = if scope == StudyScope::Quick { kind.quick() } else { kind };
    let SceneName { scene } = from_text(file, text, "")?;
    Ok(stored(kind.expand(file, &file.parent().unwrap_or(Path::new("")).join(scene))?))
}

/// Converts an expansion to one with its details in the form of `study.json`.
pub fn stored<D: Serialize>(e: Expansion<D>) -> StoredExpansion {
    let details = serde_json::to_value(e.details).expect("numbers, strings and string keys only");
    let Expansion { variants, families, rules, columns, plans, usage, derivatives, .. } = e;
    Expansion { variants, families, rules, columns, plans, usage, derivatives, details }
}

fn derive<K: StudyKind>(results: &Results, dir: &Path) -> Result<Option<serde_json::Value>, Underived> {
    let details = K::Details::deserialize(&results.study.details).map_err(|e| e.to_string())?;
    K::derive(results, &details, dir)
}

fn grow<K: StudyKind>(results: &Results, dir: &Path) -> Result<Option<Round>, String> {
    let details = K::Details::deserialize(&results.study.details).map_err(|e| e.to_string())?;
    K::grow(results, &details, dir)
}

fn grows<K: StudyKind>(study: &StudyRecord) -> bool {
    K::Details::deserialize(&study.details).is_ok_and(|details| K::grows(&details))
}

fn judged<K: StudyKind>(study: &StudyRecord, cases: &[StoredCase]) -> Vec<BTreeMap<String, f64>> {
    let Ok(details) = K::Details::deserialize(&study.details) else { return vec![BTreeMap::new(); cases.len()] };
    let of_case = |case: &StoredCase| {
        let quantities = case.variants().into_iter().filter_map(|v| study.quantities.get(v)).flatten();
        quantities.filter_map(|q| Some((q.name.clone(), K::judged(case, &q.name, &details)?))).collect()
    };
    cases.iter().map(of_case).collect()
}

fn report<K: StudyKind>(results: &Results) -> Result<Content, serde_json::Error> {
    let details = K::Details::deserialize(&results.study.details)?;
    Ok(K::report(results, &K::analyse(results, &details)).with_minus_signs())
}

/// Keys of a study file that all kinds share.
pub const COMMON_KEYS: [&str; 5] = ["kind", "question", "expectation", "scene", "tolerance"];

/// A value read from a table without [`COMMON_KEYS`]; errors keep their location in the text.
struct OwnKeys<T>(T);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for OwnKeys<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(OwnKeysVisitor(PhantomData))
    }
}

struct OwnKeysVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for OwnKeysVisitor<T> {
    type Value = OwnKeys<T>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a table")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        T::deserialize(serde::de::value::MapAccessDeserializer::new(WithoutCommon(map))).map(OwnKeys)
    }
}

struct WithoutCommon<A>(A);

impl<'de, A: MapAccess<'de>> MapAccess<'de> for WithoutCommon<A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, A::Error> {
        let mut seed = Some(seed);
        loop {
            match self.0.next_key_seed(KeySeed(&mut seed))? {
                None => return Ok(None),
                Some(Some(own)) => return Ok(Some(own)),
                Some(None) => drop(self.0.next_value::<IgnoredAny>()?),
            }
        }
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, A::Error> {
        self.0.next_value_seed(seed)
    }
}

/// Passes a key to the seed, unless it is a common one.
struct KeySeed<'a, K>(&'a mut Option<K>);

impl<'de, K: DeserializeSeed<'de>> DeserializeSeed<'de> for KeySeed<'_, K> {
    type Value = Option<K::Value>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_str(self)
    }
}

impl<'de, K: DeserializeSeed<'de>> Visitor<'de> for KeySeed<'_, K> {
    type Value = Option<K::Value>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a key")
    }

    fn visit_str<E: serde::de::Error>(self, key: &str) -> Result<Self::Value, E> {
        let own = self.0.take_if(|_| !COMMON_KEYS.contains(&key));
        own.map(|seed| seed.deserialize(serde::de::value::StrDeserializer::new(key))).transpose()
    }
}
