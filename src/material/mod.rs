//! Constitutive laws: ψ(F) \[J/m³\], P = ∂ψ/∂F \[Pa\], A = ∂P/∂F \[Pa\].
//!
//! One file per law; [`registry::LAWS`] lists them, and the generic tests run over that list.

use crate::math::lanes::{LANES, Lanes};
use crate::math::tensor::{Mat3, Mat9, ZERO9};
use crate::math::units::Dimension;

pub mod arruda_boyce;
mod assemble;
pub mod corotational;
mod error;
pub mod gent;
pub mod isochoric;
pub mod kinematics;
pub mod linear;
pub mod load_case;
pub mod moduli;
pub mod mooney_rivlin;
pub mod neo_hookean;
pub mod neo_hookean_split;
pub mod ogden;
pub mod polar;
pub mod prony;
pub mod registry;
pub mod sensitivity;
pub mod spectral;
pub mod split;
pub mod st_venant_kirchhoff;
pub mod stability;
pub mod stable_neo_hookean;
pub mod veronda_westmann;
pub mod volumetric;
pub mod yeoh;

pub use load_case::{Homogeneous, LoadCase, LoadCaseError};
pub use moduli::Moduli;
pub use prony::{Arm, Constants, Prony, PronyError};
pub use registry::{LAWS, LawEntry, LawSpecError, law_from_table};
pub use sensitivity::derivative;
pub use stability::{Instability, Limit, Stability, stability};
pub use volumetric::{Volumetric, VolumetricKind};

/// How much of a response is needed; each includes the ones before it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Want {
    Energy,
    Residual,
    Tangent,
}

/// Response of a law at one deformation gradient. What was not wanted is zero.
#[derive(Clone, Debug)]
pub struct Response {
    /// ψ \[J/m³\]
    pub psi: f64,
    /// P \[Pa\], P\[(i, J)\] = ∂ψ/∂F_iJ
    pub p: Mat3,
    /// A \[Pa\], A\[3i+J\]\[3k+L\] = ∂P_iJ/∂F_kL
    pub a: Mat9,
}

impl Response {
    /// ψ \[J/m³\] alone; P and A are filled in where they are wanted.
    fn energy(psi: f64) -> Self {
        Self { psi, p: Mat3::zeros(), a: ZERO9 }
    }
}

/// Responses at [`LANES`] deformation gradients. What was not wanted is left as it was.
#[derive(Clone, Debug)]
pub struct LaneResponse {
    /// ψ \[J/m³\]
    pub psi: Lanes,
    /// P \[Pa\] by rows
    pub p: [Lanes; 9],
    /// A \[Pa\]
    pub a: [[Lanes; 9]; 9],
}

impl Default for LaneResponse {
    fn default() -> Self {
        Self { psi: Lanes::ZERO, p: [Lanes::ZERO; 9], a: [[Lanes::ZERO; 9]; 9] }
    }
}

impl LaneResponse {
    fn set(&mut self, lane: usize, one: &Response, want: Want) {
        self.psi.0[lane] = one.psi;
        if want >= Want::Residual {
            self.p.iter_mut().zip(assemble::rows(&one.p)).for_each(|(to, from)| to.0[lane] = from);
        }
        if want >= Want::Tangent {
            let entries = self.a.as_flattened_mut().iter_mut().zip(one.a.as_flattened());
            entries.for_each(|(to, from)| to.0[lane] = *from);
        }
    }
}

/// A law that is not defined at this deformation.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
pub enum LawError {
    /// det F ≤ 0 \[–\] in a law that needs J > 0
    #[error(
        "det F = {j:e} is not positive, where ln J and J^(-2/3) do not exist; take a smaller step or `stable_neo_hookean`"
    )]
    Inverted { j: f64 },
    /// Ī₁ − 3 \[–\] at or beyond the largest one of the law
    #[error(
        "Ī₁ − 3 = {i:e} reaches {limit:e}, beyond which the law is not defined: its chains are fully stretched; take a smaller step or load"
    )]
    Locked { i: f64, limit: f64 },
}

/// A parameter, declared once: parsing, messages, fit bounds and docs derive from it.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Key in files, e.g. `mu`
    pub name: &'static str,
    /// Symbol in formulae, e.g. `μ`
    pub symbol: &'static str,
    pub dimension: Dimension,
    /// Open interval in SI: lower < value < upper
    pub bounds: (f64, f64),
    pub meaning: &'static str,
}

