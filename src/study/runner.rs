//! Runs the cases of a study side by side, skips what is done, keeps what is finished.

use crate::calibrate::inverse::{Calibration, Failure, InverseError, SceneModel, calibrate};
use crate::scene::{
    Body, Constant, ErrorEstimator, Progress, RefineError, Run, RunOptions, Scene, SceneError, SceneSpec,
    Sensitivities, SensitivityRecorder,
};
use crate::solve::Status;
use crate::study::case::Case;
use crate::study::expand::Study;
use crate::study::fields::{Fields, USUAL};
use crate::study::identity::Identity;
use crate::study::inputs::{inputs, uncertain_constants};
use crate::study::one_run::{OneRunRecord, one_run};
use crate::study::only::Only;
use crate::study::outcome::{record, refused, skin};
use crate::study::record::{CaseRecord, PANICKED, REFUSED};
use crate::study::refinement::{self, RefinementRecord, refined};
use crate::study::store::{Store, StoreError};
use crate::study::waiting;
use crate::study::work::{RepeatRecord, largest_memory, measure, watch_memory};
use crate::system::State;
use cpu_time::ThreadTime;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// Follows the run of a study; what it does not implement is ignored.
pub trait Watch: Sync {
    /// A line of the mesher about the mesh of a case.
    fn meshing(&self, _case: &str, _line: &str) {}
    fn started(&self, _case: &str) {}
    fn progress(&self, _case: &str, _progress: Progress) {}
    fn finished(&self, _record: &CaseRecord, _skipped: bool) {}
}

/// Why a study stopped; results that were finished before stay.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Fields(#[from] crate::mesh::error::MeshError),
    #[error(transparent)]
    Inverse(#[from] InverseError),
    #[error("case {case}: {why}")]
    Refine { case: String, why: Box<RefineError> },
    #[error("no case is called like \"{only}\"; the cases are: {known}")]
    NoSuchCase { only: String, known: String },
    #[error("{}: the signal {signal} waits for a controller, and a study has none; drive it by a signal", file.display())]
    Controlled { file: PathBuf, signal: String },
    #[error("{}: variant {variant}: {fact}", file.display())]
    Quantity { file: PathBuf, variant: String, fact: String },
}

/// How to run.
pub struct Options<'a> {
    pub jobs: usize,
    /// Run also what is done
    pub redo: bool,
    /// Keep results that another build of this program computed from the same inputs
    pub accept_build: bool,
    /// Only these cases
    pub only: Option<Only>,
    /// Write the fields of every case into `cases/<id>/`; a finished case without them is run again
    pub vtu: bool,
    /// Set to stop: running cases are dropped, finished ones kept
    pub stop: &'a AtomicBool,
}

impl Options<'_> {
    /// Whether this case is to be run (or kept).
    pub fn wants(&self, id: &str) -> bool {
        self.only.as_ref().is_none_or(|only| only.takes(id))
    }
}

