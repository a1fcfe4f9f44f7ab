//! The class `Run`: the columns of a run as arrays, its mesh, and the fields that were recorded.

use crate::array::{array, indices};
use crate::built::{Built, Done};
use crate::error::{input, refused};
use crate::keys::parsed;
use crate::solve::apart;
use crate::value::unit;
use durometer::scene::output::{FieldSpec, ScheduleSpec};
use durometer::scene::{Scene, hint, scalar_sensitivity};
use durometer::study::store::outcome;
use durometer::system::State;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;

/// The record of a run: one row per recorded time, one column per quantity, in SI units but for angles in degrees.
///
/// `run["xmax_z_m"]` is a column, `run.times` are the times \[s\], `run.frame` is a table of pandas.
#[pyclass(module = "durometer", frozen)]
pub struct Run {
    /// Names of the columns; the first is `t_s`
    #[pyo3(get)]
    columns: Vec<String>,
    /// \[times × columns\]
    #[pyo3(get)]
    values: Py<PyAny>,
    /// \[times × signals\] values of the prescribed signals
    #[pyo3(get)]
    signals: Py<PyAny>,
    /// Names of the signals
    #[pyo3(get)]
    signal_names: Vec<String>,
    /// `Converged`, or the reason why the run ended
    #[pyo3(get)]
    status: String,
    /// The reason in words; empty where the run converged
    #[pyo3(get)]
    fact: String,
    /// The remedy; empty where the run converged
    #[pyo3(get)]
    remedy: String,
    record: String,
    rows: usize,
    built: Built,
    /// The last state, and what the recorders keep there
    last: (State, Vec<f64>),
    /// \[times\] of the fields \[s\]
    #[pyo3(get)]
    field_times: Py<PyAny>,
    /// Name → \[times × nodes × components\]
    #[pyo3(get)]
    fields: Py<PyDict>,
    /// Name → \[times × cells × components\]
    #[pyo3(get)]
    cell_fields: Py<PyDict>,
}

/// Fields that are taken down while a scene runs.
pub struct Recorded {
    what: Vec<FieldSpec>,
    schedule: ScheduleSpec,
    /// \[s\]
    times: Vec<f64>,
    /// Place and name → components, values at one time after the other
    values: BTreeMap<(bool, &'static str), (usize, Vec<f64>)>,
}

impl Recorded {
    /// The named fields at every point of the time grid, or those of `[output.fields]` when they are due.
    pub fn new(scene: &Scene, names: Option<Vec<String>>) -> PyResult<Self> {
        let of_scene = scene.spec.output.fields.as_ref();
        let (what, schedule) = match names {
            Some(names) => {
                let field = |name: String| {
                    toml::Value::String(name)
                        .try_into::<FieldSpec>()
                        .map_err(|e| input(e.message(), "name known fields"))
                };
                (names.into_iter().map(field).collect::<PyResult<_>>()?, ScheduleSpec::default())
            }
            None => of_scene.map(|fields| (fields.what.clone(), fields.schedule())).unwrap_or_default(),
        };
        Ok(Self { what, schedule, times: vec![], values: BTreeMap::new() })
    }

    pub fn add(&mut self, scene: &Scene, state: &State) {
        if self.what.is_empty() || !self.schedule.due(self.times.last().copied(), state.t) {
            return;
        }
        self.times.push(state.t);
        for field in scene.fields(state, &self.what) {
            let entry = self.values.entry((field.at_nodes, field.name)).or_insert((field.components, vec![]));
            entry.1.extend(field.values);
        }
    }
}

#[pymethods]
impl Run {
    /// Times of the rows \[s\].
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.column(py, 0)
    }

