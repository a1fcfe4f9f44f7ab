//! Scenes at several values θ + kh of one of their keys, with the same unknowns and equations: what they compute at one state gives the derivative by
//! the key, whatever it is ([`crate::math::difference`]).
//!
//! The scenes are built from the text of the scene, on the mesh of the scene where the key is not one of `[mesh]`. Kept of each are the
//! effects and constraints that the key can change, and the recorders. They are built for a step when a state asks for it, which takes the one that leaves
//! the least error there: a guide that moves into another cell, a contact that opens, a Poisson's ratio next to ½ allow small ones only.

use super::error::SensitivityError;
use super::parameter_key::{KeyValue, ParameterKey};
use crate::math::difference::{PLACES, STEPS, by_best_step, derivatives, disagreement};
use crate::math::units::Dimension;
use crate::scene::body::Body;
use crate::scene::body::deform::is_made_here;
use crate::scene::build::Scene;
use crate::scene::error::SceneError;
use crate::scene::read::from_text;
use crate::scene::record::recorder::{Moment, Recorder};
use crate::scene::spec::{EffectSpec, SceneSpec};
use crate::scene::text::overrides;
use crate::system::{State, System, SystemDifference, SystemError, Variants};
use std::convert::Infallible;
use std::sync::{Arc, OnceLock};
use toml::Table;

/// Least size of a length whose derivative is taken, as a share of the body.
const LEAST_LENGTH: f64 = 0.1;

/// Which part of a scene a difference follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum Followed {
    /// All that depends on the key
    All,
    /// The parts that the derivatives of laws leave out: contacts and rigid bodies, whose stiffness is that of a law unless it is given
    FollowingLaws,
}

/// The scenes at other values of a key.
pub(in crate::scene) struct SceneDifference<'a> {
    family: Arc<Family<'a>>,
    /// Derivatives of the first state
    pub start: [State; 2],
}

/// The recorders of a scene, and their body.
struct Recorders {
    body: Arc<Body>,
    all: Vec<Box<dyn Recorder>>,
}

impl<'a> SceneDifference<'a> {
    /// The scenes at other values of a key of a scene.
    ///
    /// # Errors
    ///
    /// Where the scene has no number of this key, or none by which its equations have a derivative.
    pub fn new(scene: &'a Scene, key: &ParameterKey, followed: Followed) -> Result<Self, SensitivityError> {
        let family = Arc::new(Family::new(scene, key, followed)?);
        let start = family.start();
        Ok(Self { family, start })
    }

    /// The system at other values of the key.
    pub fn system(&self) -> SystemDifference<'a> {
        SystemDifference::new(&self.family.scene.system, self.family.clone())
    }

    /// Size of the value of the key \[SI\].
    pub fn size(&self) -> f64 {
        self.family.size
    }

    /// Derivatives by the key of the columns that have one, at a fixed moment: those of recorders that depend on it.
    pub fn columns(&self, now: &Moment) -> [Vec<f64>; 2] {
        let size = self.family.size;
        let values = columns(&self.family.first().recorders[0], now);
        // The effect of a change of the key by its size, over the value and that change
        let error = |[a, b]: &[Vec<f64>; 2]| {
            let of = |(c, value): (usize, &f64)| disagreement(&[a[c] * size, *value], &[b[c] * size, *value]);
            values.iter().enumerate().filter(|(_, value)| !value.is_nan()).map(of).fold(0.0, f64::max)
        };
        self.family.by_best_step(|Built { recorders, .. }, place| columns(&recorders[place], now), error)
    }
}

/// The columns with a derivative, as these recorders compute them at a moment of the scene.
fn columns(of: &Recorders, now: &Moment) -> Vec<f64> {
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
    values
}

/// Scenes at the places of [`PLACES`].
struct Built {
    /// The step of the key \[SI\]
    h: f64,
    systems: Vec<System>,
    recorders: Vec<Recorders>,
    starts: Vec<State>,
}

