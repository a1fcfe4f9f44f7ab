//! Laws with an isochoric and a volumetric part: ψ = W(F̄) + U(J), F̄ = J^{−1/3} F.
//!
//! A law whose W is a function of Ī₁ and Ī₂ implements [`Isochoric`], any other law [`IsochoricPart`]; U(J), its constant from `kappa` or `nu`, and
//! the trait [`Law`] are provided here.

use super::entry::LawEntry;
use super::isochoric::{self, Parametric};
use super::law::{Law, LawInfo};
use super::moduli::Moduli;
use super::parameter::{Chosen, LawSpecError, Parameter, Values};
use super::response::{LaneResponse, LawError, Response, Want};
use super::volumetric::{Volumetric, VolumetricKind};
use crate::math::lanes::Lanes;
use crate::math::tensor::Mat3;

/// The parameters of a law whose `keys` are ν, κ and its constants, in this order: all except ν, from which κ follows.
pub const fn law_parameters(keys: &'static [Parameter]) -> &'static [Parameter] {
    keys.split_at(1).1
}

/// The parameters that are fitted to tests of an incompressible material: the constants without ν and κ.
pub const fn fitted_parameters(keys: &'static [Parameter]) -> &'static [Parameter] {
    keys.split_at(2).1
}

/// An isochoric part W with its constants.
pub trait IsochoricPart: Copy + Send + Sync + std::fmt::Debug + 'static {
    /// Description of the whole law; its parameters begin with κ
    const INFO: &'static LawInfo;

    /// Reads the part from values by key \[SI\]
    fn read(values: &Values, chosen: &Chosen) -> Result<Self, LawSpecError>;
    /// Values of the parameters after κ, in their order \[SI\]
    fn values(&self) -> Vec<f64>;
    /// Options chosen in addition to the volumetric part
    fn choices(&self) -> Vec<&'static str> {
        Vec::new()
    }
    /// Shear modulus at F = I \[Pa\]
    fn shear(&self) -> f64;
    /// ψ = W + U, P and A at F
    fn response(&self, u: &Volumetric, f: &Mat3, want: Want) -> Result<Response, LawError>;
    /// ψ = W + U, P and A at several deformation gradients, as in [`Law::eval_lanes`]
    fn lanes(
        &self,
        u: &Volumetric,
        f: &[Lanes; 9],
        want: Want,
        out: &mut LaneResponse,
    ) -> Result<(), (usize, LawError)> {
        out.fill(f, want, |f| self.response(u, f, want))
    }
    /// ∂W/∂θ + U and its derivatives at F, where the values change by `rates` per unit of θ
    fn response_along(&self, rates: &[f64], u: &Volumetric, f: &Mat3, want: Want) -> Result<Response, LawError>;
}

/// A part that is a function of Ī₁ and Ī₂, with its constants: its derivatives from [`Parametric`] give the responses of [`IsochoricPart`].
pub trait Isochoric: Parametric + Copy + Send + Sync + std::fmt::Debug + 'static {
    /// Description of the whole law; its parameters begin with κ
    const INFO: &'static LawInfo;

    /// Reads the part from values by key \[SI\]
    fn read(values: &Values, chosen: &Chosen) -> Result<Self, LawSpecError>;
    /// Values of the parameters after κ, in their order \[SI\]
    fn values(&self) -> Vec<f64>;
    /// Shear modulus at F = I \[Pa\]
    fn shear(&self) -> f64;
}

impl<W: Isochoric> IsochoricPart for W {
    const INFO: &'static LawInfo = <W as Isochoric>::INFO;

    fn read(values: &Values, chosen: &Chosen) -> Result<Self, LawSpecError> {
        <W as Isochoric>::read(values, chosen)
    }

    fn values(&self) -> Vec<f64> {
        Isochoric::values(self)
    }

    fn shear(&self) -> f64 {
        Isochoric::shear(self)
    }

