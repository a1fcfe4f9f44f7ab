//! From text to a [`SceneSpec`]: every mistake is reported with its line, its table and the nearest known key.

use super::error::{Line, Mistake, SceneError, explain, part};
use super::spec::SceneSpec;
use super::text::overrides;
use super::text::reader::Reader;
use crate::material::{KnownLaws, LawSpecError};
use crate::mesh::format::recognise;
use crate::storage::{self, TEXT_LIMIT};
use serde::de::DeserializeOwned;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

/// Reads a scene file, applies changes, and replaces included laws and constants of effects by their contents, so that the returned text is complete. A change
/// is a path with its value, which [`overrides::parse`] reads from `key=value`; a [`SceneBuilder`](super::SceneBuilder) takes it by `set`.
///
/// # Errors
///
/// Where the file cannot be read or is not a valid scene, with line and remedy; where a change leads nowhere, or the changed scene is refused.
pub fn read_scene(file: &Path, changes: &[(String, toml::Value)]) -> Result<(SceneSpec, String), SceneError> {
    let (text, _) = read_table(file)?;
    changed_scene(file, &text, changes, &KnownLaws::default())
}

/// Applies changes to the text of a scene, which keeps these laws; paths in it are relative to the folder of `file`.
///
/// # Errors
///
/// Fails as [`read_scene`] does.
pub fn changed_scene(
    file: &Path,
    text: &str,
    changes: &[(String, toml::Value)],
    known_laws: &KnownLaws,
) -> Result<(SceneSpec, String), SceneError> {
    let mut table: toml::Table = text.parse().map_err(|e| syntax(file, text, "", &e))?;
    if is_study(&table) {
        let scene = table.get("scene").and_then(toml::Value::as_str).map(|scene| file.with_file_name(scene));
        let scene = scene.map_or(String::new(), |scene| format!(", or give its scene, {}", scene.display()));
        let remedy = format!("run it with: durometer run {}{scene}", file.display());
        return Err(content(file, "file", "this is a study, not a scene", &remedy));
    }
    // Errors of the file itself are reported with their line.
    from_text::<SceneSpec>(file, text, "")?;
    for (path, value) in changes {
        overrides::apply(&mut table, path, value.clone()).map_err(|e| part(file, "change", e))?;
    }
    let base = file.parent().unwrap_or(Path::new(""));
    for (name, law) in table.get_mut("laws").and_then(toml::Value::as_table_mut).into_iter().flatten() {
        let Some(law) = law.as_table_mut() else { continue };
        if let Some(include) = law.remove("include") {
            let place = format!("laws.{name}");
            let Some(include) = include.as_str() else {
                return Err(content(file, &place, "`include` is not a file name", "write include = \"law.toml\""));
            };
            let (_, mut included) = read_table(&base.join(include)).map_err(|e| part(file, place, e))?;
            included.extend(std::mem::take(law));
            *law = included;
        }
        law.get_mut("provenance").into_iter().for_each(spell_open_ends);
    }
    changes.iter().try_for_each(|(path, _)| check_constants(file, &table, path, known_laws))?;
    include_in_effects(file, base, &mut table)?;
    let text = toml::to_string(&table).expect("a table that was read can be written");
    let names: Vec<&str> = changes.iter().map(|c| c.0.as_str()).collect();
    let origin = match &names[..] {
        [] => "with the files that it includes".into(),
        names => format!("with the changes {}", names.join(", ")),
    };
    let read: SceneSpec = from_text(file, &text, &origin)?;
    Ok((SceneSpec { known_laws: known_laws.clone(), ..read }, text))
}

/// Refuses a change of a law by a key that the law does not have; if the whole law is replaced, all its keys are checked. Which keys may be combined is
/// checked when the law is built.
fn check_constants(file: &Path, table: &toml::Table, path: &str, known_laws: &KnownLaws) -> Result<(), SceneError> {
    let mut steps = path.split('.');
    let (Some("laws"), Some(name)) = (steps.next(), steps.next()) else { return Ok(()) };
    let law = table.get("laws").and_then(|laws| laws.get(name)?.as_table());
    let Some(law) = law else { return Ok(()) };
    let key = steps.next();
    let changed = law.iter().filter(|(own, _)| *own == "law" || key.is_none_or(|key| *own == key));
    match known_laws.given(&changed.map(|(key, value)| (key.clone(), value.clone())).collect()) {
        Err(why @ LawSpecError::UnknownKey { .. }) => Err(part(file, format!("laws.{name}"), why)),
        _ => Ok(()),
    }
}

