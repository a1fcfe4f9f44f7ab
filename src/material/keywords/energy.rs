//! The energy of a law apart from names and conventions, the programs, and the numbers of their files.

use crate::material::law::Law;
use crate::material::registry;
use crate::material::volumetric::VolumetricKind;
use crate::material::{LawSpecError, Moduli, Values};
use crate::math::units::{Dimension, UnitError};
use std::collections::BTreeMap;
use std::str::FromStr;

/// A program whose input can hold a law.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Program {
    Abaqus,
    Calculix,
    Ansys,
    Febio,
    Sofa,
}

impl Program {
    pub const ALL: [Self; 5] = [Self::Abaqus, Self::Calculix, Self::Ansys, Self::Febio, Self::Sofa];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Abaqus => "abaqus",
            Self::Calculix => "calculix",
            Self::Ansys => "ansys",
            Self::Febio => "febio",
            Self::Sofa => "sofa",
        }
    }

    /// A line of text that the program does not read.
    pub fn comment(self, text: &str) -> String {
        match self {
            Self::Abaqus | Self::Calculix => format!("** {text}\n"),
            Self::Ansys => format!("! {text}\n"),
            Self::Febio | Self::Sofa => format!("<!-- {} -->\n", text.replace("--", "- -")),
        }
    }
}

impl FromStr for Program {
    type Err = String;
    fn from_str(word: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|p| p.name() == word)
            .ok_or_else(|| format!("\"{word}\" is not a program; known: {}", Self::ALL.map(Self::name).join(", ")))
    }
}

