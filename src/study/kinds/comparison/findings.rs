//! Findings of a comparison, see [`super::analysis`].

use crate::study::analysis::ByQuantity;
use crate::study::kinds::comparison::sequence::Sequence;
use serde::{Deserialize, Serialize};

/// The member that the others are compared with, as it is stored with the study.
#[derive(Clone, Debug, Default, Serialize, Deserialize, PartialEq)]
pub struct ComparisonRecord {
    /// Name of the reference; empty if all families are cumulative, so that each member is compared with the one before it
    #[serde(default)]
    pub reference: String,
}

/// Findings of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparisonFindings {
    /// The member that the others are compared with
    pub reference: String,
    /// Differences in every quantity that the protocol does not impose \[variants × quantities\]
    pub quantities: Vec<ByQuantity<MemberDifferences>>,
    /// Members that lack a curve, imposed quantities excepted
    pub incomparable: Vec<Incomparable>,
    pub costs: Vec<MemberCost>,
    /// Effects added one by one, per variant
    pub sequences: Vec<Sequence>,
}

/// The members in one quantity.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct MemberDifferences {
    /// Peak of the reference
    pub peak: f64,
    /// The members in the order of the study, including the reference
    pub members: Vec<ComparedMember>,
}

/// One member against the reference.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct ComparedMember {
    pub member: String,
    pub case: String,
    pub peak: f64,
    /// Difference of the peaks, (f̂ − ĝ)/ĝ: negative if the magnitude is smaller, below −1 if the signs differ. Relative to the scale of the absolute
    /// tolerance if that is larger \[–\]
    pub peak_difference: f64,
    /// Change of the difference on the finer mesh \[–\]
    pub mesh_drift: Option<f64>,
    /// ‖f − g‖₂ relative to the changes of g from its start \[–\]
    pub distance: f64,
    /// ‖f − g‖∞ relative to the scale of the tolerance \[–\]
    pub largest: f64,
    /// Lag behind the reference \[s\]; `None` beyond first order
    pub lag_s: Option<f64>,
    /// ∮ f dx over the last cycle \[unit of f times unit of x\]
    pub loop_area: Option<f64>,
    /// Area of the loop relative to the box around the cycle \[–\]
    pub loop_share: Option<f64>,
}

/// A member that cannot be compared with the reference in one quantity of one variant.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Incomparable {
    pub variant: String,
    pub quantity: String,
    /// Quantity and variant in words
    #[serde(skip)]
    pub place: String,
    pub member: String,
    pub why: String,
}

/// Cost of a member, mean over the variants.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct MemberCost {
    pub member: String,
    pub formulation: String,
    pub cells: usize,
    pub dofs: usize,
    pub cpu_s: f64,
    /// CPU time relative to the reference, if the reference has a result \[–\]
    pub ratio: Option<f64>,
    pub steps: usize,
    /// Iterations, including those of rejected steps
    pub newton_iterations: usize,
}
