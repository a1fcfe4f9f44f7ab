//! Laws in the input files of other programs, written and read back: Abaqus, CalculiX, Ansys, FEBio and SOFA.
//!
//! The isochoric energy is reproduced exactly. The volumetric part is the one that the other program offers; if it differs from the law's, it has the
//! same bulk modulus κ, and the text says so. Every program needs a finite κ.
//!
//! Sources: *Abaqus Analysis User's Guide*, Hyperelastic behavior of rubberlike materials and in elastomeric foams; Dhondt, *CalculiX CrunchiX User's
//! Manual*, `*HYPERELASTIC`;
//! *Mechanical APDL Material Reference*, Hyperelasticity; sources of FEBio 4 (`FEUncoupledMaterial`, `FEOgdenMaterial`, `FEOgdenUnconstrained`,
//! `FEGentMaterial`) and of SOFA (`NeoHookean.h`, `MooneyRivlin.h`, `Ogden.h`; its documentation gives the constants in a different order). The text
//! for CalculiX was tested by running it.

mod abaqus;
mod ansys;
mod cards;
mod energy;
mod error;
mod foam;
mod markup;
mod numbers;
mod program;
mod series;

pub use energy::Energy;
pub use error::KeywordError;
pub use program::Program;
pub use series::Imported;

use super::volumetric::VolumetricKind;
use crate::math::units::{self, Dimension};

/// Writes a law as input of a program, with stresses in `unit`; `notes` become comments.
///
/// The text begins with comments on the units and on the volumetric part. A law that the program does not have is refused.
pub fn write(energy: &Energy, program: Program, unit: &str, notes: &[String]) -> Result<String, KeywordError> {
    let scale = 1.0 / units::parse(&format!("1 {unit}"), Dimension::PRESSURE)?;
    let (body, kind) = match program {
        _ if energy.law == energy::FOAM => (foam::write(energy, program, scale)?, None),
        Program::Abaqus | Program::Calculix => abaqus::write(energy, program, scale)?,
        Program::Ansys => ansys::write(energy, scale)?,
        Program::Febio => markup::write_febio(energy, scale)?,
        Program::Sofa => markup::write_sofa(energy, scale)?,
    };
    let mut text = program
        .comment(&format!("{} of Durometer; stresses and moduli in {unit}, lengths and forces to match", energy.law));
    text += &program.comment(&volumetric(energy, kind));
    notes.iter().for_each(|n| text += &program.comment(&n.replace('\n', " ")));
    Ok(text + &body)
}

/// Reads the first law in the input of a program, with stresses in `unit`, and the Prony series of its material.
pub fn read(text: &str, program: Program, unit: &str) -> Result<Imported, KeywordError> {
    let scale = units::parse(&format!("1 {unit}"), Dimension::PRESSURE)?;
    let mut found: Imported = match program {
        Program::Abaqus | Program::Calculix => of_cards(text, program, scale)?,
        Program::Ansys => {
            let energy = foam::read_ansys(text, scale)?.map_or_else(|| ansys::read(text, scale), Ok)?;
            Imported { passed_over: ansys::passed_over(text), ..energy.into() }
        }
        Program::Febio => markup::read_febio(text, scale)?,
        Program::Sofa => markup::read_sofa(text, scale)?.into(),
    };
    let kappa = found.energy.build()?.small_strain().kappa;
    if found.energy.law == energy::FOAM {
        found.energy.kappa = kappa;
    }
    Ok(found)
}

/// Reads the first law in the input of Abaqus or CalculiX, with stresses multiplied by `scale`, and the Prony series of its material.
fn of_cards(text: &str, program: Program, scale: f64) -> Result<Imported, KeywordError> {
    let absent = || KeywordError::Unreadable { program, what: "no *HYPERELASTIC or *HYPERFOAM".into() };
    let (material, law) = cards::of_first_law(text).ok_or_else(absent)?;
    let card = &material[law];
    let energy = match card.is("*HYPERFOAM") {
        true => foam::read_abaqus(card, program, scale)?,
        false => abaqus::read(card, program, scale)?,
    };
    let found = series::with_relaxation(energy, &material, law, program)?;
    Ok(Imported { passed_over: cards::passed_over(&material), ..found })
}

/// Describes the volumetric parts of the program and of the law.
fn volumetric(energy: &Energy, kind: Option<VolumetricKind>) -> String {
    let formula = |kind: Option<VolumetricKind>| match kind {
        Some(VolumetricKind::Quadratic) => "U = kappa/2 (J - 1)^2",
        Some(VolumetricKind::Logarithmic) => "U = kappa/2 (ln J)^2",
        Some(VolumetricKind::SimoTaylor) => "U = kappa/4 (J^2 - 1 - 2 ln J)",
        None => "lambda/2 (ln J)^2 - mu ln J, coupled",
    };
    if energy.law == energy::FOAM {
        return format!("volumetric part: in the terms; kappa = {} Pa at rest", energy.kappa);
    }
    let own = format!("volumetric part: {}, kappa = {} Pa", formula(kind), energy.kappa);
    if kind == energy.volumetric {
        return own;
    }
    format!(
        "{own}; the law of Durometer has {}: equal moduli at rest, stresses that differ in proportion to J - 1",
        formula(energy.volumetric)
    )
}
