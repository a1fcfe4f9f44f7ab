//! The JSON Schemas say what the program reads and writes: shipped files are valid, refused keys are not, and the keys of a schema are exactly
//! those of the reader.

#[path = "../common/files.rs"]
mod files;
mod parts;
mod walk;

use durometer::material::law_from_table;
use durometer::scene::{SceneError, SceneSpec};
use durometer::study::kind::{COMMON_KEYS, StudyScope};
use durometer::study::schema;
use durometer::study::study_file;
use files::files_below;
use jsonschema::Validator;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use walk::{Object, objects};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn validator(schema: &Value) -> Validator {
    jsonschema::validator_for(schema).expect("a schema of its draft")
}

/// All files below a folder that end so.
fn files(folder: &str, ending: &str) -> Vec<PathBuf> {
    files_below(&root().join(folder)).into_iter().filter(|path| path.to_string_lossy().ends_with(ending)).collect()
}

/// The content of a TOML file as JSON; none of a file that is no TOML.
fn content(file: &Path) -> Option<Value> {
    let table: toml::Table = std::fs::read_to_string(file).ok()?.parse().ok()?;
    Some(serde_json::to_value(table).expect("a table without dates"))
}

/// The schema of a file by its keys: a study asks a question, a scene has stages.
fn kind_of(content: &Value) -> Option<&'static str> {
    if content.get("question").is_some() {
        Some("study")
    } else if content.get("stage").is_some() && content.get("mesh").is_some() {
        Some("scene")
    } else {
        None
    }
}

