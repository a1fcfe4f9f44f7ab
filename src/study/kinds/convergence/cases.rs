//! The stored cases of a convergence study, as its analysis reads them.

use crate::study::store::record::{CaseRecord, FamilyRecord, Role, StoredCase, StudyRecord};

/// The stored cases by family and variant.
pub struct Cases<'a> {
    pub study: &'a StudyRecord,
    pub stored: &'a [StoredCase],
    /// Time step of the mesh studies \[s\]
    pub dt_s: f64,
    pub shared: bool,
}

impl<'a> Cases<'a> {
    pub fn new(study: &'a StudyRecord, stored: &'a [StoredCase]) -> Self {
        let sizes = study.families.iter().find(|f| f.role == Role::Sizes).or(study.families.first());
        let of = |id: &String| stored.iter().find(|c| c.record.id == *id);
        let dt_s = sizes.and_then(|f| f.cases.iter().find_map(of)).map_or(f64::NAN, |c| c.record.dt_s);
        Self { study, stored, dt_s, shared: stored.iter().any(|c| c.record.shared) }
    }

    /// Converged cases of a family in a variant.
    pub fn of(&self, family: &FamilyRecord, variant: &str) -> Vec<&'a StoredCase> {
        (self.stored.iter())
            .filter(|c| c.record.converged() && c.record.variant == variant && family.cases.contains(&c.record.id))
            .collect()
    }

    /// Runs with the time step of the mesh studies.
    pub fn at_study_step(&self, c: &CaseRecord) -> bool {
        (c.dt_s / self.dt_s - 1.0).abs() < 1e-6
    }

    /// Cost of a case \[s\].
    pub fn cost(&self, c: &CaseRecord) -> f64 {
        if self.shared { c.cpu_s } else { c.wall_s }
    }
    /// Reason why the answer has no limit as h → 0, if a case names one.
    pub fn no_limit(&self) -> Option<&'a str> {
        self.stored.iter().find_map(|c| c.record.no_limit.as_deref())
    }
}
