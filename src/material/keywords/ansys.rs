//! `TB,HYPER` and `TBDATA` of Ansys: constants in this order, then d = 2/κ, six numbers to a line.
//!
//! U = (J − 1)²/d; for `GENT` and `BOYCE` (½(J² − 1) − ln J)/d. Ogden's energy is Σ (μ_n/α_n)(Σλ̄^α_n − 3).

use super::energy::{COUPLED, Energy, OGDEN, SPLIT};
use super::error::KeywordError;
use super::numbers::{kappa_of, number, numbers};
use super::program::Program;
use crate::material::VolumetricKind;

/// Numbers per line
const LINE: usize = 6;
const PROGRAM: Program = Program::Ansys;

/// The commands, and their volumetric part.
pub fn write(energy: &Energy, scale: f64) -> Result<(String, Option<VolumetricKind>), KeywordError> {
    let c = &energy.constants;
    let at = |k: usize| c.get(k).copied().unwrap_or(0.0) * scale;
    let mut kind = VolumetricKind::Quadratic;
    let (points, option, mut values) = match energy.law.as_str() {
        COUPLED | SPLIT => (String::new(), "NEO", vec![at(0)]),
        "mooney_rivlin" if c.len() < 4 => (c.len().to_string(), "MOONEY", (0..c.len()).map(at).collect()),
        "mooney_rivlin" => ("5".into(), "MOONEY", vec![at(0), at(1), at(3), at(2), at(4)]),
        "yeoh" => (c.len().to_string(), "YEOH", (0..c.len()).map(at).collect()),
        OGDEN => {
            let terms = c.chunks_exact(2).flat_map(|v| [v[0] / v[1] * scale, v[1]]);
            ((c.len() / 2).to_string(), "OGDEN", terms.collect())
        }
        "gent" | "arruda_boyce" => {
            kind = VolumetricKind::SimoTaylor;
            (String::new(), if energy.law == "gent" { "GENT" } else { "BOYCE" }, vec![at(0), c[1]])
        }
        _ => return Err(energy.refuse(PROGRAM, "")),
    };
    values.push(2.0 / (energy.kappa * scale));
    let mut text = format!("TB,HYPER,1,1,{points},{option}\n");
    for (k, line) in values.chunks(LINE).enumerate() {
        let line: Vec<String> = line.iter().map(|x| number(*x)).collect();
        text += &format!("TBDATA,{},{}\n", 1 + LINE * k, line.join(","));
    }
    Ok((text, Some(kind)))
}

/// A line without its comment, in upper case.
fn bare(line: &str) -> String {
    line.split('!').next().unwrap_or("").trim().to_uppercase()
}

/// The words of a command.
fn words(line: &str) -> Vec<&str> {
    line.split(',').map(str::trim).collect()
}

fn is_law(words: &[&str]) -> bool {
    words[0] == "TB" && words.get(1).is_some_and(|w| w.starts_with("HYPER"))
}

/// Whether two commands belong to one material, which need not be named.
fn of_one_material(a: &[&str], b: &[&str]) -> bool {
    let [a, b] = [a, b].map(|words| words.get(2).copied().unwrap_or(""));
    a.is_empty() || b.is_empty() || a == b
}

/// Commands that add to the law of the first `TB,HYPER` for its material: further tables and properties, but not the density.
pub fn passed_over(text: &str) -> Vec<String> {
    let lines: Vec<String> = text.lines().map(bare).collect();
    let commands: Vec<Vec<&str>> = lines.iter().map(|l| words(l)).collect();
    let Some(law) = commands.iter().position(|c| is_law(c)) else { return vec![] };
    let gives = |c: &[&str]| ["TB", "MP", "MPDATA"].contains(&c[0]) && c.get(1).is_some_and(|label| *label != "DENS");
    let others =
        commands.iter().enumerate().filter(|(k, c)| *k != law && gives(c) && of_one_material(c, &commands[law]));
    let mut found: Vec<String> = others.map(|(_, c)| format!("{},{}", c[0], c[1])).collect();
    found.sort();
    found.dedup();
    found
}

