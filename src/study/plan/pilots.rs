//! Coarse runs, element by element and size by size, as long as their share of the budget lasts: first two of each element, then a third of those whose
//! two agree best.

use crate::math::linear::Factor;
use crate::math::stopwatch::Stopwatch;
use crate::mesh::generate::GenerateError;
use crate::scene::{
    Body, ErrorEstimator, RunOptions, Scene, SceneError, SceneSpec, Time, error_estimate::path_dependence, read_scene,
};
use crate::solve::Status;
use crate::study::curve::peak;
use crate::study::plan::budget::Budget;
use crate::study::plan::error::PlanError;
use crate::study::plan::model::{Clock, Counted, LEAST_PILOTS};
use crate::study::plan::request::{PlanWatch, Request};
use crate::study::plan::sizes::{ElementMeshes, Meshes};
use crate::study::run::one_run::one_run;
use crate::study::store::finished_run::record;
use crate::study::store::record::{Series, StoredCase};
use crate::system::State;
use std::sync::Arc;
use toml::Value;

/// Largest number of meshes of one element that are run before anything is fitted.
const MOST: usize = 4;
/// Speed of a slow machine, to reject a hopeless first pilot before it starts \[flop/s\].
const SLOW: f64 = 5e8;
/// Time of an error estimate from one run relative to the steps that it solves again in the enriched space: a cautious guess \[–\].
const ENRICHED: f64 = 50.0;

/// Reads the scene file with changes, and its text.
pub fn read(request: &Request, changes: &[(String, Value)]) -> Result<(SceneSpec, String), PlanError> {
    let all: Vec<_> = request.changes.iter().chain(changes).cloned().collect();
    Ok(read_scene(&request.file, &all)?)
}

/// Builds a scene with changes on its mesh; the mesher may take at most `limit_s`. A signal to stop also ends the mesher.
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

/// The reason why there is no mesh. If the mesher reached a limit set by the budget, the scene is not to blame.
fn no_mesh(error: SceneError, of_budget: bool) -> PlanError {
    match of_mesher(&error) {
        Some(GenerateError::TimeLimit { seconds, .. }) if of_budget => PlanError::MeshLate { after_s: *seconds },
        _ => error.into(),
    }
}

/// The error of the mesher within an error, if there is one.
fn of_mesher(error: &SceneError) -> Option<&GenerateError> {
    let SceneError::Part { source, .. } = error else { return None };
    source.downcast_ref()
}

fn is_of_mesher(error: &PlanError) -> bool {
    match error {
        PlanError::Scene(e) => of_mesher(e).is_some(),
        _ => matches!(error, PlanError::MeshLate { .. }),
    }
}

/// Counts the work of a run of the scene without running it.
pub fn count(scene: &Scene) -> Counted {
    // By the direct path, which the pilots use: the work of the iterative one is known only after its set-up
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

/// A run to make, with its time limit.
pub struct Trial<'a> {
    pub name: String,
    pub scene: &'a Scene,
    pub limit_s: f64,
    /// Columns whose errors are estimated from the run alone, if that also fits into the limit
    pub estimated: &'a [String],
}

/// Runs a scene; `None` if it did not end within its limit. A run stopped by the user is an error; if only the estimate is stopped, the run has none.
/// Any other outcome is in the status of the record.
pub fn run(request: &Request, trial: Trial, watch: &dyn PlanWatch) -> Result<Option<StoredCase>, PlanError> {
    let Trial { name, scene, limit_s, estimated } = trial;
    watch.started(&name);
    let stopwatch = Stopwatch::start();
    let followed = || ErrorEstimator::new(scene).map(|e| e.stopped_by(request.stop.clone()));
    let mut estimator = (!estimated.is_empty()).then(followed);
    let mut states = |state: &State| {
        if let Some(Ok(estimator)) = &mut estimator {
            estimator.add(state);
        }
    };
    let mut go_on = |progress| {
        watch.progress(&name, progress);
        stopwatch.spent().wall_s < limit_s
    };
    let options = RunOptions {
        on_progress: Some(&mut go_on),
        on_state: Some(&mut states),
        stop: Some(request.stop.clone()),
        ..RunOptions::default()
    };
    let run = scene.run_with(options);
    let spent = stopwatch.spent();
    let mut record = record(scene, &run, spent);
    record.id.clone_from(&name);
    let solved_again = if path_dependence(scene).is_some() { 1 } else { record.steps.max(1) };
    let fits = spent.wall_s * (1.0 + ENRICHED / solved_again as f64) < limit_s;
    record.one_run = estimator.filter(|_| fits).map(|estimator| one_run(estimator, &run, estimated));
    watch.finished(&record);
    if matches!(run.status, Status::Interrupted { .. }) {
        return if request.is_stopped() { Err(PlanError::Stopped) } else { Ok(None) };
    }
    let column = |k: usize| run.rows.iter().map(|row| row[k]).collect();
    let columns = run.columns.iter().enumerate().skip(1).map(|(k, name)| (name.clone(), column(k))).collect();
    Ok(Some(StoredCase::new(record, Series { t_s: column(0), columns })))
}

