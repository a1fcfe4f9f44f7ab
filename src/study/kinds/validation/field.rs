//! Displacement fields: many points of a body, measured by image correlation or markers, as quantities of a validation.
//!
//! Every component of every point is a quantity of its own, the change of a marker that is added to the scene. The points are given in the frame of
//! the body, so that the residual error of their registration is a rigid motion common to all of them: three shifts and, to first order, three
//! rotations ω × (X − X̄) are errors that all points of a record share.

use crate::math::tensor::Vec3;
use crate::math::units::{self, Dimension};
use crate::storage::table::Line;
use crate::study::kinds::validation::measured;
use crate::study::kinds::validation::plan::{ErrorPlan, QuantityPlan};
use crate::study::kinds::validation::spec::{Evaluation, MeasuredFieldSpec, RecordSpec};
use crate::study::spec::EXPERIMENT;
use std::collections::BTreeMap;
use std::path::Path;

/// Axes by the letters of the columns.
const AXES: [&str; 3] = ["x", "y", "z"];
/// Largest number of points of a field: each adds three columns, with derivatives, to a run.
const MOST: usize = 500;

/// A field of one record.
pub struct Field {
    /// Positions at rest \[m\]
    points: Vec<Vec3>,
    /// Displacements \[m\]; `None` in a record that is only predicted
    displacements: Vec<Option<Vec3>>,
}

impl Field {
    /// Reads the table of a record; the error describes the mistake in words.
    pub fn read(base: &Path, spec: &MeasuredFieldSpec, record: &RecordSpec) -> Result<Self, String> {
        let file = spec.file.replace(EXPERIMENT, record.experiment());
        let factor = units::parse(&format!("1 {}", spec.unit), Dimension::LENGTH).map_err(|e| format!("unit: {e}"))?;
        let names: Vec<&str> = spec.position.iter().chain(&spec.displacement).map(String::as_str).collect();
        let table = measured::read(base, &file, (&names, &spec.unit), &[])?;
        let rows: Vec<&Line> = table.rows.iter().collect();
        let is_moved: Vec<bool> = rows.iter().map(|row| (3..6).any(|k| !table.cell(row, k).is_empty())).collect();
        let moved: Vec<&Line> = rows.iter().zip(&is_moved).filter(|(_, is)| **is).map(|(row, _)| *row).collect();
        let vectors = |columns, rows: &[&Line]| -> Result<Vec<Vec3>, String> {
            let all = table.numbers(columns, rows).map_err(|e| e.to_string())?;
            Ok((0..rows.len()).map(|k| factor * Vec3::new(all[0][k], all[1][k], all[2][k])).collect())
        };
        let mut by = vectors(3..6, &moved)?.into_iter();
        let displacements = is_moved.into_iter().map(|is| if is { by.next() } else { None }).collect();
        let out = Self { points: vectors(0..3, &rows)?, displacements };
        match out.points.len() {
            0 => Err(format!("{file}: it has no point")),
            n if n > MOST => Err(format!(
                "{file}: {n} points; thin them out to {MOST} at most, which are as good where errors are correlated"
            )),
            _ => Ok(out),
        }
    }

    /// Returns the probe that records the points.
    pub fn probe(&self, name: &str) -> toml::Value {
        let text = |p: &Vec3| p.iter().map(|x| toml::Value::from(format!("{x} m"))).collect::<Vec<_>>();
        let points: Vec<toml::Value> = self.points.iter().map(|p| text(p).into()).collect();
        let keys = [("kind", "markers".into()), ("name", name.into()), ("points", points.into())];
        keys.map(|(key, value): (&str, toml::Value)| (key.to_string(), value))
            .into_iter()
            .collect::<toml::Table>()
            .into()
    }

    /// Returns one quantity per point and component, in millimetres.
    pub fn quantities(&self, spec: &MeasuredFieldSpec, record: &RecordSpec, errors: &Errors) -> Vec<QuantityPlan> {
        let middle = self.points.iter().sum::<Vec3>() / self.points.len() as f64;
        let one = |(k, i): (usize, usize)| {
            let (number, axis, arm) = (k + 1, AXES[i], self.points[k] - middle);
            let shared = |name: String, deviation: f64| ErrorPlan {
                group: "registration".into(),
                deviation,
                source: spec.source.clone(),
                shared: Some(format!("{} {} {name}", record.name, spec.name)),
            };
            let mut all = vec![ErrorPlan {
                group: "field".into(),
                deviation: 1e3 * errors.noise,
                source: spec.source.clone(),
                shared: None,
            }];
            if errors.shift > 0.0 {
                all.push(shared(format!("shift {axis}"), 1e3 * errors.shift));
            }
            for (j, about) in AXES.iter().enumerate().filter(|(j, _)| *j != i && errors.turn > 0.0) {
                let by = Vec3::ith(j, 1.0).cross(&arm)[i];
                all.push(shared(format!("rotation {about}"), 1e3 * errors.turn * by));
            }
            let measured = self.displacements[k].map_or(vec![], |u| vec![1e3 * u[i]]);
            QuantityPlan {
                name: format!("{}_{number}_{axis}", spec.name),
                label: format!("{axis} of point {number}"),
                symbol: format!("u{axis}"),
                unit: "mm".into(),
                column: format!("{}_{number}_{axis}_m", spec.name),
                value: Evaluation::Change,
                factor: 1e3,
                window: None,
                records: BTreeMap::from([(record.name.clone(), measured)]),
                errors: all,
                by_record: BTreeMap::new(),
            }
        };
        (0..self.points.len()).flat_map(|k| (0..3).map(move |i| (k, i))).map(one).collect()
    }

    /// Whether every point has a measured displacement.
    pub fn is_measured(&self) -> bool {
        self.displacements.iter().all(Option::is_some)
    }
}

/// Standard deviations of a field.
pub struct Errors {
    /// Standard deviation of a component of a point \[m\]
    noise: f64,
    /// Standard deviation of each shift and each rotation of its registration \[m, rad\]
    shift: f64,
    turn: f64,
}

impl Errors {
    pub fn read(spec: &MeasuredFieldSpec) -> Result<Self, String> {
        let read = |key: &str, text: &str, dimension| {
            units::parse(text, dimension)
                .map_err(|e| format!("{key}: {e}"))
                .and_then(|v| if v >= 0.0 { Ok(v) } else { Err(format!("{key}: it is negative")) })
        };
        let noise = read("deviation", &spec.deviation, Dimension::LENGTH)?;
        if noise == 0.0 {
            return Err("deviation: it is zero; no point is measured exactly".into());
        }
        let shift = spec.shift.as_ref().map_or(Ok(0.0), |text| read("shift", text, Dimension::LENGTH))?;
        let turn = spec.rotation.as_ref().map_or(Ok(0.0), |text| read("rotation", text, Dimension::ANGLE))?;
        Ok(Self { noise, shift, turn })
    }
}
