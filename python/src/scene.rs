//! The class `Scene`: the text of a scene with its changes, and what can be done with it.

use crate::built::{Built, assembled};
use crate::error::refused;
use crate::keys::parsed;
use crate::run::{Run, follower};
use crate::sensitivities::Sensitivities;
use crate::solution::{Wanted, solve};
use crate::solve::apart;
use crate::threads;
use crate::value::{object_of, toml_of};
use durometer::material::{KnownLaws, LawSpecError};
use durometer::math::threads::locked;
use durometer::scene::{ParameterKey, SensitivityRecorder, changed_scene, limits_of_scene, overrides, read_table};
use pyo3::prelude::*;
use pyo3::types::PyString;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use toml::{Table, Value};

/// File name that messages show for a scene that was given as text, in the folder relative to which its files are found.
const TEXT: &str = "<text>";

/// A simulation: the text of a scene and changes to it.
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
    /// Content of the scene, with the changes applied
    table: Table,
    /// Laws that were registered when the scene was made
    known_laws: KnownLaws,
    built: Mutex<Option<Built>>,
}

#[pymethods]
impl Scene {
    /// Reads a scene from a file, or from a text in TOML. Files that a text names are relative to the current folder.
    #[staticmethod]
    #[pyo3(signature = (source))]
    fn from_toml(source: &Bound<'_, PyAny>) -> PyResult<Self> {
        let text = source.cast::<PyString>().ok().map(|text| text.to_string()).filter(|text| is_scene(text));
        let (file, text) = match text {
            Some(text) => (PathBuf::from(TEXT), text),
            None => {
                let file =
                    durometer_commands::files::find(&source.extract::<PathBuf>()?, "scene.toml").map_err(refused)?;
                let (text, _) = read_table(&file).map_err(refused)?;
                (file, text)
            }
        };
        // The scene is built later, perhaps after the current folder has changed
        let file = std::path::absolute(file)?;
        let (spec, text) = changed_scene(&file, &text, &[], &KnownLaws::default()).map_err(refused)?;
        Self::of(file, &text, spec.known_laws)
    }

    /// Returns the scene with another value of a key, e.g. `set("laws.rubber.mu", "30 kPa")`. An entry of a list is addressed by its index, or by its
    /// `name` or `kind`; `+` adds an entry. Unknown keys and wrong units are refused here, anything that depends on the mesh or on other keys when the
    /// scene is run.
    fn set(&self, key: &str, value: &Bound<'_, PyAny>) -> PyResult<Self> {
        self.changed(key, toml_of(value)?)
    }

