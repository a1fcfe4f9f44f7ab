//! The list of laws, and the reading of a law from a file: `law = "neo_hookean"`, `E = "100 kPa"`, `nu = 0.45`.

use crate::wording::hint;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::{PoisonError, RwLock};

use super::entry::LawEntry;
use super::law::Law;
use super::parameter::{LawSpecError, Parameter, Values};
use super::{
    arruda_boyce, corotational, gent, hyperfoam, linear, mooney_rivlin, neo_hookean, neo_hookean_split, ogden,
    st_venant_kirchhoff, stable_neo_hookean, veronda_westmann, yeoh,
};
use crate::math::units::{self, Dimension, UnitError};

/// All laws of the library. A new law takes one file and one line here.
pub static LAWS: &[LawEntry] = &[
    linear::ENTRY,
    corotational::ENTRY,
    st_venant_kirchhoff::ENTRY,
    neo_hookean::ENTRY,
    neo_hookean_split::ENTRY,
    stable_neo_hookean::ENTRY,
    mooney_rivlin::ENTRY,
    yeoh::ENTRY,
    ogden::ENTRY,
    gent::ENTRY,
    arruda_boyce::ENTRY,
    veronda_westmann::ENTRY,
    hyperfoam::ENTRY,
];

/// Laws that programs have added to those of the library.
static REGISTERED: RwLock<Vec<&'static LawEntry>> = RwLock::new(Vec::new());

/// Adds a law that is defined outside the library, so that scenes and fits of this process can name it.
///
/// # Errors
///
/// Returns an error if a law of this name exists.
pub fn register(entry: LawEntry) -> Result<&'static LawEntry, LawSpecError> {
    add(entry, false)
}

/// Registers a law as [`register`] does, but replaces a law that was registered before under this name; existing scenes keep the old one.
///
/// # Errors
///
/// Returns an error if the library has a law of this name.
pub fn register_anew(entry: LawEntry) -> Result<&'static LawEntry, LawSpecError> {
    add(entry, true)
}

fn add(entry: LawEntry, anew: bool) -> Result<&'static LawEntry, LawSpecError> {
    let mut registered = REGISTERED.write().unwrap_or_else(PoisonError::into_inner);
    let before = registered.iter().position(|e| e.info.name == entry.info.name);
    if is_of_library(entry.info.name) || (before.is_some() && !anew) {
        return Err(LawSpecError::NameTaken { name: entry.info.name });
    }
    let entry: &'static LawEntry = Box::leak(Box::new(entry));
    match before {
        Some(k) => registered[k] = entry,
        None => registered.push(entry),
    }
    Ok(entry)
}

/// The laws that are known at some time: those of the library, and those that were registered by then. A scene keeps the laws of the time when it was
/// read or written, so that a later law of the same name does not replace its own.
#[derive(Clone)]
pub struct KnownLaws {
    registered: Vec<&'static LawEntry>,
}

impl Default for KnownLaws {
    /// The laws that are known now.
    fn default() -> Self {
        Self { registered: REGISTERED.read().unwrap_or_else(PoisonError::into_inner).clone() }
    }
}

impl fmt::Debug for KnownLaws {
    /// Omits the laws: a scene is the same whatever else is registered.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("KnownLaws")
    }
}

impl KnownLaws {
    fn all(&self) -> impl Iterator<Item = &'static LawEntry> {
        LAWS.iter().chain(self.registered.iter().copied())
    }

    /// The entry of this name.
    ///
    /// # Errors
    ///
    /// Returns an error if no law has this name.
    pub fn find(&self, name: &str) -> Result<&'static LawEntry, LawSpecError> {
        // A name that was registered since then can only mean one law
        let later = || Self::default().all().find(|e| e.info.name == name);
        self.all().find(|e| e.info.name == name).or_else(later).ok_or_else(|| LawSpecError::UnknownLaw {
            name: name.to_string(),
            hint: hint(name, &self.all().map(|e| e.info.name).collect::<Vec<_>>()),
        })
    }

    /// Reads the entry, the values and the options of a law table.
    ///
    /// # Errors
    ///
    /// Returns an error if the law is unknown, a key is unknown, or a value has the wrong type.
    pub fn given(&self, table: &toml::Table) -> Result<Given, LawSpecError> {
        let name = match table.get("law") {
            Some(toml::Value::String(name)) => name,
            Some(other) => return Err(LawSpecError::NameNotText { found: other.to_string() }),
            None => return Err(LawSpecError::NoName { known: self.all().map(|e| e.info.name).collect() }),
        };
        let entry = self.find(name)?;
        let (values, options) = given_as(entry, table)?;
        Ok((entry, values, options))
    }

    /// Reads a law from its table, as [`law_from_table`] does.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`law_from_table`].
    pub fn law(&self, table: &toml::Table) -> Result<Box<dyn Law>, LawSpecError> {
        let (entry, values, options) = self.given(table)?;
        entry.build(&values, &options)
    }
}

