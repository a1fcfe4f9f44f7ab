//! Foams in the input of other programs.
//!
//! Abaqus and CalculiX: `*HYPERFOAM, N` with μ_n, α_n of all terms, then ν_n, eight numbers to a line, with the same energy as Durometer. Ansys:
//! `TB,HYPER,,,,FOAM` with the factors 2μ_n/α_n, α_n of all terms, then β_n = ν_n/(1 − 2ν_n), and `BLATZ` with μ alone. FEBio: `Ogden unconstrained`,
//! Σ (c_n/m_n²)(Σλ^m_n − 3 − m_n ln J) + ½ c_p (J − 1)²: with c_p = 0 a foam of ν = 0. SOFA has no foam law. For CalculiX a single term is written as
//! two halves, because version 2.20 stops with a singular matrix at `N=1`.

use super::ansys::data;
use super::cards::{self, Card, options};
use super::energy::{Energy, FOAM};
use super::error::KeywordError;
use super::numbers::{number, numbers};
use super::program::Program;
use roxmltree::Node;

/// Numbers per line in Abaqus and in Ansys
const LINE: [usize; 2] = [cards::LINE, 6];
/// Poisson's ratio below which it counts as zero \[–\]
const NONE: f64 = 1e-12;

/// The text of a foam.
pub fn write(energy: &Energy, program: Program, scale: f64) -> Result<String, KeywordError> {
    let mut terms: Vec<[f64; 3]> = energy.constants.chunks_exact(3).map(|t| [t[0] * scale, t[1], t[2]]).collect();
    if let (Program::Calculix, &[[mu, alpha, nu]]) = (program, &terms[..]) {
        // The tangent of CalculiX 2.20 is singular for one term; two halves of it have the same energy
        terms = vec![[0.5 * mu, alpha, nu]; 2];
    }
    let count = terms.len();
    let lines = |values: &[f64], length: usize| -> Vec<String> {
        let joined = |l: &[f64]| l.iter().map(|x| number(*x)).collect::<Vec<_>>().join(",");
        values.chunks(length).map(joined).collect()
    };
    let own = |f: fn(&[f64; 3]) -> [f64; 2]| terms.iter().flat_map(f);
    match program {
        Program::Abaqus | Program::Calculix => {
            let values: Vec<f64> = own(|t| [t[0], t[1]]).chain(terms.iter().map(|t| t[2])).collect();
            let body: String = lines(&values, LINE[0]).iter().map(|l| format!("{}\n", l.replace(',', ", "))).collect();
            Ok(format!("*HYPERFOAM, N={count}\n{body}"))
        }
        Program::Ansys => {
            let beta = |t: &[f64; 3]| t[2] / (1.0 - 2.0 * t[2]);
            let values: Vec<f64> = own(|t| [2.0 * t[0] / t[1], t[1]]).chain(terms.iter().map(beta)).collect();
            let line = |(k, l): (usize, &String)| format!("TBDATA,{},{l}\n", 1 + LINE[1] * k);
            let body: String = lines(&values, LINE[1]).iter().enumerate().map(line).collect();
            Ok(format!("TB,HYPER,1,1,{count},FOAM\n{body}"))
        }
        Program::Febio if terms.iter().all(|t| t[2].abs() < NONE) => {
            let mut text = "<material id=\"1\" name=\"foam\" type=\"Ogden unconstrained\">\n".to_string();
            for (n, [mu, alpha, _]) in terms.iter().enumerate() {
                let (c, m) = (number(2.0 * mu), number(*alpha));
                text += &format!("  <c{0}>{c}</c{0}>\n  <m{0}>{m}</m{0}>\n", n + 1);
            }
            Ok(text + "  <cp>0</cp>\n</material>\n")
        }
        Program::Febio => Err(energy.refuse(program, " where Poisson's ratio is not zero")),
        Program::Sofa => Err(energy.refuse(program, "")),
    }
}

fn energy(terms: &[[f64; 3]], scale: f64) -> Energy {
    let constants: Vec<f64> = terms.iter().flat_map(|[mu, alpha, nu]| [mu * scale, *alpha, *nu]).collect();
    // κ follows from the terms
    Energy { law: FOAM.into(), constants, kappa: 0.0, volumetric: None }
}

