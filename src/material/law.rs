//! The trait of constitutive laws.

use super::moduli::Moduli;
use super::parameter::{Choice, Parameter};
use super::response::{LaneResponse, LawError, Response, Want};
use super::volumetric::Volumetric;
use crate::math::lanes::Lanes;
use crate::math::tensor::Mat3;

/// Description of a law.
#[derive(Debug)]
pub struct LawInfo {
    /// Name in files, e.g. `neo_hookean`
    pub name: &'static str,
    /// Name as in papers, e.g. `Neo-Hookean`
    pub title: &'static str,
    /// ψ as text, in the letters of the code
    pub formula: &'static str,
    /// Author, year, equation
    pub source: &'static str,
    /// Conditions under which the law must not be used
    pub limits: &'static str,
    /// Independent parameters; their bounds form a box, so a fit may move each alone
    pub parameters: &'static [Parameter],
    /// Number of parameters at the end that may be absent; their terms are then zero
    pub optional: usize,
    pub choices: &'static [Choice],
    /// Defined (finite ψ, P, A) for J ≤ 0; `limits` says whether it also restores inverted cells
    pub survives_inversion: bool,
    /// Whether ψ(QF) = ψ(F) for every rotation Q
    pub objective: bool,
    /// Whether ψ without U(J) is independent of the volume, so that the mean stress is U′(J) alone
    pub isochoric: bool,
}

/// A constitutive law with its constants.
pub trait Law: Send + Sync + std::fmt::Debug {
    fn info(&self) -> &'static LawInfo;
    /// Values of the parameters in the order of `info().parameters` \[SI\]; absent optional ones are omitted at the end
    fn values(&self) -> Vec<f64>;
    /// The chosen options, in the order of `info().choices`
    fn choices(&self) -> Vec<&'static str> {
        Vec::new()
    }
    /// Hooke's constants of the tangent at F = I
    fn small_strain(&self) -> Moduli;
    /// ψ, P and A at F
    fn eval(&self, f: &Mat3, want: Want) -> Result<Response, LawError>;
    /// ψ, P and A at [`LANES`](crate::math::lanes::LANES) deformation gradients, given by rows; if one is refused, the error has its lane and the
    /// reason.
    fn eval_lanes(&self, f: &[Lanes; 9], want: Want, out: &mut LaneResponse) -> Result<(), (usize, LawError)> {
        out.fill(f, want, |f| self.eval(f, want))
    }
    /// ψ = ψ_rest(F) + U(J): the law without its volumetric part, and that part, for mixed formulations; `None` for laws without such a split. If
    /// [`LawInfo::isochoric`] holds, ψ_rest(cF) = ψ_rest(F).
    fn split(&self) -> Option<(Box<dyn Law>, Volumetric)> {
        None
    }
    /// ∂/∂θ of the law, where [`Law::values`] change by `rates` per unit of θ: a function of F with its own ψ, P, A and split, and with rates in
    /// place of constants. It is not a material (its moduli may have any sign) and is not differentiated again.
    fn along(&self, rates: &[f64]) -> Box<dyn Law>;
    /// Whether [`Law::along`] is a closed form. Otherwise a run is differentiated by differences of whole scenes, with an estimate of their error.
    fn is_differentiated_exactly(&self) -> bool {
        true
    }
}
