//! `durometer simulate SCENE`

use super::controls::{self, Chosen, ControlArgs, positive_time};
use super::drawing::{Drawing, Drawn};
use super::earlier::Earlier;
use super::interrupt;
use super::live;
use super::outcome::{CommandResult, Outcome};
use super::{bars::Bars, files};
use durometer::live::Shown;
use durometer::math::cpu_clock::CpuClock;
use durometer::math::threads;
use durometer::math::units::{self, Decimals, Dimension};
use durometer::report::numbers::{five_digits, percent, seconds};
use durometer::scene::control::Controller;
use durometer::scene::{
    Body, Checkpoint, CheckpointError, Enrichment, ErrorEstimate, ErrorEstimator, EstimateError, ExtremeKind, PARTIAL,
    ParameterKey, Progress, RefineError, RefinementStep, RefinementWatch, Run, RunOptions, Scene, SceneSpec,
    Sensitivities, SensitivityError, SensitivityRecorder, limits_of_scene, read_scene, refine,
};
use durometer::solve::Status;
use durometer::storage;
use durometer::study::locking::REMEDY;
use durometer::study::overlay::distance::Distance;
use durometer::study::overlay::{markers, overlays};
use durometer::study::run::runner::Watch;
use durometer::study::store::csv_text;
use durometer::study::store::folder::{self, StoreError};
use durometer::study::store::outcome;
use durometer::study::store::partial_series::PartialSeries;
use durometer::study::store::record::CaseRecord;
use durometer::system::State;
use durometer::wording::few;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Share of the extreme of a column below which its last value is rounding.
const ROUNDING: f64 = 1e-12;

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
    #[arg(long, value_name = "N", value_parser = super::arguments::threads)]
    threads: Option<usize>,
    /// Print the record instead of progress
    #[arg(long)]
    json: bool,
}

impl Args {
    /// The scene with its changes: file, content and text.
    fn read(&self) -> Result<(PathBuf, SceneSpec, String), Box<dyn std::error::Error>> {
        let file = files::find(&self.scene, "scene.toml")?;
        let (spec, text) = read_scene(&file, &super::arguments::changes(&self.set)?)?;
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

fn print_notes(args: &Args, scene: &Scene) {
    if !args.json {
        scene.notes.iter().for_each(|note| tell!("{}: {note}", scene.kind_of_note(note)));
        limits_of_scene(scene).iter().for_each(|(kind, limit)| tell!("{kind}: {limit}"));
    }
}

/// Prints the record, or the results in words; `known` notes are printed before.
fn tell<'e>(
    args: &Args,
    (record, known, json): (&CaseRecord, usize, &str),
    states: &[PathBuf],
    errors: impl Iterator<Item = &'e ErrorEstimate>,
    drawn: &Drawn,
) {
    if args.json {
        say!("{json}");
        return;
    }
    print(record, known);
    states.iter().for_each(|file| say!("state:   {}", file.display()));
    errors.for_each(|found| print_errors(found, record));
    say!("{}", costs(record));
    say!("results: {}", args.out.join(format!("{}.csv", record.id)).display());
    drawn.print();
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

/// The states that a run saves.
struct States<'a> {
    out: &'a Path,
    name: &'a str,
    /// Those that were asked for
    files: Vec<PathBuf>,
    /// Why the first of them could not be saved
    failure: Option<CheckpointError>,
}

impl States<'_> {
    fn file(&self, label: &str) -> PathBuf {
        self.out.join(format!("{}-{label}.state", self.name))
    }

    fn save(&mut self, checkpoint: &Checkpoint, label: &str) {
        let file = self.file(label);
        match checkpoint.write(&file) {
            Ok(()) if label == PARTIAL => {}
            Ok(()) => self.files.push(file),
            Err(e) if label == PARTIAL => tell!("note: {e}"),
            Err(e) => self.failure = self.failure.take().or(Some(e)),
        }
    }

    /// A run that has ended by itself needs no state to go on from.
    fn end(&self, run: &Run) {
        if !matches!(run.status, Status::Interrupted { .. }) {
            std::fs::remove_file(self.file(PARTIAL)).ok();
        }
    }
}

