//! The cases of a validation: the design of each record over its constants, checks at random points, and at the centre the families of meshes and
//! steps and a run with tighter tolerances of Newton's method.
//!
//! The design of a record over its m unknowns has the centre of their ranges, the middle of each face and, with several unknowns, the corners (Box &
//! Wilson, *J. R. Stat. Soc. B* 13, 1951, face-centred).

use crate::math::random::SplitMix;
use crate::scene::spec::NumericsSpec;
use crate::scene::{KeyValue, ParameterKey, overrides};
use crate::study::kinds::validation::plan::{RecordPlan, UnknownPlan, ValidationPlan};
use crate::study::kinds::validation::spec::ValidationStudy;
use crate::study::spec::FamilySpec;
use crate::study::store::record::Role;
use std::collections::BTreeMap;

/// Seed of the points of checks, combined with the name of the record.
const SEED: u64 = 0x7661_6c69_6461_7465;
/// Fraction of the ranges within which checks lie.
const INNER: f64 = 0.8;
/// Ratio of the tolerances of the design to those of the run that shows its algebraic error.
pub const TIGHTER: f64 = 100.0;
/// Smallest tolerance, at the level of rounding.
const LEAST: f64 = 1e-13;

/// Family of the runs with tighter tolerances.
pub const ALGEBRAIC: &str = "algebraic";
/// Name of their only member.
const MEMBER: &str = "tighter";

/// Returns the families of the design and of the checks, followed by those of the study, and the points of their cases. `scenes` are the scenes of
/// the records.
pub fn cases(
    study: &ValidationStudy,
    scenes: &[toml::Table],
    mut plan: ValidationPlan,
) -> (ValidationPlan, Vec<FamilySpec>) {
    let (mut designs, mut checks, mut tighter) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
    for (r, scene) in plan.records.iter().zip(scenes) {
        let own: Vec<&UnknownPlan> = r.unknowns.iter().map(|k| &plan.unknowns[*k]).collect();
        let setting = |xi: &[f64]| -> toml::Table {
            own.iter().zip(xi).map(|(u, xi)| (u.key.clone(), value_at(u, *xi))).collect()
        };
        let names: Vec<&str> = own.iter().map(|u| u.name.as_str()).collect();
        let mut members = toml::Table::new();
        for (label, xi) in design(&names) {
            members.insert(label.clone(), setting(&xi).into());
            plan.points.insert(format!("design-{}-{label}", r.name), xi);
        }
        designs.insert(r.name.clone(), members);
        let seed = r.name.bytes().fold(SEED, |seed, byte| seed.rotate_left(8) ^ u64::from(byte));
        let mut random = SplitMix(seed);
        let mut members = toml::Table::new();
        for k in 1..=study.checks {
            let xi: Vec<f64> = own.iter().map(|_| INNER * (2.0 * random.unit() - 1.0)).collect();
            // A constant of a law file that is moved by its larger side may have a value that the law does not admit
            let mut shift = |k: usize| if plan.inputs[k].of_law_file { 0.0 } else { 2.0 * random.unit() - 1.0 };
            let s: Vec<f64> = r.inputs.iter().map(|(k, _)| shift(*k)).collect();
            let mut set: toml::Table = setting(&xi).into_iter().chain(tolerances(scene)).collect();
            for (s, (_, keys)) in s.iter().zip(&r.inputs).filter(|(s, _)| **s != 0.0) {
                for (key, deviation) in keys {
                    let before = number_of(key, &set, scene);
                    let after = before.map(|value| value.written_si(value.si() + s * deviation));
                    after.map(|value| set.insert(key.clone(), value));
                }
            }
            members.insert(k.to_string(), set.into());
            plan.checks.insert(format!("check-{}-{k}", r.name), (xi, s));
        }
        checks.insert(r.name.clone(), members);
        let changes = centre(r, &plan).into_iter().chain(tolerances(scene)).collect();
        tighter.insert(r.name.clone(), toml::Table::from_iter([(MEMBER.to_string(), toml::Value::Table(changes))]));
    }
    let mut families = vec![family("design", Role::Design, designs)];
    if study.checks > 0 {
        families.push(family("check", Role::Check, checks));
    }
    families.push(family(ALGEBRAIC, Role::Solver, tighter));
    families.extend(study.families.iter().map(|f| at_centre(f, &plan)));
    (plan, families)
}

