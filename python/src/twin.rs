//! The class `Twin`: a reduced model that is stepped from Python.

use crate::array::own_array;
use crate::error::{input, refused};
use crate::keys::names;
use crate::raised::Raised;
use crate::value::{mapping, number};
use durometer::math::threads::locked;
use durometer::reduction::running::inverse::{Target, reach_by};
use durometer::reduction::{ReducedModel, Twin as Model};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// A reduced model from a study of kind "reduction", at an equilibrium.
#[pyclass(module = "durometer", frozen)]
pub struct Twin {
    model: Arc<ReducedModel>,
    /// The model, in a box because its SIMD lanes are aligned to 32 bytes
    running: Box<Mutex<Model>>,
    /// Exceptions of the model's laws in Python
    raised: Arc<Raised>,
}

impl Twin {
    fn of(py: Python<'_>, model: ReducedModel) -> PyResult<Self> {
        let (model, raised) = (Arc::new(model), Arc::<Raised>::default());
        let running = py.detach(|| raised.raising(|| Model::new(model.clone())))?.map_err(refused)?;
        Ok(Self { running: Box::new(running.into()), model, raised })
    }

    /// Does work on the model without the interpreter lock, so that a thread waiting for the model does not block the one that uses it. The only Python
    /// code in the work is that of laws, whose exceptions are raised.
    fn with<T: Send>(&self, py: Python<'_>, work: impl FnOnce(&mut Model) -> T + Send) -> PyResult<T> {
        py.detach(|| {
            let mut running = locked(&self.running);
            self.raised.raising(|| work(&mut running))
        })
    }

    fn names_of_inputs(&self) -> Vec<&str> {
        self.model.inputs.iter().map(|i| i.name.as_str()).collect()
    }

    fn names_of_quantities(&self) -> Vec<&str> {
        self.model.quantities.iter().map(|q| q.name.as_str()).collect()
    }

    /// Returns which inputs a search may move: the named ones, or by default the driving ones.
    fn moving(&self, named: Option<Vec<String>>) -> PyResult<Vec<bool>> {
        let Some(named) = named else { return Ok(self.model.driving()) };
        let known = self.names_of_inputs();
        if let Some(name) = named.iter().find(|name| !known.contains(&name.as_str())) {
            return Err(input(&format!("there is no input {name}"), &format!("known: {}", known.join(", "))));
        }
        Ok(known.iter().map(|known| named.iter().any(|name| name == known)).collect())
    }

    /// Returns a dictionary of values by the names of the quantities.
    fn by_quantity<'py>(&self, py: Python<'py>, values: fn(&Model) -> &[f64]) -> PyResult<Bound<'py, PyDict>> {
        let values = self.with(py, |model| values(model).to_vec())?;
        self.names_of_quantities().into_iter().zip(values).into_py_dict(py)
    }
}

/// Reads numbers by name, and returns each with the index of its name in `known`.
fn indexed(what: &str, known: &[&str], given: &Bound<'_, PyAny>) -> PyResult<Vec<(usize, f64)>> {
    let one = |(name, value): (String, Bound<'_, PyAny>)| {
        let Some(k) = known.iter().position(|known| *known == name) else {
            return Err(input(&format!("there is no {what} {name}"), &format!("known: {}", known.join(", "))));
        };
        let number = number(&format!("the {what} {name}"), &value, "give one number in SI units")?;
        match number.is_finite() {
            true => Ok((k, number)),
            false => Err(input(&format!("the {what} {name} is {number}"), "give a finite number in SI units")),
        }
    };
    mapping(&format!("the dictionary of {what} and value"), given)?.into_iter().map(one).collect()
}

