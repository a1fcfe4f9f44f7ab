//! Ogden law with up to four terms.
//!
//! ψ = Σ (μ_n/α_n)(λ̄₁^{α_n} + λ̄₂^{α_n} + λ̄₃^{α_n} − 3) + U(J), λ̄ᵢ = J^{−1/3} λᵢ
//!
//! The shear modulus at F = I is ½ Σ μ_n α_n. Two other conventions are read, selected by `convention`, with their own μ_n:
//!
//! | `convention` | W | μ of this page | shear modulus |
//! |---|---|---|---|
//! | `"ogden"`, the default | Σ (μ_n/α_n)(Σλ̄^{α_n} − 3) | μ_n | ½ Σ μ_n α_n |
//! | `"abaqus"` (also CalculiX) | Σ (2μ_n/α_n²)(Σλ̄^{α_n} − 3) | 2μ_n/α_n | Σ μ_n |
//! | `"febio"` | Σ (c_n/α_n²)(Σλ̄^{α_n} − 3), c_n = μ_n | c_n/α_n | ½ Σ c_n |
//!
//! Source: Ogden, *Large deformation isotropic elasticity – on the correlation of theory and experiment for incompressible rubberlike solids*, Proc.
//! R. Soc. A 326, 1972; the conventions after the manuals of the programs.
//!
//! Limits: J > 0. Laws with terms whose μ_n α_n have opposite signs may lose stability at some stretch; see [`super::material_stability()`].

use super::entry::LawEntry;
use super::fit_form::{FitForm, FitTerms, ShapedTerm};
use super::kinematics::exp_m1_minus_y;
use super::law::LawInfo;
use super::parameter::{Choice, Chosen, LawSpecError, Parameter, Values};
use super::response::{LawError, Response, Want};
use super::spectral::{Sums, ValanisLandel, power_quotient};
use super::split::{IsochoricPart, Split, fitted_parameters, law_parameters, required};
use super::volumetric::{CHOICE, Volumetric};
use super::{moduli, spectral};
use crate::math::tensor::Mat3;
use crate::math::units::Dimension;
use std::collections::BTreeMap;

/// Largest number of terms.
pub const TERMS: usize = 4;

const fn mu(name: &'static str, symbol: &'static str) -> Parameter {
    Parameter::new(name, symbol, Dimension::PRESSURE, Parameter::ANY, "factor of the term, in the chosen convention")
}

const fn alpha(name: &'static str, symbol: &'static str) -> Parameter {
    Parameter::new(name, symbol, Dimension::NONE, Parameter::ANY, "exponent of the term, not zero")
}

/// Keys in files; either κ or ν is required.
pub const KEYS: &[Parameter] = &[
    moduli::NU,
    moduli::KAPPA,
    mu("mu1", "μ₁"),
    alpha("alpha1", "α₁"),
    mu("mu2", "μ₂"),
    alpha("alpha2", "α₂"),
    mu("mu3", "μ₃"),
    alpha("alpha3", "α₃"),
    mu("mu4", "μ₄"),
    alpha("alpha4", "α₄"),
];

/// Keys of μ_n and α_n of each term.
const PAIRS: [(&str, &str); TERMS] = [("mu1", "alpha1"), ("mu2", "alpha2"), ("mu3", "alpha3"), ("mu4", "alpha4")];

pub static INFO: LawInfo = LawInfo {
    name: "ogden",
    title: "Ogden",
    formula: "ψ = Σ (μ_n/α_n)(λ̄₁^{α_n} + λ̄₂^{α_n} + λ̄₃^{α_n} − 3) + U(J), λ̄ᵢ = J^{−1/3} λᵢ",
    source: "Ogden 1972; modified stretches: Holzapfel 2000, ch. 6",
    limits: "J > 0; terms of opposite signs may lose stability at some stretch",
    parameters: law_parameters(KEYS),
    optional: 2 * (TERMS - 1),
    choices: &[
        CHOICE,
        Choice {
            name: "convention",
            options: &["ogden", "abaqus", "febio"],
            default: Some("ogden"),
            meaning: "whose factor μ_n is: μ_n/α_n, 2μ_n/α_n² or μ_n/α_n²",
            formulas: &["μ_n/α_n", "2μ_n/α_n²", "μ_n/α_n²"],
        },
    ],
    survives_inversion: false,
    objective: true,
    isochoric: true,
};

/// The law in the registry.
pub const ENTRY: LawEntry = Split::<Ogden>::entry(KEYS, &[200e3, 10e3, 3.0, -8e3, -4.0, 2e3, 1.0])
    .with_fit(FIT)
    .with_conversion(to_own_convention);

/// The incompressible law in tests with homogeneous deformation.
const FIT: FitForm = FitForm {
    formula: "P = Σ μ_n (λ^{α_n − 1} − λ₃^{α_n}/λ), λ₃ = λ^{−1/2} uniaxial, λ⁻² equibiaxial, λ⁻¹ planar; μ_n α_n ≥ 0",
    source: "Ogden, Proc. R. Soc. A 326 (1972)",
    parameters: fitted_parameters(KEYS),
    term_counts: &[1, 2, 3, 4],
    default_count: 3,
    compressible: false,
    terms: FitTerms::Separable(ShapedTerm { factor: |alpha| (1.0 / alpha, -1.0 / (alpha * alpha)), ..POWERS }),
};

