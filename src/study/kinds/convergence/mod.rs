//! Convergence: which mesh can be trusted, with what error bar, at what cost.

pub mod analyse;
pub mod analysis;
pub mod cases;
pub mod errors;
pub mod figures;
pub mod report;
pub mod verdict;
pub mod warnings;

use crate::scene::SceneError;
use crate::study::analysis::Analysis;
use crate::study::content::Content;
use crate::study::kind::{Expansion, StudyKind};
use crate::study::record::Role;
use crate::study::results::Results;
use crate::study::spec::{FamilySpec, VariantSpec, check_quantities, check_roles, refuse};
use analyse::analyse;
use analysis::ConvergenceFindings;
use serde::Deserialize;
use std::path::Path;

/// Keys of a convergence study.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConvergenceStudy {
    #[serde(rename = "variant", default)]
    pub variants: Vec<VariantSpec>,
    #[serde(rename = "family", default)]
    pub families: Vec<FamilySpec>,
}

const ROLES: [Role; 6] = [Role::Sizes, Role::Nested, Role::Remeshed, Role::Seeds, Role::Element, Role::TimeStep];

impl StudyKind for ConvergenceStudy {
    const NAME: &'static str = "convergence";
    type Details = ();
    type Findings = ConvergenceFindings;

    fn expand(self, file: &Path) -> Result<Expansion<()>, SceneError> {
        let checked = check_quantities(&self.variants).and_then(|()| check_roles(Self::NAME, &self.families, &ROLES));
        checked.map_err(|mistake| refuse(file, mistake))?;
        Ok(Expansion::new(self.variants, self.families, ()))
    }

    fn analyse(results: &Results, (): &()) -> Analysis<ConvergenceFindings> {
        analyse(&results.study, &results.cases)
    }

    fn report(results: &Results, analysis: &Analysis<ConvergenceFindings>) -> Content {
        report::content(results, analysis)
    }
}
