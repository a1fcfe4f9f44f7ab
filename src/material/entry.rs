//! A law as listed in the registry: its declaration and its construction from values.

use std::collections::BTreeMap;
use std::fmt;

use super::fit_form::FitForm;
use super::law::{Law, LawInfo};
use super::moduli;
use super::parameter::{Choice, Chosen, LawSpecError, Parameter, Values, check_bounds};
use crate::math::units::{self, Dimension};
use crate::wording::hint;

/// Builds a law from its values \[SI\] and options by key.
pub type Build = fn(&Values, &Chosen) -> Result<Box<dyn Law>, LawSpecError>;

/// Rates of [`Law::values`] with respect to one of the given keys, with the others held.
pub type Rates = fn(&dyn Law, &Values, &str) -> Vec<f64>;

/// Builds a law that is only known at run time, from its values \[SI\] and options by key.
pub type Maker = dyn Fn(&Values, &Chosen) -> Result<Box<dyn Law>, LawSpecError> + Send + Sync;

/// The function that builds a law from its values.
#[derive(Clone, Copy)]
enum Make {
    Function(Build),
    Closure(&'static Maker),
}

impl fmt::Debug for Make {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if matches!(self, Self::Function(_)) { "Function" } else { "Closure" })
    }
}

/// Converts constants given in another convention, with its option, to the law's own convention; returns false if they are already in it.
pub type Convert = fn(&mut Values, &mut BTreeMap<String, String>) -> bool;

/// The declaration of a law: its description, its constants, an example and the form in which it is fitted.
#[derive(Clone, Copy, Debug)]
pub struct LawEntry {
    pub info: &'static LawInfo,
    /// Keys that are read from a file: the parameters, or quantities from which they can be computed
    pub keys: &'static [Parameter],
    /// Values of `info.parameters` in their order \[SI\], as an example for checks; optional ones may be absent at the end
    pub sample: &'static [f64],
    /// The form in which the law is fitted to homogeneous tests; `None` for a law that is not fitted
    pub fit: Option<FitForm>,
    /// Converts constants of another convention to those that are fitted, and returns whether they were in another one
    pub to_own_convention: Option<Convert>,
    make: Make,
    pub(super) rates: Rates,
}

impl LawEntry {
    /// Declares a law of the constants `keys`, read from a file by `build` and differentiated by `rates`.
    pub const fn new(
        info: &'static LawInfo,
        keys: &'static [Parameter],
        sample: &'static [f64],
        build: Build,
        rates: Rates,
    ) -> Self {
        Self { info, keys, sample, fit: None, to_own_convention: None, make: Make::Function(build), rates }
    }

    /// Declares a law whose `make` is only known at run time, such as one that another language declares. It is kept for the life of the process.
    pub fn made_by(
        info: &'static LawInfo,
        keys: &'static [Parameter],
        sample: &'static [f64],
        make: impl Fn(&Values, &Chosen) -> Result<Box<dyn Law>, LawSpecError> + Send + Sync + 'static,
        rates: Rates,
    ) -> Self {
        Self {
            info,
            keys,
            sample,
            fit: None,
            to_own_convention: None,
            make: Make::Closure(Box::leak(Box::new(make))),
            rates,
        }
    }

    /// Declares a law of two elastic constants, any two of E, ν, μ, λ, κ. The example has E = 100 kPa and ν = 0.4.
    pub const fn elastic(info: &'static LawInfo, build: Build) -> Self {
        let rates: Rates = |law, given, key| law.small_strain().rates(given, key);
        Self::new(info, moduli::KEYS, &[100e3, 0.4], build, rates)
    }

    /// This entry with the form in which the law is fitted.
    #[must_use]
    pub const fn with_fit(mut self, fit: FitForm) -> Self {
        self.fit = Some(fit);
        self
    }

    /// This entry with the conversion of its constants to one convention.
    #[must_use]
    pub const fn with_conversion(mut self, convert: Convert) -> Self {
        self.to_own_convention = Some(convert);
        self
    }

    /// The example of the law: the values of `sample`, and the first option of each choice that has no default.
    ///
    /// # Errors
    ///
    /// Returns an error if the law refuses its own example.
    pub fn example(&self) -> Result<Box<dyn Law>, LawSpecError> {
        let options: Vec<&str> = self.info.choices.iter().map(|c| c.default.unwrap_or(c.options[0])).collect();
        self.build_with(self.sample, &options)
    }

