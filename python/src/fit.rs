//! The class `Fit`: the constants of a law from tests with homogeneous deformation.

use crate::array::own_array;
use crate::error::{input, refused};
use crate::run::follower;
use crate::solve::apart;
use crate::threads;
use crate::value::{kind, mapping, numbers, object_of, pair, plain};
use durometer::calibrate::{
    Accuracy, Dimensions, Experiment, FitError, FitOptions, FitRequest, FitResult, Mode, Partner, Sample, SharedError,
    StretchRange, fit, fit_experiment,
};
use durometer::math::units::{self, Dimension};
use durometer::scene::Progress;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A law fitted to measured data, with intervals and what the data do not determine.
///
/// >>> import durometer, numpy
/// >>> stretch = numpy.linspace(1.05, 1.6, 12)
/// >>> fit = durometer.Fit.from_arrays(stretch, 40e3 * (stretch - stretch**-2), "neo_hookean", nu=0.49)
/// >>> round(fit.constants["mu"])
/// 40000
#[pyclass(module = "durometer", frozen)]
pub struct Fit {
    result: FitResult,
    /// Whether the data were arrays, which have no columns with options
    of_arrays: bool,
}

#[pymethods]
impl Fit {
    /// Fits a law to a table of strain or stretch and stress; `path` is one CSV file, or a list of files of specimens of the same test; `data/…` names a
    /// file that comes with the program.
    ///
    /// `options`: those of `durometer fit`, with underscores: terms, modes (or mode), range (two stretches, from and to), weight, noise, loss, stable,
    /// nu, kappa, volumetric, slack, tolerance, accuracy ({"stress_scale": "2 %"}); those of the table card: strain_column, stress_column,
    /// strain_column_2, stress_column_2, lateral_column, lateral_unit, strain_unit, stress_unit, strain_kind, stress_kind, decimal, test, positive,
    /// stress_positive, strain_from, cycle, zero, toe; for displacements and forces, those of the test piece: gauge_length, width, thickness, diameter,
    /// area, compliance. Quantities are texts with a unit or numbers in SI units; None means that an option is not given. `threads` and `progress` as in
    /// `Scene.run`.
    #[staticmethod]
    #[pyo3(signature = (path, law, *, threads = None, progress = None, **options))]
    fn from_csv(
        py: Python<'_>,
        path: &Bound<'_, PyAny>,
        law: &str,
        threads: Option<&Bound<'_, PyAny>>,
        progress: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        threads::set(threads)?;
        let one = path.extract::<PathBuf>().map(|path| vec![path]);
        let files = one.or_else(|_| path.extract::<Vec<PathBuf>>())?;
        let files = durometer_commands::files::all_brought(&files).map_err(refused)?;
        let Some((first, more)) = files.split_first() else {
            return Err(input("no table is given", "name a CSV file"));
        };
        let mut request = FitRequest::new(first, law);
        request.more = more.to_vec();
        let rest = columns(&mut request, options)?;
        set(&mut request.options, &rest, &[&OPTIONS[..], &COLUMNS].concat())?;
        let result = followed(py, progress, |stop| {
            request.options.stop = Some(stop);
            fit(&request)
        })?;
        Ok(Self { result: result.map_err(|e| refused(in_python(&e.to_string())))?, of_arrays: false })
    }

