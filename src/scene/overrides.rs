//! Changes to a scene by path: `mesh.cells=9300`, `constraint.cable.drive={ kind = "tension", signal = "8 N" }`, and new
//! entries at the end of a list: `effect.+={ kind = "gravity", … }`.

use super::error::hint;
use toml::{Table, Value};

/// A path that leads nowhere.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OverrideError {
    #[error("\"{text}\" is not of the form key=value; write for example --set mesh.cells=9300")]
    Form { text: String },
    #[error("a path of {steps} steps; no key of a scene lies deeper than {DEEPEST}")]
    Deep { steps: usize },
    #[error("\"{path}\" changes nothing: there is no \"{step}\"; {hint}")]
    NoSuchKey { path: String, step: String, hint: String },
}

/// Splits `key=value`; the value is TOML, or else a plain string.
pub fn parse(text: &str) -> Result<(String, Value), OverrideError> {
    let (path, value) = text.split_once('=').ok_or_else(|| OverrideError::Form { text: text.into() })?;
    let parsed = format!("v = {value}").parse::<Table>().ok().and_then(|mut t| t.remove("v"));
    Ok((path.trim().into(), parsed.unwrap_or_else(|| Value::String(value.trim().into()))))
}

/// Most steps of a path.
const DEEPEST: usize = 16;

/// Lists of a scene, to which entries can be added.
const LISTS: [&str; 7] = ["effect", "constraint", "stage", "probe", "skin", "contact", "rigid"];

/// Tables of a scene that may be absent from it: a change may make them.
const OPTIONAL: [&str; 2] = ["mesh", "numerics"];

/// Sets the value at a dotted path. In an array of tables a step is an index, or the `name` or `kind` of an entry. Only the
/// last key may be new; below `mesh` and at `numerics` also the tables in between, whose keys the reader checks. The step `+`
/// of a list adds an entry, or a list of them, at its end.
pub fn apply(table: &mut Table, path: &str, value: Value) -> Result<(), OverrideError> {
    let steps: Vec<&str> = path.split('.').collect();
    if steps.len() > DEEPEST {
        return Err(OverrideError::Deep { steps: steps.len() });
    }
    let (last, before) = steps.split_last().expect("split yields at least one part");
    if let [list, "+"] = steps[..]
        && LISTS.contains(&list)
    {
        let entries = table.entry(list).or_insert_with(|| Value::Array(vec![]));
        let more = if let Value::Array(more) = value { more } else { vec![value] };
        // A value that is no list is refused by the reader of the scene
        entries.as_array_mut().into_iter().for_each(|entries| entries.extend(more.iter().cloned()));
        return Ok(());
    }
    let may_be_new = OPTIONAL.contains(&steps[0]);
    let mut current = table;
    let mut steps = before.iter();
    while let Some(step) = steps.next() {
        let missing = |step: &str, known: &[&str]| OverrideError::NoSuchKey {
            path: path.into(),
            step: step.into(),
            hint: hint(step, known),
        };
        let known: Vec<String> = current.keys().cloned().collect();
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        if !current.contains_key(*step) && may_be_new {
            current.insert((*step).into(), Value::Table(Table::new()));
        }
        current = match current.get_mut(*step) {
            Some(Value::Table(inner)) => inner,
            Some(Value::Array(entries)) => {
                let names: Vec<String> = entries.iter().filter_map(label).map(String::from).collect();
                let names: Vec<&str> = names.iter().map(String::as_str).collect();
                let which = steps.next().ok_or_else(|| missing(&format!("{step}.?"), &names))?;
                let index = which.parse().ok().or_else(|| entries.iter().position(|e| label(e) == Some(*which)));
                let entry = index.and_then(|k: usize| entries.get_mut(k)).and_then(Value::as_table_mut);
                entry.ok_or_else(|| missing(which, &names))?
            }
            Some(_) | None => return Err(missing(step, &known)),
        };
    }
    current.insert((*last).into(), value);
    Ok(())
}

/// The value at a dotted path, as [`apply`] goes it.
pub fn find<'a>(table: &'a Table, path: &str) -> Option<&'a Value> {
    let mut steps = path.split('.');
    let mut current = table.get(steps.next()?)?;
    for step in steps {
        current = match current {
            Value::Table(inner) => inner.get(step)?,
            Value::Array(entries) => {
                let index = step.parse().ok().or_else(|| entries.iter().position(|e| label(e) == Some(step)))?;
                entries.get(index)?
            }
            _ => return None,
        };
    }
    Some(current)
}

fn label(entry: &Value) -> Option<&str> {
    let get = |key: &str| entry.get(key).and_then(Value::as_str);
    get("name").or(get("kind"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_by_path_and_names_what_is_known() {
        let mut table: Table =
            "[mesh]\ncells = 1\n[[constraint]]\nkind = \"fixed\"\n[[constraint]]\nkind = \"cable\"\n"
                .parse()
                .expect("valid TOML");
        for text in [
            "mesh.cells=9300",
            "constraint.cable.drive={ kind = \"tension\", signal = \"8 N\" }",
            "constraint.0.region=root",
        ] {
            let (path, value) = parse(text).expect("key=value");
            apply(&mut table, &path, value).expect("the path exists");
        }
        assert_eq!(table["mesh"]["cells"].as_integer(), Some(9300));
        assert_eq!(table["constraint"][1]["drive"]["signal"].as_str(), Some("8 N"));
        assert_eq!(table["constraint"][0]["region"].as_str(), Some("root"));
        let error = apply(&mut table, "constraint.tendon.drive", Value::Integer(1)).expect_err("no such constraint");
        assert_eq!(
            error.to_string(),
            "\"constraint.tendon.drive\" changes nothing: there is no \"tendon\"; known: fixed, cable"
        );
        assert!(parse("mesh.cells").is_err());
        let deep = apply(&mut table, &["mesh"; 100_000].join("."), Value::Integer(1)).expect_err("too deep");
        assert_eq!(deep, OverrideError::Deep { steps: 100_000 });
        let (path, value) = parse("constraint.+=[{kind=\"fixed\"}, {kind=\"cavity\"}]").expect("key=value");
        apply(&mut table, &path, value).expect("a list takes more");
        apply(&mut table, "probe.+", Value::Table(Table::new())).expect("a list may be new");
        assert_eq!(table["constraint"].as_array().map(Vec::len), Some(4));
        assert_eq!(table["constraint"][3]["kind"].as_str(), Some("cavity"));
        assert_eq!(table["probe"].as_array().map(Vec::len), Some(1));
        assert!(apply(&mut table, "mesh.cells.+", Value::Integer(1)).is_err(), "no list");
        apply(&mut table, "numerics.cuts", Value::Integer(3)).expect("a table of the scene may be new");
        assert_eq!(table["numerics"]["cuts"].as_integer(), Some(3));
        table.insert("laws".into(), "rubber = {}".parse::<Table>().expect("valid TOML").into());
        let error = apply(&mut table, "laws.ruber.nu", Value::Float(0.4)).expect_err("no such law");
        assert!(
            error.to_string().ends_with("there is no \"ruber\"; did you mean `rubber`? (known: rubber)"),
            "{error}"
        );
    }
}
