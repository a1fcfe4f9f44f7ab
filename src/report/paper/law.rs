//! Laws of a scene with their constants and their origin, in sentences.

use crate::calibrate::{interval_at, provenance_pair, within};
use crate::material::parameter::Choice;
use crate::material::volumetric::CHOICE;
use crate::material::{LawInfo, Parameter, VolumetricKind, find};
use crate::math::units::{self, Dimension};
use crate::report::names::symbol;
use crate::report::numbers::capital;
use crate::report::paper::paragraph::Paragraph;
use crate::report::paper::references::Reference;
use toml::{Table, Value};

/// A law of several scenes: tables that differ at most in the values of their constants, with the same constants given and from the same source.
pub struct LawGroup<'a> {
    /// Its name in the scenes, if these have several laws
    pub name: Option<&'a str>,
    pub tables: Vec<&'a Table>,
}

/// Groups the laws of scenes by name; different constants under one name come from several cases.
pub fn groups(laws: &[(String, Table)]) -> Vec<LawGroup<'_>> {
    let several = laws.iter().any(|(name, _)| *name != laws[0].0);
    let is_alike = |a: &Table, b: &Table| {
        let entry = a.get("law").and_then(Value::as_str).and_then(|law| find(law).ok());
        let choices = entry.iter().flat_map(|entry| entry.info.choices).map(|choice| choice.name);
        a.keys().eq(b.keys()) && ["law", "provenance"].into_iter().chain(choices).all(|key| a.get(key) == b.get(key))
    };
    laws.iter().fold(vec![], |mut all: Vec<LawGroup>, (name, table)| {
        let name = several.then_some(name.as_str());
        match all.iter_mut().find(|group| group.name == name && is_alike(group.tables[0], table)) {
            Some(group) => group.tables.push(table),
            None => all.push(LawGroup { name, tables: vec![table] }),
        }
        all
    })
}

/// Adds a sentence on a law; constants that differ between its tables are given by their range and the number of their values.
pub fn describe(to: Paragraph, group: &LawGroup) -> Paragraph {
    let first = group.tables.first();
    let law = first.and_then(|table| table.get("law")?.as_str());
    let (Some(first), Some(Ok(entry))) = (first, law.map(find)) else { return to };
    let chosen = |choice: &Choice| first.get(choice.name).and_then(Value::as_str).or(choice.default);
    let volumetric = entry.info.choices.iter().find(|choice| choice.name == CHOICE.name).and_then(chosen);
    let volumetric = VolumetricKind::ALL.into_iter().find(|kind| Some(kind.name()) == volumetric);
    let to = match group.name {
        Some(name) => to.text(format!("Law {}: ", name.replace('_', " "))),
        None => to,
    };
    let to = formula(to, entry.info, &in_form(entry.info, chosen));
    let to = match volumetric {
        Some(kind) => to.text(", ").formula(format!("U(J) = {}", kind.formula())),
        None => to,
    };
    let to = to.text(format!(", with {}{}", constants(&group.tables), absent(first, entry.info)));
    let to = match first.get("provenance").and_then(Value::as_table).and_then(source) {
        Some(source) => to.text(format!("; constants from {source}")),
        None => to.text("; the constants are those of the scene, without a stated source"),
    };
    to.text(". ")
}

/// The terms of the formula that a law leaves out: `, C₂₀ = C₃₀ = 0`.
fn absent(table: &Table, info: &LawInfo) -> String {
    let may_be_absent = info.parameters.iter().rev().take(info.optional).rev();
    let terms = may_be_absent.filter(|p| !table.contains_key(p.name) && info.formula.contains(p.symbol));
    let terms: Vec<String> = terms.map(|p| symbol(p.symbol)).collect();
    if terms.is_empty() { String::new() } else { format!(", {} = 0", terms.join(" = ")) }
}

/// Lists the constants of the laws of a group: `μ = 50 kPa to 500 MPa (12 values), ν = 0.49`.
pub fn constants(group: &[&Table]) -> String {
    let Some(first) = group.first() else { return String::new() };
    let Some(Ok(entry)) = first.get("law").and_then(Value::as_str).map(find) else { return String::new() };
    let empty = Table::new();
    let provenance = first.get("provenance").and_then(Value::as_table).unwrap_or(&empty);
    let one = |key: &String| {
        let values: Vec<&Value> = group.iter().filter_map(|table| table.get(key)).collect();
        constant(entry.parameter(key)?, &values, provenance)
    };
    first.keys().filter_map(one).collect::<Vec<_>>().join(", ")
}

/// Adds a sentence on the form of a law, without constants; an unknown law is left out.
pub fn named(to: Paragraph, law: &str) -> Paragraph {
    match find(law) {
        Ok(entry) => formula(to, entry.info, entry.info.formula).text(". "),
        Err(_) => to,
    }
}

/// The formula of a law with the chosen options.
fn in_form<'a>(info: &LawInfo, chosen: impl Fn(&Choice) -> Option<&'a str>) -> String {
    info.choices.iter().filter(|choice| !choice.formulas.is_empty()).fold(info.formula.to_string(), |text, choice| {
        let of =
            |option: Option<&str>| choice.options.iter().position(|o| Some(*o) == option).map(|k| choice.formulas[k]);
        match (of(choice.default), of(chosen(choice))) {
            (Some(written), Some(own)) => text.replace(written, own),
            _ => text,
        }
    })
}

