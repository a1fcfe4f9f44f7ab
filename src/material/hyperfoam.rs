//! Compressible law of foams with up to three terms (Ogden, Hill and Storåkers; *hyperfoam*).
//!
//! ψ = Σ (2μ_n/α_n²)\[λ₁^{α_n} + λ₂^{α_n} + λ₃^{α_n} − 3 + (J^{−α_nβ_n} − 1)/β_n\], β_n = ν_n/(1 − 2ν_n)
//!
//! At F = I the shear modulus is Σ μ_n and the bulk modulus Σ 2μ_n(⅓ + β_n). If all terms have the same ν, the logarithmic Poisson's ratio of a
//! uniaxial test is ν at every stretch, λ₂ = λ^{−ν}; ν = 0 is the limit β → 0, in which (J^{−αβ} − 1)/β → −α ln J.
//!
//! The foam of Blatz & Ko is α = −2, ν = ¼: ψ = ½μ(I₂/I₃ + 2√I₃ − 5).
//!
//! In eᵢ = ln λᵢ and s = ln J the law is Σ w(eᵢ) + g(s), where, with c = 2μ/α for each term, w is that of [`super::ogden`], and, with z = −αβs, g =
//! −c s (e^z − 1 − z)/z, g′ = −c(e^z − 1), g″ = c α β e^z.
//!
//! Sources: Ogden, Proc. R. Soc. A 328, 1972, 567–583; Hill, Adv. Appl. Mech. 18, 1978; Storåkers, J. Mech. Phys. Solids 34, 1986, 125–145; Blatz &
//! Ko, Trans. Soc. Rheol. 6, 1962.
//!
//! Limits: J > 0. Terms with μ_n < 0 or ν_n < 0 may lose stability at some stretch; see [`super::material_stability()`].

use super::entry::LawEntry;
use super::fit_form::{FitForm, FitTerms, ShapedTerm};
use super::kinematics::exp_m1_minus_y;
use super::law::{Law, LawInfo};
use super::moduli::Moduli;
use super::ogden::{Along as AlongOgden, Ogden, POWERS};
use super::parameter::{LawSpecError, Parameter, Values};
use super::response::{LawError, Response, Want};
use super::spectral::coupled;
use super::split::required;
use crate::math::tensor::Mat3;
use crate::math::units::Dimension;

/// Largest number of terms.
pub const TERMS: usize = 3;

const fn mu(name: &'static str, symbol: &'static str) -> Parameter {
    Parameter::new(name, symbol, Dimension::PRESSURE, Parameter::ANY, "part of the term in the shear modulus")
}

const fn alpha(name: &'static str, symbol: &'static str) -> Parameter {
    Parameter::new(name, symbol, Dimension::NONE, Parameter::ANY, "exponent of the term, not zero")
}

const fn nu(name: &'static str, symbol: &'static str) -> Parameter {
    Parameter::new(name, symbol, Dimension::NONE, (-1.0, 0.5), "Poisson's ratio of the term")
}

/// Keys in files.
pub const KEYS: &[Parameter] = &[
    mu("mu1", "μ₁"),
    alpha("alpha1", "α₁"),
    nu("nu1", "ν₁"),
    mu("mu2", "μ₂"),
    alpha("alpha2", "α₂"),
    nu("nu2", "ν₂"),
    mu("mu3", "μ₃"),
    alpha("alpha3", "α₃"),
    nu("nu3", "ν₃"),
];

pub static INFO: LawInfo = LawInfo {
    name: "hyperfoam",
    title: "hyperfoam",
    formula: "ψ = Σ (2μ_n/α_n²)[λ₁^{α_n} + λ₂^{α_n} + λ₃^{α_n} − 3 + (J^{−α_nβ_n} − 1)/β_n], β_n = ν_n/(1 − 2ν_n)",
    source: "Hill 1978; Storåkers 1986; Blatz & Ko 1962 with α = −2, ν = ¼",
    limits: "J > 0; terms of negative μ_n or ν_n may lose stability at some stretch",
    parameters: KEYS,
    optional: 3 * (TERMS - 1),
    choices: &[],
    survives_inversion: false,
    objective: true,
    isochoric: false,
};