/// Writes open ends of intervals as text, because numbers in a scene are finite.
fn spell_open_ends(provenance: &mut toml::Value) {
    match provenance {
        toml::Value::Float(end) if end.is_infinite() => *provenance = end.to_string().into(),
        toml::Value::Array(all) => all.iter_mut().for_each(spell_open_ends),
        toml::Value::Table(all) => all.iter_mut().for_each(|(_, value)| spell_open_ends(value)),
        _ => {}
    }
}

/// Replaces every `key = { include = "file.toml" }` of an effect by the value of the same key in the file; keys next to `include` take precedence.
fn include_in_effects(file: &Path, base: &Path, table: &mut toml::Table) -> Result<(), SceneError> {
    let effects = table.get_mut("effect").and_then(toml::Value::as_array_mut).into_iter().flatten();
    for (k, effect) in effects.enumerate().filter_map(|(k, e)| Some((k, e.as_table_mut()?))) {
        for (key, value) in effect.iter_mut() {
            let Some(mut own) = value.as_table().cloned() else { continue };
            let Some(toml::Value::String(name)) = own.remove("include") else { continue };
            let place = format!("effect {}", k + 1);
            let (_, mut included) = read_table(&base.join(&name)).map_err(|e| part(file, place.clone(), e))?;
            let refuse = |fact: String, remedy| content(file, &place, &fact, remedy);
            let remedy = "include a file that a fit has written for this effect";
            let mut found = included.remove(key).ok_or_else(|| refuse(format!("{name} has no `{key}`"), remedy))?;
            match found.as_table_mut() {
                Some(constants) => constants.extend(own),
                None if own.is_empty() => {}
                None => {
                    let fact = format!("`{key}` of {name} has no keys, and some are given next to `include`");
                    return Err(refuse(fact, "leave them out"));
                }
            }
            *value = found;
        }
    }
    Ok(())
}

fn content(file: &Path, place: &str, fact: &str, remedy: &str) -> SceneError {
    SceneError::Content { file: file.into(), place: place.into(), fact: fact.into(), remedy: remedy.into() }
}

/// Whether a table is that of a study, recognised by keys that no scene has.
pub fn is_study(table: &toml::Table) -> bool {
    ["scene", "family"].iter().any(|key| table.contains_key(*key))
}

/// The value at a path of a scene with changes, as in its file; `None` if there is none.
pub fn value_in(file: &Path, changes: &[(String, toml::Value)], path: &str) -> Option<toml::Value> {
    let (_, mut table) = read_table(file).ok()?;
    changes.iter().try_for_each(|(path, value)| overrides::apply(&mut table, path, value.clone())).ok()?;
    overrides::find(&table, path).ok().cloned()
}

/// Text and table of a TOML file.
///
/// # Errors
///
/// Where the file cannot be read, is not text, or is not valid TOML.
pub fn read_table(file: &Path) -> Result<(String, toml::Table), SceneError> {
    let unreadable = |e: std::io::Error| SceneError::Unreadable { file: file.into(), reason: e.to_string() };
    let bytes = storage::read(file, TEXT_LIMIT).map_err(unreadable)?;
    let text = String::from_utf8(bytes).map_err(|e| {
        let place = format!("byte {}", e.utf8_error().valid_up_to());
        mesh_instead(file)
            .unwrap_or_else(|| content(file, &place, "this is no text in UTF-8", "save the file as UTF-8"))
    })?;
    match text.parse() {
        Ok(table) => Ok((text, table)),
        Err(e) => Err(mesh_instead(file).unwrap_or_else(|| syntax(file, &text, "", &e))),
    }
}

/// The refusal of a mesh file that was given instead of a scene.
fn mesh_instead(file: &Path) -> Option<SceneError> {
    let format = recognise(file).ok()?;
    let fact = format!("this is a mesh or a body ({}), not a scene", format.name);
    let remedy =
        format!("`durometer import {}` says what it holds, and writes a scene for it with --scene", file.display());
    Some(content(file, "file", &fact, &remedy))
}

impl SceneSpec {
    /// Reads a scene from its text, with the laws in the text itself. `origin` states how the text differs from the file, if it does.
    ///
    /// # Errors
    ///
    /// Where the text is not a valid scene, with the line and the nearest known key.
    pub fn from_text(file: &Path, text: &str, origin: &str) -> Result<Self, SceneError> {
        from_text(file, text, origin)
    }
}