/// Terms w = (Σ λ^α − 3)/α² with factors μα, so that τᵢ = λᵢ^α/α. The pressure 1/α is subtracted, which makes τ smooth where α changes its sign.
pub(super) const POWERS: ShapedTerm = ShapedTerm {
    tau: |alpha, s| s.map(|x| power(alpha, x)),
    tau_by_shape: |alpha, s| s.map(|x| power_by_alpha(alpha, x)),
    shape: |x, _| (x, 1.0),
    grid: &[-12.0, -8.0, -5.0, -3.0, -2.0, -1.0, 0.6, 1.3, 2.0, 3.0, 4.5, 6.5, 9.0, 13.0, 18.0],
    factor: |_| (1.0, 0.0),
};

/// μ_n in μ_n/α_n \[Pa\], from the factor of a term in another convention.
fn own_factor(convention: &str, mu: f64, alpha: f64) -> f64 {
    match convention {
        "abaqus" => 2.0 * mu / alpha,
        "febio" => mu / alpha,
        _ => mu,
    }
}

/// Converts the μ_n of another convention to those of Ogden's; returns false if they are already in it.
fn to_own_convention(values: &mut Values, options: &mut BTreeMap<String, String>) -> bool {
    let own = "ogden".to_string();
    let given = options.insert("convention".into(), own.clone()).unwrap_or(own.clone());
    for (mu, alpha) in PAIRS {
        if let (Some(m), Some(a)) = (values.get(mu).copied(), values.get(alpha).copied()) {
            values.insert(mu.into(), own_factor(&given, m, a));
        }
    }
    given != own
}

/// Constants of W.
#[derive(Clone, Copy, Debug)]
pub struct Ogden {
    /// μ_n as given, in `convention` \[Pa\]
    given: [f64; TERMS],
    /// μ_n in μ_n/α_n \[Pa\]
    mu: [f64; TERMS],
    /// α_n \[–\]
    alpha: [f64; TERMS],
    terms: usize,
    convention: &'static str,
}

impl Ogden {
    /// The law with μ_n in μ_n/α_n \[Pa\] and α_n, for at most [`TERMS`] terms.
    pub(super) fn of_terms(terms: &[[f64; 2]]) -> Self {
        let mut law = Self {
            given: [0.0; TERMS],
            mu: [0.0; TERMS],
            alpha: [1.0; TERMS],
            terms: terms.len(),
            convention: "ogden",
        };
        for (n, [mu, alpha]) in terms.iter().enumerate() {
            (law.given[n], law.mu[n], law.alpha[n]) = (*mu, *mu, *alpha);
        }
        law
    }

    /// ∂W/∂θ for these rates of each term.
    pub(super) fn along_terms(self, rates: &[[f64; 2]]) -> Along {
        let mut along = Along { law: self, mu: [0.0; TERMS], alpha: [0.0; TERMS] };
        for (n, [mu, alpha]) in rates.iter().enumerate() {
            (along.mu[n], along.alpha[n]) = (*mu, *alpha);
        }
        along
    }

    fn terms(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.mu.iter().copied().zip(self.alpha.iter().copied()).take(self.terms)
    }
}

impl IsochoricPart for Ogden {
    const INFO: &'static LawInfo = &INFO;

    fn read(values: &Values, chosen: &Chosen) -> Result<Self, LawSpecError> {
        let terms =
            PAIRS.iter().rposition(|(m, a)| values.contains_key(*m) || values.contains_key(*a)).map_or(1, |n| n + 1);
        let convention = chosen["convention"];
        let mut law = Self { given: [0.0; TERMS], mu: [0.0; TERMS], alpha: [1.0; TERMS], terms, convention };
        for (n, (m, a)) in PAIRS.into_iter().enumerate().take(terms) {
            let (mu, alpha) = (required(&INFO, values, m)?, required(&INFO, values, a)?);
            if alpha == 0.0 {
                return Err(LawSpecError::ZeroExponent { key: a });
            }
            law.given[n] = mu;
            law.alpha[n] = alpha;
            law.mu[n] = own_factor(convention, mu, alpha);
        }
        Ok(law)
    }

    fn values(&self) -> Vec<f64> {
        (0..self.terms).flat_map(|n| [self.given[n], self.alpha[n]]).collect()
    }