    /// Returns the value of a key as written in the text.
    fn get<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        object_of(py, overrides::find(&self.table, key).map_err(refused)?)
    }

    /// Returns the scene with another value of a number, in its SI unit, or radians for an angle: `set_si("laws.rubber.mu", 30e3)`.
    fn set_si(&self, key: &str, value: f64) -> PyResult<Self> {
        self.with_si(key, value)
    }

    /// Returns the value of a number in its SI unit.
    fn get_si(&self, key: &str) -> PyResult<f64> {
        let value = key.parse::<ParameterKey>().map_err(refused)?.value(&self.table).map_err(refused)?;
        Ok(value.number * value.factor)
    }

    /// Checks that `Run.gradient` can differentiate the runs of this scene; otherwise InputError says why not.
    fn check_gradient(&self, py: Python<'_>) -> PyResult<()> {
        let built = self.build(py, None)?;
        let checked = apart(py, None, |link| built.during(link, durometer::scene::check_scalar))?;
        checked.map_err(|e| refused(e as Box<dyn std::error::Error>))?.map_err(refused)
    }

    /// Returns the names of the columns that have derivatives with respect to these keys; InputError if there are none for a key.
    fn _differentiable(&self, py: Python<'_>, keys: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
        let (keys, built) = (parsed(keys)?, self.build(py, None)?);
        let columns = apart(py, None, |link| {
            built.during(link, |scene| SensitivityRecorder::new(scene, &keys).map(|of| of.columns().to_vec()))
        })?;
        columns.map_err(|e| refused(e as Box<dyn std::error::Error>))?.map_err(refused)
    }

    /// The scene as TOML, with its changes and includes applied.
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

    /// Notes and warnings on the scene and on its mesh.
    #[getter]
    fn notes(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let scene = self.build(py, None)?.scene;
        let limits = apart(py, None, |_| limits_of_scene(&scene))?;
        Ok(scene.notes.iter().cloned().chain(limits.into_iter().map(|(_, limit)| limit)).collect())
    }

    /// Runs all stages. Meanwhile other Python threads can run, and Ctrl-C ends the run.
    ///
    /// `threads`: number of threads that it may use, by default one per core; results do not depend on it.
    /// `progress`: True for a progress bar, or a function that is called with the time reached and the end time `[s]`.
    /// `controller`: a function that sets the `controlled` signals, see `Observation`; it is called at every point of the time grid.
    /// `fields`: names such as "displacement" of fields that are recorded at every point of the time grid; by default those of `[output.fields]`.
    /// `check`: raise `RunError` if the run does not complete, or if a refined mesh misses the tolerance of `mesh.refine` (`status` is
    /// "ToleranceMissed"); with False, the `status` of the result reports the former, and a warning the latter. `result` of the exception is the run so
    /// far, also for an exception of one of your own functions, KeyboardInterrupt, and a warning that a filter turns into an exception.
    #[pyo3(signature = (*, threads = None, progress = None, controller = None, fields = None, check = true))]
    fn run(
        &self,
        py: Python<'_>,
        threads: Option<&Bound<'_, PyAny>>,
        progress: Option<&Bound<'_, PyAny>>,
        controller: Option<&Bound<'_, PyAny>>,
        fields: Option<&Bound<'_, PyAny>>,
        check: bool,
    ) -> PyResult<Py<Run>> {
        threads::set(threads)?;
        let follower = follower(py, progress)?;
        let built = self.build(py, follower.as_ref())?;
        let wanted = Wanted { follower, controller, fields, keys: vec![] };
        let (run, _) = solve(py, built, wanted, check)?;
        run.get().warned(py, run.clone_ref(py))
    }

    /// Runs all stages with the derivatives of the recorded columns with respect to keys of the scene, exact for constants of laws and finite differences
    /// of the equations, not of runs, for other keys. The options are those of `run`.
    #[pyo3(signature = (keys, *, threads = None, progress = None, check = true))]
    fn sensitivities(
        &self,
        py: Python<'_>,
        keys: &Bound<'_, PyAny>,
        threads: Option<&Bound<'_, PyAny>>,
        progress: Option<&Bound<'_, PyAny>>,
        check: bool,
    ) -> PyResult<Py<Sensitivities>> {
        threads::set(threads)?;
        let (keys, follower) = (parsed(keys)?, follower(py, progress)?);
        let built = self.build(py, follower.as_ref())?;
        let wanted = Wanted { follower, controller: None, fields: None, keys };
        let (run, found) = solve(py, built, wanted, check)?;
        let found = Sensitivities::new(py, found.expect("keys were given"), run.clone_ref(py), check)?;
        run.get().warned(py, Py::new(py, found)?)
    }

    /// Tells `pickle` how to rebuild the scene: from its text, and the file whose folder its files are relative to.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (PathBuf, String))> {
        Ok((py.import("durometer._pickled")?.getattr("scene")?, (self.file.clone(), self.text())))
    }

    /// Rebuilds a scene from what `__reduce__` has kept.
    #[staticmethod]
    fn _pickled(file: PathBuf, text: &str) -> PyResult<Self> {
        Self::of(file, text, KnownLaws::default())
    }

    /// The scene itself, which never changes.
    fn __copy__(slf: Bound<'_, Self>) -> Bound<'_, Self> {
        slf
    }

    /// The scene itself, which never changes.
    fn __deepcopy__<'py>(slf: Bound<'py, Self>, _memo: &Bound<'py, PyAny>) -> Bound<'py, Self> {
        slf
    }

    fn __repr__(&self) -> String {
        let title = self.table.get("title").and_then(Value::as_str);
        title.map_or_else(|| format!("<Scene {}>", self.file.display()), |title| format!("<Scene {title:?}>"))
    }
}