/// Runs a study into `dir`. Returns the records of all wanted cases that have one; an interrupted case has none.
pub fn run(study: &Study, dir: &Path, options: &Options, watch: &dyn Watch) -> Result<Vec<CaseRecord>, RunError> {
    let cases: Vec<&Case> = study.cases.iter().filter(|c| options.wants(&c.id)).collect();
    if let (true, Some(Only::Containing(only))) = (cases.is_empty(), &options.only) {
        let known = study.cases.iter().map(|c| c.id.as_str()).collect::<Vec<_>>().join(", ");
        return Err(RunError::NoSuchCase { only: only.clone(), known });
    }
    let is_part = options.only.as_ref().is_some_and(Only::is_part);
    let store = Store::create(dir, &study.record)?;
    // A case that waits has its scene later, and a case that is to be run is looked at then
    let is_other = |c: &&Case| !is_part && c.after.is_none() && !options.wants(&c.id) && store.has(&c.id);
    let others = study.cases.iter().filter(is_other);
    for case in others {
        let body = Body::load(&case.scene_file, &case.spec.mesh, &mut |line| watch.meshing(&case.id, line)).ok();
        store.forget_outdated(&case.id, &case.identity(body.as_ref()))?;
    }
    let (now, later): (Vec<&Case>, Vec<&Case>) = cases.into_iter().partition(|c| c.after.is_none());
    let constants = |c: &Case| if study.rules.input_uncertainty { uncertain_constants(&c.spec) } else { vec![] };
    let with_constants = |c: &Case| (c.clone(), constants(c).into_iter().map(|(constant, _)| constant).collect());
    let mut records = side_by_side(study, now.into_iter().map(with_constants).collect(), &store, options, watch)?;
    if !later.is_empty() && !options.stop.load(Ordering::Relaxed) {
        // Other runs make the results of the other cases: what waits takes them from the store, once they are all there
        let sources = |c: &Case| match is_part {
            true => waiting::sources(study, c, &store, options.accept_build),
            false => Some(records.clone()),
        };
        let ready = |c| waiting::ready(study, c, &sources(c)?, &store);
        let ready = later.into_iter().filter_map(ready).collect();
        records.extend(side_by_side(study, ready, &store, options, watch)?);
    }
    let places: HashMap<&str, usize> = study.cases.iter().enumerate().map(|(k, c)| (c.id.as_str(), k)).collect();
    records.sort_by_key(|r: &CaseRecord| places.get(r.id.as_str()).copied());
    Ok(records)
}

/// Runs cases, each together with the derivatives by the constants.
fn side_by_side(
    study: &Study,
    mut cases: Vec<(Case, Vec<Constant>)>,
    store: &Store,
    options: &Options,
    watch: &dyn Watch,
) -> Result<Vec<CaseRecord>, RunError> {
    // Meshes first, one after the other: the mesher takes its own time, and two cases may want the same mesh.
    let mut sizes = BTreeMap::new();
    for (case, _) in &cases {
        if options.stop.load(Ordering::Relaxed) {
            return Ok(Vec::new());
        }
        let body = match Body::load(&case.scene_file, &case.spec.mesh, &mut |line| watch.meshing(&case.id, line)) {
            // Ctrl-C reaches the mesher too: that is no fault of the study.
            Err(_) if options.stop.load(Ordering::Relaxed) => return Ok(Vec::new()),
            body => body,
        };
        let size = match body {
            Err(_) if study.rules.keep_refusals => 0,
            body => body?.mesh.points.len(),
        };
        sizes.insert(case.id.clone(), size);
    }
    // The largest first, so that the last ones to end are short. Where memory is measured the smallest: what a large case
    // leaves with the allocator must not count as that of a small one.
    cases.sort_by_key(|(c, _)| std::cmp::Reverse(sizes[&c.id]));
    if study.rules.smallest_first {
        cases.reverse();
    }
    let (next, running) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let (records, failure) = (Mutex::new(Vec::new()), Mutex::new(None));
    std::thread::scope(|scope| {
        for _ in 0..options.jobs.max(1) {
            scope.spawn(|| {
                while let Some((case, constants)) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
                    if options.stop.load(Ordering::Relaxed) || lock(&failure).is_some() {
                        break;
                    }
                    let run = || run_or_reuse(study, case, constants, store, options, &running, watch);
                    match if study.rules.keep_refusals {
                        recording_refusals(case, store, &running, watch, run)
                    } else {
                        run()
                    } {
                        Ok(Some(record)) => lock(&records).push(record),
                        Ok(None) => {}
                        Err(error) => {
                            lock(&failure).get_or_insert(error);
                        }
                    }
                }
            });
        }
    });
    if let Some(error) = lock(&failure).take() {
        return Err(error);
    }
    Ok(std::mem::take(&mut *lock(&records)))
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// A study of hard cases goes on where a scene is refused or, by a bug, its run panics: both are results.
fn recording_refusals(
    case: &Case,
    store: &Store,
    running: &AtomicUsize,
    watch: &dyn Watch,
    run: impl FnOnce() -> Result<Option<CaseRecord>, RunError>,
) -> Result<Option<CaseRecord>, RunError> {
    let record = match std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)) {
        Ok(Err(RunError::Scene(why))) => refused(case, REFUSED, why.to_string()),
        Ok(outcome) => return outcome,
        Err(why) => {
            running.fetch_sub(1, Ordering::SeqCst);
            let words = why.downcast_ref::<String>().cloned();
            let words = words.or_else(|| why.downcast_ref::<&str>().map(ToString::to_string));
            refused(case, PANICKED, words.unwrap_or_else(|| "a bug of this program".into()))
        }
    };
    store.save_refused(&record)?;
    watch.finished(&record, false);
    Ok(Some(record))
}

