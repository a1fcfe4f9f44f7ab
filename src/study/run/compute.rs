//! Computes one case and stores its result. A bug that ends the computation is the status of this case alone.

use crate::calibrate::inverse::{
    Calibration, End, Failure, InverseError, ObservedCurve, SceneModel, SearchWatch, Unknown, calibrate,
};
use crate::live::{Access, iterations};
use crate::math::threads::CpuClock;
use crate::report::viewer::film::Film;
use crate::report::viewer::page;
use crate::report::viewer::shape::Limits;
use crate::scene::{
    Body, ErrorEstimator, OnProgress, ParameterKey, Progress, RefineError, Run, RunOptions, Scene, SceneError,
    SceneSpec, Sensitivities, SensitivityRecorder, from_text,
};
use crate::solve::Status;
use crate::study::case::Case;
use crate::study::inverse::{CalibrationPlan, MeasuredPlan};
use crate::study::run::inputs::{inputs, uncertain_constants};
use crate::study::run::live_case::LiveCase;
use crate::study::run::one_run::{OneRunRecord, one_run};
use crate::study::run::refinement::{self, RefinementRecord, refined};
use crate::study::run::task::{Task, TaskError};
use crate::study::run::work::{Aside, RepeatRecord, largest_memory, measure, present_memory, watch_memory};
use crate::study::store::fields::{Fields, USUAL};
use crate::study::store::folder::{CaseOutput, Store, StoreError};
use crate::study::store::identity::Identity;
use crate::study::store::outcome::{record, refused, skin};
use crate::study::store::record::{CaseRecord, NOT_DETERMINED, NOT_SETTLED, OUT_OF_TIME, PANICKED, REFUSED};
use crate::study::store::states::KeptStates;
use crate::study::view;
use crate::system::State;
use std::path::Path;
use std::sync::Arc;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// Why a case has no result, not even a status.
#[derive(Debug, thiserror::Error)]
pub enum CaseError {
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
    #[error(transparent)]
    Task(#[from] TaskError),
}

/// Receives each line of the mesher.
type OnLine<'a> = dyn FnMut(&str) + 'a;

/// Follows the computation of a case.
pub struct Follow<'a> {
    pub meshing: &'a mut dyn FnMut(&str),
    /// Returns false to stop
    pub progress: &'a mut dyn FnMut(Progress) -> bool,
    /// Whether another case runs at this moment
    pub shared: &'a dyn Fn() -> bool,
    /// Gets the memory that the case is going to take \[bytes\], waits until it is there, and returns false to stop
    pub admit: &'a mut dyn FnMut(u64) -> bool,
    /// Serves a live view of the run, reached in this way, and gets its port
    pub live: Option<(&'a Access, &'a mut dyn FnMut(u16))>,
    /// This process computes nothing but this case, so that its memory is that of the case
    pub own_process: bool,
}

/// Computes a case and stores its result. `None`: stopped, and nothing is left.
pub fn compute(task: &Task, store: &Store, follow: &mut Follow) -> Result<Option<CaseRecord>, CaseError> {
    let computed = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| run(task, store, follow)));
    let record = match computed {
        Ok(Err(CaseError::Scene(why))) if task.keep_refusals => refused(&task.case, REFUSED, why.to_string()),
        Ok(computed) => return computed,
        Err(why) => {
            let words = why.downcast_ref::<String>().map(String::as_str).or(why.downcast_ref::<&str>().copied());
            let words = words.unwrap_or("no reason is known");
            let detail = format!("{words}; this is a bug of the program, please report it with the scene");
            refused(&task.case, PANICKED, detail)
        }
    };
    store.save_refused(&record)?;
    Ok(Some(record))
}

