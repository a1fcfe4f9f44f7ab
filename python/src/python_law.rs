//! A law whose energy, stress and tangent are methods of a Python class. This path is slow, because every evaluation waits for the interpreter.

use crate::array::array;
use crate::error::{input, is_outside, outside, refused};
use crate::raised::Raised;
use crate::threads::ask;
use crate::value::{number, pair, tensor, tensor_of_four};
use durometer::material::{
    Law, LawError, LawInfo, LawSpecError, Moduli, Parameter, Response, Want, kinematics::Invariants,
};
use durometer::math::tensor::{Mat3, ZERO9};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

/// A Python class that is a law.
pub struct Class {
    pub class: Py<PyAny>,
    pub info: &'static LawInfo,
    /// The law has two elastic constants, any two of E, ν, μ, λ, κ
    pub is_elastic: bool,
    /// ψ is linear in the moduli, or in the parameters
    pub is_linear: bool,
}

/// A law with its constants: an object of such a Python class.
#[derive(Clone)]
pub struct PythonLaw {
    class: Arc<Class>,
    values: Vec<f64>,
    moduli: Moduli,
    /// `None` if it could not be made, in which case the exception has been raised
    object: Option<Arc<Py<PyAny>>>,
    raised: Arc<Raised>,
}

impl fmt::Debug for PythonLaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {:?}", self.class.info.name, self.values)
    }
}

/// Steps of the differences with respect to constants, relative to the first step.
const STEPS: [f64; 3] = [1.0, 0.5, 0.25];
/// First step, relative to the room that the constants have.
const FIRST: f64 = 1e-2;
/// Weights of the three differences, whose error is of the sixth order (Richardson).
const WEIGHTS: [f64; 3] = [1.0 / 45.0, -20.0 / 45.0, 64.0 / 45.0];

impl PythonLaw {
    /// Makes the law with the values in a scene.
    pub fn made(class: &Arc<Class>, given: &BTreeMap<String, f64>) -> Result<Box<dyn Law>, LawSpecError> {
        let raised = Raised::of_a_law();
        if class.is_elastic {
            let moduli = Moduli::from_map(given)?;
            return Ok(Box::new(Self::new(class, vec![moduli.e, moduli.nu], Some(moduli), &raised).defined_at_rest()));
        }
        let value = |p: &Parameter| {
            let missing = || LawSpecError::Missing { law: class.info.name, key: p.name, meaning: p.meaning };
            given.get(p.name).copied().ok_or_else(missing)
        };
        let values = class.info.parameters.iter().map(value).collect::<Result<_, _>>()?;
        Ok(Box::new(Self::new(class, values, None, &raised).defined_at_rest()))
    }

    /// Makes an object of the class with these values; without `moduli`, the object is asked for them.
    fn new(class: &Arc<Class>, values: Vec<f64>, moduli: Option<Moduli>, raised: &Arc<Raised>) -> Self {
        let made = ask(|py| object(py, class, &values, moduli));
        let (object, moduli) = match made {
            Ok((object, moduli)) => (Some(Arc::new(object)), moduli),
            Err(why) => {
                raised.raise(why);
                (None, moduli.unwrap_or(Moduli { e: 0.0, nu: 0.0, mu: 0.0, lambda: 0.0, kappa: 0.0 }))
            }
        };
        Self { class: class.clone(), values, moduli, object, raised: raised.clone() }
    }

    /// Returns the law after raising an exception if it is not defined at F = I, where every run begins.
    fn defined_at_rest(self) -> Self {
        // If the object could not be made, the reason has already been raised
        if self.object.is_some() {
            ask(|py| {
                let Err(why) = self.ask(py, &Mat3::identity(), Want::Tangent) else { return };
                let fact =
                    || format!("the law {} is not defined at rest, F = I: {}", self.class.info.name, why.value(py));
                let is_outside = is_outside(py, &why);
                let remedy = "let energy, stress and tangent be finite numbers there";
                self.raised.raise(if is_outside { input(&fact(), remedy) } else { why });
            });
        }
        self
    }

