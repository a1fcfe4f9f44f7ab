//! Coarse runs, element by element and size by size, as long as their share of the budget lasts.

use crate::math::cpu_clock::CpuClock;
use crate::math::linear::Factor;
use crate::mesh::generate::GenerateError;
use crate::scene::{
    Body, ErrorEstimator, RunOptions, Scene, SceneError, SceneSpec, Time, error_estimate::path_dependence, read_scene,
};
use crate::solve::Status;
use crate::study::plan::budget::Budget;
use crate::study::plan::error::PlanError;
use crate::study::plan::model::{Clock, Counted};
use crate::study::plan::request::{PlanWatch, Request};
use crate::study::plan::sizes::{Choice, Meshes};
use crate::study::run::one_run::one_run;
use crate::study::store::outcome::record;
use crate::study::store::record::{Series, StoredCase};
use crate::system::State;
use std::sync::Arc;
use std::time::Instant;
use toml::Value;

/// Meshes of one element that are run at most before anything is fitted.
const MOST: usize = 4;
/// Operations a second of a slow machine, to tell a hopeless first pilot before it begins.
const SLOW: f64 = 5e8;
/// Time of an error estimate from one run, over that of the steps that it solves again in the enriched space: a cautious guess.
const ENRICHED: f64 = 50.0;

/// The scene file with changes, and its text.
pub fn read(request: &Request, changes: &[(String, Value)]) -> Result<(SceneSpec, String), PlanError> {
    let all: Vec<_> = request.changes.iter().chain(changes).cloned().collect();
    Ok(read_scene(&request.file, &all)?)
}

/// A scene with changes, on its mesh, for which the mesher may take so long. A signal to stop ends the mesher too.
pub fn build(
    request: &Request,
    changes: &[(String, Value)],
    limit_s: f64,
    watch: &dyn PlanWatch,
) -> Result<Scene, PlanError> {
    let (spec, text) = read(request, changes)?;
    let mut mesh = spec.mesh.clone();
    let own_s = mesh.time_limit.map_or(f64::INFINITY, |limit| limit.0);
    if mesh.cells.is_some() {
        mesh.time_limit = Some(Time(own_s.min(limit_s.max(1e-3))));
    }
    let body = Body::load(&request.file, &mesh, &mut |line| watch.line(line));
    let body = body.map_err(|e| if request.is_stopped() { PlanError::Stopped } else { no_mesh(e, limit_s < own_s) })?;
    Ok(Scene::build(&request.file, spec, text, Arc::new(body))?)
}

/// Why there is no mesh. Where the mesher ran into a limit that the budget has set, the scene has no part in it.
fn no_mesh(error: SceneError, of_budget: bool) -> PlanError {
    let SceneError::Part { source, .. } = &error else { return error.into() };
    match source.downcast_ref::<GenerateError>() {
        Some(GenerateError::TimeLimit { seconds, .. }) if of_budget => PlanError::MeshLate { after_s: *seconds },
        _ => error.into(),
    }
}

/// Counts of a run of the scene, without running it.
pub fn count(scene: &Scene) -> Counted {
    // By the direct path, as the pilots go: the work of the iterative one is known after its set-up only.
    let factor = Factor::new(scene.system.pattern.clone());
    Counted {
        cells: scene.body.mesh.cell_count(),
        dofs: scene.system.dofs.free.len(),
        h_m: scene.body.mesh.h(),
        steps: scene.spans.iter().map(crate::solve::TimeSpan::steps).sum(),
        factor_nnz: factor.nnz(),
        factor_flops: factor.flops(),
    }
}

/// A run to be made, and how long it may take.
pub struct Trial<'a> {
    pub name: String,
    pub scene: &'a Scene,
    pub limit_s: f64,
    /// Columns whose errors are estimated from the run alone, if that fits into the limit as well
    pub estimated: &'a [String],
}

/// Runs a scene; none if it did not end within its limit. A run stopped by the user is an error; a stopped estimate leaves a run without
/// one. Whatever else happens is in the status of the record.
pub fn run(request: &Request, trial: Trial, watch: &dyn PlanWatch) -> Result<Option<StoredCase>, PlanError> {
    let Trial { name, scene, limit_s, estimated } = trial;
    watch.started(&name);
    let (wall, cpu) = (Instant::now(), CpuClock::start());
    let followed = || ErrorEstimator::new(scene).map(|e| e.stopped_by(request.stop.clone()));
    let mut estimator = (!estimated.is_empty()).then(followed);
    let mut states = |state: &State| {
        if let Some(Ok(estimator)) = &mut estimator {
            estimator.add(state);
        }
    };
    let mut go_on = |progress| {
        watch.progress(&name, progress);
        wall.elapsed().as_secs_f64() < limit_s
    };
    let options = RunOptions {
        on_progress: Some(&mut go_on),
        on_state: Some(&mut states),
        stop: Some(request.stop.clone()),
        ..RunOptions::default()
    };
    let run = scene.run_with(options);
    let times = (wall.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64());
    let mut record = record(scene, &run, times);
    record.id.clone_from(&name);
    let solved_again = if path_dependence(scene).is_some() { 1 } else { record.steps.max(1) };
    let fits = times.0 * (1.0 + ENRICHED / solved_again as f64) < limit_s;
    record.one_run = estimator.filter(|_| fits).map(|estimator| one_run(estimator, &run, estimated));
    watch.finished(&record);
    if matches!(run.status, Status::Interrupted { .. }) {
        return if request.is_stopped() { Err(PlanError::Stopped) } else { Ok(None) };
    }
    let column = |k: usize| run.rows.iter().map(|row| row[k]).collect();
    let columns = run.columns.iter().enumerate().skip(1).map(|(k, name)| (name.clone(), column(k))).collect();
    Ok(Some(StoredCase::new(record, Series { t_s: column(0), columns })))
}

