//! The full model behind a reduced one: successive equilibria of the scene from which the reduced model was made.
//!
//! The scene runs in a separate thread, which waits between steps, so that each step starts from the last full state.

use crate::material::KnownLaws;
use crate::math::units::parts;
use crate::reduction::constants::Constants;
use crate::reduction::inputs::{Input, largest_part};
use crate::reduction::model::ReducedModel;
use crate::scene::control::{ControlError, Controller, Observation, Reply};
use crate::scene::{
    Body, FileDigest, MeshSpec, RunOptions, Scene, SceneError, changed_scene, mesh_sha256, overrides, read_scene,
    simulated_files,
};
use crate::solve::Status;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

/// Reason why a scene cannot serve as the full model, or has no equilibrium.
#[derive(Debug, thiserror::Error)]
pub enum FullModelError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Mesh(#[from] crate::mesh::error::MeshError),
    #[error("the reduced model does not say which scene it was made of; make it by a study of kind \"reduction\"")]
    Unknown,
    #[error(
        "the reduced model moves: a full step begins with velocities that a reduced state does not have; step it without the full model"
    )]
    Moves,
    #[error("{}: the reduced model was made of another scene: {key} differs or is missing; give the scene of its study", file.display())]
    OtherScene { file: PathBuf, key: String },
    #[error("{}: the reduced model was made on another mesh; give the scene of its study with its mesh, or make the model again", file.display())]
    OtherMesh { file: PathBuf },
    #[error("{}: the reduced model was made with other contents of {other}, a file of this scene; give the scene of its study with that file as it was, or make the model again", file.display())]
    OtherFile { file: PathBuf, other: String },
    #[error("the full model finds no equilibrium at these inputs: {0}")]
    NoEquilibrium(String),
}

/// The scene of a reduced model, at its last full state.
pub struct FullModel {
    file: PathBuf,
    text: String,
    known_laws: KnownLaws,
    body: Arc<Body>,
    constants: Constants,
    /// Inputs that are signals
    signals: Vec<Input>,
    /// Whether quantities count turns
    turns: bool,
    /// Columns of the quantities
    names: Vec<String>,
    running: Option<Running>,
    /// Files of the scene, other than those of the mesh, whose contents a model of an earlier version does not record
    uncompared: Vec<String>,
}

/// A running scene, with its constants.
struct Running {
    /// Values of the inputs that follow the signals
    constants: Vec<f64>,
    /// Signals of the last step; zero at rest
    signals: Vec<f64>,
    /// `None` when the scene is to end
    ask: Option<Sender<Vec<f64>>>,
    answer: Receiver<Answer>,
    thread: Option<JoinHandle<()>>,
}

/// Message of the thread.
enum Answer {
    /// The quantities
    Values(Vec<f64>),
    Ended(String),
}

/// Number of steps that a scene can make before it is restarted.
const STEPS: usize = 1_000_000;

impl FullModel {
    /// Opens the scene in `file`, which must be that of the study that made the model, with the same files and the same mesh.
    ///
    /// # Errors
    ///
    /// [`FullModelError`]: a scene that cannot be read, or is a different one.
    pub fn open(model: &ReducedModel, file: &Path) -> Result<Self, FullModelError> {
        if model.dynamics.is_some() {
            return Err(FullModelError::Moves);
        }
        let origin = &model.origin;
        let changes: toml::Table = origin.changes.parse().map_err(|_| FullModelError::Unknown)?;
        if changes.is_empty() {
            return Err(FullModelError::Unknown);
        }
        let changes: Vec<(String, toml::Value)> = changes.into_iter().collect();
        let other = |key: String| FullModelError::OtherScene { file: file.into(), key };
        let (spec, text) = read_scene(file, &[])?;
        let mut table: toml::Table = text.parse().unwrap_or_default();
        let missing = changes.iter().find(|(path, value)| overrides::apply(&mut table, path, value.clone()).is_err());
        if let Some((path, _)) = missing {
            return Err(other(path.clone()));
        }
        let text = changed_scene(file, &text, &changes, &spec.known_laws)?.1;
        let [own, known] = [&text, &origin.scene].map(|text| text.parse::<toml::Table>().unwrap_or_default());
        if let Some(key) = difference(&own.into(), &known.into(), "") {
            return Err(other(key));
        }
        let body: Arc<Body> = Body::load(file, &spec.mesh, &mut |_| {})?.into();
        if mesh_sha256(&body) != origin.mesh_sha256 {
            return Err(FullModelError::OtherMesh { file: file.into() });
        }
        let uncompared = compare_files(&origin.files, file, (&spec.mesh, &text))?;
        let mut stage = toml::Table::new();
        stage.insert("integrator".into(), "static".into());
        stage.insert("duration".into(), format!("{STEPS} s").into());
        stage.insert("dt".into(), "1 s".into());
        let open = changes.iter().filter_map(|(path, value)| Some((path.clone(), unloaded(value)?)));
        let changes: Vec<(String, toml::Value)> =
            open.chain([("stage".to_string(), vec![toml::Value::Table(stage)].into())]).collect();
        let text = changed_scene(file, &text, &changes, &spec.known_laws)?.1;
        let signals = (0..model.inputs.len()).filter(|&k| !model.constants.has(k));
        let signals = signals.map(|k| model.inputs[k].clone()).collect();
        let names = model.quantities.iter().map(|q| q.name.clone()).collect();
        let turns = model.quantities.iter().any(|q| q.reading.memory() > 0);
        Ok(Self {
            file: file.into(),
            text,
            known_laws: spec.known_laws,
            body,
            constants: model.constants.clone(),
            signals,
            turns,
            names,
            running: None,
            uncompared,
        })
    }

