//! The scene of a study with its inputs left to a controller, and the states of its runs as needed for training.

use crate::material::KnownLaws;
use crate::math::units::{Dimension, parts, quantity};
use crate::reduction::{ConstantInputs, FullState, Input, ReducedModel, ReductionError, Training, TransientTraining};
use crate::scene::{Body, ParameterKey, Scene, changed_scene, mesh_sha256, simulated_files};
use crate::study::kind::Underived;
use crate::study::kinds::reduction::in_time;
use crate::study::kinds::reduction::of_cases::{check_files, check_mesh};
use crate::study::kinds::reduction::record::{ReductionInputRecord, ReductionRecord};
use crate::study::kinds::reduction::runs::at_points;
use crate::study::kinds::reduction::spec::TRAINING;
use crate::study::kinds::reduction::trained::{Runs, Trained};
use crate::study::rounds::Rounds;
use crate::study::store::record::{Role, StoredCase};
use crate::study::store::results::Results;
use crate::study::store::states::KeptStates;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Returns the cases of this role, in the order of the study; `None` if one of them has no result.
pub fn converged(results: &Results, role: Role) -> Option<Vec<&StoredCase>> {
    let families = results.study.families.iter().filter(move |f| f.role == role);
    let find = |id: &String| results.cases.iter().find(|c| c.record.id == *id).filter(|c| c.record.converged());
    families.flat_map(|f| &f.cases).map(find).collect()
}

/// A scene with the indices of the inputs of its study.
pub struct Prepared {
    pub scene: Scene,
    file: PathBuf,
    body: Arc<Body>,
    inputs: Vec<ReductionInputRecord>,
    /// Index among the inputs of a model, for each input of the study
    places: Vec<usize>,
    /// SI value of one unit, for each input of the study
    factors: Vec<f64>,
    /// Recorded columns that the models are to give
    pub names: Vec<String>,
    /// Changes that turn the scene of the study into this one
    pub changes: toml::Table,
}

impl Prepared {
    /// Prepares the scene from cases of the study with its results in `dir`, at least one of which is there.
    ///
    /// # Errors
    ///
    /// Returns an error if the scene cannot be built, or if its files or mesh differ from those of the cases.
    pub fn of(
        results: &Results,
        record: &ReductionRecord,
        cases: &[&StoredCase],
        dir: &Path,
    ) -> Result<Self, Underived> {
        let file = record.scene_file(dir);
        check_files(&file, cases)?;
        let quantities = results.study.quantities.values().next().cloned().unwrap_or_default();
        let factors: Vec<f64> = record.inputs.iter().map(|i| factor(&i.unit)).collect::<Result<_, _>>()?;
        let marks = marks(&record.inputs, &factors);
        let left = |(input, mark): (&ReductionInputRecord, &f64)| (input.key.clone(), left_open(input, *mark));
        let changes: Vec<(String, toml::Value)> = record.inputs.iter().zip(&marks).map(left).collect();
        let (of_study, known) = (&cases[0].record.provenance.scene, KnownLaws::default());
        let (spec, text) = changed_scene(&file, of_study, &changes, &known).map_err(|e| e.to_string())?;
        let of_case: toml::Table = text.parse().map_err(|e: toml::de::Error| e.to_string())?;
        let mut all: toml::Table = changes.into_iter().collect();
        all.extend(of_case.get("stage").map(|stage| ("stage".to_string(), stage.clone())));
        let body: Arc<Body> = Body::load(&file, &spec.mesh, &mut |_| {}).map_err(|e| e.to_string())?.into();
        check_mesh(&file, &body, cases)?;
        let scene = Scene::build(&file, spec, text, body.clone()).map_err(|e| e.to_string())?;
        let places = places(&scene, &record.inputs, (&marks, &factors))?;
        Ok(Self {
            scene,
            file,
            body,
            inputs: record.inputs.clone(),
            places,
            factors,
            names: quantities.iter().map(|q| q.name.clone()).collect(),
            changes: all,
        })
    }