impl Parameter {
    /// A stiffness \[Pa\] above `lower`.
    const fn modulus(name: &'static str, symbol: &'static str, lower: f64, meaning: &'static str) -> Self {
        Self { name, symbol, dimension: Dimension::PRESSURE, bounds: (lower, f64::INFINITY), meaning }
    }

    /// A number \[–\] above `lower`.
    const fn number(name: &'static str, symbol: &'static str, lower: f64, meaning: &'static str) -> Self {
        Self { name, symbol, dimension: Dimension::NONE, bounds: (lower, f64::INFINITY), meaning }
    }
}

/// A form of the law to choose by name, e.g. `volumetric = "quadratic"`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Choice {
    /// Key in files
    pub name: &'static str,
    pub options: &'static [&'static str],
    /// What is taken where the key is absent; without one the key is required
    pub default: Option<&'static str>,
    pub meaning: &'static str,
}

/// What a law says of itself.
#[derive(Debug)]
pub struct LawInfo {
    /// Name in files, e.g. `neo_hookean`
    pub name: &'static str,
    /// ψ as text, in the letters of the code
    pub formula: &'static str,
    /// Author, year, equation
    pub source: &'static str,
    /// Where it is not to be used
    pub limits: &'static str,
    /// Independent parameters; their bounds form a box, so a fit may move each alone
    pub parameters: &'static [Parameter],
    /// How many of the last parameters may be absent: terms that are zero then
    pub optional: usize,
    pub choices: &'static [Choice],
    /// Defined (finite ψ, P, A) for J ≤ 0; `limits` says whether it also drives inverted cells back
    pub survives_inversion: bool,
    /// ψ(QF) = ψ(F) for every rotation Q
    pub objective: bool,
    /// ψ without U(J) sees no change of volume, so that the mean stress is U′(J) alone
    pub isochoric: bool,
}

/// A constitutive law with its constants.
pub trait Law: Send + Sync + std::fmt::Debug {
    fn info(&self) -> &'static LawInfo;
    /// Values of the parameters in the order of `info().parameters` \[SI\]; optional ones that are absent are left away at the end
    fn values(&self) -> Vec<f64>;
    /// What was chosen, in the order of `info().choices`
    fn choices(&self) -> Vec<&'static str> {
        Vec::new()
    }
    /// Hooke's constants of the tangent at F = I
    fn small_strain(&self) -> Moduli;
    /// ψ, P and A at F
    fn eval(&self, f: &Mat3, want: Want) -> Result<Response, LawError>;
    /// The same at [`LANES`] deformation gradients, given by rows; where one is refused, its lane and why.
    fn eval_lanes(&self, f: &[Lanes; 9], want: Want, out: &mut LaneResponse) -> Result<(), (usize, LawError)> {
        for lane in 0..LANES {
            let f = Mat3::from_fn(|i, j| f[3 * i + j].0[lane]);
            out.set(lane, &self.eval(&f, want).map_err(|e| (lane, e))?, want);
        }
        Ok(())
    }
    /// ψ = ψ_rest(F) + U(J): the law without its volumetric part, and that part, for mixed formulations; None for laws without
    /// such a split. Where [`LawInfo::isochoric`] holds, ψ_rest(cF) = ψ_rest(F).
    fn split(&self) -> Option<(Box<dyn Law>, Volumetric)> {
        None
    }
    /// ∂/∂θ, where [`Law::values`] change by `rates` per unit of θ: a function of F with a ψ, P, A and split of its own, and
    /// rates where a law has constants. It is no material (its moduli may have any sign) and is not differentiated again.
    fn along(&self, rates: &[f64]) -> Box<dyn Law>;
}

/// The law of each kind that the tests share.
#[cfg(test)]
pub(crate) fn example(entry: &LawEntry) -> Box<dyn Law> {
    let name = entry.info.name;
    let mut all: toml::Table = include_str!("../../tests/common/laws.toml").parse().expect("TOML");
    let toml::Value::Table(mut table) = all.remove(name).unwrap_or_else(|| panic!("no {name} in laws.toml")) else {
        panic!("{name} in laws.toml is not a table")
    };
    table.insert("law".into(), name.into());
    law_from_table(&table).unwrap_or_else(|e| panic!("{name}: {e}"))
}
