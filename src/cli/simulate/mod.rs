//! `durometer simulate SCENE`

mod args;
mod controls;
mod drawing;
mod earlier;
mod errors;
mod mesh;
mod output;
mod states;

use crate::outcome::{CommandResult, Outcome};
use crate::progress::Bars;
use crate::{interrupt, live};
pub use args::Args;
use controls::positive_time;
use drawing::Drawing;
use durometer::live::Shown;
use durometer::math::stopwatch::{Spent, Stopwatch};
use durometer::math::threads;
use durometer::scene::control::Controller;
use durometer::scene::{
    Body, Checkpoint, FileDigest, ParameterKey, Progress, RefineError, Run, RunOptions, Scene, SceneSpec,
    SensitivityError, SensitivityRecorder,
};
use durometer::storage;
use durometer::study::overlay::{markers, overlays};
use durometer::study::run::runner::Watch;
use durometer::study::store::csv_text;
use durometer::study::store::finished_run;
use durometer::study::store::folder::{self, StoreError};
use durometer::study::store::partial_series::{NameLock, PartialSeries};
use durometer::study::store::record::CaseRecord;
use durometer::system::State;
use earlier::Earlier;
use errors::{estimate, estimator};
use mesh::mesh;
use output::{completion, note_missing, note_quality, print_notes, tell};
use states::{States, times};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

pub fn main(args: Args) -> CommandResult {
    match simulate(args) {
        Err(why) if matches!(why.downcast_ref(), Some(RefineError::Interrupted { .. })) => {
            tell!("not complete: {why}");
            Ok(Outcome::RunIncomplete)
        }
        outcome => outcome,
    }
}

fn simulate(args: Args) -> CommandResult {
    threads::use_threads(args.threads.unwrap_or_else(threads::available));
    let (file, spec, text) = args.read()?;
    let name = file.file_stem().map_or_else(|| "scene".into(), |n| n.to_string_lossy().into_owned());
    let (_lock, earlier) = check_out(&args.out, &name)?;
    let (listener, stop) = (live::listen(args.live, args.port)?, interrupt::stop_flag());
    let bars = Bars::new(args.json);
    let (body, refined) = mesh(&args, (&file, &spec, &text), &name, &bars)?;
    let (scene, build_s) = build(&file, spec, text, body)?;
    let sensitivities = sensitivities(&args.sensitivity, &scene)?;
    let from = args.restart.as_ref().map(|file| Checkpoint::read(file, &scene)).transpose()?;
    let (save_at, save_end) = times(&args.save_state, &scene)?;
    let save_every = positive_time("--checkpoint", &args.checkpoint)?;
    let page = listener.is_some().then(|| controls::recording(&args.out, &name));
    let (source, mut estimator) = (args.control.source(&scene, page, stop)?, estimator(&args, &scene)?);
    source.check(!args.sensitivity.is_empty() || estimator.is_some())?;
    print_notes(&args, &scene);
    bars.started(&name);
    let wanted = (args.vtu, !args.no_view, listener.is_some());
    let mut drawing = Drawing::new((&args.out, &name), wanted, &scene, from.as_ref());
    let shown = Shown { run: &name, case: false, from: from.as_ref(), recording: source.page(), paused: args.paused };
    let (board, _served) = listener.and_then(|listener| drawing.follow(&scene, listener, &shown)).unzip();
    let (note, mut controller) = args.control.controller(source, &scene, (from.as_ref(), board.as_ref()), stop)?;
    let mut partial = PartialSeries::create(&args.out, &name, &scene)?;
    let mut states = States { out: &args.out, name: &name, files: vec![], kept: false, failure: None };
    let mut save = |checkpoint: &Checkpoint, label: &str| states.save(checkpoint, label);
    let mut watch = |progress: Progress| {
        bars.progress(&name, progress);
        board.iter().for_each(|board| board.accepted(progress.t));
        true
    };
    let mut points = |state: &State| {
        drawing.add(&scene, state);
        estimator.iter_mut().for_each(|estimator| estimator.add(state));
    };
    let mut rows = |row: &[f64]| {
        board.iter().for_each(|board| board.row(row));
        partial.add(row)
    };
    let options = RunOptions {
        on_sized: Some(&mut begins),
        on_row: Some(&mut rows),
        save_every: Some(save_every),
        restart: from,
        controller: controller.as_mut().map(|c| c as &mut dyn Controller),
        other_controller: args.control.other_controller,
        save_at,
        save_end,
        on_save: Some(&mut save),
        on_progress: Some(&mut watch),
        on_state: Some(&mut points),
        on_iteration: board.clone().map(durometer::live::iterations),
        stop: Some(stop.clone()),
        sensitivities,
        ..RunOptions::default()
    };
    let stopwatch = Stopwatch::start();
    let run = scene.run_with(options);
    let (spent, waited) = (stopwatch.spent(), controller.map_or(0.0, |c| c.waited.as_secs_f64()));
    let (mut drawn, film) = drawing.finish();
    let elsewhere = Spent { wall_s: waited, cpu_s: 0.0 } + drawn.spent;
    let mut record = finished_run::record(&scene, &run, run.own_time(spent, elsewhere));
    record.notes.extend(note.map(|note| controls::since(&run.controllers, note)));
    (record.id, record.phases.build_s) = (name.clone(), build_s);
    let (json, full) = replace((&mut partial, earlier), &args.out, &scene, &run, &mut record)?;
    states.end(&run);
    let errors =
        estimator.map(|estimator| estimate(estimator.stopped_by(stop.clone()), &args, &name, &run, &bars)).transpose();
    let found = errors.as_ref().ok().and_then(|found| found.as_ref()?.as_ref());
    drawn.show(film, &scene, (&run, &record), found);
    partial.remove();
    let errors = errors?;
    let has_errors = errors.as_ref().is_none_or(Option::is_some);
    bars.finished(&record, false);
    tell(&args, (&record, scene.notes.len(), &json), &states.files, errors.iter().flatten(), &drawn);
    live::end(board.as_deref(), &run, stop);
    full.map_or(Ok(()), Err)?;
    drawn.failure.map_or(Ok(()), Err)?;
    states.failure.map_or_else(|| Ok(completion(&run, has_errors && refined, states.kept)), |why| Err(why.into()))
}