    /// Fits a law to arrays of stretch and nominal stress `[Pa]` of one mode; the options are those of `from_csv` except for the columns.
    ///
    /// `second_stretch`: the stretch in the other direction of a biaxial test. Points of the other direction follow those of the first, with the
    /// stretches exchanged.
    #[staticmethod]
    #[pyo3(signature = (stretch, stress, law, *, mode = "uniaxial", second_stretch = None, threads = None, progress = None, **options))]
    fn from_arrays(
        py: Python<'_>,
        stretch: &Bound<'_, PyAny>,
        stress: &Bound<'_, PyAny>,
        law: &str,
        mode: &str,
        second_stretch: Option<&Bound<'_, PyAny>>,
        threads: Option<&Bound<'_, PyAny>>,
        progress: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        threads::set(threads)?;
        let (stretch, stress) = (numbers("stretch", stretch)?, numbers("stress", stress)?);
        let second = second_stretch.map(|second| numbers("second_stretch", second)).transpose()?;
        let mode: Mode = mode.parse().map_err(refused::<durometer::calibrate::UnknownMode>)?;
        check(mode, &stretch, &stress, second.as_deref())?;
        let second = second.unwrap_or_else(|| vec![1.0; stretch.len()]);
        let one = |(k, &stretch): (usize, &f64)| Sample {
            mode,
            stretch,
            second: second[k],
            stress: stress[k],
            line: k as u64 + 1,
            specimen: 0,
        };
        let samples: Vec<Sample> = stretch.iter().enumerate().map(one).collect();
        let bytes: Vec<u8> = stretch.iter().chain(&second).chain(&stress).flat_map(|x| x.to_le_bytes()).collect();
        let mut wanted = FitOptions::new(law);
        set(&mut wanted, &all(options)?, &OPTIONS)?;
        let experiment = Experiment::of_samples("arrays", &durometer::storage::sha256(&bytes), samples);
        let result = followed(py, progress, |stop| {
            wanted.stop = Some(stop);
            fit_experiment(&experiment, &wanted)
        })?;
        Ok(Self { result: result.map_err(|e| refused(of_arrays(&e.to_string())))?, of_arrays: true })
    }

    /// Name of the law in files.
    #[getter]
    fn law(&self) -> &str {
        self.result.law
    }

    /// Constant → value `[SI]`, in the order of the law.
    #[getter]
    fn constants<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.result.parameters.iter().map(|p| (p.name, p.value)).into_py_dict(py)
    }

    /// Constant → its SI unit; `1` for a dimensionless number.
    #[getter]
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let unit = |unit| if unit == "–" { "1" } else { unit };
        self.result.parameters.iter().map(|p| (p.name, unit(p.unit))).into_py_dict(py)
    }

    /// Constant → both ends of the 95 % interval `[SI]`; infinite if the data do not determine it.
    #[getter]
    fn intervals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.result.parameters.iter().map(|p| (p.name, <(f64, f64)>::from(p.interval))).into_py_dict(py)
    }

    /// Covariance `[constants × constants]` from the scatter of the data `[SI²]`, in the order of `constants`.
    #[getter]
    fn covariance(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let n = self.result.parameters.len();
        own_array(py, self.result.covariance.concat(), [n, n])
    }

    /// Whether every constant has a finite interval.
    #[getter]
    fn is_determined(&self) -> bool {
        self.result.is_determined()
    }

    /// Limits on the use of the constants, as text.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.result.warnings.iter().map(|warning| self.words(&warning.to_string())).collect()
    }

    /// The content of `fit.json`.
    #[getter]
    fn result<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.result)
    }

    /// The table of the law for a scene: `scene.set("laws.rubber", fit.table)`.
    #[getter]
    fn table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let text = self.words(&self.result.law_text());
        let table: toml::Table = text.parse().map_err(|e: toml::de::Error| refused(e.to_string()))?;
        object_of(py, &table.into())
    }

    /// `law.toml`, which a scene can include.
    #[getter]
    fn text(&self) -> String {
        self.result.law_text()
    }

    /// Writes `law.toml`.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        self.result.write_law(&path).map_err(refused)
    }

    /// The constants with their intervals as a pandas table.
    #[getter]
    fn frame<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("durometer._frames")?.call_method1("of_constants", (slf,))
    }

    fn __str__(&self) -> String {
        self.words(&self.result.to_string())
    }

    fn __repr__(&self) -> String {
        format!("<Fit of {} to {}>", self.result.label, self.result.data)
    }
}

impl Fit {
    /// Translates the flag names in a message of the library to the options in Python.
    fn words(&self, message: &str) -> String {
        if self.of_arrays { of_arrays(message) } else { in_python(message) }
    }
}

