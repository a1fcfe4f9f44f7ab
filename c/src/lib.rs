//! The C interface of reduced models, which `include/durometer.h` declares and describes: pointers outside, [`durometer::reduction`] inside.
//!
//! No panic leaves a function: it becomes `DUROMETER_INTERNAL`, or null.

use durometer::reduction::running::inverse::{Target, reach};
use durometer::reduction::{ReducedModel, StepError, Twin};
use std::ffi::{CStr, CString, c_char, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::ptr::null;

const DONE: c_int = 0;
const INTERNAL: c_int = 1;
const BAD_INPUT: c_int = 2;
const NOT_SOLVED: c_int = 3;

/// The type behind `durometer_twin`: a model, and its names as C strings.
pub struct Handle {
    twin: Twin,
    inputs: Vec<CString>,
    quantities: Vec<CString>,
}

impl Handle {
    fn open(path: PathBuf) -> Result<Self, String> {
        let model = ReducedModel::read(&path).map_err(|e| e.to_string())?;
        let name = |name: &String| CString::new(name.as_str()).map_err(|_| "a name holds a null character".to_string());
        let inputs = model.inputs.iter().map(|i| name(&i.name)).collect::<Result<_, _>>()?;
        let quantities = model.quantities.iter().map(|q| name(&q.name)).collect::<Result<_, _>>()?;
        Ok(Self { twin: Twin::new(model).map_err(|e| e.to_string())?, inputs, quantities })
    }
}

/// Returns the result of `work` on a model; `without` if the pointer is null, `failed` if the work panics.
///
/// # Safety
///
/// `twin` is null or from `durometer_twin_open`, not closed, and used by this thread alone.
unsafe fn with<T>(twin: *const Handle, without: T, failed: T, work: impl FnOnce(&Handle) -> T) -> T {
    // SAFETY: as above
    let Some(handle) = (unsafe { twin.as_ref() }) else { return without };
    catch_unwind(AssertUnwindSafe(|| work(handle))).unwrap_or(failed)
}

/// Returns the status of `work` that changes a model; `BAD_INPUT` if the pointer is null, `INTERNAL` if the work panics.
///
/// # Safety
///
/// As [`with`].
unsafe fn change(twin: *mut Handle, work: impl FnOnce(&mut Twin) -> c_int) -> c_int {
    // SAFETY: as above
    let Some(handle) = (unsafe { twin.as_mut() }) else { return BAD_INPUT };
    catch_unwind(AssertUnwindSafe(|| work(&mut handle.twin))).unwrap_or(INTERNAL)
}

/// Returns a C array as a slice; `None` if the pointer is null.
///
/// # Safety
///
/// `start` is null or points to `count` values that live for 'a.
unsafe fn array<'a, T>(start: *const T, count: usize) -> Option<&'a [T]> {
    // SAFETY: as above
    (!start.is_null()).then(|| unsafe { std::slice::from_raw_parts(start, count) })
}

fn status(error: StepError) -> c_int {
    match error {
        StepError::Count { .. } | StepError::NotFinite(_) | StepError::Constant(_) => BAD_INPUT,
        StepError::NoEquilibrium => NOT_SOLVED,
    }
}

/// # Safety
///
/// `path` is null or a string; `message` is null or has room for `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn durometer_twin_open(path: *const c_char, message: *mut c_char, size: usize) -> *mut Handle {
    let opened = if path.is_null() {
        Err("the path is null".to_string())
    } else {
        // SAFETY: as above
        let path = PathBuf::from(unsafe { CStr::from_ptr(path) }.to_string_lossy().into_owned());
        catch_unwind(|| Handle::open(path)).unwrap_or_else(|_| Err("an error of the program; please report it".into()))
    };
    match opened {
        Ok(handle) => Box::into_raw(Box::new(handle)),
        Err(why) => {
            if !message.is_null() && size > 0 {
                let fits = |&length: &usize| why.is_char_boundary(length);
                let length = (0..=why.len().min(size - 1)).rev().find(fits).unwrap_or(0);
                // SAFETY: `length` + 1 ≤ `size` bytes
                unsafe {
                    std::ptr::copy_nonoverlapping(why.as_ptr().cast(), message, length);
                    *message.add(length) = 0;
                }
            }
            std::ptr::null_mut()
        }
    }
}

/// # Safety
///
/// `twin` is null or from `durometer_twin_open`, and is not used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn durometer_twin_close(twin: *mut Handle) {
    if !twin.is_null() {
        // SAFETY: it was made by `Box::into_raw`
        let handle = unsafe { Box::from_raw(twin) };
        drop(catch_unwind(AssertUnwindSafe(|| drop(handle))));
    }
}

/// # Safety
///
/// As [`with`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn durometer_twin_inputs(twin: *const Handle) -> usize {
    // SAFETY: as above
    unsafe { with(twin, 0, 0, |h| h.inputs.len()) }
}

/// # Safety
///
/// As [`with`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn durometer_twin_quantities(twin: *const Handle) -> usize {
    // SAFETY: as above
    unsafe { with(twin, 0, 0, |h| h.quantities.len()) }
}

/// # Safety
///
/// As [`with`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn durometer_twin_input_name(twin: *const Handle, input: usize) -> *const c_char {
    // SAFETY: as above
    unsafe { with(twin, null(), null(), |h| h.inputs.get(input).map_or(null(), |name| name.as_ptr())) }
}

