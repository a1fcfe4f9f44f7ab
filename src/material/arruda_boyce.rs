//! Arruda–Boyce eight-chain law, with the five-term series of the inverse Langevin function.
//!
//! ψ = μ Σ_{n=1..5} c_n λ_m^{2−2n} (Ī₁ⁿ − 3ⁿ) + U(J), c = 1/2, 1/20, 11/1050, 19/7000, 519/673750
//!
//! μ is the constant of the chain statistics; the shear modulus at F = I is larger: μ₀ = μ(1 + 3/(5λ_m²) + 99/(175λ_m⁴) + 513/(875λ_m⁶) +
//! 42039/(67375λ_m⁸)).
//!
//! Source: Arruda & Boyce, *A three-dimensional constitutive model for the large stretch behavior of rubber elastic materials*, J. Mech. Phys. Solids
//! 41, 1993.
//!
//! Limits: J > 0. The series does not lock: at Ī₁ → 3λ_m², where the chains of the inverse Langevin function are fully stretched, it stays finite and
//! too soft.

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

/// c_n of the series of the inverse Langevin function.
pub const SERIES: [f64; 5] = [1.0 / 2.0, 1.0 / 20.0, 11.0 / 1050.0, 19.0 / 7000.0, 519.0 / 673_750.0];

/// Keys in files; either κ or ν is required.
pub const KEYS: &[Parameter] = &[
    moduli::NU,
    moduli::KAPPA,
    Parameter::new(
        "mu",
        "μ",
        Dimension::PRESSURE,
        Parameter::POSITIVE,
        "constant of the chain statistics, below the shear modulus at F = I",
    ),
    Parameter::new(
        "lambda_m",
        "λ_m",
        Dimension::NONE,
        (1.0, f64::INFINITY),
        "stretch at which the chains are fully stretched",
    ),
];

pub static INFO: LawInfo = LawInfo {
    name: "arruda_boyce",
    title: "Arruda–Boyce",
    formula: "ψ = μ Σ c_n λ_m^{2−2n} (Ī₁ⁿ − 3ⁿ) + U(J), n = 1 … 5, c = 1/2, 1/20, 11/1050, 19/7000, 519/673750",
    source: "Arruda & Boyce 1993; modified invariant: Holzapfel 2000, ch. 6",
    limits: "J > 0; the series is too soft near Ī₁ = 3λ_m², where the chains lock",
    parameters: law_parameters(KEYS),
    optional: 0,
    choices: CHOICES,
    survives_inversion: false,
    objective: true,
    isochoric: true,
};

/// The law in the registry.
pub const ENTRY: LawEntry = Split::<ArrudaBoyce>::entry(KEYS, &[200e3, 30e3, 2.5]).with_fit(FIT);

/// The incompressible law in tests with homogeneous deformation.
const FIT: FitForm = FitForm {
    formula: "P = 2μ g Σ n c_n (I₁/λ_m²)^{n−1}, n = 1 … 5, c = 1/2, 1/20, 11/1050, 19/7000, 519/673750, g = λ − λ⁻² uniaxial, λ − λ⁻⁵ equibiaxial, λ − λ⁻³ planar",
    source: "Arruda & Boyce, J. Mech. Phys. Solids 41 (1993)",
    parameters: fitted_parameters(KEYS),
    term_counts: &[1],
    default_count: 1,
    compressible: false,
    terms: FitTerms::Separable(ShapedTerm {
        tau: |limit, s| of_invariants(&ArrudaBoyce { mu: 1.0, limit }, s).tau,
        tau_by_shape: |limit, s| {
            let ratio = (3.0 + invariants(s).0) / (limit * limit);
            let powers =
                (0..).zip(SERIES).map(|(n, c)| f64::from(n + 1) * c * f64::from(-2 * n) * ratio.powi(n) / limit);
            tau(powers.sum(), 0.0, s)
        },
        shape: |x, _| (1.0 + x.exp(), x.exp()),
        grid: &[-7.0, -6.0, -5.0, -4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0],
        factor: |_| (1.0, 0.0),
    }),
};

/// Constants of W.
#[derive(Clone, Copy, Debug)]
pub struct ArrudaBoyce {
    /// μ \[Pa\]
    pub mu: f64,
    /// λ_m \[–\]
    pub limit: f64,
}

impl Isochoric for ArrudaBoyce {
    const INFO: &'static LawInfo = &INFO;

    fn read(values: &Values, _: &Chosen) -> Result<Self, LawSpecError> {
        Ok(Self { mu: required(&INFO, values, "mu")?, limit: required(&INFO, values, "lambda_m")? })
    }

    fn values(&self) -> Vec<f64> {
        vec![self.mu, self.limit]
    }

    fn shear(&self) -> f64 {
        2.0 * self.sums(0.0, |_| 1.0).1
    }
}

impl InvariantEnergy for ArrudaBoyce {
    const SECOND: bool = false;

    #[inline(always)]
    fn partials(&self, i: f64, _: f64) -> Result<Partials, LawError> {
        let (w, w1, w11) = self.sums(i, |_| 1.0);
        Ok(Partials { w, w1, w11, ..Partials::default() })
    }
}

impl Parametric for ArrudaBoyce {
    /// Along θ, μ λ_m^{2−2n} has the relative rate dμ/μ + (2 − 2n) dλ_m/λ_m.
    fn partials_along(&self, rates: &[f64], i: f64, _: f64) -> Result<Partials, LawError> {
        let (w, w1, w11) = self.sums(i, |n| rates[0] / self.mu + (2.0 - 2.0 * n) * rates[1] / self.limit);
        Ok(Partials { w, w1, w11, ..Partials::default() })
    }
}

impl ArrudaBoyce {
    /// W and its first two derivatives with respect to Ī₁ at Ī₁ = 3 + i. Ī₁ⁿ − 3ⁿ = i q_n, q_n = Ī₁ q_{n−1} + 3^{n−1}, avoids cancellation at small
    /// i. `factor` of n weights the terms.
    #[inline(always)]
    fn sums(&self, i: f64, factor: impl Fn(f64) -> f64) -> (f64, f64, f64) {
        let (i1, z) = (3.0 + i, 1.0 / (self.limit * self.limit));
        let (mut w, mut w1, mut w11) = (0.0, 0.0, 0.0);
        // μ λ_m^{2−2n}, q_n, 3^{n−1}, Ī₁^{n−1} and Ī₁^{n−2}
        let (mut scale, mut q, mut three, mut power, mut lower) = (self.mu, 1.0, 1.0, 1.0, 0.0);
        for (n, c) in (1..).zip(SERIES) {
            let n = f64::from(n);
            let c = c * factor(n);
            w += scale * c * i * q;
            w1 += scale * c * n * power;
            w11 += scale * c * n * (n - 1.0) * lower;
            three *= 3.0;
            q = i1 * q + three;
            scale *= z;
            (lower, power) = (power, power * i1);
        }
        (w, w1, w11)
    }
}