fn run(task: &Task, store: &Store, follow: &mut Follow) -> Result<Option<CaseRecord>, CaseError> {
    let case = &task.case;
    let body = Body::load(&case.scene_file, &case.spec.mesh, follow.meshing)?;
    let identity = case.identity(Some(&body));
    let mut fields = match task.vtu {
        true => Some(Fields::new(store.folder(&case.id)?, &case.id, &USUAL)),
        false => None,
    };
    let started = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let mut shared = (follow.shared)();
    let watched = if follow.own_process { Some(()) } else { watch_memory().filter(|()| !shared) };
    let (mut stopped, meshing, progress) = (false, &mut *follow.meshing, &mut *follow.progress);
    let (admit, own_process, mut expected, mut waited) = (&mut *follow.admit, follow.own_process, None, 0.0);
    let live = &mut follow.live;
    let mut open =
        |scene: &Scene| live.as_mut().and_then(|(access, serves)| LiveCase::open(access, &case.id, scene, *serves));
    let mut sized = |bytes: u64| {
        // Of several runs only the first one asks
        let Some(present) = present_memory().filter(|_| own_process && expected.is_none()) else { return true };
        let asked = Instant::now();
        expected = Some(present + bytes);
        let admitted = admit(present + bytes);
        waited = asked.elapsed().as_secs_f64();
        admitted
    };
    let mut go_on = |now| {
        shared |= (follow.shared)();
        stopped |= !progress(now);
        !stopped
    };
    let from = unfinished(store, &case.id, &identity);
    // A disk that is full costs what was kept, not the search
    let mut keep = |values: &[f64]| drop(store.keep_search(&case.id, &identity, values));
    let search = (from.as_deref(), &mut keep as &mut dyn FnMut(&[f64]));
    let solved = refined((&case.scene_file, &case.spec, &case.text), Arc::new(body), meshing, &mut go_on)
        .map_err(|why| CaseError::Refine { case: case.id.clone(), why: why.into() })
        .and_then(|mesh| solve(task, mesh, search, &mut fields, (meshing, &mut go_on), &mut sized, &mut open));
    shared |= (follow.shared)();
    let memory = watched.filter(|()| follow.own_process || !shared).and_then(|()| largest_memory());
    if matches!(solved, Err(CaseError::Refine { .. })) && stopped {
        return Ok(None);
    }
    let Some(mut solved) = solved? else { return Ok(None) };
    let film = solved.film.take();
    if matches!(solved.run.status, Status::Interrupted { .. }) && solved.run.failure.is_none() {
        return Ok(None);
    }
    solved.times.0 -= waited;
    fields.map_or(Ok(()), |fields| fields.finish().map(drop))?;
    if task.keep_refusals && solved.run.status != Status::Converged {
        let mut last = Fields::new(store.folder(&case.id)?, "last", &USUAL);
        last.add(&solved.scene, &solved.run.last, 0);
        last.finish()?;
    }
    store_result(case, store, (&solved, film), (shared, [memory, expected], identity, started)).map(Some)
}

/// The best values so far of a search of the same inputs that was stopped, or had no time left.
fn unfinished(store: &Store, id: &str, identity: &Identity) -> Option<Vec<f64>> {
    let out_of_time = || {
        let record = store.record(id).filter(|r| r.status == OUT_OF_TIME && r.provenance.identity == *identity)?;
        Some(store.calibration(&record.id)?.values())
    };
    store.search(id, identity).or_else(out_of_time)
}

/// Where a search begins, and what is told of every better point of it.
type Searching<'a> = (Option<&'a [f64]>, &'a mut dyn FnMut(&[f64]));

