//! Yeoh law.
//!
//! ψ = C10 i + C20 i² + C30 i³ + U(J), i = Ī₁ − 3
//!
//! C20 and C30 are zero if they are not given. The shear modulus at F = I is 2 C10.
//!
//! Source: Yeoh, *Some forms of the strain energy function for rubber*, Rubber Chem. Technol. 66, 1993.
//!
//! Limits: J > 0. With C20 < 0 (the usual S shape) stability may be lost before C30 > 0 restores it; see [`super::material_stability()`].

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
    Parameter::new("C10", "C10", Dimension::PRESSURE, Parameter::POSITIVE, "half of the shear modulus at F = I"),
    Parameter::new("C20", "C20", Dimension::PRESSURE, Parameter::ANY, "factor of (Ī₁ − 3)²"),
    Parameter::new("C30", "C30", Dimension::PRESSURE, Parameter::ANY, "factor of (Ī₁ − 3)³"),
];

pub static INFO: LawInfo = LawInfo {
    name: "yeoh",
    title: "Yeoh",
    formula: "ψ = C10 i + C20 i² + C30 i³ + U(J), i = Ī₁ − 3",
    source: "Yeoh 1993; modified invariant: Holzapfel 2000, ch. 6",
    limits: "J > 0; C20 < 0 may lose stability at some stretch",
    parameters: law_parameters(KEYS),
    optional: 2,
    choices: CHOICES,
    survives_inversion: false,
    objective: true,
    isochoric: true,
};

/// The law in the registry.
pub const ENTRY: LawEntry = Split::<Yeoh>::entry(KEYS, &[200e3, 18e3, -1e3, 0.3e3]).with_fit(FIT);

/// The incompressible law in tests with homogeneous deformation.
const FIT: FitForm = FitForm {
    formula: "P = 2ψ₁(λ − λ⁻²) uniaxial, 2ψ₁(λ − λ⁻⁵) equibiaxial, 2ψ₁(λ − λ⁻³) planar, ψ₁ = C10 + 2 C20 i + 3 C30 i², i = I₁ − 3",
    source: "Yeoh, Rubber Chem. Technol. 66 (1993)",
    parameters: fitted_parameters(KEYS),
    term_counts: &[1, 2, 3],
    default_count: 3,
    compressible: false,
    terms: FitTerms::Linear(|k, s| {
        let mut c = [0.0; 3];
        c[k] = 1.0;
        of_invariants(&Yeoh { c, terms: 3 }, s)
    }),
};

/// Constants of W \[Pa\].
#[derive(Clone, Copy, Debug)]
pub struct Yeoh {
    /// C10, C20, C30 \[Pa\]
    pub c: [f64; 3],
    /// Number of constants given in the file, without trailing zeros
    pub terms: usize,
}

impl Isochoric for Yeoh {
    const INFO: &'static LawInfo = &INFO;

    fn read(values: &Values, _: &Chosen) -> Result<Self, LawSpecError> {
        required(&INFO, values, "C10")?;
        let (c, terms) = split::terms(values, ["C10", "C20", "C30"]);
        Ok(Self { c, terms })
    }

    fn values(&self) -> Vec<f64> {
        self.c[..self.terms].to_vec()
    }

    fn shear(&self) -> f64 {
        2.0 * self.c[0]
    }
}

impl InvariantEnergy for Yeoh {
    const SECOND: bool = false;

    #[inline(always)]
    fn partials(&self, i: f64, _: f64) -> Result<Partials, LawError> {
        let [c10, c20, c30] = self.c;
        Ok(Partials {
            w: i * (c10 + i * (c20 + i * c30)),
            w1: c10 + i * (2.0 * c20 + i * 3.0 * c30),
            w11: 2.0 * c20 + 6.0 * c30 * i,
            ..Partials::default()
        })
    }
}

impl Parametric for Yeoh {
    /// W is linear in its constants.
    fn partials_along(&self, rates: &[f64], i: f64, k: f64) -> Result<Partials, LawError> {
        let mut c = [0.0; 3];
        c[..rates.len()].copy_from_slice(rates);
        Self { c, terms: rates.len() }.partials(i, k)
    }
}
