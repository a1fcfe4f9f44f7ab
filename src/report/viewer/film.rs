//! States of a run collected for a page, within bounded memory.

use super::footage::{About, FieldHistory, Footage};
use super::frame::Frame;
use super::limits::{STATES, VALUES};
use super::model::{Arrows, Field, Model};
use super::modes::Modes;
use super::of_scene;
use super::pack::{Packed, pack};
use super::shape::{Limits, Shape};
use crate::scene::Scene;
use crate::scene::output::FieldSpec;
use crate::system::State;
use std::sync::Arc;

/// Name of the contact forces, which do not include friction.
const FORCES: &str = "normal contact forces";

/// The states of a run, thinned out as they become many.
pub struct Film {
    shape: Shape,
    what: Vec<FieldSpec>,
    frames: Vec<Arc<Frame>>,
    /// Every `stride`-th state is kept
    stride: usize,
    seen: usize,
    /// The last state, if it is not kept
    last: Option<State>,
    /// Cell fields that are constant over the run
    of_run: Vec<FieldHistory>,
}

impl Film {
    /// Creates a film of a scene with the stretch and the fields `what`.
    pub fn new(scene: &Scene, what: &[FieldSpec], limits: &Limits) -> Self {
        let has = |f: &FieldSpec| what.contains(f);
        // Contact forces are drawn as arrows
        let others = [FieldSpec::Stress, FieldSpec::Velocity, FieldSpec::VonMises, FieldSpec::Pressure];
        let what = std::iter::once(FieldSpec::Stretch).chain(others.into_iter().filter(has)).collect();
        Self {
            shape: of_scene::shape(scene, limits),
            what,
            frames: vec![],
            stride: 1,
            seen: 0,
            last: None,
            of_run: vec![],
        }
    }

    /// Adds a field \[cells of the mesh\] that is the same in all states.
    pub fn add_of_cells(&mut self, name: &str, unit: &str, values: &[f64]) {
        let own = self.shape.cell_numbers.iter().map(|&c| values[c as usize] as f32).collect();
        let (name, unit) = (name.into(), unit.into());
        self.of_run.push(FieldHistory { name, unit, components: 1, at_nodes: false, states: vec![own] });
    }

    /// Adds the next state of the run.
    pub fn add(&mut self, scene: &Scene, state: &State) {
        let due = self.seen.is_multiple_of(self.stride);
        self.seen += 1;
        if !due {
            self.last = Some(state.clone());
            return;
        }
        self.last = None;
        self.frames.push(Arc::new(self.frame(scene, state)));
        let size = self.frames[0].size();
        if self.frames.len() > STATES.min((VALUES / size.max(1)).max(2)) {
            let mut number = 0..;
            self.frames.retain(|_| number.next().is_some_and(|k: usize| k.is_multiple_of(2)));
            self.stride *= 2;
            // The state that was added may just have been dropped
            self.last = (!(self.seen - 1).is_multiple_of(self.stride)).then(|| state.clone());
        }
    }

    /// Returns the kept states, with their numbers in the run.
    pub fn kept(&self) -> impl Iterator<Item = (usize, &Arc<Frame>)> {
        self.frames.iter().enumerate().map(|(k, frame)| (k * self.stride, frame))
    }

    /// Returns the number of states so far.
    pub fn count(&self) -> usize {
        self.seen
    }

    /// Returns the stride: every `stride`-th state is kept.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// Returns a state in the form shown by the page.
    pub fn frame(&self, scene: &Scene, state: &State) -> Frame {
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

    /// A note on the numbers of states of the run and of kept ones.
    fn note(&self) -> Option<String> {
        let kept = self.frames.len();
        (kept < self.seen).then(|| format!("{kept} of the {} states of the run are shown.", self.seen))
    }

    /// Returns the data of a page without any states yet; these follow through [`Frame::bytes`].
    pub fn opening(&self, scene: &Scene, about: About) -> Packed {
        let none = |components| Modes { components, ..Modes::default() };
        let field =
            |q: FieldHistory| Field { name: q.name, unit: q.unit, at_nodes: q.at_nodes, modes: none(q.components) };
        let forces = Arrows { name: FORCES.into(), unit: "N".into(), states: vec![] };
        pack(&Model {
            title: about.title,
            facts: about.facts,
            notes: about.notes,
            absent: absent(scene, &self.what),
            curves: about.curves,
            shape: self.shape.clone(),
            motion: none(3),
            fields: self.what.iter().map(|f| field(quantity(f))).collect(),
            arrows: if scene.contacts.is_empty() { vec![] } else { vec![forces] },
            ..Model::default()
        })
    }

    /// Returns the data of a page.
    pub fn finish(mut self, scene: &Scene, mut about: About) -> Packed {
        if let Some(last) = self.last.take() {
            self.frames.push(Arc::new(self.frame(scene, &last)));
        }
        about.notes.extend(self.note());
        about.absent.extend(absent(scene, &self.what));
        let mut footage = Footage { times: self.frames.iter().map(|f| f.t).collect(), ..Footage::default() };
        let mut quantities: Vec<FieldHistory> = self.what.iter().map(quantity).collect();
        let mut contact = vec![];
        for frame in self.frames.into_iter().map(Arc::unwrap_or_clone) {
            footage.motion.push(frame.motion);
            contact.push(frame.contact);
            quantities.iter_mut().zip(frame.fields).for_each(|(q, values)| q.states.push(values));
        }
        if contact.iter().any(|c| !c.is_empty()) {
            footage.arrows = vec![Arrows { name: FORCES.into(), unit: "N".into(), states: contact }];
        }
        quantities.extend(self.of_run);
        Footage { shape: self.shape, quantities, ..footage }.packed(about)
    }
}

/// Returns the data of a page that shows a scene at rest, before anything is run.
pub fn at_rest(scene: &Scene, limits: &Limits, about: About) -> Packed {
    Footage { shape: of_scene::shape(scene, limits), times: vec![0.0], ..Footage::default() }.packed(about)
}

/// Returns the components xx, yy, zz, xy, yz, xz of tensors that are given row by row.
pub fn symmetric(values: &[f64]) -> Vec<f64> {
    values.chunks_exact(9).flat_map(|s| [s[0], s[4], s[8], s[1], s[5], s[2]]).collect()
}

/// An empty history of a field.
fn quantity(field: &FieldSpec) -> FieldHistory {
    let (name, unit, components) = match field {
        FieldSpec::Displacement => ("displacement", "m", 3),
        FieldSpec::Velocity => ("velocity", "m/s", 3),
        FieldSpec::Stretch => ("stretch", "", 1),
        FieldSpec::Stress => ("stress", "Pa", 6),
        FieldSpec::VonMises => ("von Mises stress", "Pa", 1),
        FieldSpec::Pressure => ("pressure", "Pa", 1),
        FieldSpec::ContactForce => ("contact force", "N", 3),
    };
    FieldHistory { name: name.into(), unit: unit.into(), components, at_nodes: true, states: vec![] }
}

/// Fields that the scene does not request, each with the key that records it.
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
