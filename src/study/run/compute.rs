//! Computes one case and stores its result. A bug that ends the computation is the status of this case only.

use crate::calibrate::inverse::Calibration;
use crate::live::Access;
use crate::math::stopwatch::Spent;
use crate::report::viewer::film::Film;
use crate::report::viewer::page;
use crate::report::viewer::shape::Limits;
use crate::scene::{Body, ErrorEstimator, OnProgress, Progress, Run, Scene, SceneSpec, Sensitivities};
use crate::solve::Status;
use crate::storage::reading::Reading;
use crate::storage::unix_time;
use crate::study::run::derivatives::recorder;
use crate::study::run::live_case::LiveCase;
use crate::study::run::one_run::{OneRunRecord, one_run};
use crate::study::run::refinement::{self, Prepared, RefinementRecord, refined};
use crate::study::run::search::{SearchFollow, Searched, doubt, find, unfinished};
use crate::study::run::task::Task;
use crate::study::run::uncertain_constants::{inputs, uncertain_constants};
use crate::study::run::work::{
    RepeatRecord, RunFollow, Timed, largest_memory, measure, measure_with, present_memory, watch_memory,
};
use crate::study::store::field_folder::LAST;
use crate::study::store::fields::{Fields, USUAL};
use crate::study::store::finished_run::{record, refused, skin};
use crate::study::store::folder::{CaseOutput, Store};
use crate::study::store::identity::Identity;
use crate::study::store::record::{CaseRecord, INPUTS_CHANGED, PANICKED, REFUSED};
use crate::study::store::states::KeptStates;
use crate::study::view;
use crate::system::State;
use std::cell::Cell;
use std::sync::Arc;
use std::time::Instant;

pub use crate::study::run::error::CaseError;

/// Follows the computation of a case.
pub struct Follow<'a> {
    /// Receives each line of the mesher
    pub meshing: &'a mut dyn FnMut(&str),
    /// Returns false to stop the computation
    pub progress: &'a mut dyn FnMut(Progress) -> bool,
    /// Whether another case is running at the moment
    pub shared: &'a dyn Fn() -> bool,
    /// Receives the memory that the case is going to need \[bytes\], waits until it is available, and returns false to stop
    pub admit: &'a mut dyn FnMut(u64) -> bool,
    /// Access for a live view of the run, and the receiver of its port
    pub live: Option<(&'a Access, &'a mut dyn FnMut(u16))>,
    /// Whether this process computes only this case, so that its memory is that of the case
    pub own_process: bool,
}

/// Computes a case and stores its result. `None` if it was stopped; nothing is left then.
pub fn compute(task: &Task, store: &Store, follow: &mut Follow) -> Result<Option<CaseRecord>, CaseError> {
    let mut meshes = vec![];
    let computed = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| run(task, store, follow, &mut meshes)));
    let mut record = match computed {
        Ok(Err(why @ CaseError::Changed { .. })) => refused(&task.case, INPUTS_CHANGED, why.to_string()),
        Ok(Err(CaseError::Scene(why))) if task.keep_refusals => {
            let mut record = refused(&task.case, REFUSED, why.to_string());
            record.provenance.identity = task.case.identity(&meshes);
            record
        }
        Ok(computed) => return computed,
        Err(why) => {
            let words = why.downcast_ref::<String>().map(String::as_str).or(why.downcast_ref::<&str>().copied());
            let words = words.unwrap_or("no reason is known");
            let detail = format!("{words}; this is a bug of the program, please report it with the scene");
            refused(&task.case, PANICKED, detail)
        }
    };
    store.save_refused(&mut record)?;
    Ok(Some(record))
}

