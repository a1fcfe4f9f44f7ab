//! Recognises the content of a column by the words of its name, as testing machines write them in English, German and French.

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
    /// u \[m\], divided by the gauge length; in simple shear by the thickness that is sheared
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
    /// F \[N\], divided by the undeformed cross-section
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

/// A kind and the certainty of the name about it; the most certain column is taken.
pub type Ranked<K> = Option<(u8, K)>;

/// Rank below which the name does not state the kind
pub const SURE: u8 = 4;

const TRUE: &[&str] = &["true", "log", "logarithmic", "hencky", "cauchy", "wahre", "logarithmische", "vraie"];
const NOMINAL: &[&str] = &["engineering", "eng", "nominal", "pk", "piola", "technische", "shear", "schub"];
const STRETCH: &[&str] = &["stretch", "lambda", "λ", "streckgrad", "streckverhältnis"];
/// The two words of Treloar's name of λ, "extension ratio"; "extension" alone is a displacement
const EXTENSION: &[&str] = &["extension"];
const RATIO: &[&str] = &["ratio", "ratios"];
const STRAIN: &[&str] = &[
    "strain",
    "dehnung",
    "stauchung",
    "verformung",
    "elongation",
    "déformation",
    "deformation",
    "scherung",
    "gamma",
    "γ",
];
const LENGTH: &[&str] = &[
    "displacement",
    "disp",
    "extension",
    "ext",
    "extensometer",
    "crosshead",
    "position",
    "travel",
    "traverse",
    "weg",
    "verlängerung",
    "längenänderung",
    "stroke",
    "déplacement",
    "allongement",
];
const STRESS: &[&str] = &["stress", "spannung", "contrainte"];
const FORCE: &[&str] = &["force", "load", "kraft", "standardkraft"];
const TIME: &[&str] = &["time", "zeit", "temps"];
/// Words that turn a strain or stress into something else: a rate, a characteristic value, another kind of test
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
    "strength",
    "peak",
    "ultimate",
    "at",
    "flexure",
    "flexural",
    "bending",
    "torsion",
    "torsional",
];
/// Beginnings of German compounds that do the same as [`OTHER`]
const OTHER_BEGINNINGS: [&str; 9] = ["vor", "bruch", "reiß", "reiss", "höchst", "biege", "rest", "end", "quer"];
/// Words of a note in brackets, which is not a unit
const NOTE: &[&str] = &[
    "channel",
    "corrected",
    "raw",
    "smoothed",
    "video",
    "axial",
    "gauge",
    "sensor",
    "average",
    "mean",
    "specimen",
    "sample",
    "test",
    "tensile",
    "tension",
    "compressive",
    "compression",
    "machine",
    "measured",
    "calculated",
];
/// Signs in brackets for numbers without a unit
const NO_UNIT: &[&str] = &["-", "–", "1"];
/// Endings of German compounds, which say what the quantity is
const ENDINGS: [&str; 5] = ["dehnung", "spannung", "kraft", "weg", "zeit"];

/// The words of a name in lower case, without the numbers that count directions: `λ1`, `stress_2`.
pub(super) fn words(name: &str) -> Vec<String> {
    let name = name.to_lowercase();
    let parts = name.split(|c: char| !c.is_alphanumeric()).map(|w| w.trim_end_matches(char::is_numeric));
    parts.filter(|w| !w.is_empty()).map(String::from).collect()
}

fn has(words: &[String], any: &[&str]) -> bool {
    let other = |w: &String| OTHER_BEGINNINGS.iter().any(|b| w.starts_with(b));
    let ends = |w: &String, a: &&str| ENDINGS.contains(a) && w.ends_with(a) && !other(w);
    words.iter().any(|w| any.iter().any(|a| w == a || ends(w, a)))
}

pub fn strain(name: &str) -> Ranked<StrainKind> {
    let w = words(name);
    if has(&w, OTHER) || has(&w, STRESS) || has(&w, FORCE) {
        return None;
    }
    let is_length = unit(name).is_some_and(|u| factor(&u, Dimension::LENGTH).is_some());
    if has(&w, STRETCH) || (has(&w, EXTENSION) && has(&w, RATIO)) {
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
        // testXpert also shows "Standardkraft" in MPa
        let is_stress = unit(name).is_some_and(|u| factor(&u, Dimension::PRESSURE).is_some());
        Some(if is_stress { (3, StressKind::Nominal) } else { (1, StressKind::Force) })
    } else {
        None
    }
}

pub fn is_time(name: &str) -> bool {
    has(&words(name), TIME)
}

/// A condition of a test that moduli depend on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Condition {
    Temperature,
    Amplitude,
}

