//! The limit of a quantity over the mesh, at the time steps of the scene.
//!
//! Two meshes that agree determine no limit, but can contradict one that is not well known: if |f_h/f₁ − 1| > 3 |f₂/f₁ − 1|/(r − 1), at first order in
//! h and with the safety factor of two meshes (Roache, *J. Fluids Eng.* 116, 1994).
//!
//! The limit f_h ± U(f_h) is the reference of a convergence study, with precautions against values that agree by chance (errors of opposite sign, a
//! curve that crosses its limit): two meshes are not a family; U of a family is at least the largest of |fᵢ − fᵢ₊₁|/(rᵖ − 1) (h₁/hᵢ)ᵖ over its
//! neighbouring meshes; and if the interval of a family that is not refused does not overlap the reference, U(f_h) grows as for an independent
//! estimate.

use crate::study::curve::peak;
use crate::study::estimate::family::{Estimate, Level, estimate};
use crate::study::estimate::reference::{self, Reference};
use crate::study::estimate::richardson::{LEAST_ORDER, bound_of_pair, correction};
use crate::study::locking;
use crate::study::plan::model::LEAST_PILOTS;
use crate::study::plan::pilots::Pilots;
use crate::study::plan::sizes::ElementMeshes;
use crate::study::store::record::{Role, StoredCase};
use serde::Serialize;
use std::collections::BTreeMap;

/// Column → f_h and U(f_h)/|f_h|.
pub type MeshLimits = BTreeMap<String, (f64, f64)>;

/// An element whose two pilots contradict a limit that the other elements do not determine to the tolerance.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Contradiction {
    /// Short name of the element with its formulation: `tet10_up`
    #[serde(rename = "element")]
    pub formulation: String,
    pub quantity: String,
    /// Relative change from one pilot to the other \[–\]
    pub change: f64,
    /// Relative distance of the limit from the finer pilot \[–\]
    pub distance: f64,
}

/// The contradiction from the element whose two pilots agree best. Pilots that lock are ignored.
pub fn contradiction(
    choices: &[ElementMeshes],
    pilots: &Pilots,
    limits: &MeshLimits,
    tolerance: f64,
) -> Option<Contradiction> {
    let by_element = |(choice, own): (&ElementMeshes, &Vec<StoredCase>)| {
        let [coarse, fine] = &own[..] else { return None };
        if [coarse, fine].iter().any(|case| locking::alarm(&case.record).is_some()) {
            return None;
        }
        let r = coarse.record.mesh.h_m / fine.record.mesh.h_m;
        limits.iter().filter(|(_, (_, known))| *known > tolerance).find_map(|(quantity, (limit, _))| {
            let finer = peak(fine, quantity)?;
            let (change, distance) = ((peak(coarse, quantity)? / finer - 1.0).abs(), (limit / finer - 1.0).abs());
            let (formulation, quantity) = (choice.name.clone(), quantity.clone());
            (distance > bound_of_pair(change, r)).then_some(Contradiction { formulation, quantity, change, distance })
        })
    };
    let all = choices.iter().zip(&pilots.of).filter_map(by_element);
    all.min_by(|a, b| a.change.total_cmp(&b.change))
}

/// f_h of every quantity, from the pilots of each element.
pub fn of_meshes(choices: &[ElementMeshes], pilots: &Pilots, quantities: &[String], tolerance: f64) -> MeshLimits {
    let one = |q: &String| Some((q.clone(), of_estimates(&estimates(choices, &pilots.of, q, tolerance), tolerance)?));
    quantities.iter().filter_map(one).collect()
}

/// Returns f_h of every quantity on a given mesh, from the errors estimated in single runs: that of the most certain run. The other formulations check
/// it, unless they lock.
pub fn of_given(pilots: &Pilots, quantities: &[String]) -> MeshLimits {
    let one = |q: &String| {
        let value = |c: &StoredCase| {
            let e = c.record.one_run.as_ref()?.whole(q)?;
            Some((c.record.id.clone(), locking::alarm(&c.record).is_some(), peak(c, q)? + e.correction, e.uncertainty))
        };
        let mut found: Vec<_> = pilots.of.iter().filter_map(|own| value(own.first()?)).collect();
        found.sort_by(|a, b| a.1.cmp(&b.1).then(a.3.total_cmp(&b.3)));
        let (family, _, value, uncertainty) = found.first()?.clone();
        let mut best = Reference {
            value,
            uncertainty,
            scale: value.abs(),
            family,
            method: "from one run".into(),
            envelope: vec![],
            others: vec![],
            disagreement: 0.0,
            independent: None,
        };
        found.iter().skip(1).filter(|f| !f.1).for_each(|(id, _, value, u)| best.check(id, *value, *u));
        (value != 0.0).then(|| (q.clone(), (value, best.uncertainty / value.abs())))
    };
    quantities.iter().filter_map(one).collect()
}

