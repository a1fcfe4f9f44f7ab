//! The reference value of a quantity and its cross-check.
//!
//! f* is the extrapolated value of the family with the smallest defensible uncertainty. Every other family is checked
//! against it: do f* ± U(f*) overlap? Where another defensible family disagrees, U(f*) grows to reach its value.

use crate::study::estimate::family::Estimate;
use crate::study::estimate::richardson::ROUNDING;
use serde::Serialize;

/// f* ± U(f*) and who says so.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Reference {
    pub value: f64,
    /// U(f*), disagreement included \[unit of f\]
    pub uncertainty: f64,
    pub family: String,
    pub method: String,
    pub others: Vec<CrossCheck>,
    /// Largest |f* − f*_other| of a defensible family whose interval does not overlap \[unit of f\]
    pub disagreement: f64,
}

/// Another family against the reference.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct CrossCheck {
    pub family: String,
    pub value: f64,
    pub uncertainty: f64,
    pub overlaps: bool,
}

/// Among the estimates the one with the smallest uncertainty relative to its value, defensible ones first.
pub fn choose(estimates: &[Estimate]) -> Option<Reference> {
    let relative = |e: &&Estimate| e.uncertainty / e.extrapolated.abs().max(f64::MIN_POSITIVE);
    let best = (estimates.iter())
        .filter(|e| e.uncertainty.is_finite() && e.extrapolated.is_finite())
        .min_by(|a, b| b.defensible.cmp(&a.defensible).then(relative(a).total_cmp(&relative(b))))?;
    let rounding = ROUNDING * best.extrapolated.abs();
    let mut disagreement = 0.0_f64;
    let others = (estimates.iter())
        .filter(|e| e.family != best.family)
        .map(|e| {
            let gap = (e.extrapolated - best.extrapolated).abs();
            let overlaps = gap <= e.uncertainty + best.uncertainty + rounding;
            if e.defensible && !overlaps {
                disagreement = disagreement.max(gap);
            }
            CrossCheck { family: e.family.clone(), value: e.extrapolated, uncertainty: e.uncertainty, overlaps }
        })
        .collect();
    Some(Reference {
        value: best.extrapolated,
        uncertainty: best.uncertainty.max(disagreement),
        family: best.family.clone(),
        method: best.method.clone(),
        others,
        disagreement,
    })
}