/// The law in the registry.
pub const ENTRY: LawEntry = LawEntry::new(
    &INFO,
    KEYS,
    &[30e3, 6.0, 0.1, 10e3, -2.0, 0.25, 5e3, 2.0, 0.0],
    |v, _| Ok(Box::new(Hyperfoam::read(v)?)),
    |law, _, key| {
        let rate = |p: &Parameter| f64::from(u8::from(p.name == key));
        KEYS.iter().take(law.values().len()).map(rate).collect()
    },
)
.with_fit(FIT);

/// Keys of the constants that a fit finds; ν comes from the lateral strain and is the same in all terms.
const FITTED: &[Parameter] = &[KEYS[0], KEYS[1], KEYS[3], KEYS[4], KEYS[6], KEYS[7]];

const FIT: FitForm = FitForm {
    formula: "P = Σ (2μ_n/α_n)(λ^{α_n} − λ₃^{α_n})/λ, λ₃ = λ^{−ν} uniaxial, λ^{−2ν/(1 − ν)} equibiaxial, λ^{−ν/(1 − ν)} planar; μ_n ≥ 0",
    source: "Storåkers, J. Mech. Phys. Solids 34 (1986)",
    parameters: FITTED,
    term_counts: &[1, 2, 3],
    default_count: 1,
    compressible: true,
    // c = 2μ
    terms: FitTerms::Separable(ShapedTerm { factor: |_| (0.5, 0.0), ..POWERS }),
};

/// The law with its constants.
#[derive(Clone, Debug)]
pub struct Hyperfoam {
    /// μ \[Pa\], α, ν of each term
    terms: Vec<[f64; 3]>,
    /// The part in the principal stretches
    stretches: Ogden,
    hooke: Moduli,
}

/// β as a function of ν.
fn beta(nu: f64) -> f64 {
    nu / (1.0 - 2.0 * nu)
}

impl Hyperfoam {
    /// A foam of one to three terms μ \[Pa\], α, ν. Refuses zero exponents, and constants whose moduli at F = I are not positive.
    pub fn new(terms: &[[f64; 3]]) -> Result<Self, LawSpecError> {
        if let Some(n) = terms.iter().position(|t| t[1] == 0.0) {
            return Err(LawSpecError::ZeroExponent { key: KEYS[3 * n + 1].name });
        }
        let shear: f64 = terms.iter().map(|t| t[0]).sum();
        if !(shear > 0.0 && shear.is_finite()) {
            return Err(LawSpecError::NotStable { law: INFO.name, mu: shear });
        }
        let bulk: f64 = terms.iter().map(|[mu, _, nu]| 2.0 * mu * (1.0 / 3.0 + beta(*nu))).sum();
        if bulk.is_nan() || bulk <= 0.0 {
            return Err(LawSpecError::NoBulk { law: INFO.name, kappa: bulk });
        }
        let hooke = Moduli::from_pair(("mu", shear), ("kappa", bulk))?;
        let powers: Vec<[f64; 2]> = terms.iter().map(|[mu, alpha, _]| [2.0 * mu / alpha, *alpha]).collect();
        Ok(Self { terms: terms.to_vec(), stretches: Ogden::of_terms(&powers), hooke })
    }

    fn read(values: &Values) -> Result<Self, LawSpecError> {
        let terms = KEYS.iter().rposition(|p| values.contains_key(p.name)).map_or(1, |k| k / 3 + 1);
        let term = |n: usize| {
            let value = |k: usize| required(&INFO, values, KEYS[3 * n + k].name);
            Ok([value(0)?, value(1)?, value(2)?])
        };
        Self::new(&(0..terms).map(term).collect::<Result<Vec<_>, LawSpecError>>()?)
    }

    /// g, g′ and g″ at s = ln J.
    fn volume(&self, s: f64) -> [f64; 3] {
        self.terms.iter().fold([0.0; 3], |[g, d, h], [mu, alpha, nu]| {
            let (c, slope) = (2.0 * mu / alpha, alpha * beta(*nu));
            let z = -slope * s;
            [g - c * s * ratio(z), d - c * z.exp_m1(), h + c * slope * z.exp()]
        })
    }
}