/// A case with its run.
struct Solved {
    scene: Scene,
    run: Run,
    /// Constants that were found before the run
    found: Option<Calibration>,
    /// Why a search for them could not begin
    unsearched: Option<String>,
    /// Adaptive meshes, the last of which is that of the run
    refinement: Vec<RefinementRecord>,
    sensitivities: Option<Sensitivities>,
    one_run: Option<OneRunRecord>,
    /// The states, where the scene records fields
    film: Option<Film>,
    /// The states, where the study keeps them
    states: Option<KeptStates>,
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
    task: &Task,
    (body, refinement): (Arc<Body>, Vec<RefinementRecord>),
    search: Searching,
    fields: &mut Option<Fields>,
    (meshing, go_on): (&mut OnLine, &mut OnProgress),
    sized: &mut dyn FnMut(u64) -> bool,
    open: &mut dyn FnMut(&Scene) -> Option<LiveCase>,
) -> Result<Option<Solved>, CaseError> {
    let (case, repeats) = (&task.case, task.repeats);
    // The case of a calibration is its scene at the constants that were found
    let Searched { found, unsearched, spec } = match find(case, &body, search, (meshing, go_on)) {
        Ok(searched) => searched,
        Err(error) => return error.map_or(Ok(None), Err),
    };
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
        if let Some(fields) = fields.as_mut() {
            fields.add(&scene, state, number.next().expect("there is always a next number"));
        }
        film.iter_mut().for_each(|film| film.add(&scene, state));
        kept.iter_mut().for_each(|kept| kept.add(state));
        live.iter_mut().for_each(|live| live.add(&scene, state));
    };
    let mut rows = |row: &[f64]| {
        board.iter().for_each(|board| board.row(row));
        true
    };
    let mut notes = vec![];
    let (run, sensitivities, times, all) = if let Some(recorder) = recorder(&scene, task, &mut notes)? {
        let (wall, cpu, mut aside) = (Instant::now(), CpuClock::start(), Aside::default());
        let mut on_state = |state: &State| aside.count(|| states(state));
        let mut run = scene.run_with(RunOptions {
            on_progress: Some(go_on),
            on_state: Some(&mut on_state),
            on_row: Some(&mut rows),
            on_iteration: board.clone().map(iterations),
            on_sized: Some(sized),
            sensitivities: Some(recorder),
            ..RunOptions::default()
        });
        let sensitivities = run.sensitivities.take().expect("the options ask for them");
        let times =
            (wall.elapsed().as_secs_f64() - sensitivities.wall, cpu.elapsed().as_secs_f64() - sensitivities.cpu);
        (run, Some(sensitivities), aside.subtracted(times), vec![])
    } else {
        let (run, times, all) = measure(&scene, repeats, go_on, &mut states, board.as_ref(), sized);
        (run, None, times, all)
    };
    live.into_iter().for_each(|live| live.end(&run));
    let one_run = estimator.map(|estimator| one_run(estimator, &run, &task.columns));
    let repeats = if repeats > 1 { all } else { vec![] };
    let spent = |of: fn(&RefinementRecord) -> f64| refinement.iter().map(of).sum::<f64>();
    let times = (times.0 + spent(|r| r.wall_s), times.1 + spent(|r| r.cpu_s));
    Ok(Some(Solved {
        scene,
        run,
        found,
        unsearched,
        refinement,
        sensitivities,
        one_run,
        film,
        states: kept,
        notes,
        build_s,
        times,
        repeats,
    }))
}

/// The scene of a case, checked against what its study asks of it, and the time of its construction \[s\].
fn built(task: &Task, spec: SceneSpec, body: Arc<Body>) -> Result<(Scene, f64), CaseError> {
    let building = Instant::now();
    let scene = Scene::build(&task.case.scene_file, spec, task.case.text.clone(), body)?;
    let build_s = building.elapsed().as_secs_f64();
    task.check(&scene)?;
    Ok((scene, build_s))
}

/// Records the derivatives that the task asks for, if any.
fn recorder<'a>(
    scene: &'a Scene,
    task: &'a Task,
    notes: &mut Vec<String>,
) -> Result<Option<SensitivityRecorder<'a>>, CaseError> {
    if task.constants.is_empty() {
        return Ok(None);
    }
    // For the intervals of constants the derivatives at extremes are enough; other analyses take them along curves
    let made = match task.input_uncertainty && task.case.derivatives.is_empty() {
        true => SensitivityRecorder::at_extremes(scene, &task.constants),
        false => SensitivityRecorder::new(scene, &task.constants),
    };
    match made {
        Ok(recorder) => Ok(Some(recorder)),
        // Intervals of constants are an addition; a scene without derivatives has its result
        Err(why) if task.input_uncertainty => {
            notes.push(left_out(&task.constants, &why.to_string()));
            Ok(None)
        }
        Err(why) => Err(InverseError::from(why).into()),
    }
}

/// The note that constants known within intervals are in no error bar.
fn left_out(constants: &[ParameterKey], why: &str) -> String {
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
    (solved, film): (&Solved, Option<Film>),
    (shared, [memory, expected], identity, started): (bool, [Option<u64>; 2], Identity, u64),
) -> Result<CaseRecord, CaseError> {
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
    }
    let unsearched = || {
        let why = solved.unsearched.as_ref()?;
        Some((NOT_SETTLED, format!("the search of case {} cannot begin at the values of its scene: {why}", case.id)))
    };
    let doubt = solved.found.as_ref().and_then(doubt).or_else(unsearched);
    if let Some((status, detail)) = doubt.filter(|_| record.converged()) {
        (record.status, record.status_detail) = (status.into(), Some(detail));
    }
    record.phases.build_s = solved.build_s;
    (record.work.memory_bytes, record.work.expected_bytes) = (memory, expected);
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

