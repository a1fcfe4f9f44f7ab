//! Parameters and choices of a law as given in files, and the errors of a table.

use std::collections::BTreeMap;

use crate::math::units::{Dimension, UnitError};

/// A parameter, declared once; parsing, messages, fit bounds and documentation derive from it.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Key in files, e.g. `mu`
    pub name: &'static str,
    /// Symbol in formulae, e.g. `μ`
    pub symbol: &'static str,
    pub dimension: Dimension,
    /// Open interval in SI units: lower < value < upper
    pub bounds: (f64, f64),
    pub meaning: &'static str,
}

impl Parameter {
    /// Bounds of a positive value.
    pub const POSITIVE: (f64, f64) = (0.0, f64::INFINITY);
    /// Bounds of a value of either sign.
    pub const ANY: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

    /// The key in files, the symbol in formulae, the dimension, the open interval of values \[SI\], the meaning.
    pub const fn new(
        name: &'static str,
        symbol: &'static str,
        dimension: Dimension,
        bounds: (f64, f64),
        meaning: &'static str,
    ) -> Self {
        Self { name, symbol, dimension, bounds, meaning }
    }
}

/// A form of the law that is chosen by name, e.g. `volumetric = "quadratic"`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Choice {
    /// Key in files
    pub name: &'static str,
    pub options: &'static [&'static str],
    /// Option that is used if the key is absent; without a default the key is required
    pub default: Option<&'static str>,
    pub meaning: &'static str,
    /// For each option, the part of the formula that it changes, if it changes one
    pub formulas: &'static [&'static str],
}

/// Values by key \[SI\].
pub type Values = BTreeMap<String, f64>;

/// Options by key, with each choice of the law once.
pub type Chosen = BTreeMap<&'static str, &'static str>;

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

/// Reasons why a law could not be built from its table.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum LawSpecError {
    #[error("the table names no law; add `law = \"…\"` with one of {}", known.join(", "))]
    NoName { known: Vec<&'static str> },
    #[error("`law = {found}` is not a name; write for example `law = \"neo_hookean\"`")]
    NameNotText { found: String },
    #[error("there is no law `{name}`; {hint}")]
    UnknownLaw { name: String, hint: String },
    #[error("there is already a law `{name}`; register this one under another name")]
    NameTaken { name: &'static str },
    #[error("law `{law}` has no parameter `{key}`; {hint}")]
    UnknownKey { law: &'static str, key: String, hint: String },
    #[error("`{key}`: {source}")]
    Unit { key: &'static str, source: UnitError },
    #[error("`{key} = {found}` is not a quantity; write a number with its unit ({example})")]
    NotAQuantity { key: &'static str, found: String, example: &'static str },
    #[error("{key} ({meaning}) = {value} [SI] is not inside ({lower}, {upper})")]
    OutOfBounds { key: &'static str, meaning: &'static str, value: f64, lower: f64, upper: f64 },
    #[error("nu = {nu} >= 0.5 leaves no finite bulk modulus; use e.g. 0.499 with formulation = \"mixed\"")]
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
    #[error("law `{law}` needs `{key}` ({meaning})")]
    Missing { law: &'static str, key: &'static str, meaning: &'static str },
    #[error(
        "law `{law}` needs `{}`, one of {} ({})",
        choice.name, choice.options.join(", "), choice.meaning
    )]
    NotChosen { law: &'static str, choice: &'static Choice },
    #[error("`{} = {found}` is not a name; write one of {} in quotes", choice.name, choice.options.join(", "))]
    OptionNotText { choice: &'static Choice, found: String },
    #[error("`{key} = \"{option}\"` does not exist; {hint}")]
    UnknownOption { key: &'static str, option: String, hint: String },
    #[error("law `{law}` has no volumetric constant; add exactly one of kappa and nu, e.g. `nu = 0.49`")]
    NoVolumetric { law: &'static str },
    #[error(
        "kappa = {kappa} Pa and nu = {nu} are both given, and nu means kappa = {implied} Pa with the shear modulus of the law; remove one"
    )]
    TwoVolumetric { kappa: f64, nu: f64, implied: f64 },
    #[error(
        "law `{law}` has the shear modulus {mu} Pa at F = I with these constants; it must be positive, check their signs"
    )]
    NotStable { law: &'static str, mu: f64 },
    #[error(
        "law `{law}` has the bulk modulus {kappa} Pa at F = I with these constants; it must be positive, check their signs"
    )]
    NoBulk { law: &'static str, kappa: f64 },
    #[error("`{key} = 0`: the term vanishes; remove it")]
    ZeroExponent { key: &'static str },
    #[error("`{key}` is not given, so nothing depends on it; give it a value, or take one of {}", given.join(", "))]
    NotGiven { key: String, given: Vec<String> },
}
