//! Reduction: models of few unknowns made of runs of a scene, at rest or in time, with what they cost and how far they are off.

pub mod analysis;
pub mod build;
pub mod figures;
pub mod in_time;
pub mod path;
pub mod record;
pub mod report;
pub mod spec;
pub mod trained;

use crate::scene::SceneError;
use crate::study::analysis::Analysis;
use crate::study::content::Content;
use crate::study::kind::{Expansion, StudyKind};
use crate::study::spec::refuse;
use crate::study::store::results::Results;
use analysis::{ReductionFindings, analyse};
use record::ReductionRecord;
use spec::ReductionStudy;
use std::path::Path;

impl StudyKind for ReductionStudy {
    const NAME: &'static str = "reduction";
    const ERRORS: &'static str = "The error of a reduced model is estimated from the forces of the full model that it leaves: at rest along adjoint solutions \
        [@becker2001], in time by the linearised motion that they cause in a richer space; the bar is that estimate times a factor from states, or from \
        whole runs in time, that took no part in the training. It is the distance from the full \
        model on the same mesh; the error of the mesh is that of a convergence study.";
    type Details = ReductionRecord;
    type Findings = ReductionFindings;

    fn expand(self, file: &Path, scene: &Path) -> Result<Expansion<ReductionRecord>, SceneError> {
        spec::expand(self, scene).map_err(|mistake| refuse(file, mistake))
    }

    fn derive(results: &Results, record: &ReductionRecord, dir: &Path) -> Result<Option<serde_json::Value>, String> {
        build::build(results, record, dir)
    }

    fn analyse(results: &Results, record: &ReductionRecord) -> Analysis<ReductionFindings> {
        analyse(results, record)
    }

    fn report(results: &Results, analysis: &Analysis<ReductionFindings>) -> Content {
        report::content(results, analysis)
    }
}
