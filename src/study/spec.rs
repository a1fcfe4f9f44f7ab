//! Parts of a study file that several kinds share: variants, families, and checks of their names and roles.

use crate::math::units;
use crate::scene::name::{self, is_name};
use crate::scene::{SceneError, changes, column, unit_of_column};
use crate::schema::AnyTable;
use crate::study::store::record::{Role, StudyQuantity};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};

/// One way of driving the scene, and the quantities judged there.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VariantSpec {
    /// Part of the case ids
    pub name: String,
    /// Label for sentences and figures; the name if absent
    pub label: Option<String>,
    /// Heading over its columns in a matrix: `laws`
    pub group: Option<String>,
    /// Changes by path
    #[serde(default, deserialize_with = "changes::by_path")]
    #[schemars(with = "AnyTable")]
    pub set: toml::Table,
    /// Judged quantities
    #[serde(rename = "quantity", default)]
    pub quantities: Vec<StudyQuantity>,
    /// A scene different from that of the study, relative to it
    #[serde(skip)]
    pub scene: Option<PathBuf>,
}

/// Cases that differ in one respect only.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FamilySpec {
    /// Part of the case ids
    pub name: String,
    /// Purpose of the family
    pub role: Role,
    /// Variants in which it is run; all if absent
    pub variants: Option<Vec<String>>,
    /// Changes of all members
    #[serde(default, deserialize_with = "changes::by_path")]
    #[schemars(with = "AnyTable")]
    pub set: toml::Table,
    /// Name of a member → its changes
    #[serde(deserialize_with = "changes::of_members")]
    #[schemars(with = "AnyTable")]
    pub members: toml::Table,
    /// Name of a member → its label in figures and tables; the title of the law or the name itself if absent
    #[serde(default)]
    pub labels: BTreeMap<String, String>,
    /// Variant → additional members in this variant only
    #[serde(skip)]
    pub own: BTreeMap<String, toml::Table>,
    /// A scene different from that of the study
    #[serde(skip)]
    pub scene: Option<PathBuf>,
}

/// Placeholder for the experiment of a record of the study.
pub const EXPERIMENT: &str = "{experiment}";
/// Largest number of cases of a study. Each takes about 10 kB and 0.2 ms before anything runs, in every command that reads the study.
pub const MOST_CASES: usize = 20_000;

/// Place, fact and remedy of a mistake in a study file that is not a syntax error.
pub type Mistake = (String, String, String);

/// Reports the mistake as an error in the file.
pub fn refuse(file: &Path, (place, fact, remedy): Mistake) -> SceneError {
    SceneError::Content { file: file.into(), place, fact, remedy }
}

/// The families of a study file as written.
#[derive(Deserialize)]
pub struct WrittenFamilies {
    #[serde(rename = "family", default)]
    families: Vec<toml::Table>,
}

impl WrittenFamilies {
    /// Checks that every family has a role that the kind knows. If a family has an unknown key, which may be a misspelt `role`, the reader of the keys
    /// reports that key instead.
    pub fn check(&self, kind: &str, known: &[Role]) -> Result<(), Mistake> {
        let known: Vec<String> = known.iter().map(|role| role.words().replace(' ', "_")).collect();
        let keys = schemars::schema_for!(FamilySpec);
        let is_key = |key: &String| keys.get("properties").is_some_and(|all| all.get(key).is_some());
        let is_wrong = |family: &toml::Table| match family.get("role").map(toml::Value::as_str) {
            Some(role) => role.is_some_and(|role| !known.iter().any(|own| own == role)),
            None => family.keys().all(is_key),
        };
        let Some((k, family)) = (1..).zip(&self.families).find(|(_, f)| is_wrong(f)) else { return Ok(()) };
        let text = |key: &str| family.get(key).and_then(toml::Value::as_str);
        let fact = match text("role") {
            Some(role) => format!("a study of kind \"{kind}\" has no role \"{role}\""),
            None => "the key `role` is missing".into(),
        };
        let place = text("name").map_or_else(|| format!("family {k}"), |name| format!("family {name}"));
        Err((place, fact, format!("the roles are {}", known.join(", "))))
    }
}

/// Checks that the unit of a quantity is that at the end of its column name, in any spelling. Returns fact and remedy if it differs; a name without a
/// unit is accepted.
pub fn check_unit(q: &StudyQuantity) -> Result<(), (String, String)> {
    let (own, (dimension, si)) = (unit_of_column(&q.name), column::dimension(&q.name));
    let is_own = |one: f64| (one / si - 1.0).abs() < 1e-12;
    if own == "1" || q.unit == own || units::parse(&format!("1 {}", q.unit), dimension).is_ok_and(is_own) {
        return Ok(());
    }
    let fact = format!("the unit is \"{}\", and the column {} has numbers in {own}", q.unit, q.name);
    Err((fact, format!("write unit = \"{own}\": figures choose prefixes such as milli themselves")))
}