/// Pilots of every choice, in the order of the choices, coarsest first.
#[derive(Clone, Debug, Default)]
pub struct Pilots {
    /// \[choices\] Converged runs, in order of increasing cells
    pub of: Vec<Vec<StoredCase>>,
    /// \[choices\] Distinct reasons why there is no such scene
    pub refused: Vec<Vec<String>>,
    /// Pilots that could not be used: (name, reason)
    pub lost: Vec<(String, String)>,
    pub cpu_s: f64,
    pub wall_s: f64,
}

impl Pilots {
    /// Ratio of wall to CPU time on this machine under its present load; at least 1.
    pub fn slowness(&self) -> f64 {
        if self.cpu_s > 0.0 { (self.wall_s / self.cpu_s).max(1.0) } else { 1.0 }
    }

    /// Returns an empty set of pilots for this number of choices.
    fn none_of(choices: usize) -> Self {
        Self { of: vec![vec![]; choices], refused: vec![vec![]; choices], ..Self::default() }
    }

    /// Records the outcome of a pilot of choice `k`. Returns whether its next size is worth a trial: not if there is no time for it, nor if two sizes
    /// have no scene for the same reason.
    fn add(&mut self, k: usize, name: String, outcome: Pilot) -> bool {
        match outcome {
            Pilot::Run(case) => {
                self.cpu_s += case.record.cpu_s;
                self.wall_s += case.record.wall_s;
                match case.record.converged() {
                    true => self.of[k].push(*case),
                    false => {
                        let why = case.record.status_detail.clone().unwrap_or(case.record.status.clone());
                        self.lost.push((name, why));
                    }
                }
            }
            Pilot::TooLong => {
                if self.of[k].is_empty() {
                    self.lost.push((name, "it does not fit into its share of the budget".into()));
                }
                return false;
            }
            Pilot::Refused { why, by_mesher } if self.refused[k].contains(&why) => return by_mesher,
            Pilot::Refused { why, .. } => {
                self.refused[k].push(why.clone());
                self.lost.push((name, why));
            }
        }
        true
    }
}

/// The next size of an element, and whether it may still run.
#[derive(Clone, Copy)]
struct Turn {
    level: usize,
    is_open: bool,
}

impl Turn {
    /// Its rank among the turns of all elements; the lowest runs first: two pilots of each, size by size; then a third of those whose two finest agree
    /// best; then size by size again.
    fn rank(self, own: &[StoredCase], quantities: &[String]) -> (u8, f64) {
        let level = self.level as f64;
        match own.len() + 1 {
            _ if self.level + 1 < LEAST_PILOTS => (0, level),
            LEAST_PILOTS => (1, difference(own, quantities).unwrap_or(f64::INFINITY)),
            _ => (2, level),
        }
    }
}

/// The largest relative change of a peak between the last two pilots \[–\].
pub fn difference(own: &[StoredCase], quantities: &[String]) -> Option<f64> {
    let [.., coarse, fine] = own else { return None };
    let change = |q: &String| Some((peak(coarse, q)? / peak(fine, q)? - 1.0).abs()).filter(|change| change.is_finite());
    quantities.iter().map(change).try_fold(0.0, |most: f64, change| Some(most.max(change?)))
}

