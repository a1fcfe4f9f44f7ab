//! JSON Schema of the files that the program reads and writes, for editors and other programs.
//!
//! A schema is derived from the very types that read or write a file, and its descriptions are their doc comments: a key that is added to a
//! type is in the schema. This module makes of it what TOML means: no `null`, the name of a kind in place of a table, descriptions that are
//! sentences.

use schemars::generate::SchemaSettings;
use schemars::transform::{RecursiveTransform, Transform};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Map, Value};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// A table whose keys are not those of a type, such as changes by path.
pub type AnyTable = BTreeMap<String, Value>;

/// A generator for files that are read.
pub fn reader() -> SchemaGenerator {
    SchemaSettings::draft2020_12().for_deserialize().into_generator()
}

/// A generator for files that are written.
pub fn writer() -> SchemaGenerator {
    SchemaSettings::draft2020_12().for_serialize().into_generator()
}

/// A schema of a whole file with the definitions that it refers to, under this title.
pub fn whole(title: &str, mut schema: Schema, generator: &mut SchemaGenerator) -> Schema {
    schema.insert("$defs".into(), Value::Object(generator.take_definitions(true)));
    RecursiveTransform(in_sentences).transform(&mut schema);
    // The files that are read are TOML, which has no null; those that are written are JSON
    if generator.contract().is_deserialize() {
        RecursiveTransform(without_null).transform(&mut schema);
    }
    let examples = examples(&schema);
    RecursiveTransform(|schema: &mut Schema| show_example(schema, &examples)).transform(&mut schema);
    schema.insert("title".into(), title.into());
    schema.insert("$schema".into(), "https://json-schema.org/draft/2020-12/schema".into());
    schema
}

/// A value that fits one of several schemas.
pub fn any_of(schemas: &[Schema]) -> Schema {
    json_schema!({ "anyOf": schemas })
}

/// Lets the name of a kind be written in place of its table, where the table needs no other key. See `scene::kind`.
pub fn kind_alone(schema: &mut Schema) {
    let Some(kinds) = schema.get_mut("oneOf").and_then(Value::as_array_mut) else { return };
    let is_alone = |kind: &&Value| kind["required"].as_array().is_some_and(|keys| keys.len() == 1);
    let names: Vec<Value> = kinds.iter().filter(is_alone).map(|k| k["properties"]["kind"]["const"].clone()).collect();
    if !names.is_empty() {
        let description = "The name of a kind that needs no other key.";
        kinds.push(json_schema!({ "type": "string", "enum": names, "description": description }).into());
    }
}

/// A share of something: a number, or a text such as `"2 %"`.
pub struct Share;

impl JsonSchema for Share {
    fn schema_name() -> Cow<'static, str> {
        "Share".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A share, as a number or in per cent.",
            "type": ["number", "string"],
            "examples": ["2 %"],
        })
    }
}

/// Removes the names of number types, and makes sentences of descriptions.
fn in_sentences(schema: &mut Schema) {
    schema.remove("format");
    if let Some(Value::String(text)) = schema.get_mut("description") {
        *text = sentence(text);
    }
}

/// Removes `null` from the types, values and choices of a schema.
fn without_null(schema: &mut Schema) {
    let Some(keys) = schema.as_object_mut() else { return };
    if keys.get("default").is_some_and(Value::is_null) {
        keys.remove("default");
    }
    if let Some(Value::Array(types)) = keys.get_mut("type") {
        types.retain(|name| name != "null");
        if let [only] = &types[..] {
            let only = only.clone();
            keys.insert("type".into(), only);
        }
    }
    if let Some(Value::Array(values)) = keys.get_mut("enum") {
        values.retain(|value| !value.is_null());
    }
    only_choice(keys);
}

/// Puts the only schema next to `null` in the place of both.
fn only_choice(keys: &mut Map<String, Value>) {
    let Some(Value::Array(choices)) = keys.get_mut("anyOf") else { return };
    choices.retain(|choice| choice["type"] != "null");
    if choices.len() == 1
        && let Some(Value::Object(only)) = choices.pop()
    {
        keys.remove("anyOf");
        only.into_iter().for_each(|(key, value)| {
            keys.entry(key).or_insert(value);
        });
    }
}

/// A doc comment without the marks of rustdoc, with a full stop.
fn sentence(comment: &str) -> String {
    let plain = comment.replace("\\[", "[").replace("\\]", "]").replace("[`", "`").replace("`]", "`");
    let plain = plain.split_whitespace().collect::<Vec<_>>().join(" ");
    if plain.ends_with('.') { plain } else { plain + "." }
}

/// The first example of every definition that has one.
fn examples(schema: &Schema) -> BTreeMap<String, String> {
    let definitions = schema.get("$defs").and_then(Value::as_object).into_iter().flatten();
    let example = |(name, of): (&String, &Value)| Some((format!("#/$defs/{name}"), of["examples"][0].to_string()));
    definitions.filter(|(_, of)| of["examples"].is_array()).filter_map(example).collect()
}

/// Adds the example of the definition that a schema refers to, as to the description of a length `"1 mm"`.
fn show_example(schema: &mut Schema, examples: &BTreeMap<String, String>) {
    let of_items = schema.get("items").and_then(|items| items.get("$ref"));
    let example = schema.get("$ref").or(of_items).and_then(Value::as_str).and_then(|path| examples.get(path));
    if let Some(example) = example.cloned()
        && let Some(Value::String(text)) = schema.get_mut("description")
    {
        text.push_str(&format!(" Write for example {example}."));
    }
}
