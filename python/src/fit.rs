//! The class `Fit`: the constants of a law from tests with homogeneous deformation.

use crate::array::array;
use crate::error::{input, refused};
use crate::solve::apart;
use crate::value::{numbers, plain};
use durometer::calibrate::{
    Experiment, FitOptions, FitRequest, FitResult, Mode, Partner, Sample, StretchRange, fit, fit_experiment,
};
use durometer::math::units::{self, Dimension};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;
use std::path::PathBuf;

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
}

#[pymethods]
impl Fit {
    /// Fits a law to a table of strain or stretch and stress; `path` is one CSV file, or several of specimens of the same test.
    ///
    /// `options`: those of `durometer fit`, with underscores: terms, modes, range ((from, to) in stretch), weight, noise, loss, stable, nu, kappa,
    /// volumetric, slack, and columns: strain_column, stress_column, strain_unit, stress_unit, strain_kind, stress_kind, card.
    #[staticmethod]
    #[pyo3(signature = (path, law, *, progress = None, **options))]
    fn from_csv(
        py: Python<'_>,
        path: &Bound<'_, PyAny>,
        law: &str,
        progress: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let one = path.extract::<PathBuf>().map(|path| vec![path]);
        let files = one.or_else(|_| path.extract::<Vec<PathBuf>>())?;
        let Some((first, more)) = files.split_first() else {
            return Err(input("no table is given", "name a CSV file"));
        };
        let mut request = FitRequest::new(first, law);
        request.more = more.to_vec();
        let rest = columns(&mut request, options)?;
        set(&mut request.options, &rest)?;
        let result = apart(py, progress, |_| fit(&request))?;
        Ok(Self { result: result.map_err(refused)? })
    }

    /// Fits a law to arrays of stretch and of nominal stress \[Pa\] of one mode; the options are those of `from_csv` but for its columns.
    #[staticmethod]
    #[pyo3(signature = (stretch, stress, law, *, mode = "uniaxial", progress = None, **options))]
    fn from_arrays(
        py: Python<'_>,
        stretch: &Bound<'_, PyAny>,
        stress: &Bound<'_, PyAny>,
        law: &str,
        mode: &str,
        progress: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let (stretch, stress) = (numbers("stretch", stretch)?, numbers("stress", stress)?);
        if stretch.len() != stress.len() {
            let fact = format!("there are {} stretches and {} stresses", stretch.len(), stress.len());
            return Err(input(&fact, "give one stress for each stretch"));
        }
        if let Some(wrong) = stretch.iter().find(|s| **s <= 0.0) {
            return Err(input(&format!("a stretch is {wrong}"), "a stretch is positive, and 1 at rest"));
        }
        let mode: Mode = mode.parse().map_err(refused::<durometer::calibrate::UnknownMode>)?;
        let one = |(line, (stretch, stress)): (u64, (&f64, &f64))| Sample {
            mode,
            stretch: *stretch,
            second: 1.0,
            stress: *stress,
            line,
            specimen: 0,
        };
        let samples: Vec<Sample> = (1..).zip(stretch.iter().zip(&stress)).map(one).collect();
        let bytes: Vec<u8> = stretch.iter().chain(&stress).flat_map(|x| x.to_le_bytes()).collect();
        let mut wanted = FitOptions::new(law);
        set(&mut wanted, &all(options)?)?;
        let experiment = Experiment::of_samples("arrays", &durometer::storage::sha256(&bytes), samples);
        let result = apart(py, progress, |_| fit_experiment(&experiment, &wanted))?;
        Ok(Self { result: result.map_err(refused)? })
    }

    /// Name of the law in files.
    #[getter]
    fn law(&self) -> &str {
        self.result.law
    }

    /// Constant → value \[SI\].
    #[getter]
    fn constants(&self) -> BTreeMap<&str, f64> {
        self.result.parameters.iter().map(|p| (p.name, p.value)).collect()
    }

    /// Constant → its SI unit.
    #[getter]
    fn units(&self) -> BTreeMap<&str, &str> {
        self.result.parameters.iter().map(|p| (p.name, p.unit)).collect()
    }

    /// Constant → both ends of the 95 % interval \[SI\]; infinite where the data do not determine it.
    #[getter]
    fn intervals(&self) -> BTreeMap<&str, (f64, f64)> {
        self.result.parameters.iter().map(|p| (p.name, p.interval.into())).collect()
    }