fn run_or_reuse(
    study: &Study,
    case: &Case,
    constants: &[Constant],
    store: &Store,
    options: &Options,
    running: &AtomicUsize,
    watch: &dyn Watch,
) -> Result<Option<CaseRecord>, RunError> {
    let body = Body::load(&case.scene_file, &case.spec.mesh, &mut |line| watch.meshing(&case.id, line))?;
    let identity = case.identity(Some(&body));
    let mut fields = match options.vtu {
        true => Some(Fields::new(store.folder(&case.id)?, &case.id, &USUAL)),
        false => None,
    };
    let drawn = fields.as_ref().is_none_or(|f| f.collection().is_file());
    // A run that draws does not measure its cost
    let repeats = if options.vtu { 1 } else { study.repeats(case) };
    let enough =
        |r: &CaseRecord| r.repeats.len().max(1) >= repeats && (r.one_run.is_some() || !study.estimates_errors(case));
    let same = |r: &CaseRecord| r.provenance.counts_for(&identity, options.accept_build);
    let usable = |r: &CaseRecord| drawn && !options.redo && same(r) && (enough(r) || !r.converged());
    if let Some(record) = store.record(&case.id).filter(usable) {
        watch.finished(&record, true);
        return Ok(Some(record));
    }
    watch.started(&case.id);
    let started = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let mut shared = running.fetch_add(1, Ordering::SeqCst) > 0;
    let watched = watch_memory().filter(|()| !shared);
    let mut go_on = |progress| {
        shared |= running.load(Ordering::Relaxed) > 1;
        watch.progress(&case.id, progress);
        !options.stop.load(Ordering::Relaxed)
    };
    let solved = refined(
        (&case.scene_file, &case.spec, &case.text),
        Arc::new(body),
        &mut |line| watch.meshing(&case.id, line),
        &mut go_on,
    )
    .map_err(|why| RunError::Refine { case: case.id.clone(), why: why.into() })
    .and_then(|mesh| solve(study, case, constants, mesh, repeats, &mut fields, &mut go_on));
    running.fetch_sub(1, Ordering::SeqCst);
    let memory = watched.filter(|()| !shared).and_then(|()| largest_memory());
    if matches!(solved, Err(RunError::Refine { .. })) && options.stop.load(Ordering::Relaxed) {
        return Ok(None);
    }
    let Some(mut solved) = solved? else { return Ok(None) };
    if matches!(solved.run.status, Status::Interrupted { .. }) && solved.run.failure.is_none() {
        return Ok(None);
    }
    if let Some(fields) = fields {
        let (wall, cpu) = fields.finish()?;
        solved.times = (solved.times.0 - wall, solved.times.1 - cpu);
    }
    if study.rules.keep_refusals && solved.run.status != Status::Converged {
        let mut last = Fields::new(store.folder(&case.id)?, "last", &USUAL);
        last.add(&solved.scene, &solved.run.last, 0);
        last.finish()?;
    }
    let record = store_result(case, store, &solved, (shared, memory, identity, started))?;
    watch.finished(&record, false);
    Ok(Some(record))
}

