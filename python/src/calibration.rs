//! The class `Calibration`: identifies numbers of a scene from measured curves by simulating them.

use crate::array::own_array;
use crate::error::{incomplete, input, refused, with_result};
use crate::keys::parsed;
use crate::raised::Raised;
use crate::scene::Scene;
use crate::solve::{Link, ended};
use crate::threads;
use crate::value::{entries, is_list, kind, numbers, plain, toml_of};
use durometer::calibrate::Weighting;
use durometer::calibrate::inverse::{
    Bounds, Calibration as Found, Failure, FittedCurve, Measured, ObservedCurve, SceneModel, SearchWatch, Settings,
    Unknown, calibrate,
};
use durometer::math::units::Dimension;
use durometer::scene::{ParameterKey, Progress};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};

/// Numbers of a scene that best reproduce measured curves, with their intervals and the directions that the curves do not determine.
#[pyclass(module = "durometer", frozen)]
pub struct Calibration {
    found: Found,
    scene: Py<Scene>,
}

#[pymethods]
impl Calibration {
    /// Finds numbers that all scenes of `curves`, a list of `durometer.Curve`, share. The search begins at the values of the first scene.
    ///
    /// `unknowns`: keys such as "laws.rubber.mu", or a dictionary of key and bounds (lower, upper), each a text with its unit or a number in SI units;
    /// None as bounds for the whole admissible range. Results are in the order of the keys.
    /// `weight`: "absolute", "relative" or "noise". `accuracy`: relative accuracy to which the scenes can reproduce the curves. `profile`: also compute
    /// intervals by profile likelihood. `threads` and `progress` as in `Scene.run`; `progress` follows each forward solve, which ends with the last data
    /// point, and the end of the search. `check`: raise `RunError` if the search does not converge. If the search is ended early, by an incomplete run or
    /// by Ctrl-C, `result` of the exception has the best values so far, by key `[SI]`, or None if none were better than the first.
    #[staticmethod]
    #[pyo3(signature = (curves, unknowns, *, weight = "absolute", accuracy = 0.01, profile = false, threads = None, progress = None, check = true))]
    fn from_curves(
        py: Python<'_>,
        curves: &Bound<'_, PyAny>,
        unknowns: &Bound<'_, PyAny>,
        weight: &str,
        accuracy: f64,
        profile: bool,
        threads: Option<&Bound<'_, PyAny>>,
        progress: Option<&Bound<'_, PyAny>>,
        check: bool,
    ) -> PyResult<Self> {
        threads::set(threads)?;
        let follower = crate::run::follower(py, progress)?;
        let weighting: Weighting = weight.parse().map_err(refused::<String>)?;
        if !(accuracy > 0.0 && accuracy < 1.0) {
            return Err(input(&format!("accuracy is {accuracy}"), "give a share between 0 and 1, such as 0.01"));
        }
        let settings = Settings { profile, accuracy, ..Settings::new(weighting) };
        let no_list = |_| {
            input(&format!("curves is of the type {}, and no list", kind(curves)), "give a list of durometer.Curve")
        };
        let curves = curves.try_iter().map_err(no_list)?.collect::<PyResult<Vec<_>>>()?;
        let first = curves.first().ok_or_else(|| input("no curve is given", "give a list of durometer.Curve"))?;
        let scene = scene_of(first)?;
        let (keys, bounds) = wanted(unknowns, scene.get())?;
        let observed = curves.iter().map(|curve| observed(curve, &keys, &bounds)).collect::<PyResult<Vec<_>>>()?;
        let ((answer, best), raised) = ended(py, Link::default(), follower.as_ref(), |link| {
            let mut watch = Following { link, best: None, end: 1.0 };
            let _turn = Raised::by(link);
            let answer = calibrate(observed, &settings, None, &mut watch);
            if answer.is_ok() {
                link.progress(Progress { t: watch.end, end: watch.end });
            }
            (answer.map(|(found, _)| found), watch.best)
        })?;
        let so_far = || match best {
            Some(values) => Ok(keys.iter().map(ToString::to_string).zip(values).into_py_dict(py)?.into_any().unbind()),
            None => Ok::<_, PyErr>(py.None()),
        };
        if let Some(why) = raised {
            return Err(with_result(py, why, so_far()?));
        }
        let found = match answer {
            Ok(found) => found,
            Err(Failure::Input(why)) => return Err(refused(why)),
            Err(Failure::Constants(why)) => return Err(refused(why)),
            Err(Failure::Run(status)) => {
                return Err(incomplete(status.name(), &status.fact(), status.remedy(), so_far()?));
            }
            Err(Failure::Interrupted) => {
                return Err(incomplete("Interrupted", "the search was stopped", "run it again", so_far()?));
            }
        };
        let settled = found.settled();
        let this = Self { found, scene };
        if check && !settled {
            let (fact, remedy) = ("the search did not come to its end", "take another start, or fewer unknowns");
            return Err(incomplete("NotSettled", fact, remedy, Py::new(py, this)?.into_any()));
        }
        Ok(this)
    }

