//! Histories of a case, converted into the data of a page of bounded size.

use super::limits::BYTES;
use super::model::{Arrows, Curves, Field, Model};
use super::modes::{History, Modes};
use super::pack::{Packed, pack};
use super::shape::Shape;

/// Tolerance of displacements relative to the largest extent: a tenth of a pixel in a picture of 2000 pixels.
const OF_EXTENT: f64 = 5e-5;
/// Tolerance of displacements relative to the largest displacement, for stiff bodies.
const OF_DISPLACEMENT: f64 = 1e-3;
/// Tolerance of fields relative to their range: half a grade of a colour map. For a tensor it applies to its von Mises value and its pressure.
const OF_RANGE: f64 = 2e-3;
/// Smallest tolerance relative to the largest displacement: a few units of the rounding of the first mode to 16 bits.
const OF_ROUNDING: f64 = 5e-5;
/// Smallest tolerance of nearly constant fields, relative to their largest value.
const OF_SIZE: f64 = 1e-6;

/// A field in all states.
pub struct FieldHistory {
    pub name: String,
    pub unit: String,
    pub components: usize,
    pub at_nodes: bool,
    /// Values \[states\]\[nodes or cells × components\]; a single entry applies to all states
    pub states: Vec<Vec<f32>>,
}

/// Texts and curves of a case.
#[derive(Clone, Default)]
pub struct About {
    pub title: String,
    pub facts: Vec<(String, String)>,
    pub notes: Vec<String>,
    pub curves: Curves,
    /// Fields that are missing, and how to get them
    pub absent: Vec<(String, String)>,
    /// Reason why there is only one state; empty if there are more, or if nobody would expect them
    pub still: String,
}

/// A shape with its histories.
#[derive(Default)]
pub struct Footage {
    pub shape: Shape,
    /// Times of the states \[s\]
    pub times: Vec<f64>,
    /// Displacements \[states\]\[points × 3\] \[m\]; empty at rest
    pub motion: Vec<Vec<f32>>,
    pub quantities: Vec<FieldHistory>,
    pub arrows: Vec<Arrows>,
}

impl Footage {
    /// Returns the data of a page: as modes within the tolerances; without the inside, or with larger tolerances, if that would be too large.
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

/// Smallest and largest of the finite numbers; zero if there are none.
fn ends(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let all = values.filter(|v| v.is_finite());
    let [low, high] = all.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)]);
    if low <= high { [low, high] } else { [0.0; 2] }
}

/// Largest allowed deviation of the stored values of a field.
fn tolerance(q: &FieldHistory) -> f64 {
    let range = |[low, high]: [f64; 2]| high - low;
    let all = ends(q.states.iter().flatten().map(|v| f64::from(*v)));
    let of_tensors = |scalar: fn([f64; 6]) -> f64| {
        let tensors = q.states.iter().flat_map(|state| state.chunks_exact(6));
        range(ends(tensors.map(|s| scalar(std::array::from_fn(|i| f64::from(s[i]))))))
    };
    // A tensor with an error e has an error of at most √3 e in the von Mises value, and of e/√3 in the pressure
    let range = match q.components {
        6 => (of_tensors(von_mises) / 3f64.sqrt()).min(of_tensors(|s| (s[0] + s[1] + s[2]) / 3.0) * 3f64.sqrt()),
        _ => range(all),
    };
    (OF_RANGE * range).max(OF_SIZE * all[0].abs().max(all[1].abs()))
}

/// The von Mises value of xx, yy, zz, xy, yz, xz.
fn von_mises(s: [f64; 6]) -> f64 {
    let normal = (s[0] - s[1]).powi(2) + (s[1] - s[2]).powi(2) + (s[2] - s[0]).powi(2);
    (0.5 * normal + 3.0 * (s[3].powi(2) + s[4].powi(2) + s[5].powi(2))).sqrt()
}

fn field(q: &FieldHistory, states: usize, wider: f64) -> Field {
    let mut modes = Modes::of(History { components: q.components, states: q.states.clone() }, wider * tolerance(q));
    if let ([_], Some(repeats)) = (&q.states[..], states.checked_sub(1)) {
        modes.amplitudes.iter_mut().for_each(|a| a.extend(vec![a[0]; repeats]));
    }
    Field { name: q.name.clone(), unit: q.unit.clone(), at_nodes: q.at_nodes, modes }
}

/// Returns the model without its inside.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix;
    use crate::math::statistics::larger;

    /// Whatever the pressure, the von Mises stress and the pressure are reproduced within the tolerance relative to their own ranges.
    #[test]
    fn the_scalars_of_a_stress_keep_the_tolerance_of_their_own_ranges() {
        let mut random = SplitMix(3);
        let mut noise = || (0..200).map(|_| random.unit() - 0.5).collect::<Vec<f64>>();
        let (of_pressure, of_deviator, of_shear) = (noise(), noise(), noise());
        for (pressure, deviator) in [(1e6, 1e3), (1e3, 1e3), (1e3, 1e6)] {
            let state = |t: f64| {
                let point = |p: usize| {
                    let (mean, s) = (-pressure * t * (2.0 + of_pressure[p]), deviator * t * t * of_deviator[p]);
                    [mean + s, mean - s, mean, deviator * t.sin() * of_shear[p], 0.0, s].map(|v| v as f32)
                };
                (0..200).flat_map(point).collect::<Vec<f32>>()
            };
            let states: Vec<Vec<f32>> = (0..11).map(|k| state(f64::from(k) / 10.0)).collect();
            let q = FieldHistory {
                name: "stress".into(),
                unit: "Pa".into(),
                components: 6,
                at_nodes: true,
                states: states.clone(),
            };
            let modes = field(&q, 11, 1.0).modes;
            for scalar in [von_mises, |s: [f64; 6]| (s[0] + s[1] + s[2]) / 3.0] {
                let of = |values: Vec<f64>| -> Vec<f64> {
                    values.chunks_exact(6).map(|s| scalar(std::array::from_fn(|i| s[i]))).collect()
                };
                let exact: Vec<Vec<f64>> =
                    states.iter().map(|s| of(s.iter().map(|v| f64::from(*v)).collect())).collect();
                let [low, high] = ends(exact.iter().flatten().copied());
                let off = exact.iter().enumerate().flat_map(|(k, exact)| {
                    of(modes.at(k)).into_iter().zip(exact.clone()).map(|(a, b)| (a - b).abs()).collect::<Vec<_>>()
                });
                let off = off.fold(0.0, larger);
                // The numbers are below three times the larger part. Their residual is kept in single precision and is rounded once per mode
                let size = 3.0 * larger(pressure, deviator);
                let stated = larger(OF_RANGE * (high - low), 3f64.sqrt() * OF_SIZE * size);
                let rounding = 18f64.sqrt() * 6e-8 * size * modes.shapes.len() as f64;
                assert!(off <= stated + rounding, "{off} of {low} to {high}");
            }
        }
    }
}