/// Pilots of every choice, in the order of the choices, coarse ones first.
#[derive(Clone, Debug, Default)]
pub struct Pilots {
    /// \[choices\] converged runs, rising in cells
    pub of: Vec<Vec<StoredCase>>,
    /// (what, why) of those that could not be used
    pub lost: Vec<(String, String)>,
    pub cpu_s: f64,
    pub wall_s: f64,
}

impl Pilots {
    /// Time by the clock over CPU time, on this machine as busy as it is; at least 1.
    pub fn slowness(&self) -> f64 {
        if self.cpu_s > 0.0 { (self.wall_s / self.cpu_s).max(1.0) } else { 1.0 }
    }
}

/// Goes through the sizes, all elements at each, while what the next pilot is expected to take fits into its share of the budget. A signal
/// to stop ends it with the pilots that are complete.
pub fn run_all(
    request: &Request,
    (choices, meshes): (&[Choice], Meshes),
    quantities: &[String],
    budget: &Budget,
    watch: &dyn PlanWatch,
) -> Result<Pilots, PlanError> {
    let mut pilots = Pilots { of: vec![vec![]; choices.len()], ..Pilots::default() };
    let mut open: Vec<bool> = choices.iter().map(|_| true).collect();
    // The runs on a given mesh are what a plan chooses from: they may take more than those on coarse meshes.
    let left = || if meshes == Meshes::Given { budget.learning_s() } else { budget.pilots_s() };
    let estimated = if meshes == Meshes::Given { quantities } else { &[] };
    let levels = choices.iter().map(|c| c.sizes.len()).max().unwrap_or(0).max(1);
    for level in 0..levels {
        for (k, choice) in choices.iter().enumerate() {
            open[k] &= pilots.of[k].len() < MOST;
            let given = (meshes == Meshes::Given && level == 0).then_some(0);
            let Some(cells) = choice.sizes.get(level).copied().or(given).filter(|_| open[k]) else { continue };
            let name = choice.words(cells);
            let outcome = match pilot(request, (choice, cells), &pilots, &pilots.of[k], (&left, estimated), watch) {
                Err(PlanError::Stopped) => return Ok(pilots),
                outcome => outcome?,
            };
            match outcome {
                Pilot::Run(case) => {
                    pilots.cpu_s += case.record.cpu_s;
                    pilots.wall_s += case.record.wall_s;
                    match case.record.converged() {
                        true => pilots.of[k].push(*case),
                        false => {
                            let why = case.record.status_detail.clone().unwrap_or(case.record.status.clone());
                            pilots.lost.push((name, why));
                        }
                    }
                }
                Pilot::TooLong => {
                    open[k] = false;
                    if pilots.of[k].is_empty() {
                        pilots.lost.push((name, "it does not fit into its share of the budget".into()));
                    }
                }
                // The next size may have a mesh
                Pilot::Refused(why) if pilots.lost.iter().any(|(_, told)| *told == why) => {}
                Pilot::Refused(why) => pilots.lost.push((name, why)),
            }
        }
    }
    Ok(pilots)
}

/// The end of one pilot.
enum Pilot {
    Run(Box<StoredCase>),
    /// It was not begun, or stopped
    TooLong,
    /// There is no such scene: the reason
    Refused(String),
}

