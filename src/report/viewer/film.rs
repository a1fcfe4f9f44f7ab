//! States of a run gathered for a page, within bounded memory.

use super::model::{Arrows, Curves, Field, Model};
use super::modes::{History, Modes};
use super::of_scene;
use super::pack::{Packed, pack};
use super::shape::{Limits, Shape};
use crate::scene::Scene;
use crate::scene::output::FieldSpec;
use crate::system::State;

/// Most states of a page.
const STATES: usize = 240;
/// Most numbers that are kept during a run: 160 MB.
const NUMBERS: usize = 40 << 20;
/// Most bytes of a packed case; with base64 and the program of the page it is below 5 MB.
const BYTES: usize = 3_500_000;
/// Tolerance of displacements, as a share of the largest extent: a tenth of a pixel of a picture of 2000 pixels.
const OF_EXTENT: f64 = 5e-5;
/// The same as a share of the largest displacement, for stiff bodies.
const OF_DISPLACEMENT: f64 = 1e-3;
/// Tolerance of fields, as a share of their range: half a grade of a colour map.
const OF_RANGE: f64 = 2e-3;
/// Smallest tolerance, as a share of the largest displacement: a few units of the rounding of the first mode to 16 bits.
const OF_ROUNDING: f64 = 5e-5;
/// The same of fields that are nearly constant, as a share of their largest value.
const OF_SIZE: f64 = 1e-6;

/// One state.
struct Frame {
    t: f64,
    /// \[points × 3\] displacement \[m\]
    motion: Vec<f32>,
    /// \[fields\]\[nodes × components\]
    fields: Vec<Vec<f32>>,
    contact: Vec<(u32, [f32; 3])>,
}

/// The states of a run, thinned out as they become many.
pub struct Film {
    shape: Shape,
    what: Vec<FieldSpec>,
    frames: Vec<Frame>,
    /// Every so many states are kept
    stride: usize,
    seen: usize,
    /// The last state, if it is not kept
    last: Option<State>,
}

impl Film {
    /// A film of a scene with the stretch and the fields `what`.
    pub fn new(scene: &Scene, what: &[FieldSpec], limits: &Limits) -> Self {
        let has = |f: &FieldSpec| what.contains(f);
        // Forces of contact are arrows; the page computes von Mises' stress and pressure from the stress
        let of_stress =
            [FieldSpec::VonMises, FieldSpec::Pressure].into_iter().filter(|f| has(f) && !has(&FieldSpec::Stress));
        let others = [FieldSpec::Stress, FieldSpec::Velocity].into_iter().filter(has);
        let what = std::iter::once(FieldSpec::Stretch).chain(others).chain(of_stress).collect();
        Self { shape: of_scene::shape(scene, limits), what, frames: vec![], stride: 1, seen: 0, last: None }
    }

    /// Adds a state, the next one of the run.
    pub fn add(&mut self, scene: &Scene, state: &State) {
        let due = self.seen.is_multiple_of(self.stride);
        self.seen += 1;
        if !due {
            self.last = Some(state.clone());
            return;
        }
        self.last = None;
        self.frames.push(self.frame(scene, state));
        let size: usize = self.frames[0].motion.len() + self.frames[0].fields.iter().map(Vec::len).sum::<usize>();
        if self.frames.len() > STATES.min((NUMBERS / size.max(1)).max(2)) {
            let mut number = 0..;
            self.frames.retain(|_| number.next().is_some_and(|k: usize| k.is_multiple_of(2)));
            self.stride *= 2;
            // The state that was added may be one that has gone
            self.last = (!(self.seen - 1).is_multiple_of(self.stride)).then(|| state.clone());
        }
    }

    fn frame(&self, scene: &Scene, state: &State) -> Frame {
        let at = |values: &[f64], components: usize| -> Vec<f32> {
            let own = |n: u32| (0..components).map(move |i| n as usize * components + i);
            self.shape.nodes.iter().flat_map(|&n| own(n)).map(|k| values[k] as f32).collect()
        };
        let fields = scene.fields(state, &self.what).into_iter().filter(|f| f.at_nodes);
        let fields = fields.map(|f| match f.components {
            9 => at(&symmetric(&f.values), 6),
            n => at(&f.values, n),
        });
        let mut motion = at(&state.x, 3);
        motion.extend(
            of_scene::parts(scene, &state.x)
                .iter()
                .zip(self.rest_of_parts())
                .flat_map(|(p, rest)| (0..3).map(|i| (p[i] - rest[i]) as f32).collect::<Vec<_>>()),
        );
        Frame {
            t: state.t,
            motion,
            fields: fields.collect(),
            contact: of_scene::contact_forces(scene, &self.shape, &state.x),
        }
    }

    fn rest_of_parts(&self) -> &[[f64; 3]] {
        &self.shape.points[self.shape.nodes.len()..]
    }

    /// Number of states of the run, and of those that are kept.
    fn note(&self) -> Option<String> {
        let kept = self.frames.len();
        (kept < self.seen).then(|| format!("{kept} of the {} states of the run are shown.", self.seen))
    }

