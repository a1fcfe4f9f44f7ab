//! The list of laws, and how a law is read from a file: `law = "neo_hookean"`, `E = "100 kPa"`, `nu = 0.45`.

use std::collections::BTreeMap;

use super::corotational::{self, Corotational};
use super::linear::{self, Linear};
use super::neo_hookean::{self, NeoHookean};
use super::neo_hookean_split::{self, NeoHookeanSplit};
use super::st_venant_kirchhoff::{self, StVenantKirchhoff};
use super::stable_neo_hookean::{self, StableNeoHookean};
use super::{Law, LawInfo, Moduli, Parameter, moduli};
use crate::math::units::{self, Dimension, UnitError};

/// Values by key [SI].
pub type Values = BTreeMap<String, f64>;

/// One line of the registry.
#[derive(Debug)]
pub struct LawEntry {
    pub info: &'static LawInfo,
    /// Keys taken from a file: the parameters or what they can be computed from
    pub keys: &'static [Parameter],
    build: fn(&Values) -> Result<Box<dyn Law>, LawSpecError>,
}

/// A law of two elastic constants, any two of E, ν, μ, λ, κ.
const fn elastic(info: &'static LawInfo, build: fn(&Values) -> Result<Box<dyn Law>, LawSpecError>) -> LawEntry {
    LawEntry { info, keys: moduli::KEYS, build }
}

/// Every law. A new law is one file and one line here.
pub static LAWS: &[LawEntry] = &[
    elastic(&linear::INFO, |v| Ok(Box::new(Linear(Moduli::from_map(v)?)))),
    elastic(&corotational::INFO, |v| Ok(Box::new(Corotational(Moduli::from_map(v)?)))),
    elastic(&st_venant_kirchhoff::INFO, |v| Ok(Box::new(StVenantKirchhoff(Moduli::from_map(v)?)))),
    elastic(&neo_hookean::INFO, |v| Ok(Box::new(NeoHookean(Moduli::from_map(v)?)))),
    elastic(&neo_hookean_split::INFO, |v| Ok(Box::new(NeoHookeanSplit(Moduli::from_map(v)?)))),
    elastic(&stable_neo_hookean::INFO, |v| Ok(Box::new(StableNeoHookean::new(Moduli::from_map(v)?)))),
];

/// Keys of a law table that are not parameters of the law: its name, and where its numbers come from.
const OTHER_KEYS: [&str; 3] = ["law", "provenance", "source"];

impl LawEntry {
    /// The law with these values [SI] by key.
    pub fn build(&self, values: &Values) -> Result<Box<dyn Law>, LawSpecError> {
        for (key, value) in values {
            self.key(key)?;
            check_bounds(self.keys, key, *value)?;
        }
        (self.build)(values)
    }

    /// The law with the values of `info.parameters` in their order [SI]: the inverse of [`Law::values`].
    pub fn build_from(&self, values: &[f64]) -> Result<Box<dyn Law>, LawSpecError> {
        let keys = self.info.parameters.iter().map(|p| p.name.to_string());
        self.build(&keys.zip(values.iter().copied()).collect())
    }

    fn key(&self, key: &str) -> Result<&'static Parameter, LawSpecError> {
        self.keys.iter().find(|p| p.name == key).ok_or_else(|| LawSpecError::UnknownKey {
            law: self.info.name,
            key: key.to_string(),
            hint: hint(key, self.keys.iter().map(|p| p.name)),
        })
    }
}

/// The entry of this name.
pub fn find(name: &str) -> Result<&'static LawEntry, LawSpecError> {
    LAWS.iter().find(|e| e.info.name == name).ok_or_else(|| LawSpecError::UnknownLaw {
        name: name.to_string(),
        hint: hint(name, LAWS.iter().map(|e| e.info.name)),
    })
}

