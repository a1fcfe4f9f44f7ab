//! Scenes at several values θ + kh of one of their keys, with the same unknowns and equations: what they compute at one state gives the derivative by
//! the key, whatever it is ([`crate::math::difference`]).
//!
//! The scenes are built from the text of the scene, on the mesh of the scene where the key is not one of `[mesh]`. Kept of each are the
//! effects and constraints that the key can change, and the recorders. The step h is tried on a deformed state, and the one is taken that leaves the least error:
//! a guide that moves into another cell, for example, allows small ones only.

use super::body::Body;
use super::build::Scene;
use super::deform::is_made_here;
use super::error::SceneError;
use super::overrides;
use super::parameter_key::{KeyValue, ParameterKey};
use super::read::from_text;
use super::recorder::{Moment, Recorder};
use super::sensitivity_error::SensitivityError;
use super::spec::{EffectSpec, SceneSpec};
use super::trial;
use crate::math::difference::{PLACES, derivatives};
use crate::math::units::Dimension;
use crate::system::{State, SystemDifference};
use std::sync::Arc;
use toml::Table;

/// Steps that are tried, as powers of two of the size of the value: 1e-3, 3e-5, 1e-6. Rounding leaves about 2ε/h of a
/// residual: 5e-13, 1.5e-11, 5e-10.
const STEPS: [i32; 3] = [-10, -15, -20];
/// Error of the tried derivative, relative, that is good enough.
const ENOUGH: f64 = 1e-9;
/// Least size of a length whose derivative is taken, as a share of the body.
const LEAST_LENGTH: f64 = 0.1;

/// Recorders of the scenes, by which the columns depend on the key at a fixed state.
pub(super) struct SceneDifference {
    h: f64,
    /// Of the value of the key \[SI\]
    pub size: f64,
    recorders: Vec<Recorders>,
    /// Derivatives of the first state
    pub start: [State; 2],
}

/// The recorders of a scene, and their body.
struct Recorders {
    body: Arc<Body>,
    all: Vec<Box<dyn Recorder>>,
}

impl SceneDifference {
    /// For a key of a scene.
    pub fn new(scene: &Scene, key: &ParameterKey) -> Result<(Box<SystemDifference>, Self), SensitivityError> {
        let family = Family::new(scene, key)?;
        let mut best: Option<(f64, Built)> = None;
        let mut refused = None;
        for power in STEPS {
            match family.build(family.size * 2f64.powi(power)) {
                Ok(mut built) => {
                    let error = trial::error(scene, &mut built.0);
                    if best.as_ref().is_none_or(|(least, _)| error < *least) {
                        best = Some((error, built));
                    }
                    if error <= ENOUGH {
                        break;
                    }
                }
                Err(why) => {
                    refused.get_or_insert(why);
                }
            }
        }
        match (best, refused) {
            (Some((_, built)), _) => Ok(built),
            (None, Some(why)) => Err(why),
            (None, None) => unreachable!("there are steps to try"),
        }
    }

    /// Derivatives by the key of the columns that have one, at a fixed moment.
    pub fn columns(&self, now: &Moment) -> [Vec<f64>; 2] {
        let columns = |place: usize| {
            let of = &self.recorders[place];
            let mut memory = now.memory;
            let mut values = Vec::new();
            for recorder in &of.all {
                let (own, rest) = memory.split_at(recorder.memory().len());
                memory = rest;
                if recorder.is_differentiable() {
                    // An angle is kept with its whole rotations, and has to be seen again by the other recorder
                    let mut own = own.to_vec();
                    recorder.remember(&of.body, now.state, &mut own);
                    values.extend(recorder.record(&Moment { body: &of.body, memory: &own, ..*now }));
                }
            }
            Ok::<_, std::convert::Infallible>(values)
        };
        let Ok(found) = derivatives(self.h, columns);
        found
    }
}

type Built = (Box<SystemDifference>, SceneDifference);

/// A scene as a function of one key.
struct Family<'a> {
    scene: &'a Scene,
    key: &'a ParameterKey,
    table: Table,
    value: KeyValue,
    /// Size of the value by which steps are chosen \[SI\]
    size: f64,
    /// Whether each effect of the system can depend on the key
    vary: Vec<bool>,
}

impl<'a> Family<'a> {
    fn new(scene: &'a Scene, key: &'a ParameterKey) -> Result<Self, SensitivityError> {
        let table: Table = scene.text.parse().map_err(|_| SensitivityError::NoText { key: key.clone() })?;
        let value = key.value(&table)?;
        let vary = varied(scene, key, &table);
        let size = size(&value, scene);
        let family = Self { scene, key, table, value, size, vary };
        // A number that the reader takes in whole steps only, or that moves the mesher
        let (spec, _) = family.spec(0.5 * 2f64.powi(STEPS[0]))?;
        let deforms = key.path().starts_with("mesh.deform.");
        if key.makes_mesh() && !deforms && !is_made_here(&scene.file, &spec.mesh) {
            return Err(SensitivityError::Mesher { key: key.clone() });
        }
        Ok(family)
    }

