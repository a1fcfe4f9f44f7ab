//! Details that a coverage study keeps with its record.

use crate::study::store::record::StudyQuantity;
use serde::{Deserialize, Serialize};

/// The problems of a study.
#[derive(Clone, Debug, Default, Serialize, Deserialize, PartialEq)]
pub struct CoverageRecord {
    pub problems: Vec<ProblemRecord>,
}

/// A problem, and the families of cases that solve it.
#[derive(Clone, Debug, Default, Serialize, Deserialize, PartialEq)]
pub struct ProblemRecord {
    pub name: String,
    pub label: String,
    pub body: String,
    /// Whether no edge is singular
    pub smooth: bool,
    /// Whether the boundary is curved, so that linear cells cut it
    pub curved: bool,
    /// Whether it took no part in the choice of the bounds and rules that are judged
    #[serde(default)]
    pub fresh: bool,
    pub quantities: Vec<StudyQuantity>,
    /// Families whose error bars are judged
    pub judged: Vec<JudgedFamily>,
    /// Families that determine the truth
    pub truths: Vec<String>,
}

/// The meshes of one seed in one formulation.
#[derive(Clone, Debug, Default, Serialize, Deserialize, PartialEq)]
pub struct JudgedFamily {
    pub family: String,
    pub seed: String,
}