    fn response(&self, u: &Volumetric, f: &Mat3, want: Want) -> Result<Response, LawError> {
        isochoric::response(self, u, f, want)
    }

    fn lanes(
        &self,
        u: &Volumetric,
        f: &[Lanes; 9],
        want: Want,
        out: &mut LaneResponse,
    ) -> Result<(), (usize, LawError)> {
        isochoric::lanes(self, u, f, want, out)
    }

    fn response_along(&self, rates: &[f64], u: &Volumetric, f: &Mat3, want: Want) -> Result<Response, LawError> {
        isochoric::response(&isochoric::Along { part: self, rates }, u, f, want)
    }
}

/// The law ψ = W + U.
#[derive(Clone, Copy, Debug)]
pub struct Split<W> {
    part: W,
    volumetric: Volumetric,
    hooke: Moduli,
}

impl<W: IsochoricPart> Split<W> {
    /// Builds the law; refuses a shear modulus at F = I that is not positive.
    pub fn new(part: W, volumetric: Volumetric) -> Result<Self, LawSpecError> {
        let hooke = Moduli::from_pair(("mu", shear(&part)?), ("kappa", volumetric.kappa))?;
        Ok(Self { part, volumetric, hooke })
    }

    /// The entry of the registry; `keys` are the parameters and `nu`, `sample` the values of the parameters of an example.
    pub const fn entry(keys: &'static [Parameter], sample: &'static [f64]) -> LawEntry {
        LawEntry::new(W::INFO, keys, sample, Self::read, rates)
    }

    /// Builds the law from a table: the constants of W, `volumetric`, and exactly one of `kappa` and `nu`.
    fn read(values: &Values, chosen: &Chosen) -> Result<Box<dyn Law>, LawSpecError> {
        let part = W::read(values, chosen)?;
        let mu = shear(&part)?;
        let of_nu = |nu: f64| Moduli::from_pair(("nu", nu), ("mu", mu));
        let hooke = match (values.get("kappa"), values.get("nu")) {
            (Some(&kappa), None) => Moduli::from_pair(("mu", mu), ("kappa", kappa))?,
            (None, Some(&nu)) => of_nu(nu)?,
            (Some(&kappa), Some(&nu)) => {
                return Err(LawSpecError::TwoVolumetric { kappa, nu, implied: of_nu(nu)?.kappa });
            }
            (None, None) => return Err(LawSpecError::NoVolumetric { law: W::INFO.name }),
        };
        let volumetric = Volumetric { kind: VolumetricKind::chosen(chosen), kappa: hooke.kappa };
        Ok(Box::new(Self { part, volumetric, hooke }))
    }
}

fn shear<W: IsochoricPart>(part: &W) -> Result<f64, LawSpecError> {
    let mu = part.shear();
    if mu > 0.0 && mu.is_finite() { Ok(mu) } else { Err(LawSpecError::NotStable { law: W::INFO.name, mu }) }
}

impl<W: IsochoricPart> Law for Split<W> {
    fn info(&self) -> &'static LawInfo {
        W::INFO
    }

    fn values(&self) -> Vec<f64> {
        [vec![self.volumetric.kappa], self.part.values()].concat()
    }

    fn choices(&self) -> Vec<&'static str> {
        [vec![self.volumetric.kind.name()], self.part.choices()].concat()
    }

    fn small_strain(&self) -> Moduli {
        self.hooke
    }

    fn eval(&self, f: &Mat3, want: Want) -> Result<Response, LawError> {
        self.part.response(&self.volumetric, f, want)
    }

    fn eval_lanes(&self, f: &[Lanes; 9], want: Want, out: &mut LaneResponse) -> Result<(), (usize, LawError)> {
        self.part.lanes(&self.volumetric, f, want, out)
    }

    fn split(&self) -> Option<(Box<dyn Law>, Volumetric)> {
        let rest = Self { volumetric: Volumetric { kappa: 0.0, ..self.volumetric }, ..*self };
        Some((Box::new(rest), self.volumetric))
    }

    fn along(&self, rates: &[f64]) -> Box<dyn Law> {
        let volumetric = Volumetric { kappa: rates[0], ..self.volumetric };
        let mut along = Along { law: *self, rates: rates[1..].to_vec(), volumetric, hooke: self.hooke };
        along.hooke = self.hooke.shifted(along.shear(), rates[0]);
        Box::new(along)
    }
}

