//! Everything that acts on the bodies of stored cases, in sentences for a paper: effects, constraints, contacts and rigid bodies with the numbers that
//! define them.

use crate::math::units;
use crate::report::numbers::capital;
use crate::report::paper::Paragraph;
use crate::report::paper::law::plain;
use crate::study::store::record::CaseRecord;
use crate::wording::{self, distinct};
use toml::{Table, Value};

/// Lists of a scene whose entries act on its bodies, with the noun for an entry without a kind.
const LISTS: [(&str, &str); 4] =
    [("effect", "effect"), ("constraint", "constraint"), ("contact", "contact"), ("rigid", "rigid body")];
/// Keys that are part of the name of an entry.
const NAMING: [&str; 3] = ["kind", "name", "region"];
/// Keys with their wording in a sentence; for a kind the value says enough.
const WORDS: [(&str, &str); 5] =
    [("kind", ""), ("signal", "as "), ("drive", "driven by "), ("start", "after "), ("end", "until ")];
/// Largest number of list entries that are printed; of a longer list, or a list of points, only the length.
const MOST: usize = 3;

/// Writes one sentence for each entry of the scenes. Numbers that differ between the cases are given as ranges, other values as alternatives. An entry
/// or a key that not all cases have is followed by the cases that have it.
pub fn physics(records: &[&CaseRecord]) -> Paragraph {
    let cases: Vec<(&str, Vec<(String, Table)>)> = records.iter().map(|r| (r.id.as_str(), entries(r))).collect();
    let names = distinct(cases.iter().flat_map(|(_, own)| own).map(|(name, _)| name.as_str()));
    let sentence = |name: &str| {
        let tables: Vec<(&str, &Table)> = cases.iter().filter_map(|(id, own)| Some((*id, entry(own, name)?))).collect();
        let cases = not_in_all(&cases, |own| entry(own, name).is_some());
        let details = pairs(&tables, &NAMING);
        let colon = if details.is_empty() { "" } else { ": " };
        format!("{}{cases}{colon}{}.", capital(name), details.join(", "))
    };
    Paragraph::new("Effects and constraints").text(names.into_iter().map(sentence).collect::<Vec<_>>().join(" "))
}

/// The entries of the scene of a case with their names; entries of the same name are numbered. Without a scene, the effects in the record are used.
fn entries(record: &CaseRecord) -> Vec<(String, Table)> {
    let mut all: Vec<(String, Table)> = vec![];
    let mut add = |name: String, entry: Table| {
        let is_of_it =
            |known: &str| known.strip_prefix(&name).is_some_and(|rest| rest.is_empty() || rest.starts_with(" ("));
        let name = match all.iter().filter(|(known, _)| is_of_it(known)).count() {
            0 => name,
            before => format!("{name} ({})", before + 1),
        };
        all.push((name, entry));
    };
    let scene = record.provenance.scene.parse::<Table>().ok().filter(|scene| scene.contains_key("effect"));
    let Some(scene) = scene else {
        record.effects.iter().for_each(|e| add(e.name.replace('_', " "), Table::new()));
        return all;
    };
    for (list, word) in LISTS {
        for entry in scene.get(list).and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_table) {
            let text = |key: &str| entry.get(key).and_then(Value::as_str).map(|text| text.replace('_', " "));
            let part = |before: &str, key: &str| text(key).map_or(String::new(), |text| format!("{before}{text}"));
            let kind = text("kind").unwrap_or_else(|| word.into());
            add(format!("{kind}{}{}", part(" ", "name"), part(" on ", "region")), entry.clone());
        }
    }
    all
}

/// The entry with this name.
fn entry<'a>(own: &'a [(String, Table)], name: &str) -> Option<&'a Table> {
    own.iter().find(|(known, _)| known == name).map(|(_, entry)| entry)
}

/// The cases that have something, in brackets, or those that lack it if these are fewer; empty if all have it.
fn not_in_all<T>(cases: &[(&str, T)], has: impl Fn(&T) -> bool) -> String {
    let (with, without): (Vec<_>, Vec<_>) = cases.iter().partition(|(_, parts)| has(parts));
    let ids = |cases: &[&(&str, T)]| wording::few(&cases.iter().map(|(id, _)| *id).collect::<Vec<_>>());
    match without.len() {
        0 => String::new(),
        n if n < with.len() => format!(" (in all cases but {})", ids(&without)),
        _ => format!(" (in {})", ids(&with)),
    }
}

/// The keys in the tables of the cases with their values, except the keys in `without`.
fn pairs(tables: &[(&str, &Table)], without: &[&str]) -> Vec<String> {
    let keys = tables.iter().flat_map(|(_, table)| table.keys()).map(String::as_str);
    let keys = distinct(keys.filter(|key| !without.contains(key)));
    let pair = |key: &str| {
        let values: Vec<(&str, &Value)> =
            tables.iter().filter_map(|(id, table)| Some((*id, table.get(key)?))).collect();
        let cases = not_in_all(tables, |table| table.contains_key(key));
        let spoken = key.replace('_', " ");
        if let Some(counted) = counted(&values, &spoken) {
            return format!("{counted}{cases}");
        }
        let before = WORDS.iter().find(|(known, _)| *known == key).map(|(_, words)| (*words).to_string());
        format!("{}{}{cases}", before.unwrap_or_else(|| format!("{spoken} ")), shown(&values))
    };
    keys.into_iter().map(pair).collect()
}