/// Why the constants of a search are no answer, as a status with its detail.
fn doubt(found: &Calibration) -> Option<(&'static str, String)> {
    match found.end {
        End::Settled | End::Stuck if found.constants.iter().any(|c| c.interval.is_none() && c.bound == 0) => {
            Some((NOT_DETERMINED, found.unidentified.join("; ")))
        }
        End::Settled => None,
        End::Stuck => Some((
            NOT_SETTLED,
            "the search for the constants did not come to its end; take another start, or fewer unknowns".into(),
        )),
        End::OutOfTime => Some((
            OUT_OF_TIME,
            format!(
                "its time was over after {} forward solves; run again to go on from the best answer so far",
                found.solves
            ),
        )),
    }
}

/// The search that precedes the run of a case.
struct Searched {
    /// The constants of a case of a calibration
    found: Option<Calibration>,
    /// Why the search for them could not begin
    unsearched: Option<String>,
    /// The scene that is run
    spec: SceneSpec,
}

/// Finds the constants of a case of a calibration. `Err(None)`: stopped.
fn find(
    case: &Case,
    body: &Arc<Body>,
    (from, keep): Searching,
    (meshing, go_on): (&mut OnLine, &mut OnProgress),
) -> Result<Searched, Option<CaseError>> {
    let without = |unsearched| Ok(Searched { found: None, unsearched, spec: case.spec.clone() });
    let Some(plan) = &case.plan else { return without(None) };
    let curves = curves(case, plan, body, meshing).map_err(Some)?;
    let mut follow = Followed { progress: SearchProgress::new(curves.len()), go_on, keep };
    match calibrate(curves, &plan.settings, from, &mut follow) {
        Ok((calibration, scene)) => Ok(Searched { found: Some(calibration), unsearched: None, spec: scene.spec }),
        Err(Failure::Input(error)) => Err(Some(error.into())),
        Err(Failure::Interrupted) => Err(None),
        Err(Failure::Constants(why)) => without(Some(why)),
        Err(Failure::Run(status)) => without(Some(status.to_string())),
    }
}

/// The curves of a case, each with its scene and body.
fn curves(
    case: &Case,
    plan: &CalibrationPlan,
    body: &Arc<Body>,
    meshing: &mut dyn FnMut(&str),
) -> Result<Vec<ObservedCurve>, CaseError> {
    let own = |curve: &MeasuredPlan, file: &Path, spec: SceneSpec, text: &str, body: Arc<Body>| {
        let unknown = Unknown::all((file, &spec, text), &plan.constants, &plan.bounds)?;
        let (x, y) = (curve.x.clone(), curve.y.clone());
        let model = SceneModel { file: file.into(), spec, text: text.into(), body, unknown, x, y };
        let MeasuredPlan { name, measured, offsets, .. } = curve.clone();
        Ok::<_, CaseError>(ObservedCurve { name, model, measured, offsets })
    };
    let mut all = vec![own(&plan.curve, &case.scene_file, case.spec.clone(), &case.text, body.clone())?];
    for more in &plan.more {
        let text = more.scene_of(&case.member);
        let spec: SceneSpec = from_text(&more.scene_file, text, "")?;
        let body = Arc::new(Body::load(&more.scene_file, &spec.mesh, meshing)?);
        all.push(own(&more.curve, &more.scene_file, spec, text, body)?);
    }
    Ok(all)
}

/// A search as a case of a run follows it.
struct Followed<'a, 'b> {
    progress: SearchProgress,
    go_on: &'a mut OnProgress<'b>,
    keep: &'a mut dyn FnMut(&[f64]),
}

impl SearchWatch for Followed<'_, '_> {
    fn progress(&mut self, now: Progress) -> bool {
        (self.go_on)(self.progress.of(now))
    }

    fn better(&mut self, values: &[f64]) {
        (self.keep)(values);
    }
}

/// Progress of a search as that of one long run: forward solves that are expected, each of the same share.
struct SearchProgress {
    expected: usize,
    done: usize,
    /// Time of the last state of the forward solve that runs \[s\]
    last: f64,
}

impl SearchProgress {
    /// Forward solves of each curve in a usual search
    const USUAL: usize = 6;

    fn new(curves: usize) -> Self {
        Self { expected: Self::USUAL * curves, done: 0, last: 0.0 }
    }

    fn of(&mut self, Progress { t, end }: Progress) -> Progress {
        if t < self.last {
            self.done += 1;
            self.expected = self.expected.max(self.done + 2);
        }
        self.last = t;
        let share = (self.done as f64 + t / end) / self.expected as f64;
        Progress { t: share.min(1.0) * end, end }
    }
}