    /// Returns how far the constants can change along these rates: to a bound, such as ½ for Poisson's ratio, and by at most their own size; infinite if
    /// nothing limits them.
    fn room(&self, rates: &[f64]) -> f64 {
        let of = |((value, rate), parameter): ((&f64, &f64), &Parameter)| {
            let (lower, upper) = parameter.bounds;
            let own = if *value == 0.0 { f64::INFINITY } else { value.abs() };
            own.min(value - lower).min(upper - value) / rate.abs()
        };
        let moving =
            self.values.iter().zip(rates).zip(self.class.info.parameters).filter(|((_, rate), _)| **rate != 0.0);
        moving.map(of).fold(f64::INFINITY, f64::min)
    }

    /// Evaluates energy, stress and tangent of the object as far as `want` requires; `OutOfDomain` if a number is not finite.
    fn ask(&self, py: Python<'_>, f: &Mat3, want: Want) -> PyResult<Response> {
        let missing =
            || input(&format!("the law {} could not be made", self.class.info.name), "see its first exception");
        let object = self.object.as_ref().ok_or_else(missing)?.bind(py);
        let gradient = array(py, f.transpose().as_slice().to_vec(), [3, 3])?;
        let answer = |method: &str| object.call_method1(method, (&gradient,));
        let psi = number(&self.named("energy"), &answer("energy")?, "return a float, in J/m³")?;
        self.finite("energy", &[psi])?;
        let mut response = Response { psi, p: Mat3::zeros(), a: ZERO9 };
        if want >= Want::Residual {
            response.p = tensor(&self.named("stress"), &answer("stress")?)?;
            self.finite("stress", response.p.as_slice())?;
        }
        if want >= Want::Tangent {
            let values = tensor_of_four(&self.named("tangent"), &answer("tangent")?)?;
            response.a.as_flattened_mut().copy_from_slice(&values);
            self.finite("tangent", &values)?;
        }
        Ok(response)
    }

    /// Returns how messages name the answer of a method.
    fn named(&self, method: &str) -> String {
        format!("the {method} of the law {}", self.class.info.name)
    }

    fn finite(&self, what: &str, values: &[f64]) -> PyResult<()> {
        match values.iter().find(|value| !value.is_finite()) {
            Some(value) => Err(outside(&format!("{} is {value}", self.named(what)))),
            None => Ok(()),
        }
    }
}

/// Makes the Python object, and returns it with its moduli.
fn object(py: Python<'_>, class: &Class, values: &[f64], moduli: Option<Moduli>) -> PyResult<(Py<PyAny>, Moduli)> {
    let constants = PyDict::new(py);
    match moduli {
        Some(m) if class.is_elastic => {
            let all = [("E", m.e), ("nu", m.nu), ("mu", m.mu), ("lambda_", m.lambda), ("kappa", m.kappa)];
            all.iter().try_for_each(|(name, value)| constants.set_item(name, value))?;
        }
        _ => {
            let mut pairs = class.info.parameters.iter().zip(values);
            pairs.try_for_each(|(p, value)| constants.set_item(p.name, value))?;
        }
    }
    let object = class.class.bind(py).call((), Some(&constants))?;
    let moduli = match moduli {
        Some(moduli) => moduli,
        None => {
            let name = format!("the answer of `moduli` of the law {}", class.info.name);
            let (mu, kappa) = pair(&name, &object.call_method0("moduli")?)?;
            Moduli::from_pair(("mu", mu), ("kappa", kappa)).map_err(refused)?
        }
    };
    Ok((object.unbind(), moduli))
}

