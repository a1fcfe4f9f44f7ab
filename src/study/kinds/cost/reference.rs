//! The reference that the settings of a variant are compared with, and its own uncertainty.
//!
//! The families of role `reference`, or in their absence the families of meshes, are extrapolated as in a convergence study
//! ([`crate::study::estimate::family`] for the peak, [`crate::study::estimate::curve`] for the curve): over h if the meshes differ, otherwise over
//! the time step with the lowest order of the integrators of its stages. The reference is the envelope of the defensible families
//! ([`crate::study::estimate::reference`]). Families that a convergence study refuses, such as those that lock, diverge, do not resolve the thinnest
//! wall or may have no limit, cannot be a reference. With an absolute tolerance, errors are relative to the scale of
//! [`crate::study::estimate::tolerance`].
//!
//! ```text
//! U(f*) of the peak                as in a convergence study
//! U of the curve, relative in L2   max(U(f*)/|f*|, (Fs − 1)/Fs ‖GCI‖₂/‖f* − f*₀‖₂) + largest error of the interpolation over the peak
//! ```

use crate::study::curve::peak;
use crate::study::curve::{Curve, l2};
use crate::study::estimate::curve::compare;
use crate::study::estimate::family::{Estimate, Level, estimate_of_order, formal_order};
use crate::study::estimate::reference as chosen;
use crate::study::estimate::step_size::step_sizes;
use crate::study::estimate::tolerance::Tolerance;
use crate::study::store::record::{FamilyRecord, Role, StoredCase, StudyQuantity, StudyRecord};
use serde::Serialize;

/// The extrapolated f* and f*(t) with their own errors.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct ReferenceCurve {
    pub family: String,
    pub method: String,
    /// Families that it comes from, in words
    pub from: String,
    /// Peak f* \[unit of f\]
    pub peak: f64,
    /// Value that errors are relative to, |f*| unless the tolerance is absolute \[unit of f\]
    pub scale: f64,
    /// Whether its family is refused, for example because it locks, diverges, or does not resolve the thinnest wall: no error is known
    pub refused: bool,
    /// U(f*)/scale \[–\]
    pub peak_uncertainty: f64,
    /// L2 error of f*(t) relative to the size of its changes \[–\]
    pub curve_uncertainty: f64,
    /// Limitations of the reference
    pub reasons: Vec<String>,
    #[serde(skip)]
    pub curve: Curve,
}

/// Returns the converged cases of a family in a variant.
pub fn members<'a>(stored: &'a [StoredCase], family: &FamilyRecord, variant: &str) -> Vec<&'a StoredCase> {
    stored.iter().filter(|c| c.record.converged() && c.is_in(&family.name, variant)).collect()
}

/// Returns the time steps of the cases of a family \[s\].
pub fn steps(cases: &[&StoredCase]) -> Vec<f64> {
    step_sizes(&cases.iter().map(|c| &c.record).collect::<Vec<_>>())
}

/// The sizes of the cases along the axis in which their family is refined, and the formal order there.
fn sizes(cases: &[&StoredCase]) -> (Vec<f64>, f64) {
    let Some(first) = cases.first().map(|c| &c.record) else { return (vec![], 2.0) };
    match cases.iter().any(|c| (c.record.mesh.h_m / first.mesh.h_m - 1.0).abs() > 1e-6) {
        true => (cases.iter().map(|c| c.record.mesh.h_m).collect(), formal_order(&first.formulation)),
        false => (steps(cases), first.order_in_time()),
    }
}

/// Returns the reference of a quantity in a variant; `None` if no family has two cases.
pub fn reference(
    study: &StudyRecord,
    stored: &[StoredCase],
    variant: &str,
    quantity: &StudyQuantity,
) -> Option<ReferenceCurve> {
    let tolerance = quantity.tolerance(study.tolerance);
    let quantity = quantity.name.as_str();
    let of = |roles: &[Role]| -> Vec<(&FamilyRecord, Estimate)> {
        let families = study.families.iter().filter(|f| roles.contains(&f.role));
        families
            .filter_map(|f| Some((f, extrapolated(f, &members(stored, f, variant), quantity, tolerance)?)))
            .collect()
    };
    let mut found = of(&[Role::Reference]);
    if found.is_empty() {
        found = of(&[Role::Sizes, Role::Element]);
    }
    let estimates: Vec<Estimate> = found.iter().map(|f| f.1.clone()).collect();
    let best = chosen::choose(&estimates, tolerance)?;
    let (family, estimate) = found.iter().find(|f| f.1.family == best.family)?;
    let cases = members(stored, family, variant);
    let (sizes, formal) = sizes(&cases);
    let mut curves: Vec<(String, f64, Curve)> = (cases.iter().zip(sizes))
        .filter_map(|(c, size)| Some((c.record.id.clone(), size, Curve::of(&c.series, quantity)?)))
        .collect();
    curves.sort_by(|a, b| a.1.total_cmp(&b.1));
    let peak_uncertainty = best.uncertainty / best.scale;
    let study = compare(&curves, formal)?;
    let finest = &curves.first()?.2;
    let f = if study.star.is_empty() { study.t.iter().map(|t| finest.at(*t)).collect() } else { study.star.clone() };
    let curve = Curve { t: study.t, f };
    let size = curve.size_of_changes().max(least(tolerance));
    let beyond = match study.gci.is_empty() || size == 0.0 {
        true => 0.0,
        false => (study.fs - 1.0) / study.fs * l2(&curve.t, &study.gci) / size,
    };
    let interpolated = study.interpolation_error.max(finest.interpolation_error()) / best.scale;
    Some(ReferenceCurve {
        from: best.from_words(),
        family: best.family,
        method: best.method,
        peak: best.value,
        scale: best.scale,
        refused: estimate.refused,
        peak_uncertainty,
        curve_uncertainty: peak_uncertainty.max(beyond) + interpolated,
        reasons: estimate.reasons.clone(),
        curve,
    })
}

/// Smallest size of a curve that errors are relative to; zero without an absolute tolerance.
fn least(tolerance: Tolerance) -> f64 {
    tolerance.scale(0.0)
}

fn extrapolated(
    family: &FamilyRecord,
    cases: &[&StoredCase],
    quantity: &str,
    tolerance: Tolerance,
) -> Option<Estimate> {
    let (sizes, formal) = sizes(cases);
    let by_mesh = cases.iter().any(|c| c.record.mesh.h_m != cases[0].record.mesh.h_m);
    let level = |(c, size): (&&StoredCase, f64)| {
        let f = peak(c, quantity)?;
        Some(if by_mesh { Level::of(&c.record, quantity, f) } else { Level::of_steps(&c.record, f, size) })
    };
    let levels = cases.iter().zip(sizes).filter_map(level).collect();
    estimate_of_order((&family.name, family.role, family.formulation_of(cases)), formal, levels, None, tolerance)
}

/// Returns ‖f − f*‖₂/‖f* − f*₀‖₂ at the times of f*, with f linear between its rows, because a user with such steps knows no more. The position of
/// the body in its frame does not matter.
pub fn curve_error(
    reference: &ReferenceCurve,
    case: &StoredCase,
    quantity: &StudyQuantity,
    tolerance: f64,
) -> Option<f64> {
    let f = Curve::of(&case.series, &quantity.name)?;
    let Curve { t, f: star } = &reference.curve;
    let d: Vec<f64> = t.iter().zip(star).map(|(t, star)| f.at(*t) - star).collect();
    let whole = reference.curve.size_of_changes().max(least(quantity.tolerance(tolerance)));
    (whole > 0.0).then(|| l2(t, &d) / whole)
}
