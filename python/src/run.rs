//! The class `Run`: the columns of a run as arrays, its mesh, and the fields that were recorded.

use crate::array::{array, indices, own_array};
use crate::built::{Built, Done};
use crate::error::{input, refused, with_result};
use crate::keys::{names, parsed};
use crate::solve::apart;
use crate::value::{mapping, number};
use durometer::math::stopwatch::{Spent, Stopwatch};
use durometer::scene::output::{FieldSpec, ScheduleSpec};
use durometer::scene::{
    ParameterKey, ScalarSensitivity, Scene, Sensitivities, column, hint, scalar_sensitivity, unit_of_column,
};
use durometer::study::limits::{WARNING, limits_of_run};
use durometer::system::State;
use pyo3::exceptions::{PyKeyError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use std::collections::BTreeMap;

/// The record of a run: one row per recorded time, one column per quantity, in SI units except for angles in degrees.
///
/// `run["xmax_z_m"]` is a column, `run.times` are the times `[s]`, `run.frame` is a pandas table. The arrays are read-only: copy one before changing it
/// in place, `z = run["xmax_z_m"].copy()`. A run can be pickled; an unpickled run has everything but `gradient`.
#[pyclass(module = "durometer", frozen)]
pub struct Run {
    /// Names of the columns; the first is `t_s`
    #[pyo3(get)]
    columns: Vec<String>,
    /// All recorded values `[times × columns]`; `[output] series` thins only the files of the program
    #[pyo3(get)]
    values: Py<PyAny>,
    /// Values of the prescribed signals `[times × signals]`
    #[pyo3(get)]
    signals: Py<PyAny>,
    /// Names of the signals
    #[pyo3(get)]
    signal_names: Vec<String>,
    /// `Converged`, or the reason why the run ended
    #[pyo3(get)]
    status: String,
    /// The reason as text; empty if the run converged
    #[pyo3(get)]
    fact: String,
    /// The remedy; empty if the run converged
    #[pyo3(get)]
    remedy: String,
    /// Notes on the scene and on the run, as text
    #[pyo3(get)]
    notes: Vec<String>,
    /// Limits on the use of its numbers, as text; calls that return the run also issue them as `UserWarning`
    #[pyo3(get)]
    warnings: Vec<String>,
    record: String,
    rows: usize,
    origin: Origin,
    /// Times of the fields `[s]`
    #[pyo3(get)]
    field_times: Py<PyAny>,
    /// Name of a nodal field → its values `[times × nodes × components]`
    #[pyo3(get)]
    fields: Py<PyDict>,
    /// Name of a cell field → its values `[times × cells × components]`
    #[pyo3(get)]
    cell_fields: Py<PyDict>,
}

/// The origin of a run.
enum Origin {
    /// The scene, the last state, and the values that the recorders keep there
    Here(Box<(Built, State, Vec<f64>)>),
    /// Nodes and cells of a run that was pickled
    Pickled(Py<PyAny>, Py<PyAny>),
}

/// Fields that are recorded while a scene runs.
pub struct Recorded {
    what: Vec<FieldSpec>,
    schedule: ScheduleSpec,
    /// \[s\]
    times: Vec<f64>,
    /// Whether at nodes, and name → number of components, and values one time after the other
    values: BTreeMap<(bool, &'static str), (usize, Vec<f64>)>,
    /// Time taken by the fields, which does not count as time of the run
    pub spent: Spent,
}

impl Recorded {
    /// Sets up recording the named fields at every point of the time grid, or those of `[output.fields]` by their schedule.
    pub fn new(scene: &Scene, given: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let of_scene = scene.spec.output.fields.as_ref();
        let (mut what, schedule) = match given {
            Some(given) => {
                let field = |name: String| {
                    toml::Value::String(name)
                        .try_into::<FieldSpec>()
                        .map_err(|e| input(e.message(), "name known fields"))
                };
                let names = names("fields", given, "[\"displacement\"]")?;
                (names.into_iter().map(field).collect::<PyResult<Vec<_>>>()?, ScheduleSpec::default())
            }
            None => of_scene.map(|fields| (fields.what.clone(), fields.schedule())).unwrap_or_default(),
        };
        // A field that is named twice is recorded once
        let all = what.clone();
        let mut place = 0..;
        what.retain(|field| place.next().is_some_and(|k| !all[..k].contains(field)));
        Ok(Self { what, schedule, times: vec![], values: BTreeMap::new(), spent: Spent::default() })
    }

    pub fn add(&mut self, scene: &Scene, state: &State) {
        if self.what.is_empty() || !self.schedule.due(self.times.last().copied(), state.t) {
            return;
        }
        let stopwatch = Stopwatch::start();
        self.times.push(state.t);
        for field in scene.fields(state, &self.what) {
            let entry = self.values.entry((field.at_nodes, field.name)).or_insert((field.components, vec![]));
            entry.1.extend(field.values);
        }
        self.spent += stopwatch.spent();
    }
}

#[pymethods]
impl Run {
    /// Times of the rows `[s]`.
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.column(py, 0)
    }

    /// Column → its unit; `1` for a dimensionless number.
    #[getter]
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.columns.iter().map(|name| (name, unit_of_column(name))).into_py_dict(py)
    }

    /// Whether the run came to its planned end: the end of all stages, or where a controller or an event stopped it.
    #[getter]
    fn converged(&self) -> bool {
        self.status == "Converged"
    }

    /// Positions of the nodes at rest `[nodes × 3]` `[m]`.
    #[getter]
    fn nodes(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let scene = match &self.origin {
            Origin::Here(origin) => &origin.0.scene,
            Origin::Pickled(nodes, _) => return Ok(nodes.clone_ref(py)),
        };
        let points = &scene.body.mesh.points;
        array(py, points.iter().flat_map(|p| [p.x, p.y, p.z]).collect(), [points.len(), 3])
    }

    /// Node indices `[cells × nodes of a cell]`, 4 for linear and 10 for quadratic tetrahedra, in VTK order.
    #[getter]
    fn cells(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let scene = match &self.origin {
            Origin::Here(origin) => &origin.0.scene,
            Origin::Pickled(_, cells) => return Ok(cells.clone_ref(py)),
        };
        let mesh = &scene.body.mesh;
        let width = mesh.cells.len() / mesh.cell_count().max(1);
        indices(py, &mesh.cells, [mesh.cell_count(), width])
    }

    /// Displacements `[times × nodes × 3]` `[m]` at `field_times`, for a run with the field "displacement".
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

    /// The rows as a pandas table, indexed by time; `frame.attrs["units"]` has the units.
    #[getter]
    fn frame<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("durometer._frames")?.call_method1("of_run", (slf,))
    }

    /// Returns the table of `frame`.
    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        Self::frame(slf)
    }

    /// Returns the derivatives `[keys]` of Σ weight · column at the end of the run with respect to keys of the scene, per SI unit of the key, from one
    /// adjoint solution for all columns and keys. They are exact for constants of laws and finite differences of the equations for other keys; a warning
    /// `DoubtfulDerivative` names those whose relative estimated error is above 1e-6. Only for static runs, see `Scene.check_gradient`;
    /// `Scene.sensitivities` gives the derivatives of every row.
    fn gradient(&self, py: Python<'_>, weights: &Bound<'_, PyAny>, keys: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        let keys = parsed(keys)?;
        let mut of_columns = vec![0.0_f64; self.columns.len()];
        for (name, weight) in mapping("weights", weights)? {
            let known = || input(&format!("no column {name}"), &hint(&name, &self.columns));
            let place = self.columns.iter().position(|column| *column == name).ok_or_else(known)?;
            of_columns[place] = number(&format!("the weight of {name}"), &weight, "give a number")?;
        }
        if let Some(weight) = of_columns.iter().find(|weight| !weight.is_finite()) {
            return Err(input(&format!("a weight is {weight}"), "give finite numbers"));
        }
        if !self.converged() {
            return Err(input("the run did not complete, and has no last state", "mend what its `remedy` says"));
        }
        let Origin::Here(origin) = &self.origin else {
            return Err(input(
                "the run was pickled, and left its last state behind",
                "take its gradient where it was run",
            ));
        };
        let (built, state, memory) = &**origin;
        let found = apart(py, None, |link| {
            built.during(link, |scene| scalar_sensitivity(scene, (state, memory), &of_columns, &keys, &link.stop))
        })?;
        let found = found.map_err(|e| refused(e as Box<dyn std::error::Error>))?.map_err(refused)?;
        if found.errors.iter().any(|error| *error > 0.0) {
            self.warn(py, &of_columns, &keys, &found)?;
        }
        own_array(py, found.values, [keys.len()])
    }

    /// Returns the body as a pyvista unstructured grid with the fields of `field_times[k]`: displaced if "displacement" is one of them, otherwise at
    /// rest.
    #[pyo3(signature = (k = -1), text_signature = "($self, k=-1)")]
    fn to_pyvista<'py>(slf: &Bound<'py, Self>, k: isize) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("durometer._meshes")?.call_method1("pyvista_grid", (slf, k))
    }

    /// Returns the body at rest as a meshio mesh, with the fields of `field_times[k]`.
    #[pyo3(signature = (k = -1), text_signature = "($self, k=-1)")]
    fn to_meshio<'py>(slf: &Bound<'py, Self>, k: isize) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("durometer._meshes")?.call_method1("meshio_mesh", (slf, k))
    }

    /// Returns a column, one value per time.
    fn __getitem__<'py>(&self, py: Python<'py>, column: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let Ok(column) = column.extract::<&str>() else {
            let fact = format!("a run has columns by name, such as run[\"t_s\"], and none {}", column.repr()?);
            return Err(PyTypeError::new_err(format!("{fact}; its rows are run.values, its names run.columns")));
        };
        let place = self.columns.iter().position(|name| name == column);
        let k =
            place.ok_or_else(|| PyKeyError::new_err(format!("no column {column}; {}", hint(column, &self.columns))))?;
        self.column(py, k)
    }

    fn __contains__(&self, column: &Bound<'_, PyAny>) -> bool {
        column.extract::<&str>().is_ok_and(|column| self.columns.iter().any(|name| name == column))
    }

    /// The number of recorded times.
    fn __len__(&self) -> usize {
        self.rows
    }

    /// Tells `pickle` how to rebuild the run.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyDict>,))> {
        let (py, kept) = (slf.py(), PyDict::new(slf.py()));
        PICKLED.iter().try_for_each(|name| kept.set_item(name, slf.getattr(*name)?))?;
        kept.set_item("record", &slf.get().record)?;
        Ok((py.import("durometer._pickled")?.getattr("run")?, (kept,)))
    }

    /// Rebuilds a run from what `__reduce__` has kept.
    #[staticmethod]
    fn _pickled(kept: &Bound<'_, PyDict>) -> PyResult<Self> {
        let of = |name: &str| kept.as_any().get_item(name);
        let any = |name: &str| of(name).map(Bound::unbind);
        Ok(Self {
            columns: of("columns")?.extract()?,
            rows: of("values")?.len()?,
            values: any("values")?,
            signals: any("signals")?,
            signal_names: of("signal_names")?.extract()?,
            status: of("status")?.extract()?,
            fact: of("fact")?.extract()?,
            remedy: of("remedy")?.extract()?,
            notes: of("notes")?.extract()?,
            warnings: of("warnings")?.extract()?,
            record: of("record")?.extract()?,
            origin: Origin::Pickled(any("nodes")?, any("cells")?),
            field_times: any("field_times")?,
            fields: of("fields")?.cast_into()?.unbind(),
            cell_fields: of("cell_fields")?.cast_into()?.unbind(),
        })
    }

    fn __repr__(&self) -> String {
        format!("<Run {}, {} times, {} columns>", self.status, self.rows, self.columns.len())
    }
}

