//! Numbers in the files of other programs, including the volumetric constants.

use super::error::KeywordError;
use super::program::Program;

/// A number with all its digits, scaled.
pub fn number(x: f64) -> String {
    format!("{x:e}")
}

/// Numbers of a line with commas as separators; an empty cell before the last number is a zero.
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

/// Multiple of D₁ from which on a volumetric constant has no effect \[–\]
const ABSENT: f64 = 1e9;

/// D₁ = 2/κ, and constants of further terms that have no effect. In Abaqus and Ansys these are zeros; CalculiX replaces zeros by a small number, so
/// that the terms have to be made soft.
pub fn volumetric_constants(program: Program, kappa: f64, count: usize) -> Vec<f64> {
    let d1 = 2.0 / kappa;
    let absent = if program == Program::Calculix { 1e3 * ABSENT * d1 } else { 0.0 };
    (0..count).map(|k| if k == 0 { d1 } else { absent }).collect()
}

/// κ from D₁ = 2/κ; refuses further volumetric constants that have an effect.
pub fn kappa_of(program: Program, d: &[f64], scale: f64) -> Result<f64, KeywordError> {
    let refuse = |what: &str| Err(KeywordError::Unreadable { program, what: what.into() });
    match d {
        [d1, rest @ ..] if *d1 > 0.0 && rest.iter().all(|d| *d == 0.0 || *d >= ABSENT * d1) => Ok(2.0 / d1 * scale),
        [d1, ..] if *d1 > 0.0 => refuse("the volumetric part has several terms; Durometer has one"),
        _ => refuse("the law is incompressible (D1 = 0); Durometer needs a finite bulk modulus: give D1 = 2/kappa"),
    }
}
