//! Cases that wait for the constants of a calibration, and the results that give them.

use crate::scene::{Body, ParameterKey};
use crate::study::case::Case;
use crate::study::expand::Study;
use crate::study::store::folder::Store;
use crate::study::store::record::{CaseRecord, Role};

/// A case that waited, with the constants of the finest converged mesh of its variant among these records.
pub fn ready(study: &Study, case: &Case, records: &[CaseRecord], store: &Store) -> Option<(Case, Vec<ParameterKey>)> {
    let after = case.after.as_ref()?;
    let own = records.iter().filter(|r| r.variant == after.variant && r.converged() && is_size(study, &r.id));
    let finest = own.max_by_key(|r| r.mesh.cells)?;
    let source = study.cases.iter().find(|c| c.id == finest.id)?;
    case.with_constants(source, &store.calibration(&finest.id)?)
}

/// The stored records that a waiting case takes its constants from; `None` where one of them is missing or no longer counts.
pub fn sources(study: &Study, case: &Case, store: &Store, accept_build: bool) -> Option<Vec<CaseRecord>> {
    let after = case.after.as_ref()?;
    let own = study.cases.iter().filter(|c| c.after.is_none() && c.variant == after.variant && is_size(study, &c.id));
    own.map(|c| {
        let body = Body::load(&c.scene_file, &c.spec.mesh, &mut |_| {}).ok()?;
        let identity = c.identity(Some(&body));
        store.record(&c.id).filter(|r| r.provenance.counts_for(&identity, accept_build))
    })
    .collect()
}

fn is_size(study: &Study, id: &String) -> bool {
    study.record.families.iter().any(|f| f.role == Role::Sizes && f.cases.contains(id))
}