/// Reads a law from its table in a file.
pub fn law_from_table(table: &toml::Table) -> Result<Box<dyn Law>, LawSpecError> {
    let name = match table.get("law") {
        Some(toml::Value::String(name)) => name,
        Some(other) => return Err(LawSpecError::NameNotText { found: other.to_string() }),
        None => return Err(LawSpecError::NoName { known: LAWS.iter().map(|e| e.info.name).collect() }),
    };
    let entry = find(name)?;
    let mut values = Values::new();
    for (key, value) in table.iter().filter(|(key, _)| !OTHER_KEYS.contains(&key.as_str())) {
        values.insert(key.clone(), quantity(entry.key(key)?, value)?);
    }
    entry.build(&values)
}

/// A quantity as it stands in a file [SI].
fn quantity(p: &Parameter, value: &toml::Value) -> Result<f64, LawSpecError> {
    let unit = |source| LawSpecError::Unit { key: p.name, source };
    match value {
        toml::Value::String(text) => units::parse(text, p.dimension).map_err(unit),
        toml::Value::Float(x) if p.dimension == Dimension::NONE => Ok(*x),
        toml::Value::Integer(n) if p.dimension == Dimension::NONE => Ok(*n as f64),
        toml::Value::Float(_) | toml::Value::Integer(_) => {
            Err(unit(UnitError::Missing { text: value.to_string(), wanted: p.dimension }))
        }
        _ => Err(LawSpecError::NotAQuantity { key: p.name, found: value.to_string(), example: p.dimension.example() }),
    }
}

/// Refuses a value outside the open interval of its parameter, and NaN.
pub(crate) fn check_bounds(keys: &[Parameter], key: &str, value: f64) -> Result<(), LawSpecError> {
    let Some(p) = keys.iter().find(|p| p.name == key) else { return Ok(()) };
    let (lower, upper) = p.bounds;
    if lower < value && value < upper {
        Ok(())
    } else if key == "nu" && value >= 0.5 {
        Err(LawSpecError::Incompressible { nu: value })
    } else {
        Err(LawSpecError::OutOfBounds { key: p.name, meaning: p.meaning, value, lower, upper })
    }
}

/// `; did you mean …?` or the whole list, where nothing is near.
fn hint<'a>(word: &str, known: impl Iterator<Item = &'a str> + Clone) -> String {
    let near = known.clone().map(|k| (strsim::jaro_winkler(&word.to_lowercase(), &k.to_lowercase()), k));
    match near.max_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((score, k)) if score > 0.7 => format!("did you mean `{k}`?"),
        _ => format!("known: {}", known.collect::<Vec<_>>().join(", ")),
    }
}

