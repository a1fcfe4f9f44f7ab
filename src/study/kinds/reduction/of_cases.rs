//! Whether the files and the mesh of a scene are those that its cases were computed with: with others their states are none of the scene.

use crate::scene::{Body, FileDigest, mesh_sha256};
use crate::study::kind::Underived;
use crate::study::store::record::StoredCase;
use std::collections::BTreeMap;
use std::path::Path;

/// Refuses files that are not those of the cases. Records of earlier versions that name none say nothing.
pub fn check_files(scene: &Path, cases: &[&StoredCase]) -> Result<(), Underived> {
    let base = scene.parent().unwrap_or(Path::new(""));
    let mut present: BTreeMap<&str, FileDigest> = BTreeMap::new();
    for case in cases {
        for of_case in &case.record.provenance.identity.files {
            let now = present.entry(&of_case.file).or_insert_with(|| FileDigest::of(base, of_case.file.clone()));
            if now != of_case {
                let is = if now.sha256.is_empty() { "cannot be read, and" } else { "has other contents now:" };
                return Err(Underived::NotAsComputed(format!(
                    "{}: the file {} {is} the states of case {} were computed with it; run the study again, or call `durometer report` where the file is as it was",
                    scene.display(),
                    of_case.file,
                    case.record.id
                )));
            }
        }
    }
    Ok(())
}

/// Refuses a mesh that is not that of the cases.
pub fn check_mesh(scene: &Path, body: &Body, cases: &[&StoredCase]) -> Result<(), Underived> {
    let now = mesh_sha256(body);
    let of_case = |case: &&StoredCase| case.record.provenance.identity.mesh_sha256.clone();
    match cases.iter().find(|case| !of_case(case).is_empty() && of_case(case) != now) {
        Some(case) => Err(Underived::NotAsComputed(format!(
            "{}: its mesh is not that of case {}, whose states have no meaning on it; run the study again",
            scene.display(),
            case.record.id
        ))),
        None => Ok(()),
    }
}
