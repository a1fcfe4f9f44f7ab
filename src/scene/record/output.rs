//! Output of a run in addition to its record, and its schedule: fields for ParaView, rows of the time series.

use crate::scene::error::{SceneError, content};
use crate::scene::signal::instant::rounding;
use crate::scene::text::quantity::Time;
use crate::solve::TimeSpan;
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::Path;

/// Schedule and fields of the files of a run.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutputSpec {
    /// Fields that are written as VTU files, and their times
    pub fields: Option<FieldsSpec>,
    /// Times of the rows of the CSV file; every point of the time grid if absent
    pub series: Option<ScheduleSpec>,
}

/// Fields and their times; every point of the time grid if no time is given.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FieldsSpec {
    /// Names of the fields
    pub what: Vec<FieldSpec>,
    /// Period at which states are written
    pub every: Option<Time>,
    /// Further times at which states are written
    #[serde(default)]
    pub times: Vec<Time>,
}

/// A field over the body
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum FieldSpec {
    /// Displacement \[m\] at the nodes
    Displacement,
    /// Velocity \[m/s\] at the nodes
    Velocity,
    /// Largest principal stretch \[–\] at the nodes
    Stretch,
    /// Cauchy's stress \[Pa\], nine components, at the nodes and in the cells
    Stress,
    /// Von Mises' equivalent stress \[Pa\], at the nodes and in the cells
    VonMises,
    /// Pressure \[Pa\], positive in compression, at the nodes and in the cells
    Pressure,
    /// Force \[N\] of all contacts, normal to the obstacles, at the nodes
    ContactForce,
}

/// Times that repeat with a period, and individual times.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScheduleSpec {
    /// Period
    pub every: Option<Time>,
    /// Further times
    #[serde(default)]
    pub times: Vec<Time>,
}

/// Values at the nodes or in the cells of the mesh, in SI.
///
/// A stress, von Mises' stress or pressure yields two fields of one name: first the values recovered at the nodes, then the means of the cells. Other
/// quantities yield one field, at the nodes.
pub struct Field {
    /// Quantity and unit, such as `displacement_m` or `stress_Pa`
    pub name: &'static str,
    /// Number of components at each node or cell: 1, the 3 of a vector x, y, z, or the 9 of a tensor row by row, σ_xx, σ_xy, σ_xz, σ_yx, …
    pub components: usize,
    /// Values \[nodes or cells × components\], node by node or cell by cell, in the order of the mesh
    pub values: Vec<f64>,
    /// Whether the values are at the nodes; otherwise they are in the cells
    pub at_nodes: bool,
}

impl FieldsSpec {
    pub fn schedule(&self) -> ScheduleSpec {
        ScheduleSpec { every: self.every, times: self.times.clone() }
    }
}

impl ScheduleSpec {
    /// Whether output is due at `t`, after the grid point at `past`. The first state is always due.
    pub fn due(&self, past: Option<f64>, t: f64) -> bool {
        let Some(past) = past else { return true };
        let rounding = rounding(t, t - past);
        let passed = |at: f64, t: f64| at <= t + rounding;
        let count = |t: f64| self.every.map_or(0.0, |every| ((t + rounding) / every.0).floor());
        let always = self.every.is_none() && self.times.is_empty();
        always || count(t) > count(past) || self.times.iter().any(|at| passed(at.0, t) && !passed(at.0, past))
    }
}

/// Refuses times that a run does not reach, and output without fields.
pub(in crate::scene) fn check_output(file: &Path, spans: &[TimeSpan], spec: &OutputSpec) -> Result<(), SceneError> {
    let end = spans.last().map_or(0.0, |s| s.end);
    let fields = spec.fields.as_ref().map(|f| ("output.fields", f.schedule()));
    for (place, ScheduleSpec { every, times }) in
        fields.into_iter().chain(spec.series.clone().map(|s| ("output.series", s)))
    {
        if every.is_some_and(|every| every.0 <= 0.0) {
            return Err(content(file, place, "`every` is not positive", "give the time from one to the next"));
        }
        if let Some(t) = times.iter().find(|t| !(0.0..=end * (1.0 + 1e-9)).contains(&t.0)) {
            let remedy = format!("take times from 0 to {end} s, the end of the last stage");
            return Err(content(file, place, format!("the run has no t = {} s", t.0), remedy));
        }
    }
    if spec.fields.as_ref().is_some_and(|f| f.what.is_empty()) {
        return Err(content(file, "output.fields", "`what` is empty", "list fields such as \"displacement\""));
    }
    Ok(())
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

    /// After hours of settling, no step is missed and none occurs twice, even if the rounding of the time is a thousandth of a step.
    #[test]
    fn a_schedule_is_met_at_late_times() {
        for (start, dt) in [(3600.0, 1e-4), (86_400.0, 1e-4), (86_400.0, 1e-5), (86_400.0, 1e-7)] {
            let time = |k: usize| start + k as f64 * dt;
            let due = |schedule: &ScheduleSpec| -> Vec<usize> {
                (1..=200).filter(|&k| schedule.due(Some(time(k - 1)), time(k))).collect()
            };
            let every = |period: f64| ScheduleSpec { every: Some(Time(period)), times: vec![] };
            assert_eq!(due(&every(dt)).len(), 200, "{start} s, {dt} s");
            assert_eq!(due(&every(4.0 * dt)).len(), 50, "{start} s, {dt} s");
            let at = |k: f64| Time(start + k * dt);
            let times = ScheduleSpec { every: None, times: vec![at(20.0), at(30.5), at(200.0)] };
            assert_eq!(due(&times), [20, 31, 200], "{start} s, {dt} s");
        }
    }
}
