//! Mooney–Rivlin law with two, three or five terms.
//!
//! ψ = C10 i + C01 k + C11 ik + C20 i² + C02 k² + U(J), i = Ī₁ − 3, k = Ī₂ − 3
//!
//! Two terms: C10, C01; three: and C11; five: and C20, C02. A term that is not given is zero. The shear modulus at F = I is 2(C10 + C01).
//!
//! Sources: Mooney 1940; Rivlin 1948; Rivlin & Saunders, *Phil. Trans. R. Soc. A* 243, 1951, for the polynomial.
//!
//! Limits: J > 0. C01 < 0, and negative terms of higher order, lose stability at some stretch; see [`super::stability()`].

use super::isochoric::{self, Along, Parametric, Partials, Strain};
use super::registry::{Chosen, LawSpecError, Values};
use super::split::{self, Part, required};
use super::volumetric::{CHOICES, Volumetric};
use super::{LawError, LawInfo, Parameter, Response, Want, moduli};
use crate::math::tensor::Mat3;

/// Keys in files; κ and ν stand for each other.
pub const KEYS: &[Parameter] = &[
    moduli::NU,
    moduli::KAPPA,
    Parameter::modulus("C10", "C10", f64::NEG_INFINITY, "factor of Ī₁ − 3"),
    Parameter::modulus("C01", "C01", f64::NEG_INFINITY, "factor of Ī₂ − 3"),
    Parameter::modulus("C11", "C11", f64::NEG_INFINITY, "factor of (Ī₁ − 3)(Ī₂ − 3)"),
    Parameter::modulus("C20", "C20", f64::NEG_INFINITY, "factor of (Ī₁ − 3)²"),
    Parameter::modulus("C02", "C02", f64::NEG_INFINITY, "factor of (Ī₂ − 3)²"),
];

pub static INFO: LawInfo = LawInfo {
    name: "mooney_rivlin",
    formula: "ψ = C10 i + C01 k + C11 ik + C20 i² + C02 k² + U(J), i = Ī₁ − 3, k = Ī₂ − 3",
    source: "Rivlin & Saunders 1951; modified invariants: Holzapfel 2000, ch. 6",
    limits: "J > 0; negative terms lose stability at some stretch",
    parameters: KEYS.split_at(1).1,
    optional: 3,
    choices: CHOICES,
    survives_inversion: false,
    objective: true,
    isochoric: true,
};

/// Constants of W \[Pa\].
#[derive(Clone, Copy, Debug)]
pub struct MooneyRivlin {
    /// C10, C01, C11, C20, C02 \[Pa\]
    pub c: [f64; 5],
    /// How many of them the file gives, trailing zeros left away
    pub terms: usize,
}

impl Part for MooneyRivlin {
    const INFO: &'static LawInfo = &INFO;

    fn read(values: &Values, _: &Chosen) -> Result<Self, LawSpecError> {
        required(&INFO, values, "C10")?;
        required(&INFO, values, "C01")?;
        let (c, terms) = split::terms(values, ["C10", "C01", "C11", "C20", "C02"]);
        Ok(Self { c, terms })
    }

    fn values(&self) -> Vec<f64> {
        self.c[..self.terms].to_vec()
    }

    fn shear(&self) -> f64 {
        2.0 * (self.c[0] + self.c[1])
    }

    fn response(&self, u: &Volumetric, f: &Mat3, want: Want) -> Result<Response, LawError> {
        isochoric::response(self, u, f, want)
    }

    fn response_along(&self, rates: &[f64], u: &Volumetric, f: &Mat3, want: Want) -> Result<Response, LawError> {
        isochoric::response(&Along { part: self, rates }, u, f, want)
    }
}

impl Strain for MooneyRivlin {
    const SECOND: bool = true;

    #[inline(always)]
    fn partials(&self, i: f64, k: f64) -> Result<Partials, LawError> {
        let [c10, c01, c11, c20, c02] = self.c;
        Ok(Partials {
            w: i * (c10 + c11 * k + c20 * i) + k * (c01 + c02 * k),
            w1: c10 + c11 * k + 2.0 * c20 * i,
            w2: c01 + c11 * i + 2.0 * c02 * k,
            w11: 2.0 * c20,
            w12: c11,
            w22: 2.0 * c02,
        })
    }
}

impl Parametric for MooneyRivlin {
    /// W is linear in its constants.
    fn partials_along(&self, rates: &[f64], i: f64, k: f64) -> Result<Partials, LawError> {
        let mut c = [0.0; 5];
        c[..rates.len()].copy_from_slice(rates);
        Self { c, terms: rates.len() }.partials(i, k)
    }
}
