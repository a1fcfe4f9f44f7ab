//! Coarse runs, element by element and size by size, as long as their share of the budget lasts.

use crate::math::linear::Factor;
use crate::scene::{Body, RunOptions, Scene, read_scene};
use crate::solve::Status;
use crate::study::outcome::record;
use crate::study::plan::error::PlanError;
use crate::study::plan::model::{Clock, Counted};
use crate::study::plan::request::{PlanWatch, Request};
use crate::study::plan::sizes::Choice;
use crate::study::record::{Series, StoredCase};
use cpu_time::ThreadTime;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;
use toml::Value;

/// Meshes of one element that are run at most before anything is fitted.
const MOST: usize = 4;

/// A scene with changes, on its mesh.
pub fn build(request: &Request, changes: &[(String, Value)], watch: &dyn PlanWatch) -> Result<Scene, PlanError> {
    let all: Vec<_> = request.changes.iter().chain(changes).cloned().collect();
    let (spec, text) = read_scene(&request.file, &all)?;
    let body = Body::load(&request.file, &spec.mesh, &mut |line| watch.line(line))?;
    Ok(Scene::build(&request.file, spec, text, Arc::new(body))?)
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

/// Runs a scene. Stopped by the user is an error; whatever else happens is in the status of the record.
pub fn run(request: &Request, name: &str, scene: &Scene, watch: &dyn PlanWatch) -> Result<StoredCase, PlanError> {
    watch.started(name);
    let (wall, cpu) = (Instant::now(), ThreadTime::now());
    let mut go_on = |progress| {
        watch.progress(name, progress);
        !request.stop.load(Ordering::Relaxed)
    };
    let run = scene.run_with(RunOptions { on_progress: Some(&mut go_on), ..RunOptions::default() });
    let times = (wall.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64());
    if matches!(run.status, Status::Interrupted { .. }) {
        return Err(PlanError::Stopped);
    }
    let mut record = record(scene, &run, times);
    record.id = name.into();
    let column = |k: usize| run.rows.iter().map(|row| row[k]).collect();
    let columns = run.columns.iter().enumerate().skip(1).map(|(k, name)| (name.clone(), column(k))).collect();
    watch.finished(&record);
    Ok(StoredCase { series: Series { t_s: column(0), columns }, record })
}

/// Pilots of every choice, in the order of the choices, coarse ones first.
#[derive(Clone, Debug, Default)]
pub struct Pilots {
    /// \[choices\] converged runs, rising in cells
    pub of: Vec<Vec<StoredCase>>,
    /// (what, why) of those that could not be used
    pub lost: Vec<(String, String)>,
    pub cpu_s: f64,
}

/// Goes through the sizes, all elements at each, while what the next pilot is expected to take fits into `share_s`.
pub fn run_all(
    request: &Request,
    choices: &[Choice],
    share_s: f64,
    watch: &dyn PlanWatch,
) -> Result<Pilots, PlanError> {
    let mut pilots = Pilots { of: vec![vec![]; choices.len()], ..Pilots::default() };
    let mut open: Vec<bool> = choices.iter().map(|_| true).collect();
    for level in 0..MOST {
        for (k, choice) in choices.iter().enumerate() {
            let Some(&cells) = choice.sizes.get(level).filter(|_| open[k]) else { continue };
            // A pilot four times the size of the last takes no less than four times as long
            let last = pilots.of[k].last().map(|c| (c.record.mesh.cells as f64, c.record.cpu_s));
            let least = last.map_or(0.0, |(n, s)| s * (cells as f64 / n).max(1.0));
            if pilots.cpu_s + least > share_s {
                open[k] = false;
                continue;
            }
            let name = format!("{}, {cells} cells", choice.name);
            let scene = match build(request, &choice.changes(cells), watch) {
                Ok(scene) => scene,
                // The unchanged scene was built before: it is this element that does not fit it
                Err(PlanError::Scene(e)) => {
                    pilots.lost.push((choice.name.clone(), e.to_string()));
                    open[k] = false;
                    continue;
                }
                Err(e) => return Err(e),
            };
            let own: Vec<_> = pilots.of[k].iter().map(|c| &c.record).collect();
            let expected = Clock::new(&own).map(|clock| clock.predict(&count(&scene)));
            if expected.is_some_and(|s| pilots.cpu_s + s > share_s) {
                open[k] = false;
                continue;
            }
            let case = run(request, &name, &scene, watch)?;
            pilots.cpu_s += case.record.cpu_s;
            match case.record.converged() {
                true => pilots.of[k].push(case),
                false => {
                    let why = case.record.status_detail.clone().unwrap_or(case.record.status.clone());
                    pilots.lost.push((name, why));
                }
            }
        }
    }
    Ok(pilots)
}
