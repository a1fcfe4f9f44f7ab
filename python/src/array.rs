//! Arrays of numpy that take numbers of the library over, by the buffer protocol: without a copy, and without a crate for numpy, whose dependencies
//! would change the features of those of the solver.

use pyo3::exceptions::PyBufferError;
use pyo3::ffi;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::cell::UnsafeCell;
use std::ffi::c_int;

/// Numbers that Python owns; arrays of numpy are views of them.
#[pyclass(module = "durometer._native", frozen)]
pub struct Numbers(Box<[UnsafeCell<f64>]>);

// SAFETY: the library never reads or writes them again once they are here. Threads of Python that share an array of numpy share its numbers as they
// always do.
unsafe impl Sync for Numbers {}

#[pymethods]
impl Numbers {
    /// # Safety
    ///
    /// Python calls it with a `view` to fill in.
    unsafe fn __getbuffer__(slf: Bound<'_, Self>, view: *mut ffi::Py_buffer, flags: c_int) -> PyResult<()> {
        let numbers = &slf.get().0;
        let start = numbers.as_ptr().cast_mut().cast();
        let bytes = ffi::Py_ssize_t::try_from(size_of_val(&**numbers))
            .map_err(|_| PyBufferError::new_err("more numbers than Python can address"))?;
        // SAFETY: the numbers are never moved, and live as long as this object, which the view keeps alive.
        let failed = unsafe { ffi::PyBuffer_FillInfo(view, slf.as_ptr(), start, bytes, 0, flags) };
        if failed == 0 { Ok(()) } else { Err(PyErr::fetch(slf.py())) }
    }
}

/// An array of this shape over the numbers.
pub fn array<const N: usize>(py: Python<'_>, numbers: Vec<f64>, shape: [usize; N]) -> PyResult<Py<PyAny>> {
    // numpy makes no view of nothing
    let view = match numbers.is_empty() {
        true => py.import("numpy")?.call_method1("zeros", (0,))?,
        false => {
            let cells: Box<[UnsafeCell<f64>]> = numbers.into_iter().map(UnsafeCell::new).collect();
            py.import("numpy")?.call_method1("frombuffer", (Bound::new(py, Numbers(cells))?, "float64"))?
        }
    };
    Ok(view.call_method1("reshape", (shape.to_vec(),))?.unbind())
}

/// An array of whole numbers, a copy.
pub fn indices(py: Python<'_>, numbers: &[u32], shape: [usize; 2]) -> PyResult<Py<PyAny>> {
    let bytes: Vec<u8> = numbers.iter().flat_map(|k| k.to_ne_bytes()).collect();
    let view = py.import("numpy")?.call_method1("frombuffer", (PyBytes::new(py, &bytes), "uint32"))?;
    Ok(view.call_method1("reshape", (shape.to_vec(),))?.unbind())
}
