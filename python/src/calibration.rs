//! The class `Calibration`: numbers of a scene from measured curves, by simulating them.

use crate::array::array;
use crate::error::{incomplete, input, refused};
use crate::law::Raised;
use crate::scene::Scene;
use crate::solve::apart;
use crate::value::{numbers, plain, toml_of};
use durometer::calibrate::Weighting;
use durometer::calibrate::inverse::{
    Bounds, Calibration as Found, Failure, Measured, ObservedCurve, SceneModel, Settings, Unknown, calibrate,
};
use durometer::scene::{ParameterKey, Progress};
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Numbers of a scene that reproduce measured curves best, with intervals and what the curves do not determine.
#[pyclass(module = "durometer", frozen)]
pub struct Calibration {
    found: Found,
    scene: Py<Scene>,
}

#[pymethods]
impl Calibration {
    /// Finds numbers of the scenes of `curves`, of `durometer.Curve`, which all of them share. The search begins at the values of the first scene.
    ///
    /// `unknowns`: keys such as "laws.rubber.mu", or a dictionary of key and (lower, upper), each a text with its unit or a number.
    /// `weight`: "absolute", "relative" or "noise". `accuracy`: to which the scenes can reproduce the curves. `profile`: intervals by profile
    /// likelihood too. `progress` as in `Scene.run`, for each forward solve. `check`: raise `RunError` where the search does not settle.
    #[staticmethod]
    #[pyo3(signature = (curves, unknowns, *, weight = "absolute", accuracy = 0.01, profile = false, progress = None, check = true))]
    fn from_curves(
        py: Python<'_>,
        curves: Vec<Bound<'_, PyAny>>,
        unknowns: &Bound<'_, PyAny>,
        weight: &str,
        accuracy: f64,
        profile: bool,
        progress: Option<&Bound<'_, PyAny>>,
        check: bool,
    ) -> PyResult<Self> {
        let follower = crate::run::follower(py, progress)?;
        let (keys, bounds) = wanted(unknowns)?;
        let weighting: Weighting = weight.parse().map_err(refused::<String>)?;
        let settings = Settings { profile, accuracy, ..Settings::new(weighting) };
        let observed = curves.iter().map(|curve| observed(curve, &keys, &bounds)).collect::<PyResult<Vec<_>>>()?;
        let first = curves.first().ok_or_else(|| input("no curve is given", "give a list of durometer.Curve"))?;
        let scene: Py<Scene> = first.getattr("scene")?.extract()?;
        let answer = apart(py, follower.as_ref(), |link| {
            let search = || calibrate(observed, &settings, None, &mut |now: Progress| link.progress(now));
            Arc::new(Raised::default()).during(link, search).map(|(found, _)| found)
        })?;
        let found = answer.map_err(|failure| match failure {
            Failure::Input(why) => refused(why),
            Failure::Constants(why) => refused(why),
            Failure::Run(status) => incomplete(status.name(), &status.fact(), status.remedy(), py.None()),
            Failure::Interrupted => incomplete("Interrupted", "the search was stopped", "run it again", py.None()),
        })?;
        let settled = found.settled();
        let this = Self { found, scene };
        if check && !settled {
            let (fact, remedy) = ("the search did not come to its end", "take another start, or fewer unknowns");
            return Err(incomplete("NotSettled", fact, remedy, Py::new(py, this)?.into_any()));
        }
        Ok(this)
    }

    /// Key → value \[SI\].
    #[getter]
    fn constants(&self) -> BTreeMap<&str, f64> {
        self.found.constants.iter().map(|f| (f.key.as_str(), f.value)).collect()
    }

    /// Key → its SI unit.
    #[getter]
    fn units(&self) -> BTreeMap<&str, &str> {
        self.found.constants.iter().map(|f| (f.key.as_str(), f.unit.as_str())).collect()
    }

    /// Key → both ends of the 95 % interval \[SI\]; none where the curves do not determine the number.
    #[getter]
    fn intervals(&self) -> BTreeMap<&str, Option<(f64, f64)>> {
        self.found.constants.iter().map(|f| (f.key.as_str(), f.interval.map(Into::into))).collect()
    }

