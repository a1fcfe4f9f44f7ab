//! Veronda–Westmann law of soft tissue.
//!
//! ψ = C1(e^{β(Ī₁ − 3)} − 1) − ½C1β(Ī₂ − 3) + U(J)
//!
//! The shear modulus at F = I is C1β.
//!
//! Source: Veronda & Westmann, *Mechanical characterization of skin – finite deformations*, J. Biomech. 3, 1970; the split form as in the FEBio
//! theory manual.
//!
//! Limits: J > 0. The second term is negative: stability is lost in compression for small β, see [`super::material_stability()`]. States at which the
//! exponential would leave the floating-point range are refused.

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

/// Largest exponent β(Ī₁ − 3) \[–\]: e^600 is 1e260.
const LARGEST: f64 = 600.0;

/// Keys in files; either κ or ν is required.
pub const KEYS: &[Parameter] = &[
    moduli::NU,
    moduli::KAPPA,
    Parameter::new("C1", "C1", Dimension::PRESSURE, Parameter::POSITIVE, "factor of the exponential"),
    Parameter::new("beta", "β", Dimension::NONE, Parameter::POSITIVE, "rate of the exponential"),
];

pub static INFO: LawInfo = LawInfo {
    name: "veronda_westmann",
    title: "Veronda–Westmann",
    formula: "ψ = C1(e^{β(Ī₁ − 3)} − 1) − ½C1β(Ī₂ − 3) + U(J)",
    source: "Veronda & Westmann 1970; split form: FEBio theory manual",
    limits: "J > 0; the second term is negative, stability is lost at some stretch for small β",
    parameters: law_parameters(KEYS),
    optional: 0,
    choices: CHOICES,
    survives_inversion: false,
    objective: true,
    isochoric: true,
};

/// The law in the registry.
pub const ENTRY: LawEntry = Split::<VerondaWestmann>::entry(KEYS, &[200e3, 60e3, 0.6]).with_fit(FIT);

/// The incompressible law in tests with homogeneous deformation.
const FIT: FitForm = FitForm {
    formula: "P = 2(1 − λ⁻³)(λψ₁ + ψ₂) uniaxial, 2(λ − λ⁻⁵)(ψ₁ + λ²ψ₂) equibiaxial, 2(λ − λ⁻³)(ψ₁ + ψ₂) planar, ψ₁ = C1βe^{βi}, ψ₂ = −½C1β, i = I₁ − 3",
    source: "Veronda & Westmann, J. Biomech. 3 (1970)",
    parameters: fitted_parameters(KEYS),
    term_counts: &[1],
    default_count: 1,
    compressible: false,
    terms: FitTerms::Separable(ShapedTerm {
        tau: |beta, s| of_invariants(&VerondaWestmann { c1: 1.0, beta }, s).tau,
        tau_by_shape: |beta, s| {
            let y = beta * invariants(s).0;
            tau((1.0 + y) * y.exp(), -0.5, s)
        },
        shape: |x, _| (x.exp(), x.exp()),
        grid: &[-7.0, -6.0, -5.0, -4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0],
        factor: |_| (1.0, 0.0),
    }),
};

/// Constants of W.
#[derive(Clone, Copy, Debug)]
pub struct VerondaWestmann {
    /// C1 \[Pa\]
    pub c1: f64,
    /// β \[–\]
    pub beta: f64,
}

impl Isochoric for VerondaWestmann {
    const INFO: &'static LawInfo = &INFO;

    fn read(values: &Values, _: &Chosen) -> Result<Self, LawSpecError> {
        Ok(Self { c1: required(&INFO, values, "C1")?, beta: required(&INFO, values, "beta")? })
    }

    fn values(&self) -> Vec<f64> {
        vec![self.c1, self.beta]
    }

    fn shear(&self) -> f64 {
        self.c1 * self.beta
    }
}

impl InvariantEnergy for VerondaWestmann {
    const SECOND: bool = true;

    #[inline(always)]
    fn partials(&self, i: f64, k: f64) -> Result<Partials, LawError> {
        let Self { c1, beta } = *self;
        let (y, half) = (beta * i, 0.5 * c1 * beta);
        if y > LARGEST {
            return Err(LawError::Locked { i, limit: LARGEST / beta });
        }
        let exp = c1 * y.exp_m1();
        let w1 = beta * (exp + c1);
        Ok(Partials { w: exp - half * k, w1, w2: -half, w11: beta * w1, ..Partials::default() })
    }
}

impl Parametric for VerondaWestmann {
    fn partials_along(&self, rates: &[f64], i: f64, k: f64) -> Result<Partials, LawError> {
        let (Self { c1, beta }, [dc1, dbeta]) = (*self, [rates[0], rates[1]]);
        let p = self.partials(i, k)?;
        let (by_c1, y) = (dc1 / c1, beta * i);
        let exp = c1 * y.exp() * dbeta;
        Ok(Partials {
            w: by_c1 * p.w + i * exp - 0.5 * c1 * dbeta * k,
            w1: by_c1 * p.w1 + (1.0 + y) * exp,
            w2: by_c1 * p.w2 - 0.5 * c1 * dbeta,
            w11: by_c1 * p.w11 + beta * (2.0 + y) * exp,
            ..Partials::default()
        })
    }
}
