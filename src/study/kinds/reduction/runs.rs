//! Runs through points in the ranges of the inputs, as changes of the scene.

use super::record::ReductionInputRecord;
use crate::reduction::inputs::SHARE;
use crate::scene::column;

/// Relative rounding error of the end of a step.
const ROUNDING: f64 = 1e-9;

/// Returns the fraction of the range at which the input is zero, or nearest to it.
pub fn at_rest(input: &ReductionInputRecord) -> f64 {
    let [low, high] = input.range;
    (input.at_rest() - low) / (high - low)
}

/// Converts fractions of the ranges to values in the units of the inputs.
pub fn in_units(inputs: &[ReductionInputRecord], shares: &[f64]) -> Vec<f64> {
    inputs.iter().zip(shares).map(|(i, s)| i.range[0] + s * (i.range[1] - i.range[0])).collect()
}

/// Returns the changes of a run: each signal starts at rest and is piecewise linear over time, with one point per second; constants are those of the
/// first point. If the `quantities` include angles, which count full turns from state to state, the path to each point is divided into steps.
pub fn members<'a>(
    inputs: &[ReductionInputRecord],
    points: &[Vec<f64>],
    quantities: impl IntoIterator<Item = &'a str>,
) -> toml::Table {
    let mut changes = polygons(inputs, points, 1.0);
    let constants = inputs.iter().enumerate().filter(|(_, input)| input.is_constant());
    changes.extend(constants.filter_map(|(k, input)| Some((input.key.clone(), input.text(points.first()?[k])))));
    let turns = quantities.into_iter().any(column::is_angle);
    let start: Vec<f64> = inputs.iter().map(ReductionInputRecord::at_rest).collect();
    let from = std::iter::once(&start).chain(points);
    let steps = from.zip(points).map(|(from, to)| if turns { steps(inputs, from, to) } else { 1 });
    let steps: Vec<usize> = steps.collect();
    let stage = |alike: &[usize]| {
        let mut stage = toml::Table::new();
        stage.insert("integrator".into(), "static".into());
        stage.insert("duration".into(), format!("{} s", alike.len()).into());
        stage.insert("dt".into(), format!("{} s", 1.0 / alike[0] as f64).into());
        toml::Value::Table(stage)
    };
    changes.insert("stage".into(), steps.chunk_by(|a, b| a == b).map(stage).collect::<Vec<_>>().into());
    changes
}

/// Number of steps from one point to the next such that no signal changes by more than a given fraction of its range per step; a power of two, so
/// that the times have no rounding.
fn steps(inputs: &[ReductionInputRecord], from: &[f64], to: &[f64]) -> usize {
    let signals = inputs.iter().zip(from.iter().zip(to)).filter(|(input, _)| !input.is_constant());
    let shares = signals.map(|(input, (from, to))| (to - from).abs() / (input.range[1] - input.range[0]));
    let most = shares.fold(0.0, f64::max);
    ((most / SHARE - ROUNDING).ceil().max(1.0) as usize).next_power_of_two()
}

/// Returns the rows of a run at its points and at rest, found by their times \[s\]: one per second.
pub fn at_points(t: &[f64]) -> Vec<usize> {
    (0..t.len()).filter(|&row| (t[row] - t[row].round()).abs() <= ROUNDING * t[row].max(1.0)).collect()
}

/// Returns each signal as a polygon over time with these points at intervals of `each` \[s\], starting at rest.
pub fn polygons(inputs: &[ReductionInputRecord], points: &[Vec<f64>], each: f64) -> toml::Table {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The path to an angle is divided into steps of a sixteenth of the range, other paths are not; the states at the points are found again.
    #[test]
    fn the_way_to_an_angle_is_cut() {
        let input = |key: &str| ReductionInputRecord {
            name: "pull".into(),
            key: key.into(),
            unit: "mm".into(),
            range: [0.0, 16.0],
            start: None,
            held: false,
        };
        let inputs = [input("a"), input("laws.rubber.mu")];
        let points = [[1.0, 0.0], [2.0, 16.0], [5.0, 0.0], [1.0, 0.0], [9.0, 0.0]].map(|p| p.to_vec());
        let stages = |column: &str| -> Vec<(String, String)> {
            let run = members(&inputs, &points, [column]);
            let text = |stage: &toml::Value, key: &str| stage[key].as_str().expect("text").to_string();
            run["stage"].as_array().expect("stages").iter().map(|s| (text(s, "duration"), text(s, "dt"))).collect()
        };
        let of = |all: &[[&str; 2]]| all.iter().map(|[a, b]| (a.to_string(), b.to_string())).collect::<Vec<_>>();
        assert_eq!(stages("tip_x_m"), of(&[["5 s", "1 s"]]));
        assert_eq!(stages("bending_angle_deg"), of(&[["2 s", "1 s"], ["2 s", "0.25 s"], ["1 s", "0.125 s"]]));
        let t = [0.0, 1.0, 2.0, 2.25, 2.5, 2.75, 3.0 - 1e-12, 3.25];
        assert_eq!(at_points(&t), [0, 1, 2, 6]);
    }
}
