//! The class `Twin`: a reduced model that steps.

use crate::array::array;
use crate::error::{input, refused};
use durometer::math::threads::locked;
use durometer::reduction::inverse::{Target, reach};
use durometer::reduction::{ReducedModel, Twin as Model};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};

/// A reduced model from a study of kind "reduction", at an equilibrium.
#[pyclass(module = "durometer", frozen)]
pub struct Twin {
    /// In a box: its lanes of numbers are aligned to 32 bytes
    model: Box<Mutex<Model>>,
}

impl Twin {
    fn get(&self) -> MutexGuard<'_, Model> {
        locked(&self.model)
    }

    /// Values by the names of the quantities.
    fn by_quantity<'py>(&self, py: Python<'py>, values: fn(&Model) -> &[f64]) -> PyResult<Bound<'py, PyDict>> {
        let (model, out) = (self.get(), PyDict::new(py));
        let named = model.model().quantities.iter().zip(values(&model));
        named.into_iter().try_for_each(|(q, value)| out.set_item(&q.name, value))?;
        Ok(out)
    }
}

#[pymethods]
impl Twin {
    /// Reads a file `.durom`; the model is at rest.
    #[new]
    fn new(path: PathBuf) -> PyResult<Self> {
        let model = ReducedModel::read(&path).map_err(refused)?;
        Ok(Self { model: Box::new(Model::new(model).map_err(refused)?.into()) })
    }

    /// A model from the bytes of such a file.
    #[staticmethod]
    fn from_bytes(data: &[u8]) -> PyResult<Self> {
        let model = ReducedModel::from_bytes(Path::new("the bytes"), data).map_err(refused)?;
        Ok(Self { model: Box::new(Model::new(model).map_err(refused)?.into()) })
    }

    /// Name of each input → its range (least, largest) \[SI\].
    #[getter]
    fn ranges<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (model, out) = (self.get(), PyDict::new(py));
        model.model().inputs.iter().try_for_each(|i| out.set_item(&i.name, (i.range[0], i.range[1])))?;
        Ok(out)
    }

    /// Name of each input → its value at the present equilibrium \[SI\].
    #[getter]
    fn inputs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (model, out) = (self.get(), PyDict::new(py));
        let named = model.model().inputs.iter().zip(model.inputs());
        named.into_iter().try_for_each(|(i, value)| out.set_item(&i.name, value))?;
        Ok(out)
    }

    /// Name of each quantity → its value.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.by_quantity(py, Model::values)
    }

    /// Name of each quantity → its error bar, infinite beyond the ranges.
    #[getter]
    fn bars<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.by_quantity(py, Model::bars)
    }

    /// Name of each quantity → the estimated error: the value of the full model less that of this one.
    #[getter]
    fn estimates<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.by_quantity(py, Model::estimates)
    }

    /// Whether the inputs are within the ranges that the model was made for.
    #[getter]
    fn in_range(&self) -> bool {
        self.get().in_range()
    }

    /// Length of a step in time \[s\] of a model that moves, else None.
    #[getter]
    fn dt(&self) -> Option<f64> {
        self.get().dt()
    }

    /// Time since the last rest \[s\] of a model that moves, else None.
    #[getter]
    fn time(&self) -> Option<f64> {
        self.get().time()
    }

    /// Goes to the equilibrium of these inputs \[SI\], or one step in time with them at its end; those that are not given keep their values. Returns the values of the quantities.
    fn step<'py>(&self, py: Python<'py>, inputs: &Bound<'_, PyDict>) -> PyResult<Bound<'py, PyDict>> {
        {
            let mut model = self.get();
            let mut values = model.inputs().to_vec();
            for (name, value) in inputs.iter() {
                let name: String = name.extract()?;
                let Some(k) = model.model().inputs.iter().position(|i| i.name == name) else {
                    let known: Vec<&str> = model.model().inputs.iter().map(|i| i.name.as_str()).collect();
                    return Err(input(
                        &format!("there is no input {name}"),
                        &format!("the inputs are {}", known.join(", ")),
                    ));
                };
                values[k] = value.extract()?;
            }
            model.step(&values).map_err(refused)?;
        }
        self.values(py)
    }

    /// Goes to inputs in their ranges at which these quantities have these values, as near as a local search comes; true where it met all within
    /// `tolerance`, a share of their largest changes from rest.
    #[pyo3(signature = (targets, *, tolerance = 1e-4))]
    fn reach(&self, targets: &Bound<'_, PyDict>, tolerance: f64) -> PyResult<bool> {
        let mut model = self.get();
        let mut all = vec![];
        for (name, value) in targets.iter() {
            let name: String = name.extract()?;
            let Some(quantity) = model.model().quantities.iter().position(|q| q.name == name) else {
                let known: Vec<&str> = model.model().quantities.iter().map(|q| q.name.as_str()).collect();
                return Err(input(
                    &format!("there is no quantity {name}"),
                    &format!("the quantities are {}", known.join(", ")),
                ));
            };
            let value: f64 = value.extract()?;
            if !(value.is_finite() && tolerance > 0.0) {
                return Err(input(
                    &format!("{name} is to be {value} within {tolerance}"),
                    "give a finite value, and a tolerance above zero",
                ));
            }
            let size = model.model().size_at(quantity, value);
            all.push(Target { quantity, value, tolerance: tolerance * size });
        }
        Ok(reach(&mut model, &all).map_err(refused)?.met)
    }

    /// Derivatives of the quantities by the inputs \[quantities × inputs\] at the present equilibrium, in the order of `values` and `inputs`.
    fn sensitivities(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let mut model = self.get();
        let shape = [model.values().len(), model.inputs().len()];
        let mut out = vec![0.0; shape[0] * shape[1]];
        model.sensitivities(&mut out);
        array(py, out, shape)
    }

    /// Back to rest.
    fn reset(&self) {
        self.get().reset();
    }
}
