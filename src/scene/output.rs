//! Output of a run in addition to its record, and its schedule: fields for ParaView, rows of the time series.
//!
//! Stress fields are those of the elastic effects, σ = P Fᵀ/J. A cell has the mean over its quadrature points, a node the
//! mean over the cells there, both weighted with the reference volume; von Mises' stress and the pressure −tr σ/3 are those of
//! the mean. Overstress of `viscoelastic` and viscous stress are not in them.

use super::build::{Body, Scene};
use super::builder::Builder;
use super::error::SceneError;
use super::quantity::Time;
use crate::effect::Stressed;
use crate::math::tensor::Mat3;
use crate::system::State;
use serde::Deserialize;
use std::sync::Arc;

/// Rates and fields of the files of a run.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutputSpec {
    pub fields: Option<FieldsSpec>,
    pub series: Option<ScheduleSpec>,
}

/// Which fields, and when; at every point of the time grid if no time is given.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FieldsSpec {
    pub what: Vec<FieldSpec>,
    pub every: Option<Time>,
    #[serde(default)]
    pub times: Vec<Time>,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum FieldSpec {
    Displacement,
    Velocity,
    /// Largest principal stretch
    Stretch,
    /// Cauchy's stress
    Stress,
    VonMises,
    Pressure,
    /// Of all contacts, normal to the obstacles, at the nodes
    ContactForce,
}

/// Every so often, and at some times.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScheduleSpec {
    pub every: Option<Time>,
    #[serde(default)]
    pub times: Vec<Time>,
}

/// Values at the nodes or in the cells.
pub struct Field {
    pub name: &'static str,
    pub components: usize,
    pub values: Vec<f64>,
    pub at_nodes: bool,
}

impl FieldsSpec {
    pub fn schedule(&self) -> ScheduleSpec {
        ScheduleSpec { every: self.every, times: self.times.clone() }
    }
}

impl ScheduleSpec {
    /// Whether output is due at `t`, after the point of the grid at `past`. The first state always is.
    pub fn due(&self, past: Option<f64>, t: f64) -> bool {
        let Some(past) = past else { return true };
        let passed = |at: f64, t: f64| at <= t + 1e-9 * t.abs();
        let count = |t: f64| self.every.map_or(0.0, |every| (t / every.0 + 1e-9).floor());
        let always = self.every.is_none() && self.times.is_empty();
        always || count(t) > count(past) || self.times.iter().any(|at| passed(at.0, t) && !passed(at.0, past))
    }
}

pub(super) fn check_output(builder: &Builder, spec: &OutputSpec, end: f64) -> Result<(), SceneError> {
    let fields = spec.fields.as_ref().map(|f| ("output.fields", f.schedule()));
    for (place, ScheduleSpec { every, times }) in
        fields.into_iter().chain(spec.series.clone().map(|s| ("output.series", s)))
    {
        if every.is_some_and(|every| every.0 <= 0.0) {
            return Err(builder.content(place, "`every` is not positive", "give the time from one to the next"));
        }
        if let Some(t) = times.iter().find(|t| !(0.0..=end * (1.0 + 1e-9)).contains(&t.0)) {
            let remedy = format!("take times from 0 to {end} s, the end of the last stage");
            return Err(builder.content(place, format!("the run has no t = {} s", t.0), remedy));
        }
    }
    if spec.fields.as_ref().is_some_and(|f| f.what.is_empty()) {
        return Err(builder.content("output.fields", "`what` is empty", "list fields such as \"displacement\""));
    }
    Ok(())
}

