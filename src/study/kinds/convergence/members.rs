//! Members of families that are not meshes of one problem, and those of a size that another one has.

use crate::study::analysis::ByQuantity;
use crate::study::curve::peak;
use crate::study::kinds::convergence::cases::Cases;
use crate::study::kinds::convergence::findings::MeshErrors;
use crate::study::store::record::{CaseRecord, FamilyRecord, Role};
use crate::wording::few;
use std::collections::{BTreeMap, BTreeSet};
use toml::{Table, Value};

/// Tables and keys that do not change the problem.
const OF_NO_PROBLEM: [&str; 4] = ["title", "numerics", "output", "view"];
/// Keys of a grid that set the sizes of its cells; the others are its shape.
const OF_SIZE: [&str; 2] = ["divisions", "fine"];
/// Tables of `[mesh]` that are the same on every mesh of a problem.
const OF_SHAPE: [&str; 3] = ["grid", "deform", "regions"];

/// One sentence for each family whose members differ in more than their meshes, and for each that has two members of one size.
pub fn warnings(cases: &Cases, quantities: &[ByQuantity<MeshErrors>]) -> Vec<String> {
    let is_of_meshes = |f: &&FamilyRecord| !matches!(f.role, Role::Seeds | Role::Adaptive | Role::TimeStep);
    let mut out = Vec::new();
    for family in cases.study.families.iter().filter(is_of_meshes) {
        let mut differing = BTreeSet::new();
        for variant in &cases.study.variants {
            let members = cases.of(family, variant);
            differing.extend(differing_keys(members.iter().map(|c| &c.record)));
        }
        if !differing.is_empty() {
            out.push(format!(
                "Family {}: its members differ in {} too, so that the differences of their values are not those of the meshes alone.",
                family.name,
                few(&differing.iter().collect::<Vec<_>>())
            ));
        }
        let left_out = left_out(cases, family, quantities);
        if !left_out.is_empty() {
            out.push(format!(
                "Family {}: no estimate uses {}, since another member has the same size.",
                family.name,
                few(&left_out.iter().collect::<Vec<_>>())
            ));
        }
    }
    out
}

/// Cases with a value that no estimate of their family uses.
fn left_out<'a>(
    cases: &Cases<'a>,
    family: &FamilyRecord,
    quantities: &[ByQuantity<MeshErrors>],
) -> BTreeSet<&'a String> {
    let estimates = quantities.iter().filter_map(|q| Some((q, q.estimate(&family.name)?)));
    let unused = estimates.flat_map(|(q, e)| {
        let has_value = cases.of(family, &q.variant).into_iter().filter(|c| peak(c, &q.quantity.name).is_some());
        has_value.map(|c| &c.record.id).filter(|id| !e.cases.contains(id))
    });
    unused.collect()
}

/// Keys of the scenes in which these cases differ, apart from those that set the sizes of the cells.
fn differing_keys<'a>(members: impl Iterator<Item = &'a CaseRecord>) -> BTreeSet<String> {
    let mut scenes = members.filter_map(|c| c.provenance.scene.parse::<Table>().ok()).map(|scene| {
        let mut keys = BTreeMap::new();
        flatten("", &Value::Table(scene), &mut keys);
        keys
    });
    let Some(first) = scenes.next() else { return BTreeSet::new() };
    let mut out = BTreeSet::new();
    for other in scenes {
        let both = first.keys().chain(other.keys());
        out.extend(both.filter(|key| first.get(*key) != other.get(*key) && is_of_problem(key)).cloned());
    }
    out
}

/// Whether two scenes that differ in this key are of different problems.
fn is_of_problem(key: &str) -> bool {
    let parts: Vec<&str> = key.split('.').collect();
    if parts[0] != "mesh" {
        return !OF_NO_PROBLEM.contains(&parts[0]);
    }
    parts.iter().any(|part| OF_SHAPE.contains(part)) && !parts.iter().any(|part| OF_SIZE.contains(part))
}

/// The leaves of a scene by their keys, `laws.rubber.E` or `stage.0.dt`.
fn flatten(key: &str, value: &Value, keys: &mut BTreeMap<String, Value>) {
    let below = |name: &str| if key.is_empty() { name.to_string() } else { format!("{key}.{name}") };
    match value {
        Value::Table(table) => table.iter().for_each(|(name, inner)| flatten(&below(name), inner, keys)),
        Value::Array(list) if list.iter().any(Value::is_table) => {
            list.iter().enumerate().for_each(|(k, inner)| flatten(&below(&k.to_string()), inner, keys));
        }
        leaf => drop(keys.insert(key.to_string(), leaf.clone())),
    }
}
