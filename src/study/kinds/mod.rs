//! The kinds of study, one folder each. A new kind is one folder and one line in [`KINDS`].

pub mod calibration;
pub mod convergence;
pub mod cost;
pub mod materials;
pub mod prices;
pub mod robustness;
pub mod sweep;

use crate::study::content::Content;
use crate::study::results::Results;

/// Analyses the stored cases of a kind.
pub type Analyse = fn(&Results) -> Content;

/// `kind` of a study → its analysis.
pub const KINDS: [(&str, Analyse); 7] = [
    ("convergence", convergence::report::content),
    ("materials", materials::report::content),
    ("calibration", calibration::report::content),
    ("sweep", sweep::report::content),
    ("prices", prices::report::content),
    ("cost", cost::report::content),
    ("robustness", robustness::report::content),
];
