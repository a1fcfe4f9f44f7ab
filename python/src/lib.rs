//! The module `durometer._native`: the program as a function, and the classes of the package `durometer`, one file each.
//!
//! The package in `python/durometer` contains what is easier in Python: exceptions, progress bars, pandas and pyvista.

mod array;
mod built;
mod calibration;
mod controller;
mod error;
mod fit;
mod invariants;
mod keys;
mod law;
mod python_law;
mod raised;
mod report;
mod run;
mod scene;
mod sensitivities;
mod solution;
mod solve;
mod study;
mod threads;
mod twin;
mod value;

use pyo3::PyClass;
use pyo3::prelude::*;
use std::ffi::OsString;
use std::sync::Arc;

/// Runs the command line `durometer` with these arguments, without its name, and returns the exit code: 0 done, 2 bad input, 3 not complete. An
/// exception of a law in Python is raised. If `owns_process`, a closed pipe may end the process.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<OsString>, owns_process: bool) -> PyResult<u8> {
    let link = Arc::new(solve::Link::by(durometer_commands::interrupt::flag().clone()));
    let code = py.detach(|| signals_kept(|| command(arguments, owns_process, &link)));
    link.raised().map_or(Ok(code), Err)
}

/// Runs the command line in a session that continues, such as a notebook: Ctrl-C stops the command as on the command line, and is raised when the command
/// has ended.
#[pyfunction]
fn main_in_session(py: Python<'_>, arguments: Vec<OsString>) -> PyResult<u8> {
    let link = solve::Link::by(durometer_commands::interrupt::flag().clone());
    solve::followed(py, link, None, |link| command(arguments, false, link))
}

/// Runs the command line, which an exception of a law in Python ends.
fn command(arguments: Vec<OsString>, owns_process: bool, link: &Arc<solve::Link>) -> u8 {
    let _turn = raised::Raised::by(link);
    durometer_commands::main(std::iter::once("durometer".into()).chain(arguments), owns_process)
}

/// Does work that may block signals in this thread, and restores the signal mask afterwards, because the thread is Python's.
#[cfg(unix)]
fn signals_kept<T>(work: impl FnOnce() -> T) -> T {
    let before = nix::sys::signal::SigSet::thread_get_mask();
    let done = work();
    before.and_then(|mask| mask.thread_set_mask()).ok();
    done
}

#[cfg(not(unix))]
fn signals_kept<T>(work: impl FnOnce() -> T) -> T {
    work()
}

/// Tells the program which interpreter has loaded it; it uses this interpreter to start itself and the mesher.
#[pyfunction]
fn set_python(file: std::path::PathBuf) {
    durometer::catalogue::host::set_python(file);
}

/// Sets the number of threads for the work that follows; InputError for a number that the program would refuse, and in a process that was forked without
/// its threads.
#[pyfunction]
#[pyo3(signature = (threads))]
fn set_threads(threads: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
    threads::set(threads)?;
    threads::check_fork()
}

/// Alignment of the memory of Python objects \[bytes\], which pyo3 does not compare with that of a class.
const ALIGNMENT: usize = 16;

/// Checks the alignment of a class. A class whose values need more, such as SIMD lanes, must keep them in a box.
const fn is_aligned<T: PyClass>() {
    assert!(align_of::<T>() <= ALIGNMENT, "Python has no memory of this alignment: keep the values in a box");
}

// The check of all classes
const _: () = {
    is_aligned::<array::Numbers>();
    is_aligned::<calibration::Calibration>();
    is_aligned::<controller::Observation>();
    is_aligned::<fit::Fit>();
    is_aligned::<invariants::Invariants>();
    is_aligned::<run::Run>();
    is_aligned::<scene::Scene>();
    is_aligned::<sensitivities::Sensitivities>();
    is_aligned::<study::Study>();
    is_aligned::<twin::Twin>();
};

#[pymodule]
#[pyo3(name = "_native")]
mod native {
    #[pymodule_export]
    use super::{
        calibration::Calibration, controller::Observation, fit::Fit, invariants::Invariants, law::check_law,
        law::register_law, main, main_in_session, report::write_report, run::Run, scene::Scene,
        sensitivities::Sensitivities, set_python, set_threads, study::Study, twin::Twin,
    };
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        durometer_commands::bring_files();
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
