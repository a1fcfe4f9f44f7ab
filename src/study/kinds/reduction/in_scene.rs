//! The inputs of a study as they are in its scene: their values at the start, and whether they drive it.

use super::record::ReductionInputRecord;
use crate::math::units;
use crate::scene::spec::{EffectSpec, IntegratorSpec, SignalSpec};
use crate::scene::{SceneSpec, find, overrides, read_scene};
use crate::study::spec::Mistake;
use serde::Deserialize;
use std::path::Path;

/// Adds the facts of the scene to each input. Refuses two inputs that replace the same value and, for runs in time, a scene that is static or has
/// several stages.
pub fn complete(inputs: &mut [ReductionInputRecord], scene: &Path, in_time: bool) -> Result<(), Mistake> {
    // A scene that cannot be read is refused elsewhere, with its own reason
    let Ok((spec, text)) = read_scene(scene, &[]) else { return Ok(()) };
    let table: toml::Table = text.parse().unwrap_or_default();
    if in_time && spec.stages.len() > 1 {
        let fact = format!("the scene has {} stages, and the runs in time are of one", spec.stages.len());
        return Err((
            "motion".into(),
            fact,
            "give the scene one stage, with the integrator and the dt of the runs".into(),
        ));
    }
    if in_time && spec.stages.iter().any(|stage| stage.integrator == IntegratorSpec::Static) {
        let fact = "the stage of the scene is static: it has no time".to_string();
        return Err(("motion".into(), fact, "give it a dynamic integrator, or leave `motion` out".into()));
    }
    check_apart(inputs, &table)?;
    inputs.iter().try_for_each(|input| check_whole(input, &table))?;
    for input in inputs {
        input.held = input.is_constant() || is_weight(&spec, &table, &input.key);
        input.start = find(&table, &input.key).ok().and_then(|value| at_start(value, &input.unit, scene));
    }
    Ok(())
}

/// Refuses inputs whose keys lead to the same value, however they are written.
fn check_apart(inputs: &[ReductionInputRecord], table: &toml::Table) -> Result<(), Mistake> {
    let mut marked = table.clone();
    for (k, input) in inputs.iter().enumerate() {
        // A key that leads nowhere is refused elsewhere, with its own reason
        overrides::apply(&mut marked, &input.key, (k as i64).into()).ok();
    }
    for (k, input) in inputs.iter().enumerate() {
        let other = find(&marked, &input.key).ok().and_then(toml::Value::as_integer).filter(|other| *other > k as i64);
        if let Some(other) = other.and_then(|other| inputs.get(other as usize)) {
            let fact = format!("its key {} is that of the input {} too", other.key, input.name);
            return Err((
                format!("input {}", other.name),
                fact,
                "give each input a key of its own, or leave one out".into(),
            ));
        }
    }
    Ok(())
}

/// Refuses an input that is a part of another signal, such as a term of a sum: a controller sets whole signals.
fn check_whole(input: &ReductionInputRecord, table: &toml::Table) -> Result<(), Mistake> {
    let above = std::iter::successors(input.key.rsplit_once('.'), |(above, _)| above.rsplit_once('.'));
    let is_signal = |key: &&str| find(table, key).is_ok_and(|value| SignalSpec::deserialize(value.clone()).is_ok());
    match above.map(|(above, _)| above).filter(is_signal).last() {
        None => Ok(()),
        Some(whole) => Err((
            format!("input {}", input.name),
            format!(
                "its key {} is that of a part of the signal {whole}, and an input takes the place of a whole one",
                input.key
            ),
            format!("write key = \"{whole}\", with a range that has the other parts in it"),
        )),
    }
}

/// Whether a key belongs to a weight.
fn is_weight(spec: &SceneSpec, table: &toml::Table, key: &str) -> bool {
    let entries = if key.starts_with("effect.") { overrides::entries_of(table, key) } else { vec![] };
    entries.iter().any(|&k| matches!(spec.effects.get(k), Some(EffectSpec::Gravity(_))))
}

/// The value of a signal or a constant at the start of the scene, in `unit`.
fn at_start(value: &toml::Value, unit: &str, scene: &Path) -> Option<f64> {
    let (_, _, factor, dimension) = units::parts(&format!("1 {unit}")).ok()?;
    let signal = SignalSpec::deserialize(value.clone()).ok()?;
    Some(signal.at_start(dimension, scene.parent()?)? / factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Constants with and without a unit, and functions of time; a formula of columns has no value of its own.
    #[test]
    fn values_are_those_at_the_start() {
        for (text, unit, expected) in [
            ("\"9.81 m/s^2\"", "m/s^2", Some(9.81)),
            ("\"0.06 MPa\"", "kPa", Some(60.0)),
            ("0.45", "", Some(0.45)),
            ("{ kind = \"ramp\", from = \"2 mm\", to = \"5 mm\", end = \"1 s\" }", "mm", Some(2.0)),
            ("{ kind = \"controlled\", initial = \"3 mm\" }", "mm", Some(3.0)),
            ("{ kind = \"expression\", formula = \"2 * tip_z_m\", unit = \"mm\" }", "mm", None),
            ("\"9.81 m/s^2\"", "mm", None),
        ] {
            let table: toml::Table = format!("v = {text}").parse().expect("TOML");
            let found = at_start(&table["v"], unit, Path::new("scene.toml"));
            let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
            assert!(found.map_or(expected.is_none(), |v| expected.is_some_and(|e| near(v, e))), "{text}: {found:?}");
        }
    }
}