/// The mesh of the scene, refined where it asks for it, and whether the error is within the tolerance then.
fn mesh(
    args: &Args,
    scene: (&Path, &SceneSpec, &str),
    name: &str,
    bars: &Bars,
) -> Result<(Arc<Body>, bool), Box<dyn std::error::Error>> {
    let (file, spec, _) = scene;
    let body = Arc::new(Body::load(file, &spec.mesh, &mut |line| bars.meshing(name, line))?);
    let Some(wanted) = &spec.mesh.refine else { return Ok((body, true)) };
    let (table, mut steps) = (args.out.join(format!("{name}.refinement.csv")), vec![]);
    let mut follow = |step: &RefinementStep| {
        if !args.json {
            print_refinement(step);
        }
        steps.push(step.clone());
        // The table is written again at the end, where a failure is an error
        _ = folder::write(&table, &csv_text::refinement(&steps));
    };
    let stop = interrupt::stop_flag();
    bars.started(name);
    let mut watch = RefinementWatch {
        step: &mut follow,
        mesher: &mut |line| bars.meshing(name, line),
        progress: &mut |progress| {
            bars.progress(name, progress);
            !stop.load(Ordering::Relaxed)
        },
        stop: Some(stop.clone()),
    };
    let found = refine(scene, wanted, body, None, &mut watch)?;
    folder::write(&table, &csv_text::refinement(&found.steps))?;
    let is_within = found.steps.last().is_some_and(RefinementStep::is_within);
    if !is_within {
        let lacks =
            if found.steps.iter().any(RefinementStep::lacks_surface) { ", or without curved facets," } else { "," };
        tell!(
            "not complete: the error bar is above the tolerance on every mesh{lacks} and smallest on that of {} cells, which is taken; allow more `meshes`, or \
             more tolerance",
            found.body.mesh.cell_count()
        );
    }
    Ok((found.body, is_within))
}

fn print_refinement(step: &RefinementStep) {
    let RefinementStep { cells, error, bar, tolerance, .. } = step;
    say!(
        "mesh of {cells} cells: {} = {}, error bar {}{} (tolerance {}), {}",
        error.column,
        five_digits(error.value),
        five_digits(*bar),
        if step.lacks_surface() { WITHOUT_FACETS } else { "" },
        five_digits(*tolerance),
        seconds(step.cpu)
    );
}

/// The recorder of the derivatives that are asked for, if there are any.
fn sensitivities<'a>(texts: &[String], scene: &'a Scene) -> Result<Option<SensitivityRecorder<'a>>, SensitivityError> {
    let keys: Vec<ParameterKey> = texts.iter().map(|text| text.parse()).collect::<Result<_, _>>()?;
    if keys.is_empty() { Ok(None) } else { SensitivityRecorder::new(scene, &keys).map(Some) }
}

/// The columns whose errors are asked for; none for all of them.
fn estimated_columns(args: &Args) -> &[String] {
    if args.error.iter().any(|column| column == "all") { &[] } else { &args.error }
}

/// The estimator of the errors that are asked for, if there are any.
fn estimator<'a>(args: &Args, scene: &'a Scene) -> Result<Option<ErrorEstimator<'a>>, EstimateError> {
    if args.error.is_empty() {
        return Ok(None);
    }
    let estimator = ErrorEstimator::new(scene)?;
    estimator.check_columns(estimated_columns(args))?;
    if args.error_cells { estimator.localised().map(Some) } else { Ok(Some(estimator)) }
}

/// Estimates the errors that are asked for, and writes them; none where the run or the enriched solution is not complete.
fn estimate(
    estimator: ErrorEstimator,
    args: &Args,
    name: &str,
    run: &Run,
    bars: &Bars,
) -> Result<Option<ErrorEstimate>, Box<dyn std::error::Error>> {
    if run.status != Status::Converged {
        return Ok(None);
    }
    bars.note(name, "the errors are estimated; Ctrl-C ends that, and the results of the run stay");
    let found = match estimator.estimate(run, estimated_columns(args)) {
        Err(why @ (EstimateError::NotSolved { .. } | EstimateError::Unstable { .. } | EstimateError::Stopped)) => {
            tell!("not complete: no error estimate: {why}");
            return Ok(None);
        }
        found => found?,
    };
    folder::write(&args.out.join(format!("{name}.errors.csv")), &csv_text::errors(&found))?;
    Ok(Some(found))
}