/// (e^z − 1 − z)/z, 0 at z = 0
fn ratio(z: f64) -> f64 {
    if z == 0.0 { 0.0 } else { exp_m1_minus_y(z) / z }
}

/// Derivative of [`ratio`] with respect to z, \[z(e^z − 1) − (e^z − 1 − z)\]/z²
fn ratio_by_z(z: f64) -> f64 {
    // The series ½ + z/3 + z²/8: the next term is z³/30 < 1e-17
    if z.abs() < 1e-5 { 0.5 + z / 3.0 + z * z / 8.0 } else { (z * z.exp_m1() - exp_m1_minus_y(z)) / (z * z) }
}

impl Law for Hyperfoam {
    fn info(&self) -> &'static LawInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        self.terms.concat()
    }

    fn small_strain(&self) -> Moduli {
        self.hooke
    }

    fn eval(&self, f: &Mat3, want: Want) -> Result<Response, LawError> {
        coupled(&self.stretches, |s| self.volume(s), f, want)
    }

    fn along(&self, rates: &[f64]) -> Box<dyn Law> {
        let rates: Vec<[f64; 3]> = rates.chunks_exact(3).map(|r| [r[0], r[1], r[2]]).collect();
        let pairs = || self.terms.iter().zip(&rates);
        let power = |([mu, alpha, _], [dmu, dalpha, _]): (&[f64; 3], &[f64; 3])| {
            [(2.0 * dmu - 2.0 * mu / alpha * dalpha) / alpha, *dalpha]
        };
        let powers: Vec<[f64; 2]> = pairs().map(power).collect();
        let bulk = |([mu, _, nu], [dmu, _, dnu]): (&[f64; 3], &[f64; 3])| {
            2.0 * dmu * (1.0 / 3.0 + beta(*nu)) + 2.0 * mu * dnu / (1.0 - 2.0 * nu).powi(2)
        };
        let hooke = self.hooke.shifted(rates.iter().map(|r| r[0]).sum(), pairs().map(bulk).sum());
        Box::new(Along { law: self.clone(), stretches: self.stretches.along_terms(&powers), rates, hooke })
    }
}

/// ∂ψ/∂θ for these rates of μ, α, ν of each term.
#[derive(Clone, Debug)]
struct Along {
    law: Hyperfoam,
    stretches: AlongOgden,
    rates: Vec<[f64; 3]>,
    hooke: Moduli,
}

impl Along {
    /// ∂/∂θ of g, g′ and g″ at s, where c has the rate dc and z the rate dz = −s d(αβ).
    fn volume(&self, s: f64) -> [f64; 3] {
        let terms = self.law.terms.iter().zip(&self.rates);
        terms.fold([0.0; 3], |[g, d, h], ([mu, alpha, nu], [dmu, dalpha, dnu])| {
            let (c, b) = (2.0 * mu / alpha, beta(*nu));
            let dc = (2.0 * dmu - c * dalpha) / alpha;
            let (slope, change) = (alpha * b, dalpha * b + alpha * dnu / (1.0 - 2.0 * nu).powi(2));
            let (z, dz) = (-slope * s, -change * s);
            let exp = z.exp();
            [
                g - s * (dc * ratio(z) + c * ratio_by_z(z) * dz),
                d - dc * z.exp_m1() - c * exp * dz,
                h + exp * (dc * slope + c * (change + slope * dz)),
            ]
        })
    }
}