/// One pilot, unless it is expected to take longer than is left.
fn pilot(
    request: &Request,
    (choice, cells): (&Choice, u64),
    pilots: &Pilots,
    own: &[StoredCase],
    (left, estimated): (&dyn Fn() -> f64, &[String]),
    watch: &dyn PlanWatch,
) -> Result<Pilot, PlanError> {
    if request.is_stopped() {
        return Err(PlanError::Stopped);
    }
    // A pilot four times the size of the last takes no less than four times as long
    let last = own.last().map(|c| (c.record.mesh.cells as f64, c.record.wall_s));
    let least = last.map_or(0.0, |(n, s)| s * (cells as f64 / n).max(1.0));
    if least >= left() {
        return Ok(Pilot::TooLong);
    }
    let scene = match build(request, &choice.changes(cells), left(), watch) {
        Ok(scene) => scene,
        // The scene was built before: it is this element or size that does not fit it
        Err(e @ (PlanError::Scene(_) | PlanError::MeshLate { .. })) => return Ok(Pilot::Refused(e.to_string())),
        Err(e) => return Err(e),
    };
    let counted = count(&scene);
    let records: Vec<_> = own.iter().map(|c| &c.record).collect();
    let expected = match Clock::new(&records) {
        Some(clock) => clock.predict(&counted) * pilots.slowness(),
        None => counted.factor_flops / SLOW,
    };
    if expected > left() {
        return Ok(Pilot::TooLong);
    }
    let trial = Trial { name: choice.words(cells), scene: &scene, limit_s: left(), estimated };
    Ok(run(request, trial, watch)?.map_or(Pilot::TooLong, |case| Pilot::Run(Box::new(case))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Progress;
    use crate::study::store::record::CaseRecord;
    use std::path::{Path, PathBuf};
    use std::sync::atomic::{AtomicBool, Ordering};

    fn late() -> SceneError {
        let source =
            GenerateError::TimeLimit { seconds: 1.0692882160000003, remedy: "raise mesh.time_limit", lines: vec![] };
        SceneError::Part { file: "scene.toml".into(), place: "mesh".into(), source: Box::new(source) }
    }

    #[test]
    fn a_mesher_that_the_budget_ends_is_not_blamed_on_the_scene() {
        let words = no_mesh(late(), true).to_string();
        assert!(words.contains("after 1.1 s") && words.contains("raise --budget"), "{words}");
        assert!(!words.contains("time_limit"), "{words}");
        let own = no_mesh(late(), false).to_string();
        assert!(own.contains("raise mesh.time_limit"), "{own}");
        let other = SceneError::Part { file: "scene.toml".into(), place: "mesh".into(), source: "no such body".into() };
        assert!(no_mesh(other, true).to_string().contains("no such body"));
    }

    /// Sets the flag to stop as soon as a step of the run is complete.
    struct StopsAfterAStep<'a>(&'a AtomicBool);

    impl PlanWatch for StopsAfterAStep<'_> {
        fn line(&self, _: &str) {}
        fn started(&self, _: &str) {}
        fn progress(&self, _: &str, _: Progress) {
            self.0.store(true, Ordering::Relaxed);
        }
        fn finished(&self, _: &CaseRecord) {}
    }

    /// Follows nothing.
    struct Nobody;

    impl PlanWatch for Nobody {
        fn line(&self, _: &str) {}
        fn started(&self, _: &str) {}
        fn progress(&self, _: &str, _: Progress) {}
        fn finished(&self, _: &CaseRecord) {}
    }

    /// A bar that is stretched, as a scene file.
    fn bar(folder: &Path, steps: usize) -> PathBuf {
        let file = folder.join("scene.toml");
        let text = format!(
            r#"
[mesh]
grid = {{ kind = "box", size = ["40 mm", "10 mm", "10 mm"], divisions = [4, 1, 1] }}
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.45
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "prescribed"
region = "xmax"
components = "x"
displacement = {{ kind = "ramp", from = "0 mm", to = "0.5 mm", end = "1 s" }}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "{} s"
[[probe]]
kind = "reaction"
region = "xmax"
"#,
            1.0 / steps as f64
        );
        std::fs::write(&file, text).expect("writable");
        file
    }

    fn try_run(steps: usize, stop: &Arc<AtomicBool>, watch: &dyn PlanWatch) -> Result<Option<StoredCase>, PlanError> {
        let folder = tempfile::tempdir().expect("temporary folder");
        let (changes, quantities) = (vec![], vec!["xmax_reaction_x_N".to_string()]);
        let file = bar(folder.path(), steps);
        let request = Request { file, changes, tolerance: 0.01, budget_s: 60.0, quantities, stop };
        let scene = build(&request, &[], 60.0, &Nobody).expect("a sound scene");
        let trial = Trial { name: "bar".into(), scene: &scene, limit_s: f64::INFINITY, estimated: &request.quantities };
        run(&request, trial, watch)
    }

    #[test]
    fn a_stopped_estimate_ends_and_leaves_its_run() {
        let stop = Arc::new(AtomicBool::new(false));
        let whole = try_run(1, &stop, &Nobody).expect("not stopped").expect("no limit");
        assert!(whole.record.one_run.is_some_and(|found| found.refused.is_none() && !found.quantities.is_empty()));
        let case = try_run(1, &stop, &StopsAfterAStep(&stop)).expect("the run is complete").expect("no limit");
        assert!(case.record.converged());
        let found = case.record.one_run.expect("the reason");
        assert!(found.quantities.is_empty() && found.refused.is_some_and(|why| why.contains("stopped")));
    }

    #[test]
    fn a_stopped_run_is_an_error() {
        let stop = Arc::new(AtomicBool::new(false));
        assert!(matches!(try_run(20, &stop, &StopsAfterAStep(&stop)), Err(PlanError::Stopped)));
    }
}