impl Scene {
    /// Makes a scene from its text, with these laws.
    fn of(file: PathBuf, text: &str, known_laws: KnownLaws) -> PyResult<Self> {
        let table = text.parse().map_err(|e: toml::de::Error| refused(e.to_string()))?;
        Ok(Self { file, table, known_laws, built: Mutex::new(None) })
    }

    /// Returns the scene with this value of a key.
    pub fn changed(&self, key: &str, value: Value) -> PyResult<Self> {
        let changes = [(key.into(), value.clone())];
        let (spec, text) = changed_scene(&self.file, &self.text(), &changes, &self.known_laws).map_err(refused)?;
        let parsed = key.parse::<ParameterKey>().ok();
        let constant = parsed.as_ref().and_then(ParameterKey::law_constant);
        if let Some((constant, law)) = constant.and_then(|constant| Some((constant.key, spec.laws.get(constant.law)?)))
        {
            check_constant(&self.known_laws, law, constant, value)?;
        }
        Self::of(self.file.clone(), &text, spec.known_laws)
    }

    /// Returns the scene with a value given in SI units, written in the unit of the text.
    pub fn with_si(&self, key: &str, value: f64) -> PyResult<Self> {
        let parsed: ParameterKey = key.parse().map_err(refused)?;
        let written = parsed.value(&self.table).map_err(refused)?.written_si(value);
        // An integer stays one, because some keys accept only integers
        let is_whole = matches!(overrides::find(&self.table, key), Ok(Value::Integer(_)));
        let whole = |number: f64| format!("{number}").parse().map(Value::Integer).ok();
        self.changed(key, written.as_float().filter(|_| is_whole).and_then(whole).unwrap_or(written))
    }

    pub fn file(&self) -> &Path {
        &self.file
    }

    pub fn table(&self) -> &Table {
        &self.table
    }

    /// Returns the scene on its mesh, which is made or read at the first call.
    pub fn build(&self, py: Python<'_>, follower: Option<&Bound<'_, PyAny>>) -> PyResult<Built> {
        if let Some(built) = locked(&self.built).clone() {
            return Ok(built);
        }
        let text = self.text();
        let built = apart(py, follower, |link| assembled(&self.file, &text, &self.known_laws, link))?;
        let built = built.map_err(|e| refused(e as Box<dyn std::error::Error>))?;
        // A scene that another thread has built meanwhile is dropped after the lock is released
        let _other = locked(&self.built).replace(built.clone());
        Ok(built)
    }
}

/// Whether a text is a scene rather than a file name: it has several lines, or its only line sets a key and is not the path of a file.
fn is_scene(text: &str) -> bool {
    let gives_key = || text.contains('=') && text.parse::<Table>().is_ok() && !Path::new(text).exists();
    text.contains('\n') || gives_key()
}

/// Refuses a constant of a law with a wrong unit. Errors that depend on other keys of the law are left to the run, because those keys may be changed
/// next.
fn check_constant(known_laws: &KnownLaws, law: &Table, key: &str, value: Value) -> PyResult<()> {
    let alone = law.get("law").map(|name| ("law".into(), name.clone())).into_iter().chain([(key.into(), value)]);
    match known_laws.given(&alone.collect()) {
        Err(why @ (LawSpecError::Unit { .. } | LawSpecError::NotAQuantity { .. })) => Err(refused(why)),
        _ => Ok(()),
    }
}
