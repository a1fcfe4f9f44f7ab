//! `*HYPERELASTIC` of Abaqus and CalculiX: constants in this order, then D₁ = 2/κ, eight numbers to a line.
//!
//! U = (J − 1)²/D₁, with further terms (J − 1)²ᵏ/D_k that have no effect; for `ARRUDA-BOYCE` (½(J² − 1) − ln J)/D. Ogden's energy is Σ
//! (2μ_n/α_n²)(Σλ̄^α_n − 3).

use super::cards::{Card, LINE, options};
use super::energy::{COUPLED, Energy, OGDEN, SPLIT};
use super::error::KeywordError;
use super::numbers::{kappa_of, number, volumetric_constants};
use super::program::Program;
use crate::material::VolumetricKind;

/// The keyword with its numbers, and its volumetric part.
pub fn write(energy: &Energy, program: Program, scale: f64) -> Result<(String, Option<VolumetricKind>), KeywordError> {
    let c = &energy.constants;
    let at = |k: usize| c.get(k).copied().unwrap_or(0.0) * scale;
    let mut kind = VolumetricKind::Quadratic;
    // Number of volumetric constants last
    let (option, mut values, d) = match energy.law.as_str() {
        COUPLED | SPLIT => ("NEO HOOKE".to_string(), vec![0.5 * at(0)], 1),
        "mooney_rivlin" if c.len() == 2 => ("MOONEY-RIVLIN".into(), vec![at(0), at(1)], 1),
        "mooney_rivlin" => ("POLYNOMIAL, N=2".into(), vec![at(0), at(1), at(3), at(2), at(4)], 2),
        "yeoh" => ("YEOH".into(), vec![at(0), at(1), at(2)], 3),
        // CalculiX 2.20 stops with an error at four terms
        OGDEN if program == Program::Calculix && c.len() > 6 => {
            return Err(energy.refuse(program, " and more than three terms"));
        }
        OGDEN => {
            let terms = c.chunks_exact(2).flat_map(|v| [0.5 * v[0] * scale, v[1]]);
            (format!("OGDEN, N={}", c.len() / 2), terms.collect(), c.len() / 2)
        }
        "arruda_boyce" => {
            kind = VolumetricKind::SimoTaylor;
            ("ARRUDA-BOYCE".into(), vec![at(0), c[1]], 1)
        }
        _ => return Err(energy.refuse(program, "")),
    };
    values.extend(volumetric_constants(program, energy.kappa * scale, d));
    let lines: Vec<String> =
        values.chunks(LINE).map(|l| l.iter().map(|x| number(*x)).collect::<Vec<_>>().join(", ") + "\n").collect();
    Ok((format!("*HYPERELASTIC, {option}\n{}", lines.concat()), Some(kind)))
}

/// Reads a `*HYPERELASTIC`.
pub fn read(card: &Card, program: Program, scale: f64) -> Result<Energy, KeywordError> {
    let refuse = |what: String| KeywordError::Unreadable { program, what };
    let head = card.head.as_str();
    let given = options(head);
    let count =
        given.get("N").map_or(Ok(1), |n| n.parse::<usize>().map_err(|_| refuse(format!("N = {n} is no number"))))?;
    let has = |name: &str| given.contains_key(name);
    // Number of volumetric constants last
    let (law, constants, volumetric) = match () {
        () if has("NEO HOOKE") || (has("REDUCED POLYNOMIAL") && count == 1) => (SPLIT, 1, 1),
        () if has("MOONEY-RIVLIN") || (has("POLYNOMIAL") && count == 1) => ("mooney_rivlin", 2, 1),
        () if has("POLYNOMIAL") && count == 2 => ("mooney_rivlin", 5, 2),
        () if has("REDUCED POLYNOMIAL") && count == 2 => ("yeoh", 2, 2),
        () if has("YEOH") || (has("REDUCED POLYNOMIAL") && count == 3) => ("yeoh", 3, 3),
        () if has("OGDEN") && (1..=4).contains(&count) => (OGDEN, 2 * count, count),
        () if has("ARRUDA-BOYCE") => ("arruda_boyce", 2, 1),
        () => return Err(refuse(format!("\"{head}\" is no law of Durometer"))),
    };
    let (values, first_d) = (card.constants(program, constants + volumetric)?, constants);
    if values.len() <= first_d {
        return Err(refuse(format!("{} numbers below \"{head}\", at least {} are needed", values.len(), first_d + 1)));
    }
    let kappa = kappa_of(program, &values[first_d..], scale)?;
    let v = &values[..constants];
    let constants = match law {
        SPLIT => vec![2.0 * v[0] * scale],
        OGDEN => v.chunks_exact(2).flat_map(|v| [2.0 * v[0] * scale, v[1]]).collect(),
        "arruda_boyce" => vec![v[0] * scale, v[1]],
        "mooney_rivlin" if constants == 5 => [v[0], v[1], v[3], v[2], v[4]].map(|x| x * scale).to_vec(),
        "yeoh" => (0..3).map(|k| v.get(k).map_or(0.0, |x| x * scale)).collect(),
        _ => v.iter().map(|x| x * scale).collect(),
    };
    let kind = if law == "arruda_boyce" { VolumetricKind::SimoTaylor } else { VolumetricKind::Quadratic };
    Ok(Energy { law: law.into(), constants, kappa, volumetric: Some(kind) })
}
