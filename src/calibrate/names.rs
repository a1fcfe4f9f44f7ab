//! Content of a column by the words of its name, as testing machines write them in English, German and French.

use crate::math::units::{self, Dimension};
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// Content of a strain column, with e = λ − 1.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StrainKind {
    /// λ \[–\]
    Stretch,
    /// e \[–\]; in simple shear γ \[–\]
    Engineering,
    /// ln λ \[–\]
    True,
    /// u \[m\], over the gauge length; in simple shear over the thickness that is sheared
    Displacement,
}

/// Content of a stress column.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StressKind {
    /// P \[Pa\], force over undeformed area
    Nominal,
    /// σ \[Pa\], force over deformed area
    True,
    /// F \[N\], over the undeformed cross-section
    Force,
}

impl FromStr for StrainKind {
    type Err = String;
    fn from_str(word: &str) -> Result<Self, String> {
        match word {
            "stretch" => Ok(Self::Stretch),
            "engineering" => Ok(Self::Engineering),
            "true" => Ok(Self::True),
            "displacement" => Ok(Self::Displacement),
            _ => Err(format!("\"{word}\" is not a kind of strain; known: stretch, engineering, true, displacement")),
        }
    }
}

impl FromStr for StressKind {
    type Err = String;
    fn from_str(word: &str) -> Result<Self, String> {
        match word {
            "nominal" => Ok(Self::Nominal),
            "true" => Ok(Self::True),
            "force" => Ok(Self::Force),
            _ => Err(format!("\"{word}\" is not a kind of stress; known: nominal, true, force")),
        }
    }
}

impl StrainKind {
    pub fn words(self) -> &'static str {
        match self {
            Self::Stretch => "stretch",
            Self::Engineering => "engineering strain",
            Self::True => "true strain ln λ",
            Self::Displacement => "displacement",
        }
    }
}

impl StressKind {
    pub fn words(self) -> &'static str {
        match self {
            Self::Nominal => "nominal stress",
            Self::True => "true stress",
            Self::Force => "force",
        }
    }
}

/// A kind and how sure the name is of it: the surest column is taken.
pub type Ranked<K> = Option<(u8, K)>;

/// Below this rank the name has no word on the kind
pub const SURE: u8 = 4;

const TRUE: &[&str] = &["true", "log", "logarithmic", "hencky", "cauchy", "wahre", "logarithmische", "vraie"];
const NOMINAL: &[&str] = &["engineering", "eng", "nominal", "pk", "piola", "technische", "shear", "schub"];
const STRETCH: &[&str] = &["stretch", "lambda", "λ", "streckgrad"];
const STRAIN: &[&str] = &["strain", "dehnung", "elongation", "déformation", "deformation", "scherung", "gamma", "γ"];
const LENGTH: &[&str] = &[
    "displacement",
    "extension",
    "crosshead",
    "traverse",
    "weg",
    "verlängerung",
    "stroke",
    "déplacement",
    "allongement",
];
const STRESS: &[&str] = &["stress", "spannung", "contrainte"];
const FORCE: &[&str] = &["force", "load", "kraft", "standardkraft"];
const TIME: &[&str] = &["time", "zeit", "temps"];
/// Words that make of a strain or stress something else
const OTHER: &[&str] = &[
    "rate",
    "speed",
    "cell",
    "energy",
    "work",
    "modulus",
    "lateral",
    "transverse",
    "querdehnung",
    "poisson",
    "break",
    "yield",
    "max",
    "maximum",
];
/// German compounds end with what they are
const ENDINGS: [&str; 5] = ["dehnung", "spannung", "kraft", "weg", "zeit"];

/// Lower case, without the numbers that count directions: `λ1`, `stress_2`.
fn words(name: &str) -> Vec<String> {
    let name = name.to_lowercase();
    let parts = name.split(|c: char| !c.is_alphanumeric()).map(|w| w.trim_end_matches(char::is_numeric));
    parts.filter(|w| !w.is_empty()).map(String::from).collect()
}

fn has(words: &[String], any: &[&str]) -> bool {
    let ends = |w: &String, a: &&str| ENDINGS.contains(a) && w.ends_with(a) && !w.starts_with("vor");
    words.iter().any(|w| any.iter().any(|a| w == a || ends(w, a)))
}

pub fn strain(name: &str) -> Ranked<StrainKind> {
    let w = words(name);
    if has(&w, OTHER) || has(&w, STRESS) || has(&w, FORCE) {
        return None;
    }
    let is_length = unit(name).is_some_and(|u| units::parse(&format!("1 {u}"), Dimension::LENGTH).is_ok());
    if has(&w, STRETCH) {
        Some((SURE + 1, StrainKind::Stretch))
    } else if has(&w, LENGTH) || (is_length && has(&w, STRAIN)) {
        // "Extension (%)" is a strain
        let is_strain = unit(name).is_some_and(|u| strain_factor(&u).is_some());
        Some(if is_strain { (3, StrainKind::Engineering) } else { (1, StrainKind::Displacement) })
    } else if has(&w, STRAIN) {
        Some(match () {
            () if has(&w, TRUE) => (2, StrainKind::True),
            () if has(&w, NOMINAL) => (SURE, StrainKind::Engineering),
            () => (3, StrainKind::Engineering),
        })
    } else {
        None
    }
}

