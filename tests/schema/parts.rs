//! Goes through all parts of a schema.

use serde_json::Value;

/// Calls a function with every part of a schema and the path to it, `/$defs/Name/properties/key`.
pub fn each_part(schema: &Value, see: &mut dyn FnMut(&str, &Value)) {
    fn walk(part: &Value, path: &str, see: &mut dyn FnMut(&str, &Value)) {
        see(path, part);
        match part {
            Value::Object(keys) => keys.iter().for_each(|(key, value)| walk(value, &format!("{path}/{key}"), see)),
            Value::Array(list) => {
                list.iter().enumerate().for_each(|(k, value)| walk(value, &format!("{path}/{k}"), see))
            }
            _ => {}
        }
    }
    walk(schema, "", see);
}
