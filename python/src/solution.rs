//! A run of a scene from Python: its options, its controller, its derivatives, and the exception where it does not complete.

use crate::built::{Built, Done, Failed};
use crate::controller::{Foreign, callable};
use crate::error::{incomplete, input, refused};
use crate::run::{Recorded, Run};
use crate::solve::{Link, apart};
use durometer::math::threads;
use durometer::scene::control::Controller;
use durometer::scene::{ParameterKey, RunOptions, Sensitivities, SensitivityRecorder};
use durometer::solve::Status;
use pyo3::prelude::*;
use std::sync::Arc;

/// Options of a run, from Python.
pub struct Wanted<'a, 'py> {
    pub threads: Option<usize>,
    pub follower: Option<Bound<'py, PyAny>>,
    pub controller: Option<&'a Bound<'py, PyAny>>,
    pub fields: Option<Vec<String>>,
    pub keys: Vec<ParameterKey>,
}

/// Runs all stages. `check` raises an exception where the run does not complete.
pub fn solve(
    py: Python<'_>,
    built: Built,
    wanted: Wanted<'_, '_>,
    check: bool,
) -> PyResult<(Run, Option<Sensitivities>)> {
    let foreign = callable(wanted.controller)?;
    check_control(&built.scene, foreign.is_some())?;
    let mut recorded = Recorded::new(&built.scene, wanted.fields)?;
    threads::use_threads(wanted.threads.unwrap_or_else(threads::available).max(1));
    let keys = &wanted.keys;
    let mut done = apart(py, wanted.follower.as_ref(), |link| run(&built, foreign, keys, &mut recorded, link))?
        .map_err(|e| refused(e as Box<dyn std::error::Error>))?;
    let (status, failure) = (done.run.status.clone(), done.run.failure.take());
    let sensitivities = done.run.sensitivities.take();
    let run = Run::new(py, built, done, recorded)?;
    if let Some(why) = failure {
        return Err(refused(why));
    }
    if check && status != Status::Converged {
        let result = Py::new(py, run)?.into_any();
        return Err(incomplete(status.name(), &in_words(&status), status.remedy(), result));
    }
    Ok((run, sensitivities))
}

/// A status in words, with its time.
fn in_words(status: &Status) -> String {
    status.t().map_or_else(|| status.fact(), |t| format!("after t = {t:.6} s: {}", status.fact()))
}

fn run(
    built: &Built,
    mut foreign: Option<Foreign>,
    keys: &[ParameterKey],
    recorded: &mut Recorded,
    link: &Arc<Link>,
) -> Result<Done, Failed> {
    let scene = &*built.scene;
    let sensitivities = (!keys.is_empty()).then(|| SensitivityRecorder::new(scene, keys)).transpose()?;
    foreign.iter_mut().for_each(|foreign| foreign.link = Some(link.clone()));
    let mut progress = |now| link.progress(now);
    let mut state = |state: &durometer::system::State| recorded.add(scene, state);
    let options = RunOptions {
        on_progress: Some(&mut progress),
        on_state: Some(&mut state),
        stop: Some(link.stop.clone()),
        controller: foreign.as_mut().map(|c| c as &mut dyn Controller),
        sensitivities,
        ..RunOptions::default()
    };
    let (wall, cpu) = (std::time::Instant::now(), threads::CpuClock::start());
    let run = built.raised.during(link, || scene.run_with(options));
    Ok(Done { run, seconds: (wall.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64()) })
}

fn check_control(scene: &durometer::scene::Scene, is_given: bool) -> PyResult<()> {
    match (scene.controls.controlled().first(), is_given) {
        (None, true) => {
            let remedy = "drive something by { kind = \"controlled\", initial = \"0 mm\" }";
            Err(input("the scene leaves no signal to a controller", remedy))
        }
        (Some(name), false) => {
            Err(input(&format!("the signal {name} waits for a controller"), "give a function as `controller`"))
        }
        _ => Ok(()),
    }
}
