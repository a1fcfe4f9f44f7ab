//! Keys of a reduction study, and the runs that follow from them.

use crate::math::units;
use crate::reduction::training::sampling::WORST;
use crate::scene::changes;
use crate::schema::AnyTable;
use crate::study::kind::{Expansion, RunRules};
use crate::study::kinds::reduction::constants;
use crate::study::kinds::reduction::in_scene;
use crate::study::kinds::reduction::in_time::{self, MotionSpec};
use crate::study::kinds::reduction::path::{ordered, random};
use crate::study::kinds::reduction::record::{MeshesRecord, ReductionInputRecord, ReductionRecord};
use crate::study::kinds::reduction::runs::{at_rest, in_units, members};
use crate::study::kinds::reduction::training::TrainingSpec;
use crate::study::spec::{FamilySpec, Mistake, VariantSpec, check_names, check_quantities};
use crate::study::store::record::{Role, StudyQuantity};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// Keys of a reduction study.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReductionStudy {
    /// Inputs of the models, with the ranges that they are made for
    #[serde(rename = "input", default)]
    pub inputs: Vec<ReductionInputSpec>,
    /// Recorded columns that the models give
    #[serde(rename = "quantity", default)]
    pub quantities: Vec<StudyQuantity>,
    /// States that the models are made of: their number, or a plan; or the number of runs in time
    pub training: TrainingSpec,
    /// Number of held-back states, or of runs in time, that the error bars are made from; at least 59 for bars that contain 95 % of the errors with a
    /// confidence of 95 %
    #[serde(default = "held_back")]
    pub held_back: usize,
    /// Number of runs into which the states of each kind are divided; without effect for runs in time
    #[serde(default = "runs")]
    pub runs: usize,
    /// Numbers of displacement modes, one model for each
    pub modes: Vec<usize>,
    /// Runs in time, for models that move
    pub motion: Option<MotionSpec>,
    /// Largest error of the forces that the choice of points may cause, as a fraction or in %
    #[serde(default = "sampling")]
    pub sampling: String,
    /// Other meshes that the models are compared with, each with its changes to the scene; requires `reference`
    #[serde(default, deserialize_with = "changes::of_members")]
    #[schemars(with = "BTreeMap<String, AnyTable>")]
    pub meshes: BTreeMap<String, toml::Table>,
    /// Changes that make the finer mesh from which the errors of meshes and models are measured
    #[serde(default, deserialize_with = "changes::by_path")]
    #[schemars(with = "Option<AnyTable>")]
    pub reference: Option<toml::Table>,
}

/// An input of reduced models.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReductionInputSpec {
    /// Name in words: `pull`
    pub name: String,
    /// Path into the scene of the signal or constant that the input replaces
    pub key: String,
    /// Smallest and largest value, with their unit
    pub range: [RangeEnd; 2],
}

/// An end of a range: a text with its unit, or a number without one.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "an end of a range is a text with its unit, such as \"15 mm\", or a number without one")]
pub enum RangeEnd {
    Text(String),
    Number(f64),
}

impl RangeEnd {
    fn text(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Number(number) => number.to_string(),
        }
    }
}

fn held_back() -> usize {
    124
}

fn runs() -> usize {
    2
}

fn sampling() -> String {
    "0.1 %".into()
}

/// Seeds of the training points and of the held-back points.
const SEEDS: [u64; 2] = [1, 2];
/// Name of the only variant of models at rest.
const VARIANT: &str = "static";
/// Name of the only variant of models that move.
const IN_TIME: &str = "in-time";

/// Family of the training states.
pub const TRAINING: &str = "training";
/// Family of the held-back states.
const HELD_BACK: &str = "held-back";
/// Families of the meshes that the models are compared with.
pub const MESHES: &str = "meshes";
pub const REFERENCE: &str = "reference";
/// Largest number of held-back states that the compared meshes pass through.
const COMPARED: usize = 10;