    /// The specification at a step of so many sizes of the value.
    fn spec(&self, steps: f64) -> Result<(SceneSpec, String), SensitivityError> {
        let mut table = self.table.clone();
        if steps != 0.0 {
            let value = self.value.written(self.value.number + steps * self.size / self.value.factor);
            overrides::apply(&mut table, self.key.path(), value)?;
        }
        let text = toml::to_string(&table).expect("a table that was read can be written");
        let read = from_text(&self.scene.file, &text, &format!("with another {}", self.key));
        let spec =
            read.map_err(|source| SensitivityError::Discrete { key: self.key.clone(), source: Box::new(source) })?;
        Ok((spec, text))
    }

    fn build(&self, h: f64) -> Result<Built, SensitivityError> {
        let mut scenes = Vec::new();
        for place in PLACES {
            scenes.push(self.at(f64::from(place) * h)?);
        }
        let starts: Vec<State> = scenes.iter().map(Scene::start).collect();
        let mut recorders = Vec::new();
        let mut systems = Vec::new();
        for scene in scenes {
            let (system, body, all) = scene.into_parts();
            recorders.push(Recorders { body, all });
            systems.push(system);
        }
        let start = start(&starts, h);
        Ok((Box::new(SystemDifference::new(systems, h)), SceneDifference { h, size: self.size, recorders, start }))
    }

    /// The scene at θ + `step`, with the equations of the scene.
    fn at(&self, step: f64) -> Result<Scene, SensitivityError> {
        let scene = self.scene;
        let differs = |source| SensitivityError::Differs { key: self.key.clone(), source: Box::new(source) };
        let content = |fact: &str| {
            differs(SceneError::Content {
                file: scene.file.clone(),
                place: self.key.to_string(),
                fact: fact.into(),
                remedy: "a derivative needs the same equations with other values".into(),
            })
        };
        let (spec, _) = self.spec(step / self.size)?;
        let body = match self.key.makes_mesh() {
            false => scene.body.clone(),
            true => Arc::new(scene.body.varied(&scene.file, &spec.mesh).map_err(differs)?),
        };
        if body.mesh.cells != scene.body.mesh.cells || body.mesh.points.len() != scene.body.mesh.points.len() {
            return Err(content("the mesh has other cells"));
        }
        if step == 0.0 && body.mesh.points != scene.body.mesh.points {
            return Err(content("the body of the scene is not the one of its table [mesh]"));
        }
        let found = scene.variant(spec, body, |e| self.vary.get(e).copied().unwrap_or(true)).map_err(differs)?;
        if found.spans != scene.spans {
            return Err(content("the stages have other times"));
        }
        let names = |scene: &Scene| scene.signals.iter().map(|s| s.name.clone()).collect::<Vec<_>>();
        if found.columns() != scene.columns() || names(&found) != names(scene) {
            return Err(content("other columns are recorded"));
        }
        Ok(found)
    }
}

/// Size of a value by which steps are chosen \[SI\]: its own, but of a coordinate near zero a share of the body, and the unit of what is zero.
fn size(value: &KeyValue, scene: &Scene) -> f64 {
    let own = value.si().abs();
    match value.dimension {
        Dimension::LENGTH => own.max(LEAST_LENGTH * scene.body.mesh.diagonal()),
        _ if own > 0.0 => own,
        _ => value.factor,
    }
}

/// Which effects of the system can depend on a key.
fn varied(scene: &Scene, key: &ParameterKey, table: &Table) -> Vec<bool> {
    let own = &scene.spec.effects;
    let is_of_file = |e: usize| e < own.len();
    let of_effect = (key.root() == "effect").then(|| overrides::entry_of(table, key.path())).flatten();
    let varies = |e: usize| match key.root() {
        // Damping by stiffness takes that of another effect
        "effect" => is_of_file(e) && (of_effect == Some(e) || matches!(own[e], EffectSpec::StiffnessDamping(_))),
        "constraint" | "contact" | "rigid" | "start" | "skin" | "probe" | "stage" | "output" | "numerics" => {
            !is_of_file(e) || !scene.system.ties.is_empty()
        }
        _ => true,
    };
    (0..scene.system.effects.len()).map(varies).collect()
}

/// Derivatives of the first state.
fn start(starts: &[State], h: f64) -> [State; 2] {
    let flat = |place: usize| {
        let State { x, v, a, .. } = &starts[place];
        Ok::<_, std::convert::Infallible>([&x[..], v, a].concat())
    };
    let Ok(found) = derivatives(h, flat);
    found.map(|all| {
        let State { x, v, a, lambda, history, .. } = &starts[0];
        let (n, m) = (x.len(), v.len());
        debug_assert_eq!(all.len(), n + m + a.len());
        State {
            t: 0.0,
            x: all[..n].to_vec(),
            v: all[n..n + m].to_vec(),
            a: all[n + m..].to_vec(),
            lambda: vec![0.0; lambda.len()],
            memory: Vec::new(),
            dt: 0.0,
            history: vec![0.0; history.len()],
            inputs: Vec::new(),
        }
    })
}
