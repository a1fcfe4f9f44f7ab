//! Evidence in addition to the families of meshes: errors estimated from single runs, and the uncertainty of the constants.
//!
//! ```text
//! constants     √(Σⱼₖ rⱼₖ cⱼ cₖ)/scale                                     on the finest mesh of the leading family
//!               cₖ = ∂J/∂θₖ · the larger side of the 95 % interval of θₖ,   rⱼₖ the correlation of θⱼ and θₖ
//! together      √(bar² + constants²)                                        after ASME V&V 20-2009, section 1-5
//! ```

use crate::math::statistics::root;
use crate::study::curve::peak;
use crate::study::estimate::family::Estimate;
use crate::study::estimate::reference::Reference;
use crate::study::kinds::convergence::cases::Cases;
use crate::study::run::uncertain_constants::UncertainConstantRecord;
use crate::study::store::record::StoredCase;
use serde::Serialize;

/// The error of one case from its run alone \[unit of f; bar –\].
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct OneRunBar {
    pub id: String,
    pub value: f64,
    pub corrected: f64,
    pub uncertainty: f64,
    /// Error bar relative to the scale \[–\]
    pub bar: f64,
    /// Parts of the error that the bar lacks, in words
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lacks: Option<String>,
}

/// Uncertainty of a quantity due to the constants of the laws.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct InputUncertainty {
    /// The case whose derivatives were taken
    pub case: String,
    pub constants: Vec<String>,
    /// Half-width of the 95 % interval relative to the scale \[–\]
    pub share: f64,
    /// Whether the law file states the correlations of the constants
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub correlated: bool,
}

/// Returns one entry per case with an estimate from its own run.
pub fn one_run(cases: &Cases, variant: &str, quantity: &str, scale: f64) -> Vec<OneRunBar> {
    let bar = |c: &StoredCase| {
        let e = c.record.one_run.as_ref()?.quantities.get(quantity)?;
        let value = peak(c, quantity)?;
        let (corrected, uncertainty) = (value + e.correction, e.uncertainty);
        let (bar, lacks) = (e.bar / scale, e.lacks());
        Some(OneRunBar { id: c.record.id.clone(), value, corrected, uncertainty, bar, lacks })
    };
    cases.of_variant(variant).filter_map(bar).collect()
}

/// Compares the reference with the single-run estimate of the finest mesh of its leading family, if that estimate lacks no part of its error.
pub fn check(reference: &mut Reference, finest: Option<&String>, own: &[OneRunBar]) {
    if let Some(bar) = own.iter().find(|b| Some(&b.id) == finest && b.lacks.is_none()) {
        reference.check(&bar.id, bar.corrected, bar.uncertainty);
    }
}

/// Returns the uncertainty due to the constants, from the finest mesh of the leading family that has derivatives by constants with intervals; if
/// there is none, from the next family of the envelope. A mesh of another family may lock, and its derivatives with it.
pub fn input_uncertainty(
    cases: &Cases,
    (variant, quantity): (&str, &str),
    estimates: &[Estimate],
    reference: &Reference,
) -> Option<InputUncertainty> {
    let families = std::iter::once(&reference.family).chain(&reference.envelope);
    let mut ids = families.filter_map(|f| estimates.iter().find(|e| e.family == *f)).flat_map(|e| &e.cases);
    let known = |id: &String| {
        let case = &cases.of_variant(variant).find(|c| c.record.id == *id)?.record;
        let is_known = !case.inputs.is_empty() && case.inputs.iter().all(|i| i.derivatives.contains_key(quantity));
        is_known.then_some(case)
    };
    let finest = ids.find_map(known)?;
    let change = |i: &UncertainConstantRecord| i.derivatives[quantity] * i.half_width;
    let correlation = |a: &UncertainConstantRecord, b: &UncertainConstantRecord| match a.constant == b.constant {
        true => 1.0,
        false => a.correlation.get(&b.constant).copied().unwrap_or(0.0),
    };
    let pairs = finest.inputs.iter().flat_map(|a| finest.inputs.iter().map(move |b| (a, b)));
    let square: f64 = pairs.map(|(a, b)| correlation(a, b) * change(a) * change(b)).sum();
    let share = root(square) / reference.scale;
    let correlated = finest.inputs.iter().any(|i| !i.correlation.is_empty());
    let constants = finest.inputs.iter().map(|i| i.constant.clone()).collect();
    share.is_finite().then(|| InputUncertainty { case: finest.id.clone(), constants, share, correlated })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An estimate that lacks a part of its error, or belongs to a mesh other than the finest, says nothing about the reference; a complete one
    /// widens it to reach the estimate.
    #[test]
    fn only_a_whole_estimate_of_the_finest_mesh_is_compared() {
        let reference = Reference {
            value: 1.0,
            uncertainty: 0.1,
            scale: 1.0,
            family: "tet10".into(),
            method: String::new(),
            envelope: vec!["tet10".into()],
            others: vec![],
            disagreement: 0.0,
            independent: None,
        };
        let own = |id: &str, lacks: Option<&str>| OneRunBar {
            id: id.into(),
            value: 2.0,
            corrected: 2.0,
            uncertainty: 0.2,
            bar: 0.2,
            lacks: lacks.map(String::from),
        };
        let (fine, coarse) = ("fine".to_string(), own("coarse", None));
        let checked = |own: &[OneRunBar]| {
            let mut checked = reference.clone();
            check(&mut checked, Some(&fine), own);
            checked
        };
        assert_eq!(checked(&[coarse.clone(), own("fine", Some("the time steps"))]), reference);
        let whole = checked(&[coarse, own("fine", None)]);
        assert!((whole.uncertainty - 0.1_f64.hypot(1.0)).abs() < 1e-15);
        assert!(whole.independent.is_some_and(|check| check.of == "fine" && !check.overlaps));
    }
}