    /// Returns the quantities of the model at the equilibrium of these inputs in SI, starting from the last full state, or else from rest. If
    /// quantities count turns, the change is divided into parts, as in the reduced model.
    ///
    /// # Errors
    ///
    /// [`FullModelError::NoEquilibrium`]; the next step starts at rest.
    pub fn step(&mut self, inputs: &[f64]) -> Result<Vec<f64>, FullModelError> {
        let (signals, constants) = inputs.split_at(self.signals.len());
        let is_other = |running: &Running| running.constants != constants;
        if self.running.as_ref().is_some_and(is_other) {
            self.reset();
        }
        let mut from_rest = self.running.is_none();
        loop {
            if self.running.is_none() {
                self.running = Some(self.start(constants)?);
            }
            let inputs: &[Input] = if self.turns { &self.signals } else { &[] };
            match self.running.as_mut().expect("it runs").go(inputs, signals) {
                Ok(values) => return Ok(values),
                Err(why) => {
                    self.reset();
                    if from_rest {
                        return Err(FullModelError::NoEquilibrium(why));
                    }
                    from_rest = true;
                }
            }
        }
    }

    /// Returns the files of the scene that could not be compared with those of the study, because a model of an earlier version does not record them.
    /// The mesh was compared.
    pub fn uncompared(&self) -> &[String] {
        &self.uncompared
    }

    /// Returns to rest.
    pub fn reset(&mut self) {
        self.running = None;
    }

    fn start(&self, constants: &[f64]) -> Result<Running, FullModelError> {
        let changes: Vec<(String, toml::Value)> = self.constants.changes(self.signals.len(), constants);
        let (spec, text) = changed_scene(&self.file, &self.text, &changes, &self.known_laws)?;
        let scene = Scene::build(&self.file, spec, text, self.body.clone())?;
        let columns = scene.columns();
        let places: Vec<usize> = self.names.iter().filter_map(|n| columns.iter().position(|c| c == n)).collect();
        let ((ask, asked), (tell, answer)) = (channel(), channel());
        let thread = std::thread::spawn(move || run(&scene, Asked { asked, tell, places, started: false }));
        let signals = vec![0.0; self.signals.len()];
        Ok(Running { constants: constants.to_vec(), signals, ask: Some(ask), answer, thread: Some(thread) })
    }
}

impl Running {
    /// Returns the quantities at these signals, reached in parts in which no input changes by more than a given share of its range.
    fn go(&mut self, inputs: &[Input], signals: &[f64]) -> Result<Vec<f64>, String> {
        let parts = (1.0 / largest_part(inputs, |k| self.signals[k], signals)).ceil();
        for part in 1..parts as usize {
            let between = self.signals.iter().zip(signals).map(|(from, to)| from + part as f64 / parts * (to - from));
            self.step(&between.collect::<Vec<f64>>())?;
        }
        let values = self.step(signals)?;
        self.signals.copy_from_slice(signals);
        Ok(values)
    }

