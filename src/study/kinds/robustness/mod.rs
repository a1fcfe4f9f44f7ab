//! Robustness: scenes that are hard for simulators, and maps of where a scene can be solved.

pub mod analysis;
pub mod around;
pub mod check;
pub mod figures;
mod loads;
pub mod map;
pub mod record;
pub mod report;
pub mod spec;

use crate::scene::SceneError;
use crate::study::analysis::Analysis;
use crate::study::content::Content;
use crate::study::kind::{Around, Expansion, StudyKind};
use crate::study::spec::{VariantSpec, refuse};
use crate::study::store::results::Results;
use analysis::{RobustnessFindings, analyse};
use record::RobustnessRecord;
use schemars::JsonSchema;
use serde::Deserialize;
use spec::{MapSpec, SuiteSpec};
use std::path::Path;

/// Keys of a robustness study.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobustnessStudy {
    /// Variants: ways of driving the scene, with the quantities judged there
    #[serde(rename = "variant", default)]
    pub variants: Vec<VariantSpec>,
    /// Suites of scenes that are hard for simulators
    #[serde(rename = "suite", default)]
    pub suites: Vec<SuiteSpec>,
    /// Maps of where a scene can be solved
    #[serde(rename = "map", default)]
    pub maps: Vec<MapSpec>,
}

impl StudyKind for RobustnessStudy {
    const NAME: &'static str = "robustness";
    type Details = RobustnessRecord;
    type Findings = RobustnessFindings;
    const AROUND: Option<Around> = Some(around::AROUND);

    /// Keeps only the suites that are marked as quick.
    fn quick(mut self) -> Self {
        self.maps.clear();
        self.suites.retain(|suite| suite.quick);
        self
    }

    fn expand(self, file: &Path, scene: &Path) -> Result<Expansion<RobustnessRecord>, SceneError> {
        let mut maps = self.maps.iter();
        maps.try_for_each(|map| spec::check_map(map, &self.variants, (file, scene)))
            .and_then(|()| spec::expand(self.variants, &self.suites, &self.maps))
            .map_err(|mistake| refuse(file, mistake))
    }

    fn analyse(results: &Results, robustness: &RobustnessRecord) -> Analysis<RobustnessFindings> {
        analyse(&results.study, robustness, &results.cases)
    }

    fn report(results: &Results, analysis: &Analysis<RobustnessFindings>) -> Content {
        let errors = "A run that converges matches its references, or has none and is not judged; one that stops with a stated reason does so as \
        demanded or as is accepted; all others fail. A reference is a known solution or another run of the program, as is stated with each; the error \
        of a case is that from its reference. Points of maps are compared with the reference of their row."
            .into();
        Content { errors, ..report::content(results, analysis) }
    }
}