/// Estimates the limit for each element with at least three meshes.
pub fn estimates(choices: &[ElementMeshes], of: &[Vec<StoredCase>], quantity: &str, tolerance: f64) -> Vec<Estimate> {
    let level = |c: &StoredCase| Some(Level { edge: None, ..Level::of(&c.record, quantity, peak(c, quantity)?) });
    let one = |(choice, own): (&ElementMeshes, &Vec<StoredCase>)| {
        let levels: Vec<Level> = own.iter().filter_map(level).collect();
        let mut e = estimate((&choice.name, Role::Element, &choice.name), levels, None, tolerance)?;
        e.uncertainty = e.uncertainty.max(largest_of_sequence(&e));
        e.defensible &= e.uncertainty <= tolerance * e.extrapolated.abs();
        (e.values.len() >= LEAST_PILOTS).then_some(e)
    };
    choices.iter().zip(of).filter_map(one).collect()
}

/// Returns the reference among the families as f_h and U(f_h)/|f_h|; `None` if it is zero, or if the quantity may have no limit on any meshes.
pub fn of_estimates(estimates: &[Estimate], tolerance: f64) -> Option<(f64, f64)> {
    let estimates: Vec<Estimate> = estimates.iter().filter(|e| !e.lasting).cloned().collect();
    let mut best = reference::choose(&estimates, tolerance)?;
    let apart = |e: &&Estimate| !e.refused && e.family != best.family && !best.envelope.contains(&e.family);
    let others: Vec<&Estimate> = estimates.iter().filter(apart).collect();
    others.iter().for_each(|e| best.check(&e.family, e.extrapolated, e.uncertainty));
    (best.value != 0.0).then(|| (best.value, best.uncertainty / best.value.abs()))
}

/// The largest error of the finest value according to any two neighbours in the sequence, scaled with the order: max |fᵢ − fᵢ₊₁|/(rᵖ − 1) (h₁/hᵢ)ᵖ.
pub fn largest_of_sequence(e: &Estimate) -> f64 {
    let p = e.observed_order.unwrap_or(e.formal_order).clamp(LEAST_ORDER, e.formal_order);
    let of =
        |k: usize| correction((e.values[k] - e.values[k + 1]).abs(), e.ratios[k], p) * (e.h_m[0] / e.h_m[k]).powf(p);
    (0..e.ratios.len()).map(of).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_bounds_the_uncertainty_from_below() {
        let (h, f) = ([1.0, 2.0, 4.0, 8.0], [1.0, 1.01, 1.05, 1.8]);
        let levels = h.iter().zip(f).map(|(h, f)| Level { h: *h, f, ..Level::default() }).collect();
        let e = estimate(("tet10", Role::Element, "tet10"), levels, None, 0.01).expect("four meshes");
        let p = e.observed_order.expect("monotone");
        assert!((p - 2.0).abs() < 1e-12, "{p}");
        // The pair 4, 8 of the sequence: 0.75/(2² − 1) (1/4)²
        assert!((largest_of_sequence(&e) - 0.25 / 16.0).abs() < 1e-12, "{}", largest_of_sequence(&e));
    }

    /// With a largest value within the body on three meshes, a border that runs through cells, or a force at a point, no mesh determines a limit, and
    /// that of another element counts.
    #[test]
    fn what_no_mesh_tells_is_no_limit() {
        let of = |name: &str, level: &Level| {
            let levels = [(1.0, 1.01), (1.3, 1.017), (1.7, 1.029)].map(|(h, f)| Level { h, f, ..level.clone() });
            estimate((name, Role::Element, name), levels.into(), None, 0.05).expect("three meshes")
        };
        let sound = of("tet10", &Level::default());
        let limit = of_estimates(std::slice::from_ref(&sound), 0.05).expect("a limit");
        for level in [
            Level { extreme: true, ..Level::default() },
            Level { cut: vec!["clamp".into()], ..Level::default() },
            Level { no_limit: Some("a force on a point".into()), ..Level::default() },
        ] {
            let e = of("tet4", &level);
            assert!(e.lasting && e.refused && !e.defensible, "{e:?}");
            assert_eq!(of_estimates(std::slice::from_ref(&e), 0.05), None);
            assert_eq!(of_estimates(&[e, sound.clone()], 0.05), Some(limit));
        }
    }
}
