//! `card.toml`: information that a table lacks. It lies next to the table and names it.

use super::{accuracy::Accuracy, columns::ColumnChoice, dimensions::Dimensions};
use crate::calibrate::{FitError, Mode, Preparation};
use crate::storage::{self, TEXT_LIMIT};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Source of the numbers.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Source {
    pub authors: String,
    pub title: String,
    pub journal: String,
    pub volume: String,
    pub pages: String,
    pub year: Option<u32>,
    pub url: String,
}

/// Facts about one table. `[columns]` overrides what is detected.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Card {
    pub name: String,
    /// File name of the table in the same folder
    pub file: String,
    /// Licence, or why none is needed
    pub status: String,
    /// How the numbers came into the file
    #[serde(default)]
    pub digitised: String,
    /// The mode of all rows if no column gives it
    pub mode: Option<Mode>,
    /// The instrument of the strain: `crosshead`, `extensometer` or another
    pub strain_measurement: Option<String>,
    pub temperature: Option<String>,
    #[serde(default)]
    pub notes: Vec<String>,
    #[serde(default)]
    pub source: Source,
    #[serde(default)]
    pub columns: ColumnChoice,
    /// `gauge_length`, `width`, `thickness`, `diameter`, `area`, `compliance` with their units; other keys are free
    #[serde(default)]
    pub specimen: toml::Table,
    /// 95 % half-widths of the errors that all data points share
    #[serde(default)]
    pub accuracy: Accuracy,
    /// Treatment of the rows before a fit
    #[serde(default)]
    pub preparation: Preparation,
}

/// The keys that every card needs.
const BEGINNING: &str = "a card begins with name = \"…\", file = \"…\" of the table next to it, and status = \"own measurement\" or a licence";

impl Card {
    pub fn read(path: &Path) -> Result<Self, FitError> {
        let text =
            storage::read_text(path, TEXT_LIMIT).map_err(|source| FitError::Read { path: path.into(), source })?;
        toml::from_str(&text).map_err(|e| {
            let is_missing = e.message().starts_with("missing field");
            let remedy = if is_missing { format!("; {BEGINNING}") } else { String::new() };
            FitError::Card { path: path.into(), message: e.to_string().trim_end().to_string() + &remedy }
        })
    }

    /// The statements of the card on the columns of the table.
    pub fn choice(&self) -> Result<ColumnChoice, FitError> {
        let dimensions = Dimensions::of_card(&self.specimen)?;
        Ok(ColumnChoice { dimensions, strain_measurement: self.strain_measurement.clone(), ..self.columns.clone() })
    }

    /// A choice of columns, completed by the card if there is one.
    pub fn complete(card: Option<&Self>, choice: &ColumnChoice) -> Result<ColumnChoice, FitError> {
        card.map_or_else(|| Ok(choice.clone()), |card| Ok(choice.or(&card.choice()?)))
    }

    /// The given card; by default the `card.toml` next to the table, if it names this table.
    pub fn find(given: Option<&Path>, data: &Path) -> Result<Option<Self>, FitError> {
        match given {
            Some(path) => Self::read(path).map(Some),
            None => Ok(Self::next_to(data)?.filter(|card| card.names(data))),
        }
    }

    /// The `card.toml` next to the table, whichever table it names.
    pub fn next_to(data: &Path) -> Result<Option<Self>, FitError> {
        let neighbour = data.with_file_name("card.toml");
        neighbour.is_file().then(|| Self::read(&neighbour)).transpose()
    }

    /// Whether the card belongs to this table.
    pub fn names(&self, data: &Path) -> bool {
        data.file_name().is_some_and(|name| name == self.file.as_str())
    }
}