/// Runs a fit, which stops at the flag that it is given, without the interpreter lock. Its duration is unknown: progress is 0 of 1 until it is done.
fn followed(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(Arc<AtomicBool>) -> Result<FitResult, FitError> + Send,
) -> PyResult<Result<FitResult, FitError>> {
    let follower = follower(py, progress)?;
    apart(py, follower.as_ref(), |link| {
        link.progress(Progress { t: 0.0, end: 1.0 });
        let result = work(link.stop.clone());
        link.progress(Progress { t: 1.0, end: 1.0 });
        result
    })
}

/// Refuses arrays that do not match in length or mode, and stretches that are not positive.
fn check(mode: Mode, stretch: &[f64], stress: &[f64], second: Option<&[f64]>) -> PyResult<()> {
    if stretch.len() != stress.len() {
        let fact = format!("there are {} stretches and {} stresses", stretch.len(), stress.len());
        return Err(input(&fact, "give one stress for each stretch"));
    }
    if stretch.is_empty() {
        return Err(input("there are no data points", "give a stretch and a stress for each"));
    }
    match (mode == Mode::Biaxial, second) {
        (true, None) => {
            return Err(input(
                "a biaxial test has two stretches",
                "give those of the other direction as second_stretch",
            ));
        }
        (false, Some(_)) => {
            return Err(input(&format!("second_stretch does not go with the mode {mode}"), "give mode=\"biaxial\""));
        }
        (true, Some(second)) if second.len() != stretch.len() => {
            let fact = format!("there are {} stretches and {} second stretches", stretch.len(), second.len());
            return Err(input(&fact, "give both for each stress"));
        }
        _ => {}
    }
    match stretch.iter().chain(second.unwrap_or_default()).find(|s| **s <= 0.0) {
        Some(wrong) => Err(input(&format!("a stretch is {wrong}"), "a stretch is positive, and 1 at rest")),
        None => Ok(()),
    }
}

type Options<'py> = BTreeMap<String, Bound<'py, PyAny>>;

/// Options of a fit, and of the columns of its table.
const OPTIONS: [&str; 13] = [
    "terms",
    "modes",
    "range",
    "stable",
    "weight",
    "loss",
    "slack",
    "noise",
    "nu",
    "kappa",
    "volumetric",
    "tolerance",
    "accuracy",
];
const COLUMNS: [&str; 25] = [
    "card",
    "strain_column",
    "stress_column",
    "strain_column_2",
    "stress_column_2",
    "lateral_column",
    "lateral_unit",
    "strain_unit",
    "stress_unit",
    "strain_kind",
    "stress_kind",
    "decimal",
    "test",
    "positive",
    "stress_positive",
    "strain_from",
    "cycle",
    "zero",
    "toe",
    "gauge_length",
    "width",
    "thickness",
    "diameter",
    "area",
    "compliance",
];

/// Replaces the flags of `durometer fit` in a message by the names of the options in Python.
fn in_python(message: &str) -> String {
    let mut parts = message.split("--");
    let mut out = parts.next().unwrap_or_default().to_string();
    for part in parts {
        // A file name may contain two dashes
        let begins = out.chars().next_back().is_none_or(|c| c.is_whitespace() || "(\"'`".contains(c));
        let is_flag = begins && part.starts_with(|c: char| c.is_ascii_alphabetic());
        if !is_flag {
            out.extend(["--", part]);
            continue;
        }
        let end = part.find(|c: char| !c.is_ascii_alphanumeric() && c != '-').unwrap_or(part.len());
        let (flag, rest) = part.split_at(end);
        let name = if flag == "mode" { "modes".into() } else { flag.replace('-', "_") };
        if OPTIONS.iter().chain(&COLUMNS).any(|known| *known == name) {
            out.extend(["the option ", &name, rest]);
        } else {
            out.extend(["--", flag, " of the program", rest]);
        }
    }
    out
}

/// Replaces the flags in a message by the options in Python for a fit to arrays, whose numbers are in SI units.
fn of_arrays(message: &str) -> String {
    let in_pascal = message.replace("Pass --stress-unit", "Give them in Pa");
    in_python(&in_pascal.replace("pass --stress-positive compression", "give the stresses the other sign"))
}

/// Returns the options that are given, that is, not None.
fn all<'py>(options: Option<&Bound<'py, PyDict>>) -> PyResult<Options<'py>> {
    let given = options.iter().flat_map(|o| o.iter()).filter(|(_, value)| !value.is_none());
    given.map(|(key, value)| Ok((key.extract()?, value))).collect()
}