/// The length of lists of points or of many numbers: `4 guides`.
fn counted(values: &[(&str, &Value)], key: &str) -> Option<String> {
    let lists: Vec<&Vec<Value>> = values.iter().filter_map(|(_, v)| v.as_array()).collect();
    let is_long = |list: &&Vec<Value>| list.len() > MOST || list.iter().any(Value::is_array);
    if lists.len() < values.len() || !lists.iter().any(is_long) {
        return None;
    }
    let (least, most) = (lists.iter().map(|l| l.len()).min()?, lists.iter().map(|l| l.len()).max()?);
    // The points of a signal are under the key `of`
    let one = if key == "of" { "value" } else { key.trim_end_matches('s') };
    let most = wording::count(most, one);
    Some(if lists.iter().all(|l| l.len() == lists[0].len()) { most } else { format!("{least} to {most}") })
}

/// The values of one key in the cases: as written if they agree, otherwise a range of numbers with one unit, or the alternatives.
fn shown(values: &[(&str, &Value)]) -> String {
    let tables: Vec<(&str, &Table)> = values.iter().filter_map(|(id, v)| Some((*id, v.as_table()?))).collect();
    if tables.len() == values.len() {
        let kinds = tables.iter().map(|(_, table)| table.get("kind"));
        let of_kind = |kind: Option<&Value>| {
            tables.iter().copied().filter(|(_, table)| table.get("kind") == kind).collect::<Vec<_>>()
        };
        let each: Vec<String> = distinct(kinds).into_iter().map(|kind| pairs(&of_kind(kind), &[]).join(" ")).collect();
        return wording::either(&each);
    }
    let lists: Vec<(&str, &Vec<Value>)> = values.iter().filter_map(|(id, v)| Some((*id, v.as_array()?))).collect();
    if lists.len() == values.len() && lists.iter().all(|(_, l)| l.len() == lists[0].1.len()) {
        let places =
            (0..lists[0].1.len()).map(|k| shown(&lists.iter().map(|(id, list)| (*id, &list[k])).collect::<Vec<_>>()));
        return format!("({})", places.collect::<Vec<_>>().join(", "));
    }
    let words = distinct(values.iter().map(|(_, value)| one(value)));
    let number = |text: &String| {
        let (number, unit) = text.split_once('\u{a0}').unwrap_or((text, ""));
        Some((number.replace('−', "-").parse::<f64>().ok()?, unit.to_string()))
    };
    let numbers: Option<Vec<(f64, String)>> = words.iter().map(number).collect();
    match numbers {
        Some(all) if all.len() > 1 && all.iter().all(|(_, unit)| *unit == all[0].1) => {
            let order = |a: &usize, b: &usize| all[*a].0.total_cmp(&all[*b].0);
            let low = (0..all.len()).min_by(order).unwrap_or_default();
            let high = (0..all.len()).max_by(order).unwrap_or_default();
            format!("between {} and {} ({} values)", words[low], words[high], all.len())
        }
        _ => wording::either(&words),
    }
}

