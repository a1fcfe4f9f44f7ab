//! numpy arrays that take over numbers of the library by the buffer protocol: without a copy, and without a numpy crate, whose dependencies
//! would change the features of the solver's dependencies. They are read-only, so that recorded results stay as computed.

use pyo3::exceptions::PyBufferError;
use pyo3::ffi;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::ffi::c_int;

/// Numbers that Python owns and that numpy arrays are views of.
#[pyclass(module = "durometer._native", frozen)]
pub struct Numbers(Box<[f64]>);

#[pymethods]
impl Numbers {
    /// # Safety
    ///
    /// Python must call it with a valid `view` to fill in.
    unsafe fn __getbuffer__(slf: Bound<'_, Self>, view: *mut ffi::Py_buffer, flags: c_int) -> PyResult<()> {
        let numbers = &slf.get().0;
        let start = numbers.as_ptr().cast_mut().cast();
        let bytes = ffi::Py_ssize_t::try_from(size_of_val(&**numbers))
            .map_err(|_| PyBufferError::new_err("more numbers than Python can address"))?;
        // SAFETY: the numbers are never moved, and live as long as this object, which the view keeps alive. Nobody writes to them: the view is
        // read-only.
        let failed = unsafe { ffi::PyBuffer_FillInfo(view, slf.as_ptr(), start, bytes, 1, flags) };
        if failed == 0 { Ok(()) } else { Err(PyErr::fetch(slf.py())) }
    }
}

/// Returns a read-only array of this shape over the numbers.
pub fn array<const N: usize>(py: Python<'_>, numbers: Vec<f64>, shape: [usize; N]) -> PyResult<Py<PyAny>> {
    // numpy cannot make a view of an empty buffer
    let view = match numbers.is_empty() {
        true => py.import("numpy")?.call_method1("zeros", (0,))?,
        false => {
            let numbers = Bound::new(py, Numbers(numbers.into()))?;
            py.import("numpy")?.call_method1("frombuffer", (numbers, "float64"))?
        }
    };
    Ok(view.call_method1("reshape", (shape.to_vec(),))?.unbind())
}

/// Returns a writable array, for numbers that are computed anew at every call.
pub fn own_array<const N: usize>(py: Python<'_>, numbers: Vec<f64>, shape: [usize; N]) -> PyResult<Py<PyAny>> {
    array(py, numbers, shape)?.call_method0(py, "copy")
}

/// Returns a read-only array with a copy of integers.
pub fn indices(py: Python<'_>, numbers: &[u32], shape: [usize; 2]) -> PyResult<Py<PyAny>> {
    let bytes: Vec<u8> = numbers.iter().flat_map(|k| k.to_ne_bytes()).collect();
    let view = py.import("numpy")?.call_method1("frombuffer", (PyBytes::new(py, &bytes), "uint32"))?;
    Ok(view.call_method1("reshape", (shape.to_vec(),))?.unbind())
}