/// Marks the end of the set-up, whatever memory the run will take: from here on a signal stops the run, and its rows are kept.
fn begins(_: u64) -> bool {
    interrupt::set_up(false);
    true
}

/// Builds the scene and returns it with the time that this took \[s\]; invalid marker tracks that it is compared with are refused before the run.
fn build(
    file: &Path,
    spec: SceneSpec,
    text: String,
    body: Arc<Body>,
) -> Result<(Scene, f64), Box<dyn std::error::Error>> {
    interrupt::set_up(true);
    let building = Instant::now();
    let scene = Scene::build(file, spec, text, body)?;
    markers::read(&scene)?;
    Ok((scene, building.elapsed().as_secs_f64()))
}

/// Refuses a folder that cannot be written, or where another process runs under this name, before anything is computed. Returns the lock of the name, and
/// the files of the previous run.
fn check_out(out: &Path, name: &str) -> Result<(NameLock, Earlier), Box<dyn std::error::Error>> {
    let remedy = "choose another folder with --out, or make room";
    storage::writable_folder(out).map_err(|e| format!("{}: cannot be written: {e}; {remedy}", out.display()))?;
    let lock = NameLock::take(out, name)?;
    folder::sweep_parts(out);
    Ok((lock, Earlier::find(out, name)))
}

/// Writes the results in place of the partial rows and of the files of the previous run. Returns the record as JSON, and the failure that ended the
/// partial rows, if any.
fn replace(
    (partial, earlier): (&mut PartialSeries, Earlier),
    out: &Path,
    scene: &Scene,
    run: &Run,
    record: &mut CaseRecord,
) -> Result<(String, Option<StoreError>), String> {
    let kept = |e: Box<dyn std::error::Error>| format!("{e}; the rows of the run are in {}", partial.path().display());
    let json = write(out, earlier, scene, run, record).map_err(kept)?;
    Ok((json, partial.failure()))
}

/// Builds the recorder of the requested derivatives; `None` if none are requested.
fn sensitivities<'a>(texts: &[String], scene: &'a Scene) -> Result<Option<SensitivityRecorder<'a>>, SensitivityError> {
    let keys: Vec<ParameterKey> = texts.iter().map(|text| text.parse()).collect::<Result<_, _>>()?;
    if keys.is_empty() { Ok(None) } else { SensitivityRecorder::new(scene, &keys).map(Some) }
}

/// Writes the time series, the signals, the sensitivities, the record with their digests, and the overlays; returns the record as JSON. The earlier
/// record is removed before the first file is replaced, so that a record is never next to a series of another run.
fn write(
    out: &Path,
    earlier: Earlier,
    scene: &Scene,
    run: &Run,
    record: &mut CaseRecord,
) -> Result<String, Box<dyn std::error::Error>> {
    let mut files = vec![("csv", csv_text::rows(run)), ("signals.csv", csv_text::signals(scene, run))];
    if let Some(sensitivities) = &run.sensitivities {
        files.push(("sensitivities.csv", csv_text::sensitivities(run, sensitivities)));
        note_missing(run, sensitivities);
        note_quality(sensitivities);
    }
    let named = |(end, text)| (format!("{}.{end}", record.id), text);
    let mut files: Vec<(String, String)> = files.into_iter().map(named).collect();
    let digest = |(file, text): &(String, String)| FileDigest { file: file.clone(), sha256: storage::sha256(text) };
    record.provenance.results = files.iter().map(digest).collect();
    let json = folder::json(record)?;
    files.push((format!("{}.json", record.id), json.clone()));
    let files: Vec<(PathBuf, String)> = files.into_iter().map(|(file, text)| (out.join(file), text)).collect();
    storage::write_together(&files, || earlier.remove()).map_err(folder::unwritten)?;
    durometer::study::overlay::save(out, &record.id, &overlays(scene, run), &markers::overlays(scene, run)?)?;
    Ok(json)
}
