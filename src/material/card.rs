//! A law as data: its name, values and options, from which it can be rebuilt.

use super::law::Law;
use super::parameter::LawSpecError;
use super::registry::find;
use serde::{Deserialize, Serialize};

/// Name, values \[SI\] and options of a law, in the order of its declaration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LawCard {
    pub name: String,
    pub values: Vec<f64>,
    pub choices: Vec<String>,
}

impl LawCard {
    /// The card of a law.
    pub fn of(law: &dyn Law) -> Self {
        let choices = law.choices().iter().map(ToString::to_string).collect();
        Self { name: law.info().name.into(), values: law.values(), choices }
    }

    /// Rebuilds the law of this card.
    ///
    /// # Errors
    ///
    /// Returns the errors of a law file: this program does not know the law, or a value is outside its bounds.
    pub fn build(&self) -> Result<Box<dyn Law>, LawSpecError> {
        let choices: Vec<&str> = self.choices.iter().map(String::as_str).collect();
        find(&self.name)?.build_with(&self.values, &choices)
    }
}
