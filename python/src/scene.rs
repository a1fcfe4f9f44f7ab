//! The class `Scene`: the text of a scene with its changes, and what can be done with it.

use crate::controller::{Foreign, callable};
use crate::error::{incomplete, input, refused};
use crate::law;
use crate::run::{Recorded, Run};
use crate::sensitivities::Sensitivities;
use crate::solve::{Link, apart};
use crate::value::{plain, toml_of};
use durometer::math::threads;
use durometer::scene::control::Controller;
use durometer::scene::{
    Body, ParameterKey, RefinementWatch, RunOptions, SceneSpec, SensitivityRecorder, changed_scene, overrides,
    read_table, refine,
};
use durometer::solve::Status;
use pyo3::prelude::*;
use pyo3::types::PyString;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use toml::{Table, Value};

/// A simulation: the text of a scene, with changes.
///
/// >>> import durometer
/// >>> scene = durometer.Scene.from_toml('''
/// ... [mesh]
/// ... grid = { kind = "box", size = ["20 mm", "10 mm", "10 mm"], divisions = [4, 2, 2] }
/// ... [laws.silicone]
/// ... law = "neo_hookean"
/// ... E = "100 kPa"
/// ... nu = 0.45
/// ... [[effect]]
/// ... kind = "elastic"
/// ... region = "body"
/// ... law = "silicone"
/// ... [[effect]]
/// ... kind = "gravity"
/// ... region = "body"
/// ... density = "1070 kg/m^3"
/// ... direction = [0, 0, -1]
/// ... acceleration = "9.81 m/s^2"
/// ... [[constraint]]
/// ... kind = "fixed"
/// ... region = "xmin"
/// ... [[stage]]
/// ... integrator = "static"
/// ... duration = "1 s"
/// ... dt = "1 s"
/// ... [[probe]]
/// ... kind = "position"
/// ... region = "xmax"
/// ... ''')
/// >>> run = scene.run()
/// >>> run.status
/// 'Converged'
/// >>> softer = scene.set("laws.silicone.E", "50 kPa").run()
/// >>> bool(softer["xmax_z_m"][-1] < run["xmax_z_m"][-1])
/// True
#[pyclass(module = "durometer", frozen)]
pub struct Scene {
    file: PathBuf,
    /// With the changes in it
    table: Table,
    built: Mutex<Option<Built>>,
}

/// A scene on its mesh, and the exceptions of its laws in Python.
#[derive(Clone)]
pub struct Built {
    pub scene: Arc<durometer::scene::Scene>,
    pub raised: Arc<law::Raised>,
}

#[pymethods]
impl Scene {
    /// The scene of a file, or of a text in TOML, which has several lines. Files that a text names are found from the current folder.
    #[staticmethod]
    #[pyo3(signature = (source))]
    fn from_toml(source: &Bound<'_, PyAny>) -> PyResult<Self> {
        let text = source.cast::<PyString>().ok().map(|text| text.to_string()).filter(|text| text.contains('\n'));
        let (file, text) = match text {
            Some(text) => (PathBuf::from("scene.toml"), text),
            None => {
                let file = crate::cli::files::find(&source.extract::<PathBuf>()?, "scene.toml").map_err(refused)?;
                let (text, _) = read_table(&file).map_err(refused)?;
                (file, text)
            }
        };
        let (_, text) = changed_scene(&file, &text, &[]).map_err(refused)?;
        Self::of(file, text.parse().map_err(|e: toml::de::Error| refused(e.to_string()))?)
    }

    /// The same scene with another value of a key, such as `set("laws.rubber.mu", "30 kPa")`. A step into a list is its index, or the `name` or
    /// `kind` of an entry; the step `+` adds an entry.
    fn set(&self, key: &str, value: &Bound<'_, PyAny>) -> PyResult<Self> {
        self.changed(key, toml_of(value)?)
    }