/// The condition that a column records.
pub fn condition(name: &str) -> Option<Condition> {
    let w = words(name);
    if has(&w, &["temperature", "temp", "temperatur", "température"]) {
        Some(Condition::Temperature)
    } else {
        has(&w, &["amplitude", "dehnungsamplitude", "dehnungsamplituden"]).then_some(Condition::Amplitude)
    }
}

/// True for the name of a frequency in radians: "Angular frequency", "ω", "Kreisfrequenz".
pub fn is_angular(name: &str) -> bool {
    const ANGULAR: &[&str] =
        &["angular", "circular", "omega", "ω", "kreisfrequenz", "winkelfrequenz", "pulsation", "angulaire"];
    has(&words(name), ANGULAR)
}

/// True for a name of tan δ: "tan delta", "tan_delta", "Tan(delta)", "tanδ", "Loss factor", "Verlustfaktor".
pub fn is_tan_delta(name: &str) -> bool {
    const ONE: &[&str] = &["tandelta", "tanδ", "tand", "verlustfaktor"];
    const TWO: [(&[&str], &[&str]); 2] =
        [(&["tan", "tangent", "tangens", "tangente"], &["delta", "δ", "d"]), (&["loss"], &["factor", "tangent"])];
    let w = words(name);
    let is_pair = |p: &[String]| TWO.iter().any(|(a, b)| a.contains(&p[0].as_str()) && b.contains(&p[1].as_str()));
    has(&w, ONE) || w.windows(2).any(is_pair) || w == ["tan"]
}

/// True for a logarithmic strain, "True strain", "log. Dehnung", also across the load or of a volume.
pub fn is_true(name: &str) -> bool {
    has(&words(name), TRUE)
}

/// True for a stretch, also across the load, as in "lateral stretch".
pub fn is_stretch(name: &str) -> bool {
    has(&words(name), STRETCH)
}

/// Content of a column of volume.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum VolumeKind {
    /// J \[–\]
    Ratio,
    /// J − 1 \[–\]
    Change,
}

/// The content of a column of volume by its name; `None` if the name does not say, as in "Volume (%)".
pub fn volume(name: &str) -> Option<VolumeKind> {
    const CHANGE: &[&str] = &[
        "change",
        "strain",
        "dilatation",
        "reduction",
        "decrease",
        "änderung",
        "volumenänderung",
        "dehnung",
        "variation",
        "delta",
        "dv",
        "δv",
    ];
    const RATIO_WORDS: &[&str] = &["relative", "relatives", "relatif", "normalised", "normalized", "normiertes", "j"];
    let w = words(name);
    if has(&w, CHANGE) {
        Some(VolumeKind::Change)
    } else if has(&w, RATIO) || has(&w, RATIO_WORDS) || name.to_lowercase().contains("v/v0") {
        Some(VolumeKind::Ratio)
    } else {
        None
    }
}

/// True for names that count compression as positive: "Compressive stress", "Stauchung", "Druckkraft".
pub fn is_compressive(name: &str) -> bool {
    words(name).iter().any(|w| ["compress", "druck", "stauch"].iter().any(|b| w.starts_with(b)))
}

/// True for a strain that is derived from the travel of the crosshead: "Tensile strain (Displacement)".
pub fn is_travel(name: &str) -> bool {
    has(&words(name), &["displacement", "crosshead", "position", "travel", "traverse", "stroke", "weg"])
}

/// True for the name of a column that tells specimens apart: "Specimen", "Sample ID", "Probe Nr.".
pub fn is_specimen(name: &str) -> bool {
    const WHAT: &[&str] = &["specimen", "sample", "probe", "prüfkörper", "éprouvette"];
    const WHICH: &[&str] = &["id", "label", "name", "no", "nr", "number", "nummer"];
    let w = words(name);
    has(&w, WHAT) && w.iter().all(|w| [WHAT, WHICH].iter().any(|list| list.contains(&w.as_str())))
}

/// Factor from a unit of strain to fractions.
pub fn strain_factor(unit: &str) -> Option<f64> {
    match unit.to_lowercase().as_str() {
        "1" | "-" | "–" | "mm/mm" | "m/m" | "in/in" => Some(1.0),
        "%" | "percent" | "pct" | "prozent" => Some(0.01),
        "‰" | "mm/m" => Some(1e-3),
        "µε" | "με" | "microstrain" | "um/m" | "µm/m" | "μm/m" => Some(1e-6),
        _ => None,
    }
}

/// Factor to SI of a unit in the spelling of testing machines.
pub fn factor(unit: &str, dimension: Dimension) -> Option<f64> {
    units::parse(&format!("1 {}", units::spelled(unit)), dimension).ok()
}