fn family(name: &str, role: Role, own: BTreeMap<String, toml::Table>) -> FamilySpec {
    FamilySpec {
        name: name.into(),
        role,
        variants: None,
        set: toml::Table::new(),
        members: toml::Table::new(),
        labels: BTreeMap::new(),
        own,
        scene: None,
    }
}

/// A family of the study with the constants at the centre of the design.
fn at_centre(f: &FamilySpec, plan: &ValidationPlan) -> FamilySpec {
    let runs = |r: &&RecordPlan| f.variants.as_ref().is_none_or(|own| own.contains(&r.name));
    let with_centre = |r: &RecordPlan, member: &toml::Value| match member {
        toml::Value::Table(changes) => toml::Value::Table(centre(r, plan).into_iter().chain(changes.clone()).collect()),
        other => other.clone(),
    };
    let members = |r: &RecordPlan| f.members.iter().map(|(l, m)| (l.clone(), with_centre(r, m))).collect();
    let own = plan.records.iter().filter(runs).map(|r| (r.name.clone(), members(r))).collect();
    FamilySpec { members: toml::Table::new(), own, ..f.clone() }
}

/// The constants of a record at the centre of the design.
fn centre(r: &RecordPlan, plan: &ValidationPlan) -> toml::Table {
    r.unknowns.iter().map(|k| &plan.unknowns[*k]).map(|u| (u.key.clone(), value_at(u, 0.0))).collect()
}

/// The tolerances of Newton's method in a scene, divided by [`TIGHTER`].
fn tolerances(scene: &toml::Table) -> toml::Table {
    let own: NumericsSpec = scene.get("numerics").cloned().and_then(|n| n.try_into().ok()).unwrap_or_default();
    let keys = [("numerics.tolerance", own.tolerance), ("numerics.accuracy", own.accuracy)];
    keys.map(|(key, value)| (key.to_string(), (value / TIGHTER).max(LEAST.min(value)).into())).into_iter().collect()
}

/// Labels and points of a face-centred central composite design.
fn design(names: &[&str]) -> Vec<(String, Vec<f64>)> {
    let m = names.len();
    let word = |x: f64| if x < 0.0 { "low" } else { "high" };
    let mut all = vec![("centre".to_string(), vec![0.0; m])];
    for (k, name) in names.iter().enumerate() {
        for x in [-1.0, 1.0] {
            let mut at = vec![0.0; m];
            at[k] = x;
            all.push((format!("{name}-{}", word(x)), at));
        }
    }
    if m > 1 {
        for corner in 0..1_usize << m {
            let at: Vec<f64> = (0..m).map(|k| if corner >> k & 1 == 1 { 1.0 } else { -1.0 }).collect();
            let label: Vec<String> = names.iter().zip(&at).map(|(n, x)| format!("{n}-{}", word(*x))).collect();
            all.push((label.join("-"), at));
        }
    }
    all
}

fn value_at(u: &UnknownPlan, xi: f64) -> toml::Value {
    let value = u.at(xi);
    if u.unit.is_empty() { value.into() } else { format!("{value} {}", u.unit).into() }
}

/// The number of a key, as it is set or as in the scene, where another key may give its unit.
fn number_of(key: &str, set: &toml::Table, scene: &toml::Table) -> Option<KeyValue> {
    let mut scene = scene.clone();
    if let Some(value) = set.get(key) {
        overrides::apply(&mut scene, key, value.clone()).ok()?;
    }
    key.parse::<ParameterKey>().ok()?.value(&scene).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A value among points has the unit of its signal, even if an earlier change has set it.
    #[test]
    fn a_value_that_is_set_keeps_the_unit_of_its_signal() {
        let scene: toml::Table =
            "[drive]\nkind = \"points\"\nof = [[0, 0], [1, 2]]\nunit = \"mm\"".parse().expect("TOML");
        let number = |set: &toml::Table| number_of("drive.of.1.1", set, &scene).map(|value| value.si());
        assert_eq!(number(&toml::Table::new()), Some(2.0 * 1e-3));
        let set = toml::Table::from_iter([("drive.of.1.1".to_string(), 3.0.into())]);
        assert_eq!(number(&set), Some(3.0 * 1e-3));
    }
}
