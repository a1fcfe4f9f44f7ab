//! The class `Invariants`: invariants of a deformation gradient without cancellation, for laws in Python.

use crate::value::{finite, tensor};
use durometer::prelude::Invariants as Of;
use pyo3::prelude::*;

/// Invariants of F with J > 0 that stay accurate for F near the identity: J, J − 1, ln J, I₁ − 3, I₁ − 3 − 2 ln J, and cof F.
///
/// >>> import durometer, numpy
/// >>> durometer.Invariants(numpy.diag([1 + 1e-9, 1.0, 1.0])).J_minus_1
/// 1.000000082740371e-09
#[pyclass(module = "durometer", frozen)]
pub struct Invariants(Of);

#[pymethods]
impl Invariants {
    #[new]
    fn new(gradient: &Bound<'_, PyAny>) -> PyResult<Self> {
        let f = tensor("F", gradient)?;
        finite("F", f.transpose().as_slice())?;
        Of::of_positive(&f).map(Self).map_err(crate::error::refused)
    }

    /// det F.
    #[getter(J)]
    fn j(&self) -> f64 {
        self.0.j
    }

    /// det F − 1.
    #[getter(J_minus_1)]
    fn j_minus_1(&self) -> f64 {
        self.0.x
    }

    /// ln det F.
    #[getter(ln_J)]
    fn ln_j(&self) -> f64 {
        self.0.ln_j()
    }

    /// F:F − 3.
    #[getter(I1_minus_3)]
    fn i1_minus_3(&self) -> f64 {
        self.0.i
    }

    /// F:F − 3 − 2 ln J, which is never negative.
    #[getter(I1_minus_3_minus_2_ln_J)]
    fn i1_minus_3_minus_2_ln_j(&self) -> f64 {
        self.0.i_2ln(self.0.ln_j())
    }

    /// Cofactor J F⁻ᵀ `[3 × 3]`.
    #[getter]
    fn cofactor(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        crate::array::own_array(py, self.0.cof.transpose().as_slice().to_vec(), [3, 3])
    }
}
