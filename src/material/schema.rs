//! JSON Schema of the table of a law: each law contributes the constants and choices that it declares.

use super::entry::LawEntry;
use super::parameter::{Choice, Parameter};
use super::registry::{OTHER_KEYS, laws};
use crate::math::units::{self, Dimension};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Map, Value, json};
use std::borrow::Cow;

/// The table of a law in a scene: `law` with its constants, or `include` of a law file with keys added or replaced.
pub struct LawTable;

impl JsonSchema for LawTable {
    fn schema_name() -> Cow<'static, str> {
        "LawTable".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let laws = laws();
        let included = json!({
            "description": "A law file, relative to the scene, with keys added or replaced.",
            "type": "object",
            "properties": { "include": { "type": "string", "description": "Path of the law file, relative to the scene." } },
            "required": ["include"],
        });
        let tables: Vec<Value> = laws.iter().map(|law| table(law)).chain([included]).collect();
        json_schema!({ "oneOf": tables })
    }
}

fn table(law: &LawEntry) -> Value {
    let other = OTHER_KEYS.iter().map(|(key, meaning)| ((*key).to_string(), json!({ "description": meaning })));
    let constants = law.keys.iter().map(|p| (p.name.to_string(), constant(p)));
    let choices = law.info.choices.iter().map(|c| (c.name.to_string(), choice(c)));
    let mut properties: Map<String, Value> = other.chain(constants).chain(choices).collect();
    properties["law"]["const"] = law.info.name.into();
    let required = law.info.choices.iter().filter(|c| c.default.is_none()).map(|c| c.name);
    json!({
        "title": law.info.title,
        "description": law.info.limits,
        "type": "object",
        "properties": properties,
        "required": std::iter::once("law").chain(required).collect::<Vec<_>>(),
        "additionalProperties": false,
    })
}

fn constant(p: &Parameter) -> Value {
    let description = format!("{} ({})", capital(p.meaning), p.symbol);
    if p.dimension == Dimension::NONE {
        return json!({ "type": ["number", "string"], "pattern": units::pattern(), "description": description });
    }
    let description = format!("{description}, such as \"1 {}\".", p.dimension.example());
    json!({ "type": "string", "pattern": units::pattern(), "description": description })
}

fn choice(c: &Choice) -> Value {
    let mut schema = json!({ "enum": c.options, "description": capital(c.meaning) });
    if let Some(default) = c.default {
        schema["default"] = default.into();
    }
    schema
}

/// A text with its first letter capitalised.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