impl Law for Along {
    fn info(&self) -> &'static LawInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        self.rates.concat()
    }

    fn small_strain(&self) -> Moduli {
        self.hooke
    }

    fn eval(&self, f: &Mat3, want: Want) -> Result<Response, LawError> {
        coupled(&self.stretches, |s| self.volume(s), f, want)
    }

    /// Derivatives are those of the same law: see [`Law::along`].
    fn along(&self, rates: &[f64]) -> Box<dyn Law> {
        self.law.along(rates)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::tensor::Vec3;

    fn stress(law: &Hyperfoam, s: [f64; 3]) -> (f64, Vec3) {
        let r = law.eval(&Mat3::from_diagonal(&Vec3::from(s)), Want::Residual).expect("J > 0");
        (r.psi, r.p.diagonal())
    }

    /// The foam of Blatz & Ko: its energy from the invariants, to the rounding of their terms, and its uniaxial stress μ(λ₂⁻² − λ⁻²)/λ, λ₂ =
    /// λ^{−1/4}.
    #[test]
    fn blatz_and_ko() {
        let law = Hyperfoam::new(&[[40e3, -2.0, 0.25]]).expect("a foam");
        for s in [[1.3, 0.9, 1.1], [0.4, 0.7, 2.0], [1.0, 1.0, 1.0]] {
            let [a, b, c] = s.map(|x| x * x);
            let (i2, i3): (f64, f64) = (a * b + b * c + c * a, a * b * c);
            let expected = 20e3 * (i2 / i3 + 2.0 * i3.sqrt() - 5.0);
            assert!((stress(&law, s).0 - expected).abs() < 1e-14 * 20e3 * (i2 / i3 + 2.0 * i3.sqrt() + 5.0), "{s:?}");
        }
        for l in [0.3_f64, 0.9, 2.5] {
            let side = l.powf(-0.25);
            let (_, p) = stress(&law, [l, side, side]);
            let expected = 40e3 * (side.powi(-2) - l.powi(-2)) / l;
            assert!((p[0] / expected - 1.0).abs() < 1e-13 && p[1].abs() < 1e-12 * expected.abs(), "{l}: {p}");
        }
    }

    /// Hydrostatic stress of every term, P = (2μ/α)(λ^α − λ^{−3αβ})/λ, also at ν = 0; and with one ν in all terms the stretch λ₂ = λ^{−ν} is
    /// stress-free.
    #[test]
    fn closed_forms() {
        let terms = [[30e3, 7.0, 0.0], [12e3, -3.0, 0.3], [8e3, 1.5, -0.2]];
        let law = Hyperfoam::new(&terms).expect("a foam");
        for l in [0.5_f64, 0.97, 1.8] {
            let one = |[mu, alpha, nu]: &[f64; 3]| {
                2.0 * mu / alpha * (l.powf(*alpha) - l.powf(-3.0 * alpha * nu / (1.0 - 2.0 * nu))) / l
            };
            let expected: f64 = terms.iter().map(one).sum();
            let (_, p) = stress(&law, [l; 3]);
            assert!((p[0] / expected - 1.0).abs() < 1e-12, "{l}: {} not {expected}", p[0]);
        }
        for nu in [0.0, 0.12, 0.45] {
            let law = Hyperfoam::new(&terms.map(|[mu, alpha, _]| [mu, alpha, nu])).expect("a foam");
            for l in [0.4_f64, 1.6] {
                let side = l.powf(-nu);
                let (_, p) = stress(&law, [l, side, side]);
                let expected: f64 =
                    terms.iter().map(|t| 2.0 * t[0] / t[1] * (l.powf(t[1]) - side.powf(t[1])) / l).sum();
                assert!((p[0] / expected - 1.0).abs() < 1e-12 && p[1].abs() < 1e-11 * expected.abs(), "{nu} {l}: {p}");
            }
        }
    }

    /// The derivative of the ratio on both sides of the switch to its series: the difference formula loses ε/z² there.
    #[test]
    fn the_series_meets_the_difference() {
        for s in [-1.0, 1.0] {
            let (a, b) = (ratio_by_z(s * 0.999_999e-5), ratio_by_z(s * 1.000_001e-5));
            assert!((a - b).abs() < 1e-10, "{a} {b}");
        }
    }

    #[test]
    fn refuses_what_is_no_foam() {
        let message = |terms: &[[f64; 3]]| Hyperfoam::new(terms).expect_err("refused").to_string();
        assert!(message(&[[1e3, 0.0, 0.1]]).contains("`alpha1 = 0`"));
        assert!(message(&[[1e3, 2.0, 0.1], [-2e3, 4.0, 0.1]]).contains("shear modulus -1000 Pa"));
        assert!(message(&[[1e3, 2.0, -0.9], [-0.9e3, 4.0, 0.3]]).contains("has the bulk modulus"));
    }
}
