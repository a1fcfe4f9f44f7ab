//! Changes to a scene by path: `mesh.cells=9300`, `constraint.cable.drive={ kind = "tension", signal = "8 N" }`, and new
//! entries at the end of a list: `effect.+={ kind = "gravity", … }`.

use crate::scene::error::hint;
use crate::wording::first;
use toml::{Table, Value};

/// Reason why a change by path cannot be applied.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OverrideError {
    #[error("\"{text}\" is not of the form key=value; write for example --set mesh.cells=9300")]
    Form { text: String },
    #[error("\"{text}\" holds more than one key; give each of them in a --set of its own")]
    Several { text: String },
    #[error("a path of {steps} steps; no key of a scene lies deeper than {DEEPEST}")]
    Deep { steps: usize },
    #[error("\"{path}\" leads nowhere: there is no \"{step}\"; {hint}")]
    NoSuchKey { path: String, step: String, hint: String },
    #[error(
        "\"{path}\" is not clear: {} entries are called \"{step}\" and have other values there; write the number of one of them in its place: {}",
        found.len(),
        listed(found)
    )]
    Ambiguous { path: String, step: String, found: Vec<usize> },
}

fn listed(numbers: &[usize]) -> String {
    first(&numbers.iter().map(usize::to_string).collect::<Vec<_>>())
}

/// Splits `key=value`; the value is TOML, or otherwise a plain string.
///
/// # Errors
///
/// [`OverrideError::Form`] for a text without `=`.
pub fn parse(text: &str) -> Result<(String, Value), OverrideError> {
    let (path, value) = text.split_once('=').ok_or_else(|| OverrideError::Form { text: text.into() })?;
    let mut table = format!("v = {value}").parse::<Table>().unwrap_or_default();
    let parsed = table.remove("v");
    if !table.is_empty() {
        return Err(OverrideError::Several { text: text.into() });
    }
    Ok((path.trim().into(), parsed.unwrap_or_else(|| Value::String(value.trim().into()))))
}

/// Largest number of steps of a path.
const DEEPEST: usize = 16;

/// Lists of a scene, to which entries can be added.
const LISTS: [&str; 7] = ["effect", "constraint", "stage", "probe", "skin", "contact", "rigid"];

/// Tables that may be absent from a scene and can be created by a change.
const OPTIONAL: [&str; 3] = ["mesh", "numerics", "output"];

/// Sets the value at a dotted path. A step into a list is an index, or the `name` or `kind` of an entry: `direction.2`, `guides.0.1`. A kind that several
/// entries have refers to all of them, which must have the same value there. Only the last key may be new; at and below `mesh`, `numerics` and `output` also
/// the tables in between, whose keys the reader checks. The step `+` of a list adds an entry, or a list of entries, at its end.
///
/// # Errors
///
/// Where the path leads nowhere, refers to entries with different values, or has too many steps.
pub fn apply(table: &mut Table, path: &str, value: Value) -> Result<(), OverrideError> {
    let steps = steps(path)?;
    if let [list, "+"] = steps[..]
        && LISTS.contains(&list)
    {
        let entries = table.entry(list).or_insert_with(|| Value::Array(vec![]));
        let more = if let Value::Array(more) = value { more } else { vec![value] };
        // A value that is not a list is refused by the reader of the scene
        entries.as_array_mut().into_iter().for_each(|entries| entries.extend(more.iter().cloned()));
        return Ok(());
    }
    let mut whole = Value::Table(std::mem::take(table));
    let place = Place { path, may_be_new: OPTIONAL.contains(&steps[0]) };
    let set = place.set(&mut whole, &steps, value);
    if let Value::Table(changed) = whole {
        *table = changed;
    }
    set
}

/// The place at which a value is set.
struct Place<'a> {
    path: &'a str,
    may_be_new: bool,
}

