//! Histories of a case, turned into the data of a page of bounded size.

use super::model::{Arrows, Curves, Field, Model};
use super::modes::{History, Modes};
use super::pack::{Packed, pack};
use super::shape::Shape;

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

/// A field at all states.
pub struct Quantity {
    pub name: String,
    pub unit: String,
    pub components: usize,
    pub at_nodes: bool,
    /// \[states\]\[nodes or cells × components\]; one of many states: the same at all of them
    pub states: Vec<Vec<f32>>,
}

/// Texts and curves of a case.
#[derive(Clone, Default)]
pub struct About {
    pub title: String,
    pub facts: Vec<(String, String)>,
    pub notes: Vec<String>,
    pub curves: Curves,
    /// A field that is not there, and how to get it
    pub absent: Vec<(String, String)>,
    /// Why there is only one state; empty where there are more, or nobody would expect them
    pub still: String,
}

/// A shape with its histories.
#[derive(Default)]
pub struct Footage {
    pub shape: Shape,
    /// \[states\] \[s\]
    pub times: Vec<f64>,
    /// \[states\]\[points × 3\] displacement \[m\]; empty at rest
    pub motion: Vec<Vec<f32>>,
    pub quantities: Vec<Quantity>,
    pub arrows: Vec<Arrows>,
}

impl Footage {
    /// The data of a page: as modes to the tolerances; without the inside, or at larger tolerances, where that would be too large.
    pub fn packed(self, about: About) -> Packed {
        let mut model = Model {
            title: about.title,
            facts: about.facts,
            notes: about.notes,
            absent: about.absent,
            still: about.still,
            curves: about.curves,
            arrows: self.arrows.clone(),
            shape: self.shape.clone(),
            times: self.times.clone(),
            ..Model::default()
        };
        let mut wider = 1.0;
        loop {
            model.motion = self.displacement(wider);
            model.fields = self.quantities.iter().map(|q| field(q, self.times.len(), wider)).collect();
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

    fn displacement(&self, wider: f64) -> Modes {
        let history = History { components: 3, states: self.motion.clone() };
        let finite = history.states.iter().flatten().filter(|v| v.is_finite());
        let largest = finite.fold(0.0f64, |m, v| m.max(f64::from(v.abs())));
        let tolerance = (OF_EXTENT * self.shape.diagonal()).min(OF_DISPLACEMENT * largest);
        Modes::of(history, wider * tolerance.max(OF_ROUNDING * largest))
    }
}

fn field(q: &Quantity, states: usize, wider: f64) -> Field {
    let values = || q.states.iter().flatten().filter(|v| v.is_finite()).map(|v| f64::from(*v));
    let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let tolerance = if low <= high { (OF_RANGE * (high - low)).max(OF_SIZE * low.abs().max(high.abs())) } else { 0.0 };
    let mut modes = Modes::of(History { components: q.components, states: q.states.clone() }, wider * tolerance);
    if let ([_], Some(repeats)) = (&q.states[..], states.checked_sub(1)) {
        modes.amplitudes.iter_mut().for_each(|a| a.extend(vec![a[0]; repeats]));
    }
    Field { name: q.name.clone(), unit: q.unit.clone(), at_nodes: q.at_nodes, modes }
}

/// The model without its inside.
pub fn hollow(model: &Model) -> Model {
    let (shape, points, cells) = model.shape.hollow();
    let nodes = &points[..shape.nodes.len()];
    let place = |p: u32| points.binary_search(&p).ok().map(|k| k as u32);
    let states =
        |a: &Arrows| a.states.iter().map(|s| s.iter().filter_map(|(p, v)| Some((place(*p)?, *v))).collect()).collect();
    let modes = |f: &Field| f.modes.of_points(if f.at_nodes { nodes } else { &cells });
    Model {
        motion: model.motion.of_points(&points),
        fields: model.fields.iter().map(|f| Field { modes: modes(f), ..f.clone() }).collect(),
        arrows: model.arrows.iter().map(|a| Arrows { states: states(a), ..a.clone() }).collect(),
        shape,
        ..model.clone()
    }
}