    /// The example as a table of a file.
    pub fn example_table(&self) -> toml::Table {
        let mut table = toml::Table::new();
        table.insert("law".into(), self.info.name.into());
        for (p, value) in self.info.parameters.iter().zip(self.sample) {
            let value = match p.dimension {
                Dimension::NONE => toml::Value::from(*value),
                Dimension::PRESSURE => format!("{value:?} Pa").into(),
                other => {
                    let factor = units::parse(&format!("1 {}", other.example()), other).unwrap_or(1.0);
                    format!("{:?} {}", value / factor, other.example()).into()
                }
            };
            table.insert(p.name.into(), value);
        }
        for c in self.info.choices.iter().filter(|c| c.default.is_none()) {
            table.insert(c.name.into(), c.options[0].into());
        }
        table
    }

    /// Builds the law with these values \[SI\] and options by key.
    ///
    /// # Errors
    ///
    /// Returns an error if a value is missing, unknown or out of its range, or if the law does not have an option.
    pub fn build(&self, values: &Values, options: &BTreeMap<String, String>) -> Result<Box<dyn Law>, LawSpecError> {
        for (key, value) in values {
            check_bounds(std::slice::from_ref(self.key(key)?), key, *value)?;
        }
        if let Some(key) = options.keys().find(|key| self.choice(key).is_none()) {
            return Err(self.unknown(key));
        }
        let choose = |c: &'static Choice| self.choose(c, options.get(c.name).map(String::as_str));
        let chosen = self.info.choices.iter().map(choose).collect::<Result<_, _>>()?;
        match self.make {
            Make::Function(build) => build(values, &chosen),
            Make::Closure(make) => make(values, &chosen),
        }
    }

    /// Builds the law with the values of `info.parameters` in their order \[SI\], and the default options.
    ///
    /// # Errors
    ///
    /// Returns an error if a value is out of its range, or if the number of values is not that of the parameters.
    pub fn build_from(&self, values: &[f64]) -> Result<Box<dyn Law>, LawSpecError> {
        self.build_with(values, &[])
    }

    /// Builds the law with the values of `info.parameters` and the options of `info.choices` in their order: the inverse of [`Law::values`] and
    /// [`Law::choices`].
    ///
    /// # Errors
    ///
    /// Returns the errors of [`LawEntry::build_from`], and an error for options that the law does not have.
    pub fn build_with(&self, values: &[f64], options: &[&str]) -> Result<Box<dyn Law>, LawSpecError> {
        let keys = self.info.parameters.iter().map(|p| p.name.to_string());
        let names = self.info.choices.iter().map(|c| c.name.to_string());
        let options = names.zip(options.iter().map(ToString::to_string)).collect();
        self.build(&keys.zip(values.iter().copied()).collect(), &options)
    }

    pub(super) fn choice(&self, key: &str) -> Option<&'static Choice> {
        self.info.choices.iter().find(|c| c.name == key)
    }

    fn choose(
        &self,
        choice: &'static Choice,
        option: Option<&str>,
    ) -> Result<(&'static str, &'static str), LawSpecError> {
        let Some(option) = option.or(choice.default) else {
            return Err(LawSpecError::NotChosen { law: self.info.name, choice });
        };
        let known = choice.options.iter().find(|o| **o == option);
        known.map(|o| (choice.name, *o)).ok_or_else(|| LawSpecError::UnknownOption {
            key: choice.name,
            option: option.to_string(),
            hint: hint(option, choice.options),
        })
    }

    /// The parameter with this key in files.
    pub fn parameter(&self, key: &str) -> Option<&'static Parameter> {
        self.keys.iter().find(|p| p.name == key)
    }

    pub(super) fn key(&self, key: &str) -> Result<&'static Parameter, LawSpecError> {
        self.parameter(key).ok_or_else(|| self.unknown(key))
    }

    fn unknown(&self, key: &str) -> LawSpecError {
        let keys = self.keys.iter().map(|p| p.name);
        let known: Vec<&str> = keys.chain(self.info.choices.iter().map(|c| c.name)).collect();
        LawSpecError::UnknownKey { law: self.info.name, key: key.to_string(), hint: hint(key, &known) }
    }
}