/// The fields of a state.
pub(super) fn fields(scene: &Scene, state: &State, what: &[FieldSpec]) -> Vec<Field> {
    let stress = what.iter().any(|f| matches!(f, FieldSpec::Stress | FieldSpec::VonMises | FieldSpec::Pressure));
    let tensors = || {
        let cells = stresses(&scene.body, &scene.stressed, &state.x);
        [(nodal(&scene.body, &cells), true), (cells, false)]
    };
    let stress = stress.then(tensors);
    let displacements = 3 * scene.body.mesh.points.len();
    let mut out = Vec::new();
    for field in what {
        let node = |name, components, values| Field { name, components, values, at_nodes: true };
        let (name, components, of): (_, _, fn(&Mat3) -> Vec<f64>) = match field {
            FieldSpec::Displacement => {
                out.push(node("displacement_m", 3, state.x[..displacements].to_vec()));
                continue;
            }
            FieldSpec::Velocity => {
                out.push(node("velocity_m_s", 3, state.v[..displacements].to_vec()));
                continue;
            }
            FieldSpec::ContactForce => {
                let mut forces = vec![0.0; displacements];
                scene.contacts.iter().for_each(|c| c.nodal(&state.x, None, &mut forces));
                out.push(node("contact_force_N", 3, forces));
                continue;
            }
            FieldSpec::Stretch => {
                out.push(node("stretch", 1, scene.nodal_stretch(&state.x)));
                continue;
            }
            FieldSpec::Stress => ("stress_Pa", 9, |s| s.transpose().as_slice().to_vec()),
            FieldSpec::VonMises => ("von_mises_Pa", 1, |s| vec![von_mises(s)]),
            FieldSpec::Pressure => ("pressure_Pa", 1, |s| vec![-s.trace() / 3.0]),
        };
        for (tensors, at_nodes) in stress.iter().flatten() {
            let values = tensors.iter().flat_map(of).collect();
            out.push(Field { name, components, values, at_nodes: *at_nodes });
        }
    }
    out
}

/// √(3/2 s:s), s the deviator.
fn von_mises(sigma: &Mat3) -> f64 {
    (1.5 * (sigma - Mat3::identity() * (sigma.trace() / 3.0)).norm_squared()).sqrt()
}

/// \[cells\] mean Cauchy stress \[Pa\]; laws that share a cell add up.
fn stresses(body: &Body, effects: &[Arc<dyn Stressed>], x: &[f64]) -> Vec<Mat3> {
    let mut out = vec![Mat3::zeros(); body.mesh.cell_count()];
    for effect in effects {
        let points = effect.points();
        for (b, &cell) in points.cells.iter().enumerate() {
            // Every law was defined at an accepted state.
            let Ok(stress) = effect.stress(x, b) else { continue };
            let volume: f64 = (0..stress.len()).map(|q| points.weight(b, q)).sum();
            for (q, p) in stress.iter().enumerate() {
                let f = points.deformation_gradient(x, b, q);
                out[cell as usize] += p * f.transpose() * (points.weight(b, q) / volume / f.determinant());
            }
        }
    }
    out
}

/// \[nodes\] mean over the cells there.
fn nodal(body: &Body, cells: &[Mat3]) -> Vec<Mat3> {
    let mesh = &body.mesh;
    let mut sums = vec![(Mat3::zeros(), 0.0); mesh.points.len()];
    for (c, stress) in cells.iter().enumerate() {
        let volume = mesh.cell_volume(c);
        for &node in mesh.cell(c) {
            let sum = &mut sums[node as usize];
            *sum = (sum.0 + stress * volume, sum.1 + volume);
        }
    }
    sums.into_iter().map(|(sum, volume)| if volume > 0.0 { sum / volume } else { sum }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_schedule_is_met_at_the_next_point_of_the_grid() {
        let grid: Vec<f64> = (0..=10).map(|k| f64::from(k) * 0.1).collect();
        let due = |schedule: &ScheduleSpec| -> Vec<usize> {
            let past = |k: usize| k.checked_sub(1).map(|k| grid[k]);
            (0..grid.len()).filter(|&k| schedule.due(past(k), grid[k])).collect()
        };
        assert_eq!(due(&ScheduleSpec::default()), (0..=10).collect::<Vec<_>>());
        assert_eq!(due(&ScheduleSpec { every: Some(Time(0.3)), times: vec![] }), [0, 3, 6, 9]);
        assert_eq!(due(&ScheduleSpec { every: Some(Time(0.25)), times: vec![] }), [0, 3, 5, 8, 10]);
        assert_eq!(due(&ScheduleSpec { every: None, times: vec![Time(0.42), Time(1.0)] }), [0, 5, 10]);
    }

    #[test]
    fn von_mises_of_tension_and_of_shear() {
        let tension = Mat3::new(3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        let shear = Mat3::new(5.0, 2.0, 0.0, 2.0, 5.0, 0.0, 0.0, 0.0, 5.0);
        assert!((von_mises(&tension) - 3.0).abs() < 1e-15);
        assert!((von_mises(&shear) - 2.0 * 3f64.sqrt()).abs() < 1e-15);
    }
}
