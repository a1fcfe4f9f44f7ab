//! Recorded columns of a scene as functions of the coordinates of a reduced model.

use super::error::ReductionError;
use super::forces::{ReducedCable, effects_of_loads};
use super::polynomial::Quadratic;
use super::training::basis::{Basis, combine};
use crate::math::tensor::Vec3;
use crate::scene::{Features, Reading, Scene, Winding};
use crate::system::{Effect, PolynomialLoad};
use serde::{Deserialize, Serialize};

/// A recorded column and the rule by which it is evaluated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReducedQuantity {
    /// Name of the column, with its unit at the end
    pub name: String,
    pub reading: ReducedReading,
}

/// Rule by which a column follows from the coordinates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ReducedReading {
    /// Tension of the cable with this index \[N\]
    Tension(usize),
    /// Length of the cable with this index \[m\]
    Length(usize),
    /// Volume \[m³\] of the cavity whose pressure is the load with this index: V₀ minus the potential
    Volume { load: usize, rest: f64 },
    /// Intensity of the load with this index
    Intensity(usize),
    /// A polynomial
    Value(Quadratic),
    /// Angle \[deg\] between a direction, given by three polynomials, and `rest`
    Turned { direction: Quadratic, rest: [f64; 3], axis: Option<[f64; 3]> },
}

impl ReducedReading {
    /// Number of values that it keeps from one state to the next.
    pub fn memory(&self) -> usize {
        if matches!(self, Self::Turned { .. }) { Winding::MEMORY } else { 0 }
    }

    /// Whether the arrays have consistent sizes.
    pub fn is_sound(&self, coordinates: usize, cables: usize, loads: usize) -> bool {
        match self {
            Self::Tension(c) | Self::Length(c) => *c < cables,
            Self::Volume { load, .. } | Self::Intensity(load) => *load < loads,
            Self::Value(polynomial) => polynomial.is_sound(coordinates, 1),
            Self::Turned { direction, .. } => direction.is_sound(coordinates, 3),
        }
    }
}

/// Returns the winding that counts the turns of such an angle.
pub fn winding(rest: [f64; 3], axis: Option<[f64; 3]>) -> Winding {
    Winding { rest: Vec3::from(rest), axis: axis.map(Vec3::from) }
}

/// Returns the names of the columns that reduced models of a scene can provide.
pub fn names(scene: &Scene) -> Vec<String> {
    let read = scene.probes.iter().filter(|recorder| recorder.features().is_some()).flat_map(|r| r.columns());
    let cables = scene.cables.iter().flat_map(|c| ["tension_N", "length_m"].map(|what| format!("{}_{what}", c.name)));
    let cavities =
        scene.cavities.iter().flat_map(|c| ["pressure_Pa", "volume_m3"].map(|what| format!("{}_{what}", c.name)));
    read.chain(cables).chain(cavities).collect()
}

/// Returns all columns of a scene that can be evaluated from the displacement coordinates; `steps` are the magnitudes of these.
pub fn quantities(scene: &Scene, basis: &Basis, cables: &[ReducedCable], steps: &[f64]) -> Vec<ReducedQuantity> {
    let mut out = vec![];
    let mut add = |name: String, reading| out.push(ReducedQuantity { name, reading });
    for recorder in &scene.probes {
        let Some(Features { degree, readings }) = recorder.features() else { continue };
        let modes = &basis.modes[..basis.displacements];
        let values = |q: &[f64]| recorder.feature_values(&scene.body, &combine(modes, q));
        let all = Quadratic::identify(degree, steps, values);
        for (name, reading) in recorder.columns().into_iter().zip(readings) {
            let part = |first: usize, count: usize| outputs(&all, first, count);
            match reading {
                Reading::Value(k) => add(name, ReducedReading::Value(part(k, 1))),
                Reading::Turned(k, Winding { rest, axis }) => {
                    let (rest, axis) = (rest.into(), axis.map(Into::into));
                    add(name, ReducedReading::Turned { direction: part(k, 3), rest, axis });
                }
            }
        }
    }
    for (k, cable) in cables.iter().enumerate() {
        add(format!("{}_tension_N", cable.name), ReducedReading::Tension(k));
        add(format!("{}_length_m", cable.name), ReducedReading::Length(k));
    }
    for cavity in &scene.cavities {
        // Another load may have the same name
        let presses =
            |(effect, _): (&dyn Effect, &dyn PolynomialLoad)| std::ptr::eq(effect.blocks(), cavity.cavity.facets());
        let Some(load) = effects_of_loads(scene).position(presses) else { continue };
        let rest = cavity.volume(&scene.system.rest().x);
        add(format!("{}_pressure_Pa", cavity.name), ReducedReading::Intensity(load));
        add(format!("{}_volume_m3", cavity.name), ReducedReading::Volume { load, rest });
    }
    out
}

/// Returns some of the outputs of polynomials.
fn outputs(of: &Quadratic, first: usize, count: usize) -> Quadratic {
    let n = of.coordinates;
    let part = |values: &[f64], each: usize| match values {
        [] => vec![],
        values => values[first * each..(first + count) * each].to_vec(),
    };
    Quadratic {
        coordinates: n,
        constant: part(&of.constant, 1),
        linear: part(&of.linear, n),
        quadratic: part(&of.quadratic, n * n),
    }
}

/// Returns the quantities with these names; the error for an unknown name lists the available ones.
pub fn choose(all: Vec<ReducedQuantity>, names: &[String]) -> Result<Vec<ReducedQuantity>, ReductionError> {
    let find = |name: &String| {
        all.iter().find(|q| q.name == *name).cloned().ok_or_else(|| ReductionError::Quantity {
            name: name.clone(),
            known: all.iter().map(|q| q.name.as_str()).collect::<Vec<_>>().join(", "),
        })
    };
    names.iter().map(find).collect()
}
