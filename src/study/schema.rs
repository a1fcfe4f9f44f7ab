//! JSON Schemas of scene files, study files and `summary.json`.

use super::kinds::KINDS;
use super::study_file::StudySpec;
use super::summary::Summary;
use crate::scene::SceneSpec;
use crate::schema::{reader, whole, writer};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Map, Value};

/// A file that has a schema.
pub struct Described {
    pub name: &'static str,
    pub schema: fn() -> Schema,
}

/// All files that have a schema.
pub const SCHEMAS: [Described; 3] = [
    Described { name: "scene", schema: scene },
    Described { name: "study", schema: study },
    Described { name: "summary", schema: summary },
];

/// The schema of `scene.toml`.
///
/// ```
/// let schema = durometer::study::schema::scene();
/// let required = schema.get("required").and_then(|keys| keys.as_array()).expect("a list of keys");
/// assert!(required.iter().any(|key| key == "mesh"));
/// ```
pub fn scene() -> Schema {
    let mut generator = reader();
    let schema = SceneSpec::json_schema(&mut generator);
    whole("Scene of Durometer", schema, &mut generator)
}

/// The schema of `study.toml`: the keys of one kind of study, and those that all kinds share.
pub fn study() -> Schema {
    let mut generator = reader();
    let common = StudySpec::json_schema(&mut generator);
    let kinds: Vec<Schema> =
        KINDS.iter().map(|kind| of_kind(kind.name, kind.schema, &common, &mut generator)).collect();
    whole("Study of Durometer", json_schema!({ "oneOf": kinds }), &mut generator)
}

fn of_kind(
    name: &str,
    own: fn(&mut SchemaGenerator) -> Schema,
    common: &Schema,
    generator: &mut SchemaGenerator,
) -> Schema {
    let mut schema = own(generator);
    let entries = |of: &Schema, key| of.get(key).cloned().unwrap_or_default();
    let mut properties = Map::new();
    for part in [entries(common, "properties"), entries(&schema, "properties")] {
        properties.extend(part.as_object().cloned().unwrap_or_default());
    }
    let description = properties["kind"]["description"].clone();
    properties["kind"] = json_schema!({ "const": name, "description": description }).into();
    let required = [entries(common, "required"), entries(&schema, "required")];
    let required: Vec<Value> = required.iter().filter_map(Value::as_array).flatten().cloned().collect();
    schema.insert("properties".into(), properties.into());
    schema.insert("required".into(), required.into());
    schema.insert("title".into(), format!("Study of kind {name}").into());
    schema
}

/// The schema of `summary.json`. Its `analysis` depends on the kind of the study and is an open object.
pub fn summary() -> Schema {
    let mut generator = writer();
    let schema = Summary::json_schema(&mut generator);
    whole("Summary of a study of Durometer", schema, &mut generator)
}