/// One value; a number and its unit are joined by a no-break space.
fn one(value: &Value) -> String {
    let number = |text: &str| text.replace('-', "−");
    match value {
        Value::String(text) => match units::spaced(text) {
            Some(spaced) => match spaced.split_once(' ') {
                Some((n, unit)) => format!("{}\u{a0}{}", number(n), unit.replace("^2", "²").replace("^3", "³")),
                None => spaced,
            },
            None if text.chars().all(|c| c.is_alphanumeric() || c == '_') => text.replace('_', " "),
            None => text.clone(),
        },
        Value::Integer(n) => number(&n.to_string()),
        Value::Float(x) => number(&plain(*x)),
        Value::Table(_) | Value::Array(_) => shown(&[("", value)]),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::store::record::{EffectRecord, Provenance};

    const BEAM: &str = r#"
[mesh]
grid = { kind = "box", size = ["60 mm", "10 mm", "10 mm"], divisions = [6, 1, 2] }
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.45
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "prescribed"
region = "xmax"
components = "x"
displacement = "1 mm"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.5 s"
"#;
    const BALL: &str = r#"
[[contact]]
region = "ball"
obstacle = { kind = "floor", point = ["0 mm", "0 mm", "-20 mm"], normal = [0, 0, 1] }
response = "barrier"
friction = 0.0
[[rigid]]
name = "ball"
shape = { kind = "sphere", center = ["0 mm", "0 mm", "0 mm"], radius = "5 mm" }
density = "1 g/cm^3"
"#;

    fn words(scenes: &[(&str, &str)]) -> String {
        let record = |(id, scene): &(&str, &str)| CaseRecord {
            id: id.to_string(),
            effects: vec![EffectRecord { name: "elastic".into(), role: Some("strain".into()), wall_s: 0.0 }],
            provenance: Provenance { scene: scene.to_string(), ..Provenance::default() },
            ..CaseRecord::default()
        };
        let records: Vec<CaseRecord> = scenes.iter().map(record).collect();
        let said = physics(&records.iter().collect::<Vec<_>>()).markdown();
        said.trim().trim_start_matches("**Effects and constraints.** ").to_string()
    }

    #[test]
    fn all_that_acts_on_a_body_has_a_sentence() {
        let beam =
            "Elastic on body: law rubber. Fixed on xmin. Prescribed on xmax: components x, displacement 1\u{a0}mm.";
        assert_eq!(words(&[("a", BEAM)]), beam);
        let more = format!("{BEAM}{BALL}");
        let said = words(&[("a", BEAM), ("b", &more)]);
        let floor = "Contact on ball (in b): obstacle floor point (0\u{a0}mm, 0\u{a0}mm, −20\u{a0}mm) normal (0, 0, 1), response barrier, friction 0.";
        assert!(said.starts_with(beam) && said.contains(floor), "{said}");
        assert!(said.contains("Rigid body ball (in b): shape sphere center "), "{said}");
        assert!(said.ends_with(" radius 5\u{a0}mm, density 1\u{a0}g/cm³."), "{said}");
        let said = words(&[("a", BEAM), ("b", &more), ("c", &more)]);
        assert!(said.contains("Rigid body ball (in all cases but a): "), "{said}");
        assert_eq!(words(&[("a", "no scene")]), "Elastic.");
    }

    /// Guides are counted, a drive is described with its signal, and numbers that differ between cases are ranges.
    #[test]
    fn a_cable_is_told_by_its_numbers() {
        let cable = |radius: &str, to: &str| {
            format!(
                "{BEAM}[[constraint]]\nkind = \"cable\"\npull_point = [\"-5 mm\", \"5 mm\", \"5 mm\"]\n\
                 guides = [[\"10 mm\", \"5 mm\", \"5 mm\"], [\"50 mm\", \"5 mm\", \"5 mm\"]]\nguide_radius = \"{radius}\"\n\
                 drive = {{ kind = \"tension\", signal = {{ kind = \"ramp\", from = \"0 N\", to = \"{to}\", end = \"1 s\" }} }}\n"
            )
        };
        let point = "(−5\u{a0}mm, 5\u{a0}mm, 5\u{a0}mm)";
        let said = words(&[("a", &cable("4 mm", "2 N"))]);
        let drive = "driven by tension as ramp from 0\u{a0}N to 2\u{a0}N until 1\u{a0}s.";
        let alone = format!("Cable: pull point {point}, 2 guides, guide radius 4\u{a0}mm, {drive}");
        assert!(said.ends_with(&alone), "{said}");
        let said = words(&[("a", &cable("4 mm", "2 N")), ("b", &cable("2 mm", "2 N")), ("c", &cable("point", "2 N"))]);
        assert!(said.contains("guide radius 4\u{a0}mm, 2\u{a0}mm or point, driven by"), "{said}");
        let said = words(&[("a", &cable("4 mm", "9 N")), ("b", &cable("4 mm", "10 N")), ("c", &cable("4 mm", "9 N"))]);
        assert!(said.ends_with("from 0\u{a0}N to between 9\u{a0}N and 10\u{a0}N (2 values) until 1\u{a0}s."), "{said}");
    }

    /// A key that only some cases have is followed by these cases, also within the signal of a drive; drives of several kinds are alternatives.
    #[test]
    fn what_some_cases_have_is_not_said_of_all() {
        let mixed = BEAM.replace("law = \"rubber\"\n", "law = \"rubber\"\nformulation = \"mixed\"\n");
        let said = words(&[("a", BEAM), ("b", &mixed), ("c", BEAM)]);
        assert!(said.starts_with("Elastic on body: law rubber, formulation mixed (in b). Fixed on xmin."), "{said}");
        let said = words(&[("a", &mixed), ("b", &mixed), ("c", BEAM)]);
        assert!(said.contains(", formulation mixed (in all cases but c). "), "{said}");
        assert!(words(&[("a", &mixed), ("b", &mixed)]).contains(", formulation mixed. "));
        let cable = |drive: &str| format!("{BEAM}[[constraint]]\nkind = \"cable\"\ndrive = {{ {drive} }}\n");
        let length = cable("kind = \"length\", signal = { kind = \"ramp\", from = \"0 mm\", to = \"2 mm\" }");
        let late =
            cable("kind = \"length\", signal = { kind = \"ramp\", from = \"0 mm\", to = \"2 mm\", end = \"1 s\" }");
        let tension = cable("kind = \"tension\", signal = { kind = \"ramp\", from = \"0 N\", to = \"1 N\" }");
        let said = words(&[("a", &length), ("b", &tension), ("c", &late)]);
        let drives = "Cable: driven by length as ramp from 0\u{a0}mm to 2\u{a0}mm until 1\u{a0}s (in c) or tension as ramp from 0\u{a0}N to 1\u{a0}N.";
        assert!(said.ends_with(drives), "{said}");
    }
}
