//! Goes through a schema and makes examples of what it describes.

use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};

/// A table of a file, whose keys are all known.
pub struct Object {
    /// The path to it through the schema
    pub name: String,
    /// Its keys but `kind`
    pub keys: BTreeSet<String>,
    /// The path to it through a file
    path: Vec<Step>,
    /// A file in which the table has the keys that are required
    file: Value,
    /// The table with all keys
    full: Value,
}

#[derive(Clone)]
enum Step {
    Key(String),
    First,
}

impl Object {
    /// The file in which the table has all of its keys.
    pub fn with_all_keys(&self) -> Value {
        let mut file = self.file.clone();
        *at(&mut file, &self.path) = self.full.clone();
        file
    }

    /// The file in which the table has one more key.
    pub fn with_key(&self, key: &str, value: Value) -> Value {
        let mut file = self.file.clone();
        at(&mut file, &self.path)[key] = value;
        file
    }
}

fn at<'a>(file: &'a mut Value, path: &[Step]) -> &'a mut Value {
    path.iter().fold(file, |value, step| match step {
        Step::Key(key) => &mut value[key.as_str()],
        Step::First => &mut value[0],
    })
}

/// All tables that a schema describes, whose keys are all known.
pub fn objects(schema: &Value) -> Vec<Object> {
    let mut walk = Walk { root: schema, found: Vec::new(), seen: BTreeSet::new() };
    walk.visit(schema, "", &[], &|value| value);
    walk.found
}

struct Walk<'a> {
    root: &'a Value,
    found: Vec<Object>,
    seen: BTreeSet<String>,
}

impl<'a> Walk<'a> {
    /// Visits a schema at a path; `file` makes a file of a value that is put there.
    fn visit(&mut self, schema: &'a Value, name: &str, path: &[Step], file: &dyn Fn(Value) -> Value) {
        if let Some(reference) = schema["$ref"].as_str() {
            if self.seen.insert(reference.to_string()) {
                let target = resolve(self.root, reference);
                self.visit(target, reference, path, file);
            }
            return;
        }
        for (k, choice) in ["oneOf", "anyOf"].iter().filter_map(|key| schema[key].as_array()).flatten().enumerate() {
            self.visit(choice, &format!("{name}|{k}"), path, file);
        }
        if let Some(items) = schema.get("items") {
            let count = schema["minItems"].as_u64().unwrap_or(1).max(1) as usize;
            let rest = example(self.root, items, false);
            let list = |value: Value| {
                let others = std::iter::repeat_n(rest.clone(), count - 1);
                file(std::iter::once(value).chain(others).collect())
            };
            self.visit(items, &format!("{name}[]"), &[path, &[Step::First]].concat(), &list);
        }
        if let Some(values) = schema.get("additionalProperties").filter(|values| values.is_object()) {
            let entry = |value: Value| file(Map::from_iter([("a".to_string(), value)]).into());
            self.visit(values, &format!("{name}.*"), &[path, &[Step::Key("a".into())]].concat(), &entry);
        }
        self.visit_table(schema, name, path, file);
    }

    fn visit_table(&mut self, schema: &'a Value, name: &str, path: &[Step], file: &dyn Fn(Value) -> Value) {
        let Some(properties) = schema["properties"].as_object() else { return };
        let base = example(self.root, schema, false);
        // A law is read by its own reader
        if schema["additionalProperties"] == false && !name.contains("LawTable") {
            self.found.push(Object {
                name: name.into(),
                keys: properties.keys().filter(|key| *key != "kind").cloned().collect(),
                path: path.to_vec(),
                file: file(base.clone()),
                full: example(self.root, schema, true),
            });
        }
        for (key, property) in properties {
            let with = |value: Value| {
                let mut table = base.clone();
                table[key] = value;
                file(table)
            };
            self.visit(property, &format!("{name}.{key}"), &[path, &[Step::Key(key.clone())]].concat(), &with);
        }
    }
}

fn resolve<'a>(root: &'a Value, reference: &str) -> &'a Value {
    root.pointer(reference.trim_start_matches('#')).expect("a definition of the schema")
}

/// A value that a schema describes, with all keys or with those that are required.
fn example(root: &Value, schema: &Value, all: bool) -> Value {
    if let Some(reference) = schema["$ref"].as_str() {
        return example(root, resolve(root, reference), false);
    }
    let first = ["examples", "enum", "oneOf", "anyOf"].iter().find_map(|key| Some((*key, schema[key].get(0)?)));
    match (schema.get("const"), first) {
        (Some(value), _) => return value.clone(),
        (_, Some(("examples" | "enum", value))) => return value.clone(),
        (_, Some((_, choice))) => return example(root, choice, false),
        _ => {}
    }
    let types = schema["type"].as_str().or(schema["type"][0].as_str());
    match types {
        Some("string") if schema.get("pattern").is_some() => "1 mm".into(),
        Some("string") => "x".into(),
        Some("integer") => schema["minimum"].as_u64().unwrap_or(1).max(1).into(),
        Some("number") => 0.5.into(),
        Some("boolean") => true.into(),
        Some("array") => {
            let count = schema["minItems"].as_u64().unwrap_or(1);
            (0..count).map(|_| example(root, &schema["items"], false)).collect()
        }
        Some("object") => {
            let required: Vec<&str> =
                schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
            let keys = schema["properties"].as_object().into_iter().flatten();
            let keys = keys.filter(|(key, _)| all || required.contains(&key.as_str()));
            let table: BTreeMap<String, Value> =
                keys.map(|(key, of)| (key.clone(), example(root, of, false))).collect();
            table.into_iter().collect::<Map<_, _>>().into()
        }
        _ => "x".into(),
    }
}