    /// The value of a key as the text has it.
    fn get<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        plain(py, overrides::find(&self.table, key).map_err(refused)?)
    }

    /// The scene as TOML, with its changes and with what it includes.
    #[getter]
    fn text(&self) -> String {
        toml::to_string(&self.table).unwrap_or_default()
    }

    /// Names of the columns that a run records.
    #[getter]
    fn columns(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        Ok(self.build(py, None)?.scene.columns())
    }

    /// Names of the signals that a controller sets.
    #[getter]
    fn controlled(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        Ok(self.build(py, None)?.scene.controls.controlled())
    }

    /// Notes and warnings on the scene.
    #[getter]
    fn notes(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        Ok(self.build(py, None)?.scene.notes.clone())
    }

    /// Runs all stages; the interpreter is free meanwhile, and Ctrl-C ends the run.
    ///
    /// `threads`: those that it may use, all by default; no result depends on it.
    /// `progress`: True, or a function that is called with the time that is done and the end \[s\].
    /// `controller`: a function that sets the `controlled` signals, see `Observation`; it is called at every point of the time grid.
    /// `fields`: names such as "displacement" that are recorded at every point of the grid; those of `[output.fields]` by default.
    /// `check`: raise `RunError` where the run does not complete; otherwise `status` of the result says so.
    #[pyo3(signature = (*, threads = None, progress = None, controller = None, fields = None, check = true))]
    fn run(
        &self,
        py: Python<'_>,
        threads: Option<usize>,
        progress: Option<&Bound<'_, PyAny>>,
        controller: Option<&Bound<'_, PyAny>>,
        fields: Option<Vec<String>>,
        check: bool,
    ) -> PyResult<Run> {
        let run = self.solve(py, Wanted { threads, progress, controller, fields, keys: vec![] }, check)?.0;
        Ok(run)
    }

    /// Runs all stages with the derivatives of the recorded columns by keys of the scene, exact in the constants of laws and by differences of
    /// the equations, not of runs, in others. The options are those of `run`.
    #[pyo3(signature = (keys, *, threads = None, progress = None, check = true))]
    fn sensitivities(
        &self,
        py: Python<'_>,
        keys: Vec<String>,
        threads: Option<usize>,
        progress: Option<&Bound<'_, PyAny>>,
        check: bool,
    ) -> PyResult<Sensitivities> {
        let parsed =
            keys.iter().map(|key| key.parse::<ParameterKey>()).collect::<Result<Vec<_>, _>>().map_err(refused)?;
        if parsed.is_empty() {
            return Err(input("no key is given", "write for example [\"laws.rubber.mu\"]"));
        }
        let wanted = Wanted { threads, progress, controller: None, fields: None, keys: parsed };
        let (run, found) = self.solve(py, wanted, check)?;
        Sensitivities::new(py, found.expect("keys were given"), run, check)
    }

    fn __repr__(&self) -> String {
        let title = self.table.get("title").and_then(Value::as_str);
        title.map_or_else(|| format!("<Scene {}>", self.file.display()), |title| format!("<Scene {title:?}>"))
    }
}

/// Options of a run, from Python.
struct Wanted<'a, 'py> {
    threads: Option<usize>,
    progress: Option<&'a Bound<'py, PyAny>>,
    controller: Option<&'a Bound<'py, PyAny>>,
    fields: Option<Vec<String>>,
    keys: Vec<ParameterKey>,
}

impl Scene {
    /// Refuses a text that is no scene.
    fn of(file: PathBuf, table: Table) -> PyResult<Self> {
        Ok(Self { file, table, built: Mutex::new(None) })
    }

    pub fn changed(&self, key: &str, value: Value) -> PyResult<Self> {
        let (_, text) = changed_scene(&self.file, &self.text(), &[(key.into(), value)]).map_err(refused)?;
        Self::of(self.file.clone(), text.parse().map_err(|e: toml::de::Error| refused(e.to_string()))?)
    }