/// Why a law could not be made from its table.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum LawSpecError {
    #[error("the table names no law; add `law = \"…\"` with one of {}", known.join(", "))]
    NoName { known: Vec<&'static str> },
    #[error("`law = {found}` is not a name; write for example `law = \"neo_hookean\"`")]
    NameNotText { found: String },
    #[error("there is no law `{name}`; {hint}")]
    UnknownLaw { name: String, hint: String },
    #[error("law `{law}` has no parameter `{key}`; {hint}")]
    UnknownKey { law: &'static str, key: String, hint: String },
    #[error("`{key}`: {source}")]
    Unit { key: &'static str, source: UnitError },
    #[error("`{key} = {found}` is not a quantity; write a number with its unit ({example})")]
    NotAQuantity { key: &'static str, found: String, example: &'static str },
    #[error("{key} ({meaning}) = {value} [SI] is not inside ({lower}, {upper})")]
    OutOfBounds { key: &'static str, meaning: &'static str, value: f64, lower: f64, upper: f64 },
    #[error("nu = {nu} >= 0.5: incompressible needs a mixed formulation; use e.g. 0.49")]
    Incompressible { nu: f64 },
    #[error(
        "the law needs exactly two of E, nu, mu, lambda, kappa, and {} given; {}",
match &given[..] {
            [] => "none is".to_string(),
            [one] => format!("only {one} is"),
            many => format!("{} are", many.join(", ")),
        },
        if given.len() < 2 { "add one, e.g. `nu = 0.45`" } else { "remove all but two" }
    )]
    NotTwo { given: Vec<String> },
    #[error(
        "{first} and {second} contradict each other: they give {derived} = {value}, not inside ({lower}, {upper}); check their units"
    )]
    Contradiction { first: String, second: String, derived: &'static str, value: f64, lower: f64, upper: f64 },
    #[error("nu = 0 means lambda = 0 whatever the stiffness; give E or mu instead of lambda")]
    Undetermined,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Box<dyn Law>, LawSpecError> {
        law_from_table(&text.parse().expect("the test writes valid TOML"))
    }

    #[test]
    fn reads_every_law() {
        for entry in LAWS {
            let name = entry.info.name;
            let law = read(&format!(
                "law = \"{name}\"\nE = \"100 kPa\"\nnu = 0.45\nprovenance = \"a test\"\nsource.doi = \"x\""
            ))
            .unwrap_or_else(|e| panic!("{name}: {e}"));
            assert_eq!((law.info().name, law.values()), (name, vec![100e3, 0.45]));
        }
    }

    #[test]
    fn any_two_constants() {
        let law = read("law = \"neo_hookean\"\nmu = \"0.1 MPa\"\nkappa = \"1 bar\"").expect("a consistent pair");
        let m = law.small_strain();
        assert_eq!((m.mu, m.kappa), (1e5, 1e5));
        assert!((m.nu / 0.125 - 1.0).abs() < 1e-15, "(3κ − 2μ)/(6κ + 2μ) = 1/8");
    }

    /// (table, what its message must say)
    #[test]
    fn refuses_with_fact_and_remedy() {
        let nh = "law = \"neo_hookean\"\n";
        for (table, says) in [
            ("E = \"1 kPa\"", "names no law; add `law = \"…\"` with one of linear"),
            ("law = 3", "`law = 3` is not a name"),
            ("law = \"neohookean\"", "no law `neohookean`; did you mean `neo_hookean`?"),
            ("law = \"xyz\"", "no law `xyz`; known: linear, corotational"),
            (&format!("{nh}young = \"1 kPa\""), "no parameter `young`; known: E, nu, mu, lambda, kappa"),
            (&format!("{nh}kapa = \"1 kPa\""), "no parameter `kapa`; did you mean `kappa`?"),
            (&format!("{nh}E = 100e3\nnu = 0.45"), "`E`: 100000.0 has no unit; write for example \"100000.0 kPa\""),
            (&format!("{nh}E = \"100 mm\"\nnu = 0.45"), "`E`: \"100 mm\" has the wrong dimension"),
            (&format!("{nh}E = true\nnu = 0.45"), "`E = true` is not a quantity"),
            (&format!("{nh}E = \"100 kPa\""), "exactly two of E, nu, mu, lambda, kappa, and only E is given; add one"),
            (nh, "and none is given; add one"),
            (&format!("{nh}E = \"1 kPa\"\nnu = 0.3\nmu = \"1 kPa\""), "E, nu, mu are given; remove all but two"),
            (
                &format!("{nh}E = \"1 kPa\"\nnu = 0.5"),
                "nu = 0.5 >= 0.5: incompressible needs a mixed formulation; use e.g. 0.49",
            ),
            (&format!("{nh}E = \"1 kPa\"\nnu = -1.0"), "nu (Poisson's ratio) = -1 [SI] is not inside (-1, 0.5)"),
            (&format!("{nh}E = \"-1 kPa\"\nnu = 0.3"), "E (Young's modulus) = -1000 [SI] is not inside (0, inf)"),
            (&format!("{nh}nu = nan\nE = \"1 kPa\""), "nu (Poisson's ratio) = NaN"),
            (&format!("{nh}E = \"9 kPa\"\nmu = \"1 kPa\""), "E and mu contradict each other: they give kappa"),
        ] {
            let message = read(table).expect_err(table).to_string();
            assert!(message.contains(says), "{table}\ngave: {message}\nnot: {says}");
        }
    }
}