/// Runs the case; `meshes` receives the digests of its meshes, which a scene that is refused may have too.
fn run(
    task: &Task,
    store: &Store,
    follow: &mut Follow,
    meshes: &mut Vec<String>,
) -> Result<Option<CaseRecord>, CaseError> {
    let case = &task.case;
    let reading = Reading::begin();
    let bodies = case.bodies(follow.meshing)?;
    *meshes = bodies.sha256();
    let identity = case.identity(meshes);
    check_files(task, &reading)?;
    let mut fields = match task.vtu {
        true => Some(Fields::new(store.begin_fields(&case.id)?, &case.id, &USUAL)),
        false => None,
    };
    let started_unix_s = unix_time().as_secs();
    let Follow { meshing, progress, shared, admit, live, own_process } = follow;
    let own_process = *own_process;
    let (is_shared, stopped) = (Cell::new(shared()), Cell::new(false));
    let watched = if own_process { Some(()) } else { watch_memory().filter(|()| !is_shared.get()) };
    let expected_memory = Cell::new(None);
    let mut open =
        |scene: &Scene| live.as_mut().and_then(|(access, serves)| LiveCase::open(access, &case.id, scene, *serves));
    let mut sized = |bytes: u64| {
        // With several runs, only the first one asks
        let Some(present) = present_memory().filter(|_| own_process && expected_memory.get().is_none()) else {
            return true;
        };
        expected_memory.set(Some(present + bytes));
        admit(present + bytes)
    };
    let mut go_on = |now| {
        is_shared.set(is_shared.get() | shared());
        stopped.set(stopped.get() | !progress(now));
        !stopped.get()
    };
    let prepared = match refined((&case.scene_file, &case.spec, &case.text), Arc::new(bodies.own), *meshing, &mut go_on)
    {
        Ok(prepared) => prepared,
        Err(_) if stopped.get() => return Ok(None),
        Err(why) => return Err(CaseError::Refine { case: case.id.clone(), why: why.into() }),
    };
    let from = unfinished(store, &case.id, &identity);
    // A full disk loses the saved values, not the search
    let mut keep = |values: &[f64]| drop(store.keep_search(&case.id, &identity, values));
    let searching = SearchFollow { from: from.as_deref(), keep: &mut keep, go_on: &mut go_on };
    let Some(searched) = find(case, (&prepared.body, bodies.curves), searching)? else { return Ok(None) };
    let hooks = Hooks { fields: fields.as_mut(), go_on: &mut go_on, sized: &mut sized, open: &mut open };
    let mut computed = solve(task, prepared, searched, hooks)?;
    check_files(task, &reading)?;
    is_shared.set(is_shared.get() | shared());
    let memory = watched.filter(|()| own_process || !is_shared.get()).and_then(|()| largest_memory());
    let solved = &mut computed.solved;
    if matches!(solved.run.status, Status::Interrupted { .. }) && solved.run.failure.is_none() {
        return Ok(None);
    }
    write_fields(task, store, fields, solved, &identity)?;
    let (is_shared, expected_memory) = (is_shared.get(), expected_memory.get());
    let circumstances = Circumstances { is_shared, memory, expected_memory, identity, started_unix_s };
    store_result(task, store, computed, circumstances).map(Some)
}

/// Completes the fields of a case, and writes those of its last state if not reaching the end is a result.
fn write_fields(
    task: &Task,
    store: &Store,
    fields: Option<Fields>,
    solved: &Solved,
    identity: &Identity,
) -> Result<(), CaseError> {
    let id = &task.case.id;
    let mut folder = match fields {
        Some(fields) => {
            let folder = fields.folder().to_path_buf();
            fields.finish()?;
            Some(folder)
        }
        None => None,
    };
    if task.keep_refusals && solved.run.status != Status::Converged {
        let into = folder.map_or_else(|| store.begin_fields(id), Ok)?;
        let mut last = Fields::new(&into, LAST, &USUAL);
        last.add(&solved.scene, &solved.run.last, 0);
        last.finish()?;
        folder = Some(into);
    }
    match folder {
        Some(_) => Ok(store.end_fields(id, identity)?),
        None => Ok(()),
    }
}

/// Refuses a case if one of its files was edited after the run of the study began, even if the edit has been undone since.
fn check_files(task: &Task, reading: &Reading) -> Result<(), CaseError> {
    let changed = reading.changed(&task.files);
    match changed.is_empty() {
        true => Ok(()),
        false => Err(CaseError::Changed { files: changed.iter().map(|path| path.display().to_string()).collect() }),
    }
}

/// A case after its run.
struct Solved {
    scene: Scene,
    run: Run,
    /// Constants found before the run
    found: Option<Calibration>,
    /// Why a search for them could not start
    unsearched: Option<String>,
    /// Adaptive meshes; the last one is that of the run
    refinement: Vec<RefinementRecord>,
    sensitivities: Option<Sensitivities>,
    one_run: Option<OneRunRecord>,
    /// The states, if the study keeps them
    states: Option<KeptStates>,
    /// Facts about the result that its numbers do not show
    notes: Vec<String>,
    build_s: f64,
    /// Time of the run and of the adaptive meshes before it
    spent: Spent,
    /// Times of every run, if there are several
    repeats: Vec<RepeatRecord>,
}

/// A case after its run, with its motion if the scene records fields.
struct Computed {
    solved: Solved,
    film: Option<Film>,
}

/// The circumstances under which a case was computed.
struct Circumstances {
    /// Whether another case ran at the same time
    is_shared: bool,
    /// Largest resident set of the process \[bytes\]
    memory: Option<u64>,
    /// Resident set expected before the first factorisation \[bytes\]
    expected_memory: Option<u64>,
    identity: Identity,
    started_unix_s: u64,
}

/// Callbacks during the run of a case.
struct Hooks<'a, 'b> {
    /// Receives the states for ParaView
    fields: Option<&'a mut Fields>,
    /// Returns false to stop the run
    go_on: &'a mut OnProgress<'b>,
    /// Receives the memory that the factorisation needs \[bytes\], before the first one, and returns false to stop
    sized: &'a mut dyn FnMut(u64) -> bool,
    /// Opens a live view of the scene, if one is requested
    open: &'a mut dyn FnMut(&Scene) -> Option<LiveCase>,
}