/// Adds name, source and formula of a law.
fn formula(to: Paragraph, info: &LawInfo, formula: &str) -> Paragraph {
    let cited = Reference::named_in(info.source);
    let source = if cited.is_empty() { format!(" ({})", info.source) } else { String::new() };
    let to = to.text(format!("{} law{source}", capital(info.title))).cite(cited);
    to.text(", ").formula(formula)
}

/// A constant as `μ = 357 kPa (95 % interval 334 to 380 kPa)`, from the text of a scene, or the range of several values.
fn constant(p: &Parameter, values: &[&Value], provenance: &Table) -> Option<String> {
    let si = |value: &Value| match value {
        Value::String(text) => units::parse(text, p.dimension).ok(),
        other => other.as_float().or_else(|| other.as_integer().map(|n| n as f64)),
    };
    let mut numbers: Vec<f64> = values.iter().filter_map(|value| si(value)).collect();
    numbers.sort_by(f64::total_cmp);
    numbers.dedup();
    let unit = if p.dimension == Dimension::PRESSURE { "Pa" } else { "" };
    // A constant without an interval has the digits that were given
    let given = |number: f64| {
        let printed = within(number, unit, None);
        format!("{}{}", plain(printed.factor * number), joined(printed.unit))
    };
    let shown = match numbers[..] {
        [] => return None,
        [number] => {
            let in_use = provenance_pair(provenance, &format!("{}_interval_in_use", p.name));
            match interval_at(provenance, p.name, number) {
                None => given(number),
                Some(ends) if !ends.iter().any(|end| end.is_finite()) => {
                    format!("{} (without an interval)", given(number))
                }
                Some([a, b]) => {
                    let printed = within(number, unit, Some([a, b]));
                    let unit = joined(printed.unit);
                    let text = |v: f64| printed.end(v);
                    // The interval for use also contains the misfit of the law
                    let wider = in_use.filter(|ends| *ends != [a, b]).map_or(String::new(), |[a, b]| {
                        format!(", {} to {}{unit} with the misfit of the law", text(a), text(b))
                    });
                    format!("{}{unit} (95 % interval {} to {}{unit}{wider})", printed.number(number), text(a), text(b))
                }
            }
        }
        [low, .., high] => format!("{} to {} ({} values)", given(low), given(high), numbers.len()),
    };
    Some(format!("{} = {shown}", symbol(p.symbol)))
}

/// A unit preceded by a no-break space.
fn joined(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!("\u{a0}{unit}") }
}

/// Formats a number with six significant digits, without trailing zeros.
pub fn plain(x: f64) -> String {
    let shown: f64 = format!("{x:.5e}").parse().unwrap_or(x);
    if shown != 0.0 && (shown.abs() < 1e-4 || shown.abs() >= 1e6) { format!("{shown:e}") } else { format!("{shown}") }
}