    /// Column → its unit; `1` of a number without one.
    #[getter]
    fn units(&self) -> BTreeMap<&str, &'static str> {
        self.columns.iter().map(|name| (name.as_str(), unit(name))).collect()
    }

    /// Whether all stages were run.
    #[getter]
    fn converged(&self) -> bool {
        self.status == "Converged"
    }

    /// \[nodes × 3\] positions at rest \[m\].
    #[getter]
    fn nodes(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let points = &self.built.scene.body.mesh.points;
        array(py, points.iter().flat_map(|p| [p.x, p.y, p.z]).collect(), [points.len(), 3])
    }

    /// \[cells × nodes of a cell\] indices of nodes, 4 of linear and 10 of quadratic tetrahedra, in the order of VTK.
    #[getter]
    fn cells(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let mesh = &self.built.scene.body.mesh;
        let width = mesh.cells.len() / mesh.cell_count().max(1);
        indices(py, &mesh.cells, [mesh.cell_count(), width])
    }

    /// \[times × nodes × 3\] displacements \[m\] at `field_times`, of a run with the field "displacement".
    #[getter]
    fn displacements<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.fields.bind(py).get_item("displacement_m")?.ok_or_else(|| {
            input(
                "the run has recorded no displacements",
                "run it with fields=[\"displacement\"], or add [output.fields] to the scene",
            )
        })
    }

    /// The record of the run as `durometer simulate --json` prints it: peaks, events, costs, provenance.
    #[getter]
    fn record<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("json")?.call_method1("loads", (&self.record,))
    }

    /// The rows as a table of pandas, indexed by time; `frame.attrs["units"]` has the units.
    #[getter]
    fn frame<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("durometer._frames")?.call_method1("of_run", (slf,))
    }

    /// The same table.
    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        Self::frame(slf)
    }

    /// \[keys\] derivatives of Σ weight · column at the end of the run by keys of the scene, per SI unit of the key, by one adjoint solution for all
    /// columns and keys. For static runs, see `Scene.check_gradient`; `Scene.sensitivities` has the derivatives of every row.
    fn gradient(&self, py: Python<'_>, weights: BTreeMap<String, f64>, keys: Vec<String>) -> PyResult<Py<PyAny>> {
        let keys = parsed(&keys)?;
        let mut of_columns = vec![0.0; self.columns.len()];
        for (name, weight) in weights {
            let known = || input(&format!("no column {name}"), &hint(&name, &self.columns));
            of_columns[self.columns.iter().position(|column| *column == name).ok_or_else(known)?] = weight;
        }
        if let Some(weight) = of_columns.iter().find(|weight| !weight.is_finite()) {
            return Err(input(&format!("a weight is {weight}"), "give finite numbers"));
        }
        if !self.converged() {
            return Err(input("the run did not complete, and has no last state", "mend what its `remedy` says"));
        }
        let Built { scene, raised } = &self.built;
        let last = (&self.last.0, &self.last.1[..]);
        let work = || scalar_sensitivity(scene, last, &of_columns, &keys);
        let found = apart(py, None, |link| raised.during(link, work))?.map_err(refused)?;
        array(py, found.values, [keys.len()])
    }

    /// The body as an unstructured grid of pyvista, displaced as at `field_times[k]`, with the fields of that time; at rest without fields.
    #[pyo3(signature = (k = -1), text_signature = "($self, k=-1)")]
    fn to_pyvista<'py>(slf: &Bound<'py, Self>, k: isize) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("durometer._meshes")?.call_method1("pyvista_grid", (slf, k))
    }

    /// The body at rest as a mesh of meshio, with the fields of `field_times[k]`.
    #[pyo3(signature = (k = -1), text_signature = "($self, k=-1)")]
    fn to_meshio<'py>(slf: &Bound<'py, Self>, k: isize) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("durometer._meshes")?.call_method1("meshio_mesh", (slf, k))
    }

    /// A column, one value per time.
    fn __getitem__<'py>(&self, py: Python<'py>, column: &str) -> PyResult<Bound<'py, PyAny>> {
        let place = self.columns.iter().position(|name| name == column);
        let k =
            place.ok_or_else(|| PyKeyError::new_err(format!("no column {column}; {}", hint(column, &self.columns))))?;
        self.column(py, k)
    }

    fn __contains__(&self, column: &str) -> bool {
        self.columns.iter().any(|name| name == column)
    }

    /// The number of recorded times.
    fn __len__(&self) -> usize {
        self.rows
    }

    fn __repr__(&self) -> String {
        format!("<Run {}, {} times, {} columns>", self.status, self.rows, self.columns.len())
    }
}

impl Run {
    pub fn new(py: Python<'_>, built: Built, done: Done, recorded: Recorded) -> PyResult<Self> {
        let (Done { run, seconds }, scene) = (done, &*built.scene);
        let record = serde_json::to_string(&outcome::record(scene, &run, seconds));
        let (rows, columns) = (run.rows.len(), run.columns.len());
        let signals = run.signals.first().map_or(0, Vec::len);
        let is_whole = run.status == durometer::solve::Status::Converged;
        let words = |text: String| if is_whole { String::new() } else { text };
        let (fields, cell_fields) = (PyDict::new(py), PyDict::new(py));
        let times = recorded.times.len();
        for ((at_nodes, name), (components, values)) in recorded.values {
            let places = values.len() / (times * components).max(1);
            let into = if at_nodes { &fields } else { &cell_fields };
            into.set_item(name, array(py, values, [times, places, components])?)?;
        }
        Ok(Self {
            rows,
            values: array(py, run.rows.concat(), [rows, columns])?,
            signals: array(py, run.signals.concat(), [run.signals.len(), signals])?,
            signal_names: scene.signals.iter().map(|signal| signal.name.clone()).collect(),
            status: run.status.name().into(),
            fact: words(run.status.fact()),
            remedy: words(run.status.remedy().into()),
            record: record.map_err(|e| input(&format!("the record cannot be written: {e}"), ""))?,
            columns: run.columns,
            last: (run.last, run.memories.last().cloned().unwrap_or_default()),
            built,
            field_times: array(py, recorded.times, [times])?,
            fields: fields.unbind(),
            cell_fields: cell_fields.unbind(),
        })
    }

    pub fn column<'py>(&self, py: Python<'py>, k: usize) -> PyResult<Bound<'py, PyAny>> {
        let all = pyo3::types::PySlice::full(py);
        self.values.bind(py).get_item((all, k))
    }
}

/// The function that follows some work: one of the user, or a bar.
pub fn follower<'py>(py: Python<'py>, given: Option<&Bound<'py, PyAny>>) -> PyResult<Option<Bound<'py, PyAny>>> {
    let follower = py.import("durometer._progress")?.call_method1("follower", (given,))?;
    Ok((!follower.is_none()).then_some(follower))
}