/// Attributes that a pickled run keeps, in addition to its record.
const PICKLED: [&str; 14] = [
    "columns",
    "values",
    "signals",
    "signal_names",
    "status",
    "fact",
    "remedy",
    "notes",
    "warnings",
    "nodes",
    "cells",
    "field_times",
    "fields",
    "cell_fields",
];

impl Run {
    /// Makes the Python object of a run. `ended`: fact and remedy if something other than the equations ended the run.
    pub fn new(
        py: Python<'_>,
        built: Built,
        done: Done,
        recorded: Recorded,
        ended: Option<(String, String)>,
    ) -> PyResult<Self> {
        let (Done { run, record }, scene) = (done, &*built.scene);
        let in_words = |(kind, limit): (&str, String)| if kind == WARNING { limit } else { format!("{kind}: {limit}") };
        let warnings = limits_of_run(&record).into_iter().map(in_words).chain(built.missed.clone()).collect();
        let notes = record.notes.clone();
        let record = serde_json::to_string(&record);
        let (rows, columns) = (run.rows.len(), run.columns.len());
        let signals = run.signals.first().map_or(0, Vec::len);
        let is_whole = run.status == durometer::solve::Status::Converged;
        let of_status = || if is_whole { Default::default() } else { (run.status.fact(), run.status.remedy().into()) };
        let (fact, remedy) = ended.unwrap_or_else(of_status);
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
            fact,
            remedy,
            notes,
            warnings,
            record: record.map_err(|e| input(&format!("the record cannot be written: {e}"), ""))?,
            columns: run.columns,
            origin: Origin::Here(Box::new((built, run.last, run.memories.last().cloned().unwrap_or_default()))),
            field_times: array(py, recorded.times, [times])?,
            fields: fields.unbind(),
            cell_fields: cell_fields.unbind(),
        })
    }

    /// Warns of the limits of the run that a call is about to return. If a filter turns the warning into an exception, its `result` is what the call
    /// would have returned.
    pub fn warned<T>(&self, py: Python<'_>, returned: Py<T>) -> PyResult<Py<T>> {
        match py.import("durometer.errors")?.call_method1("warn_of_limits", (&self.warnings,)) {
            Ok(_) => Ok(returned),
            Err(why) => Err(with_result(py, why, returned.into_any())),
        }
    }

    /// Warns of derivatives of the weighted sum that are not accurate relative to their size, as judged by `Sensitivities.doubtful`.
    fn warn(&self, py: Python<'_>, weights: &[f64], keys: &[ParameterKey], found: &ScalarSensitivity) -> PyResult<()> {
        let Origin::Here(origin) = &self.origin else { return Ok(()) };
        let values: Vec<f64> = self.values.bind(py).call_method0("ravel")?.extract()?;
        let width = self.columns.len();
        let rows: Vec<&[f64]> = values.chunks_exact(width).collect();
        let size = |c: usize| column::largest_of_unit(&self.columns, &rows, &self.columns[c]);
        let weighted = (0..width).filter(|c| weights[*c] != 0.0).map(|c| weights[c].abs() * size(c)).sum();
        let table: toml::Table = origin.0.scene.text.parse().map_err(|e: toml::de::Error| refused(e.to_string()))?;
        let one = Sensitivities {
            columns: vec!["sum".into()],
            keys: keys.to_vec(),
            rows: vec![vec![found.values.clone()]],
            errors: vec![found.errors.clone()],
            // Unknown for an adjoint solution: their sum is at least the value
            terms: vec![found.values.iter().map(|value| value.abs()).collect()],
            column_sizes: vec![weighted],
            key_sizes: keys.iter().map(|key| key.value(&table).map_or(0.0, |value| value.si().abs())).collect(),
            stopped: None,
            factorisations: 0,
            solves: 0,
            spent: Spent::default(),
        };
        let is_doubtful = |key: &ParameterKey| one.doubtful().iter().any(|(_, doubtful, _)| *doubtful == key);
        let of_keys = keys.iter().zip(&found.values).zip(&found.errors);
        let doubtful: Vec<(String, f64, f64)> = of_keys
            .filter(|((key, _), _)| is_doubtful(key))
            .map(|((key, value), error)| (key.to_string(), *value, *error))
            .collect();
        py.import("durometer.errors")?.call_method1("warn_of_doubtful", (doubtful,)).map(|_| ())
    }

    pub fn column<'py>(&self, py: Python<'py>, k: usize) -> PyResult<Bound<'py, PyAny>> {
        let all = pyo3::types::PySlice::full(py);
        self.values.bind(py).get_item((all, k))
    }
}

/// Returns the function that follows some work: one given by the user, or a progress bar.
pub fn follower<'py>(py: Python<'py>, given: Option<&Bound<'py, PyAny>>) -> PyResult<Option<Bound<'py, PyAny>>> {
    let follower = py.import("durometer._progress")?.call_method1("follower", (given,))?;
    Ok((!follower.is_none()).then_some(follower))
}
