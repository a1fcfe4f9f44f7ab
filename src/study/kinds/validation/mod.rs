//! Validation: constants from measured records, predictions of others with an error budget, and a score where these are measured too.
//!
//! | Step | File |
//! |---|---|
//! | Keys of the study, its plan, its cases | [`spec`], [`plan`], [`expansion`], [`measured`], [`field`] |
//! | A number from a run, with derivatives | [`evaluate`] |
//! | Runs of a design as a function | [`surface`] |
//! | Constants and predictions with all their sources of error | [`joint`], [`monte_carlo`], [`budget`] |
//! | Error of mesh, time steps and surface | [`numerical`] |
//! | Verdict, page, files | [`analysis`], [`report`], [`figures`], [`predictions`] |

pub mod analysis;
pub mod budget;
pub mod evaluate;
pub mod expansion;
pub mod field;
pub mod figures;
pub mod joint;
pub mod measured;
pub mod monte_carlo;
pub mod numerical;
pub mod plan;
pub mod predictions;
pub mod report;
pub mod spec;
pub mod surface;

use crate::scene::SceneError;
use crate::study::analysis::Analysis;
use crate::study::content::Content;
use crate::study::kind::{Expansion, StudyKind};
use crate::study::store::results::Results;
use analysis::{ValidationFindings, analyse};
use plan::ValidationPlan;
pub use spec::ValidationStudy;
use std::path::Path;

impl StudyKind for ValidationStudy {
    const NAME: &'static str = "validation";
    type Details = ValidationPlan;
    type Findings = ValidationFindings;

    fn expand(self, file: &Path, scene: &Path) -> Result<Expansion<ValidationPlan>, SceneError> {
        expansion::expand(&self, file, scene)
    }

    fn analyse(results: &Results, plan: &ValidationPlan) -> Analysis<ValidationFindings> {
        analyse(results, plan)
    }

    fn report(results: &Results, analysis: &Analysis<ValidationFindings>) -> Content {
        report::content(results, analysis)
    }
}
