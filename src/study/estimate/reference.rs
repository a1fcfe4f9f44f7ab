//! The reference value of a quantity, from the limits of all families that can serve as one.
//!
//! ```text
//! leading     argmin U(f*)/scale · 1, 2, 3      with at least four meshes, three, two; among the defensible families, else those not refused, else all
//! f*, U(f*)   of the leading family;   U² = U(f*)² + max |f* − f*ᵢ|² over every defensible family i
//! ```
//!
//! The order of three meshes has not been checked by a fourth, so that the smallest claim is not the best evidence. The limits of all defensible
//! families (which excludes those that lock, diverge, or do not resolve their walls) enter, whether or not the intervals overlap: two limits of one
//! number differ by the error of at least one of them. A family that is not defensible is compared with the reference and does not change it.
//! `tests/estimates/coverage_of_estimates.rs` measures how often the interval contains the true value.

use crate::math::statistics::larger;
use crate::report::numbers::{minus_signs, space, within};
use crate::study::estimate::family::Estimate;
use crate::study::estimate::richardson::ROUNDING;
use crate::study::estimate::tolerance::Tolerance;
use serde::Serialize;

/// The reference value f* ± U(f*) and its sources.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Reference {
    pub value: f64,
    /// U(f*), including the distance to the limits of the envelope \[unit of f\]
    pub uncertainty: f64,
    /// Value relative to which errors are given, |f*| unless the tolerance is absolute \[unit of f\]
    pub scale: f64,
    /// The leading family
    pub family: String,
    pub method: String,
    /// Defensible families, the leading one first; if empty, the leading family is merely the best available
    pub envelope: Vec<String>,
    pub others: Vec<CrossCheck>,
    /// Largest |f* − f*ᵢ| over the envelope \[unit of f\]
    pub disagreement: f64,
    /// An estimate by another method, here from a single run
    pub independent: Option<CrossCheck>,
}

/// Comparison of another family, or of the estimate from a single run, with the reference.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct CrossCheck {
    /// The family, or the case of the single run
    #[serde(rename = "family")]
    pub of: String,
    pub value: f64,
    pub uncertainty: f64,
    /// Whether its interval overlaps that of the leading family, or of the reference
    pub overlaps: bool,
}

/// Factor on a claimed uncertainty by the number of meshes behind it.
fn caution(meshes: usize) -> f64 {
    match meshes {
        0..=2 => 3.0,
        3 => 2.0,
        _ => 1.0,
    }
}

/// Chooses the reference from the estimates of one quantity, one per family.
pub fn choose(estimates: &[Estimate], tolerance: impl Into<Tolerance>) -> Option<Reference> {
    let tolerance = tolerance.into();
    // A small U(f*) of a refused family is not a claim
    let rank = |e: &Estimate| (!e.defensible, e.refused);
    let claim =
        |e: &&Estimate| caution(e.cases.len()) * e.uncertainty / tolerance.scale(e.extrapolated).max(f64::MIN_POSITIVE);
    let leading = (estimates.iter())
        .filter(|e| e.uncertainty.is_finite() && e.extrapolated.is_finite())
        .min_by(|a, b| rank(a).cmp(&rank(b)).then(claim(a).total_cmp(&claim(b))))?;
    let rounding = ROUNDING * leading.extrapolated.abs();
    let gap = |e: &Estimate| (e.extrapolated - leading.extrapolated).abs();
    let others = || estimates.iter().filter(|e| e.family != leading.family);
    let disagreement = others().filter(|e| e.defensible).map(gap).fold(0.0, larger);
    let check = |e: &Estimate| CrossCheck {
        of: e.family.clone(),
        value: e.extrapolated,
        uncertainty: e.uncertainty,
        overlaps: gap(e) <= e.uncertainty + leading.uncertainty + rounding,
    };
    let mut envelope: Vec<&Estimate> = others().filter(|e| e.defensible).collect();
    envelope.extend(leading.defensible.then_some(leading));
    envelope.rotate_right(usize::from(leading.defensible));
    Some(Reference {
        value: leading.extrapolated,
        uncertainty: leading.uncertainty.hypot(disagreement),
        scale: tolerance.scale(leading.extrapolated),
        family: leading.family.clone(),
        method: leading.method.to_string(),
        envelope: envelope.iter().map(|e| e.family.clone()).collect(),
        others: others().map(check).collect(),
        disagreement,
        independent: None,
    })
}

impl Reference {
    /// Compares the reference with an estimate by another method. If the intervals do not overlap, U(f*) is increased to reach the estimate.
    pub fn check(&mut self, of: &str, value: f64, uncertainty: f64) {
        let gap = (value - self.value).abs();
        let overlaps = gap <= uncertainty + self.uncertainty;
        if !overlaps {
            self.uncertainty = self.uncertainty.hypot(gap);
        }
        self.independent = Some(CrossCheck { of: of.into(), value, uncertainty, overlaps });
    }

    /// Value and uncertainty in words: `−0.00542 m ± 0.00012 m`.
    pub fn words(&self, unit: &str) -> String {
        let unit = space(unit);
        let [value, half] = [self.value, self.uncertainty].map(|v| minus_signs(&within(v, self.uncertainty)));
        format!("{value}{unit} ± {half}{unit}")
    }

    /// The supporting families in words: `from family tet10_up alone` or `from families tet10_up, tet10, nested`.
    pub fn from_words(&self) -> String {
        match self.envelope.len() {
            0 | 1 => format!("from family {} alone", self.family),
            _ => format!("from families {}", self.envelope.join(", ")),
        }
    }

    /// Whether a defensible family supports it and its uncertainty is within the tolerance.
    pub fn is_within(&self, tolerance: Tolerance) -> bool {
        !self.envelope.is_empty() && self.uncertainty <= tolerance.allowed(self.value)
    }
}