/// Whether the library itself has a law of this name. For any other law, which this process has registered, files and builds record only the name.
pub(crate) fn is_of_library(name: &str) -> bool {
    LAWS.iter().any(|e| e.info.name == name)
}

/// The laws of the library and the registered ones.
pub fn laws() -> Vec<&'static LawEntry> {
    KnownLaws::default().all().collect()
}

/// Keys of a law table that are not parameters of the law, with their meanings.
pub(super) const OTHER_KEYS: [(&str, &str); 3] = [
    ("law", "Name of the law"),
    ("provenance", "How the numbers were found, in words or as a table"),
    ("source", "Where the numbers come from, in words or as a table"),
];

/// The entry of this name.
pub fn find(name: &str) -> Result<&'static LawEntry, LawSpecError> {
    KnownLaws::default().find(name)
}

/// The name of a law as in papers; any other name with spaces in place of underscores.
pub fn title(name: &str) -> String {
    laws().iter().find(|e| e.info.name == name).map_or_else(|| name.replace('_', " "), |e| e.info.title.into())
}

/// Contents of a law table: the entry of the law, values \[SI\] and options by key.
pub type Given = (&'static LawEntry, Values, BTreeMap<String, String>);

/// Reads a law from its table in a file.
///
/// ```
/// use durometer::prelude::*;
///
/// let law = law_from_table(&"law = 'neo_hookean'\nE = '100 kPa'\nnu = 0.45".parse()?)?;
/// // The energy of a stretch of 20 % along x, and its first Piola-Kirchhoff stress [J/m^3, Pa]
/// let state = law.eval(&Mat3::from_diagonal(&Vec3::new(1.2, 1.0, 1.0)), Want::Residual)?;
/// assert!(state.psi > 0.0 && state.p[(0, 0)] > state.p[(1, 1)]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Where the law is unknown, a key is missing or unknown, or a value is out of its range or of another unit.
pub fn law_from_table(table: &toml::Table) -> Result<Box<dyn Law>, LawSpecError> {
    KnownLaws::default().law(table)
}

/// Reads the entry, the values and the options of a law table.
pub fn given(table: &toml::Table) -> Result<Given, LawSpecError> {
    KnownLaws::default().given(table)
}

/// Reads the values \[SI\] and the options of a table of this law.
pub(super) fn given_as(
    entry: &LawEntry,
    table: &toml::Table,
) -> Result<(Values, BTreeMap<String, String>), LawSpecError> {
    let (mut values, mut options) = (Values::new(), BTreeMap::new());
    for (key, value) in table.iter().filter(|(key, _)| OTHER_KEYS.iter().all(|(other, _)| other != key)) {
        if let Some(choice) = entry.choice(key) {
            let Some(option) = value.as_str() else {
                return Err(LawSpecError::OptionNotText { choice, found: value.to_string() });
            };
            options.insert(key.clone(), option.to_string());
        } else {
            values.insert(key.clone(), quantity(entry.key(key)?, value)?);
        }
    }
    Ok((values, options))
}

/// Reads a quantity of a file \[SI\].
pub(crate) fn quantity(p: &Parameter, value: &toml::Value) -> Result<f64, LawSpecError> {
    let unit = |source| LawSpecError::Unit { key: p.name, source };
    match value {
        toml::Value::String(text) => units::parse(text, p.dimension).map_err(unit),
        toml::Value::Float(x) if p.dimension == Dimension::NONE => Ok(*x),
        toml::Value::Integer(n) if p.dimension == Dimension::NONE => Ok(*n as f64),
        toml::Value::Float(_) | toml::Value::Integer(_) => {
            Err(unit(UnitError::Missing { text: value.to_string(), wanted: p.dimension }))
        }
        _ => Err(LawSpecError::NotAQuantity { key: p.name, found: value.to_string(), example: p.dimension.example() }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Box<dyn Law>, LawSpecError> {
        law_from_table(&text.parse().expect("the test writes valid TOML"))
    }

    #[test]
    fn reads_every_law() {
        for entry in LAWS.iter().filter(|e| e.keys.iter().any(|k| k.name == "E")) {
            let name = entry.info.name;
            let law = read(&format!(
                "law = \"{name}\"\nE = \"100 kPa\"\nnu = 0.45\nprovenance = \"a test\"\nsource.doi = \"x\""
            ))
            .unwrap_or_else(|e| panic!("{name}: {e}"));
            assert_eq!((law.info().name, law.values()), (name, vec![100e3, 0.45]));
        }
        for (table, mu, values, choices) in [
            (
                "law = \"mooney_rivlin\"\nC10 = \"40 kPa\"\nC01 = \"10 kPa\"\nkappa = \"1 MPa\"\nvolumetric = \"quadratic\"",
                100e3,
                &[1e6, 40e3, 10e3][..],
                &["quadratic"][..],
            ),
            (
                "law = \"mooney_rivlin\"\nC10 = \"40 kPa\"\nC01 = \"10 kPa\"\nC20 = \"-1 kPa\"\nkappa = \"1 MPa\"\nvolumetric = \"quadratic\"",
                100e3,
                &[1e6, 40e3, 10e3, 0.0, -1e3],
                &["quadratic"],
            ),
            (
                "law = \"yeoh\"\nC10 = \"50 kPa\"\nkappa = \"1 MPa\"\nvolumetric = \"logarithmic\"",
                100e3,
                &[1e6, 50e3],
                &["logarithmic"],
            ),
            (
                "law = \"ogden\"\nmu1 = \"50 kPa\"\nalpha1 = 4\nkappa = \"1 MPa\"\nvolumetric = \"simo_taylor\"",
                100e3,
                &[1e6, 50e3, 4.0],
                &["simo_taylor", "ogden"],
            ),
            (
                "law = \"ogden\"\nmu1 = \"50 kPa\"\nalpha1 = 4\nmu2 = \"30 kPa\"\nalpha2 = -2\nkappa = \"1 MPa\"\nvolumetric = \"quadratic\"\nconvention = \"abaqus\"",
                80e3,
                &[1e6, 50e3, 4.0, 30e3, -2.0],
                &["quadratic", "abaqus"],
            ),
            (
                "law = \"gent\"\nmu = \"50 kPa\"\nJ_m = 30\nkappa = \"1 MPa\"\nvolumetric = \"quadratic\"",
                50e3,
                &[1e6, 50e3, 30.0],
                &["quadratic"],
            ),
            (
                "law = \"veronda_westmann\"\nC1 = \"50 kPa\"\nbeta = 0.5\nkappa = \"1 MPa\"\nvolumetric = \"quadratic\"",
                25e3,
                &[1e6, 50e3, 0.5],
                &["quadratic"],
            ),
        ] {
            let law = read(table).unwrap_or_else(|e| panic!("{table}: {e}"));
            assert_eq!((law.values(), law.choices()), (values.to_vec(), choices.to_vec()), "{table}");
            assert!((law.small_strain().mu / mu - 1.0).abs() < 1e-15, "{table}: μ₀ = {}", law.small_strain().mu);
        }
    }

    /// ν and κ = 2μ₀(1 + ν)/(3(1 − 2ν)) give the same law.
    #[test]
    fn nu_or_kappa() {
        let gent = "law = \"gent\"\nmu = \"30 kPa\"\nJ_m = 30\nvolumetric = \"quadratic\"\n";
        let law = read(&format!("{gent}nu = 0.49")).expect("nu alone");
        assert!((law.values()[0] / (2.0 * 30e3 * 1.49 / 0.06) - 1.0).abs() < 1e-14);
        assert_eq!(law.small_strain().kappa, law.values()[0]);
    }

    #[test]
    fn any_two_constants() {
        let law = read("law = \"neo_hookean\"\nmu = \"0.1 MPa\"\nkappa = \"1 bar\"").expect("a consistent pair");
        let m = law.small_strain();
        assert_eq!((m.mu, m.kappa), (1e5, 1e5));
        assert!((m.nu / 0.125 - 1.0).abs() < 1e-15, "(3κ − 2μ)/(6κ + 2μ) = 1/8");
    }

    /// (table, required text of its message)
    #[test]
    fn refuses_with_fact_and_remedy() {
        let nh = "law = \"neo_hookean\"\n";
        let gent = "law = \"gent\"\nmu = \"3 kPa\"\nJ_m = 30\nvolumetric = \"quadratic\"\n";
        for (table, says) in [
            ("E = \"1 kPa\"", "names no law; add `law = \"…\"` with one of linear"),
            ("law = 3", "`law = 3` is not a name"),
            ("law = \"neohookean\"", "no law `neohookean`; did you mean `neo_hookean`?"),
            ("law = \"xyz\"", "no law `xyz`; known: linear, corotational"),
            (&format!("{nh}young = \"1 kPa\""), "no parameter `young`; known: E, nu, mu, lambda, kappa"),
            (&format!("{nh}kapa = \"1 kPa\""), "no parameter `kapa`; did you mean `kappa`?"),
            (
                &format!("{nh}E = 100e3\nnu = 0.45"),
                "`E`: 100000.0 has no unit; write the unit that is meant, \"100000.0 Pa\" in SI or for example \"100000.0 kPa\"",
            ),
            (&format!("{nh}E = \"100 mm\"\nnu = 0.45"), "`E`: \"100 mm\" has the wrong dimension"),
            (&format!("{nh}E = true\nnu = 0.45"), "`E = true` is not a quantity"),
            (&format!("{nh}E = \"100 kPa\""), "exactly two of E, nu, mu, lambda, kappa, and only E is given; add one"),
            (nh, "and none is given; add one"),
            (&format!("{nh}E = \"1 kPa\"\nnu = 0.3\nmu = \"1 kPa\""), "E, nu, mu are given; remove all but two"),
            (
                &format!("{nh}E = \"1 kPa\"\nnu = 0.5"),
                "nu = 0.5 >= 0.5 leaves no finite bulk modulus; use e.g. 0.499 with formulation = \"mixed\"",
            ),
            (&format!("{nh}E = \"1 kPa\"\nnu = -1.0"), "nu (Poisson's ratio) = -1 [SI] is not inside (-1, 0.5)"),
            (&format!("{nh}E = \"-1 kPa\"\nnu = 0.3"), "E (Young's modulus) = -1000 [SI] is not inside (0, inf)"),
            (&format!("{nh}nu = nan\nE = \"1 kPa\""), "nu (Poisson's ratio) = NaN"),
            (&format!("{gent}nu = 0.5"), "leaves no finite bulk modulus"),
            (gent, "law `gent` has no volumetric constant; add exactly one of kappa and nu"),
            (&format!("{gent}nu = 0.4\nkappa = \"1 MPa\""), "are both given, and nu means kappa = 14000"),
            ("law = \"gent\"\nmu = \"3 kPa\"\nJ_m = 30\nnu = 0.4", "needs `volumetric`, one of quadratic, logarithmic"),
            (&gent.replace("quadratic", "log"), "`volumetric = \"log\"` does not exist; did you mean `logarithmic`?"),
            (&gent.replace("\"quadratic\"", "1"), "`volumetric = 1` is not a name"),
            (&gent.replace("J_m = 30", "nu = 0.3"), "law `gent` needs `J_m` (Ī₁ − 3 at which"),
            (
                &gent.replace("J_m = 30", "J_m = 0"),
                "J_m (Ī₁ − 3 at which the chains are fully stretched) = 0 [SI] is not inside",
            ),
            (&format!("{gent}volumetrc = \"quadratic\""), "no parameter `volumetrc`; did you mean `volumetric`?"),
            (&format!("{nh}E = \"1 kPa\"\nnu = 0.3\nvolumetric = \"quadratic\""), "no parameter `volumetric`"),
            (
                &gent
                    .replace("gent", "mooney_rivlin")
                    .replace("mu = \"3 kPa\"\nJ_m = 30", "C10 = \"1 kPa\"\nC01 = \"-2 kPa\"\nnu = 0.4"),
                "has the shear modulus -2000 Pa at F = I",
            ),
            (
                &gent.replace("gent", "ogden").replace("mu = \"3 kPa\"\nJ_m = 30", "mu1 = \"1 kPa\"\nalpha1 = 0"),
                "`alpha1 = 0`",
            ),
            (
                &gent.replace("gent", "ogden").replace("mu = \"3 kPa\"\nJ_m = 30", "mu1 = \"1 kPa\"\nalpha2 = 2"),
                "needs `alpha1`",
            ),
            (
                &gent.replace("gent", "ogden").replace("mu = \"3 kPa\"\nJ_m = 30", "mu1 = \"1 kPa\"\nalpha1 = -2"),
                "shear modulus -1000 Pa",
            ),
            (&format!("{nh}E = \"9 kPa\"\nmu = \"1 kPa\""), "E and mu contradict each other: they give kappa"),
        ] {
            let message = read(table).expect_err(table).to_string();
            assert!(message.contains(says), "{table}\ngave: {message}\nnot: {says}");
        }
    }
}