#[test]
fn shipped_scenes_and_studies_are_valid() {
    let scenes = validator(schema::scene().as_value());
    let studies = validator(schema::study().as_value());
    let (mut wrong, mut checked) = (Vec::new(), [0, 0]);
    for file in ["studies", "src/study/starters", "tests/scenes", "tests/cli"].iter().flat_map(|f| files(f, ".toml")) {
        let content = content(&file).expect("shipped files are TOML");
        let Some(kind) = kind_of(&content) else { continue };
        let (schema, count) = if kind == "scene" { (&scenes, 0) } else { (&studies, 1) };
        checked[count] += 1;
        wrong.extend(schema.iter_errors(&content).map(|e| format!("{}: {}: {e}", file.display(), e.instance_path())));
    }
    assert!(checked[0] > 40 && checked[1] > 30, "{checked:?}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Refuses keys that no type has.
fn close(schema: &mut Value) {
    match schema {
        Value::Object(keys) => {
            keys.values_mut().for_each(close);
            if keys.contains_key("properties") && !keys.contains_key("additionalProperties") {
                keys.insert("additionalProperties".into(), false.into());
            }
        }
        Value::Array(list) => list.iter_mut().for_each(close),
        _ => {}
    }
}

/// Results that this version has written are valid; those of earlier ones lack only keys that were added since.
#[test]
fn published_summaries_are_valid() {
    let mut schema = schema::summary().to_value();
    close(&mut schema);
    let summary = validator(&schema);
    let all = files("reports/published", "summary.json");
    assert!(all.len() >= 20);
    let (mut wrong, mut whole) = (Vec::new(), 0);
    for file in &all {
        let text = std::fs::read_to_string(file).expect("a summary");
        let content: Value = serde_json::from_str(&text).expect("JSON");
        whole += usize::from(summary.is_valid(&content));
        let errors = summary.iter_errors(&content).filter(|e| !e.to_string().ends_with("is a required property"));
        wrong.extend(errors.map(|e| format!("{}: {}: {e}", file.display(), e.instance_path())));
    }
    assert!(whole > 4, "{whole} are valid as they are");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Mistakes in keys, kinds and types are seen by an editor too; those of content, such as a region that does not exist, are not.
#[test]
fn refused_keys_are_refused_by_the_schema() {
    let scenes = validator(schema::scene().as_value());
    let (mut accepted, mut checked) = (Vec::new(), 0);
    for file in files("tests/bad/scenes", ".toml") {
        let message = std::fs::read_to_string(file.with_extension("txt")).unwrap_or_default();
        let of_form = ["unknown key", "unknown kind", "unknown name", "is missing; add it", "this must be"];
        let Some(content) = content(&file).filter(|_| of_form.iter().any(|words| message.contains(words))) else {
            continue;
        };
        if kind_of(&content) == Some("study") {
            continue;
        }
        checked += 1;
        if scenes.is_valid(&content) {
            accepted.push(format!("{}: {message}", file.display()));
        }
    }
    assert!(checked > 10, "{checked}");
    assert!(accepted.is_empty(), "{}", accepted.join("\n"));
}

fn read_scene(text: &str) -> Result<(), SceneError> {
    SceneSpec::from_text(Path::new("scene.toml"), text, "").map(|_| ())
}

fn read_study(text: &str) -> Result<(), SceneError> {
    study_file::parse(Path::new("study.toml"), text, StudyScope::Whole).map(|_| ())
}

/// Compares the keys of one table with those of the reader. Returns what is wrong.
fn compare(object: &Object, read: fn(&str) -> Result<(), SceneError>) -> Option<String> {
    const UNKNOWN: &str = "zzz";
    let text = |content: &Value| toml::to_string(content).expect("tables, lists, texts and numbers");
    let full = text(&object.with_all_keys());
    if let Err(error @ SceneError::Syntax { .. }) = read(&full) {
        return Some(format!("{}: a key of the schema is refused: {error}\n{full}", object.name));
    }
    let message = match read(&text(&object.with_key(UNKNOWN, json!(1)))) {
        Err(SceneError::Syntax { mistake, .. }) => mistake.what,
        other => return Some(format!("{}: an unknown key is not refused as such: {other:?}", object.name)),
    };
    let Some((_, known)) = message.split_once("unknown key `zzz`; ") else {
        return Some(format!("{}: the unknown key is not what is refused: {message}", object.name));
    };
    let known = known.split("known: ").nth(1).unwrap_or_default();
    let known: BTreeSet<&str> = known.split([',', ')', ' ']).filter(|k| !k.is_empty()).collect();
    let own: BTreeSet<&str> = object.keys.iter().map(String::as_str).collect();
    // The keys that every study has are read apart from those of its kind
    let common = |key: &&&str| object.name.starts_with('|') && COMMON_KEYS.contains(key);
    let extra: Vec<_> = known.difference(&own).chain(own.difference(&known)).filter(|key| !common(key)).collect();
    (!extra.is_empty()).then(|| format!("{}: only the reader or the schema knows {extra:?}: {message}", object.name))
}

/// Every table that a schema describes, within a file of examples, is read with all of its keys, and the reader lists the same keys where one
/// is unknown.
#[test]
fn the_keys_of_schema_and_reader_are_the_same() {
    for (schema, read, least) in
        [(schema::scene(), read_scene as fn(&str) -> Result<(), SceneError>, 80), (schema::study(), read_study, 25)]
    {
        let all = objects(schema.as_value());
        let wrong: Vec<String> = all.iter().filter_map(|object| compare(object, read)).collect();
        assert!(all.len() > least, "{}", all.len());
        assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), all.len(), wrong.join("\n"));
    }
}

#[test]
fn a_law_takes_the_keys_of_its_schema_and_no_other() {
    let schema = schema::scene();
    let tables = schema.pointer("/$defs/LawTable/oneOf").and_then(Value::as_array).expect("a table for each law");
    for (entry, table) in durometer::material::LAWS.iter().zip(tables) {
        let keys = table["properties"].as_object().expect("keys");
        assert_eq!(keys["law"]["const"], entry.info.name);
        for key in keys.keys().chain([&"zzz".to_string()]) {
            let mut given = entry.example_table();
            given.insert(key.clone(), toml::Value::Boolean(true));
            let error = law_from_table(&given).map(|_| ()).map_err(|e| e.to_string());
            let refused = error.as_ref().is_err_and(|e| e.contains("has no parameter"));
            assert_eq!(refused, key == "zzz", "{}: {key}: {error:?}", entry.info.name);
        }
    }
}

/// What an editor shows is a sentence, and quantities show how they are written.
#[test]
fn every_key_has_a_description() {
    for described in schema::SCHEMAS {
        let schema = (described.schema)();
        let mut silent = Vec::new();
        parts::each_part(schema.as_value(), &mut |name, key| {
            if !name.rsplit_once('/').is_some_and(|(table, _)| table.ends_with("/properties")) {
                return;
            }
            let text = key["description"].as_str().unwrap_or_default();
            let is_sentence =
                text.ends_with('.') && text.starts_with(|c: char| !c.is_lowercase()) && !text.contains("\\");
            if !(is_sentence || key.get("const").is_some()) {
                silent.push(format!("{name}: {text:?}"));
            }
        });
        assert!(silent.is_empty(), "{}: {} keys:\n{}", described.name, silent.len(), silent.join("\n"));
    }
    let scene = schema::scene();
    let size = scene.pointer("/$defs/MeshSpec/properties/size/description");
    assert_eq!(size, Some(&json!("Edge length. Write for example \"1 mm\".")));
}
