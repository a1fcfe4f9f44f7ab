//! The true value of a quantity, from families of finer meshes in several formulations.
//!
//! Each family of the truth has a limit f* (the Richardson value if the order of its three finest meshes is sane, otherwise the finest value f₁) and
//! a change δ towards it: |f* − f₁|, or without an order the last difference |f₁ − f₂|. The truth is the limit of the family with the smallest δ. Its
//! uncertainty is the largest distance from the limit of another family, and at least a quarter of δ if the limit was extrapolated, otherwise all of
//! δ. A family whose value may have no limit, or that has a region whose border runs through cells, is not used.

use crate::study::curve::peak;
use crate::study::estimate::family::{Level, estimate, formal_order};
use crate::study::estimate::richardson::Triple;
use crate::study::kinds::coverage::record::ProblemRecord;
use crate::study::store::record::{Role, StoredCase, StudyQuantity, StudyRecord};
use serde::Serialize;

/// Fraction of the change by extrapolation that counts as its uncertainty.
const SHARE_OF_CHANGE: f64 = 0.25;

/// A true value with its uncertainty.
#[derive(Clone, Debug, Serialize, PartialEq)]
pub struct Truth {
    pub problem: String,
    pub material: String,
    pub quantity: StudyQuantity,
    /// True value \[unit of the quantity\]
    pub value: f64,
    pub uncertainty: f64,
    /// The family it comes from, and the other family whose limit is farthest from it
    pub family: String,
    pub other: String,
    /// Number of cells of the finest mesh
    pub cells: usize,
}

struct Limit {
    family: String,
    value: f64,
    change: f64,
    uncertainty: f64,
    cells: usize,
}

/// Determines the truth; `None` unless two families have two converged meshes each.
pub fn truth(
    study: &StudyRecord,
    stored: &[StoredCase],
    problem: &ProblemRecord,
    material: &str,
    quantity: &StudyQuantity,
) -> Option<Truth> {
    let limits: Vec<Limit> =
        problem.truths.iter().filter_map(|family| limit(study, stored, family, material, &quantity.name)).collect();
    if limits.len() < 2 {
        return None;
    }
    let best = limits.iter().min_by(|a, b| a.change.total_cmp(&b.change))?;
    let others = limits.iter().filter(|l| l.family != best.family);
    let distance = |l: &Limit| (l.value - best.value).abs();
    let other = others.max_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    Some(Truth {
        problem: problem.name.clone(),
        material: material.into(),
        quantity: quantity.clone(),
        value: best.value,
        uncertainty: distance(other).max(best.uncertainty),
        family: best.family.clone(),
        other: other.family.clone(),
        cells: best.cells,
    })
}

fn limit(study: &StudyRecord, stored: &[StoredCase], family: &str, material: &str, quantity: &str) -> Option<Limit> {
    let formulation = &study.families.iter().find(|f| f.name == family)?.formulation;
    let cases = levels(stored, family, material, quantity);
    let [first, second, ..] = &cases[..] else { return None };
    let all = cases.iter().map(|(level, _)| level.clone()).collect();
    if estimate((family, Role::Reference, formulation), all, None, study.tolerance).is_some_and(|e| e.lasting) {
        return None;
    }
    let cells = first.1.record.mesh.cells;
    let (h, f): (Vec<f64>, Vec<f64>) = cases.iter().map(|(l, _)| (l.h, l.f)).unzip();
    let triple = (f.len() > 2).then(|| Triple::new([h[0], h[1], h[2]], [f[0], f[1], f[2]]));
    let sane = triple.filter(|t| t.is_sane(formal_order(formulation)));
    let (value, change, uncertainty) = match sane.and_then(|t| Some(t.correction(t.p?))) {
        Some(shift) => (f[0] + shift, shift.abs(), SHARE_OF_CHANGE * shift.abs()),
        None => (f[0], (f[0] - second.0.f).abs(), (f[0] - second.0.f).abs()),
    };
    Some(Limit { family: family.into(), value, change, uncertainty, cells })
}

/// Returns the converged meshes of a family, finest first.
pub fn levels<'a>(
    stored: &'a [StoredCase],
    family: &str,
    material: &str,
    quantity: &str,
) -> Vec<(Level, &'a StoredCase)> {
    let own = stored.iter().filter(|c| c.record.family == family && c.record.variant == material);
    let level = |c: &'a StoredCase| Some((Level::of(&c.record, quantity, peak(c, quantity)?), c));
    let mut all: Vec<_> = own.filter(|c| c.record.converged()).filter_map(level).collect();
    all.sort_by(|a, b| a.0.h.total_cmp(&b.0.h));
    all
}
