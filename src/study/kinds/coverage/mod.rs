//! Coverage: how often error bars contain known truths, and how much wider they are than the errors.

pub mod analysis;
pub mod figure;
pub mod mark;
pub mod record;
pub mod report;
pub mod share;
pub mod spec;
pub mod truth;

use crate::scene::SceneError;
use crate::study::analysis::Analysis;
use crate::study::content::Content;
use crate::study::kind::{Expansion, StudyKind};
use crate::study::spec::refuse;
use crate::study::store::results::Results;
use analysis::{CoverageFindings, analyse};
use record::CoverageRecord;
use std::path::Path;

pub use spec::CoverageStudy;

impl StudyKind for CoverageStudy {
    const NAME: &'static str = "coverage";
    type Details = CoverageRecord;
    type Findings = CoverageFindings;

    /// Keeps only the problems that are marked as quick.
    fn quick(mut self) -> Self {
        self.problems.retain(|problem| problem.quick);
        self
    }

    fn expand(self, file: &Path, _: &Path) -> Result<Expansion<CoverageRecord>, SceneError> {
        spec::expand(&self).map_err(|mistake| refuse(file, mistake))
    }

    fn analyse(results: &Results, coverage: &CoverageRecord) -> Analysis<CoverageFindings> {
        analyse(&results.study, coverage, &results.cases)
    }

    fn report(results: &Results, analysis: &Analysis<CoverageFindings>) -> Content {
        let errors = "A bar holds where the truth is within it. Truths are limits of far finer meshes with their uncertainty; intervals of \
        shares are those of Wilson [@wilson1927]."
            .into();
        Content { errors, ..report::content(results, analysis) }
    }
}
