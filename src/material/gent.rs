//! Gent law: chains of finite length.
//!
//! ψ = −½μJ_m ln(1 − (Ī₁ − 3)/J_m) + U(J)
//!
//! Source: Gent, *A new constitutive relation for rubber*, Rubber Chem. Technol. 69, 1996.
//!
//! Limits: J > 0 and Ī₁ − 3 < J_m; beyond, where the chains would be fully stretched and ψ infinite, the state is refused.

use super::entry::LawEntry;
use super::fit_form::{FitForm, FitTerms, ShapedTerm};
use super::isochoric::{InvariantEnergy, Parametric, Partials};
use super::law::LawInfo;
use super::moduli;
use super::parameter::{Chosen, LawSpecError, Parameter, Values};
use super::principal::{invariants, of_invariants, tau};
use super::response::LawError;
use super::split::{Isochoric, Split, fitted_parameters, law_parameters, required};
use super::volumetric::CHOICES;
use crate::math::units::Dimension;

/// Keys in files; either κ or ν is required.
pub const KEYS: &[Parameter] = &[
    moduli::NU,
    moduli::KAPPA,
    Parameter::new("mu", "μ", Dimension::PRESSURE, Parameter::POSITIVE, "shear modulus at F = I"),
    Parameter::new(
        "J_m",
        "J_m",
        Dimension::NONE,
        Parameter::POSITIVE,
        "Ī₁ − 3 at which the chains are fully stretched",
    ),
];

pub static INFO: LawInfo = LawInfo {
    name: "gent",
    title: "Gent",
    formula: "ψ = −½μJ_m ln(1 − (Ī₁ − 3)/J_m) + U(J)",
    source: "Gent 1996; modified invariant: Holzapfel 2000, ch. 6",
    limits: "J > 0; locks at Ī₁ − 3 = J_m and is not defined beyond",
    parameters: law_parameters(KEYS),
    optional: 0,
    choices: CHOICES,
    survives_inversion: false,
    objective: true,
    isochoric: true,
};

/// The law in the registry.
pub const ENTRY: LawEntry = Split::<Gent>::entry(KEYS, &[200e3, 35e3, 20.0]).with_fit(FIT);

/// The incompressible law in tests with homogeneous deformation.
const FIT: FitForm = FitForm {
    formula: "P = μ g/(1 − i/J_m), i = I₁ − 3, g = λ − λ⁻² uniaxial, λ − λ⁻⁵ equibiaxial, λ − λ⁻³ planar",
    source: "Gent, Rubber Chem. Technol. 69 (1996)",
    parameters: fitted_parameters(KEYS),
    term_counts: &[1],
    default_count: 1,
    compressible: false,
    terms: FitTerms::Separable(ShapedTerm {
        tau: |limit, s| of_invariants(&Gent { mu: 1.0, limit }, s).tau,
        tau_by_shape: |limit, s| {
            let i = invariants(s).0;
            // w₁ = ½J_m/(J_m − i)
            tau(-0.5 * i / (limit - i).powi(2), 0.0, s)
        },
        shape: |x, reach| (reach * (1.0 + x.exp()), reach * x.exp()),
        grid: &[-7.0, -6.0, -5.0, -4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0],
        factor: |_| (1.0, 0.0),
    }),
};

/// Constants of W.
#[derive(Clone, Copy, Debug)]
pub struct Gent {
    /// μ \[Pa\]
    pub mu: f64,
    /// J_m \[–\]
    pub limit: f64,
}

impl Isochoric for Gent {
    const INFO: &'static LawInfo = &INFO;

    fn read(values: &Values, _: &Chosen) -> Result<Self, LawSpecError> {
        Ok(Self { mu: required(&INFO, values, "mu")?, limit: required(&INFO, values, "J_m")? })
    }

    fn values(&self) -> Vec<f64> {
        vec![self.mu, self.limit]
    }

    fn shear(&self) -> f64 {
        self.mu
    }
}

impl InvariantEnergy for Gent {
    const SECOND: bool = false;

    #[inline(always)]
    fn partials(&self, i: f64, _: f64) -> Result<Partials, LawError> {
        let Self { mu, limit } = *self;
        if i >= limit {
            return Err(LawError::Locked { i, limit });
        }
        let t = i / limit;
        let w1 = 0.5 * mu / (1.0 - t);
        Ok(Partials { w: -0.5 * mu * limit * (-t).ln_1p(), w1, w11: w1 / (limit * (1.0 - t)), ..Partials::default() })
    }
}

impl Parametric for Gent {
    /// ∂W/∂J_m = −½μ\[ln(1 − t) + t/(1 − t)\], t = i/J_m; the series of the bracket starts with ½t².
    fn partials_along(&self, rates: &[f64], i: f64, k: f64) -> Result<Partials, LawError> {
        let (Self { mu, limit }, [dmu, dlimit]) = (*self, [rates[0], rates[1]]);
        let p = self.partials(i, k)?;
        let t = i / limit;
        let (open, by_mu, by_limit) = (1.0 - t, dmu / mu, 0.5 * mu * dlimit);
        Ok(Partials {
            w: by_mu * p.w - by_limit * ((-t).ln_1p() + t / open),
            w1: by_mu * p.w1 - by_limit * t / (limit * open * open),
            w11: by_mu * p.w11 - by_limit * (1.0 + t) / (limit * limit * open.powi(3)),
            ..Partials::default()
        })
    }
}