impl Law for PythonLaw {
    fn info(&self) -> &'static LawInfo {
        self.class.info
    }

    fn values(&self) -> Vec<f64> {
        self.values.clone()
    }

    fn small_strain(&self) -> Moduli {
        self.moduli
    }

    fn eval(&self, f: &Mat3, want: Want) -> Result<Response, LawError> {
        if !self.class.info.survives_inversion {
            Invariants::of_positive(f)?;
        }
        if self.raised.has_ended_laws() {
            return Err(LawError::Undefined);
        }
        ask(|py| {
            self.ask(py, f, want).map_err(|why| {
                if !is_outside(py, &why) {
                    // The exception ends the run, however it handles the returned error
                    self.raised.raise(why);
                }
                LawError::Undefined
            })
        })
    }

    fn is_differentiated_exactly(&self) -> bool {
        self.class.is_linear && self.class.is_elastic
    }

    /// Returns a law of the same class with the rates as its constants if it is declared linear and elastic, otherwise a difference of six laws.
    fn along(&self, rates: &[f64]) -> Box<dyn Law> {
        let first = FIRST * self.room(rates);
        let first = if first.is_finite() { first } else { FIRST };
        let at = |t: f64| -> Self {
            let values: Vec<f64> = self.values.iter().zip(rates).map(|(v, r)| v + t * r).collect();
            let moduli = self.class.is_elastic.then(|| Moduli::from_e_nu(values[0], values[1])).transpose();
            match moduli {
                Ok(moduli) => Self::new(&self.class, values, moduli, &self.raised),
                Err(why) => {
                    self.raised.raise(refused(why));
                    Self { values, object: None, ..self.clone() }
                }
            }
        };
        if self.is_differentiated_exactly() {
            return Box::new(Self::new(&self.class, rates.to_vec(), Some(self.moduli.along(rates)), &self.raised));
        }
        let laws = STEPS.map(|step| [at(step * first), at(-step * first)]);
        let steps = STEPS.map(|step| step * first);
        Box::new(Differences { laws, steps, law: self.clone() })
    }
}

/// The derivative ∂ψ/∂θ and its tensors by differences.
#[derive(Clone, Debug)]
struct Differences {
    /// The laws at +h and −h for each step h
    laws: [[PythonLaw; 2]; 3],
    steps: [f64; 3],
    law: PythonLaw,
}

impl Differences {
    /// Returns the weighted sum of the differences of a number.
    fn of(&self, number: impl Fn(&PythonLaw) -> f64) -> f64 {
        let one = |k: usize| WEIGHTS[k] * (number(&self.laws[k][0]) - number(&self.laws[k][1])) / (2.0 * self.steps[k]);
        one(0) + one(1) + one(2)
    }
}

impl Law for Differences {
    fn info(&self) -> &'static LawInfo {
        self.law.info()
    }

    fn values(&self) -> Vec<f64> {
        self.law.values()
    }

    fn small_strain(&self) -> Moduli {
        Moduli {
            e: self.of(|law| law.moduli.e),
            nu: self.of(|law| law.moduli.nu),
            mu: self.of(|law| law.moduli.mu),
            lambda: self.of(|law| law.moduli.lambda),
            kappa: self.of(|law| law.moduli.kappa),
        }
    }

    fn eval(&self, f: &Mat3, want: Want) -> Result<Response, LawError> {
        let mut sum = Response { psi: 0.0, p: Mat3::zeros(), a: ZERO9 };
        for ((laws, step), weight) in self.laws.iter().zip(self.steps).zip(WEIGHTS) {
            for (law, sign) in laws.iter().zip([1.0, -1.0]) {
                let (factor, one) = (sign * weight / (2.0 * step), law.eval(f, want)?);
                sum.psi += factor * one.psi;
                sum.p += factor * one.p;
                let entries = sum.a.as_flattened_mut().iter_mut().zip(one.a.as_flattened());
                entries.for_each(|(to, from)| *to += factor * from);
            }
        }
        Ok(sum)
    }

    /// Returns the derivative itself, because it is never differentiated again.
    fn along(&self, _: &[f64]) -> Box<dyn Law> {
        Box::new(self.clone())
    }
}