/// Runs pilots, one element after another, as long as the expected time of the next one fits into its share of the budget. Until an element has three
/// pilots, its third may also use the share for learning. A signal to stop ends it with the complete pilots.
pub fn run_all(
    request: &Request,
    (choices, meshes): (&[ElementMeshes], Meshes),
    quantities: &[String],
    budget: &Budget,
    watch: &dyn PlanWatch,
) -> Result<Pilots, PlanError> {
    let mut pilots = Pilots::none_of(choices.len());
    let mut turns = vec![Turn { level: 0, is_open: true }; choices.len()];
    let estimated = if meshes == Meshes::Given { quantities } else { &[] };
    let size = |k: usize, level: usize| match meshes {
        Meshes::Given => (level == 0).then_some(0),
        _ => choices[k].sizes.get(level).copied(),
    };
    loop {
        let is_open = |k: &usize| turns[*k].is_open && pilots.of[*k].len() < MOST;
        let ranked = (0..choices.len())
            .filter(is_open)
            .filter_map(|k| Some((turns[k].rank(&pilots.of[k], quantities), k, size(k, turns[k].level)?)));
        let first = ranked.min_by(|a, b| a.0.0.cmp(&b.0.0).then(a.0.1.total_cmp(&b.0.1)));
        let Some(((rank, _), k, cells)) = first else { return Ok(pilots) };
        let decides = rank == 1 && pilots.of.iter().all(|own| own.len() < LEAST_PILOTS);
        // On a given mesh the plan chooses among these very runs: they may take longer than those on coarse meshes
        let left = || if meshes == Meshes::Given || decides { budget.learning_s() } else { budget.pilots_s() };
        let outcome = match pilot(request, (&choices[k], cells), &pilots, &pilots.of[k], (&left, estimated), watch) {
            Err(PlanError::Stopped) => return Ok(pilots),
            outcome => outcome?,
        };
        turns[k].level += 1;
        turns[k].is_open = pilots.add(k, choices[k].words(cells), outcome);
    }
}

/// The outcome of one pilot.
enum Pilot {
    Run(Box<StoredCase>),
    /// It was not started, or was stopped
    TooLong,
    /// There is no such scene: the reason, and whether the mesher is the cause, which another size may avoid
    Refused {
        why: String,
        by_mesher: bool,
    },
}

/// Makes one pilot, unless it is expected to take longer than the remaining time.
fn pilot(
    request: &Request,
    (choice, cells): (&ElementMeshes, u64),
    pilots: &Pilots,
    own: &[StoredCase],
    (left, estimated): (&dyn Fn() -> f64, &[String]),
    watch: &dyn PlanWatch,
) -> Result<Pilot, PlanError> {
    if request.is_stopped() {
        return Err(PlanError::Stopped);
    }
    // A pilot of four times the size takes at least four times as long
    let last = own.last().map(|c| (c.record.mesh.cells as f64, c.record.wall_s));
    let least = last.map_or(0.0, |(n, s)| s * (cells as f64 / n).max(1.0));
    if least >= left() {
        return Ok(Pilot::TooLong);
    }
    let scene = match build(request, &choice.changes(cells), left(), watch) {
        Ok(scene) => scene,
        // The scene has been built before, so that this element or size is what does not fit it
        Err(e @ (PlanError::Scene(_) | PlanError::MeshLate { .. })) => {
            return Ok(Pilot::Refused { why: e.to_string(), by_mesher: is_of_mesher(&e) });
        }
        Err(e) => return Err(e),
    };
    let counted = count(&scene);
    if expected(&counted, own, pilots.slowness()) > left() {
        return Ok(Pilot::TooLong);
    }
    let trial = Trial { name: choice.words(cells), scene: &scene, limit_s: left(), estimated };
    Ok(run(request, trial, watch)?.map_or(Pilot::TooLong, |case| Pilot::Run(Box::new(case))))
}

