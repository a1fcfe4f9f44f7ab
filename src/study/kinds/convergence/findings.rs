//! Convergence analysis of stored cases: which mesh can be trusted, with what error bar, at what cost.
//!
//! Pure: records and curves in, [`ConvergenceFindings`] out; nothing is solved, read or written. The formulae are in [`crate::study::estimate`], the
//! errors of the cases in [`super::errors`], the sentences in [`super::verdict`] and [`super::warnings`].

use crate::study::analysis::ByQuantity;
use crate::study::estimate::curve::CurveStudy;
use crate::study::estimate::family::Estimate;
use crate::study::estimate::reference::Reference;
use crate::study::extension::Extension;
use crate::study::kinds::convergence::errors::{CaseQuantityError, Noise, TimeStepError, Unresolved};
use crate::study::kinds::convergence::independent::{InputUncertainty, OneRunBar};
use crate::study::store::record::Role;
use serde::Serialize;

/// Findings of a convergence study.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvergenceFindings {
    /// Findings in every quantity \[variants × quantities\]
    pub quantities: Vec<ByQuantity<MeshErrors>>,
    /// Mesh and formulation, cheapest first
    pub settings: Vec<MeshSetting>,
    pub recommended: Option<Recommendation>,
    /// The mesh to add if nothing is recommended
    pub extension: Option<Extension>,
}

/// Errors of the meshes in one quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshErrors {
    pub deciding: bool,
    /// Estimates, one per family of meshes with at least two results
    pub estimates: Vec<Estimate>,
    /// Curves by family
    pub curves: Vec<(String, CurveStudy)>,
    /// Mesh noise, one entry per formulation with seeds
    pub noise: Vec<Noise>,
    pub step: Option<TimeStepError>,
    /// A case whose steps do not resolve the motion
    pub unresolved: Option<Unresolved>,
    /// Largest share of a peak that the time grid may miss between two points \[–\]
    pub missed_share: f64,
    /// Whether this share is above the tolerance of the quantity
    pub is_missed: bool,
    /// Errors of single cases, each from its run alone
    pub one_run: Vec<OneRunBar>,
    /// Uncertainty due to the constants of the laws; `None` if one of them is not determined
    pub inputs: Option<InputUncertainty>,
    /// Constants of the laws whose interval is open
    pub undetermined: Vec<String>,
    /// Constants of the laws with an interval whose contribution to the quantity is unknown, because there is no derivative by them
    pub without_share: Vec<String>,
    pub reference: Option<Reference>,
    pub errors: Vec<CaseQuantityError>,
    /// Whether a reference within the tolerance exists, the time steps resolve the motion, and the time grid captures the extrema of the signals
    pub supported: bool,
    /// Reasons against it, or its limitations
    pub reasons: Vec<String>,
}

impl MeshErrors {
    pub fn estimate(&self, family: &str) -> Option<&Estimate> {
        self.estimates.iter().find(|e| e.family == family)
    }

    /// Whether the reference comes from a refused family, because all families are refused.
    pub fn has_refused_reference(&self) -> bool {
        self.reference.as_ref().and_then(|r| self.estimate(&r.family)).is_some_and(|e| e.refused)
    }

    /// Returns the estimate of the family that the study is about.
    pub fn sizes(&self) -> Option<&Estimate> {
        self.estimates.iter().find(|e| e.role == Role::Sizes)
    }
}

impl ConvergenceFindings {
    pub fn find(&self, variant: &str, quantity: &str) -> Option<&ByQuantity<MeshErrors>> {
        self.quantities.iter().find(|q| q.variant == variant && q.quantity.name == quantity)
    }

    /// Returns the quantity that the study names for its summary, otherwise the first deciding one with an estimate.
    pub fn headline(&self) -> Option<&ByQuantity<MeshErrors>> {
        headline(&self.quantities)
    }
}

/// Returns the quantity that summarises a study, see [`ConvergenceFindings::headline`].
pub fn headline(quantities: &[ByQuantity<MeshErrors>]) -> Option<&ByQuantity<MeshErrors>> {
    let estimated = || quantities.iter().filter(|q| !q.estimates.is_empty());
    let named = estimated().find(|q| q.quantity.headline);
    named.or_else(|| estimated().find(|q| q.deciding)).or(quantities.first())
}

/// A mesh with a formulation, in every variant in which it was run.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct MeshSetting {
    /// Name in words: `tet4, 16200 cells`
    pub label: String,
    pub formulation: String,
    pub cells: usize,
    pub h_m: f64,
    pub family: String,
    pub cases: Vec<String>,
    /// CPU time of a case, mean over the variants \[s\]
    pub cost_s: f64,
    pub bars: Vec<Bar>,
    /// Largest error bar of the deciding quantities \[–\]; infinite if one has no reference or no result
    pub worst: f64,
    /// Title of the quantity with the largest bar
    pub limited_by: String,
}

/// Error and error bar of a setting in one quantity.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Bar {
    pub variant: String,
    pub quantity: String,
    pub value: f64,
    pub error: f64,
    pub bar: f64,
    pub cost_s: f64,
}

/// The cheapest setting that meets the tolerance in every deciding quantity.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Recommendation {
    /// Case id in the variant of the headline
    pub case: String,
    pub cases: Vec<String>,
    pub label: String,
    pub error_bar: f64,
    pub limited_by: String,
    pub cost_s: f64,
    /// The next better setting: label, error bar \[–\], cost \[s\]
    pub next: Option<(String, f64, f64)>,
}