/// A scene as a function of one key.
struct Family<'a> {
    scene: &'a Scene,
    key: ParameterKey,
    table: Table,
    value: KeyValue,
    /// Size of the value by which steps are chosen \[SI\]
    size: f64,
    /// Whether each effect of the system can depend on the key
    vary: Vec<bool>,
    /// For each of the [`STEPS`], when it was asked for; none where there is no such scene
    built: [OnceLock<Option<Built>>; STEPS.len()],
}

impl Variants for Family<'_> {
    fn size(&self) -> f64 {
        self.size
    }

    fn systems(&self, step: usize) -> Option<(f64, &[System])> {
        self.at_step(step).map(|built| (built.h, &built.systems[..]))
    }
}

impl<'a> Family<'a> {
    fn new(scene: &'a Scene, key: &ParameterKey, followed: Followed) -> Result<Self, SensitivityError> {
        let table: Table = scene.text.parse().map_err(|_| SensitivityError::NoText { key: key.clone() })?;
        let value = key.value(&table)?;
        if key.root() == "numerics" {
            return Err(SensitivityError::Setting { key: key.clone() });
        }
        let vary = match followed {
            Followed::All => varied(scene, key, &table),
            Followed::FollowingLaws => (0..scene.system.effects.len()).map(|e| e >= scene.spec.effects.len()).collect(),
        };
        let size = size(&value, scene);
        let built = std::array::from_fn(|_| OnceLock::new());
        let family = Self { scene, key: key.clone(), table, value, size, vary, built };
        family.check_mesh()?;
        family.build_first()?;
        Ok(family)
    }

    /// Refuses a number that the reader takes in whole steps only, or that moves the mesher.
    fn check_mesh(&self) -> Result<(), SensitivityError> {
        let (_, spec) = first_step(|step| self.spec(0.5 * 2f64.powi(STEPS[step])))?;
        let (key, scene) = (&self.key, self.scene);
        let deforms = key.path().starts_with("mesh.deform.");
        if key.makes_mesh() && !deforms && !is_made_here(&scene.file, &spec.mesh) {
            return Err(SensitivityError::Mesher { key: key.clone() });
        }
        Ok(())
    }

    /// Builds the scenes of the largest step for which there are some.
    fn build_first(&self) -> Result<(), SensitivityError> {
        let (step, built) = first_step(|step| self.build(step))?;
        self.built[..step].iter().for_each(|refused| _ = refused.set(None));
        self.built[step].get_or_init(|| Some(built));
        Ok(())
    }

    /// The scenes of the largest step.
    fn first(&self) -> &Built {
        self.built.iter().find_map(|built| built.get()?.as_ref()).expect("built at the start")
    }

    /// The scenes of a step, if there are some.
    fn at_step(&self, step: usize) -> Option<&Built> {
        self.built[step].get_or_init(|| self.build(step).ok()).as_ref()
    }

    /// The derivative by the key of some values of the scene at a place, and its companion.
    fn by_best_step(
        &self,
        values: impl Fn(&Built, usize) -> Vec<f64>,
        error: impl Fn(&[Vec<f64>; 2]) -> f64,
    ) -> [Vec<f64>; 2] {
        let derive = |step: usize| {
            let built = self.at_step(step)?;
            Some(derivatives(built.h, |place| Ok::<_, Infallible>(values(built, place))))
        };
        let Ok(found) = by_best_step(derive, error).expect("scenes for some step");
        found
    }

    /// Derivatives of the first state.
    fn start(&self) -> [State; 2] {
        let State { x, v, a, lambda, history, .. } = &self.first().starts[0];
        let ends = [x.len(), x.len() + v.len(), x.len() + v.len() + a.len()];
        let flat = |built: &Built, place: usize| {
            let State { x, v, a, .. } = &built.starts[place];
            [&x[..], v, a].concat()
        };
        let error = |[a, b]: &[Vec<f64>; 2]| {
            let parts = [0..ends[0], ends[0]..ends[1], ends[1]..ends[2]];
            parts.into_iter().map(|part| disagreement(&a[part.clone()], &b[part])).fold(0.0, f64::max)
        };
        self.by_best_step(flat, error).map(|all| State {
            t: 0.0,
            x: all[..ends[0]].to_vec(),
            v: all[ends[0]..ends[1]].to_vec(),
            a: all[ends[1]..].to_vec(),
            lambda: vec![0.0; lambda.len()],
            memory: Vec::new(),
            dt: 0.0,
            history: vec![0.0; history.len()],
            inputs: Vec::new(),
        })
    }