/// The first `TB,HYPER`: the line, its number of terms, the name of the law, and the numbers below it.
pub fn data(text: &str) -> Result<(String, usize, String, Vec<f64>), KeywordError> {
    let refuse = |what: String| KeywordError::Unreadable { program: PROGRAM, what };
    let mut lines = text.lines().map(bare).filter(|l| !l.is_empty());
    let head = lines.find(|l| is_law(&words(l))).ok_or_else(|| refuse("no TB,HYPER".into()))?;
    let words = words(&head);
    check_relaxation(text, &words)?;
    let (points, option) = (words.get(4).copied().unwrap_or(""), words.get(5).copied().unwrap_or("MOONEY"));
    let mut values: Vec<f64> = vec![];
    let is_temperature = |l: &String| l.starts_with("TBTEMP");
    // The table is open until the next one
    let below: Vec<String> = lines
        .take_while(|l| self::words(l)[0] != "TB")
        .filter(|l| l.starts_with("TBDATA") || is_temperature(l))
        .collect();
    if below.iter().filter(|l| is_temperature(l)).count() > 1 {
        return Err(refuse(format!(
            "the constants of \"{head}\" depend on temperature; keep those of one temperature"
        )));
    }
    for line in below.iter().filter(|l| !is_temperature(l)) {
        let all = numbers(PROGRAM, &line.split(',').skip(1).collect::<Vec<_>>())?;
        let (first, rest) = all.split_first().ok_or_else(|| refuse(format!("\"{line}\" has no numbers")))?;
        // A table has at most 100 places
        let place =
            Some(*first as usize).filter(|k| (1..100).contains(k)).ok_or_else(|| refuse(format!("place {first}")))?;
        values.resize(values.len().max(place - 1 + rest.len()), 0.0);
        values[place - 1..place - 1 + rest.len()].copy_from_slice(rest);
    }
    let count =
        if points.is_empty() { 1 } else { points.parse().map_err(|_| refuse(format!("NPTS = \"{points}\"")))? };
    let option = option.to_string();
    Ok((head, count, option, values))
}

/// Refuses a material that relaxes: whether the constants of `TB,HYPER` are then instantaneous or long-term moduli is a choice of the model.
fn check_relaxation(text: &str, law: &[&str]) -> Result<(), KeywordError> {
    let of_it = |line: &str| {
        let line = bare(line);
        let words = words(&line);
        words[0] == "TB" && words.get(1) == Some(&"PRONY") && of_one_material(&words, law)
    };
    let Some(line) = text.lines().find(|l| of_it(l)) else { return Ok(()) };
    let what = format!(
        "the material relaxes (\"{}\"), which is not read: leave the command out, and give its shares and times as `prony` of the effect viscoelastic, \
         whose `moduli` says whether the constants are instantaneous or long-term ones",
        line.trim()
    );
    Err(KeywordError::Unreadable { program: PROGRAM, what })
}

/// Reads the first `TB,HYPER`.
pub fn read(text: &str, scale: f64) -> Result<Energy, KeywordError> {
    let refuse = |what: String| KeywordError::Unreadable { program: PROGRAM, what };
    let (head, count, option, values) = data(text)?;
    let (law, own) = match (option.as_str(), count) {
        ("NEO", _) => (SPLIT, 1),
        ("MOONEY", 2 | 3 | 5) => ("mooney_rivlin", count),
        ("YEOH", 1..=3) => ("yeoh", count),
        ("OGDEN", 1..=4) => (OGDEN, 2 * count),
        ("GENT", _) => ("gent", 2),
        ("BOYCE", _) => ("arruda_boyce", 2),
        _ => return Err(refuse(format!("\"{head}\" is no law of Durometer"))),
    };
    if values.len() <= own {
        return Err(refuse(format!("{} numbers below \"{head}\", at least {} are needed", values.len(), own + 1)));
    }
    let kappa = kappa_of(PROGRAM, &values[own..], scale)?;
    let v = &values[..own];
    let constants = match law {
        OGDEN => v.chunks_exact(2).flat_map(|v| [v[0] * v[1] * scale, v[1]]).collect(),
        "gent" | "arruda_boyce" => vec![v[0] * scale, v[1]],
        "mooney_rivlin" if own == 5 => [v[0], v[1], v[3], v[2], v[4]].map(|x| x * scale).to_vec(),
        _ => v.iter().map(|x| x * scale).collect(),
    };
    let simo = matches!(law, "gent" | "arruda_boyce");
    let kind = if simo { VolumetricKind::SimoTaylor } else { VolumetricKind::Quadratic };
    Ok(Energy { law: law.into(), constants, kappa, volumetric: Some(kind) })
}