    /// Returns the digest of the mesh.
    pub fn mesh_sha256(&self) -> String {
        mesh_sha256(&self.body)
    }

    /// Stores in a model the facts about the scene of the study that it keeps: the changes that lead to its own scene, the mesh, the files, and the
    /// inputs as they are in that scene. A model that moves starts where its runs start.
    pub fn complete(&self, model: &mut ReducedModel) {
        (model.origin.changes, model.origin.mesh_sha256) = (self.changes.to_string(), self.mesh_sha256());
        model.origin.files = simulated_files(&self.file, &self.scene.text);
        let rests = model.dynamics.is_none();
        let enriched = model.estimate_in_time.iter_mut().map(|e| &mut e.enriched.inputs);
        for inputs in std::iter::once(&mut model.inputs).chain(enriched) {
            for ((&place, factor), input) in self.places.iter().zip(&self.factors).zip(&self.inputs) {
                inputs[place].held = input.held;
                inputs[place].start = input.start.filter(|_| rests).map(|value| factor * value);
            }
        }
    }

    /// Converts values in the units of the study to the inputs of a model \[SI\].
    pub fn inputs(&self, values: &[f64]) -> Vec<f64> {
        let mut inputs = vec![0.0; values.len()];
        for ((&place, factor), value) in self.places.iter().zip(&self.factors).zip(values) {
            inputs[place] = factor * value;
        }
        inputs
    }

    /// Converts the inputs of a model \[SI\] to values in the units of the study.
    pub fn in_units(&self, inputs: &[f64]) -> Vec<f64> {
        self.places.iter().zip(&self.factors).map(|(&place, factor)| inputs[place] / factor).collect()
    }

    /// Returns the states of each run except the first one, at rest.
    pub fn runs(
        &self,
        cases: &[&StoredCase],
        record: &ReductionRecord,
        dir: &Path,
    ) -> Result<Vec<Vec<FullState>>, String> {
        let rounds = Rounds::read(dir);
        cases.iter().map(|case| self.states_of(case, record, &rounds, dir)).collect()
    }

    fn states_of(
        &self,
        case: &StoredCase,
        record: &ReductionRecord,
        rounds: &Rounds,
        dir: &Path,
    ) -> Result<Vec<FullState>, String> {
        let id = &case.record.id;
        let mut kept = KeptStates::read(dir, id)?;
        let points = points(case, record, rounds).ok_or_else(|| format!("{id}: its points are not known"))?;
        let column = |name: &String| case.series.columns.get(name).ok_or_else(|| format!("{id}: it has no {name}"));
        let columns: Vec<&Vec<f64>> = self.names.iter().map(column).collect::<Result<_, _>>()?;
        let states = kept.x.len();
        let rows = if record.motion.is_some() { (0..states).collect() } else { at_points(&kept.t) };
        let expected = if record.motion.is_some() { states } else { points.len() + 1 };
        if rows.len() != expected || columns.iter().any(|c| c.len() != states) || kept.lambda.len() != states {
            return Err(format!("{id}: it has {} states in place of {expected}; run the study again", rows.len()));
        }
        let states = rows.into_iter().enumerate().skip(1).map(|(point, row)| {
            let inputs = match record.motion {
                Some(motion) => self.inputs(&in_time::at(&record.inputs, &points, motion, kept.t[row])),
                None => self.inputs(&points[point - 1]),
            };
            let [x, lambda] = [&mut kept.x, &mut kept.lambda].map(|all| std::mem::take(&mut all[row]));
            FullState { inputs, x, lambda, values: columns.iter().map(|c| c[row]).collect() }
        });
        Ok(states.collect())
    }

