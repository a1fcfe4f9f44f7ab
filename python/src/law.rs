//! Registration of laws in Python, and their checks.

use crate::error::{input, refused};
use crate::python_law::{Class, PythonLaw};
use crate::raised::Raised;
use crate::solve::apart;
use durometer::material::entry::Rates;
use durometer::material::{LawEntry, LawInfo, Parameter, check_law as check, moduli, register_anew};
use durometer::math::threads::locked;
use durometer::math::units;
use pyo3::prelude::*;
use pyo3::types::PyType;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

/// Classes by the name of their law.
static CLASSES: Mutex<BTreeMap<String, &'static LawEntry>> = Mutex::new(BTreeMap::new());

/// Registers a law, so that scenes and studies of this process can name it. `law` is a class that extends `durometer.Law`. An earlier Python law of the
/// same name is replaced; scenes that were made with it, scenes derived from them by `Scene.set`, and their runs keep it.
#[pyfunction]
pub fn register_law<'py>(law: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    check_class(law)?;
    let text = |name: &str| law.getattr(name)?.extract::<String>();
    let name = text("name")?;
    if name.is_empty() {
        return Err(input("the law has no name", "give its class an attribute `name`, as scenes are to write it"));
    }
    let given = law.getattr("parameters")?;
    let is_elastic = given.extract::<String>().is_ok_and(|word| word == "elastic");
    let parameters = if is_elastic { moduli::PAIR } else { declared(&given)? };
    let info = LawInfo {
        name: leaked(name.clone()),
        title: leaked(text("title")?),
        formula: leaked(text("formula")?),
        source: leaked(text("source")?),
        limits: leaked(text("limits")?),
        parameters,
        optional: 0,
        choices: &[],
        survives_inversion: law.getattr("survives_inversion")?.extract()?,
        objective: law.getattr("objective")?.extract()?,
        isochoric: false,
    };
    let info: &'static LawInfo = Box::leak(Box::new(info));
    let is_linear = law.getattr("linear")?.extract()?;
    let class = Arc::new(Class { class: law.clone().unbind(), info, is_elastic, is_linear });
    let make = move |values: &BTreeMap<String, f64>, _: &_| PythonLaw::made(&class, values);
    let entry = if is_elastic {
        LawEntry::made_by(info, moduli::KEYS, &[100e3, 0.4], make, |law, given, key| {
            law.small_strain().rates(given, key)
        })
    } else {
        let sample: Vec<f64> = law.getattr("sample")?.extract()?;
        if sample.len() != parameters.len() {
            let fact = format!("the law {name} has {} parameters and {} sample values", parameters.len(), sample.len());
            return Err(input(&fact, "give `sample` one value for each, in SI units"));
        }
        let rates: Rates =
            |law, _, key| law.info().parameters.iter().map(|p| f64::from(u8::from(p.name == key))).collect();
        LawEntry::made_by(info, parameters, Vec::leak(sample), make, rates)
    };
    let entry = register_anew(entry).map_err(refused)?;
    locked(&CLASSES).insert(name, entry);
    Ok(law.clone())
}

/// Refuses anything but a class that extends `durometer.Law`, such as an object of one, or another class.
fn check_class(law: &Bound<'_, PyAny>) -> PyResult<()> {
    let base = law.py().import("durometer.law")?.getattr("Law")?;
    let fact = match law.cast::<PyType>() {
        Ok(class) if class.is_subclass(&base)? => return Ok(()),
        Ok(class) => format!("the class {} does not extend durometer.Law", class.name()?),
        Err(_) => format!("an object of the class {} is given, and no class", law.get_type().name()?),
    };
    Err(input(&fact, "give the class of the law itself, such as register_law(MyLaw) of class MyLaw(durometer.Law)"))
}

/// Checks a registered law: energy, stress and tangent against each other by finite differences at random states within its domain, objectivity,
/// small strain, and more. Raises `InputError` with the first property that does not hold.
#[pyfunction]
pub fn check_law(py: Python<'_>, name: &str) -> PyResult<()> {
    let known = locked(&CLASSES).get(name).copied();
    let entry = known.ok_or_else(|| input(&format!("no law {name} is registered"), "register its class first"))?;
    apart(py, None, |link| {
        let _turn = Raised::by(link).with_ending_laws();
        check(entry)
    })?
    .map_err(refused)
}

/// Name, symbol, unit, bounds and meaning of a parameter.
type Declared = (String, String, String, (f64, f64), String);

/// Returns the parameters that the class declares.
fn declared(given: &Bound<'_, PyAny>) -> PyResult<&'static [Parameter]> {
    let remedy = "write \"elastic\", or a list of durometer.Parameter(name, symbol, unit, (lower, upper), meaning)";
    let all: Vec<Declared> = given.extract().map_err(|_| input("`parameters` of the law is not understood", remedy))?;
    let one = |(name, symbol, unit, bounds, meaning): Declared| {
        let (factor, dimension) = units::quantity(&format!("1 {unit}"))
            .or_else(|e| if unit == "1" { units::quantity("1") } else { Err(e) })
            .map_err(refused)?;
        if factor != 1.0 {
            let fact = format!("the unit of the parameter {name} is {unit}, and the law gets its value in SI units");
            return Err(input(&fact, &format!("write {}, with `bounds` and `sample` in it", dimension.si_unit())));
        }
        Ok(Parameter::new(leaked(name), leaked(symbol), dimension, bounds, leaked(meaning)))
    };
    Ok(Vec::leak(all.into_iter().map(one).collect::<PyResult<Vec<_>>>()?))
}

/// Leaks a text: laws are kept until the process ends.
fn leaked(text: String) -> &'static str {
    String::leak(text)
}