    /// The key as the text gives it, for a value in SI units.
    pub fn with_si(&self, key: &str, value: f64) -> PyResult<Self> {
        let parsed: ParameterKey = key.parse().map_err(refused)?;
        self.changed(key, parsed.value(&self.table).map_err(refused)?.written_si(value))
    }

    pub fn file(&self) -> &Path {
        &self.file
    }

    pub fn table(&self) -> &Table {
        &self.table
    }

    /// The scene on its mesh, which is made or read at the first call.
    pub fn build(&self, py: Python<'_>, follower: Option<&Bound<'_, PyAny>>) -> PyResult<Built> {
        if let Some(built) = self.built.lock().unwrap_or_else(PoisonError::into_inner).clone() {
            return Ok(built);
        }
        let text = self.text();
        let built = apart(py, follower, |link| assembled(&self.file, &text, link))?;
        let built = built.map_err(|e| refused(e as Box<dyn std::error::Error>))?;
        *self.built.lock().unwrap_or_else(PoisonError::into_inner) = Some(built.clone());
        Ok(built)
    }

    fn solve(
        &self,
        py: Python<'_>,
        wanted: Wanted<'_, '_>,
        check: bool,
    ) -> PyResult<(Run, Option<durometer::scene::Sensitivities>)> {
        let follower = crate::run::follower(py, wanted.progress)?;
        let foreign = callable(wanted.controller)?;
        let built = self.build(py, follower.as_ref())?;
        check_control(&built.scene, foreign.is_some())?;
        let mut recorded = Recorded::new(&built.scene, wanted.fields)?;
        threads::use_threads(wanted.threads.unwrap_or_else(threads::available).max(1));
        let keys = &wanted.keys;
        let mut done = apart(py, follower.as_ref(), |link| run(&built, foreign, keys, &mut recorded, link))?
            .map_err(|e| refused(e as Box<dyn std::error::Error>))?;
        let (status, failure) = (done.run.status.clone(), done.run.failure.take());
        let sensitivities = done.run.sensitivities.take();
        let run = Run::new(py, &built.scene, done, recorded)?;
        if let Some(why) = failure {
            return Err(refused(why));
        }
        if check && status != Status::Converged {
            let result = Py::new(py, run)?.into_any();
            return Err(incomplete(status.name(), &status.to_string_at(), status.remedy(), result));
        }
        Ok((run, sensitivities))
    }
}

/// A status in words, with its time.
trait Words {
    fn to_string_at(&self) -> String;
}

impl Words for Status {
    fn to_string_at(&self) -> String {
        self.t().map_or_else(|| self.fact(), |t| format!("after t = {t:.6} s: {}", self.fact()))
    }
}

type Failed = Box<dyn std::error::Error + Send + Sync>;

/// Reads or makes the mesh, refined where the scene asks for it, and assembles the scene.
fn assembled(file: &Path, text: &str, link: &Arc<Link>) -> Result<Built, Failed> {
    let raised = Arc::new(law::Raised::default());
    raised.during(link, || {
        let (spec, text) = changed_scene(file, text, &[])?;
        let body = body(file, &spec, &text, link)?;
        let scene = durometer::scene::Scene::build(file, spec, text, body)?;
        Ok(Built { scene: Arc::new(scene), raised: raised.clone() })
    })
}

fn body(file: &Path, spec: &SceneSpec, text: &str, link: &Arc<Link>) -> Result<Arc<Body>, Failed> {
    let body = Arc::new(Body::load(file, &spec.mesh, &mut |_| {})?);
    let Some(wanted) = &spec.mesh.refine else { return Ok(body) };
    let mut watch =
        RefinementWatch { step: &mut |_| {}, mesher: &mut |_| {}, progress: &mut |progress| link.progress(progress) };
    Ok(refine((file, spec, text), wanted, body, None, &mut watch)?.body)
}

/// A run with the seconds that it took, by the clock and of the processor.
pub struct Done {
    pub run: durometer::scene::Run,
    pub seconds: (f64, f64),
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