/// ∂W/∂θ + U(J; ∂κ/∂θ).
#[derive(Clone, Debug)]
struct Along<W> {
    law: Split<W>,
    /// ∂/∂θ of the values of W
    rates: Vec<f64>,
    volumetric: Volumetric,
    hooke: Moduli,
}

impl<W: IsochoricPart> Along<W> {
    /// ∂μ₀/∂θ \[Pa\]: without U the shear modulus is A₁₂₁₂ at F = I.
    fn shear(&self) -> f64 {
        let none = Volumetric { kappa: 0.0, ..self.volumetric };
        let response = self.law.part.response_along(&self.rates, &none, &Mat3::identity(), Want::Tangent);
        response.expect("every law is defined at F = I").a[1][1]
    }
}

impl<W: IsochoricPart> Law for Along<W> {
    fn info(&self) -> &'static LawInfo {
        W::INFO
    }

    fn values(&self) -> Vec<f64> {
        [&[self.volumetric.kappa], &self.rates[..]].concat()
    }

    fn choices(&self) -> Vec<&'static str> {
        self.law.choices()
    }

    fn small_strain(&self) -> Moduli {
        self.hooke
    }

    fn eval(&self, f: &Mat3, want: Want) -> Result<Response, LawError> {
        self.law.part.response_along(&self.rates, &self.volumetric, f, want)
    }

    fn split(&self) -> Option<(Box<dyn Law>, Volumetric)> {
        let rest = Self { volumetric: Volumetric { kappa: 0.0, ..self.volumetric }, ..self.clone() };
        Some((Box::new(rest), self.volumetric))
    }

    /// Derivatives are those of the same law: see [`Law::along`].
    fn along(&self, rates: &[f64]) -> Box<dyn Law> {
        self.law.along(rates)
    }
}

/// Rates of (κ, values of W) with respect to `key`, where κ or ν was given: at fixed ν, κ = 2μ₀(1 + ν)/(3(1 − 2ν)) follows μ₀.
fn rates(law: &dyn Law, given: &Values, key: &str) -> Vec<f64> {
    let mut rates = vec![0.0; law.values().len()];
    if let Some(k) = law.info().parameters.iter().position(|p| p.name == key) {
        rates[k] = 1.0;
    }
    if let Some(nu) = given.get("nu") {
        let mu = law.small_strain().mu;
        rates[0] = match key {
            "nu" => 2.0 * mu / (1.0 - 2.0 * nu).powi(2),
            _ => law.along(&rates).small_strain().mu * 2.0 * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu)),
        };
    }
    rates
}

/// The value of a required key \[SI\].
pub fn required(law: &'static LawInfo, values: &Values, key: &'static str) -> Result<f64, LawSpecError> {
    values.get(key).copied().ok_or_else(|| {
        let meaning = law.parameters.iter().find(|p| p.name == key).map_or("", |p| p.meaning);
        LawSpecError::Missing { law: law.name, key, meaning }
    })
}

/// The values of terms that may be absent: a term that is not given is zero, and trailing terms that are not given are not counted.
pub fn terms<const N: usize>(values: &Values, keys: [&str; N]) -> ([f64; N], usize) {
    let given = keys.iter().rposition(|k| values.contains_key(*k)).map_or(0, |n| n + 1);
    (keys.map(|k| values.get(k).copied().unwrap_or(0.0)), given)
}
