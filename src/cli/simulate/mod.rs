//! `durometer simulate SCENE`

mod controls;
mod drawing;
mod earlier;
mod errors;
mod mesh;
mod states;
mod words;

use crate::arguments::{self, changes};
use crate::bars::Bars;
use crate::outcome::{CommandResult, Outcome};
use crate::{files, interrupt, live};
use controls::{Chosen, ControlArgs, positive_time};
use drawing::{Drawing, Drawn};
use durometer::live::Shown;
use durometer::math::cpu_clock::CpuClock;
use durometer::math::threads;
use durometer::scene::control::Controller;
use durometer::scene::{
    Body, Checkpoint, ParameterKey, Progress, RefineError, Run, RunOptions, Scene, SceneSpec, SensitivityError,
    SensitivityRecorder, read_scene,
};
use durometer::storage;
use durometer::study::overlay::{markers, overlays};
use durometer::study::run::runner::Watch;
use durometer::study::store::csv_text;
use durometer::study::store::folder::{self, StoreError};
use durometer::study::store::outcome;
use durometer::study::store::partial_series::PartialSeries;
use durometer::study::store::record::CaseRecord;
use durometer::system::State;
use earlier::Earlier;
use errors::{estimate, estimator};
use mesh::mesh;
use states::{States, times};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;
use words::{completion, note_missing, note_quality, print_notes, tell};

/// Run one scene and write its time series
///
/// Writes <name>.csv (what the probes record), <name>.signals.csv (what is prescribed), <name>.json (the
/// record, with the time each effect took), <name>.html (the motion in three dimensions, for a browser), and fields for ParaView on request.
///
/// A run that does not complete keeps everything up to its last good state. One that is killed, or finds the disk full, leaves its rows in
/// <name>.partial.csv and a state to restart from in <name>-partial.state.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer simulate studies/finger-dynamics/scene.toml
  durometer simulate my-scene.toml --set mesh.cells=9300 --out out
  durometer simulate my-scene.toml --set 'constraint.cable.drive={ kind = \"tension\", signal = \"2 N\" }' --vtu
  durometer simulate my-scene.toml --save-state \"0.5 s\" --save-state end
  durometer simulate my-scene.toml --restart reports/simulate/my-scene-0.5s.state
  durometer simulate my-scene.toml --controller \"python3 studies/finger-control/pi.py 30\"
  durometer simulate studies/finger-control/scene.toml --live --paused
  durometer simulate studies/finger-control/scene.toml --replay reports/simulate/scene.control.csv
  durometer simulate finger-convergence --sensitivity laws.rubber.mu --sensitivity effect.gravity.direction.0

In --set and --sensitivity a step into a list is its index from 0, or the name or kind of an entry.
Exit codes: 0 converged, 2 bad input, 3 the run did not complete.")]
pub struct Args {
    /// Scene file (TOML), or the name of a folder in studies/
    scene: PathBuf,
    /// Folder of the results
    #[arg(long, default_value = "reports/simulate")]
    out: PathBuf,
    /// Change a key, e.g. --set mesh.cells=9300
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Write displacement and stretch at every step of the time grid as VTU, with a PVD collection; in ParaView, Warp By Vector with displacement_m deforms the grid
    #[arg(long)]
    vtu: bool,
    /// Write <name>.sensitivities.csv: derivatives of positions, angles, reactions and cables by a number of the scene, several times, e.g.
    /// --sensitivity laws.rubber.mu --sensitivity effect.gravity.density; not in implicit_euler_linearised or _corrected
    #[arg(long, value_name = "KEY", conflicts_with_all = ["save_state", "restart", "controller", "replay"])]
    sensitivity: Vec<String>,
    /// Do not write <name>.html, the page that shows the motion in three dimensions
    #[arg(long)]
    no_view: bool,
    /// Estimate the discretisation error of a recorded quantity, several times, or of all; writes <name>.errors.csv. Solves again on an
    /// enriched mesh: a static scene at the times of largest departure, one that depends on its path from the start
    #[arg(long, value_name = "COLUMN", num_args = 0..=1, default_missing_value = "all",
          conflicts_with_all = ["restart", "controller", "replay"])]
    error: Vec<String>,
    /// With --error: show on the page where in the mesh the error comes from, as a colour of the cells; an adjoint solution for each
    /// quantity. Not where the state depends on the path
    #[arg(long, requires = "error", conflicts_with = "no_view")]
    error_cells: bool,
    /// Save a state to restart from at a time ("0.5 s"), or at the `end`; several times
    #[arg(long, value_name = "WHEN")]
    save_state: Vec<String>,
    /// Go on from a saved state of this scene; the files come out as if the run had never been cut
    #[arg(long, value_name = "FILE")]
    restart: Option<PathBuf>,
    /// Wall time after which <name>-partial.state is saved, again and again; it is removed when the results are written
    #[arg(long, value_name = "TIME", default_value = "2 min")]
    checkpoint: String,
    #[command(flatten)]
    pub(super) control: ControlArgs,
    /// Show the run in a browser while it goes on: serves a page on this machine alone (127.0.0.1), at an address with a token that is printed.
    /// The page pauses the run, takes single steps, and sets the `controlled` signals of the scene, which <name>.control.csv records
    #[arg(long)]
    live: bool,
    /// Port of the live view; 0 is a free one
    #[arg(long, value_name = "N", default_value_t = 0, requires = "live")]
    port: u16,
    /// With --live: wait at the first state until a page lets the run go on
    #[arg(long, requires = "live")]
    paused: bool,
    /// Threads that the run may use [default: one per core]; the results do not depend on it
    #[arg(long, value_name = "N", value_parser = arguments::threads)]
    threads: Option<usize>,
    /// Print the record instead of progress
    #[arg(long)]
    json: bool,
}