/// Expected wall time of a pilot from the earlier ones of its element \[s\]. After a single one, the time of the factorisation is scaled with the
/// operations, and the rest with the cells.
fn expected(counted: &Counted, own: &[StoredCase], slowness: f64) -> f64 {
    let records: Vec<_> = own.iter().map(|c| &c.record).collect();
    if let Some(clock) = Clock::new(&records) {
        return clock.predict(counted) * slowness;
    }
    let by_last = own.last().map_or(f64::INFINITY, |StoredCase { record: last, .. }| {
        let factorisation = last.phases.factorisation_s.min(last.wall_s);
        (last.wall_s - factorisation) * counted.cells as f64 / last.mesh.cells as f64
            + factorisation * counted.factor_flops / last.work.factor_flops.max(1.0)
    });
    by_last.min(counted.factor_flops / SLOW)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Progress;
    use crate::study::store::record::CaseRecord;
    use std::path::{Path, PathBuf};
    use std::sync::atomic::{AtomicBool, Ordering};

    /// Returns a run with this peak.
    fn run_of(f: f64) -> StoredCase {
        let columns = [("angle".to_string(), vec![0.0, f])].into();
        StoredCase::new(CaseRecord::default(), Series { t_s: vec![0.0, 1.0], columns })
    }

    /// Linear elements whose pilots are far apart do not use up the time for a third one of a quadratic element whose two agree.
    #[test]
    fn elements_whose_pilots_agree_best_have_their_third_first() {
        let quantities = ["angle".to_string()];
        let rank = |level: usize, peaks: &[f64]| {
            let own: Vec<StoredCase> = peaks.iter().map(|f| run_of(*f)).collect();
            Turn { level, is_open: true }.rank(&own, &quantities)
        };
        let [second, linear, quadratic] = [rank(1, &[7.39]), rank(2, &[3.78, 5.92]), rank(2, &[7.39, 7.52])];
        assert!(second < quadratic && quadratic < linear && linear < rank(3, &[2.7, 4.9, 6.0]), "{quadratic:?}");
        assert!(rank(0, &[]) < second && linear < rank(2, &[0.0, 0.0]), "peaks of zero agree in nothing");
        // One of its two sizes could not be run
        assert_eq!(rank(2, &[7.39]), (2, 2.0));
    }

    /// An element that the law does not support is reported once, and no further size of it is meshed; a mesh that fails may succeed at another size.
    #[test]
    fn an_element_that_is_refused_twice_for_one_reason_is_closed() {
        let mut pilots = Pilots::none_of(2);
        let mut refused = |k: usize, why: &str, by_mesher| {
            pilots.add(k, format!("{k}"), Pilot::Refused { why: why.into(), by_mesher })
        };
        assert_eq!([0; 2].map(|k| refused(k, "no such law", false)), [true, false]);
        assert_eq!([1; 3].map(|k| refused(k, "facets overlap", true)), [true; 3]);
        assert_eq!(pilots.lost.len(), 2);
        assert!(!pilots.add(1, "1".into(), Pilot::TooLong));
    }

    /// A mesh with 8 times the cells and 64 times the operations of a run of 0.1 s, of which 0.02 s are for the factorisation.
    #[test]
    fn a_second_pilot_is_expected_by_the_first() {
        let mut first = run_of(1.0);
        (first.record.mesh.cells, first.record.wall_s) = (252, 0.1);
        (first.record.phases.factorisation_s, first.record.work.factor_flops) = (0.02, 4e7);
        let counted = Counted { cells: 2016, dofs: 0, h_m: 1e-3, steps: 1, factor_nnz: 0, factor_flops: 64.0 * 4e7 };
        assert!((expected(&counted, &[first], 3.0) - (0.64 + 1.28)).abs() < 1e-12);
        assert!((expected(&counted, &[], 3.0) - 64.0 * 4e7 / SLOW).abs() < 1e-12);
    }

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

    /// Sets the stop flag as soon as a step of the run is complete.
    struct StopsAfterAStep<'a>(&'a AtomicBool);

    impl PlanWatch for StopsAfterAStep<'_> {
        fn line(&self, _: &str) {}
        fn started(&self, _: &str) {}
        fn progress(&self, _: &str, _: Progress) {
            self.0.store(true, Ordering::Relaxed);
        }
        fn finished(&self, _: &CaseRecord) {}
    }

    /// An observer that ignores everything.
    struct Nobody;

    impl PlanWatch for Nobody {
        fn line(&self, _: &str) {}
        fn started(&self, _: &str) {}
        fn progress(&self, _: &str, _: Progress) {}
        fn finished(&self, _: &CaseRecord) {}
    }

    /// Writes the scene file of a bar that is stretched.
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
