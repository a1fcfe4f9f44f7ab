//! Mooney–Rivlin law with two, three or five terms.
//!
//! ψ = C10 i + C01 k + C11 ik + C20 i² + C02 k² + U(J), i = Ī₁ − 3, k = Ī₂ − 3
//!
//! Two terms: C10 and C01; three terms: also C11; five terms: also C20 and C02. Terms that are not given are zero. The shear modulus at F = I is
//! 2(C10 + C01).
//!
//! Sources: Mooney 1940; Rivlin 1948; Rivlin & Saunders, *Phil. Trans. R. Soc. A* 243, 1951, for the polynomial.
//!
//! Limits: J > 0. With C01 < 0, or negative terms of higher order, stability is lost at some stretch; see [`super::material_stability()`].

use super::entry::LawEntry;
use super::fit_form::{FitForm, FitTerms};
use super::isochoric::{InvariantEnergy, Parametric, Partials};
use super::law::LawInfo;
use super::parameter::{Chosen, LawSpecError, Parameter, Values};
use super::principal::of_invariants;
use super::response::LawError;
use super::split::{Isochoric, Split, fitted_parameters, law_parameters, required};
use super::volumetric::CHOICES;
use super::{moduli, split};
use crate::math::units::Dimension;

/// Keys in files; either κ or ν is required.
pub const KEYS: &[Parameter] = &[
    moduli::NU,
    moduli::KAPPA,
    Parameter::new("C10", "C10", Dimension::PRESSURE, Parameter::ANY, "factor of Ī₁ − 3"),
    Parameter::new("C01", "C01", Dimension::PRESSURE, Parameter::ANY, "factor of Ī₂ − 3"),
    Parameter::new("C11", "C11", Dimension::PRESSURE, Parameter::ANY, "factor of (Ī₁ − 3)(Ī₂ − 3)"),
    Parameter::new("C20", "C20", Dimension::PRESSURE, Parameter::ANY, "factor of (Ī₁ − 3)²"),
    Parameter::new("C02", "C02", Dimension::PRESSURE, Parameter::ANY, "factor of (Ī₂ − 3)²"),
];

pub static INFO: LawInfo = LawInfo {
    name: "mooney_rivlin",
    title: "Mooney–Rivlin",
    formula: "ψ = C10 i + C01 k + C11 ik + C20 i² + C02 k² + U(J), i = Ī₁ − 3, k = Ī₂ − 3",
    source: "Rivlin & Saunders 1951; modified invariants: Holzapfel 2000, ch. 6",
    limits: "J > 0; negative terms lose stability at some stretch",
    parameters: law_parameters(KEYS),
    optional: 3,
    choices: CHOICES,
    survives_inversion: false,
    objective: true,
    isochoric: true,
};

/// The law in the registry.
pub const ENTRY: LawEntry = Split::<MooneyRivlin>::entry(KEYS, &[200e3, 12e3, 5e3, 1e3, 0.5e3, 0.2e3]).with_fit(FIT);

/// The incompressible law in tests with homogeneous deformation.
const FIT: FitForm = FitForm {
    formula: "P = 2(1 − λ⁻³)(λψ₁ + ψ₂) uniaxial, 2(λ − λ⁻⁵)(ψ₁ + λ²ψ₂) equibiaxial, 2(λ − λ⁻³)(ψ₁ + ψ₂) planar, ψ₁ = C10 + C11 k + 2 C20 i, ψ₂ = C01 + C11 i + 2 C02 k, i = I₁ − 3, k = I₂ − 3",
    source: "Rivlin & Saunders, Phil. Trans. R. Soc. A 243 (1951)",
    parameters: fitted_parameters(KEYS),
    term_counts: &[2, 3, 5],
    default_count: 2,
    compressible: false,
    terms: FitTerms::Linear(|k, s| {
        let mut c = [0.0; 5];
        c[k] = 1.0;
        of_invariants(&MooneyRivlin { c, terms: 5 }, s)
    }),
};

/// Constants of W \[Pa\].
#[derive(Clone, Copy, Debug)]
pub struct MooneyRivlin {
    /// C10, C01, C11, C20, C02 \[Pa\]
    pub c: [f64; 5],
    /// Number of constants given in the file, without trailing zeros
    pub terms: usize,
}

impl Isochoric for MooneyRivlin {
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
}

impl InvariantEnergy for MooneyRivlin {
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