    fn choices(&self) -> Vec<&'static str> {
        vec![self.convention]
    }

    fn shear(&self) -> f64 {
        0.5 * self.terms().map(|(mu, alpha)| mu * alpha).sum::<f64>()
    }

    fn response(&self, u: &Volumetric, f: &Mat3, want: Want) -> Result<Response, LawError> {
        spectral::response(self, u, f, want)
    }

    fn response_along(&self, rates: &[f64], u: &Volumetric, f: &Mat3, want: Want) -> Result<Response, LawError> {
        let rate = |(n, rates): (usize, &[f64])| {
            let ([given, dalpha], mu, alpha) = ([rates[0], rates[1]], self.mu[n], self.alpha[n]);
            let dmu = match self.convention {
                "abaqus" => (2.0 * given - mu * dalpha) / alpha,
                "febio" => (given - mu * dalpha) / alpha,
                _ => given,
            };
            [dmu, dalpha]
        };
        let rates: Vec<[f64; 2]> = rates.chunks_exact(2).enumerate().map(rate).collect();
        spectral::response(&self.along_terms(&rates), u, f, want)
    }
}

impl ValanisLandel for Ogden {
    /// w = (μ/α)(e^{αē} − 1 − αē) and w′ = μ(e^{αē} − 1): the terms added to (μ/α) e^{αē} cancel in the sum if Σē = 0.
    #[inline(always)]
    fn sums(&self, e: &[f64; 3]) -> Sums {
        let mut s = Sums { w: 0.0, dw: [0.0; 3], d2w: [0.0; 3] };
        for (mu, alpha) in self.terms() {
            for (i, e) in e.iter().enumerate() {
                let y = alpha * e;
                let exp = y.exp_m1();
                s.w += mu / alpha * if y.abs() < 0.5 { exp_m1_minus_y(y) } else { exp - y };
                s.dw[i] += mu * exp;
                s.d2w[i] += mu * alpha * (exp + 1.0);
            }
        }
        s
    }

    #[inline(always)]
    fn quotient(&self, a: f64, b: f64) -> f64 {
        self.terms().map(|(mu, alpha)| mu * (alpha * b).exp() * power_quotient(alpha, a - b)).sum()
    }
}

/// ∂W/∂θ from the rates of μ_n in μ_n/α_n and of α_n.
#[derive(Clone, Copy, Debug)]
pub(super) struct Along {
    law: Ogden,
    mu: [f64; TERMS],
    alpha: [f64; TERMS],
}

impl Along {
    /// μ, α and their rates, term by term.
    fn terms(&self) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
        let rates = self.mu.iter().zip(&self.alpha).map(|(mu, alpha)| [*mu, *alpha]);
        self.law.terms().map(|(mu, alpha)| [mu, alpha]).zip(rates)
    }
}

impl ValanisLandel for Along {
    /// With y = αē: ∂w/∂α = (μ/α²)\[y(eʸ − 1) − (eʸ − 1 − y)\] and ∂w′/∂α = μ ē eʸ.
    fn sums(&self, e: &[f64; 3]) -> Sums {
        let mut s = Sums { w: 0.0, dw: [0.0; 3], d2w: [0.0; 3] };
        for ([mu, alpha], [dmu, dalpha]) in self.terms() {
            for (i, e) in e.iter().enumerate() {
                let y = alpha * e;
                let exp = y.exp_m1();
                let small = if y.abs() < 0.5 { exp_m1_minus_y(y) } else { exp - y };
                s.w += dmu / alpha * small + dalpha * mu / (alpha * alpha) * (y * exp - small);
                s.dw[i] += dmu * exp + dalpha * mu * e * (exp + 1.0);
                s.d2w[i] += (dmu * alpha + dalpha * mu * (1.0 + y)) * (exp + 1.0);
            }
        }
        s
    }

    fn quotient(&self, a: f64, b: f64) -> f64 {
        let d = a - b;
        // d/(eᵈ − 1); below 1e-150 the floating-point range is exhausted before the accuracy.
        let ratio = if d < 1e-150 { 1.0 } else { d / d.exp_m1() };
        let term = |([mu, alpha], [dmu, dalpha]): ([f64; 2], [f64; 2])| {
            let by_alpha = b * power_quotient(alpha, d) + ratio * (alpha * d).exp();
            (alpha * b).exp() * (dmu * power_quotient(alpha, d) + dalpha * mu * by_alpha)
        };
        self.terms().map(term).sum()
    }
}

/// Computes (λ^α − 1)/α.
fn power(alpha: f64, x: f64) -> f64 {
    let e = x.ln();
    if alpha == 0.0 { e } else { (alpha * e).exp_m1() / alpha }
}

/// ∂/∂α of [`power`], \[αe λ^α − (λ^α − 1)\]/α², by its series where the difference cancels
fn power_by_alpha(alpha: f64, x: f64) -> f64 {
    let e = x.ln();
    let y = alpha * e;
    if y.abs() < 1e-2 {
        // e²(1/2 + y/3 + y²/8 + y³/30 + y⁴/144 + y⁵/840): the next term is y⁶/5760 < 2e-16
        let series = [1.0 / 840.0, 1.0 / 144.0, 1.0 / 30.0, 1.0 / 8.0, 1.0 / 3.0, 0.5];
        return e * e * series.iter().fold(0.0, |s, c| s * y + c);
    }
    let grown = y.exp_m1();
    (y + (y - 1.0) * grown) / (alpha * alpha)
}