/// Checks that every variant lists a quantity, that units are those of the columns, and that absolute tolerances are positive.
pub fn check_quantities(variants: &[VariantSpec]) -> Result<(), Mistake> {
    if let Some(variant) = variants.iter().find(|v| v.quantities.is_empty()) {
        let remedy = "add quantity = [{ name = …, label = …, symbol = …, unit = … }] with a recorded column";
        return Err((format!("variant {}", variant.name), "it judges no quantity".into(), remedy.into()));
    }
    for variant in variants {
        let wrong = |q: &&StudyQuantity| q.absolute_tolerance.is_some_and(|t| !(t > 0.0 && t.is_finite()));
        if let Some(q) = variant.quantities.iter().find(wrong) {
            let fact = format!("the absolute_tolerance is {}", q.absolute_tolerance.unwrap_or_default());
            let remedy = "give the accepted error as a positive number in the unit of the column";
            return Err((format!("variant {}, quantity {}", variant.name, q.name), fact, remedy.into()));
        }
        for q in variant.quantities.iter().flat_map(|q| std::iter::once(q).chain(q.against.as_deref())) {
            let place = || format!("variant {}, quantity {}", variant.name, q.name);
            check_unit(q).map_err(|(fact, remedy)| (place(), fact, remedy))?;
        }
    }
    Ok(())
}

/// Checks that families with these roles have at least two members.
pub fn check_members(families: &[FamilySpec], compared: &[Role]) -> Result<(), Mistake> {
    let is_alone = |f: &&FamilySpec| compared.contains(&f.role) && f.members.len() == 1;
    let Some(family) = families.iter().find(is_alone) else { return Ok(()) };
    let fact = format!("one member, and nothing to compare it with in the role \"{}\"", family.role.words());
    let remedy = "add another one: errors are estimated from differences between the members";
    Err((format!("family {}", family.name), fact, remedy.into()))
}

/// Checks names that become parts of file names and must be distinct; returns index, fact and remedy of the first that cannot be used.
pub fn check_names(names: &[String]) -> Result<(), (usize, String, &'static str)> {
    let mut seen = HashSet::new();
    for (k, name) in names.iter().enumerate() {
        if !seen.insert(name) {
            return Err((k, format!("another one is called \"{name}\" too"), "give it a name of its own"));
        }
        if !is_name(name) {
            let fact = format!("\"{name}\" cannot be part of a file name");
            return Err((k, fact, name::REMEDY));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::from_text;

    #[test]
    fn the_dotted_keys_of_a_family_are_paths() {
        let read = |set: &str, member: &str| {
            let text =
                format!("name = \"a\"\nrole = \"sizes\"\nset = {{ {set} }}\nmembers = {{ fine = {{ {member} }} }}\n");
            let family: FamilySpec = from_text(Path::new("study.toml"), &text, "").expect(&text);
            (family.set, family.members)
        };
        let quoted = read("\"numerics.accuracy\" = 1e-5", "\"mesh.cells\" = 9");
        assert_eq!(read("numerics.accuracy = 1e-5", "mesh.cells = 9"), quoted);
        assert!(quoted.0.contains_key("numerics.accuracy"));
    }

    #[test]
    fn a_quantity_has_the_unit_of_its_column() {
        let of =
            |name: &str, unit: &str| StudyQuantity { name: name.into(), unit: unit.into(), ..StudyQuantity::default() };
        for (name, unit) in [
            ("tip_z_m", "m"),
            ("bending_angle_deg", "°"),
            ("bending_angle_deg", "deg"),
            ("cavity_volume_m3", "m³"),
            ("cavity_volume_m3", "m^3"),
            ("cavity_volume_m3", "m3"),
            ("grip_reaction_moment_z_Nm", "N m"),
            ("line_1_curvature_per_m", "1/m"),
            ("elastic_J", "J"),
            ("stretch_p95", "%"),
        ] {
            assert_eq!(check_unit(&of(name, unit)), Ok(()));
        }
        for (name, unit) in [("tip_z_m", "mm"), ("tip_z_m", "N"), ("tip_z_m", ""), ("tip_z_m", "furlong")] {
            let (fact, remedy) = check_unit(&of(name, unit)).expect_err("another unit");
            assert!(fact.contains(name) && remedy.contains("write unit = "), "{fact}; {remedy}");
        }
    }
}