    /// The specification at a step of so many sizes of the value.
    fn spec(&self, steps: f64) -> Result<SceneSpec, SensitivityError> {
        let mut table = self.table.clone();
        if steps != 0.0 {
            let value = self.value.written(self.value.number + steps * self.size / self.value.factor);
            overrides::apply(&mut table, self.key.path(), value)?;
        }
        let text = toml::to_string(&table).expect("a table that was read can be written");
        let read = from_text(&self.scene.file, &text, &format!("with another {}", self.key));
        let read: SceneSpec =
            read.map_err(|source| SensitivityError::Discrete { key: self.key.clone(), source: Box::new(source) })?;
        Ok(SceneSpec { known_laws: self.scene.spec.known_laws.clone(), ..read })
    }

    /// Builds the scenes of a step.
    fn build(&self, step: usize) -> Result<Built, SensitivityError> {
        let h = self.size * 2f64.powi(STEPS[step]);
        let mut built = Built { h, systems: Vec::new(), recorders: Vec::new(), starts: Vec::new() };
        for place in PLACES {
            let scene = self.at(f64::from(place) * h)?;
            built.starts.push(scene.start());
            let (system, body, all) = scene.into_parts();
            built.recorders.push(Recorders { body, all });
            built.systems.push(system);
        }
        Ok(built)
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
        let spec = self.spec(step / self.size)?;
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
        let variant = scene.variant(spec, body, |e| self.vary.get(e).copied().unwrap_or(true));
        let found = variant.map_err(|source| match is_other_system(&source) {
            true => differs(source),
            false => SensitivityError::AtBound { key: self.key.clone(), source: Box::new(source) },
        })?;
        let times = |scene: &Scene| scene.spans.iter().map(|s| [s.start, s.end, s.dt]).collect::<Vec<_>>();
        if times(&found) != times(scene) {
            return Err(content("the stages have other times"));
        }
        if found.spans != scene.spans {
            return Err(content("the stages have other integrators"));
        }
        let names = |scene: &Scene| scene.signals.iter().map(|s| s.name.clone()).collect::<Vec<_>>();
        if found.columns() != scene.columns() || names(&found) != names(scene) {
            return Err(content("other columns are recorded"));
        }
        Ok(found)
    }
}

/// Whether a scene was built, but with other equations.
fn is_other_system(error: &SceneError) -> bool {
    matches!(error, SceneError::Part { source, .. } if source.is::<SystemError>())
}

/// The first of the [`STEPS`] at which something succeeds, with the outcome, or else why the largest fails.
fn first_step<T>(mut at: impl FnMut(usize) -> Result<T, SensitivityError>) -> Result<(usize, T), SensitivityError> {
    let largest = at(0);
    let smaller = |step| at(step).ok().map(|found| (step, found));
    largest.map(|found| (0, found)).or_else(|why| (1..STEPS.len()).find_map(smaller).ok_or(why))
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
    let of_effects = overrides::entries_of(table, key.path());
    let varies = |e: usize| match key.root() {
        // Damping by stiffness takes that of another effect
        "effect" => is_of_file(e) && (of_effects.contains(&e) || matches!(own[e], EffectSpec::StiffnessDamping(_))),
        "constraint" | "contact" | "rigid" | "start" | "skin" | "probe" | "stage" | "output" => {
            !is_of_file(e) || !scene.system.ties.is_empty()
        }
        _ => true,
    };
    (0..scene.system.effects.len()).map(varies).collect()
}