/// Returns the runs, or the first mistake as place, fact and remedy.
pub fn expand(study: ReductionStudy, tolerance: &str, scene: &Path) -> Result<Expansion<ReductionRecord>, Mistake> {
    let mut inputs = check(&study)?;
    constants::check(&inputs, scene)?;
    in_scene::complete(&mut inputs, scene, study.motion.is_some())?;
    let sampling = share(&study.sampling)?;
    let start: Vec<f64> = inputs.iter().map(at_rest).collect();
    let motion = study.motion.as_ref().map(in_time::motion).transpose()?;
    // All states of a run share its constants
    let apart = inputs.iter().any(ReductionInputRecord::is_constant);
    let number = if apart { usize::MAX } else { study.runs };
    let runs = |role: Role| match (motion, role) {
        (Some(motion), Role::Training) => {
            in_time::corners(inputs.len(), study.training.states(inputs.len()), motion, SEEDS[0])
        }
        (Some(motion), _) => in_time::corners(inputs.len(), study.held_back, motion, SEEDS[1]),
        (None, Role::Training) => parts(study.training.points(inputs.len(), SEEDS[0]), &start, number),
        (None, _) => parts(random(inputs.len(), study.held_back, SEEDS[1]), &start, number),
    };
    let families = [(TRAINING, Role::Training), (HELD_BACK, Role::HeldBack)].map(|(n, role)| (n, role, runs(role)));
    let mut record = ReductionRecord {
        scene: scene.into(),
        greedy: study.training.greedy(tolerance)?,
        meshes: None,
        inputs,
        training: BTreeMap::new(),
        held_back: BTreeMap::new(),
        motion,
        modes: study.modes.clone(),
        sampling,
    };
    let mut specs = vec![];
    for (name, role, of_runs) in families {
        let mut runs = toml::Table::new();
        for (k, shares) in of_runs.iter().enumerate() {
            let values: Vec<Vec<f64>> = shares.iter().map(|s| in_units(&record.inputs, s)).collect();
            let member = format!("{}", k + 1);
            let changes = match motion {
                Some(motion) => in_time::run(&record.inputs, &values, motion),
                None => members(&record.inputs, &values, names(&study.quantities)),
            };
            runs.insert(member.clone(), changes.into());
            let all = if role == Role::Training { &mut record.training } else { &mut record.held_back };
            all.insert(member, values);
        }
        specs.push(family(name, role, runs));
    }
    specs.extend(meshes(&study, &mut record)?);
    let variant = VariantSpec {
        name: if motion.is_some() { IN_TIME } else { VARIANT }.into(),
        label: Some(if motion.is_some() { "in time" } else { "static" }.into()),
        group: None,
        set: toml::Table::new(),
        quantities: study.quantities,
        scene: None,
    };
    let rules = RunRules { keep_states: true, share_cases: false, ..RunRules::default() };
    Ok(Expansion { rules, ..Expansion::new(vec![variant], specs, record) })
}

fn names(quantities: &[StudyQuantity]) -> impl Iterator<Item = &str> {
    quantities.iter().map(|q| q.name.as_str())
}

/// Points along a path of short steps, divided into runs.
fn parts(points: Vec<Vec<f64>>, start: &[f64], runs: usize) -> Vec<Vec<Vec<f64>>> {
    let way = ordered(points, start);
    way.chunks(way.len().div_ceil(runs).max(1)).map(<[Vec<f64>]>::to_vec).collect()
}

fn family(name: &str, role: Role, members: toml::Table) -> FamilySpec {
    FamilySpec {
        name: name.into(),
        role,
        variants: None,
        set: toml::Table::new(),
        members,
        labels: BTreeMap::new(),
        own: BTreeMap::new(),
        scene: None,
    }
}

/// The runs of other meshes through the first held-back states.
fn meshes(study: &ReductionStudy, record: &mut ReductionRecord) -> Result<Vec<FamilySpec>, Mistake> {
    let mistake = |place: &str, fact: &str, remedy: &str| Err((place.into(), fact.into(), remedy.into()));
    let Some(reference) = &study.reference else {
        return match study.meshes.is_empty() {
            true => Ok(vec![]),
            false => {
                mistake("meshes", "there is no mesh to count their errors from", "add [reference] with a finer mesh")
            }
        };
    };
    if record.inputs.iter().any(ReductionInputRecord::is_constant) {
        let fact = "meshes are compared along one run, whose constants of laws are the same at all states";
        return mistake("reference", fact, "compare meshes in a study whose inputs are signals");
    }
    let Some((member, points)) = record.held_back.first_key_value() else {
        return mistake("reference", "no state is held back to compare meshes at", "give held_back = 59 or more");
    };
    let points = &points[..points.len().min(COMPARED)];
    let run = members(&record.inputs, points, names(&study.quantities));
    let with = |own: &toml::Table| -> toml::Value {
        let mut all = run.clone();
        all.extend(own.clone());
        all.into()
    };
    let names = study.meshes.iter().map(|(name, own)| (name.clone(), with(own)));
    let reference: toml::Table = [(REFERENCE.to_string(), with(reference))].into_iter().collect();
    record.meshes = Some(MeshesRecord { reference: REFERENCE.into(), member: member.clone(), points: points.len() });
    let others = family(MESHES, Role::Sizes, names.collect());
    let mut out = vec![family(REFERENCE, Role::Reference, reference)];
    if !others.members.is_empty() {
        out.push(others);
    }
    Ok(out)
}

