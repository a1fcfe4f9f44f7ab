//! Veronda–Westmann law of soft tissue.
//!
//! ψ = C1(e^{β(Ī₁ − 3)} − 1) − ½C1β(Ī₂ − 3) + U(J)
//!
//! The shear modulus at F = I is C1β.
//!
//! Source: Veronda & Westmann, *Mechanical characterization of skin – finite deformations*, J. Biomech. 3, 1970; the split form as in the FEBio theory
//! manual.
//!
//! Limits: J > 0. The second term is negative: stability is lost in compression for small β, see [`super::stability()`]. Refused
//! where the exponential leaves the range of numbers.

use super::isochoric::{self, Along, Parametric, Partials, Strain};
use super::registry::{Chosen, LawSpecError, Values};
use super::split::{Part, required};
use super::volumetric::{CHOICES, Volumetric};
use super::{LawError, LawInfo, Parameter, Response, Want, moduli};
use crate::math::tensor::Mat3;

/// Largest exponent β(Ī₁ − 3) \[–\]: e^600 is 1e260.
const LARGEST: f64 = 600.0;

/// Keys in files; κ and ν stand for each other.
pub const KEYS: &[Parameter] = &[
    moduli::NU,
    moduli::KAPPA,
    Parameter::modulus("C1", "C1", 0.0, "factor of the exponential"),
    Parameter::number("beta", "β", 0.0, "rate of the exponential"),
];

pub static INFO: LawInfo = LawInfo {
    name: "veronda_westmann",
    formula: "ψ = C1(e^{β(Ī₁ − 3)} − 1) − ½C1β(Ī₂ − 3) + U(J)",
    source: "Veronda & Westmann 1970; split form: FEBio theory manual",
    limits: "J > 0; the second term is negative, stability is lost at some stretch for small β",
    parameters: KEYS.split_at(1).1,
    optional: 0,
    choices: CHOICES,
    survives_inversion: false,
    objective: true,
    isochoric: true,
};

/// Constants of W.
#[derive(Clone, Copy, Debug)]
pub struct VerondaWestmann {
    /// C1 \[Pa\]
    pub c1: f64,
    /// β \[–\]
    pub beta: f64,
}

impl Part for VerondaWestmann {
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

    fn response(&self, u: &Volumetric, f: &Mat3, want: Want) -> Result<Response, LawError> {
        isochoric::response(self, u, f, want)
    }

    fn response_along(&self, rates: &[f64], u: &Volumetric, f: &Mat3, want: Want) -> Result<Response, LawError> {
        isochoric::response(&Along { part: self, rates }, u, f, want)
    }
}

impl Strain for VerondaWestmann {
    const SECOND: bool = true;

    #[inline(always)]
    fn partials(&self, i: f64, k: f64) -> Result<Partials, LawError> {
        let Self { c1, beta } = *self;
        let (y, half) = (beta * i, 0.5 * c1 * beta);
        if y > LARGEST {
            return Err(LawError::Locked { i, limit: LARGEST / beta });
        }
        let exp = c1 * y.exp_m1();
        let slope = beta * (exp + c1);
        Ok(Partials { w: exp - half * k, w1: slope, w2: -half, w11: beta * slope, ..Partials::default() })
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
