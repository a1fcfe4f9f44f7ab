//! What a table of a law can have wrong with it: the fact and the remedy.

use super::Choice;
use crate::math::units::UnitError;

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
    #[error("`{key} = 0`: the term vanishes; remove it")]
    ZeroExponent { key: &'static str },
    #[error("`{key}` is not given, so nothing depends on it; give it a value, or take one of {}", given.join(", "))]
    NotGiven { key: String, given: Vec<String> },
}
