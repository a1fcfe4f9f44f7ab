//! The cases of a study, with their stored results and expected costs.

use crate::mesh::generate::MeshStore;
use crate::scene::{self, Body, MadeMesh, MeshSpec, SceneError, mesh_sha256};
use crate::study::case::Case;
use crate::study::expand::Study;
use crate::study::forecast::{Expected, Forecast, Size};
use crate::study::run::task::Task;
use crate::study::run::waiting;
use crate::study::store::folder::Store;
use crate::study::store::identity::Identity;
use crate::study::store::record::{CaseRecord, OUT_OF_TIME};
use serde::Serialize;
use std::collections::{HashMap, HashSet};
use std::path::Path;

/// A case of a study, before it runs.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Listed {
    pub id: String,
    pub family: String,
    pub variant: String,
    pub member: String,
    pub state: State,
    /// SHA-256 of the scene, its files and its mesh; `None` if the mesh, or a constant that it waits for, does not exist yet
    pub identity: Option<String>,
    /// Variant for whose constants it waits
    #[serde(skip_serializing_if = "Option::is_none")]
    pub waits_for: Option<String>,
    /// Number of nodes of its mesh; `None` before the mesh exists
    pub nodes: Option<usize>,
    #[serde(flatten)]
    pub expected: Expected,
}

/// The stored result of a case.
#[derive(Serialize, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// Up to date: `run` keeps it
    Stored,
    /// Same inputs, but from another build of this program
    OtherBuild,
    /// Same inputs, but lacks something that the study requests now, or belongs to a search that ran out of time: `run` continues
    Partial,
    /// Other inputs
    Outdated,
    /// Its files differ from those that were stored
    Damaged,
    Missing,
    /// Unknown until the mesh has been made
    Unmeshed,
}

impl State {
    /// The name of the state in a list of cases.
    pub fn words(self) -> &'static str {
        match self {
            Self::Stored => "stored",
            Self::OtherBuild => "other build",
            Self::Partial => "partial",
            Self::Outdated => "outdated",
            Self::Damaged => "damaged",
            Self::Missing => "missing",
            Self::Unmeshed => "unmeshed",
        }
    }
}

/// Makes the meshes of all cases, each once. `progress` receives the id of a case and a line of the mesher.
pub fn prepare(study: &Study, progress: &mut dyn FnMut(&str, &str)) -> Result<(), SceneError> {
    let mut made = HashSet::new();
    for case in &study.cases {
        for (file, spec, _) in case.scenes()? {
            if !made.insert(key(file, &spec.mesh)) {
                continue;
            }
            let body = Body::load(file, &spec.mesh, &mut |line| progress(&case.id, line));
            if !study.rules.keep_refusals {
                body?;
            }
        }
    }
    Ok(())
}

/// Lists the meshes that are made for the cases, each once.
///
/// # Errors
///
/// A scene without a valid mesh, unless refusals are kept: then a bad mesh is a case.
pub fn made_meshes(study: &Study, store: &MeshStore) -> Result<Vec<MadeMesh>, SceneError> {
    let (mut seen, mut made) = (HashSet::new(), vec![]);
    for case in &study.cases {
        for (file, spec, _) in case.scenes()? {
            if seen.insert(key(file, &spec.mesh)) {
                match scene::made_meshes(file, &spec.mesh, store) {
                    Err(_) if study.rules.keep_refusals => {}
                    found => made.extend(found?),
                }
            }
        }
    }
    Ok(made)
}

fn key(file: &Path, mesh: &MeshSpec) -> String {
    format!("{:?}", (file, mesh))
}

/// Lists the cases, without making meshes or writing files.
pub fn list(study: &Study, dir: &Path) -> Vec<Listed> {
    let store = Store::at(dir);
    let meshes = MeshStore::find().ok().map(MeshStore::stored_only);
    let mut meshes = Meshes { store: meshes, known: HashMap::new() };
    let (mut forecast, mut found) = (Forecast::default(), vec![]);
    for case in &study.cases {
        let record = store.record(&case.id);
        let nodes = meshes.of(&case.scene_file, &case.spec.mesh).map(|(_, nodes)| nodes);
        let size = Size::of(&case.spec, nodes);
        record.iter().for_each(|r| forecast.learn(r, &size));
        let identity = waiting::identity(study, case, &store, &mut |case| meshes.of_case(case));
        let state = match state(&store, case, record.as_ref(), identity.as_ref()) {
            State::Stored | State::OtherBuild if record.as_ref().is_some_and(|r| lacks(study, case, r)) => {
                State::Partial
            }
            state => state,
        };
        found.push((state, identity, size));
    }
    let fitted = forecast.fitted();
    let listed = study.cases.iter().zip(found).map(|(case, (state, identity, size))| Listed {
        id: case.id.clone(),
        family: case.family.clone(),
        variant: case.variant.clone(),
        member: case.member.clone(),
        state,
        identity: identity.map(|i| i.sha256),
        waits_for: case.after.as_ref().map(|after| after.variant.clone()),
        nodes: size.nodes,
        expected: fitted.of(&case.id, &size),
    });
    listed.collect()
}

fn state(store: &Store, case: &Case, record: Option<&CaseRecord>, identity: Option<&Identity>) -> State {
    match (record, identity) {
        (None, _) if store.has(&case.id) => State::Damaged,
        (None, _) => State::Missing,
        (Some(r), None) if case.after.is_none() => {
            // On the meshes of the result, all other inputs must be the same
            let stored = &r.provenance.identity;
            let same = case.identity(&stored.meshes()) == *stored;
            if same { State::Unmeshed } else { State::Outdated }
        }
        (Some(_), None) => State::Outdated,
        (Some(r), Some(identity)) if r.provenance.counts_for(identity, false) => State::Stored,
        (Some(r), Some(identity)) if r.provenance.counts_for(identity, true) => State::OtherBuild,
        _ => State::Outdated,
    }
}

/// Whether a stored result lacks what the study requests, or belongs to an unfinished search. The requests of a case that waits for constants are not
/// known before these are.
fn lacks(study: &Study, case: &Case, record: &CaseRecord) -> bool {
    record.status == OUT_OF_TIME || case.after.is_none() && !record.has(&Task::of(study, case, false).asked())
}

/// The stored meshes of a study, each read once.
struct Meshes {
    store: Option<MeshStore>,
    /// Scene file and `[mesh]` → digest and nodes
    known: HashMap<String, Option<(String, usize)>>,
}

impl Meshes {
    fn of(&mut self, file: &Path, mesh: &MeshSpec) -> Option<(String, usize)> {
        let read = || {
            let body = Body::load_from(file, mesh, self.store.as_ref(), &mut |_| {}).ok()?;
            Some((mesh_sha256(&body), body.mesh.points.len()))
        };
        self.known.entry(key(file, mesh)).or_insert_with(read).clone()
    }

    /// Digests of the meshes of a case; `None` if one of them is not stored.
    fn of_case(&mut self, case: &Case) -> Option<Vec<String>> {
        case.scenes().ok()?.iter().map(|(file, spec, _)| Some(self.of(file, &spec.mesh)?.0)).collect()
    }
}