    /// \[unknowns × unknowns\] \[SI²\]; none where a direction is not determined.
    #[getter]
    fn covariance(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        let n = self.found.constants.len();
        self.found.covariance.as_ref().map(|rows| array(py, rows.concat(), [n, n])).transpose()
    }

    /// Directions that the curves do not determine, in words.
    #[getter]
    fn unidentified(&self) -> Vec<String> {
        self.found.unidentified.clone()
    }

    /// Whether the search came to its end.
    #[getter]
    fn settled(&self) -> bool {
        self.found.settled()
    }

    /// Forward solves of the search.
    #[getter]
    fn solves(&self) -> usize {
        self.found.solves
    }

    /// Everything: curves with what is predicted, offsets, errors.
    #[getter]
    fn result<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.found)
    }

    /// The scene of the first curve with the values that were found.
    #[getter]
    fn scene(&self) -> PyResult<Scene> {
        let mut constants = self.found.constants.iter();
        let Some(first) = constants.next() else { return Err(input("nothing was found", "")) };
        let scene = self.scene.get().with_si(&first.key, first.value)?;
        constants.try_fold(scene, |scene, found| scene.with_si(&found.key, found.value))
    }

    /// The numbers with their intervals as a table of pandas.
    #[getter]
    fn frame<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("durometer._frames")?.call_method1("of_constants", (slf,))
    }

    fn __repr__(&self) -> String {
        let one = |f: &durometer::calibrate::inverse::Found| format!("{} = {:.6e} {}", f.key, f.value, f.unit);
        format!("<Calibration {}>", self.found.constants.iter().map(one).collect::<Vec<_>>().join(", "))
    }
}

/// Keys and their bounds.
fn wanted(unknowns: &Bound<'_, PyAny>) -> PyResult<(Vec<ParameterKey>, Bounds)> {
    let mut bounds = Bounds::new();
    let mut keys: Vec<String> = vec![];
    for key in unknowns.try_iter()? {
        let key: String = key?.extract()?;
        if let Ok(ends) =
            unknowns.get_item(&key).and_then(|ends| ends.extract::<(Bound<'_, PyAny>, Bound<'_, PyAny>)>())
        {
            bounds.insert(key.clone(), [toml_of(&ends.0)?, toml_of(&ends.1)?]);
        }
        keys.push(key);
    }
    if keys.is_empty() {
        return Err(input("no unknown is given", "write for example [\"laws.rubber.mu\"]"));
    }
    Ok((keys.iter().map(|key| key.parse()).collect::<Result<_, _>>().map_err(refused)?, bounds))
}

/// A curve of `durometer.Curve` with its scene.
fn observed(curve: &Bound<'_, PyAny>, keys: &[ParameterKey], bounds: &Bounds) -> PyResult<ObservedCurve> {
    let py = curve.py();
    let text = |name: &str| curve.getattr(name)?.extract::<String>();
    let (x, y) = (numbers("x", &curve.getattr("x")?)?, numbers("y", &curve.getattr("y")?)?);
    if x.len() != y.len() {
        return Err(input(&format!("a curve has {} x and {} y", x.len(), y.len()), "give one y for each x"));
    }
    let scene: Py<Scene> = curve.getattr("scene")?.extract()?;
    let (file, built) = (scene.get().file().to_path_buf(), scene.get().build(py, None)?.scene);
    let (spec, text_of_scene) = (built.spec.clone(), built.text.clone());
    let unknown = Unknown::all((&file, &spec, &text_of_scene), keys, bounds).map_err(refused)?;
    let body = built.body.clone();
    let model = SceneModel { file, spec, text: text_of_scene, body, unknown, x: text("over")?, y: text("column")? };
    let bytes: Vec<u8> = x.iter().chain(&y).flat_map(|v| v.to_le_bytes()).collect();
    let lines = (1..=x.len() as u64).collect();
    let sha256 = durometer::storage::sha256(&bytes);
    let measured = Measured { file: "arrays".into(), sha256, x, y, lines, notes: vec![] };
    Ok(ObservedCurve { name: text("name")?, model, measured, offsets: vec![] })
}
