//! Members of families that are not meshes of one problem, and members with the size of another member.

use crate::math::units::shown;
use crate::report::names::title;
use crate::study::analysis::ByQuantity;
use crate::study::curve::peak;
use crate::study::estimate::family::formal_order;
use crate::study::kinds::convergence::cases::Cases;
use crate::study::kinds::convergence::findings::MeshErrors;
use crate::study::store::record::{CaseRecord, FamilyRecord, Role, StoredCase};
use crate::wording::{all, distinct, few};
use std::collections::{BTreeMap, BTreeSet};
use toml::{Table, Value};

/// Tables and keys that do not change the problem.
const OF_NO_PROBLEM: [&str; 4] = ["title", "numerics", "output", "view"];
/// Keys of a grid that set the sizes of its cells; the others describe its shape.
const OF_SIZE: [&str; 2] = ["divisions", "fine"];
/// Tables of `[mesh]` that are the same on every mesh of a problem.
const OF_SHAPE: [&str; 4] = ["grid", "deform", "parameters", "regions"];

/// Factor within which the change of volume between meshes of one body follows the law of refined facets \[–\]
const OF_FACETS: f64 = 4.0;
/// Change of the volume relative to the tolerance that is worth reporting \[–\]
const TELLING: f64 = 0.2;

/// Returns one sentence for each family whose members differ in more than their meshes or have no common formal order, whose meshes belong to several
/// bodies by their volumes, or that has two members of one size.
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
        let mixed = |variant: &String| orders(&cases.of(family, variant));
        if let Some(formulations) = cases.study.variants.iter().find_map(mixed) {
            out.push(format!(
                "Family {}: its members are of {}, whose formal orders differ, so that no order is that of the family.",
                family.name,
                all(&formulations)
            ));
        }
        let of_variant = |variant: &String| other_volume(&cases.of(family, variant), cases.study.tolerance);
        if let Some(change) = cases.study.variants.iter().filter_map(of_variant).reduce(f64::max) {
            out.push(format!(
                "Family {}: the volumes of its meshes differ by {} %, which finer facets of one body do not explain; check that all are of the same \
                 body, in the same unit.",
                family.name,
                shown((1e4 * change).round() / 100.0)
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

/// The formulations of these members, if they do not share one formal order.
fn orders(members: &[&StoredCase]) -> Option<Vec<String>> {
    let all = || members.iter().map(|c| c.record.formulation.as_str());
    let several = distinct(all().map(formal_order)).len() > 1;
    several.then(|| distinct(all().map(title)))
}

/// Largest relative change of the volume from mesh to mesh, if it is not that of meshes of one body: facets on a curved surface miss its volume by c
/// h², so a change is of another kind if, scaled by this law, it differs from its neighbour by more than a factor of four or in sign.
fn other_volume(members: &[&StoredCase], tolerance: f64) -> Option<f64> {
    let mut meshes: Vec<(f64, f64)> = members.iter().map(|c| (c.record.mesh.h_m, c.record.mesh.volume_m3)).collect();
    meshes.sort_by(|a, b| b.0.total_cmp(&a.0));
    let step = |w: &[(f64, f64)]| (w[0].0.powi(2) - w[1].0.powi(2), (w[1].1 - w[0].1) / w[1].1);
    let steps: Vec<(f64, f64)> = meshes.windows(2).map(step).filter(|(facets, _)| *facets > 0.0).collect();
    let largest = |steps: &[(f64, f64)]| steps.iter().map(|(_, change)| change.abs()).fold(0.0, f64::max);
    let is_other = |w: &&[(f64, f64)]| {
        let [a, b] = [w[0].1 / w[0].0, w[1].1 / w[1].0];
        largest(w) > TELLING * tolerance && OF_FACETS * a * b < a.abs().max(b.abs()).powi(2)
    };
    steps.windows(2).find(is_other).map(|_| largest(&steps))
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

/// The keys of the scenes in which these cases differ, except those that set the sizes of the cells.
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

/// Whether scenes that differ in this key describe different problems.
fn is_of_problem(key: &str) -> bool {
    let parts: Vec<&str> = key.split('.').collect();
    if parts[0] != "mesh" {
        return !OF_NO_PROBLEM.contains(&parts[0]);
    }
    parts.iter().any(|part| OF_SHAPE.contains(part)) && !parts.iter().any(|part| OF_SIZE.contains(part))
}

/// Collects the leaves of a scene by their keys, such as `laws.rubber.E` or `stage.0.dt`.
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
