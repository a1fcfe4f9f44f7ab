//! Laws that can be fitted. Each is a sum P = Σ_k m_k φ_k(λ) of terms: linear in its factors m, and where it has shape constants θ
//! (an exponent, a limit of the chains) each term has one of them.

mod arruda_boyce;
mod gent;
mod mooney_rivlin;
mod neo_hookean;
mod ogden;
mod veronda_westmann;
mod yeoh;

use super::term::Slopes;
use super::{FitError, Mode, Sample};
use crate::material::registry::{self, Values};
use crate::material::{Law, LawSpecError, Parameter};
use crate::math::units::Dimension;
use std::collections::BTreeMap;

/// A law that can be fitted to tests with homogeneous, incompressible deformation.
#[derive(Debug)]
pub struct Fittable {
    /// Name in files
    pub name: &'static str,
    /// Nominal stress as text
    pub formula: &'static str,
    pub source: &'static str,
    /// Constants in the order of files; those of the last terms stand last
    pub parameters: &'static [Parameter],
    /// Numbers of terms that can be asked for
    pub terms: &'static [usize],
    /// The number taken where none is asked for
    pub usual: usize,
    pub form: Form,
}

/// How the stress depends on the constants.
#[derive(Debug)]
pub enum Form {
    /// Linear: slopes of term k with factor 1. The number of terms is the number of constants.
    Linear(fn(usize, [f64; 3]) -> Slopes),
    /// A factor m and a shape constant θ per term, in turn
    Separable(Family),
}

/// A term w(λ; θ) with factor c ≥ 0, its shape constant θ searched as a number x without bounds.
#[derive(Debug)]
pub struct Family {
    /// τ/c \[–\]; not a number where the term is not defined
    pub tau: fn(f64, [f64; 3]) -> [f64; 3],
    /// ∂τ/∂θ
    pub tau_by_shape: fn(f64, [f64; 3]) -> [f64; 3],
    /// θ and ∂θ/∂x at x, with the largest I₁ − 3 of the table
    pub shape: fn(f64, f64) -> (f64, f64),
    /// x where the search may start, ascending; |x| stays below twice the largest
    pub grid: &'static [f64],
    /// s and s′ at θ of the factor of files m = s(θ)c
    pub factor: fn(f64) -> (f64, f64),
}

/// Laws that can be fitted, one line each.
pub const FITS: &[Fittable] = &[
    neo_hookean::NEO_HOOKEAN,
    mooney_rivlin::MOONEY_RIVLIN,
    yeoh::YEOH,
    ogden::OGDEN,
    gent::GENT,
    arruda_boyce::ARRUDA_BOYCE,
    veronda_westmann::VERONDA_WESTMANN,
];

/// The law of this name, or the error that names the nearest one.
pub fn fittable(name: &str) -> Result<&'static Fittable, FitError> {
    FITS.iter().find(|f| f.name == name).ok_or_else(|| {
        let nearest = FITS
            .iter()
            .max_by(|a, b| strsim::jaro_winkler(a.name, name).total_cmp(&strsim::jaro_winkler(b.name, name)))
            .expect("the registry is not empty")
            .name;
        FitError::UnknownLaw { name: name.into(), nearest, known: FITS.iter().map(|f| f.name).collect() }
    })
}

/// A law with its number of terms.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    pub law: &'static Fittable,
    pub terms: usize,
}

impl Model {
    /// `terms`: the usual number where none is asked for.
    pub fn new(name: &str, terms: Option<usize>) -> Result<Self, FitError> {
        let law = fittable(name)?;
        let terms = terms.unwrap_or(law.usual);
        if law.terms.contains(&terms) {
            Ok(Self { law, terms })
        } else {
            Err(FitError::Terms { law: law.name, terms, known: law.terms })
        }
    }

    /// `ogden with 3 terms`, or the name where there is no choice
    pub fn label(&self) -> String {
        if self.law.terms.len() == 1 {
            self.law.name.into()
        } else {
            format!("{} with {} term{}", self.law.name, self.terms, if self.terms == 1 { "" } else { "s" })
        }
    }

    /// The constants that are fitted.
    pub fn parameters(&self) -> &'static [Parameter] {
        match self.law.form {
            Form::Linear(_) => &self.law.parameters[..self.terms],
            Form::Separable(_) => &self.law.parameters[..2 * self.terms],
        }
    }

    /// Nominal stress P \[Pa\] with these constants \[SI\] at λ \[–\]; of a biaxial test both stretches count: [`Model::at`].
    pub fn stress(&self, values: &[f64], mode: Mode, stretch: f64) -> f64 {
        self.nominal(values, mode, mode.stretches(stretch, 1.0))
    }

    /// P \[Pa\] where a sample was taken.
    pub fn at(&self, values: &[f64], sample: &Sample) -> f64 {
        self.nominal(values, sample.mode, sample.stretches())
    }

    fn nominal(&self, values: &[f64], mode: Mode, s: [f64; 3]) -> f64 {
        match &self.law.form {
            Form::Linear(slopes) => {
                let terms = values.iter().enumerate().map(|(k, c)| c * mode.nominal(slopes(k, s).tau, s[0]));
                terms.sum()
            }
            Form::Separable(f) => {
                let terms = values.chunks_exact(2).map(|v| {
                    let c = v[0] / (f.factor)(v[1]).0;
                    c * mode.nominal((f.tau)(v[1], s), s[0])
                });
                terms.sum()
            }
        }
    }

    /// ∂P/∂value of each constant where a sample was taken.
    pub fn sensitivities(&self, values: &[f64], sample: &Sample) -> Vec<f64> {
        let (mode, s) = (sample.mode, sample.stretches());
        match &self.law.form {
            Form::Linear(slopes) => (0..values.len()).map(|k| mode.nominal(slopes(k, s).tau, s[0])).collect(),
            Form::Separable(f) => {
                let one = |v: &[f64]| {
                    // P = m φ/s: with c = m/s, ∂P/∂θ = c(φ′ − φ s′/s)
                    let (m, theta) = (v[0], v[1]);
                    let (scale, by) = (f.factor)(theta);
                    let phi = mode.nominal((f.tau)(theta, s), s[0]);
                    let slope = mode.nominal((f.tau_by_shape)(theta, s), s[0]);
                    [phi / scale, m / scale * (slope - phi * by / scale)]
                };
                values.chunks_exact(2).flat_map(one).collect()
            }
        }
    }

    /// The compressible law of scenes with these constants \[SI\] and κ \[Pa\].
    pub fn law(&self, values: &[f64], kappa: f64) -> Result<Box<dyn Law>, LawSpecError> {
        let entry = registry::find(self.law.name)?;
        let named = self.parameters().iter().map(|p| p.name.to_string()).zip(values.iter().copied());
        let values: Values = named.chain([("kappa".to_string(), kappa)]).collect();
        let volumetric = entry.info.choices.iter().find(|c| c.name == "volumetric" && c.default.is_none());
        let options: BTreeMap<_, _> =
            volumetric.map(|c| (c.name.to_string(), "quadratic".to_string())).into_iter().collect();
        entry.build(&values, &options)
    }
}

/// Unit of a constant in SI.
pub fn unit(p: &Parameter) -> &'static str {
    if p.dimension == Dimension::PRESSURE { "Pa" } else { "–" }
}
