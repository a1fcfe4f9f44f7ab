//! Convergence: which mesh can be trusted, with what error bar, at what cost.
//!
//! `analysis` leads from the stored cases to the `findings`: the estimates of each family with their limitations ([`crate::study::estimate`]), the
//! `errors` of the cases against the reference, the `warnings`, and the recommendation or refusal in words (`verdict`), with the mesh that would help
//! (`next_mesh`).

pub mod analysis;
pub mod bars;
pub mod cases;
pub mod errors;
pub mod figures;
pub mod findings;
pub mod independent;
pub mod members;
pub mod next_mesh;
pub mod report;
pub mod verdict;
pub mod warnings;

use crate::scene::SceneError;
use crate::study::analysis::Analysis;
use crate::study::content::Content;
use crate::study::kind::{Expansion, RunRules, StudyKind};
use crate::study::spec::{FamilySpec, VariantSpec, check_members, check_quantities, refuse};
use crate::study::store::record::Role;
use crate::study::store::results::Results;
use analysis::analyse;
use findings::ConvergenceFindings;
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::Path;

/// Keys of a convergence study.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConvergenceStudy {
    /// Variants: ways of driving the scene, with the quantities judged there
    #[serde(rename = "variant", default)]
    pub variants: Vec<VariantSpec>,
    /// Families of cases that differ in one respect
    #[serde(rename = "family", default)]
    pub families: Vec<FamilySpec>,
    /// Whether the errors of every case are also estimated from its run alone
    #[serde(default)]
    pub error_estimates: bool,
}

/// Roles for which a single member says nothing; a single mesh of a size or an element is a setting to judge.
const COMPARED: [Role; 4] = [Role::Nested, Role::Remeshed, Role::Seeds, Role::TimeStep];

impl StudyKind for ConvergenceStudy {
    const NAME: &'static str = "convergence";
    type Details = ();
    type Findings = ConvergenceFindings;
    const ROLES: &'static [Role] =
        &[Role::Sizes, Role::Nested, Role::Remeshed, Role::Seeds, Role::Element, Role::Adaptive, Role::TimeStep];

    fn expand(self, file: &Path, _: &Path) -> Result<Expansion<()>, SceneError> {
        let checked = check_quantities(&self.variants).and_then(|()| check_members(&self.families, &COMPARED));
        checked.map_err(|mistake| refuse(file, mistake))?;
        let rules = RunRules { error_estimates: self.error_estimates, input_uncertainty: true, ..RunRules::default() };
        Ok(Expansion { rules, ..Expansion::new(self.variants, self.families, ()) })
    }

    fn analyse(results: &Results, (): &()) -> Analysis<ConvergenceFindings> {
        analyse(&results.study, &results.cases)
    }

    fn report(results: &Results, analysis: &Analysis<ConvergenceFindings>) -> Content {
        let errors = bars::errors(analysis);
        Content { errors, ..report::content(results, analysis) }
    }
}