/// The words for an error bar without the error of geometry.
const WITHOUT_FACETS: &str = " (without curved facets, which are not estimated here)";

fn print_errors(found: &ErrorEstimate, record: &CaseRecord) {
    for volume in &found.missed_volumes {
        tell!(
            "warning: the error bars do not contain the error of the surface, since the mesh is too far from its surface or CAD ({volume}): the error may be \
             several times the bar; use more cells, or a smaller size"
        );
    }
    if found.enrichment == Enrichment::Split && record.locking.as_ref().is_some_and(|l| l.alarm) {
        tell!(
            "warning: the smaller cells by which the errors are estimated lock too: the error may be several times the bar"
        );
    }
    for q in &found.quantities {
        let (value, corrected, uncertainty) =
            (five_digits(q.value), five_digits(q.corrected), five_digits(q.uncertainty));
        let geometry = match q.geometry {
            Some(g) if g.change == 0.0 => String::new(),
            Some(g) => format!(" (of it {} by curved facets)", five_digits(g.change)),
            None => WITHOUT_FACETS.into(),
        };
        let extent = match (&found.cut_regions[..], q.extent) {
            ([], 0.0) => String::new(),
            ([], change) => format!(" (of it up to {} by the extent of regions)", five_digits(change.abs())),
            (regions, _) => format!(" (without the extent of {})", regions.join(", ")),
        };
        say!(
            "{:28} error bar {:>12} of {value:>12}; corrected {corrected} ± {uncertainty}{geometry}{extent}",
            q.column,
            five_digits(q.bar)
        );
    }
    let (cpu, dofs) = (seconds(found.cpu), found.dofs);
    let what = match found.solves {
        _ if found.whole_run => "a whole run".into(),
        1 => "1 solution".into(),
        solves => format!("{solves} solutions"),
    };
    say!("errors:  {what} with {dofs} equations in {cpu}");
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

/// Prints what a run found; `known` notes are printed before it.
fn print(record: &CaseRecord, known: usize) {
    record.notes[known..].iter().for_each(|note| tell!("note: {note}"));
    record.solver.energy_from_nothing.iter().for_each(|found| tell!("warning: {}", found.warning()));
    record.solver.collapsed_cavities.iter().for_each(|found| tell!("warning: {}", found.warning()));
    if let Some(l) = record.locking.as_ref().filter(|l| l.alarm) {
        let scatter = l.pressure_scatter;
        tell!("locking alarm: the pressures scatter by {scatter:.2} of the deviatoric stress; {REMEDY}");
    }
    let unresolved: Vec<String> = record
        .probes
        .keys()
        .filter_map(|probe| Some(format!("{probe} ({})", percent(record.unresolved(probe, 0.0)?))))
        .collect();
    if !unresolved.is_empty() {
        tell!(
            "warning: the time steps do not resolve the motion: one of them covers a large part of the range of {}; shorten them",
            few(&unresolved)
        );
    }
    for (probe, value) in &record.probes {
        let (peak, last) = (five_digits(value.peak), five_digits(without_rounding(value.last, value.peak)));
        match value.peak_is {
            ExtremeKind::Constant => say!("{probe:28} constant {peak:>12}"),
            kind => {
                say!("{probe:28} {:8} {peak:>12} at {:.3} s   final {last:>12}", kind.name(), Decimals(value.peak_t_s))
            }
        }
    }
    for e in &record.events {
        let value = e.value.map_or_else(String::new, |v| format!(" (at {})", five_digits(v)));
        say!("event {} at {:.4} s{value}: {}", e.event, Decimals(e.t_s), e.did.join(", "));
    }
    for d in &record.distances {
        let (l2, largest) = (100.0 * d.l2, 100.0 * d.largest);
        let inside = d.inside_words().map_or(String::new(), |words| format!(", {words}"));
        let compared = format!("{} points, {}", d.share_words(), d.range_words());
        let Distance { column, over, file, .. } = d;
        say!("{column} over {over} is off {file} by {l2:.2} % (L2), {largest:.2} % (largest) at {compared}{inside}");
    }
    record.markers.iter().for_each(|d| say!("{}", markers::words(d)));
    // Contacts that are solved for with multipliers have no counts.
    for c in record.contacts.iter().filter(|c| c.seen > 0) {
        say!(
            "contact {}: {} points, examined {} times in all, {} distances computed, {} active; search {}, collision detection {}",
            c.name,
            c.points,
            c.seen,
            c.tested,
            c.active,
            seconds(c.search_s),
            seconds(c.detection_s)
        );
    }
}

/// Says which columns have no derivative in some rows; the table has NaN there.
fn note_missing(run: &Run, sensitivities: &Sensitivities) {
    for (k, column) in sensitivities.columns.iter().enumerate() {
        let missing = |row: &&Vec<Vec<f64>>| row[k].iter().any(|d| d.is_nan());
        let count = sensitivities.rows.iter().filter(missing).count();
        if let Some(first) = sensitivities.rows.iter().position(|row| missing(&row)) {
            let t = run.rows[first][0];
            tell!("note: {column} has no derivative in {count} of {} rows, the first at t = {t} s", run.rows.len());
        }
    }
}

/// Says which keys change nothing, and which derivatives are not as accurate as they should be.
fn note_quality(sensitivities: &Sensitivities) {
    for key in sensitivities.idle() {
        tell!("warning: {key} changes nothing that is recorded: all derivatives by it are zero");
    }
    for (column, key, error) in sensitivities.doubtful() {
        tell!(
            "warning: the derivative of {column} by {key} has an estimated error of {:.1e} of its largest value: the scene is not smooth in \
             this key, as where a guide moves into another cell or a signal has a kink",
            error
        );
    }
}

/// How a run ended, with the error estimates that were asked for; an incomplete one says why.
fn completion(run: &Run, has_errors: bool) -> Outcome {
    if let Some(why) = &run.failure {
        tell!("not complete: {why}");
    }
    let stopped = run.sensitivities.as_ref().and_then(|s| s.stopped.as_ref());
    if let Some((t, why)) = stopped {
        tell!("not complete: no derivative at t = {t} s: {why}");
    }
    let complete = run.status == Status::Converged && stopped.is_none() && has_errors;
    if complete { Outcome::Complete } else { Outcome::RunIncomplete }
}

/// Times at which states are saved \[s\], and whether the last state is saved too.
fn times(when: &[String], scene: &Scene) -> Result<(Vec<f64>, bool), String> {
    let end = scene.spans.last().map_or(0.0, |s| s.end);
    let mut times = Vec::new();
    for text in when.iter().filter(|text| *text != "end") {
        let remedy = "write a time such as \"0.5 s\", or end";
        let t = units::parse(text, Dimension::TIME).map_err(|e| format!("--save-state: {e}; {remedy}"))?;
        if !(0.0..=end * (1.0 + 1e-9)).contains(&t) {
            return Err(format!("--save-state: the run is from 0 to {end} s and has no {text}; {remedy}"));
        }
        times.push(t);
    }
    Ok((times, when.iter().any(|text| text == "end")))
}

/// Zero for a value that is rounding next to the extreme of its column.
fn without_rounding(value: f64, extreme: f64) -> f64 {
    if value.abs() < ROUNDING * extreme.abs() { 0.0 } else { value }
}

/// Where the time went: every effect and constraint that is assembled, then the linear algebra.
fn costs(record: &CaseRecord) -> String {
    let share = |(name, s): (&str, f64)| format!("{name} {} ({:.0} %)", seconds(s), 100.0 * s / record.wall_s);
    let effects = record.effects.iter().map(|e| (e.name.as_str(), e.wall_s));
    let p = &record.phases;
    let sweeps = (p.contact_forces_s > 0.0).then_some(("contact forces", p.contact_forces_s));
    let all = effects.chain([("factorisation", p.factorisation_s), ("solve", p.solve_s)]).chain(sweeps);
    let (s, w) = (&record.solver, &record.work);
    let lost =
        if s.lost_iterations > 0 { format!(" and {} in refused attempts", s.lost_iterations) } else { String::new() };
    let shifted = if s.shifted_factorisations > 0 {
        format!(", {} of them of tangents shifted towards definiteness", s.shifted_factorisations)
    } else {
        String::new()
    };
    format!(
        "work: {} iterations{lost}, {} factorisations{shifted}\ntime: {} in all, of it {}",
        record.newton_iterations,
        w.factorisations,
        seconds(record.wall_s),
        all.map(share).collect::<Vec<_>>().join(", ")
    )
}
