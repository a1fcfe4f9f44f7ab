//! Convergence analysis of stored cases: which mesh can be trusted, with what error bar, at what cost.
//!
//! Pure: records and curves in, [`Analysis`] out; nothing is solved, read or written. The formulae are in
//! [`crate::study::estimate`], the errors of the cases in [`super::errors`], the sentences in [`super::verdict`] and [`super::warnings`].

use crate::study::estimate::curve::CurveStudy;
use crate::study::estimate::family::Estimate;
use crate::study::estimate::reference::Reference;
use crate::study::kinds::convergence::errors::{CaseError, Noise, TimeStep};
use crate::study::record::{Quantity, Role};
use serde::Serialize;

/// Everything that is said about a study.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Analysis {
    pub tolerance: f64,
    /// \[variants × quantities\]
    pub quantities: Vec<QuantityAnalysis>,
    /// Mesh + formulation, cheapest first
    pub settings: Vec<Setting>,
    pub recommended: Option<Recommendation>,
    /// Cases without a usable result: (id, what is wrong)
    pub incomplete: Vec<(String, String)>,
    /// `wall_s`, or `cpu_s` if any case ran at the same time as another
    pub cost: &'static str,
    pub warnings: Vec<String>,
    /// In words, refusals included
    pub verdict: String,
}

/// One quantity in one variant.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct QuantityAnalysis {
    pub variant: String,
    /// The variant in words
    pub variant_label: String,
    pub quantity: Quantity,
    pub deciding: bool,
    /// Judged by its largest change, since it does not start at zero
    pub change: bool,
    /// One per family of meshes with two or more results
    pub estimates: Vec<Estimate>,
    /// (family, curves)
    pub curves: Vec<(String, CurveStudy)>,
    pub noise: Option<Noise>,
    pub time_step: Option<TimeStep>,
    pub reference: Option<Reference>,
    pub errors: Vec<CaseError>,
    /// A reference within the tolerance exists
    pub supported: bool,
    /// Why not, or what limits it
    pub reasons: Vec<String>,
    pub sentence: String,
}

impl QuantityAnalysis {
    pub fn estimate(&self, family: &str) -> Option<&Estimate> {
        self.estimates.iter().find(|e| e.family == family)
    }

    /// The family the study is about.
    pub fn sizes(&self) -> Option<&Estimate> {
        self.estimates.iter().find(|e| e.role == Role::Sizes)
    }

    /// `peak bending angle, tension control`
    pub fn title(&self) -> String {
        let what = if self.change { "largest change of" } else { "peak" };
        format!("{what} {}, {}", self.quantity.label, self.variant_label)
    }
}

impl Analysis {
    pub fn find(&self, variant: &str, quantity: &str) -> Option<&QuantityAnalysis> {
        self.quantities.iter().find(|q| q.variant == variant && q.quantity.name == quantity)
    }

    /// The quantity that the study names for its summary, else the first one that decides and has an estimate.
    pub fn headline(&self) -> Option<&QuantityAnalysis> {
        headline(&self.quantities)
    }
}

/// The quantity that summarises a study, see [`Analysis::headline`].
pub fn headline(quantities: &[QuantityAnalysis]) -> Option<&QuantityAnalysis> {
    let estimated = || quantities.iter().filter(|q| !q.estimates.is_empty());
    let named = estimated().find(|q| q.quantity.headline);
    named.or_else(|| estimated().find(|q| q.deciding)).or(quantities.first())
}

/// A mesh with a formulation, in every variant it was run in.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Setting {
    /// `tet4, 16200 cells`
    pub label: String,
    pub formulation: String,
    pub cells: usize,
    pub h_m: f64,
    pub family: String,
    pub cases: Vec<String>,
    /// Mean over the variants \[s\]
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
