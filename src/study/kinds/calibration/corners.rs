//! The combined effect of dimensions that are known only within ranges, at their worst ends.
//!
//! To first order in the ranges, the changes of a constant by single dimensions add up. If its dependence is curved they do not: for θ ∝ aᵖb^q the
//! factors multiply. Sum and product follow from the cases of the single dimensions, and the wider one is taken at each end. If the two differ by
//! more than a twentieth of the range, or if both ends of one dimension change the constant in the same direction, a sentence says so. With `corners
//! = true` the corners themselves are run, and their extremes replace the estimate.
//!
//! Limit: a dimension is evaluated only at the members of its family; an extreme between them is not seen.

use crate::math::statistics::{larger, smaller};
use crate::report::numbers::percent;
use crate::study::spec::{FamilySpec, Mistake};
use crate::study::store::record::Role;
use std::collections::BTreeMap;

/// Name of the family of the corners.
pub const FAMILY: &str = "corners";
/// Fraction of the range of a constant above which its dependence counts as curved \[–\]
const CURVED: f64 = 0.05;
/// Largest number of corners
const MOST: usize = 16;

/// Changes of a constant at the worst ends of the dimensions.
#[derive(Clone, Debug, PartialEq)]
pub struct Corners {
    /// Smallest and largest change
    pub change: [f64; 2],
    /// A sentence if the dimensions do not simply add up
    pub note: Option<String>,
}

/// Returns the changes of a constant with this `value`, from its changes by the members of each family (`single`) and at the corners, if they were
/// run (`runs`). `None` without such a family.
pub fn judge(value: f64, single: &BTreeMap<&str, Vec<f64>>, runs: &[f64]) -> Option<Corners> {
    if single.is_empty() {
        return None;
    }
    let ends = single.values().map(|all| all.iter().fold([0.0_f64; 2], |[a, b], c| [a.min(*c), b.max(*c)]));
    let ends: Vec<[f64; 2]> = ends.collect();
    let sum = self::ends(single, &[]);
    let product = [0, 1].map(|k| value * (ends.iter().map(|e| 1.0 + e[k] / value).product::<f64>() - 1.0));
    let product = if product.iter().all(|p| p.is_finite()) { product } else { sum };
    let range = sum[1] - sum[0];
    let off = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs().max((a[1] - b[1]).abs()) / range.max(f64::MIN_POSITIVE);
    if !runs.is_empty() {
        let change = self::ends(single, runs);
        let by = off(change, sum);
        let note = format!(
            "the dimensions do not simply add up: their corners, which were run, differ from the sums of single changes by {} of the range",
            percent(by)
        );
        return Some(Corners { change, note: (by > CURVED).then_some(note) });
    }
    let change = [sum[0].min(product[0]), sum[1].max(product[1])];
    let one_sided = |(name, all): (&&str, &Vec<f64>)| {
        let least = all.iter().map(|c| c.abs()).fold(f64::INFINITY, f64::min);
        let one_side = all.iter().all(|c| *c > 0.0) || all.iter().all(|c| *c < 0.0);
        (all.len() > 1 && one_side && least > CURVED * range).then(|| (*name).to_string())
    };
    let bent: Vec<String> = single.iter().filter_map(one_sided).collect();
    let by = if single.len() > 1 { off(product, sum) } else { 0.0 };
    let remedy = "corners = true in [calibration] runs the corners";
    let note = match &bent[..] {
        [] if by <= CURVED => None,
        [] => Some(format!(
            "the dimensions do not simply add up: the products of their changes differ from the sums by {} of the range, and the wider end is taken; {remedy}",
            percent(by)
        )),
        bent => Some(format!(
            "the changes are curved: both ends of {} change it to the same side, and a worse value may lie between; add members to the family",
            bent.join(" and of ")
        )),
    };
    Some(Corners { change, note })
}

/// Returns the smallest and the largest change due to all dimensions: over corners and single dimensions if corners were run, otherwise the sums over
/// the single dimensions.
pub fn ends(single: &BTreeMap<&str, Vec<f64>>, runs: &[f64]) -> [f64; 2] {
    let of = |all: &mut dyn Iterator<Item = f64>| all.fold([0.0; 2], |[a, b], c| [smaller(a, c), larger(b, c)]);
    if !runs.is_empty() {
        return of(&mut runs.iter().chain(single.values().flatten()).copied());
    }
    let each = single.values().map(|all| of(&mut all.iter().copied()));
    each.fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d])
}