impl Args {
    /// The scene with its changes: file, content and text.
    fn read(&self) -> Result<(PathBuf, SceneSpec, String), Box<dyn std::error::Error>> {
        let file = files::find(&self.scene, "scene.toml")?;
        let (spec, text) = read_scene(&file, &changes(&self.set)?)?;
        Ok((file, spec, text))
    }
}

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
    let earlier = check_out(&args.out, &name)?;
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
    let shown = Shown { run: &name, from: from.as_ref(), recording: source.page(), paused: args.paused };
    let (board, _served) = listener.and_then(|listener| drawing.follow(&scene, listener, &shown)).unzip();
    let note = source.note();
    let mut controller = Chosen::new(source, board.as_ref(), stop);
    let mut partial = PartialSeries::create(&args.out, &name, &scene)?;
    let mut states = States { out: &args.out, name: &name, files: vec![], failure: None };
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
    let (wall, cpu) = (Instant::now(), CpuClock::start());
    let run = scene.run_with(options);
    let times = (wall.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64());
    let waited = controller.map_or(0.0, |c| c.waited.as_secs_f64());
    let (mut drawn, film) = drawing.finish();
    let mut record = outcome::record(&scene, &run, own_times(times, &run, waited, &drawn));
    record.id.clone_from(&name);
    record.notes.extend(note);
    record.phases.build_s = build_s;
    let (json, full) = replace((partial, earlier), &args.out, &scene, &run, &record)?;
    states.end(&run);
    let errors =
        estimator.map(|estimator| estimate(estimator.stopped_by(stop.clone()), &args, &name, &run, &bars)).transpose();
    let found = errors.as_ref().ok().and_then(|found| found.as_ref()?.as_ref());
    drawn.show(film, &scene, (&run, &record), found);
    let errors = errors?;
    let has_errors = errors.as_ref().is_none_or(Option::is_some);
    bars.finished(&record, false);
    tell(&args, (&record, scene.notes.len(), &json), &states.files, errors.iter().flatten(), &drawn);
    live::end(board.as_deref(), &run, stop);
    full.map_or(Ok(()), Err)?;
    drawn.failure.map_or(Ok(()), Err)?;
    states.failure.map_or_else(|| Ok(completion(&run, has_errors && refined)), |why| Err(why.into()))
}

/// Seconds by the clock and of the processor without what is no part of the cost of a run: derivatives, the answers of a controller, the writing of
/// fields.
fn own_times((wall, cpu): (f64, f64), run: &Run, waited: f64, drawn: &Drawn) -> (f64, f64) {
    let aside = run.sensitivities.as_ref().map_or((0.0, 0.0), |s| (s.wall, s.cpu));
    (wall - aside.0 - waited - drawn.wall, cpu - aside.1 - drawn.cpu)
}

/// Takes the end of the set-up, whatever memory the run is going to take: a signal ends the run from here on, which keeps its rows.
fn begins(_: u64) -> bool {
    interrupt::set_up(false);
    true
}

/// The scene with the seconds that it took; tracks that it is compared with are refused before the run.
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

/// Refuses a folder that cannot be written, or where another process runs under this name, before anything is computed for it. Returns the files of
/// the run before.
fn check_out(out: &Path, name: &str) -> Result<Earlier, Box<dyn std::error::Error>> {
    let remedy = "choose another folder with --out, or make room";
    storage::writable_folder(out).map_err(|e| format!("{}: cannot be written: {e}; {remedy}", out.display()))?;
    PartialSeries::check_free(out, name)?;
    folder::Store::at(out).sweep();
    Ok(Earlier::find(out, name))
}

/// Writes the results in place of the rows that were written as they came, and of the files of the run before. Returns the record as JSON, and the failure that ended the rows.
fn replace(
    (partial, earlier): (PartialSeries, Earlier),
    out: &Path,
    scene: &Scene,
    run: &Run,
    record: &CaseRecord,
) -> Result<(String, Option<StoreError>), String> {
    let (rows, full) = partial.end();
    let kept = |e: Box<dyn std::error::Error>| format!("{e}; the rows of the run are in {}", rows.display());
    let json = write(out, &record.id, scene, run, record).map_err(kept)?;
    std::fs::remove_file(&rows).ok();
    earlier.remove();
    Ok((json, full))
}

/// The recorder of the derivatives that are asked for, if there are any.
fn sensitivities<'a>(texts: &[String], scene: &'a Scene) -> Result<Option<SensitivityRecorder<'a>>, SensitivityError> {
    let keys: Vec<ParameterKey> = texts.iter().map(|text| text.parse()).collect::<Result<_, _>>()?;
    if keys.is_empty() { Ok(None) } else { SensitivityRecorder::new(scene, &keys).map(Some) }
}

/// Writes the time series, the signals, the sensitivities, the record and the overlays; returns the record as JSON.
fn write(
    out: &Path,
    name: &str,
    scene: &Scene,
    run: &Run,
    record: &CaseRecord,
) -> Result<String, Box<dyn std::error::Error>> {
    folder::write(&out.join(format!("{name}.csv")), &csv_text::rows(run))?;
    folder::write(&out.join(format!("{name}.signals.csv")), &csv_text::signals(scene, run))?;
    if let Some(sensitivities) = &run.sensitivities {
        let text = csv_text::sensitivities(run, sensitivities);
        folder::write(&out.join(format!("{name}.sensitivities.csv")), &text)?;
        note_missing(run, sensitivities);
        note_quality(sensitivities);
    }
    let json = folder::json(record)?;
    folder::write(&out.join(format!("{name}.json")), &json)?;
    durometer::study::overlay::save(out, name, &overlays(scene, run), &markers::overlays(scene, run)?)?;
    Ok(json)
}