/// A case with its run.
struct Solved {
    scene: Scene,
    run: Run,
    /// Constants that were found before the run
    found: Option<Calibration>,
    /// Adaptive meshes, the last of which is that of the run
    refinement: Vec<RefinementRecord>,
    sensitivities: Option<Sensitivities>,
    one_run: Option<OneRunRecord>,
    /// Facts about the result that its numbers do not say
    notes: Vec<String>,
    build_s: f64,
    /// Wall and CPU seconds of the run
    times: (f64, f64),
    /// Of every run, where there are several
    repeats: Vec<RepeatRecord>,
}

/// Finds the constants of a case that asks for some, and runs its scene. `None`: stopped.
fn solve(
    study: &Study,
    case: &Case,
    constants: &[Constant],
    (body, refinement): (Arc<Body>, Vec<RefinementRecord>),
    repeats: usize,
    fields: &mut Option<Fields>,
    go_on: &mut dyn FnMut(Progress) -> bool,
) -> Result<Option<Solved>, RunError> {
    let found = match find(case, &body, go_on) {
        Ok(found) => found,
        Err(error) => return error.map_or(Ok(None), Err),
    };
    // The case of a calibration is its scene at the constants that were found
    let (found, spec) = found.map_or_else(|| (None, case.spec.clone()), |(found, spec)| (Some(found), spec));
    let building = Instant::now();
    let scene = Scene::build(&case.scene_file, spec, case.text.clone(), body);
    let build_s = building.elapsed().as_secs_f64();
    let scene = scene?;
    check_quantities(study, case, &scene)?;
    let mut estimator = study.estimates_errors(case).then(|| ErrorEstimator::new(&scene));
    let mut number = 0..;
    let mut states = |state: &State| {
        if let Some(Ok(estimator)) = &mut estimator {
            estimator.add(state);
        }
        if let Some(fields) = fields.as_mut() {
            fields.add(&scene, state, number.next().expect("there is always a next number"));
        }
    };
    let mut notes = vec![];
    let recorder = match constants {
        [] => None,
        some => match SensitivityRecorder::new(&scene, some) {
            Ok(recorder) => Some(recorder),
            // Intervals of constants are an addition; a scene without derivatives has its result
            Err(why) if study.rules.input_uncertainty => {
                notes.push(left_out(some, &why.to_string()));
                None
            }
            Err(why) => return Err(InverseError::from(why).into()),
        },
    };
    let (run, sensitivities, times, all) = if let Some(recorder) = recorder {
        let (wall, cpu) = (Instant::now(), ThreadTime::now());
        let mut run = scene.run_with(RunOptions {
            on_progress: Some(go_on),
            on_state: Some(&mut states),
            sensitivities: Some(recorder),
            ..RunOptions::default()
        });
        let sensitivities = run.sensitivities.take().expect("the options ask for them");
        let times =
            (wall.elapsed().as_secs_f64() - sensitivities.wall, cpu.elapsed().as_secs_f64() - sensitivities.cpu);
        (run, Some(sensitivities), times, vec![])
    } else {
        let (run, times, all) = measure(&scene, repeats, go_on, &mut states);
        (run, None, times, all)
    };
    let one_run = estimator.map(|estimator| one_run(estimator, &run, &study.columns_of(case)));
    let repeats = if repeats > 1 { all } else { vec![] };
    let spent = |of: fn(&RefinementRecord) -> f64| refinement.iter().map(of).sum::<f64>();
    let times = (times.0 + spent(|r| r.wall_s), times.1 + spent(|r| r.cpu_s));
    Ok(Some(Solved { scene, run, found, refinement, sensitivities, one_run, notes, build_s, times, repeats }))
}

/// The note that constants known within intervals are in no error bar.
fn left_out(constants: &[Constant], why: &str) -> String {
    let names: Vec<String> = constants.iter().map(ToString::to_string).collect();
    format!(
        "the intervals of {} are in no error bar, as derivatives by them are not known here: {why}",
        names.join(", ")
    )
}