/// Builds the family of all corners of the dimensions.
pub fn family(families: &[FamilySpec]) -> Result<FamilySpec, Mistake> {
    let refuse = |fact: String, remedy: &str| Err(("calibration.corners".to_string(), fact, remedy.to_string()));
    let dimensions: Vec<&FamilySpec> = families.iter().filter(|f| f.role == Role::Nuisance).collect();
    let [first, rest @ ..] = &dimensions[..] else {
        return refuse(
            "there is no family of role \"nuisance\"".into(),
            "add one for each dimension, or leave out corners",
        );
    };
    if rest.is_empty() {
        return refuse("one dimension has no corners".into(), "its two ends are run already; leave out corners");
    }
    if families.iter().any(|f| f.name == FAMILY) {
        return refuse(format!("a family is called \"{FAMILY}\" already"), "give it another name");
    }
    if let Some(other) = rest.iter().find(|f| f.variants != first.variants || f.scene != first.scene) {
        let fact =
            format!("the families \"{}\" and \"{}\" are of different variants or scenes", first.name, other.name);
        return refuse(fact, "give all dimensions the same variants and scene");
    }
    let count: usize = dimensions.iter().map(|f| f.members.len()).product();
    if count > MOST {
        return refuse(
            format!("the dimensions have {count} corners, at most {MOST} are run"),
            "take two members each of at most four dimensions",
        );
    }
    let mut set = toml::Table::new();
    let mut corners: Vec<(String, toml::Table)> = vec![(String::new(), toml::Table::new())];
    for f in &dimensions {
        if let Some(key) = f.set.iter().find(|(k, v)| set.get(*k).is_some_and(|own| own != *v)).map(|p| p.0) {
            return refuse(
                format!("the families set `{key}` to different values"),
                "give all of them the same changes in `set`",
            );
        }
        set.extend(f.set.clone());
        let mut next = vec![];
        for (name, own) in &corners {
            for (label, changes) in &f.members {
                let changes = changes.as_table().cloned().unwrap_or_default();
                if let Some(key) = changes.keys().find(|k| own.contains_key(*k)) {
                    let fact = format!("two dimensions change `{key}`, and a corner has one value of it");
                    return refuse(
                        fact,
                        "change parts of their own, such as \"mesh.grid.size.0\" and \"mesh.grid.size.2\"",
                    );
                }
                let name = if name.is_empty() { label.clone() } else { format!("{name}-{label}") };
                next.push((name, own.clone().into_iter().chain(changes).collect()));
            }
        }
        corners = next;
    }
    let members = corners.into_iter().map(|(name, changes)| (name, changes.into())).collect();
    let (variants, scene) = (first.variants.clone(), first.scene.clone());
    let (own, labels) = (BTreeMap::new(), BTreeMap::new());
    Ok(FamilySpec { name: FAMILY.into(), role: Role::Nuisance, variants, set, members, labels, own, scene })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn single(all: &[(&'static str, &[f64])]) -> BTreeMap<&'static str, Vec<f64>> {
        all.iter().map(|(name, changes)| (*name, changes.to_vec())).collect()
    }

    /// Small changes add up without a note; for a product of large ones the wider end is taken and named.
    #[test]
    fn sums_and_products() {
        let found = judge(100.0, &single(&[("a", &[-1.0, 1.0]), ("b", &[-2.0, 2.0])]), &[]).expect("two dimensions");
        let near = |found: &Corners, ends: [f64; 2]| (0..2).all(|k| (found.change[k] - ends[k]).abs() < 1e-12);
        assert!(found.note.is_none() && near(&found, [-3.0, 3.0 + 0.02]), "{found:?}");
        let found =
            judge(100.0, &single(&[("a", &[-30.0, 40.0]), ("b", &[-20.0, 50.0])]), &[]).expect("two dimensions");
        assert!(found.change[0] == -50.0 && (found.change[1] - 110.0).abs() < 1e-9, "{found:?}");
        assert!(found.note.is_some_and(|n| n.contains("14 % of the range") && n.contains("corners = true")));
        assert_eq!(judge(1.0, &BTreeMap::new(), &[]), None);
    }

    /// Corners that were run replace the estimate; a dimension whose ends change the constant in one direction is named.
    #[test]
    fn runs_and_curved_dimensions() {
        let both = single(&[("a", &[-30.0, 40.0]), ("b", &[-20.0, 50.0])]);
        let found = judge(100.0, &both, &[-44.0, 5.0, 12.0, 110.0]).expect("two dimensions");
        assert!(found.change == [-44.0, 110.0] && found.note.is_some_and(|n| n.contains("which were run")), "a corner");
        let found = judge(100.0, &single(&[("a", &[3.0, 4.0])]), &[]).expect("a dimension");
        assert_eq!(ends(&both, &[]), [-50.0, 90.0]);
        assert_eq!(ends(&both, &[-44.0, 110.0]), [-44.0, 110.0]);
        assert!(ends(&both, &[f64::NAN])[1].is_nan());
        assert!(found.change[0] == 0.0 && (found.change[1] - 4.0).abs() < 1e-12, "{found:?}");
        assert!(found.note.is_some_and(|n| n.contains("both ends of a change it")));
    }
}