#[pymethods]
impl Twin {
    /// Reads a file `.durom`; the model is at rest.
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        Self::of(py, ReducedModel::read(&path).map_err(refused)?)
    }

    /// Reads a model from the bytes of a `.durom` file.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, data: &[u8]) -> PyResult<Self> {
        Self::of(py, ReducedModel::from_bytes(Path::new("the bytes"), data).map_err(refused)?)
    }

    /// Name of each input → its range (least, largest) `[SI]`.
    #[getter]
    fn ranges<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.model.inputs.iter().map(|i| (&i.name, <(f64, f64)>::from(i.range))).into_py_dict(py)
    }

    /// Name of each input → its value at the present equilibrium `[SI]`.
    #[getter]
    fn inputs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let values = self.with(py, |model| model.inputs().to_vec())?;
        self.names_of_inputs().into_iter().zip(values).into_py_dict(py)
    }

    /// Name of each quantity → its value.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.by_quantity(py, Model::values)
    }

    /// Name of each quantity → its error bar, infinite out of range.
    #[getter]
    fn bars<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.by_quantity(py, Model::bars)
    }

    /// Name of each quantity → its estimated error: the value of the full model minus that of this one.
    #[getter]
    fn estimates<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.by_quantity(py, Model::estimates)
    }

    /// Whether the inputs are within the ranges that the model was made for.
    #[getter]
    fn in_range(&self, py: Python<'_>) -> PyResult<bool> {
        self.with(py, |model| model.in_range())
    }

    /// Time step `[s]` of a model that moves, otherwise None.
    #[getter]
    fn dt(&self) -> Option<f64> {
        self.model.dynamics.as_ref().map(|dynamics| dynamics.dt)
    }

    /// Time since the last rest `[s]` of a model that moves, otherwise None.
    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<Option<f64>> {
        self.with(py, |model| model.time())
    }

    /// Goes to the equilibrium of these inputs `[SI]`, or takes one time step at whose end they have these values; inputs that are not given keep their
    /// values. Returns the values of the quantities.
    fn step<'py>(&self, py: Python<'py>, inputs: &Bound<'_, PyAny>) -> PyResult<Bound<'py, PyDict>> {
        let given = indexed("input", &self.names_of_inputs(), inputs)?;
        let values = self.with(py, |model| {
            let mut all = model.inputs().to_vec();
            given.iter().for_each(|(k, value)| all[*k] = *value);
            model.step(&all).map(|_| model.values().to_vec())
        })?;
        self.names_of_quantities().into_iter().zip(values.map_err(refused)?).into_py_dict(py)
    }

    /// Goes to inputs within their ranges at which these quantities have these values, as nearly as a local search finds them. Returns whether all are
    /// met within `tolerance`, relative to their largest changes from rest. `moving` names the inputs that may move, by default the driving ones.
    #[pyo3(signature = (targets, *, tolerance = 1e-4, moving = None))]
    fn reach(
        &self,
        py: Python<'_>,
        targets: &Bound<'_, PyAny>,
        tolerance: f64,
        moving: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<bool> {
        if tolerance.is_nan() || tolerance <= 0.0 {
            return Err(input(&format!("tolerance is {tolerance}"), "give a share above zero, such as 1e-4"));
        }
        let target = |(quantity, value)| {
            let tolerance = tolerance * self.model.size_at(quantity, value);
            Target { quantity, value, tolerance }
        };
        let given = indexed("quantity", &self.names_of_quantities(), targets)?;
        let targets: Vec<Target> = given.into_iter().map(target).collect();
        let named = moving.map(|moving| names("moving", moving, "[\"cable_shortening_m\"]")).transpose()?;
        let moving = self.moving(named)?;
        Ok(self.with(py, |model| reach_by(model, &targets, &moving))?.map_err(refused)?.met)
    }

    /// Returns the derivatives of the quantities with respect to the inputs `[quantities × inputs]` at the present equilibrium, in the order of `values`
    /// and `inputs`; NaN at rest, before the first step.
    fn sensitivities(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let shape = [self.model.quantities.len(), self.model.inputs.len()];
        let mut out = vec![0.0; shape[0] * shape[1]];
        self.with(py, |model| model.sensitivities(&mut out))?;
        own_array(py, out, shape)
    }

    /// Returns to rest.
    fn reset(&self, py: Python<'_>) -> PyResult<()> {
        self.with(py, Model::reset)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (inputs, values) = self.with(py, |model| (model.inputs().to_vec(), model.values().to_vec()))?;
        let listed = |names: Vec<&str>, values: Vec<f64>| {
            let one = |(name, value): (&str, f64)| format!("{name} = {value:.6e}");
            names.into_iter().zip(values).map(one).collect::<Vec<_>>().join(", ")
        };
        let at = listed(self.names_of_inputs(), inputs);
        Ok(format!("<Twin at {at}: {}>", listed(self.names_of_quantities(), values)))
    }
}