    /// Key → value `[SI]`, in the order of `unknowns`.
    #[getter]
    fn constants<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.found.constants.iter().map(|f| (&f.key, f.value)).into_py_dict(py)
    }

    /// Key → its SI unit; `1` for a dimensionless number.
    #[getter]
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let unit = |key: &str| -> PyResult<&'static str> {
            let key: ParameterKey = key.parse().map_err(refused)?;
            Ok(key.value(self.scene.get().table()).map_err(refused)?.dimension.si_unit())
        };
        let all = self.found.constants.iter().map(|f| Ok((&f.key, unit(&f.key)?)));
        all.collect::<PyResult<Vec<_>>>()?.into_py_dict(py)
    }

    /// Key → both ends of the 95 % interval `[SI]`; None if the curves do not determine the number.
    #[getter]
    fn intervals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let ends = |interval: Option<[f64; 2]>| interval.map(<(f64, f64)>::from);
        self.found.constants.iter().map(|f| (&f.key, ends(f.interval))).into_py_dict(py)
    }

    /// Covariance `[unknowns × unknowns]` `[SI²]`, in the order of `constants`; None if a direction is not determined.
    #[getter]
    fn covariance(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        let n = self.found.constants.len();
        self.found.covariance.as_ref().map(|rows| own_array(py, rows.concat(), [n, n])).transpose()
    }

    /// Directions that the curves do not determine, as text.
    #[getter]
    fn unidentified(&self) -> Vec<String> {
        self.found.unidentified.clone()
    }

    /// Notes on the treatment of the measured points, e.g. that points beyond the range of the protocol were left out.
    #[getter]
    fn notes(&self) -> Vec<String> {
        let of = |curve: &FittedCurve| {
            let note = |note: &String| format!("curve {}: {note}", curve.name);
            curve.measured.notes.iter().map(note).collect::<Vec<_>>()
        };
        self.found.curves.iter().flat_map(of).collect()
    }

    /// Whether the search converged.
    #[getter]
    fn settled(&self) -> bool {
        self.found.settled()
    }

    /// Number of forward solves of the search.
    #[getter]
    fn solves(&self) -> usize {
        self.found.solves
    }

    /// The complete result: curves with their predictions, offsets, errors.
    #[getter]
    fn result<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.found)
    }

    /// The scene of the first curve with the identified values.
    #[getter]
    fn scene(&self) -> PyResult<Scene> {
        let mut constants = self.found.constants.iter();
        let Some(first) = constants.next() else { return Err(input("nothing was found", "")) };
        let scene = self.scene.get().with_si(&first.key, first.value)?;
        constants.try_fold(scene, |scene, found| scene.with_si(&found.key, found.value))
    }

    /// The numbers with their intervals as a pandas table.
    #[getter]
    fn frame<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("durometer._frames")?.call_method1("of_constants", (slf,))
    }

    fn __repr__(&self) -> String {
        let one = |f: &durometer::calibrate::inverse::FittedConstant| format!("{} = {:.6e} {}", f.key, f.value, f.unit);
        format!("<Calibration {}>", self.found.constants.iter().map(one).collect::<Vec<_>>().join(", "))
    }
}

/// Follows a search, and keeps the best values so far.
struct Following<'a> {
    link: &'a Link,
    best: Option<Vec<f64>>,
    /// End time of the last forward solve \[s\]
    end: f64,
}

impl SearchWatch for Following<'_> {
    fn progress(&mut self, now: Progress) -> bool {
        self.end = now.end;
        self.link.progress(now)
    }

    fn better(&mut self, values: &[f64]) {
        self.best = Some(values.to_vec());
    }
}

