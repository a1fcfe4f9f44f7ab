//! A run of a scene from Python: its options, its controller, its derivatives, and the exception if it does not complete.

use crate::built::{Built, Done, Failed};
use crate::controller::{Foreign, callable};
use crate::error::{incomplete, input, refused, split, with_result};
use crate::run::{Recorded, Run};
use crate::solve::{Link, ended};
use durometer::math::stopwatch::{Spent, Stopwatch};
use durometer::scene::control::{ControlError, Controller};
use durometer::scene::{ParameterKey, RunOptions, Sensitivities, SensitivityRecorder};
use durometer::solve::Status;
use durometer::study::store::finished_run;
use pyo3::prelude::*;
use std::sync::Arc;

/// Options of a run, from Python.
pub struct Wanted<'a, 'py> {
    pub follower: Option<Bound<'py, PyAny>>,
    pub controller: Option<&'a Bound<'py, PyAny>>,
    pub fields: Option<&'a Bound<'py, PyAny>>,
    pub keys: Vec<ParameterKey>,
}

/// Runs all stages. With `check` an exception is raised if the run does not complete, or if its refined mesh misses the tolerance. Any other exception
/// that ends it has the run so far in `result`.
pub fn solve(
    py: Python<'_>,
    built: Built,
    wanted: Wanted<'_, '_>,
    check: bool,
) -> PyResult<(Py<Run>, Option<Sensitivities>)> {
    let foreign = callable(wanted.controller)?;
    check_control(&built.scene, foreign.is_some())?;
    let mut recorded = Recorded::new(&built.scene, wanted.fields)?;
    let keys = &wanted.keys;
    let work = |link: &Arc<Link>| run(&built, foreign, keys, &mut recorded, link);
    let mut done = match ended(py, Link::default(), wanted.follower.as_ref(), work)? {
        (Ok(done), None) => done,
        (Ok(done), Some(why)) => {
            let run = Py::new(py, Run::new(py, built, done, recorded, None)?)?;
            return Err(with_result(py, why, run.into_any()));
        }
        (Err(_), Some(why)) => return Err(why),
        (Err(why), None) => return Err(refused(why as Box<dyn std::error::Error>)),
    };
    let (status, failure) = (done.run.status.clone(), done.run.failure.take());
    let sensitivities = done.run.sensitivities.take();
    let missed = built.missed.clone();
    let outside = failure.map(|why| in_python(&why, &built.scene));
    let run = Py::new(py, Run::new(py, built, done, recorded, outside.clone())?)?;
    if check && status != Status::Converged {
        let (fact, remedy) = outside.unwrap_or_else(|| (in_words(&status), status.remedy().into()));
        return Err(incomplete(status.name(), &fact, &remedy, run.into_any()));
    }
    if let Some(missed) = missed.filter(|_| check) {
        let (fact, remedy) = split(&missed);
        return Err(incomplete("ToleranceMissed", fact, remedy, run.into_any()));
    }
    Ok((run, sensitivities))
}

/// Returns fact and remedy of an error of signals or a controller that ended a run.
fn in_python(why: &ControlError, scene: &durometer::scene::Scene) -> (String, String) {
    let text = why.to_string();
    let (fact, remedy) = split(&text);
    let is_set = |signal| scene.controls.controlled().contains(signal);
    match why {
        ControlError::NotFinite { signal, .. } if is_set(signal) => {
            (fact.into(), "let the controller return finite numbers".into())
        }
        _ => (fact.into(), remedy.into()),
    }
}

/// Describes a status, with its time.
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
    foreign.iter_mut().for_each(|foreign| foreign.link = Some(link.clone()));
    built.during(link, |scene| {
        let sensitivities = (!keys.is_empty()).then(|| SensitivityRecorder::new(scene, keys)).transpose()?;
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
        let stopwatch = Stopwatch::start();
        let run = scene.run_with(options);
        let spent = stopwatch.spent();
        let elsewhere = recorded.spent + foreign.map_or(Spent::default(), |foreign| foreign.spent);
        let mut record = finished_run::record(scene, &run, run.own_time(spent, elsewhere));
        record.phases.build_s = built.build_s;
        Ok(Done { record: record.into(), run })
    })?
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
