//! Convergence analysis of stored cases: which mesh can be trusted, with what error bar, at what cost.
//!
//! Pure: records and curves in, [`ConvergenceFindings`] out; nothing is solved, read or written. The formulae are in
//! [`crate::study::estimate`], the errors of the cases in [`super::errors`], the sentences in [`super::verdict`] and [`super::warnings`].

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
    /// \[variants × quantities\]
    pub quantities: Vec<ByQuantity<MeshErrors>>,
    /// Mesh + formulation, cheapest first
    pub settings: Vec<MeshSetting>,
    pub recommended: Option<Recommendation>,
    /// The mesh to add where nothing is recommended
    pub extension: Option<Extension>,
}

/// Errors of the meshes in one quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshErrors {
    pub deciding: bool,
    /// One per family of meshes with two or more results
    pub estimates: Vec<Estimate>,
    /// (family, curves)
    pub curves: Vec<(String, CurveStudy)>,
    /// One per formulation with seeds
    pub noise: Vec<Noise>,
    pub step: Option<TimeStepError>,
    /// A case whose steps do not resolve the motion
    pub unresolved: Option<Unresolved>,
    /// Largest share of a peak that the time grid may miss between two points \[–\]
    pub missed_share: f64,
    /// It is above the tolerance of the quantity
    pub is_missed: bool,
    /// Errors of single cases from their runs alone
    pub one_run: Vec<OneRunBar>,
    /// The uncertainty by the constants of the laws; none where one of them is not determined
    pub inputs: Option<InputUncertainty>,
    /// Constants of the laws whose interval is open
    pub undetermined: Vec<String>,
    /// Constants of the laws with an interval whose share of the quantity is not known, since no derivative by them is there
    pub without_share: Vec<String>,
    pub reference: Option<Reference>,
    pub errors: Vec<CaseQuantityError>,
    /// A reference within the tolerance exists, the time steps resolve the motion, and the time grid meets the extrema of the signals
    pub supported: bool,
    /// Why not, or what limits it
    pub reasons: Vec<String>,
}

impl MeshErrors {
    pub fn estimate(&self, family: &str) -> Option<&Estimate> {
        self.estimates.iter().find(|e| e.family == family)
    }

    /// Whether the reference is of a family that is refused, since all are.
    pub fn has_refused_reference(&self) -> bool {
        self.reference.as_ref().and_then(|r| self.estimate(&r.family)).is_some_and(|e| e.refused)
    }

    /// The family the study is about.
    pub fn sizes(&self) -> Option<&Estimate> {
        self.estimates.iter().find(|e| e.role == Role::Sizes)
    }
}

impl ConvergenceFindings {
    pub fn find(&self, variant: &str, quantity: &str) -> Option<&ByQuantity<MeshErrors>> {
        self.quantities.iter().find(|q| q.variant == variant && q.quantity.name == quantity)
    }

    /// The quantity that the study names for its summary, else the first one that decides and has an estimate.
    pub fn headline(&self) -> Option<&ByQuantity<MeshErrors>> {
        headline(&self.quantities)
    }
}

/// The quantity that summarises a study, see [`ConvergenceFindings::headline`].
pub fn headline(quantities: &[ByQuantity<MeshErrors>]) -> Option<&ByQuantity<MeshErrors>> {
    let estimated = || quantities.iter().filter(|q| !q.estimates.is_empty());
    let named = estimated().find(|q| q.quantity.headline);
    named.or_else(|| estimated().find(|q| q.deciding)).or(quantities.first())
}

/// A mesh with a formulation, in every variant it was run in.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct MeshSetting {
    /// `tet4, 16200 cells`
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
    /// Title of the quantity with that bar
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
    /// Id in the variant of the headline
    pub case: String,
    pub cases: Vec<String>,
    pub label: String,
    pub error_bar: f64,
    pub limited_by: String,
    pub cost_s: f64,
    /// The next better one: label, error bar \[–\], cost \[s\]
    pub next: Option<(String, f64, f64)>,
}