    /// The page data of the film: as modes to the tolerances, without the inside or at larger ones where it would be too large.
    pub fn finish(mut self, scene: &Scene, about: About) -> Packed {
        if let Some(last) = self.last.take() {
            self.frames.push(self.frame(scene, &last));
        }
        let mut model = Model {
            title: about.title,
            facts: about.facts,
            notes: about.notes.into_iter().chain(self.note()).collect(),
            times: self.frames.iter().map(|f| f.t).collect(),
            curves: about.curves,
            absent: absent(scene, &self.what),
            ..Model::default()
        };
        let contact = self.frames.iter().map(|f| f.contact.clone()).collect::<Vec<_>>();
        if contact.iter().any(|c| !c.is_empty()) {
            model.arrows = vec![Arrows { name: "contact forces".into(), unit: "N".into(), states: contact }];
        }
        let names = self.what.iter().map(name_of);
        let mut wider = 1.0;
        loop {
            let motion = self.frames.iter().map(|f| f.motion.clone()).collect();
            model.motion = self.displacement(History { components: 3, states: motion }, wider);
            let field = |(k, (name, unit, components)): (usize, (&str, &str, usize))| {
                let states = self.frames.iter().map(|f| f.fields[k].clone()).collect();
                let modes = quantity(History { components, states }, wider);
                Field { name: name.into(), unit: unit.into(), at_nodes: true, modes }
            };
            model.fields = names.clone().enumerate().map(field).collect();
            model.shape = self.shape.clone();
            let packed = pack(&model);
            if packed.data.len() <= BYTES || wider > 100.0 {
                return packed;
            }
            let packed = pack(&hollow(&model));
            if packed.data.len() <= BYTES {
                return packed;
            }
            wider *= 4.0;
        }
    }

    fn displacement(&self, history: History, wider: f64) -> Modes {
        let largest = size(&history);
        let tolerance = (OF_EXTENT * self.shape.diagonal()).min(OF_DISPLACEMENT * largest);
        Modes::of(history, wider * tolerance.max(OF_ROUNDING * largest))
    }
}

/// Texts and curves of a film.
#[derive(Default)]
pub struct About {
    pub title: String,
    pub facts: Vec<(String, String)>,
    pub notes: Vec<String>,
    pub curves: Curves,
}

/// The modes of a quantity that a colour shows.
pub fn quantity(history: History, wider: f64) -> Modes {
    let values = || history.states.iter().flatten().filter(|v| v.is_finite()).map(|v| f64::from(*v));
    let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let tolerance = if high > low { OF_RANGE * (high - low) } else { 0.0 };
    let floor = OF_SIZE * low.abs().max(high.abs());
    Modes::of(history, wider * if floor.is_finite() { tolerance.max(floor) } else { tolerance })
}

/// The largest value.
fn size(history: &History) -> f64 {
    history.states.iter().flatten().filter(|v| v.is_finite()).fold(0.0f64, |m, v| m.max(f64::from(v.abs())))
}

/// The model without its inside.
fn hollow(model: &Model) -> Model {
    let (shape, kept) = model.shape.hollow();
    let nodes = &kept[..shape.nodes.len()];
    let place = |p: u32| kept.binary_search(&p).ok().map(|k| k as u32);
    let states =
        |a: &Arrows| a.states.iter().map(|s| s.iter().filter_map(|(p, v)| Some((place(*p)?, *v))).collect()).collect();
    Model {
        motion: model.motion.of_points(&kept),
        fields: model.fields.iter().map(|f| Field { modes: f.modes.of_points(nodes), ..f.clone() }).collect(),
        arrows: model.arrows.iter().map(|a| Arrows { states: states(a), ..a.clone() }).collect(),
        shape,
        ..model.clone()
    }
}

/// xx, yy, zz, xy, yz, xz of tensors row by row.
pub fn symmetric(values: &[f64]) -> Vec<f64> {
    values.chunks_exact(9).flat_map(|s| [s[0], s[4], s[8], s[1], s[5], s[2]]).collect()
}

/// Name, unit and number of components of a field.
fn name_of(field: &FieldSpec) -> (&'static str, &'static str, usize) {
    match field {
        FieldSpec::Displacement => ("displacement", "m", 3),
        FieldSpec::Velocity => ("velocity", "m/s", 3),
        FieldSpec::Stretch => ("stretch", "", 1),
        FieldSpec::Stress => ("stress", "Pa", 6),
        FieldSpec::VonMises => ("von Mises stress", "Pa", 1),
        FieldSpec::Pressure => ("pressure", "Pa", 1),
        FieldSpec::ContactForce => ("contact force", "N", 3),
    }
}

/// Fields that the scene does not ask for, each with the key that records it.
fn absent(scene: &Scene, what: &[FieldSpec]) -> Vec<(String, String)> {
    let key = |name: &str| format!("[output] fields = {{ what = [\"{name}\"] }}");
    let stress = what.contains(&FieldSpec::Stress);
    let mut out = vec![];
    if !stress {
        out.push(("stress".into(), key("stress")));
    }
    if !stress && !what.contains(&FieldSpec::VonMises) {
        out.push(("von Mises stress".into(), key("von_mises")));
    }
    if !stress && !what.contains(&FieldSpec::Pressure) {
        out.push(("pressure".into(), key("pressure")));
    }
    let moves = scene.spans.iter().any(|s| s.integrator.name() != "static");
    if moves && !what.contains(&FieldSpec::Velocity) {
        out.push(("velocity".into(), key("velocity")));
    }
    out
}
