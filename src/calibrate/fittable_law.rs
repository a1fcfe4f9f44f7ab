//! Laws that can be fitted, each with its number of terms.

use std::collections::BTreeMap;

use super::{FitError, Mode, Partner, Sample};
use crate::material::parameter::{LawSpecError, Parameter, Values};
use crate::material::{Choice, FitForm, FitTerms, Law, LawEntry, laws};
use crate::math::units::Dimension;

/// The laws that can be fitted.
pub fn fittable_laws() -> Vec<&'static LawEntry> {
    laws().into_iter().filter(|e| e.fit.is_some()).collect()
}

/// A law with its number of terms.
#[derive(Clone, Copy, Debug)]
pub struct FittableLaw {
    pub law: &'static LawEntry,
    pub form: &'static FitForm,
    pub terms: usize,
    /// Poisson's ratio that determines the lateral stretches of a test: ½ if the law is fitted as incompressible
    pub nu: f64,
}

impl FittableLaw {
    /// Finds a law by name. `terms`: the number of terms, by default the law's usual one.
    pub fn new(name: &str, terms: Option<usize>) -> Result<Self, FitError> {
        let known = fittable_laws();
        let (law, form) = known
            .iter()
            .filter(|e| e.info.name == name)
            .find_map(|e| e.fit.as_ref().map(|form| (*e, form)))
            .ok_or_else(|| unknown(name, &known))?;
        let terms = terms.unwrap_or(form.default_count);
        if form.term_counts.contains(&terms) {
            Ok(Self { law, form, terms, nu: 0.5 })
        } else {
            Err(FitError::Terms { law: law.info.name, terms, known: form.term_counts })
        }
    }

    /// This model with lateral stretches that follow Poisson's ratio `nu`, which all terms then have; it has no effect on laws that are not fitted as
    /// compressible.
    #[must_use]
    pub fn with_poisson(self, nu: f64) -> Self {
        if self.form.compressible { Self { nu, ..self } } else { self }
    }

    /// Name of the law.
    pub fn name(&self) -> &'static str {
        self.law.info.name
    }

    /// `Ogden with 3 terms`, or the title of the law if the number of terms is fixed
    pub fn label(&self) -> String {
        let title = self.law.info.title;
        if self.form.term_counts.len() == 1 {
            title.into()
        } else {
            format!("{title} with {} term{}", self.terms, if self.terms == 1 { "" } else { "s" })
        }
    }

    /// The constants that are fitted.
    pub fn parameters(&self) -> &'static [Parameter] {
        match self.form.terms {
            FitTerms::Linear(_) => &self.form.parameters[..self.terms],
            FitTerms::Separable(_) => &self.form.parameters[..2 * self.terms],
        }
    }

    /// Nominal stress P \[Pa\] with these constants \[SI\] at λ \[–\]. For biaxial tests, where both stretches count, use [`FittableLaw::at`].
    pub fn stress(&self, values: &[f64], mode: Mode, stretch: f64) -> f64 {
        self.nominal(values, mode, mode.stretches_with(self.nu, stretch, 1.0))
    }

    /// P \[Pa\] at a sample.
    pub fn at(&self, values: &[f64], sample: &Sample) -> f64 {
        self.nominal(values, sample.mode, sample.stretches(self.nu))
    }

    fn nominal(&self, values: &[f64], mode: Mode, s: [f64; 3]) -> f64 {
        match &self.form.terms {
            FitTerms::Linear(derivatives) => {
                let terms = values.iter().enumerate().map(|(k, c)| c * mode.nominal(derivatives(k, s).tau, s[0]));
                terms.sum()
            }
            FitTerms::Separable(f) => {
                let terms = values.chunks_exact(2).map(|v| {
                    let c = v[0] / (f.factor)(v[1]).0;
                    c * mode.nominal((f.tau)(v[1], s), s[0])
                });
                terms.sum()
            }
        }
    }

    /// ∂P/∂value of each constant at a sample.
    pub fn sensitivities(&self, values: &[f64], sample: &Sample) -> Vec<f64> {
        let (mode, s) = (sample.mode, sample.stretches(self.nu));
        match &self.form.terms {
            FitTerms::Linear(derivatives) => {
                (0..values.len()).map(|k| mode.nominal(derivatives(k, s).tau, s[0])).collect()
            }
            FitTerms::Separable(f) => {
                let one = |v: &[f64]| {
                    // P = m φ/s: with c = m/s, ∂P/∂θ = c(φ′ − φ s′/s)
                    let (m, theta) = (v[0], v[1]);
                    let (scale, by) = (f.factor)(theta);
                    let phi = mode.nominal((f.tau)(theta, s), s[0]);
                    let by_shape = mode.nominal((f.tau_by_shape)(theta, s), s[0]);
                    [phi / scale, m / scale * (by_shape - phi * by / scale)]
                };
                values.chunks_exact(2).flat_map(one).collect()
            }
        }
    }

    /// Keys of Poisson's ratio of each term of a law that is fitted as compressible.
    pub fn poisson_keys(&self) -> impl Iterator<Item = String> + use<> {
        let count = if self.form.compressible { self.terms } else { 0 };
        (1..=count).map(|n| format!("nu{n}"))
    }

    /// The choice of the volumetric part, if the law has no default for it.
    pub fn volumetric(&self) -> Option<&'static Choice> {
        self.law.info.choices.iter().find(|c| c.name == "volumetric" && c.default.is_none())
    }

    /// The compressible law of scenes with these constants \[SI\] and κ \[Pa\]; κ is ignored by a law that is fitted as compressible.
    pub fn law(&self, values: &[f64], kappa: f64) -> Result<Box<dyn Law>, LawSpecError> {
        self.law_with(values, Partner::Kappa(kappa), None)
    }

    /// The law of scenes with these constants \[SI\], with ν or κ and a volumetric part, by default the quadratic one.
    pub fn law_with(
        &self,
        values: &[f64],
        partner: Partner,
        volumetric: Option<&str>,
    ) -> Result<Box<dyn Law>, LawSpecError> {
        let named = self.parameters().iter().map(|p| p.name.to_string()).zip(values.iter().copied());
        let partner = (!self.form.compressible).then(|| match partner {
            Partner::Nu(nu) => ("nu".to_string(), nu),
            Partner::Kappa(kappa) => ("kappa".to_string(), kappa),
        });
        let values: Values = named.chain(partner).chain(self.poisson_keys().map(|k| (k, self.nu))).collect();
        let chosen = volumetric.unwrap_or("quadratic");
        let options: BTreeMap<_, _> =
            self.volumetric().map(|c| (c.name.to_string(), chosen.to_string())).into_iter().collect();
        self.law.build(&values, &options)
    }
}

/// Unit of a constant in SI.
pub fn unit(p: &Parameter) -> &'static str {
    if p.dimension == Dimension::PRESSURE { "Pa" } else { "–" }
}

/// The error that names the laws that can be fitted.
fn unknown(name: &str, known: &[&'static LawEntry]) -> FitError {
    FitError::UnknownLaw { name: name.into(), known: known.iter().map(|e| e.info.name).collect() }
}
