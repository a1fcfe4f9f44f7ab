//! Cost: what accuracy costs, by mesh, element, time step and solver.

pub mod analysis;
pub mod figures;
pub mod findings;
pub mod line;
pub mod reference;
pub mod report;
pub mod sentence;

use crate::scene::SceneError;
use crate::study::analysis::Analysis;
use crate::study::content::Content;
use crate::study::kind::{Expansion, RunRules, StudyKind};
use crate::study::spec::{FamilySpec, Mistake, VariantSpec, check_members, check_quantities, refuse};
use crate::study::store::record::Role;
use crate::study::store::results::Results;
use analysis::analyse;
use findings::CostFindings;
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::Path;

/// Keys of a cost study.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CostStudy {
    /// Variants: ways of driving the scene, with the quantities judged there
    #[serde(rename = "variant", default)]
    pub variants: Vec<VariantSpec>,
    /// Families of cases that differ in one respect
    #[serde(rename = "family", default)]
    pub families: Vec<FamilySpec>,
    /// Number of runs of every case, to measure the scatter of its cost
    #[serde(default = "once")]
    pub repeats: usize,
    /// Whether the errors of every case are also estimated from its run alone
    #[serde(default)]
    pub error_estimates: bool,
}

fn once() -> usize {
    1
}

impl CostStudy {
    fn check(&self) -> Result<(), Mistake> {
        check_quantities(&self.variants)?;
        if self.repeats == 0 {
            return Err(("repeats".into(), "no run at all".into(), "give 1 or more, for example 3".into()));
        }
        check_members(&self.families, &[Role::Reference])
    }
}

impl StudyKind for CostStudy {
    const NAME: &'static str = "cost";
    type Details = ();
    type Findings = CostFindings;
    const ROLES: &'static [Role] =
        &[Role::Sizes, Role::Element, Role::Adaptive, Role::TimeStep, Role::Solver, Role::Reference];

    fn expand(self, file: &Path, _: &Path) -> Result<Expansion<()>, SceneError> {
        self.check().map_err(|mistake| refuse(file, mistake))?;
        let rules = RunRules {
            repeats: self.repeats,
            smallest_first: true,
            error_estimates: self.error_estimates,
            ..RunRules::default()
        };
        Ok(Expansion { rules, ..Expansion::new(self.variants, self.families, ()) })
    }

    fn analyse(results: &Results, (): &()) -> Analysis<CostFindings> {
        analyse(&results.study, &results.cases)
    }

    fn report(results: &Results, analysis: &Analysis<CostFindings>) -> Content {
        let errors = "The error of a setting is its distance from a reference on a finer mesh with smaller steps. An error bar is the error \
        and the uncertainty of the reference [@roache1994]."
            .into();
        Content { errors, ..report::content(results, analysis) }
    }
}