/// Reason why a law could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum KeywordError {
    #[error("{} has no law with the energy of `{law}`{why}; choose another program or another law", program.name())]
    NoForm { program: Program, law: String, why: &'static str },
    #[error("the text has no law of {}: {what}", program.name())]
    Unreadable { program: Program, what: String },
    #[error(transparent)]
    Unit(#[from] UnitError),
    #[error(transparent)]
    Law(#[from] LawSpecError),
}

/// The energy of a law with its constants in SI units.
#[derive(Clone, PartialEq, Debug)]
pub struct Energy {
    /// Name of the law
    pub law: String,
    /// Of Ogden's law c_n and α_n of Σ (c_n/α_n²)(Σλ̄^α_n − 3); of both Neo-Hookean laws μ; of a foam μ_n, α_n, ν_n
    pub constants: Vec<f64>,
    /// Bulk modulus \[Pa\]; of a foam it follows from the constants
    pub kappa: f64,
    /// `None` of a law whose volumetric part is coupled
    pub volumetric: Option<VolumetricKind>,
}

/// Names of laws that are treated alike
pub const COUPLED: &str = "neo_hookean";
pub const SPLIT: &str = "neo_hookean_split";
pub const OGDEN: &str = "ogden";
pub const FOAM: &str = "hyperfoam";

impl Energy {
    /// The energy of a law.
    pub fn of(law: &dyn Law) -> Self {
        let (name, hooke) = (law.info().name, law.small_strain());
        let volumetric = law.split().map(|(_, u)| u.kind).filter(|_| name != COUPLED);
        let constants = match name {
            COUPLED | SPLIT => vec![hooke.mu],
            FOAM => law.values(),
            OGDEN => {
                // c_n of the three conventions
                let factor = |mu: f64, alpha: f64| match law.choices() {
                    c if c.contains(&"abaqus") => 2.0 * mu,
                    c if c.contains(&"febio") => mu,
                    _ => mu * alpha,
                };
                law.values()[1..].chunks_exact(2).flat_map(|v| [factor(v[0], v[1]), v[1]]).collect()
            }
            _ if volumetric.is_some() => law.values()[1..].to_vec(),
            _ => vec![],
        };
        Self { law: name.into(), constants, kappa: hooke.kappa, volumetric }
    }

    /// The law that has this energy.
    pub fn build(&self) -> Result<Box<dyn Law>, LawSpecError> {
        registry::law_from_table(&self.table()?)
    }

    /// The table of a law file.
    pub fn table(&self) -> Result<toml::Table, LawSpecError> {
        let entry = registry::find(&self.law)?;
        let pascal = |x: f64| toml::Value::from(format!("{x} Pa"));
        let mut table = toml::Table::new();
        table.insert("law".into(), self.law.clone().into());
        match self.law.as_str() {
            COUPLED | SPLIT => drop(table.insert("mu".into(), pascal(self.constants[0]))),
            law => {
                if law == OGDEN {
                    table.insert("convention".into(), "febio".into());
                }
                // κ is the first parameter of all laws but the foam
                let first = usize::from(law != FOAM);
                for (p, x) in entry.info.parameters.iter().skip(first).zip(&self.constants) {
                    let value = if p.dimension == Dimension::PRESSURE { pascal(*x) } else { (*x).into() };
                    table.insert(p.name.into(), value);
                }
            }
        }
        if self.law == FOAM {
            return Ok(table);
        }
        table.insert("kappa".into(), pascal(self.kappa));
        if let Some(kind) = self.volumetric {
            table.insert("volumetric".into(), kind.name().into());
        }
        Ok(table)
    }

    /// The same law with its isochoric energy times a factor; the bulk modulus stays.
    pub(super) fn scaled(mut self, factor: f64) -> Result<Self, LawSpecError> {
        let parameters = registry::find(&self.law)?.info.parameters;
        // κ is the first parameter of the laws with several constants, and μ the one of both Neo-Hookean laws
        let alone = matches!(self.law.as_str(), COUPLED | SPLIT);
        for (k, x) in self.constants.iter_mut().enumerate() {
            if alone || parameters.get(k + 1).is_some_and(|p| p.dimension == Dimension::PRESSURE) {
                *x *= factor;
            }
        }
        Ok(self)
    }

    /// Elastic constants of the coupled law.
    pub(super) fn moduli(&self) -> Result<Moduli, LawSpecError> {
        let given: Values =
            [("mu".to_string(), self.constants[0]), ("kappa".to_string(), self.kappa)].into_iter().collect();
        Moduli::from_map(&given)
    }

    /// The error that a program has no such law.
    pub(super) fn refuse(&self, program: Program, why: &'static str) -> KeywordError {
        KeywordError::NoForm { program, law: self.law.clone(), why }
    }
}

/// A number with all its digits, scaled.
pub fn number(x: f64) -> String {
    format!("{x:e}")
}

/// Numbers of a line that is divided by commas; an empty cell before the last number is a zero.
pub fn numbers(program: Program, cells: &[&str]) -> Result<Vec<f64>, KeywordError> {
    let one = |c: &&str| match c.trim() {
        "" => Ok(0.0),
        cell => cell
            .parse::<f64>()
            .ok()
            .filter(|x| x.is_finite())
            .ok_or_else(|| KeywordError::Unreadable { program, what: format!("\"{cell}\" is not a number") }),
    };
    let end = cells.iter().rposition(|c| !c.trim().is_empty()).map_or(0, |k| k + 1);
    cells[..end].iter().map(one).collect()
}

/// A volumetric constant from this multiple of D₁ on has no effect \[–\]
const ABSENT: f64 = 1e9;

/// D₁ = 2/κ and constants of further terms that have no effect. Zeros say so in Abaqus and Ansys; CalculiX replaces them by a small number, so
/// that the terms have to be made soft.
pub fn volumetric_constants(program: Program, kappa: f64, count: usize) -> Vec<f64> {
    let d1 = 2.0 / kappa;
    let absent = if program == Program::Calculix { 1e3 * ABSENT * d1 } else { 0.0 };
    (0..count).map(|k| if k == 0 { d1 } else { absent }).collect()
}

/// κ of D₁ = 2/κ, and no other volumetric constants.
pub fn kappa_of(program: Program, d: &[f64], scale: f64) -> Result<f64, KeywordError> {
    let refuse = |what: &str| Err(KeywordError::Unreadable { program, what: what.into() });
    match d {
        [d1, rest @ ..] if *d1 > 0.0 && rest.iter().all(|d| *d == 0.0 || *d >= ABSENT * d1) => Ok(2.0 / d1 * scale),
        [d1, ..] if *d1 > 0.0 => refuse("the volumetric part has several terms; Durometer has one"),
        _ => refuse("the law is incompressible (D1 = 0); Durometer needs a finite bulk modulus: give D1 = 2/kappa"),
    }
}

/// Options of a keyword by name, in upper case.
pub fn options(line: &str) -> BTreeMap<String, String> {
    let pair = |o: &str| {
        let (key, value) = o.split_once('=').unwrap_or((o, ""));
        (key.trim().to_uppercase(), value.trim().to_string())
    };
    line.split(',').map(pair).collect()
}