/// Stores what a case has left; the record comes last. With it: whether another case ran at the same time, the memory of
/// the process, the identity of the case, the start of its run.
fn store_result(
    case: &Case,
    store: &Store,
    solved: &Solved,
    (shared, memory, identity, started): (bool, Option<u64>, Identity, u64),
) -> Result<CaseRecord, RunError> {
    let Solved { scene, run, .. } = solved;
    let writing = Instant::now();
    let skin = skin(scene, run);
    let mut record = record(scene, run, solved.times);
    record.id.clone_from(&case.id);
    record.family.clone_from(&case.family);
    record.variant.clone_from(&case.variant);
    record.member.clone_from(&case.member);
    record.shared = shared;
    (record.provenance.identity, record.provenance.started_unix_s) = (identity, started);
    record.one_run.clone_from(&solved.one_run);
    record.refinement.clone_from(&solved.refinement);
    record.notes.extend(refinement::note(&solved.refinement));
    record.notes.extend(solved.notes.iter().cloned());
    if let Some(sensitivities) = &solved.sensitivities {
        let known = uncertain_constants(&case.spec);
        record.inputs = if case.after.is_none() { inputs(&known, run, sensitivities) } else { vec![] };
        store.save_sensitivities(&case.id, run, sensitivities)?;
    }
    if let Some(calibration) = &solved.found {
        store.save_calibration(&case.id, calibration)?;
        if !calibration.settled && record.converged() {
            record.status = "SearchNotSettled".into();
            let detail = "the search for the constants did not come to its end; take another start, or fewer unknowns";
            record.status_detail = Some(detail.into());
        }
    }
    (record.phases.build_s, record.work.memory_bytes) = (solved.build_s, memory);
    record.repeats.clone_from(&solved.repeats);
    record.phases.output_s = writing.elapsed().as_secs_f64();
    store.save(&mut record, run, &skin)?;
    Ok(record)
}

/// Finds the constants of a case of a calibration; with the scene that has them. `Err(None)`: stopped. A scene that cannot be solved at
/// its own constants has no answer, and its run will say why.
fn find(
    case: &Case,
    body: &Arc<Body>,
    go_on: &mut dyn FnMut(Progress) -> bool,
) -> Result<Option<(Calibration, SceneSpec)>, Option<RunError>> {
    let Some(plan) = &case.plan else { return Ok(None) };
    let unknown = SceneModel::unknowns(&case.spec, &plan.constants).map_err(|e| Some(e.into()))?;
    let model = SceneModel {
        file: case.scene_file.clone(),
        spec: case.spec.clone(),
        text: case.text.clone(),
        body: body.clone(),
        unknown,
        x: plan.x.clone(),
        y: plan.y.clone(),
    };
    match calibrate(&model, &plan.measured, &plan.settings, go_on) {
        Ok((calibration, scene)) => Ok(Some((calibration, scene.spec))),
        Err(Failure::Input(error)) => Err(Some(error.into())),
        Err(Failure::Interrupted) => Err(None),
        Err(Failure::Constants(_) | Failure::Run(_)) => Ok(None),
    }
}

/// Every quantity that a variant judges must be recorded, as a curve over time, and no signal be left to a controller.
pub fn check_quantities(study: &Study, case: &Case, scene: &Scene) -> Result<(), RunError> {
    if let Some(signal) = scene.controls.controlled().pop() {
        return Err(RunError::Controlled { file: case.scene_file.clone(), signal });
    }
    let refuse = |fact| RunError::Quantity { file: study.file.clone(), variant: case.variant.clone(), fact };
    if let Some(columns) = study.columns.get(&case.family) {
        return columns.iter().find_map(|c| scene.check_column(c).err()).map_or(Ok(()), |fact| Err(refuse(fact)));
    }
    let quantities = study.record.quantities.get(&case.variant).into_iter().flatten();
    let mut checks = std::iter::once(scene.check_time()).chain(quantities.map(|q| scene.check_column(&q.name)));
    checks.find_map(Result::err).map_or(Ok(()), |fact| Err(refuse(fact)))
}
