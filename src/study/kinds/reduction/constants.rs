//! Constants of laws as inputs of a study, and keys that cannot be inputs.

use crate::material::law_from_table;
use crate::scene::{ParameterKey, hint, read_scene};
use crate::study::kinds::reduction::record::ReductionInputRecord;
use crate::study::spec::Mistake;
use std::path::Path;

/// Keys that are neither signals nor constants of laws: the part of the key that identifies them, why they cannot be inputs, and the remedy.
const OTHERS: [(&str, &str, &str); 5] = [
    (
        "mesh.",
        "it makes another mesh, whose states have no modes in common with this one",
        "make a model for each mesh",
    ),
    ("stage", "statics have no protocol but their inputs", "take the signals that the stages drive"),
    ("numerics", "it changes how equations are solved, not their solution", "set it in the scene"),
    (".density", "it multiplies a weight", "take the acceleration of the weight, which it multiplies"),
    (".prony", "statics have no rates", "leave relaxation out"),
];

/// Refuses inputs that are impossible, naming the input and the reason.
pub fn check(inputs: &[ReductionInputRecord], scene: &Path) -> Result<(), Mistake> {
    for input in inputs {
        let place = format!("input {}", input.name);
        let is_other = |key: &str| input.key.starts_with(key) || key.starts_with('.') && input.key.contains(key);
        if let Some((_, why, remedy)) = OTHERS.iter().find(|(key, ..)| !input.is_constant() && is_other(key)) {
            return Err((place, format!("{} cannot be an input: {why}", input.key), (*remedy).into()));
        }
    }
    // A scene that cannot be read is refused elsewhere, with its own reason
    let Ok((spec, _)) = read_scene(scene, &[]) else { return Ok(()) };
    for input in inputs.iter().filter(|input| input.is_constant()) {
        let mistake = |fact: String, remedy: String| (format!("input {}", input.name), fact, remedy);
        let key: ParameterKey = input
            .key
            .parse()
            .map_err(|e: crate::scene::KeyError| mistake(e.to_string(), "write laws.rubber.mu".into()))?;
        let Some(constant) = key.law_constant() else {
            return Err(mistake(format!("{key} is no constant of a law"), "write for example laws.rubber.mu".into()));
        };
        let known: Vec<String> = spec.laws.keys().cloned().collect();
        let Some(law) = spec.laws.get(constant.law) else {
            return Err(mistake(format!("there is no law \"{}\"", constant.law), hint(constant.law, &known)));
        };
        if !law.contains_key(constant.key) {
            let known: Vec<String> = law.keys().filter(|k| *k != "law").cloned().collect();
            let fact = format!(
                "the scene does not give its law by \"{}\", and two sets of constants cannot both be held",
                constant.key
            );
            return Err(mistake(fact, hint(constant.key, &known)));
        }
        for value in input.range {
            let mut law = law.clone();
            law.insert(constant.key.into(), input.text(value));
            let remedy = "give a range within the bounds of the law, in the unit of the constant";
            law_from_table(&law).map_err(|e| mistake(e.to_string(), remedy.into()))?;
        }
    }
    Ok(())
}
