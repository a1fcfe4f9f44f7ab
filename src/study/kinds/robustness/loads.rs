//! The loads of a scene: every signal in its file, multiplied by a factor.
//!
//! Signals are found by the JSON Schema of a scene, at any depth, so that those of each effect, constraint, contact, rigid body and event are
//! included.

use crate::scene::SceneSpec;
use crate::scene::spec::SignalSpec;
use crate::schema::reader;
use schemars::JsonSchema;
use serde_json::{Map, Value as Json};
use toml::{Table, Value};

/// The signals of a scene.
#[derive(Clone, Debug, Default)]
pub struct Loads {
    /// The signals that can be scaled, as (path, signal)
    scaled: Vec<(String, Value)>,
    /// Paths of the signals that a controller sets, which take no factor
    pub controlled: Vec<String>,
}

impl Loads {
    /// Collects the signals of a scene file.
    pub fn new(scene: &Table) -> Self {
        let mut generator = reader();
        let schema = SceneSpec::json_schema(&mut generator);
        let places = Places { definitions: generator.take_definitions(true), signal: SignalSpec::schema_name().into() };
        let mut found = vec![];
        places.visit(schema.as_value(), &Value::Table(scene.clone()), "", &mut found);
        let is_controlled = |signal: &Value| signal.get("kind").and_then(Value::as_str) == Some("controlled");
        let (controlled, scaled): (Vec<_>, Vec<_>) = found.into_iter().partition(|(_, signal)| is_controlled(signal));
        Self { scaled, controlled: controlled.into_iter().map(|(path, _)| path).collect() }
    }

    pub fn is_empty(&self) -> bool {
        self.scaled.is_empty()
    }

    /// The changes that multiply each signal by the factor.
    pub fn times(&self, factor: f64) -> Table {
        let product = |signal: &Value| {
            let of = Value::from(vec![signal.clone(), factor.into()]);
            Value::from(Table::from_iter([("kind".to_string(), "product".into()), ("of".to_string(), of)]))
        };
        self.scaled.iter().map(|(path, signal)| (path.clone(), product(signal))).collect()
    }
}

/// The places in a schema where signals occur.
struct Places {
    definitions: Map<String, Json>,
    /// Name of the schema definition of a signal
    signal: String,
}

impl Places {
    /// Adds the signals in `value`, which has this schema.
    fn visit(&self, schema: &Json, value: &Value, path: &str, found: &mut Vec<(String, Value)>) {
        if let Some(name) = schema["$ref"].as_str().and_then(|path| path.rsplit('/').next()) {
            match self.definitions.get(name) {
                _ if name == self.signal => found.push((path.into(), value.clone())),
                Some(definition) => self.visit(definition, value, path, found),
                None => {}
            }
        }
        let kind = value.get("kind").and_then(Value::as_str);
        let suits = |choice: &&Json| {
            let wanted = choice["properties"]["kind"]["const"].as_str();
            wanted.is_none() || wanted == kind
        };
        let choices = ["anyOf", "oneOf", "allOf"].map(|key| schema[key].as_array());
        for choice in choices.into_iter().flatten().flatten().filter(suits) {
            self.visit(choice, value, path, found);
        }
        let below = |step: &str| if path.is_empty() { step.to_string() } else { format!("{path}.{step}") };
        match value {
            Value::Table(keys) => keys.iter().for_each(|(key, value)| {
                self.visit(&schema["properties"][key], value, &below(key), found);
            }),
            Value::Array(entries) => entries.iter().enumerate().for_each(|(k, entry)| {
                self.visit(&schema["items"], entry, &below(&k.to_string()), found);
            }),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = r#"
[[effect]]
kind = "gravity"
acceleration = "9.81 m/s^2"
[[constraint]]
kind = "prescribed"
rotation = { axis = [0, 1, 0], about = ["0 m", "0 m", "0 m"], angle = { kind = "table", file = "a.csv", unit = "deg" } }
translation = ["1 mm", { kind = "sine", amplitude = "2 mm", frequency = "1 Hz" }, "0 mm"]
[[constraint]]
kind = "cable"
drive = { kind = "length", signal = { kind = "hold", signal = "1 mm", at = "1 s" } }
[[constraint]]
kind = "cable"
drive = { kind = "tension", signal = { kind = "controlled", initial = "1 N" } }
[[contact]]
motion = { direction = [0, 0, 1], displacement = "3 mm", turn = { axis = [0, 0, 1], angle = "4 deg" } }
obstacle = { kind = "box", turn = { axis = [0, 0, 1], angle = "5 deg" } }
[[rigid]]
shape = { kind = "box", turn = { axis = [0, 0, 1], angle = "5 deg" } }
gravity = { direction = [0, 0, -1], acceleration = "9.81 m/s^2" }
[[event]]
then = [{ kind = "stop" }, { kind = "switch", signal = "a", to = "2 N" }]
[start]
kind = "twisted"
angle = "90 deg"
"#;

    /// Motions of regions and obstacles, weights of rigid bodies and signals of events are loads; a rotated shape is not.
    #[test]
    fn every_signal_of_a_scene_is_scaled() {
        let loads = Loads::new(&SCENE.parse().expect("TOML"));
        let mut paths: Vec<String> = loads.times(2.0).keys().cloned().collect();
        paths.sort();
        let expected = [
            "constraint.0.rotation.angle",
            "constraint.0.translation.0",
            "constraint.0.translation.1",
            "constraint.0.translation.2",
            "constraint.1.drive.signal",
            "contact.0.motion.displacement",
            "contact.0.motion.turn.angle",
            "effect.0.acceleration",
            "event.0.then.1.to",
            "rigid.0.gravity.acceleration",
        ];
        assert_eq!(paths, expected);
        assert_eq!(loads.controlled, ["constraint.2.drive.signal"]);
        let angle = &loads.times(2.0)["constraint.0.rotation.angle"];
        assert_eq!(angle["of"][0]["file"].as_str(), Some("a.csv"));
        assert_eq!(angle["of"][1].as_float(), Some(2.0));
    }
}