/// The contents of brackets in a name, in order.
fn brackets(name: &str) -> Vec<&str> {
    let mut found = Vec::new();
    let mut rest = name;
    while let Some(open) = rest.find(['(', '[']) {
        let close = if rest[open..].starts_with('(') { ')' } else { ']' };
        let Some(end) = rest[open..].find(close) else { break };
        found.push(rest[open + 1..open + end].trim());
        rest = &rest[open + end + 1..];
    }
    found
}

/// The unit in a column name: in the last brackets that are not a note, or the last word if it is a unit of stress, force or length or a percent
/// sign.
pub fn unit(name: &str) -> Option<String> {
    let is_note = |text: &&&str| {
        let w = words(text);
        let lists = [STRAIN, STRESS, STRETCH, TRUE, NOMINAL, LENGTH, FORCE, NOTE];
        !is_unit(text) && lists.iter().any(|list| has(&w, list))
    };
    let groups = brackets(name);
    if let Some(unit) = groups.iter().rev().find(|g| !is_note(g)) {
        return (!unit.is_empty() && !NO_UNIT.contains(unit)).then(|| unit.to_string());
    }
    let last = |c: &[char]| name.rsplit(c).next().map(str::trim).filter(|u| is_unit(u)).map(String::from);
    last(&[' ']).or_else(|| last(&['_'])).or_else(|| last(&['/', ',']))
}

/// True for a name whose brackets say that its numbers have no unit: "strain [-]", "strain (1)".
pub fn is_unitless(name: &str) -> bool {
    brackets(name).iter().any(|g| NO_UNIT.contains(g))
}

/// True for a unit that is recognised without brackets; "in" and "s" are not, because they may be words.
pub fn is_unit(word: &str) -> bool {
    matches!(word, "%" | "mm" | "cm" | "N" | "kN" | "mN" | "lbf" | "mm/mm" | "in/in")
        || factor(word, Dimension::PRESSURE).is_some()
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
            ("Tensile strain (Strain 1) [%]", Some("%")),
            ("Tensile strain (Displacement) (%)", Some("%")),
            ("Tensile strain (Strain 1)", None),
            ("Stress (Corrected) [N/mm2]", Some("N/mm2")),
            ("Force (Channel 1)", None),
            ("Spannung N/mm²", Some("N/mm²")),
        ] {
            assert_eq!(unit(name).as_deref(), expected, "{name}");
        }
    }

    #[test]
    fn brackets_may_say_that_there_is_no_unit() {
        for (name, expected) in [
            ("strain [-]", true),
            ("strain (1)", true),
            ("Tensile strain (Strain 1) [–]", true),
            ("strain", false),
            ("strain ()", false),
            ("strain [%]", false),
        ] {
            assert_eq!(is_unitless(name), expected, "{name}");
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
            ("Travel [mm]", Some(Displacement)),
            ("λ1", Some(Stretch)),
            ("extension ratio", Some(Stretch)),
            ("Extension_Ratio [-]", Some(Stretch)),
            ("Streckverhältnis", Some(Stretch)),
            ("Poisson's ratio", None),
            ("shear strain γ", Some(Engineering)),
            ("Stauchung [%]", Some(Engineering)),
            ("Verformung [%]", Some(Engineering)),
            ("Extensometer (mm/mm)", Some(Engineering)),
            ("strain rate (1/s)", None),
            ("Tensile strain at Break (%)", None),
            ("Bruchdehnung", None),
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
            ("Standardkraft [MPa]", Some(StressKind::Nominal)),
            ("Flexure stress (MPa)", None),
            ("Tensile strength (MPa)", None),
            ("Höchstkraft [N]", None),
            ("Vorspannung", None),
            ("Load Cell", None),
        ] {
            assert_eq!(stress(name).map(|r| r.1), kind, "{name}");
        }
        assert!(is_time("Prüfzeit [s]") && !is_time("Dehnung"));
        assert!(is_compressive("Compressive stress (MPa)") && is_compressive("Druckkraft") && !is_compressive("Load"));
        assert!(is_specimen("Specimen ID") && is_specimen("Probe Nr.") && !is_specimen("Specimen width"));
    }

    #[test]
    fn spellings_of_machines_are_units() {
        let pressure = |u: &str| factor(u, Dimension::PRESSURE);
        for (unit, pascal) in [
            ("N/mm2", 1e6),
            ("N/mm²", 1e6),
            ("N/mm**2", 1e6),
            ("Mpa", 1e6),
            ("KPa", 1e3),
            ("kN/m2", 1e3),
            ("ksi", 6894757.293168361),
            ("lbf/in2", 6894.757293168361),
        ] {
            assert!((pressure(unit).expect(unit) / pascal - 1.0).abs() < 1e-12, "{unit}: {:?}", pressure(unit));
        }
        for unit in ["mpa", "mPa", "V", "kg/cm2", ""] {
            assert_eq!(pressure(unit), None, "{unit}");
        }
    }
}
