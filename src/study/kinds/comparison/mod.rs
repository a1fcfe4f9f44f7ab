//! Comparison: members against a reference, or effects added one by one.

pub mod analysis;
pub mod figures;
pub mod findings;
pub mod finer;
pub mod report;
pub mod samples;
pub mod sequence;

use crate::scene::{SceneError, hint};
use crate::study::analysis::Analysis;
use crate::study::content::Content;
use crate::study::kind::{Expansion, StudyKind};
use crate::study::spec::{FamilySpec, Mistake, VariantSpec, check_quantities, refuse};
use crate::study::store::record::Role;
use crate::study::store::results::Results;
use analysis::analyse;
use findings::{ComparisonFindings, ComparisonRecord};
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::Path;

/// Keys of a comparison.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComparisonStudy {
    /// Variants: ways of driving the scene, with the quantities judged there
    #[serde(rename = "variant", default)]
    pub variants: Vec<VariantSpec>,
    /// Families of cases that differ in one respect
    #[serde(rename = "family", default)]
    pub families: Vec<FamilySpec>,
    /// The member that the others are compared with
    pub reference: Option<String>,
}

impl ComparisonStudy {
    fn check(&self) -> Result<(), Mistake> {
        check_quantities(&self.variants)?;
        let adds_up = |f: &&FamilySpec| f.role == Role::Cumulative;
        let on = |f: &FamilySpec, v: &VariantSpec| f.variants.as_ref().is_none_or(|own| own.contains(&v.name));
        let twice =
            self.variants.iter().find(|v| self.families.iter().filter(adds_up).filter(|f| on(f, v)).count() > 1);
        if let Some(v) = twice {
            let remedy = "a variant has one cumulative family: give each family its `variants`";
            return Err((format!("variant {}", v.name), "two families are run in it".into(), remedy.into()));
        }
        if !self.families.is_empty() && self.families.iter().all(|f| adds_up(&f)) {
            let Some(_) = self.reference else { return Ok(()) };
            let fact = "a cumulative family compares each member with the one before it".into();
            return Err(("reference".into(), fact, "remove the key".into()));
        }
        self.check_reference()
    }

    fn check_reference(&self) -> Result<(), Mistake> {
        let members: Vec<&FamilySpec> = self.families.iter().filter(|f| f.role == Role::Members).collect();
        let [family] = members[..] else {
            let fact = format!("{} families have the role \"members\"", members.len());
            return Err(("family".into(), fact, "give it to one; a finer mesh has the role \"finer\"".into()));
        };
        let members: Vec<String> = family.members.keys().cloned().collect();
        match &self.reference {
            Some(r) if members.contains(r) => Ok(()),
            Some(r) => Err(("reference".into(), format!("no member is called \"{r}\""), hint(r, &members))),
            None => {
                let remedy = format!("name the member that the others are compared with: {}", members.join(", "));
                Err(("reference".into(), "it is missing".into(), remedy))
            }
        }
    }
}

impl StudyKind for ComparisonStudy {
    const NAME: &'static str = "comparison";
    type Details = ComparisonRecord;
    type Findings = ComparisonFindings;
    const ROLES: &'static [Role] = &[Role::Members, Role::Finer, Role::Cumulative];

    fn expand(self, file: &Path, _: &Path) -> Result<Expansion<ComparisonRecord>, SceneError> {
        self.check().map_err(|mistake| refuse(file, mistake))?;
        let details = ComparisonRecord { reference: self.reference.unwrap_or_default() };
        Ok(Expansion::new(self.variants, self.families, details))
    }

    fn analyse(results: &Results, comparison: &ComparisonRecord) -> Analysis<ComparisonFindings> {
        analyse(&results.study, comparison, &results.cases)
    }

    fn report(results: &Results, analysis: &Analysis<ComparisonFindings>) -> Content {
        let errors = finer::errors(&results.study, analysis);
        Content { errors, ..report::content(results, analysis) }
    }
}