/// Refuses a number of terms that Durometer does not have.
fn check_count(program: Program, count: usize, head: &str) -> Result<(), KeywordError> {
    if (1..=3).contains(&count) {
        return Ok(());
    }
    Err(unreadable(program, format!("\"{head}\" has {count} terms; Durometer has 1 to 3")))
}

/// Terms from the numbers μ_n, α_n of all terms, followed by one more number for each term.
fn terms(program: Program, values: &[f64], count: usize, head: &str) -> Result<Vec<[f64; 3]>, KeywordError> {
    check_count(program, count, head)?;
    if values.len() < 3 * count || values[3 * count..].iter().any(|v| *v != 0.0) {
        return Err(unreadable(
            program,
            format!("{} numbers below \"{head}\", {} are needed", values.len(), 3 * count),
        ));
    }
    Ok((0..count).map(|n| [values[2 * n], values[2 * n + 1], values[2 * count + n]]).collect())
}

fn unreadable(program: Program, what: String) -> KeywordError {
    KeywordError::Unreadable { program, what }
}

/// Reads a `*HYPERFOAM`.
pub fn read_abaqus(card: &Card, program: Program, scale: f64) -> Result<Energy, KeywordError> {
    let head = card.head.as_str();
    let given = options(head);
    if let Some(other) = ["TEST DATA INPUT", "POISSON"].iter().find(|o| given.contains_key(**o)) {
        return Err(unreadable(program, format!("\"{head}\" has {other}; give the constants of the terms")));
    }
    let count = match given.get("N") {
        None => 1,
        Some(n) => n.parse().map_err(|_| unreadable(program, format!("N = {n} is no number")))?,
    };
    check_count(program, count, head)?;
    Ok(energy(&terms(program, &card.constants(program, 3 * count)?, count, head)?, scale))
}

/// Reads the first `TB,HYPER` if it has `FOAM` or `BLATZ`.
pub fn read_ansys(text: &str, scale: f64) -> Result<Option<Energy>, KeywordError> {
    let program = Program::Ansys;
    let (head, points, option, values) = data(text)?;
    match option.as_str() {
        "BLATZ" => match values.first() {
            Some(mu) => Ok(Some(energy(&[[*mu, -2.0, 0.25]], scale))),
            None => Err(unreadable(program, format!("no number below \"{head}\""))),
        },
        "FOAM" => {
            let terms = terms(program, &values, points, &head)?;
            let own = |[factor, alpha, beta]: &[f64; 3]| [0.5 * factor * alpha, *alpha, beta / (1.0 + 2.0 * beta)];
            Ok(Some(energy(&terms.iter().map(own).collect::<Vec<_>>(), scale)))
        }
        _ => Ok(None),
    }
}

/// Reads a material `Ogden unconstrained` of FEBio.
pub fn read_febio(material: Node, scale: f64) -> Result<Energy, KeywordError> {
    let program = Program::Febio;
    let value = |key: &str| -> Result<Option<f64>, KeywordError> {
        let text = material.children().find(|n| n.has_tag_name(key)).and_then(|n| n.text());
        text.map_or(Ok(None), |t| Ok(numbers(program, &[t])?.first().copied()))
    };
    if value("cp")?.is_some_and(|cp| cp != 0.0) {
        return Err(unreadable(program, "cp is not zero, which no foam of Durometer has".into()));
    }
    let mut terms = vec![];
    for n in 1..=6 {
        // In FEBio a missing c is zero, and a missing m is one
        match (value(&format!("c{n}"))?, value(&format!("m{n}"))?) {
            (Some(c), m) if c != 0.0 => terms.push([0.5 * c, m.unwrap_or(1.0), 0.0]),
            _ => {}
        }
    }
    match terms.len() {
        1..=3 => Ok(energy(&terms, scale)),
        n => Err(unreadable(program, format!("{n} terms of a foam; Durometer has 1 to 3"))),
    }
}