/// Parses the keys and their bounds.
fn wanted(unknowns: &Bound<'_, PyAny>, scene: &Scene) -> PyResult<(Vec<ParameterKey>, Bounds)> {
    let Some(bounded) = entries(unknowns)? else { return Ok((parsed(unknowns)?, Bounds::new())) };
    let mut bounds = Bounds::new();
    for (key, ends) in bounded.iter().filter(|(_, ends)| !ends.is_none()) {
        let wrong = || {
            let fact = format!("the bounds of {key} are of the type {}, and no pair", kind(ends));
            input(&fact, "write for example (\"10 kPa\", \"1 MPa\")")
        };
        let listed = if is_list(ends) { ends.clone() } else { ends.call_method0("tolist").map_err(|_| wrong())? };
        let listed: Vec<Bound<'_, PyAny>> = listed.try_iter().and_then(Iterator::collect).map_err(|_| wrong())?;
        let [lower, upper] = &listed[..] else { return Err(wrong()) };
        bounds.insert(key.clone(), [bound(scene, key, lower)?, bound(scene, key, upper)?]);
    }
    let keys = bounded.into_iter().map(|(key, _)| key).collect::<Vec<_>>();
    Ok((parsed(keys.into_pyobject(unknowns.py())?.as_any())?, bounds))
}

/// Parses a bound: a text with its unit, or a number in SI units, which is written in the unit of the value in the scene if that has one.
fn bound(scene: &Scene, key: &str, end: &Bound<'_, PyAny>) -> PyResult<toml::Value> {
    match end.extract::<f64>() {
        Ok(number) => {
            let value = key.parse::<ParameterKey>().map_err(refused)?.value(scene.table()).map_err(refused)?;
            let has_own = value.unit.is_some() || value.dimension == Dimension::NONE;
            Ok(if has_own {
                value.written_si(number)
            } else {
                format!("{number} {}", value.dimension.si_unit()).into()
            })
        }
        Err(_) => toml_of(end),
    }
}

/// Returns the scene of a curve.
fn scene_of(curve: &Bound<'_, PyAny>) -> PyResult<Py<Scene>> {
    let remedy = "give a list of durometer.Curve, each with its scene";
    let no_curve = |_| input(&format!("a curve is of the type {}, and no durometer.Curve", kind(curve)), remedy);
    let scene = curve.getattr("scene").map_err(no_curve)?;
    let fact = || format!("the scene of a curve is of the type {}, and no durometer.Scene", kind(&scene));
    scene.extract().map_err(|_| input(&fact(), remedy))
}

/// Converts a `durometer.Curve` with its scene.
fn observed(curve: &Bound<'_, PyAny>, keys: &[ParameterKey], bounds: &Bounds) -> PyResult<ObservedCurve> {
    let py = curve.py();
    let scene = scene_of(curve)?;
    let text = |name: &str| {
        let given = curve.getattr(name)?;
        let fact = || format!("{name} of a curve is of the type {}, and no text", kind(&given));
        given.extract::<String>().map_err(|_| input(&fact(), "name it by a text"))
    };
    let (x, y) = (numbers("x", &curve.getattr("x")?)?, numbers("y", &curve.getattr("y")?)?);
    if x.len() != y.len() {
        return Err(input(&format!("a curve has {} x and {} y", x.len(), y.len()), "give one y for each x"));
    }
    let (file, built) = (scene.get().file().to_path_buf(), scene.get().build(py, None)?.scene);
    let (spec, text_of_scene) = (built.spec.clone(), built.text.clone());
    let unknown = Unknown::all((&file, &spec, &text_of_scene), keys, bounds).map_err(refused)?;
    let body = built.body.clone();
    let model = SceneModel { file, spec, text: text_of_scene, body, unknown, x: text("over")?, y: text("column")? };
    let bytes: Vec<u8> = x.iter().chain(&y).flat_map(|v| v.to_le_bytes()).collect();
    let lines = (1..=x.len() as u64).collect();
    let sha256 = durometer::storage::sha256(&bytes);
    let measured = Measured { file: "arrays".into(), sha256, x, y, lines, notes: vec![] };
    let specimen = curve.getattr("specimen")?.extract()?;
    Ok(ObservedCurve { name: text("name")?, model, measured, specimen, offsets: vec![] })
}