/// Reads the value of an option with `read`; refuses a value that it does not accept.
fn option<T>(key: &str, value: &Bound<'_, PyAny>, wanted: &str, read: impl FnOnce() -> Option<T>) -> PyResult<T> {
    let fact = || format!("the option {key} is {value} of the type {}", kind(value));
    read().ok_or_else(|| input(&fact(), &format!("give {wanted}")))
}

fn word(key: &str, value: &Bound<'_, PyAny>) -> PyResult<String> {
    option(key, value, "a text", || value.extract().ok())
}

fn number(key: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    option(key, value, "a number", || value.extract().ok())
}

/// Reads a stress \[Pa\].
fn pressure(key: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    match value.extract::<f64>() {
        Ok(number) => Ok(number),
        Err(_) => {
            let text =
                option(key, value, "a text such as \"1 MPa\", or a number in Pa", || value.extract::<String>().ok())?;
            units::parse(&text, Dimension::PRESSURE).map_err(|e| refused(format!("{key}: {e}")))
        }
    }
}

/// Reads a quantity with its unit, or a number in the SI unit of its dimension, as text; a truth value is refused.
fn sized(key: &str, value: &Bound<'_, PyAny>, dimension: Dimension) -> PyResult<String> {
    let (unit, wanted) = match dimension {
        Dimension::NONE => (String::new(), "a share such as \"2 %\", or 0.02".into()),
        _ => {
            let (unit, example) = (dimension.si_unit(), dimension.example());
            (format!(" {unit}"), format!("a text with a unit such as \"3 {example}\", or a number in {unit}"))
        }
    };
    let number = || value.extract::<f64>().ok().filter(|_| !kind(value).starts_with("bool"));
    let text = || number().map(|number| format!("{number}{unit}")).or_else(|| value.extract().ok());
    option(key, value, &wanted, text)
}

/// Reads an integer.
fn whole(key: &str, value: &Bound<'_, PyAny>) -> PyResult<usize> {
    option(key, value, "a whole number", || value.extract().ok())
}

/// Parses one of the known words.
fn known<T: FromStr<Err = String>>(word: &str) -> PyResult<T> {
    word.parse().map_err(refused::<String>)
}

/// Applies the options of a table to the request; returns the remaining ones.
fn columns<'py>(request: &mut FitRequest, options: Option<&Bound<'py, PyDict>>) -> PyResult<Options<'py>> {
    let mut rest = all(options)?;
    // The program accepts both names
    if let Some(mode) = rest.remove("mode")
        && rest.insert("modes".into(), mode).is_some()
    {
        return Err(input("mode and modes are both given, and they are one option", "give one of them"));
    }
    let columns = &mut request.columns;
    columns.compression =
        rest.get("modes").is_some_and(|modes| modes.to_string().to_lowercase().contains("compression"));
    for key in COLUMNS {
        let Some(value) = rest.remove(key) else { continue };
        let text = || word(key, &value);
        match key {
            "card" => request.card = Some(option(key, &value, "a path", || value.extract().ok())?),
            "strain_column" => columns.strain = Some(text()?),
            "stress_column" => columns.stress = Some(text()?),
            "strain_column_2" => columns.strain_2 = Some(text()?),
            "stress_column_2" => columns.stress_2 = Some(text()?),
            "lateral_column" => columns.lateral = Some(text()?),
            "lateral_unit" => columns.lateral_unit = Some(text()?),
            "strain_unit" => columns.strain_unit = Some(text()?),
            "stress_unit" => columns.stress_unit = Some(text()?),
            "strain_kind" => columns.strain_kind = Some(known(&text()?)?),
            "stress_kind" => columns.stress_kind = Some(known(&text()?)?),
            "decimal" => columns.decimal = Some(known(&text()?)?),
            "test" => columns.test = Some(whole(key, &value)?),
            "positive" => columns.positive = Some(known(&text()?)?),
            "stress_positive" => columns.stress_positive = Some(known(&text()?)?),
            "strain_from" => columns.strain_measurement = Some(text()?),
            "cycle" => request.preparation.cycle = Some(known(&value.to_string())?),
            "zero" => request.preparation.zero = Some(whole(key, &value)?),
            "toe" => request.preparation.toe = Some(sized(key, &value, Dimension::PRESSURE)?),
            size => {
                let (own, dimension) = Dimensions::KEYS.into_iter().find(|(own, _)| *own == size).expect("a size");
                columns.dimensions.set(own, &sized(key, &value, dimension)?).map_err(refused)?;
            }
        }
    }
    Ok(rest)
}