/// Runs the scene of a case after the search for its constants.
fn solve(task: &Task, prepared: Prepared, searched: Searched, hooks: Hooks) -> Result<Computed, CaseError> {
    let Prepared { body, refinement } = prepared;
    let Searched { found, unsearched, spec } = searched;
    let Hooks { mut fields, go_on, sized, open } = hooks;
    let (scene, build_s) = built(task, spec, body)?;
    let mut estimator = task.estimates_errors.then(|| ErrorEstimator::new(&scene));
    let mut live = open(&scene);
    let board = live.as_ref().map(|live| live.board().clone());
    let recorded = scene.spec.output.fields.as_ref();
    let mut film = recorded.map(|fields| Film::new(&scene, &fields.what, &Limits::USUAL));
    let mut kept = task.keep_states.then(KeptStates::default);
    let mut number = 0..;
    let mut states = |state: &State| {
        if let Some(Ok(estimator)) = &mut estimator {
            estimator.add(state);
        }
        if let Some(fields) = &mut fields {
            fields.add(&scene, state, number.next().expect("there is always a next number"));
        }
        film.iter_mut().for_each(|film| film.add(&scene, state));
        kept.iter_mut().for_each(|kept| kept.add(state));
        live.iter_mut().for_each(|live| live.add(&scene, state));
    };
    let mut notes = vec![];
    let follow = RunFollow { go_on, states: &mut states, board: board.as_ref(), sized };
    let (timed, sensitivities, repeats) = match recorder(&scene, task, &mut notes)? {
        Some(recorder) => {
            let (timed, sensitivities) = measure_with(&scene, recorder, follow);
            (timed, Some(sensitivities), vec![])
        }
        None => {
            let (timed, all) = measure(&scene, task.repeats, follow);
            (timed, None, all)
        }
    };
    let Timed { run, spent } = timed;
    live.into_iter().for_each(|live| live.end(&run));
    let one_run = estimator.map(|estimator| one_run(estimator, &run, &task.columns));
    let solved = Solved {
        spent: refinement.iter().fold(spent, |spent, mesh| spent + mesh.spent()),
        scene,
        run,
        found,
        unsearched,
        refinement,
        sensitivities,
        one_run,
        states: kept,
        notes,
        build_s,
        repeats: if task.repeats > 1 { repeats } else { vec![] },
    };
    Ok(Computed { solved, film })
}

/// Builds the scene of a case, checks it against the requests of its study, and returns the time of its construction \[s\].
fn built(task: &Task, spec: SceneSpec, body: Arc<Body>) -> Result<(Scene, f64), CaseError> {
    let building = Instant::now();
    let scene = Scene::build(&task.case.scene_file, spec, task.case.text.clone(), body)?;
    let build_s = building.elapsed().as_secs_f64();
    task.check(&scene)?;
    Ok((scene, build_s))
}

/// Stores the result of a case; the record is written last.
fn store_result(
    task: &Task,
    store: &Store,
    computed: Computed,
    circumstances: Circumstances,
) -> Result<CaseRecord, CaseError> {
    let (case, Computed { solved, film }) = (&task.case, computed);
    let Circumstances { is_shared, memory, expected_memory, identity, started_unix_s } = circumstances;
    let Solved { scene, run, .. } = &solved;
    let writing = Instant::now();
    let skin = skin(scene, run);
    let mut record = record(scene, run, solved.spent);
    record.id.clone_from(&case.id);
    record.family.clone_from(&case.family);
    record.variant.clone_from(&case.variant);
    record.member.clone_from(&case.member);
    record.shared = is_shared;
    (record.provenance.identity, record.provenance.started_unix_s) = (identity, started_unix_s);
    record.provenance.asked = Some(task.asked());
    record.one_run.clone_from(&solved.one_run);
    record.refinement.clone_from(&solved.refinement);
    record.notes.extend(refinement::note(&solved.refinement));
    record.notes.extend(solved.notes.iter().cloned());
    if let Some(sensitivities) = &solved.sensitivities {
        let known = uncertain_constants(&case.spec);
        record.inputs = if case.after.is_none() { inputs(&known, run, sensitivities) } else { vec![] };
    }
    let doubt = doubt(&case.id, solved.found.as_ref(), solved.unsearched.as_deref());
    if let Some((status, detail)) = doubt.filter(|_| record.converged()) {
        (record.status, record.status_detail) = (status.into(), Some(detail));
    }
    record.phases.build_s = solved.build_s;
    (record.work.memory_bytes, record.work.expected_bytes) = (memory, expected_memory);
    record.repeats.clone_from(&solved.repeats);
    record.phases.output_s = writing.elapsed().as_secs_f64();
    let (sensitivities, calibration) = (solved.sensitivities.as_ref(), solved.found.as_ref());
    let page = film.map(|film| {
        let about = view::about_case(run, &record);
        page::page(&record.id, &[film.finish(scene, about)])
    });
    let states = solved.states.as_ref();
    let output = CaseOutput { run, skin: &skin, sensitivities, calibration, page: page.as_deref(), states };
    store.save(&mut record, &output)?;
    Ok(record)
}