    fn step(&mut self, signals: &[f64]) -> Result<Vec<f64>, String> {
        let sent = self.ask.as_ref().is_some_and(|ask| ask.send(signals.to_vec()).is_ok());
        match self.answer.recv() {
            Ok(Answer::Values(values)) if sent => Ok(values),
            Ok(Answer::Ended(why)) => Err(why),
            _ => Err("its run has ended".into()),
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // The thread waits for inputs, and ends when there are none
        self.ask = None;
        if let Some(thread) = self.thread.take() {
            thread.join().ok();
        }
    }
}

/// Refuses files that differ from those of the study. Returns the names of the files that cannot be compared, if none are recorded.
fn compare_files(
    known: &[FileDigest],
    scene: &Path,
    (mesh, text): (&MeshSpec, &str),
) -> Result<Vec<String>, FullModelError> {
    let mut named = simulated_files(scene, text);
    let is_other = |now: &&FileDigest| known.iter().any(|of_study| of_study.file == now.file && of_study != *now);
    if let Some(other) = named.iter().find(is_other) {
        return Err(FullModelError::OtherFile { file: scene.into(), other: other.file.clone() });
    }
    if !known.is_empty() {
        named.clear();
    }
    let of_parts = mesh.parts.iter().filter_map(|part| part.file.as_deref());
    let of_mesh: Vec<&Path> = mesh.file.as_deref().into_iter().chain(of_parts).collect();
    Ok(named.into_iter().map(|f| f.file).filter(|name| !of_mesh.contains(&Path::new(name))).collect())
}

/// Runs a scene as requested by the other thread.
fn run(scene: &Scene, mut asked: Asked) {
    let tell = asked.tell.clone();
    let run = scene.run_with(RunOptions { controller: Some(&mut asked), undiagnosed: true, ..RunOptions::default() });
    let why = match run.status {
        Status::Converged => "its steps are used up".into(),
        status => status.to_string(),
    };
    // The receiver may no longer exist
    tell.send(Answer::Ended(run.failure.map_or(why, |failure| failure.to_string()))).ok();
}

/// Takes the signals from the other thread, and returns the resulting quantities.
struct Asked {
    asked: Receiver<Vec<f64>>,
    tell: Sender<Answer>,
    places: Vec<usize>,
    started: bool,
}

impl Controller for Asked {
    fn step(&mut self, now: &Observation, signals: &mut [f64]) -> Result<Reply, ControlError> {
        if std::mem::replace(&mut self.started, true) {
            let values = self.places.iter().map(|&k| now.row[k]).collect();
            self.tell.send(Answer::Values(values)).ok();
        }
        match self.asked.recv() {
            Ok(values) => signals.copy_from_slice(&values),
            Err(_) => return Ok(Reply { stop: true, ..Reply::default() }),
        }
        Ok(Reply::default())
    }
}

/// Returns a controlled signal without a range, so that it may have any value, and without a load at the start, when the body is undeformed.
fn unloaded(signal: &toml::Value) -> Option<toml::Value> {
    let mut signal = signal.as_table()?.clone();
    signal.remove("range")?;
    let unit = signal.get("initial").and_then(toml::Value::as_str).and_then(|text| parts(text).ok()).map(|of| of.1);
    let zero = unit.map_or(toml::Value::Float(0.0), |unit| format!("0 {unit}").into());
    signal.insert("initial".into(), zero);
    Some(signal.into())
}

/// Returns the path of the first key in which two scenes differ.
fn difference(a: &toml::Value, b: &toml::Value, path: &str) -> Option<String> {
    let below = |key: &str| if path.is_empty() { key.to_string() } else { format!("{path}.{key}") };
    match (a, b) {
        (toml::Value::Table(a), toml::Value::Table(b)) => {
            let keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
            keys.into_iter().find_map(|key| match (a.get(key), b.get(key)) {
                (Some(a), Some(b)) => difference(a, b, &below(key)),
                _ => Some(below(key)),
            })
        }
        (toml::Value::Array(a), toml::Value::Array(b)) if a.len() == b.len() => {
            a.iter().zip(b).enumerate().find_map(|(k, (a, b))| difference(a, b, &below(&k.to_string())))
        }
        _ => (a != b).then(|| path.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A study specifies its inputs by values within their ranges, which the undeformed body at the start does not have.
    #[test]
    fn a_full_model_begins_without_loads() {
        for (signal, expected) in [
            ("{ kind = 'controlled', initial = '13 mm', range = ['0 mm', '26 mm'] }", Some("0 mm")),
            ("{ kind = 'controlled', initial = '3.25 m/s^2', range = ['1 m/s^2', '9 m/s^2'] }", Some("0 m/s^2")),
            ("{ kind = 'controlled', initial = 0.5, range = [0.0, 1.0] }", None),
        ] {
            let table: toml::Table = format!("signal = {signal}").parse().expect("TOML");
            let found = unloaded(&table["signal"]).expect("a signal that is left open");
            let expected = expected.map_or(toml::Value::Float(0.0), Into::into);
            assert_eq!((found.get("initial"), found.get("range")), (Some(&expected), None));
        }
        // A list of stages, and a constant of a law
        assert_eq!([toml::Value::Array(vec![]), "60 kPa".into()].map(|other| unloaded(&other)), [None, None]);
    }
}