/// Where constants come from: the source of the data, the test and the fitted stretches.
fn source(provenance: &Table) -> Option<String> {
    let text = |key: &str| provenance.get(key).and_then(Value::as_str).map(String::from);
    let from = text("source").or_else(|| text("data"))?;
    let modes = provenance.get("mode").and_then(Value::as_array);
    let modes: Vec<&str> = modes.into_iter().flatten().filter_map(Value::as_str).collect();
    let stretch = provenance.get("fitted_stretch").and_then(Value::as_array);
    let stretch: Vec<f64> = stretch.into_iter().flatten().filter_map(Value::as_float).collect();
    let fitted = match (modes.is_empty(), stretch.as_slice()) {
        (false, [a, b]) => {
            format!(", fitted to its {} data for stretches from {} to {}", modes.join(" and "), plain(*a), plain(*b))
        }
        (false, _) => format!(", fitted to its {} data", modes.join(" and ")),
        (true, _) => String::new(),
    };
    Some(format!("{}{fitted}", from.trim_end_matches('.')))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chosen U(J) and the interval with the misfit of the law are stated.
    #[test]
    fn the_volumetric_part_and_the_wider_interval_are_told() {
        let text = "law = \"yeoh\"\nC10 = \"90 kPa\"\nC20 = \"9 kPa\"\nnu = 0.49\nvolumetric = \"quadratic\"\n[provenance]\n\
                    data = \"a\"\nC10_interval = [\"83 kPa\", \"97 kPa\"]\nC10_interval_in_use = [\"80 kPa\", \"101 kPa\"]\n";
        let table: Table = text.parse().expect("TOML");
        let words = constants(&[&table]);
        assert!(
            words.contains("95 % interval 83.0 to 97.0\u{a0}kPa, 80.0 to 101.0\u{a0}kPa with the misfit of the law)"),
            "{words}"
        );
        let markdown =
            format!("{:?}", describe(Paragraph::new("Material"), &LawGroup { name: None, tables: vec![&table] }));
        assert!(markdown.contains("U(J) = ½κ(J − 1)²"), "{markdown}");
        // A value that differs from the file has no interval
        let other: Table = text.replace("C10 = \"90 kPa\"", "C10 = \"180 kPa\"").parse().expect("TOML");
        assert!(!constants(&[&other]).contains("interval"), "{}", constants(&[&other]));
        // The formula has a third term
        let markdown = describe(Paragraph::new("Material"), &LawGroup { name: None, tables: vec![&table] }).markdown();
        assert!(words.ends_with("ν = 0.49") && markdown.contains("ν = 0.49, C₃₀ = 0; constants from"), "{markdown}");
    }

    /// Every constant of the formula has a value, even if the scene leaves it out.
    #[test]
    fn terms_that_a_law_leaves_out_are_zero() {
        let words = |text: &str| {
            let table: Table = text.parse().expect("TOML");
            describe(Paragraph::new("Material"), &LawGroup { name: None, tables: vec![&table] }).markdown()
        };
        let of = |law: &str| words(&format!("law = \"{law}\"\nC10 = \"1 kPa\"\nC01 = \"1 kPa\"\nnu = 0.49\n"));
        assert!(of("mooney_rivlin").contains("ν = 0.49, C₁₁ = C₂₀ = C₀₂ = 0;"), "{}", of("mooney_rivlin"));
        assert!(words("law = \"yeoh\"\nC10 = \"1 kPa\"\nnu = 0.49\n").contains("ν = 0.49, C₂₀ = C₃₀ = 0;"));
        // A sum names no term
        let ogden = words("law = \"ogden\"\nmu1 = \"1 kPa\"\nalpha1 = 2.0\nnu = 0.49\n");
        assert!(!ogden.contains("= 0;") && ogden.contains("ν = 0.49;"), "{ogden}");
    }

    /// The energy is that of the chosen or default form, stated once; laws of different forms are not combined into a range.
    #[test]
    fn the_energy_is_that_of_the_form_of_the_scene() {
        let table = |text: &str| -> Table { text.parse().expect("TOML") };
        let words = |table: &Table| {
            describe(Paragraph::new("Material"), &LawGroup { name: None, tables: vec![table] }).markdown()
        };
        let split = "law = \"neo_hookean_split\"\nE = \"1 MPa\"\nnu = 0.49\n";
        let (usual, quadratic) = (table(split), table(&format!("{split}volumetric = \"quadratic\"")));
        let logarithmic = table(&format!("{split}volumetric = \"logarithmic\""));
        for (law, own) in [(&usual, "U(J) = ½κ(J − 1)²"), (&logarithmic, "U(J) = ½κ(ln J)²")] {
            let words = words(law);
            assert!(words.contains(own) && words.matches("½κ").count() == 1, "{words}");
        }
        let ogden =
            "law = \"ogden\"\nmu1 = \"1 kPa\"\nalpha1 = 2.0\nnu = 0.49\nvolumetric = \"quadratic\"\nconvention = ";
        assert!(words(&table(&format!("{ogden}\"abaqus\""))).contains("Σ (2μ\\_n/α\\_n²)("));
        assert!(words(&table(&format!("{ogden}\"ogden\""))).contains("Σ (μ\\_n/α\\_n)("));
        let laws = [quadratic, logarithmic].map(|law| ("rubber".to_string(), law));
        assert_eq!(groups(&laws).len(), 2);
    }

    /// Laws that differ in a constant form one sentence with its range and count; another source has its own sentence.
    #[test]
    fn swept_constants_are_a_range() {
        let law = |mu: &str, more: &str| -> Table {
            format!("law = \"neo_hookean\"\nmu = \"{mu}\"\nnu = 0.49\n{more}").parse().expect("TOML")
        };
        let sourced = law("60 kPa", "[provenance]\nsource = \"a data sheet\"");
        let named =
            |name: &str, all: Vec<Table>| all.into_iter().map(|law| (name.to_string(), law)).collect::<Vec<_>>();
        let all = named("rubber", vec![law("50 kPa", ""), law("0.2 MPa", ""), law("50 kPa", ""), sourced]);
        let found = groups(&all);
        assert_eq!(found.iter().map(|group| group.tables.len()).collect::<Vec<_>>(), [3, 1]);
        assert!(found.iter().all(|group| group.name.is_none()));
        assert_eq!(constants(&found[0].tables), "μ = 50\u{a0}kPa to 200\u{a0}kPa (2 values), ν = 0.49");
        assert_eq!(constants(&found[1].tables), "μ = 60\u{a0}kPa, ν = 0.49");
        // Two materials are not combined into a range
        let all = [named("soft", vec![law("50 kPa", "")]), named("stiff", vec![law("0.2 MPa", "")])].concat();
        let words = groups(&all).iter().fold(Paragraph::new("Material"), describe).markdown();
        assert!(
            words.contains("Law soft: Neo-Hookean law") && words.contains("with μ = 50\u{a0}kPa, ν = 0.49;"),
            "{words}"
        );
        assert!(words.contains("Law stiff: Neo-Hookean law") && !words.contains("values)"), "{words}");
    }
}
