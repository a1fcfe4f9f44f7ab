//! Derivative of a law with respect to a constant as given in its file: ∂ψ/∂θ, ∂P/∂θ and ∂A/∂θ as functions of F.
//!
//! A law differentiates with respect to its own values ([`Law::along`]); here the rates of those values follow from the key of the file by the chain
//! rule: a law of two constants is given by any two of E, ν, μ, λ, κ, the other laws by κ or ν. The other keys of the file are held.

use super::entry::LawEntry;
use super::law::Law;
use super::parameter::{LawSpecError, Values};
use super::registry::given;
use std::collections::BTreeMap;

/// ∂/∂`key` of the law of this table.
pub fn derivative(table: &toml::Table, key: &str) -> Result<Box<dyn Law>, LawSpecError> {
    let (entry, values, options) = given(table)?;
    derivative_of(entry, &values, &options, key)
}

/// ∂/∂`key` of a law at values \[SI\] and options by key.
pub fn derivative_of(
    entry: &LawEntry,
    values: &Values,
    options: &BTreeMap<String, String>,
    key: &str,
) -> Result<Box<dyn Law>, LawSpecError> {
    let law = entry.build(values, options)?;
    if !values.contains_key(key) {
        return Err(LawSpecError::NotGiven { key: key.into(), given: values.keys().cloned().collect() });
    }
    Ok(law.along(&(entry.rates)(law.as_ref(), values, key)))
}
