//! Runs through points of the ranges of the inputs, as changes of the scene.

use super::record::InputRecord;

/// Share of the range at which the input is zero, or nearest to it.
pub fn at_rest(input: &InputRecord) -> f64 {
    let [low, high] = input.range;
    (input.at_rest() - low) / (high - low)
}

/// Values in the units of the inputs.
pub fn in_units(inputs: &[InputRecord], shares: &[f64]) -> Vec<f64> {
    inputs.iter().zip(shares).map(|(i, s)| i.range[0] + s * (i.range[1] - i.range[0])).collect()
}

/// The changes of a run: each signal is a polygon over time, one point a second, from rest on; constants are those of the first point.
pub fn members(inputs: &[InputRecord], points: &[Vec<f64>]) -> toml::Table {
    let mut changes = polygons(inputs, points, 1.0);
    let constants = inputs.iter().enumerate().filter(|(_, input)| input.is_constant());
    changes.extend(constants.filter_map(|(k, input)| Some((input.key.clone(), input.text(points.first()?[k])))));
    let mut stage = toml::Table::new();
    stage.insert("integrator".into(), "static".into());
    stage.insert("duration".into(), format!("{} s", points.len()).into());
    stage.insert("dt".into(), "1 s".into());
    changes.insert("stage".into(), vec![toml::Value::Table(stage)].into());
    changes
}

/// Each signal as a polygon over time with these points at even distances \[s\], from rest on.
pub fn polygons(inputs: &[InputRecord], points: &[Vec<f64>], each: f64) -> toml::Table {
    let mut changes = toml::Table::new();
    for (k, input) in inputs.iter().enumerate() {
        if input.is_constant() {
            continue;
        }
        let values = std::iter::once(input.at_rest()).chain(points.iter().map(|p| p[k]));
        let point = |(n, value): (usize, f64)| toml::Value::Array(vec![(n as f64 * each).into(), value.into()]);
        let of: Vec<toml::Value> = values.enumerate().map(point).collect();
        let mut signal = toml::Table::new();
        signal.insert("kind".into(), "points".into());
        signal.insert("of".into(), of.into());
        signal.insert("unit".into(), input.unit.clone().into());
        changes.insert(input.key.clone(), signal.into());
    }
    changes
}