pub fn stress(name: &str) -> Ranked<StressKind> {
    let w = words(name);
    if has(&w, OTHER) {
        None
    } else if has(&w, STRESS) {
        Some(match () {
            () if has(&w, TRUE) => (2, StressKind::True),
            () if has(&w, NOMINAL) || w.iter().any(|x| x.starts_with("nenn")) => (SURE, StressKind::Nominal),
            () => (3, StressKind::Nominal),
        })
    } else if has(&w, FORCE) {
        Some((1, StressKind::Force))
    } else {
        None
    }
}

pub fn is_time(name: &str) -> bool {
    has(&words(name), TIME)
}

/// Factor of a unit of strain.
pub fn strain_factor(unit: &str) -> Option<f64> {
    match unit {
        "1" | "mm/mm" | "m/m" | "in/in" => Some(1.0),
        "%" | "percent" | "pct" => Some(0.01),
        _ => None,
    }
}

/// A unit in a column name: in brackets, or the last word where that is a unit of stress, force, length or a percent sign.
pub fn unit(name: &str) -> Option<String> {
    for (open, close) in [('(', ')'), ('[', ']')] {
        if let (Some(a), Some(b)) = (name.rfind(open), name.rfind(close))
            && a < b
        {
            let unit = name[a + open.len_utf8()..b].trim();
            return (!matches!(unit, "" | "-" | "–" | "1")).then(|| unit.to_string());
        }
    }
    let last = |c: &[char]| name.rsplit(c).next().map(str::trim).filter(|u| is_unit(u)).map(String::from);
    last(&[' ']).or_else(|| last(&['_'])).or_else(|| last(&['/', ',']))
}

/// True of a unit that is written without brackets; "in" and "s" may be words.
pub fn is_unit(word: &str) -> bool {
    matches!(word, "%" | "mm" | "cm" | "N" | "kN" | "mN")
        || units::parse(&format!("1 {word}"), Dimension::PRESSURE).is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_from_column_names() {
        for (name, expected) in [
            ("Engineering Stress (MPa)", Some("MPa")),
            ("nominal_stress_MPa", Some("MPa")),
            ("stress [N/mm^2]", Some("N/mm^2")),
            ("Stress / kPa", Some("kPa")),
            ("stress N/mm^2", Some("N/mm^2")),
            ("strain %", Some("%")),
            ("strain (-)", None),
            ("nominal stress", None),
            ("stress (mpa)", Some("mpa")),
            ("Standardkraft in N", Some("N")),
            ("Extension mm", Some("mm")),
            ("plugged in", None),
        ] {
            assert_eq!(unit(name).as_deref(), expected, "{name}");
        }
    }

    #[test]
    fn names_of_three_languages_say_what_they_hold() {
        use StrainKind::{Displacement, Engineering, Stretch};
        for (name, kind) in [
            ("Dehnung [%]", Some(Engineering)),
            ("technische Dehnung", Some(Engineering)),
            ("wahre Dehnung", Some(StrainKind::True)),
            ("Hencky strain", Some(StrainKind::True)),
            ("Traversenweg [mm]", Some(Displacement)),
            ("Standardweg", Some(Displacement)),
            ("Weg in mm", Some(Displacement)),
            ("Extension (mm)", Some(Displacement)),
            ("Extension (%)", Some(Engineering)),
            ("Elongation (mm)", Some(Displacement)),
            ("Déplacement (mm)", Some(Displacement)),
            ("λ1", Some(Stretch)),
            ("shear strain γ", Some(Engineering)),
            ("strain rate (1/s)", None),
            ("Querdehnung", None),
            ("transverse strain", None),
            ("Time (s)", None),
        ] {
            assert_eq!(strain(name).map(|r| r.1), kind, "{name}");
        }
        for (name, kind) in [
            ("Spannung [MPa]", Some(StressKind::Nominal)),
            ("Nennspannung", Some(StressKind::Nominal)),
            ("wahre Spannung", Some(StressKind::True)),
            ("Cauchy stress", Some(StressKind::True)),
            ("Standardkraft [N]", Some(StressKind::Force)),
            ("Load (N)", Some(StressKind::Force)),
            ("Contrainte (MPa)", Some(StressKind::Nominal)),
            ("Vorspannung", None),
            ("Load Cell", None),
        ] {
            assert_eq!(stress(name).map(|r| r.1), kind, "{name}");
        }
        assert!(is_time("Prüfzeit [s]") && !is_time("Dehnung"));
    }
}