impl Place<'_> {
    fn set(&self, current: &mut Value, steps: &[&str], value: Value) -> Result<(), OverrideError> {
        let (step, rest) = steps.split_first().expect("split yields at least one part");
        let next = match current {
            Value::Table(inner) if rest.is_empty() => {
                inner.insert((*step).into(), value);
                return Ok(());
            }
            Value::Table(inner) => {
                if !inner.contains_key(*step) && self.may_be_new {
                    inner.insert((*step).into(), Value::Table(Table::new()));
                }
                let known: Vec<String> = inner.keys().cloned().collect();
                let next = inner.get_mut(*step).filter(|next| next.is_table() || next.is_array());
                next.ok_or_else(|| missing(self.path, step, &known))?
            }
            Value::Array(entries) => {
                let fitting = fitting(entries, step, rest, self.path)?;
                if fitting.is_empty() {
                    return Err(missing(self.path, step, &labels(entries)));
                }
                for k in fitting {
                    match rest.is_empty() {
                        true => entries[k] = value.clone(),
                        false => self.set(&mut entries[k], rest, value.clone())?,
                    }
                }
                return Ok(());
            }
            _ => return Err(missing(self.path, step, &[])),
        };
        self.set(next, rest, value)
    }
}

/// The value at a dotted path, which is interpreted as by [`apply`].
///
/// # Errors
///
/// Where the path leads nowhere, refers to entries with different values, or has too many steps.
pub fn find<'a>(table: &'a Table, path: &str) -> Result<&'a Value, OverrideError> {
    let steps = steps(path)?;
    let (first, rest) = steps.split_first().expect("split yields at least one part");
    let known = |table: &Table| table.keys().cloned().collect::<Vec<String>>();
    let mut current = table.get(*first).ok_or_else(|| missing(path, first, &known(table)))?;
    for (k, step) in rest.iter().enumerate() {
        current = match current {
            Value::Table(inner) => inner.get(*step).ok_or_else(|| missing(path, step, &known(inner))),
            Value::Array(entries) => {
                let fitting = fitting(entries, step, &rest[k + 1..], path)?;
                fitting.first().map(|k| &entries[*k]).ok_or_else(|| missing(path, step, &labels(entries)))
            }
            _ => Err(missing(path, step, &[])),
        }?;
    }
    Ok(current)
}

/// Whether a change at the path `later` undoes an earlier one at `path`, however both are written, because it replaces the value or a table around it.
pub fn undoes(table: &Table, later: &str, path: &str) -> bool {
    let (mut changed, mark) = (table.clone(), Value::Integer(1));
    // If only one of several entries gets another value, the change remains in the others
    let is_there = |changed: &Table| match find(changed, path) {
        Ok(value) => *value == mark,
        Err(e) => matches!(e, OverrideError::Ambiguous { .. }),
    };
    let made = apply(&mut changed, path, mark.clone()).is_ok() && is_there(&changed);
    made && apply(&mut changed, later, Value::Integer(2)).is_ok() && !is_there(&changed)
}

/// The indices of the entries of a top-level list to which a path leads; empty if it leads elsewhere.
pub fn entries_of(table: &Table, path: &str) -> Vec<usize> {
    let mut steps = path.split('.');
    let list = steps.next().and_then(|list| table.get(list)?.as_array());
    list.zip(steps.next()).map_or(vec![], |(entries, step)| called(entries, step))
}

fn steps(path: &str) -> Result<Vec<&str>, OverrideError> {
    let steps: Vec<&str> = path.split('.').collect();
    if steps.len() > DEEPEST { Err(OverrideError::Deep { steps: steps.len() }) } else { Ok(steps) }
}

fn missing(path: &str, step: &str, known: &[String]) -> OverrideError {
    OverrideError::NoSuchKey { path: path.into(), step: step.into(), hint: hint(step, known) }
}

/// The entries of a list with this number, name or kind.
fn called(entries: &[Value], step: &str) -> Vec<usize> {
    match step.parse() {
        Ok(number) => Some(number).into_iter().filter(|k| *k < entries.len()).collect(),
        Err(_) => (0..entries.len()).filter(|k| label(&entries[*k]) == Some(step)).collect(),
    }
}

