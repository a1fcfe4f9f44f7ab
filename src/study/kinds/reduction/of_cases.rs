//! Checks that the files and the mesh of a scene are those that its cases were computed with; otherwise the states do not belong to the scene.

use crate::scene::{Body, FileDigest, mesh_sha256, simulated_files};
use crate::study::kind::Underived;
use crate::study::store::record::StoredCase;
use std::path::Path;

/// Refuses a scene whose files differ from those of the cases; files that no state depends on are ignored. Records of earlier versions that list no
/// files are accepted.
pub fn check_files(scene: &Path, cases: &[&StoredCase]) -> Result<(), Underived> {
    // Apart from the inputs, all cases have the same scene
    let present = cases.first().map_or_else(Vec::new, |case| simulated_files(scene, &case.record.provenance.scene));
    for case in cases {
        for of_case in &case.record.provenance.identity.files {
            let is_other = |now: &&FileDigest| now.file == of_case.file && *now != of_case;
            if let Some(now) = present.iter().find(is_other) {
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

/// Refuses a mesh that differs from that of the cases.
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