    /// \[constants × constants\] by the scatter of the data \[SI²\].
    #[getter]
    fn covariance(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let n = self.result.parameters.len();
        array(py, self.result.covariance.concat(), [n, n])
    }

    /// Whether every constant has a finite interval.
    #[getter]
    fn is_determined(&self) -> bool {
        self.result.is_determined()
    }

    /// Limits on the use of the constants, in words.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.result.warnings.iter().map(ToString::to_string).collect()
    }

    /// Everything that `fit.json` has.
    #[getter]
    fn result<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.result)
    }

    /// The table of the law for a scene: `scene.set("laws.rubber", fit.table)`.
    #[getter]
    fn table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let table: toml::Table = self.result.law_text().parse().map_err(|e: toml::de::Error| refused(e.to_string()))?;
        plain(py, &table)
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

    /// The constants with their intervals as a table of pandas.
    #[getter]
    fn frame<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("durometer._frames")?.call_method1("of_constants", (slf,))
    }

    fn __str__(&self) -> String {
        self.result.to_string()
    }

    fn __repr__(&self) -> String {
        format!("<Fit of {} to {}>", self.result.label, self.result.data)
    }
}

type Options<'py> = BTreeMap<String, Bound<'py, PyAny>>;

fn all<'py>(options: Option<&Bound<'py, PyDict>>) -> PyResult<Options<'py>> {
    options.iter().flat_map(|o| o.iter()).map(|(key, value)| Ok((key.extract()?, value))).collect()
}

/// Takes the options of a table; returns the others.
fn columns<'py>(request: &mut FitRequest, options: Option<&Bound<'py, PyDict>>) -> PyResult<Options<'py>> {
    let mut rest = all(options)?;
    let mut text = |name: &str| rest.remove(name).map(|value| value.extract::<String>()).transpose();
    let columns = &mut request.columns;
    columns.strain = text("strain_column")?;
    columns.stress = text("stress_column")?;
    columns.strain_unit = text("strain_unit")?;
    columns.stress_unit = text("stress_unit")?;
    columns.strain_kind = text("strain_kind")?.map(|word| word.parse()).transpose().map_err(refused::<String>)?;
    columns.stress_kind = text("stress_kind")?.map(|word| word.parse()).transpose().map_err(refused::<String>)?;
    request.card = text("card")?.map(PathBuf::from);
    Ok(rest)
}

/// Takes the options of a fit; all that are unknown are named.
fn set(wanted: &mut FitOptions, options: &Options<'_>) -> PyResult<()> {
    let mut unknown = vec![];
    for (key, value) in options {
        let word = || value.extract::<String>();
        match key.as_str() {
            "terms" => wanted.terms = value.extract()?,
            "modes" => {
                let words = word().map(|one| vec![one]).or_else(|_| value.extract::<Vec<String>>())?;
                let modes = words.iter().map(|word| word.parse()).collect::<Result<_, _>>();
                wanted.modes = modes.map_err(refused::<durometer::calibrate::UnknownMode>)?;
            }
            "range" => wanted.range = Some(range(value)?),
            "stable" => wanted.stable = Some(range(value)?),
            "weight" => wanted.weighting = word()?.parse().map_err(refused::<String>)?,
            "loss" => wanted.loss = word()?.parse().map_err(refused::<String>)?,
            "slack" => wanted.slack = word()?.parse().map_err(refused::<String>)?,
            "noise" => wanted.noise = Some(units::parse(&word()?, Dimension::PRESSURE).map_err(refused)?),
            "nu" => wanted.partner = Some(Partner::Nu(value.extract()?)),
            "kappa" => {
                wanted.partner = Some(Partner::Kappa(units::parse(&word()?, Dimension::PRESSURE).map_err(refused)?))
            }
            "volumetric" => wanted.volumetric = Some(word()?),
            "tolerance" => wanted.tolerance = value.extract()?,
            _ => unknown.push(key.as_str()),
        }
    }
    if unknown.is_empty() {
        return Ok(());
    }
    let known = "terms, modes, range, stable, weight, loss, slack, noise, nu, kappa, volumetric, tolerance";
    Err(input(&format!("a fit has no option {}", unknown.join(", ")), &format!("known: {known}")))
}

fn range(value: &Bound<'_, PyAny>) -> PyResult<StretchRange> {
    let (from, to): (f64, f64) = value.extract().map_err(|_| input("a range is two stretches", "write (1.0, 1.6)"))?;
    format!("{from}..{to}").parse().map_err(refused::<durometer::calibrate::FitError>)
}