/// The entries of a list to which a step refers; several if they have the same value at the `rest` of the path, or none of them has a value there.
fn fitting(entries: &[Value], step: &str, rest: &[&str], path: &str) -> Result<Vec<usize>, OverrideError> {
    let found = called(entries, step);
    let there = |k: &usize| at(&entries[*k], rest);
    match found.windows(2).all(|pair| !rest.is_empty() && there(&pair[0]) == there(&pair[1])) {
        true => Ok(found),
        false => Err(OverrideError::Ambiguous { path: path.into(), step: step.into(), found }),
    }
}

/// The value at a path below another value.
fn at<'a>(value: &'a Value, steps: &[&str]) -> Option<&'a Value> {
    let Some((step, rest)) = steps.split_first() else { return Some(value) };
    let next = match value {
        Value::Table(inner) => inner.get(*step),
        Value::Array(entries) => called(entries, step).first().map(|k| &entries[*k]),
        _ => None,
    };
    at(next?, rest)
}

/// Names of the entries of a list, or their indices.
fn labels(entries: &[Value]) -> Vec<String> {
    let name = |(k, entry): (usize, &Value)| label(entry).map_or_else(|| k.to_string(), String::from);
    entries.iter().enumerate().map(name).collect()
}

/// The name or kind of an entry; a cable of a file of guides has its name from the file.
fn label(entry: &Value) -> Option<&str> {
    let get = |key: &str| entry.get(key).and_then(Value::as_str);
    let in_file = entry.get("guides").and_then(|guides| guides.get("cable")).and_then(Value::as_str);
    in_file.or(get("name")).or(get("kind"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_after_a_value_is_refused() {
        assert!(matches!(parse("mesh.cells=9300\nfoo = 3"), Err(OverrideError::Several { .. })));
        assert!(matches!(parse("mesh.cells = 9300"), Ok((path, Value::Integer(9300))) if path == "mesh.cells"));
    }

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
            "\"constraint.tendon.drive\" leads nowhere: there is no \"tendon\"; known: fixed, cable"
        );
        assert!(parse("mesh.cells").is_err());
        let deep = apply(&mut table, &["mesh"; 100_000].join("."), Value::Integer(1)).expect_err("too deep");
        assert_eq!(deep, OverrideError::Deep { steps: 100_000 });
        let (path, value) = parse("constraint.+=[{kind=\"fixed\"}, {kind=\"cavity\"}]").expect("key=value");
        apply(&mut table, &path, value).expect("a list takes more");
        let (path, value) = parse("constraint.fixed.region=tip").expect("key=value");
        let several = "\"constraint.fixed.region\" is not clear: 2 entries are called \"fixed\" and have other values there; \
                       write the number of one of them in its place: 0, 2";
        assert_eq!(apply(&mut table, &path, value.clone()).expect_err("two").to_string(), several);
        assert_eq!(find(&table, &path).expect_err("two").to_string(), several);
        assert_eq!(find(&table, "constraint.0.region").expect("one").as_str(), Some("root"));
        // All entries that have the same value there, or none
        apply(&mut table, "constraint.fixed.components", "x".into()).expect("none has components");
        apply(&mut table, "constraint.fixed.components", "yz".into()).expect("both have the same");
        assert_eq!([0, 2].map(|k| table["constraint"][k]["components"].as_str()), [Some("yz"); 2]);
        assert_eq!(entries_of(&table, "constraint.fixed.components"), [0, 2]);
        apply(&mut table, "probe.+", Value::Table(Table::new())).expect("a list may be new");
        assert_eq!(table["constraint"].as_array().map(Vec::len), Some(4));
        assert_eq!(table["constraint"][3]["kind"].as_str(), Some("cavity"));
        assert_eq!(table["probe"].as_array().map(Vec::len), Some(1));
        assert!(apply(&mut table, "mesh.cells.+", Value::Integer(1)).is_err(), "no list");
        let gravity = "direction = [0, 0, -1]\nguides = [[\"1 mm\", \"2 mm\"]]".parse().expect("valid TOML");
        table.insert("load".into(), Value::Table(gravity));
        apply(&mut table, "load.direction.2", Value::Float(-0.5)).expect("an entry of a list");
        apply(&mut table, "load.guides.0.1", Value::String("3 mm".into())).expect("an entry of a list in a list");
        assert_eq!(find(&table, "load.direction.2").expect("there").as_float(), Some(-0.5));
        assert_eq!(find(&table, "load.guides.0.1").expect("there").as_str(), Some("3 mm"));
        let error = apply(&mut table, "load.direction.3", Value::Float(0.0)).expect_err("three entries");
        assert_eq!(error.to_string(), "\"load.direction.3\" leads nowhere: there is no \"3\"; known: 0, 1, 2");
        apply(&mut table, "numerics.cuts", Value::Integer(3)).expect("a table of the scene may be new");
        assert_eq!(table["numerics"]["cuts"].as_integer(), Some(3));
        apply(&mut table, "output.fields.what", vec!["displacement"].into()).expect("and the tables in between");
        assert_eq!(table["output"]["fields"]["what"][0].as_str(), Some("displacement"));
        table.insert("laws".into(), "rubber = {}".parse::<Table>().expect("valid TOML").into());
        let error = apply(&mut table, "laws.ruber.nu", Value::Float(0.4)).expect_err("no such law");
        assert!(
            error.to_string().ends_with("there is no \"ruber\"; did you mean `rubber`? (known: rubber)"),
            "{error}"
        );
    }

    /// The same path in any spelling, and a table around it, undo a change; paths next to it or below it and new entries do not.
    #[test]
    fn a_change_is_undone_at_its_place_or_around_it() {
        let text = "[laws.rubber]\nE = 1\nnu = 2\n[[effect]]\nkind = \"elastic\"\n[[effect]]\nkind = \"gravity\"\ndensity = 1\n";
        let two = format!("{text}[[effect]]\nkind = \"gravity\"\ndensity = 1\n");
        for (text, path, later, expected) in [
            (text, "laws.rubber.E", "laws.rubber.E", true),
            (text, "laws.rubber.E", "laws.rubber", true),
            (text, "laws.rubber", "laws.rubber.E", false),
            (text, "laws.rubber.E", "laws.rubber.nu", false),
            (text, "effect.gravity.density", "effect.1.density", true),
            (text, "effect.1.density", "effect.gravity.density", true),
            (text, "effect.1.density", "effect", true),
            (text, "effect.+", "effect.gravity.density", false),
            (text, "effect.+", "effect.+", false),
            (text, "laws.ruber.E", "laws.ruber.E", false),
            (&two, "effect.gravity.density", "effect.1.density", false),
            (&two, "effect.gravity.density", "effect.gravity.density", true),
        ] {
            let table = text.parse().expect("valid TOML");
            assert_eq!(undoes(&table, later, path), expected, "{path}, {later}");
        }
    }

    /// A cable that is taken from a file of guides has its name from the file; a list of guides has none.
    #[test]
    fn a_cable_of_a_file_is_known_by_its_name_there() {
        let entry = |more: &str| format!("[[constraint]]\nkind = \"cable\"\n{more}\n");
        let of_file =
            |cable: &str| entry(&format!("guides = {{ file = \"guides.csv\", unit = \"mm\", cable = \"{cable}\" }}"));
        let text = [of_file("north"), of_file("south"), entry("guides = [[\"1 mm\", \"2 mm\", \"3 mm\"]]")].concat();
        let mut table: Table = text.parse().expect("valid TOML");
        apply(&mut table, "constraint.south.EA", Value::String("9 N".into())).expect("the cable of the file");
        apply(&mut table, "constraint.cable.EA", Value::String("7 N".into())).expect("the cable with a list");
        let stiffness = |k: usize| table["constraint"][k].get("EA").and_then(Value::as_str);
        assert_eq!([0, 1, 2].map(stiffness), [None, Some("9 N"), Some("7 N")]);
    }
}