/// Reads a typed value from TOML. Private to this crate: every crate that calls it would compile the reader of all types below T again.
pub(crate) fn from_text<T: DeserializeOwned>(file: &Path, text: &str, origin: &str) -> Result<T, SceneError> {
    let table = DeTable::parse(text).map_err(|e| syntax(file, text, origin, &e))?;
    let entries = entries(table.get_ref());
    T::deserialize(Reader::from(table)).map_err(|e| {
        let at = e.span.as_ref().map_or(0, |s| s.start);
        let place = entries.iter().filter(|(start, _)| *start <= at).max_by_key(|e| e.0);
        mistake(file, text, origin, (&e.message, e.span), place.and_then(|p| p.1.clone()))
    })
}

/// The refusal of a text that is not valid TOML.
fn syntax(file: &Path, text: &str, origin: &str, error: &toml::de::Error) -> SceneError {
    mistake(file, text, origin, (error.message(), error.span()), None)
}

fn mistake(
    file: &Path,
    text: &str,
    origin: &str,
    (message, span): (&str, Option<Range<usize>>),
    place: Option<String>,
) -> SceneError {
    let line = span.map(|span| Line::of(text, span));
    let mistake = Mistake { origin: origin.into(), line, place, what: explain(message) };
    SceneError::Syntax { file: file.into(), mistake: Box::new(mistake) }
}

/// The start of each top-level key and of each entry of an array of tables, with the name of an entry.
fn entries(table: &DeTable) -> Vec<(usize, Option<String>)> {
    let mut starts = Vec::new();
    for (key, value) in table {
        let DeValue::Array(list) = value.get_ref() else {
            starts.push((start(key, value), None));
            tables_below(value.get_ref(), &mut starts);
            continue;
        };
        for (k, entry) in list.iter().enumerate() {
            let label = ["name", "kind"].iter().find_map(|key| entry.get_ref().get(*key)?.get_ref().as_str());
            let label = label.map_or_else(String::new, |l| format!(" ({l})"));
            starts.push((entry.span().start, Some(format!("{} {}{label}", key.get_ref(), k + 1))));
        }
    }
    starts
}

/// Adds the tables below a top-level key, which may be anywhere in the file, each under its own header.
fn tables_below(value: &DeValue, starts: &mut Vec<(usize, Option<String>)>) {
    let DeValue::Table(table) = value else { return };
    for (key, value) in table {
        starts.push((start(key, value), None));
        tables_below(value.get_ref(), starts);
    }
}