/// # Safety
///
/// As [`with`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn durometer_twin_quantity_name(twin: *const Handle, quantity: usize) -> *const c_char {
    // SAFETY: as above
    unsafe { with(twin, null(), null(), |h| h.quantities.get(quantity).map_or(null(), |name| name.as_ptr())) }
}

/// # Safety
///
/// As [`with`]; `range` is null or has room for two numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn durometer_twin_range(twin: *const Handle, input: usize, range: *mut f64) -> c_int {
    let of = |h: &Handle| h.twin.model().inputs.get(input).map(|i| i.range);
    // SAFETY: as above
    let found = unsafe { with(twin, None, None, of) };
    match found {
        Some([least, largest]) if !range.is_null() => {
            // SAFETY: as above
            unsafe {
                *range = least;
                *range.add(1) = largest;
            }
            DONE
        }
        _ => BAD_INPUT,
    }
}

/// # Safety
///
/// As [`with`]; `inputs` is null or has `count` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn durometer_twin_step(twin: *mut Handle, inputs: *const f64, count: usize) -> c_int {
    // SAFETY: as above
    let Some(inputs) = (unsafe { array(inputs, count) }) else { return BAD_INPUT };
    // SAFETY: as above
    unsafe { change(twin, |twin| twin.step(inputs).map_or_else(status, |_| DONE)) }
}

/// # Safety
///
/// As [`with`]; the arrays are null or have `count` values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn durometer_twin_reach(
    twin: *mut Handle,
    quantities: *const usize,
    values: *const f64,
    tolerances: *const f64,
    count: usize,
) -> c_int {
    // SAFETY: as above
    let arrays = unsafe { (array(quantities, count), array(values, count), array(tolerances, count)) };
    let (Some(quantities), Some(values), Some(tolerances)) = arrays else { return BAD_INPUT };
    let target = |((&quantity, &value), &tolerance): ((&usize, &f64), &f64)| Target { quantity, value, tolerance };
    let search = |twin: &mut Twin| {
        let known = twin.values().len();
        let targets: Vec<Target> = quantities.iter().zip(values).zip(tolerances).map(target).collect();
        let sound = |t: &Target| t.quantity < known && t.value.is_finite() && t.tolerance > 0.0;
        if targets.is_empty() || !targets.iter().all(sound) {
            return BAD_INPUT;
        }
        reach(twin, &targets).map_or_else(status, |reached| if reached.met { DONE } else { NOT_SOLVED })
    };
    // SAFETY: as above
    unsafe { change(twin, search) }
}

/// # Safety
///
/// As [`with`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn durometer_twin_reset(twin: *mut Handle) -> c_int {
    let reset = |twin: &mut Twin| {
        twin.reset();
        DONE
    };
    // SAFETY: as above
    unsafe { change(twin, reset) }
}

/// # Safety
///
/// As [`with`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn durometer_twin_dt(twin: *const Handle) -> f64 {
    // SAFETY: as above
    unsafe { with(twin, 0.0, 0.0, |h| h.twin.dt().unwrap_or(0.0)) }
}

/// # Safety
///
/// As [`with`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn durometer_twin_time(twin: *const Handle) -> f64 {
    // SAFETY: as above
    unsafe { with(twin, 0.0, 0.0, |h| h.twin.time().unwrap_or(0.0)) }
}

/// # Safety
///
/// As [`with`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn durometer_twin_present_inputs(twin: *const Handle) -> *const f64 {
    // SAFETY: as above
    unsafe { with(twin, null(), null(), |h| h.twin.inputs().as_ptr()) }
}

/// # Safety
///
/// As [`with`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn durometer_twin_in_range(twin: *const Handle) -> c_int {
    // SAFETY: as above
    unsafe { with(twin, 0, 0, |h| c_int::from(h.twin.in_range())) }
}

/// # Safety
///
/// As [`with`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn durometer_twin_values(twin: *const Handle) -> *const f64 {
    // SAFETY: as above
    unsafe { with(twin, null(), null(), |h| h.twin.values().as_ptr()) }
}

/// # Safety
///
/// As [`with`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn durometer_twin_bars(twin: *const Handle) -> *const f64 {
    // SAFETY: as above
    unsafe { with(twin, null(), null(), |h| h.twin.bars().as_ptr()) }
}

/// # Safety
///
/// As [`with`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn durometer_twin_estimates(twin: *const Handle) -> *const f64 {
    // SAFETY: as above
    unsafe { with(twin, null(), null(), |h| h.twin.estimates().as_ptr()) }
}

/// # Safety
///
/// As [`with`]; `out` is null or has room for `count` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn durometer_twin_sensitivities(twin: *mut Handle, out: *mut f64, count: usize) -> c_int {
    if out.is_null() {
        return BAD_INPUT;
    }
    // SAFETY: as above
    let out = unsafe { std::slice::from_raw_parts_mut(out, count) };
    let derive = |twin: &mut Twin| {
        if out.len() != twin.values().len() * twin.inputs().len() {
            return BAD_INPUT;
        }
        twin.sensitivities(out);
        if out.iter().all(|x| x.is_finite()) { DONE } else { NOT_SOLVED }
    };
    // SAFETY: as above
    unsafe { change(twin, derive) }
}
