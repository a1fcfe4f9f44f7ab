//! Cases that wait for the constants of a calibration, and the results that provide them.

use crate::scene::ParameterKey;
use crate::study::case::{After, Case};
use crate::study::expand::Study;
use crate::study::store::folder::Store;
use crate::study::store::identity::Identity;
use crate::study::store::record::{CaseRecord, Role};

/// Returns a waiting case with the constants of the finest converged mesh of its variant among these records.
pub fn ready(study: &Study, case: &Case, records: &[CaseRecord], store: &Store) -> Option<(Case, Vec<ParameterKey>)> {
    let after = case.after.as_ref()?;
    let found = |c: &'_ Case| records.iter().position(|r| r.id == c.id && r.converged());
    let own = sizes_of(study, after).filter_map(|c| Some((c, &records[found(c)?])));
    let (source, finest) = own.max_by_key(|(_, r)| r.mesh.cells)?;
    case.with_constants(source, &store.calibration(&finest.id)?)
}

/// A function that finds the digests of the meshes of a case, in the order of its scenes; it returns `None` if one of the meshes is missing.
pub type FindMeshes<'a> = dyn FnMut(&Case) -> Option<Vec<String>> + 'a;

/// The stored records from which a waiting case takes its constants; `None` if one of them is missing or no longer counts.
pub fn sources(
    study: &Study,
    case: &Case,
    (store, accept_build): (&Store, bool),
    meshes: &mut FindMeshes,
) -> Option<Vec<CaseRecord>> {
    let after = case.after.as_ref()?;
    let own = sizes_of(study, after);
    own.map(|c| {
        let identity = c.identity(&meshes(c)?);
        store.record(&c.id).filter(|r| r.provenance.counts_for(&identity, accept_build))
    })
    .collect()
}

/// The identity that the result of a case must have, whichever build computes it; `None` if it is not yet known.
pub fn identity(study: &Study, case: &Case, store: &Store, meshes: &mut FindMeshes) -> Option<Identity> {
    let of_case = meshes(case)?;
    match case.after {
        None => Some(case.identity(&of_case)),
        Some(_) => {
            let sources = sources(study, case, (store, true), meshes)?;
            let (case, _) = ready(study, case, &sources, store)?;
            Some(case.identity(&of_case))
        }
    }
}

/// The cases in the mesh-size families of the variant for which a case waits.
fn sizes_of<'a>(study: &'a Study, after: &'a After) -> impl Iterator<Item = &'a Case> {
    let is_size = |id: &String| study.record.families.iter().any(|f| f.role == Role::Sizes && f.cases.contains(id));
    study.cases.iter().filter(move |c| c.after.is_none() && c.variant == after.variant && is_size(&c.id))
}