/// The start of a key with its value; for a table with a header, that of the bracket of the header, at which its missing keys are reported.
fn start(key: &Spanned<DeString>, value: &Spanned<DeValue>) -> usize {
    key.span().start.min(value.span().start)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::SceneSpec;

    const SCENE: &str =
        "[mesh]\nbody = \"finger\"\n\n[[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n\n";

    fn refusal(entries: &str) -> String {
        let text = format!("{SCENE}{entries}");
        from_text::<SceneSpec>(Path::new("s.toml"), &text, "").expect_err(entries).to_string()
    }

    #[test]
    fn a_mistake_is_found_in_its_table_and_line() {
        for (entries, says) in [
            (
                "[[probe]]\nkind = \"energy\"\n[[probe]]\nkind = \"energy\"\nregion = \"tip\"",
                "s.toml, line 13: probe 2 (energy): unknown key `region`",
            ),
            (
                "[[probe]]\nkind = \"energy\"\n[output.fields]\nevery = \"1 s\"",
                "s.toml, line 11: the key `what` is missing; add it",
            ),
            (
                "[[probe]]\nregion = \"tip\"",
                "s.toml, line 9: probe 1: it has no `kind`; add kind = \"…\" with one of bending_angle",
            ),
            (
                "[[probe]]\nkind = 3\nregion = \"tip\"",
                "s.toml, line 10: probe 1: integer `3`; this must be the name of a kind",
            ),
            (
                "[[effect]]\nkind = \"elastic\"\nregion = \"body\"",
                "s.toml, line 9: effect 1 (elastic): the key `law` is missing; add it",
            ),
            (
                "[[constraint]]\nkind = \"prescribed\"\nregion = \"tip\"\ncomponents = \"x\"\n\
                 displacement = { kind = \"ramp\", from = \"0 mm\", too = \"1 mm\", end = \"1 s\" }",
                "s.toml, line 13: constraint 1 (prescribed): unknown key `too`; did you mean `to`?",
            ),
            (
                "[[constraint]]\nkind = \"prescribed\"\nregion = \"tip\"\ncomponents = \"x\"\n\
                 displacement = { amplitude = \"1 mm\", frequency = \"1 Hz\" }",
                "line 13: constraint 1 (prescribed): it has no `kind`; add kind = \"…\" with one of raised_cosine, sine",
            ),
            (
                "[[constraint]]\nkind = \"cable\"\npath = \"cable\"\nguide_radius = \"4 mm\"\ndrive = { kind = \"lenth\", signal = \"1 mm\" }",
                "line 13: constraint 1 (cable): unknown kind `lenth`; did you mean `length`? (known: length, tension)",
            ),
            (
                "[[constraint]]\nkind = \"cable\"\npath = \"cable\"\nguide_radius = \"4 mm\"\ndrive = { length = \"1 mm\" }",
                "line 13: constraint 1 (cable): it has no `kind`; add kind = \"…\" with one of length, tension",
            ),
            (
                "[mesh.regions]\nroot = { min = [\"0 mm\", \"0 mm\", \"0 mm\"], kind = \"bux\" }",
                "line 10: unknown kind `bux`; did you mean `box`? (known: box, sphere, plane, normal, near, ",
            ),
            (
                "[[stage]]\nintegrator = { kind = \"static\", rho = 0.5 }",
                "line 10: stage 2: unknown key `rho`; it takes no key but `kind`",
            ),
            (
                "[[stage]]\ndt = \"1 s\"\nduration = \"1 s\"\nintegrator = \"generalised_alpha\"",
                "line 12: stage 2: the key `rho` is missing; add it",
            ),
            (
                "[[constraint]]\nkind = \"cable\"\nguides = [[\"0 mm\", \"0 mm\", \"0 mm\"]]\nguide_radius = \"4 mm\"\n\
                 pull_point = [\"0 mm\", \"0 mm\", \"0 mm\", \"0 mm\"]\ndrive = { kind = \"length\", signal = \"1 mm\" }",
                "line 13: constraint 1 (cable): invalid length 4, expected an array of length 3",
            ),
            (
                "[[constraint]]\nkind = \"cable\"\npath = \"cable\"\nguide_radius = \"4 mm\"\n\
                 drive = { kind = \"length\", signal = { kind = \"points\", unit = \"mm\", of = [[0, 0, 1, 2]] } }",
                "line 13: constraint 1 (cable): invalid length 4, expected an array of length 2",
            ),
            ("[numerics]\ntolerance = nan", "s.toml, line 10: nan is not a finite number; give one"),
            ("[[stages]]\ndt = 1", "s.toml, line 9: stages 1: unknown key `stages`; did you mean `stage`?"),
            ("[mesh]\n", "s.toml, line 9: "),
        ] {
            let message = refusal(entries);
            assert!(message.contains(says), "{entries}\ngave: {message}\nnot: {says}");
        }
    }

    /// A change is refused only by its own key: other keys of the law may be changed next, and an unknown law may be registered later.
    #[test]
    fn a_change_by_a_key_that_the_law_does_not_have_is_refused() {
        let text = format!("{SCENE}[laws.rubber]\nlaw = \"neo_hookean\"\nE = \"1 MPa\"\nnu = 0.3\n");
        let changed = |changes: &[(&str, toml::Value)]| {
            let changes: Vec<_> = changes.iter().map(|(path, value)| ((*path).to_string(), value.clone())).collect();
            changed_scene(Path::new("s.toml"), &text, &changes, &KnownLaws::default())
                .map(|_| ())
                .map_err(|e| e.to_string())
        };
        let whole = |text: &str| toml::Value::Table(text.parse().expect("a table"));
        for (path, value) in [
            ("laws.rubber.nuu", toml::Value::Float(0.3)),
            ("laws.rubber", whole("law = \"neo_hookean\"\nE = \"1 MPa\"\nnuu = 0.3")),
        ] {
            let said = changed(&[(path, value)]).err().unwrap_or_default();
            let expected = "s.toml: laws.rubber: law `neo_hookean` has no parameter `nuu`; did you mean `nu`?";
            assert!(said.contains(expected), "{path}: {said}");
        }
        for changes in [
            &[("laws.rubber.law", "yeoh".into())][..],
            &[("laws.rubber.C10", "1 kPa".into()), ("laws.rubber.law", "yeoh".into())],
            &[("laws.rubber.mu", "1 kPa".into())],
            &[("laws.rubber.provenance", "a guess".into())],
            &[("laws.rubber", whole("law = \"of_tomorrow\"\nC = 1"))],
        ] {
            assert_eq!(changed(changes), Ok(()), "{changes:?}");
        }
    }

    /// The values of a table in the order of its keys are not accepted as the table: at the top, in an entry of a list, or below a kind.
    #[test]
    fn an_array_is_no_table() {
        for text in [
            format!("numerics = [0.5, 0.5, 3]\n{SCENE}"),
            "stage = [[\"static\", \"1 s\", \"1 s\"]]\n[mesh]\nbody = \"finger\"\n".into(),
            format!("{SCENE}[[constraint]]\nkind = \"cable\"\ndrive = [\"length\", \"1 mm\"]\n"),
        ] {
            let said = from_text::<SceneSpec>(Path::new("s.toml"), &text, "").expect_err(&text).to_string();
            assert!(said.contains("this must be"), "{text}\ngave: {said}");
        }
        let numerics = format!("numerics = [0.5, 0.5, 3]\n{SCENE}");
        let said = from_text::<SceneSpec>(Path::new("s.toml"), &numerics, "").expect_err("an array").to_string();
        assert!(said.contains("s.toml, line 1: array; this must be a table"), "{said}");
    }

    /// A fit that leaves an end of an interval open writes it as TOML's `inf`. The law may come from a file, or be set as a whole.
    #[test]
    fn laws_with_open_intervals_are_taken() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let law = "law = \"gent\"\nmu = \"300 kPa\"\nJ_m = 80.0\n[provenance]\nJ_m_interval = [70.0, inf]\nmu_interval = [\"-inf Pa\", \"310 kPa\"]\n";
        std::fs::write(folder.path().join("gent.toml"), law).expect("room");
        let file = folder.path().join("scene.toml");
        std::fs::write(&file, format!("{SCENE}[laws.rubber]\ninclude = \"gent.toml\"\nnu = 0.49\n")).expect("room");
        let whole = format!("nu = 0.49\n{law}").parse().map(toml::Value::Table).expect("TOML");
        for changes in [vec![], vec![("laws.rubber".to_string(), whole)]] {
            let (spec, _) = read_scene(&file, &changes).unwrap_or_else(|e| panic!("{e}"));
            let ends = spec.laws["rubber"]["provenance"]["J_m_interval"].as_array().expect("two ends");
            assert_eq!((ends[0].as_float(), ends[1].as_str()), (Some(70.0), Some("inf")));
        }
    }

    /// Keys next to `include` take precedence over those of the file, in effects as in laws, and a missing file is refused.
    #[test]
    fn keys_next_to_an_included_file_take_precedence() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("room");
        write("mullins.toml", "softening = { r = 1.2, m = \"9 kPa\", beta = 0.5 }\n");
        write("prony.toml", "prony = [{ g = 0.2, tau = \"1 s\" }]\n");
        let file = folder.path().join("scene.toml");
        let read = |entry: &str, changes: &[(String, toml::Value)]| {
            std::fs::write(&file, format!("{SCENE}[[effect]]\nregion = \"body\"\nlaw = \"rubber\"\n{entry}\n"))
                .expect("room");
            let (_, text) = read_scene(&file, changes).map_err(|e| e.to_string())?;
            Ok::<toml::Table, String>(text.parse().expect("TOML"))
        };
        let softening = |keys: &str, changes: &[(String, toml::Value)]| {
            let found =
                read(&format!("kind = \"mullins\"\nsoftening = {{ include = \"mullins.toml\"{keys} }}"), changes);
            let constants = found.unwrap_or_else(|e| panic!("{e}"))["effect"][0]["softening"].clone();
            ["r", "m", "beta"].map(|key| constants[key].to_string())
        };
        assert_eq!(softening("", &[]), ["1.2", "\"9 kPa\"", "0.5"]);
        assert_eq!(softening(", r = 3.0", &[]), ["3.0", "\"9 kPa\"", "0.5"]);
        assert_eq!(softening("", &[("effect.0.softening.beta".into(), 0.1.into())]), ["1.2", "\"9 kPa\"", "0.1"]);
        let absent =
            "kind = \"mullins\"\nsoftening = { include = \"absent.toml\", r = 3.0, m = \"1 kPa\", beta = 0.1 }";
        assert!(read(absent, &[]).expect_err("no file").contains("absent.toml"));
        let series = "kind = \"viscoelastic\"\nmoduli = \"long_term\"\nprony = { include = \"prony.toml\" }";
        let said = read(series, &[("effect.0.prony.terms".into(), 3.into())]).expect_err("a key of a list");
        assert!(said.contains("`prony` of prony.toml has no keys"), "{said}");
    }
}
