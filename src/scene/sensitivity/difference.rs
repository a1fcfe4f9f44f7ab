//! Scenes at several values θ + kh of one of their keys, with the same unknowns and equations. Their values at one state give the derivative with respect to
//! the key, whatever the key is ([`crate::math::difference`]).
//!
//! The scenes are built from the text of the scene, on its mesh unless the key belongs to `[mesh]`. Of each scene only the recorders, and the effects and
//! constraints that the key can change, are kept. The scenes of a step size are built when a state needs them; each state uses the step size with the smallest
//! error there: a guide that moves into another cell, a contact that opens, or a Poisson's ratio close to ½ allow only small steps.

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

/// Smallest scale of a length whose derivative is computed, relative to the size of the body.
const LEAST_LENGTH: f64 = 0.1;

/// The parts of a scene that a difference includes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum Followed {
    /// Everything that depends on the key
    All,
    /// The parts that the derivatives of laws leave out: contacts and rigid bodies, whose stiffness comes from a law unless it is given
    FollowingLaws,
}

/// The scenes at other values of a key.
pub(in crate::scene) struct SceneDifference<'a> {
    family: Arc<Family<'a>>,
    /// Derivatives of the initial state
    pub start: [State; 2],
}

/// The recorders of a scene, with their body.
struct Recorders {
    body: Arc<Body>,
    all: Vec<Box<dyn Recorder>>,
}

impl<'a> SceneDifference<'a> {
    /// Builds the scenes at other values of a key of a scene.
    ///
    /// # Errors
    ///
    /// Where the scene has no number at this key, or its equations have no derivative with respect to it.
    pub fn new(scene: &'a Scene, key: &ParameterKey, followed: Followed) -> Result<Self, SensitivityError> {
        let family = Arc::new(Family::new(scene, key, followed)?);
        let start = family.start();
        Ok(Self { family, start })
    }

    /// The system at other values of the key.
    pub fn system(&self) -> SystemDifference<'a> {
        SystemDifference::new(&self.family.scene.system, self.family.clone())
    }

    /// Magnitude of the value of the key \[SI\].
    pub fn size(&self) -> f64 {
        self.family.size
    }

    /// Derivatives, with respect to the key at a fixed state, of the columns that have one: those of recorders that depend on the key.
    pub fn columns(&self, now: &Moment) -> [Vec<f64>; 2] {
        let size = self.family.size;
        let values = columns(&self.family.first().recorders[0], now);
        // The effect of a change of the key by its magnitude, compared with the value and that change
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
            // An angle is kept with its whole rotations, and must be computed again by the other recorder
            let mut own = own.to_vec();
            recorder.remember(&of.body, now.state, &mut own);
            values.extend(recorder.record(&Moment { body: &of.body, memory: &own, ..*now }));
        }
    }
    values
}

/// Scenes at the offsets [`PLACES`].
struct Built {
    /// Step size of the key \[SI\]
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
    /// Magnitude of the value by which step sizes are chosen \[SI\]
    size: f64,
    /// Whether each effect of the system can depend on the key
    vary: Vec<bool>,
    /// The scenes of each of the [`STEPS`], built on demand; `None` if they cannot be built
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

    /// Refuses a number that can only change in whole steps, and one that would change the mesh of the mesher.
    fn check_mesh(&self) -> Result<(), SensitivityError> {
        let (_, spec) = first_step(|step| self.spec(0.5 * 2f64.powi(STEPS[step])))?;
        let (key, scene) = (&self.key, self.scene);
        let deforms = key.path().starts_with("mesh.deform.");
        if key.makes_mesh() && !deforms && !is_made_here(&scene.file, &spec.mesh) {
            return Err(SensitivityError::Mesher { key: key.clone() });
        }
        Ok(())
    }

    /// Builds the scenes of the largest step size for which this succeeds.
    fn build_first(&self) -> Result<(), SensitivityError> {
        let (step, built) = first_step(|step| self.build(step))?;
        self.built[..step].iter().for_each(|refused| _ = refused.set(None));
        self.built[step].get_or_init(|| Some(built));
        Ok(())
    }

    /// The scenes of the largest step size.
    fn first(&self) -> &Built {
        self.built.iter().find_map(|built| built.get()?.as_ref()).expect("built at the start")
    }

    /// The scenes of a step size; `None` if they cannot be built.
    fn at_step(&self, step: usize) -> Option<&Built> {
        self.built[step].get_or_init(|| self.build(step).ok()).as_ref()
    }

    /// The derivative with respect to the key of values of the scenes at the offsets, and its companion.
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

    /// Derivatives of the initial state.
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

    /// The specification at an offset of `steps` times the magnitude of the value.
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

    /// Builds the scenes of a step size.
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

    /// The scene at θ + `step`, with the equations of the original scene.
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

/// Whether a scene could be built, but with different equations.
fn is_other_system(error: &SceneError) -> bool {
    matches!(error, SceneError::Part { source, .. } if source.is::<SystemError>())
}

/// The first of the [`STEPS`] at which `at` succeeds, with its result; otherwise the error at the largest step.
fn first_step<T>(mut at: impl FnMut(usize) -> Result<T, SensitivityError>) -> Result<(usize, T), SensitivityError> {
    let largest = at(0);
    let smaller = |step| at(step).ok().map(|found| (step, found));
    largest.map(|found| (0, found)).or_else(|why| (1..STEPS.len()).find_map(smaller).ok_or(why))
}

/// Magnitude of a value by which step sizes are chosen \[SI\]: its own; for a coordinate near zero a share of the size of the body, and for other zeros the
/// unit.
fn size(value: &KeyValue, scene: &Scene) -> f64 {
    let own = value.si().abs();
    match value.dimension {
        Dimension::LENGTH => own.max(LEAST_LENGTH * scene.body.mesh.diagonal()),
        _ if own > 0.0 => own,
        _ => value.factor,
    }
}

/// Whether each effect of the system can depend on a key.
fn varied(scene: &Scene, key: &ParameterKey, table: &Table) -> Vec<bool> {
    let own = &scene.spec.effects;
    let is_of_file = |e: usize| e < own.len();
    let of_effects = overrides::entries_of(table, key.path());
    let varies = |e: usize| match key.root() {
        // Stiffness-proportional damping uses the stiffness of another effect
        "effect" => is_of_file(e) && (of_effects.contains(&e) || matches!(own[e], EffectSpec::StiffnessDamping(_))),
        "constraint" | "contact" | "rigid" | "start" | "skin" | "probe" | "stage" | "output" => {
            !is_of_file(e) || !scene.system.ties.is_empty()
        }
        _ => true,
    };
    (0..scene.system.effects.len()).map(varies).collect()
}
