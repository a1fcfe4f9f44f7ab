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
use crate::study::record::Role;
use crate::study::results::Results;
use crate::study::spec::{FamilySpec, Mistake, VariantSpec, check_quantities, check_roles, refuse};
use analysis::analyse;
use findings::CostFindings;
use serde::Deserialize;
use std::path::Path;

/// Keys of a cost study.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CostStudy {
    #[serde(rename = "variant", default)]
    pub variants: Vec<VariantSpec>,
    #[serde(rename = "family", default)]
    pub families: Vec<FamilySpec>,
    /// Runs of every case, for the scatter of its cost
    #[serde(default = "once")]
    pub repeats: usize,
}

fn once() -> usize {
    1
}

const ROLES: [Role; 5] = [Role::Sizes, Role::Element, Role::TimeStep, Role::Solver, Role::Reference];

impl CostStudy {
    fn check(&self) -> Result<(), Mistake> {
        check_quantities(&self.variants)?;
        check_roles(Self::NAME, &self.families, &ROLES)?;
        if self.repeats == 0 {
            return Err(("repeats".into(), "no run at all".into(), "give 1 or more, for example 3".into()));
        }
        // One reference run does not tell its own error
        let alone = self.families.iter().find(|f| f.role == Role::Reference && f.members.len() < 2);
        alone.map_or(Ok(()), |f| {
            let remedy = "add a coarser member: their difference is what the error of the reference is estimated from";
            Err((format!("family {}", f.name), "a reference of one member".into(), remedy.into()))
        })
    }
}

impl StudyKind for CostStudy {
    const NAME: &'static str = "cost";
    type Details = ();
    type Findings = CostFindings;

    fn expand(self, file: &Path) -> Result<Expansion<()>, SceneError> {
        self.check().map_err(|mistake| refuse(file, mistake))?;
        let rules = RunRules { repeats: self.repeats, smallest_first: true, ..RunRules::default() };
        Ok(Expansion { rules, ..Expansion::new(self.variants, self.families, ()) })
    }

    fn analyse(results: &Results, (): &()) -> Analysis<CostFindings> {
        analyse(&results.study, &results.cases)
    }

    fn report(results: &Results, analysis: &Analysis<CostFindings>) -> Content {
        report::content(results, analysis)
    }
}