/// Reads the half-widths of the errors that all data points share, by their names.
fn accuracy(value: &Bound<'_, PyAny>) -> PyResult<Accuracy> {
    let one = |(error, width): (String, Bound<'_, PyAny>)| {
        let known = SharedError::ALL.into_iter().find(|(_, known, ..)| *known == error);
        let dimension = known.map_or(Dimension::NONE, |(_, _, dimension, _)| dimension);
        let width = sized(&format!("accuracy {error}"), &width, dimension)?;
        format!("{error}={width}").parse::<Accuracy>().map_err(|e| refused(in_python(&e.to_string())))
    };
    let all = mapping("accuracy", value)?.into_iter().map(one).collect::<PyResult<Vec<_>>>()?;
    Ok(all.iter().fold(Accuracy::default(), |all, one| one.or(&all)))
}

/// Applies the options of a fit; the error names all unknown options and the `known` ones.
fn set(wanted: &mut FitOptions, options: &Options<'_>, known: &[&str]) -> PyResult<()> {
    let unknown: Vec<&str> = options.keys().map(String::as_str).filter(|key| !known.contains(key)).collect();
    if !unknown.is_empty() {
        let fact = format!("a fit has no option {}", unknown.join(", "));
        return Err(input(&fact, &format!("known: {}", known.join(", "))));
    }
    if options.contains_key("nu") && options.contains_key("kappa") {
        return Err(input("nu and kappa are both given, and each follows from the other", "give one of them"));
    }
    for (key, value) in options {
        let word = || word(key, value);
        match key.as_str() {
            "terms" => wanted.terms = Some(whole(key, value)?),
            "accuracy" => wanted.accuracy = accuracy(value)?,
            "modes" => {
                let one = || value.extract::<String>().map(|one| vec![one]).ok();
                let words =
                    option(key, value, "a mode, or a list of modes", || one().or_else(|| value.extract().ok()))?;
                let modes = words.iter().map(|word: &String| word.parse()).collect::<Result<_, _>>();
                wanted.modes = modes.map_err(refused::<durometer::calibrate::UnknownMode>)?;
            }
            "range" => wanted.range = Some(range(key, value)?),
            "stable" => wanted.stable = Some(range(key, value)?),
            "weight" => wanted.weighting = word()?.parse().map_err(refused::<String>)?,
            "loss" => wanted.loss = word()?.parse().map_err(refused::<String>)?,
            "slack" => wanted.slack = word()?.parse().map_err(refused::<String>)?,
            "noise" => wanted.noise = Some(pressure(key, value)?),
            "nu" => wanted.partner = Some(Partner::Nu(number(key, value)?)),
            "kappa" => wanted.partner = Some(Partner::Kappa(pressure(key, value)?)),
            "volumetric" => wanted.volumetric = Some(word()?),
            _ => {
                let share = || value.extract().ok().filter(|share: &f64| *share > 0.0 && share.is_finite());
                wanted.tolerance = option(key, value, "a share above zero, such as 0.1", share)?;
            }
        }
    }
    Ok(())
}

fn range(key: &str, value: &Bound<'_, PyAny>) -> PyResult<StretchRange> {
    let wanted = "two stretches such as (1.0, 1.6)";
    let (from, to) = option(key, value, wanted, || pair(key, value).ok())?;
    format!("{from}..{to}").parse().map_err(|e| match e {
        FitError::Range { reason, .. } => {
            input(&format!("the option {key} is {from} to {to}: {reason}"), &format!("give {wanted}"))
        }
        other => refused(in_python(&other.to_string())),
    })
}