fn check(study: &ReductionStudy) -> Result<Vec<ReductionInputRecord>, Mistake> {
    let mistake = |place: &str, fact: String, remedy: &str| Err((place.into(), fact, remedy.into()));
    let names: Vec<String> = study.inputs.iter().map(|i| i.name.clone()).collect();
    if names.is_empty() {
        let remedy = "add an [[input]] with name, key and range = [\"0 mm\", \"15 mm\"]";
        return mistake("study", "the models have no input".into(), remedy);
    }
    check_names(&names).map_err(|(k, fact, remedy)| (format!("input {}", k + 1), fact, remedy.to_string()))?;
    let quantities = VariantSpec {
        name: VARIANT.into(),
        label: None,
        group: None,
        set: toml::Table::new(),
        quantities: study.quantities.clone(),
        scene: None,
    };
    check_quantities(&[quantities])?;
    if study.modes.is_empty() || study.modes.contains(&0) {
        return mistake("modes", format!("{:?}", study.modes), "give numbers of modes, for example [4, 8, 12]");
    }
    let least = 2 * study.modes.iter().max().copied().unwrap_or(0);
    study.training.check(names.len())?;
    let states = study.training.states(names.len());
    if study.motion.is_none() && states < least {
        let fact = format!("{states} states for {} modes", least / 2);
        return mistake("training", fact, "give twice as many states as modes, or more");
    }
    if study.held_back == 0 {
        let fact = "held_back = 0: errors and their bars are known from states that are held back";
        return mistake("held_back", fact.into(), "give 59 or more");
    }
    if study.runs == 0 {
        return mistake("runs", "no run at all".into(), "give 1 or more");
    }
    let inputs: Vec<ReductionInputRecord> = study.inputs.iter().map(input).collect::<Result<_, _>>()?;
    if study.motion.is_some() {
        at_rest_only(study, &inputs)?;
    }
    Ok(inputs)
}

/// Refuses keys that only models at rest have in a study of runs in time.
fn at_rest_only(study: &ReductionStudy, inputs: &[ReductionInputRecord]) -> Result<(), Mistake> {
    let mistake = |place: &str, fact: &str, remedy: &str| Err((place.into(), fact.into(), remedy.into()));
    if matches!(study.training, TrainingSpec::Plan(_)) {
        let fact = "a plan chooses states at rest; runs in time are drawn";
        return mistake("training", fact, "give the number of runs, or leave `motion` out");
    }
    if let Some(constant) = inputs.iter().find(|input| input.is_constant()) {
        let place = format!("input {}", constant.name);
        let fact = "a constant of a law is an input of models at rest only";
        return mistake(&place, fact, "take signals as inputs, or leave `motion` out");
    }
    if study.reference.is_some() || !study.meshes.is_empty() {
        let fact = "meshes are compared at states at rest";
        return mistake("reference", fact, "leave `reference` and `meshes` out, or `motion`");
    }
    Ok(())
}

fn input(spec: &ReductionInputSpec) -> Result<ReductionInputRecord, Mistake> {
    let place = format!("input {}", spec.name);
    let wrong =
        |fact: String| (place.clone(), fact, "write range = [\"0 mm\", \"15 mm\"], in units of the input".to_string());
    let ends = spec.range.each_ref().map(RangeEnd::text);
    let (_, unit, _, _) = units::parts(&ends[1]).map_err(|e| wrong(e.to_string()))?;
    let [low, high] = ends.each_ref().map(|text| units::in_unit(text, unit));
    let (low, high) = (low.map_err(|e| wrong(e.to_string()))?, high.map_err(|e| wrong(e.to_string()))?);
    if low >= high {
        let remedy = if low > high {
            format!("write range = [\"{}\", \"{}\"]", ends[1], ends[0])
        } else {
            "give two values, the least first".into()
        };
        return Err((place, format!("the range from {low} to {high} {unit} is empty"), remedy));
    }
    let (start, held) = (None, false);
    Ok(ReductionInputRecord {
        name: spec.name.clone(),
        key: spec.key.clone(),
        unit: unit.into(),
        range: [low, high],
        start,
        held,
    })
}

fn share(text: &str) -> Result<f64, Mistake> {
    let remedy = format!("write sampling = \"0.1 %\"; at most {:.0} % is of use", 100.0 * WORST);
    let wrong = |fact: String| ("sampling".to_string(), fact, remedy.clone());
    let value = units::parse(text, units::Dimension::NONE).map_err(|e| wrong(e.to_string()))?;
    if value > 0.0 && value <= WORST { Ok(value) } else { Err(wrong(format!("sampling = \"{text}\""))) }
}