    /// Returns the training of these runs, at rest or in time.
    pub fn trained<'a>(&'a self, record: &ReductionRecord, known: &'a Runs) -> Result<Trained<'a>, String> {
        if record.motion.is_none() {
            return Ok(Trained::AtRest(self.training(&known.states)?));
        }
        let training = TransientTraining::new(&self.scene, &known.runs, &self.names);
        training.map(Trained::InTime).map_err(|e| e.to_string())
    }

    /// Returns the training of these states.
    pub fn training<'a>(&'a self, states: &'a [FullState]) -> Result<Training<'a>, String> {
        let at = |values: &[f64]| self.at_constants(values).map_err(ReductionError::OtherScene);
        let of: Vec<(usize, &ReductionInputRecord)> =
            self.inputs.iter().enumerate().filter(|(_, input)| input.is_constant()).collect();
        let key =
            |(_, input): &(usize, &ReductionInputRecord)| input.key.parse::<ParameterKey>().map_err(|e| e.to_string());
        let named = |(k, input): &(usize, &ReductionInputRecord)| {
            Input::new(constant_name(input), input.range.map(|u| self.factors[*k] * u))
        };
        let constants = ConstantInputs {
            keys: of.iter().map(key).collect::<Result<_, _>>()?,
            inputs: of.iter().map(named).collect(),
            build: &at,
        };
        let constants = (!of.is_empty()).then_some(&constants);
        Training::with_constants(&self.scene, constants, states, &self.names).map_err(|e| e.to_string())
    }

    /// The scene with the constants at these values \[SI\].
    fn at_constants(&self, values: &[f64]) -> Result<Scene, String> {
        let of = self.inputs.iter().zip(&self.factors).filter(|(input, _)| input.is_constant());
        let changes: Vec<(String, toml::Value)> =
            of.zip(values).map(|((input, factor), value)| (input.key.clone(), input.text(value / factor))).collect();
        let known = &self.scene.spec.known_laws;
        let (spec, text) = changed_scene(&self.file, &self.scene.text, &changes, known).map_err(|e| e.to_string())?;
        Scene::build(&self.file, spec, text, self.body.clone()).map_err(|e| e.to_string())
    }
}

/// The points of a run in the units of the inputs, taken from the study or from a search.
fn points(case: &StoredCase, record: &ReductionRecord, rounds: &Rounds) -> Option<Vec<Vec<f64>>> {
    let member = &case.record.member;
    let all = if case.record.family == TRAINING { &record.training } else { &record.held_back };
    if let Some(points) = all.get(member) {
        return Some(points.clone());
    }
    // One state per run, at its end
    let set = rounds.member(&case.record.family, member)?;
    let value = |input: &ReductionInputRecord| match set.get(&input.key)? {
        toml::Value::Table(signal) => signal.get("of")?.as_array()?.last()?.as_array()?.get(1)?.as_float(),
        toml::Value::String(text) => parts(text).ok().map(|(number, ..)| number),
        number => number.as_float(),
    };
    Some(vec![record.inputs.iter().map(value).collect::<Option<Vec<f64>>>()?])
}

/// The value of an input in the scene of a model: a signal left to a controller, with a start value that identifies it; a constant at the middle of
/// its range.
fn left_open(input: &ReductionInputRecord, mark: f64) -> toml::Value {
    if input.is_constant() {
        return input.text(0.5 * (input.range[0] + input.range[1]));
    }
    let mut signal = toml::Table::new();
    signal.insert("kind".into(), "controlled".into());
    signal.insert("initial".into(), input.text(mark));
    signal.insert("range".into(), input.range.map(|end| input.text(end)).to_vec().into());
    signal.into()
}

/// Smallest distance of the mark of an input from other marks, relative to its range.
const APART: f64 = 1e-6;
/// Distance relative to a range within which a value matches a mark: rounding.
const ROUNDING: f64 = 1e-9;

