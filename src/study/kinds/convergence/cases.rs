//! The stored cases of a convergence study, as its analysis reads them.

use crate::scene::SceneSpec;
use crate::study::estimate::step_size::has_steps_of;
use crate::study::run::uncertain_constants::{bounded_constants, undetermined_constants};
use crate::study::store::record::{CaseRecord, FamilyRecord, Role, StoredCase, StudyRecord};
use crate::wording::distinct;
use std::collections::BTreeMap;
use std::path::Path;

/// The stored cases by family and variant.
pub struct Cases<'a> {
    pub study: &'a StudyRecord,
    pub stored: &'a [StoredCase],
    /// A run with the time steps of the mesh studies, by variant
    steps: BTreeMap<&'a str, &'a CaseRecord>,
    /// Constants of the laws, from the scenes of the cases, by variant
    constants: BTreeMap<&'a str, Constants>,
}

/// Constants of laws that are not known exactly.
pub struct Constants {
    /// Constants whose interval is open
    pub undetermined: Vec<String>,
    /// Constants whose interval has two ends
    pub bounded: Vec<String>,
}

impl<'a> Cases<'a> {
    pub fn new(study: &'a StudyRecord, stored: &'a [StoredCase]) -> Self {
        let steps = study.variants.iter().filter_map(|v| Some((v.as_str(), with_steps_of_study(study, stored, v)?)));
        let steps = steps.collect();
        let cases = Self { study, stored, steps, constants: BTreeMap::new() };
        let constants = study.variants.iter().map(|v| (v.as_str(), Constants::of(cases.of_variant(v)))).collect();
        Self { constants, ..cases }
    }

    /// Returns the converged cases of a family in a variant.
    pub fn of(&self, family: &FamilyRecord, variant: &str) -> Vec<&'a StoredCase> {
        self.stored.iter().filter(|c| c.record.converged() && c.is_in(&family.name, variant)).collect()
    }

    /// Returns the converged cases of a variant.
    pub fn of_variant(&self, variant: &str) -> impl Iterator<Item = &'a StoredCase> {
        self.stored.iter().filter(move |c| c.record.converged() && c.is_of(variant))
    }

    /// Whether a case has the time steps of the mesh studies of a variant.
    pub fn at_study_step(&self, variant: &str, c: &CaseRecord) -> bool {
        self.steps.get(variant).is_some_and(|of| has_steps_of(c, of))
    }

    /// Returns the constants of the laws of a variant that are not known exactly.
    pub fn constants(&self, variant: &str) -> Option<&Constants> {
        self.constants.get(variant)
    }

    /// Returns the reason why the answer has no limit as h → 0, if a case states one.
    pub fn no_limit(&self) -> Option<&'a str> {
        self.stored.iter().find_map(|c| c.record.no_limit.as_deref())
    }
}

impl Constants {
    /// Collects the constants of some cases, except cases whose scene this version cannot read.
    fn of<'a>(cases: impl Iterator<Item = &'a StoredCase>) -> Self {
        let spec = |c: &StoredCase| SceneSpec::from_text(Path::new(&c.record.id), &c.record.provenance.scene, "").ok();
        let specs: Vec<SceneSpec> = cases.filter_map(spec).collect();
        let of_all = |of: fn(&SceneSpec) -> Vec<String>| distinct(specs.iter().flat_map(of));
        Self { undetermined: of_all(undetermined_constants), bounded: of_all(bounded_constants) }
    }
}

/// The first case of the family of sizes in a variant; if there is none, of another family, with families of time steps last.
fn with_steps_of_study<'a>(study: &'a StudyRecord, stored: &'a [StoredCase], variant: &str) -> Option<&'a CaseRecord> {
    let rank = |role: Role| match role {
        Role::Sizes => 0,
        Role::TimeStep => 2,
        _ => 1,
    };
    let mut families: Vec<&FamilyRecord> = study.families.iter().collect();
    families.sort_by_key(|f| rank(f.role));
    families.into_iter().find_map(|f| Some(&stored.iter().find(|c| c.is_in(&f.name, variant))?.record))
}
