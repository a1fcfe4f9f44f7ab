//! Inputs given by law files: the constants of the laws of a record that its study neither determines nor states, with the intervals from their
//! files.
//!
//! The standard deviation is the larger side of the 95 % interval divided by 1.96. Correlated constants share sources: source s moves constant k by
//! the entry (k, s) of the Cholesky factor of their covariance. Records with the same constants from the same file share their sources.

use crate::scene::SceneSpec;
use crate::study::kinds::validation::budget::COVERAGE;
use crate::study::kinds::validation::plan::{InputPlan, ValidationPlan};
use crate::study::run::uncertain_constants::{Uncertain, uncertain_constants, undetermined_constants};
use nalgebra::DMatrix;
use std::collections::BTreeMap;
use toml::Table;

/// Group of these inputs in the budget.
const GROUP: &str = "law file";

/// Keys with one standard deviation each \[SI\].
type Amounts = Vec<(String, f64)>;

/// Adds the inputs from the law files of its records to a plan. `scenes` are the scenes of the records.
pub fn with_inputs(mut plan: ValidationPlan, scenes: &[SceneSpec]) -> ValidationPlan {
    let mut known: Vec<(usize, Amounts, Option<&Table>)> = vec![];
    for (place, scene) in scenes.iter().enumerate().take(plan.records.len()) {
        let taken = plan.records[place].keys(&plan.unknowns);
        let is_taken = |key: &String| taken.contains(key);
        let used = scene.laws_in_use();
        let mut laws: BTreeMap<String, Vec<Uncertain>> = BTreeMap::new();
        for one in uncertain_constants(scene) {
            let Some(law) = one.keys[0].law_constant().map(|of| of.law.to_string()) else { continue };
            if used.contains(law.as_str()) && !one.keys.iter().any(|key| is_taken(&key.to_string())) {
                laws.entry(law).or_default().push(one);
            }
        }
        for (law, constants) in &laws {
            let provenance = scene.laws.get(law).and_then(|table| table.get("provenance")?.as_table());
            for (name, value, amounts) in sources(constants) {
                let is_same = |(_, of, from): &&(usize, Amounts, Option<&Table>)| *of == amounts && *from == provenance;
                let found = known.iter().find(is_same).map(|(k, ..)| *k);
                let input = found.unwrap_or_else(|| {
                    let label = &plan.records[place].label;
                    let is_named = plan.inputs.iter().any(|i| i.name == name);
                    let name = if is_named { format!("{name} of {label}") } else { name };
                    plan.inputs.push(InputPlan {
                        name,
                        group: GROUP.into(),
                        deviation: words(value, &amounts),
                        source: "95 % interval of the law file".into(),
                        of_law_file: true,
                    });
                    known.push((plan.inputs.len() - 1, amounts.clone(), provenance));
                    plan.inputs.len() - 1
                });
                plan.records[place].inputs.push((input, amounts));
            }
        }
        plan.records[place].open = undetermined_constants(scene).into_iter().filter(|key| !is_taken(key)).collect();
    }
    plan
}

/// Independent sources of the errors of these constants: name, value and amounts.
fn sources(constants: &[Uncertain]) -> Vec<(String, f64, Amounts)> {
    let name = |one: &Uncertain| one.keys.iter().map(ToString::to_string).collect::<Vec<_>>().join(" = ");
    let n = constants.len();
    let correlation = DMatrix::from_fn(n, n, |a, b| match a == b {
        true => 1.0,
        false => {
            let known = constants[b].keys.iter().find_map(|k| constants[a].correlation.get(&k.to_string()));
            known.copied().unwrap_or(0.0)
        }
    });
    // A matrix that is not a valid covariance is ignored
    let factor = correlation.cholesky().map_or_else(|| DMatrix::identity(n, n), |c| c.l());
    let of = |s: usize| {
        let moved = constants.iter().enumerate().filter(|(k, _)| factor[(*k, s)] != 0.0);
        let amounts = moved.flat_map(|(k, one)| {
            let amount = factor[(k, s)] * one.half_width / COVERAGE;
            one.keys.iter().map(move |key| (key.to_string(), amount))
        });
        (name(&constants[s]), constants[s].value, amounts.collect())
    };
    (0..n).map(of).collect()
}

/// The deviation of the first constant of a source, after which the source is named.
fn words(value: f64, amounts: &Amounts) -> String {
    let first = amounts.first().map_or(0.0, |(_, amount)| *amount);
    if value == 0.0 { format!("{first:.3e}") } else { format!("{:.2} %", 100.0 * (first / value).abs()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ParameterKey;

    /// Two constants with correlation 0.6 have two sources, whose squares add up to their variances and whose products add up to the covariance.
    #[test]
    fn correlated_constants_share_a_source() {
        let one = |name: &str, other: &str| Uncertain {
            keys: vec![ParameterKey::of_law("rubber", name)],
            value: 10.0,
            half_width: COVERAGE,
            correlation: [(ParameterKey::of_law("rubber", other).to_string(), 0.6)].into(),
        };
        let found = sources(&[one("C10", "C01"), one("C01", "C10")]);
        assert_eq!(found.len(), 2);
        let of = |key: &str| -> Vec<f64> {
            found.iter().map(|(.., all)| all.iter().find(|(k, _)| k == key).map_or(0.0, |a| a.1)).collect()
        };
        let (a, b) = (of("laws.rubber.C10"), of("laws.rubber.C01"));
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert!((dot(&a, &a) - 1.0).abs() < 1e-12 && (dot(&b, &b) - 1.0).abs() < 1e-12, "{a:?} {b:?}");
        assert!((dot(&a, &b) - 0.6).abs() < 1e-12, "{a:?} {b:?}");
        assert_eq!((found[0].0.as_str(), words(found[0].1, &found[0].2).as_str()), ("laws.rubber.C10", "10.00 %"));
    }
}
