//! Sensitivities of a run against differences of whole runs.
//!
//! Differences: central over θ(1 ± h), h = 1e-3 and half of it, Richardson's (4D(h/2) − D(h))/3. With poles 0.05 θ away (an angle
//! that nearly vanishes has such) the truncation is (1e-3/0.05)⁴/4 ≈ 4e-8 of the value; runs that end 1e-11 from equilibrium
//! add 3·1e-11/1e-3 ≈ 3e-8. Accepted is 1e-6 of the largest value of the same unit.

use durometer::material::registry;
use durometer::math::statistics::larger;
use durometer::scene::{ParameterKey, Run, RunOptions, Scene, Sensitivities, SensitivityRecorder, column};
use durometer::solve::Status;
use toml::{Table, Value};

/// The run of a scene that completes, with the sensitivities of every row by these constants of the law `rubber`.
pub fn sensitivities(scene: &Scene, keys: &[String]) -> (Run, Sensitivities) {
    let constants: Vec<ParameterKey> =
        keys.iter().map(|k| format!("laws.rubber.{k}").parse().expect("a name")).collect();
    let recorder = SensitivityRecorder::new(scene, &constants).unwrap_or_else(|e| panic!("{e}"));
    let mut run = scene.run_with(RunOptions { sensitivities: Some(recorder), ..RunOptions::default() });
    let sensitivities = run.sensitivities.take().expect("the options ask for them");
    assert_eq!(
        (&run.status, &sensitivities.stopped, run.rows.len()),
        (&Status::Converged, &None, sensitivities.rows.len())
    );
    (run, sensitivities)
}

/// Every constant of the law `rubber` and every row against differences; the largest error.
pub fn check(label: &str, table: &Table, build: &dyn Fn(&Table) -> Scene) -> f64 {
    let known = registry::find(table["law"].as_str().expect("a name")).expect("registered").keys;
    let keys: Vec<String> = table.keys().filter(|k| known.iter().any(|p| p.name == *k)).cloned().collect();
    let (run, exact) = sensitivities(&build(table), &keys);
    let place = |name: &String| run.columns.iter().position(|c| c == name).expect("a column of the run");
    let columns: Vec<usize> = exact.columns.iter().map(place).collect();
    let sizes: Vec<f64> = exact
        .columns
        .iter()
        .map(|name| {
            let alike = columns.iter().filter(|c| column::comparable(&run.columns[**c], name));
            alike.flat_map(|&c| run.rows.iter().map(move |row| row[c])).fold(0.0, |m, v| larger(m, v.abs()))
        })
        .collect();
    let mut worst = 0.0_f64;
    for (k, key) in keys.iter().enumerate() {
        let (theta, unit) = match &table[key] {
            Value::String(text) => {
                let (number, unit) = text.split_once(' ').expect("a number and its unit");
                (number.parse::<f64>().expect("a number"), Some(unit))
            }
            other => (other.as_float().expect("a number"), None),
        };
        // A constant that is zero is moved by shares of one
        let whole = if theta == 0.0 { 1.0 } else { theta };
        let scale = whole * if unit == Some("kPa") { 1e3 } else { 1.0 };
        let at = |s: f64| {
            let mut table = table.clone();
            let value = theta + whole * s;
            let quantity = unit.map(|unit| Value::from(format!("{value:?} {unit}")));
            table.insert(key.clone(), quantity.unwrap_or(Value::from(value)));
            let moved = super::run(&build(&table));
            assert_eq!(moved.status, Status::Converged, "{label}");
            moved.rows
        };
        let stencil = [1e-3, 5e-4].map(|h| (h, at(h), at(-h)));
        for (row, sensitivities) in exact.rows.iter().enumerate() {
            for (c, (&column, size)) in columns.iter().zip(&sizes).enumerate() {
                let [coarse, fine] = stencil
                    .each_ref()
                    .map(|(h, plus, minus)| (plus[row][column] - minus[row][column]) / (2.0 * h * scale));
                let (expected, got) = ((4.0 * fine - coarse) / 3.0, sensitivities[c][k]);
                let size = size / scale.abs();
                let error = (got - expected).abs() / size;
                let name = &exact.columns[c];
                assert!(
                    got == expected || error <= 1e-6,
                    "{label}: row {row}, d {name}/d {key} = {got:e}, differences say {expected:e} (size {size:e})"
                );
                worst = if got == expected { worst } else { larger(worst, error) };
            }
        }
    }
    worst
}
