//! The energy of a law, independent of names and conventions.

use super::error::KeywordError;
use super::program::Program;
use crate::material::law::Law;
use crate::material::registry;
use crate::material::volumetric::VolumetricKind;
use crate::material::{LawSpecError, Moduli, Values};
use crate::math::units::Dimension;

/// The energy of a law with its constants in SI units.
#[derive(Clone, PartialEq, Debug)]
pub struct Energy {
    /// Name of the law
    pub law: String,
    /// For Ogden's law c_n and α_n in Σ (c_n/α_n²)(Σλ̄^α_n − 3); for both neo-Hookean laws μ; for a foam μ_n, α_n, ν_n
    pub constants: Vec<f64>,
    /// Bulk modulus \[Pa\]; for a foam it follows from the constants
    pub kappa: f64,
    /// `None` for a law whose volumetric part is coupled
    pub volumetric: Option<VolumetricKind>,
}

/// Names of laws that need special treatment
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
                // c_n in the three conventions
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
                // κ is the first parameter of all laws except the foam
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

    /// This energy with its isochoric part multiplied by a factor; the bulk modulus is unchanged.
    pub(super) fn scaled(mut self, factor: f64) -> Result<Self, LawSpecError> {
        let parameters = registry::find(&self.law)?.info.parameters;
        // κ is the first parameter of the laws with several constants; μ is the only one of both neo-Hookean laws
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

    /// The error that the program has no form of this law.
    pub(super) fn refuse(&self, program: Program, why: &'static str) -> KeywordError {
        KeywordError::NoForm { program, law: self.law.clone(), why }
    }
}
