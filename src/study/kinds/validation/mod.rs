//! Validation: constants from measured records, predictions of other records with an error budget, and a score if these are measured too.
//!
//! | Step | File |
//! |---|---|
//! | Keys of the study, its plan, its cases | [`spec`], [`plan`], [`expansion`], [`constants`], [`quantities`], [`design`] |
//! | Measured values | [`measured`], [`tracks`], [`tracks_request`], [`field`], [`scatter`] |
//! | A number from a run, with derivatives | [`evaluate`] |
//! | Runs of a design as a function | [`surface`], [`responses`] |
//! | Constants and predictions with all their sources of error | [`joint`], [`consistency`], [`monte_carlo`], [`budget`] |
//! | Error of mesh, time steps and surface | [`numerical`] |
//! | Constants and predictions with every part of their errors | [`outcomes`] |
//! | Findings, verdict, page, files | [`analysis`], [`findings`], [`words`], [`report`], [`figures`], [`predictions`] |

pub mod analysis;
pub mod budget;
pub mod consistency;
pub mod constants;
pub mod design;
pub mod evaluate;
pub mod expansion;
pub mod field;
pub mod figures;
pub mod findings;
pub mod joint;
pub mod law_files;
pub mod measured;
mod methods;
pub mod monte_carlo;
pub mod numerical;
pub mod outcomes;
pub mod plan;
pub mod predictions;
pub mod quantities;
pub mod report;
pub mod responses;
pub mod scatter;
pub mod spec;
pub mod surface;
pub mod tracks;
pub mod tracks_request;
pub mod words;

use crate::scene::SceneError;
use crate::study::analysis::Analysis;
use crate::study::content::Content;
use crate::study::kind::{Expansion, StudyKind};
use crate::study::store::record::Role;
use crate::study::store::results::Results;
use analysis::analyse;
use findings::ValidationFindings;
use plan::ValidationPlan;
pub use spec::ValidationStudy;
use std::path::Path;

impl StudyKind for ValidationStudy {
    const NAME: &'static str = "validation";
    type Details = ValidationPlan;
    type Findings = ValidationFindings;
    const ROLES: &'static [Role] = &[Role::Sizes, Role::Nested, Role::Remeshed, Role::TimeStep];

    fn expand(self, file: &Path, scene: &Path) -> Result<Expansion<ValidationPlan>, SceneError> {
        expansion::expand(&self, file, scene)
    }

    fn analyse(results: &Results, plan: &ValidationPlan) -> Analysis<ValidationFindings> {
        analyse(results, plan)
    }

    fn report(results: &Results, analysis: &Analysis<ValidationFindings>) -> Content {
        let errors = "The uncertainty of a prediction contains discretisation, time steps, the constants with their covariance and the inputs \
        of the experiment, propagated by response surfaces with derivatives [@box1951; @asme2009]. It is compared with the \
        uncertainty of the measurement [@jcgm2008]; inputs that several records share are in the covariance of the data \
        [@kennedy2001]."
            .into();
        Content { errors, ..report::content(results, analysis) }
    }
}
