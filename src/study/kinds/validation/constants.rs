//! Constants to be found and inputs with a deviation, read from their keys and the scenes.

use crate::math::units::{self, Dimension};
use crate::scene::{ParameterKey, find};
use crate::study::kinds::validation::plan::{RecordPlan, UnknownPlan};
use crate::study::kinds::validation::spec::{Purpose, RecordSpec, UncertainInputSpec, UnknownSpec, ValidationStudy};
use crate::wording::either;

/// Largest number of unknowns: their corners are 16 runs.
const MOST_UNKNOWNS: usize = 4;

/// Reads an unknown with its range in its unit; the error describes the mistake in words.
pub fn unknown(u: &UnknownSpec) -> Result<UnknownPlan, String> {
    let read = |v: &toml::Value| match v {
        toml::Value::String(text) => units::quantity(text).map_err(|e| e.to_string()),
        other => number(other).map(|n| (n, Dimension::NONE)).ok_or_else(|| format!("{other} is not a number")),
    };
    let found = match (read(&u.range[0]), read(&u.range[1])) {
        (Ok((low, a)), Ok((high, b))) if a == b && low < high => Ok([low, high]),
        (Ok((_, a)), Ok((_, b))) if a != b => Err("its ends have different dimensions".to_string()),
        (Ok(_), Ok(_)) => Err("its lower end is not below the upper one".into()),
        (Err(why), _) | (_, Err(why)) => Err(why),
    };
    let [low, high] = found.map_err(|why| format!("unknown {}: range: {why}", u.name))?;
    let parts = u.range[0].as_str().and_then(|text| units::parts(text).ok());
    let (unit, factor) = parts.map_or((String::new(), 1.0), |(_, unit, factor, _)| (unit.into(), factor));
    let (name, key, label, symbol) = (u.name.clone(), u.key.clone(), u.label.clone(), u.symbol.clone());
    Ok(UnknownPlan { name, key, label, symbol, unit, range: [low / factor, high / factor], factor })
}

/// Reads a record with the unknowns and inputs that its scene has; mistakes are added to `wrong`.
pub fn record(
    r: &RecordSpec,
    scene: &toml::Table,
    study: &ValidationStudy,
    unknowns: &[UnknownPlan],
    wrong: &mut Vec<String>,
) -> RecordPlan {
    let own = (0..unknowns.len()).filter(|u| find(scene, &unknowns[*u].key).is_ok()).collect();
    let mut inputs = vec![];
    for (j, input) in study.inputs.iter().enumerate() {
        let named = input.records.as_ref().map(|of| of.contains(&r.name));
        if named == Some(false) {
            continue;
        }
        let keys: Vec<&String> = input.keys.iter().filter(|key| find(scene, key).is_ok()).collect();
        match (deviations(input, &keys, scene), named) {
            (_, None) if keys.is_empty() => {}
            (_, Some(_)) if keys.is_empty() => {
                wrong.push(format!("input {}: the scene of record {} has none of its keys", input.name, r.name));
            }
            (Ok(found), _) => inputs.push((j, found)),
            (Err(why), _) => wrong.push(format!("input {}, record {}: {why}", input.name, r.name)),
        }
    }
    RecordPlan {
        name: r.name.clone(),
        label: r.label.clone().unwrap_or_else(|| r.name.clone()),
        experiment: r.experiment().into(),
        purpose: r.purpose,
        unknowns: own,
        inputs,
        open: vec![],
    }
}

/// Returns the mistakes of unknowns that no calibration record has, of keys of inputs that no scene has, and of too many unknowns.
pub fn without_use(study: &ValidationStudy, records: &[RecordPlan], scenes: &[toml::Table]) -> Vec<String> {
    let mut wrong = vec![];
    let calibrated = |k: &usize| records.iter().any(|r| r.purpose == Purpose::Calibration && r.unknowns.contains(k));
    for (_, u) in study.unknowns.iter().enumerate().filter(|(k, _)| !calibrated(k)) {
        wrong.push(format!("unknown {}: no calibration record has the key {}", u.name, u.key));
    }
    for input in &study.inputs {
        let is_own = |r: &RecordSpec| input.records.as_ref().is_none_or(|of| of.contains(&r.name));
        let acts =
            |key: &String| study.records.iter().zip(scenes).any(|(r, scene)| is_own(r) && find(scene, key).is_ok());
        let idle: Vec<&String> = input.keys.iter().filter(|key| !acts(key)).collect();
        if !idle.is_empty() {
            wrong.push(format!("input {}: no scene of its records has the key {}", input.name, either(&idle)));
        }
    }
    if study.unknowns.len() > MOST_UNKNOWNS {
        wrong.push(format!("{} unknowns; at most {MOST_UNKNOWNS} are found at once", study.unknowns.len()));
    }
    wrong
}

/// The keys of an input that a scene has, with one standard deviation each \[SI\].
fn deviations(input: &UncertainInputSpec, keys: &[&String], scene: &toml::Table) -> Result<Vec<(String, f64)>, String> {
    let (amount, dimension) = units::quantity(&input.deviation).map_err(|e| e.to_string())?;
    if amount <= 0.0 {
        return Err("its deviation is not above zero".into());
    }
    let share = input.deviation.trim().ends_with('%');
    let one = |key: &&String| {
        let found = key.parse::<ParameterKey>().and_then(|key| key.value(scene)).map_err(|e| e.to_string())?;
        let value = found.si();
        match share {
            true if value == 0.0 => {
                Err(format!("{key} is zero, of which no share is taken; give the deviation as a quantity"))
            }
            true => Ok(((*key).clone(), amount * value.abs())),
            false if found.dimension == dimension => Ok(((*key).clone(), amount)),
            false => Err(format!("{key} has another dimension than the deviation \"{}\"", input.deviation)),
        }
    };
    keys.iter().map(one).collect()
}

fn number(v: &toml::Value) -> Option<f64> {
    v.as_float().or_else(|| v.as_integer().map(|n| n as f64))
}