/// Values within the ranges, in the units of the inputs, that identify each input at the start: no two of them are equal in SI \[inputs\].
fn marks(inputs: &[ReductionInputRecord], factors: &[f64]) -> Vec<f64> {
    let (n, mut marks) = (inputs.len(), Vec::<f64>::new());
    for (k, (input, factor)) in inputs.iter().zip(factors).enumerate() {
        let width = input.range[1] - input.range[0];
        let value = |turn: usize| input.range[0] + ((k + turn) % n + 1) as f64 / (n + 1) as f64 * width;
        let is_free = |value: &f64| {
            marks.iter().zip(factors).all(|(other, of)| (of * other - factor * value).abs() > APART * factor * width)
        };
        // Each previous mark takes at most one of the n values
        let free = (0..n).map(value).find(is_free).expect("there are more values than marks before it");
        marks.push(free);
    }
    marks
}

/// The index of each input of the study among the inputs of a model: signals in the order of the scene, then constants.
fn places(
    scene: &Scene,
    inputs: &[ReductionInputRecord],
    (marks, factors): (&[f64], &[f64]),
) -> Result<Vec<usize>, String> {
    let initial = scene.controls.values_from_outside(&scene.controls.memory());
    let mut constants = initial.len()..;
    let mut place = |(k, input): (usize, &ReductionInputRecord)| {
        if input.is_constant() {
            return constants.next().ok_or_else(String::new);
        }
        let off = |place: &usize| (initial[*place] - factors[k] * marks[k]).abs();
        let nearest = (0..initial.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest
            .filter(|place| off(place) <= ROUNDING * factors[k] * (input.range[1] - input.range[0]))
            .ok_or_else(|| format!("input {} drives nothing in the scene", input.name))
    };
    inputs.iter().enumerate().map(&mut place).collect()
}

/// The name of a constant among the inputs of a model: law, key and unit, `rubber_mu_Pa`.
fn constant_name(input: &ReductionInputRecord) -> String {
    let name = input.key.trim_start_matches("laws.").replace('.', "_");
    let is_pressure = parts(&format!("1 {}", input.unit)).is_ok_and(|(_, _, _, of)| of == Dimension::PRESSURE);
    if is_pressure { name + "_Pa" } else { name }
}

/// The SI value of one unit.
fn factor(unit: &str) -> Result<f64, String> {
    quantity(&format!("1 {unit}")).map(|q| q.0).map_err(|e| e.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ranges of which one is half of the other, in the same unit and in different ones, nested ranges and equal ones.
    #[test]
    fn no_two_inputs_have_the_same_mark() {
        for ranges in [
            vec![([0.0, 4.0], "mm"), ([0.0, 2.0], "mm")],
            vec![([0.0, 2.0], "mm"), ([0.0, 4.0], "mm")],
            vec![([0.0, 4e-3], "N"), ([0.0, 2.0], "mm")],
            vec![([0.0, 3.0], "mm"), ([0.0, 1.5], "mm"), ([0.0, 1.0], "mm"), ([-1.0, 3.0], "mm")],
            vec![([0.0, 5.0], "kPa"), ([0.0, 5.0], "kPa"), ([0.0, 5.0], "kPa")],
        ] {
            let input = |(range, unit): &([f64; 2], &str)| ReductionInputRecord {
                name: "a".into(),
                key: "k".into(),
                unit: (*unit).into(),
                range: *range,
                start: None,
                held: false,
            };
            let inputs: Vec<ReductionInputRecord> = ranges.iter().map(input).collect();
            let factors: Vec<f64> = inputs.iter().map(|i| factor(&i.unit).expect("a unit")).collect();
            let marks = marks(&inputs, &factors);
            for (k, input) in inputs.iter().enumerate() {
                assert!(input.range[0] < marks[k] && marks[k] < input.range[1], "{ranges:?}: {marks:?}");
                let apart = |j: usize| (factors[j] * marks[j] / (factors[k] * marks[k]) - 1.0).abs();
                assert!((0..k).all(|j| apart(j) > 1e-3), "{ranges:?}: {marks:?}");
            }
        }
    }
}
