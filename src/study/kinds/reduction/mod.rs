//! Reduction: models of few unknowns made from runs of a scene, at rest or in time, with their cost and error.

pub mod analysis;
pub mod build;
mod constants;
pub mod figures;
mod in_scene;
mod in_time;
mod meshes;
mod of_cases;
pub mod path;
mod prepared;
pub mod record;
pub mod report;
mod runs;
mod search;
pub mod spec;
mod trained;
pub mod training;

use crate::scene::{SceneError, read_table};
use crate::study::analysis::Analysis;
use crate::study::content::Content;
use crate::study::kind::{Expansion, StudyKind, Underived};
use crate::study::rounds::Round;
use crate::study::spec::refuse;
use crate::study::store::results::Results;
use analysis::{ReductionFindings, analyse};
use record::ReductionRecord;
use spec::ReductionStudy;
use std::path::Path;

impl StudyKind for ReductionStudy {
    const NAME: &'static str = "reduction";
    type Details = ReductionRecord;
    type Findings = ReductionFindings;

    fn expand(self, file: &Path, scene: &Path) -> Result<Expansion<ReductionRecord>, SceneError> {
        // The tolerance is a key of all kinds of study
        let (_, common) = read_table(file)?;
        let tolerance = common.get("tolerance").and_then(toml::Value::as_str).unwrap_or_default();
        let mut expansion = spec::expand(self, tolerance, scene).map_err(|mistake| refuse(file, mistake))?;
        // The path is relative, so that the study is the same wherever it is run from
        let below = file.parent().and_then(|folder| scene.strip_prefix(folder).ok());
        expansion.details.scene = below.unwrap_or(scene).into();
        Ok(expansion)
    }

    fn derive(results: &Results, record: &ReductionRecord, dir: &Path) -> Result<Option<serde_json::Value>, Underived> {
        build::build(results, record, dir)
    }

    fn grow(results: &Results, record: &ReductionRecord, dir: &Path) -> Result<Option<Round>, String> {
        search::round(results, record, dir)
    }

    fn grows(record: &ReductionRecord) -> bool {
        record.greedy.is_some()
    }

    fn analyse(results: &Results, record: &ReductionRecord) -> Analysis<ReductionFindings> {
        analyse(results, record)
    }

    fn report(results: &Results, analysis: &Analysis<ReductionFindings>) -> Content {
        let errors = "The error of a reduced model is estimated from the forces of the full model that it leaves: at rest along adjoint solutions \
        [@becker2001], in time by the linearised motion that they cause in a richer space; the bar is that estimate times a factor from states, or from \
        whole runs in time, that took no part in the training. It is the distance from the full \
        model on the same mesh; the error of the mesh is that of a convergence study.";
        let errors = format!("{} {errors}", report::made_of(analysis));
        Content { errors, ..report::content(results, analysis) }
    }
}
