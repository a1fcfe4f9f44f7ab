//! The form in which a law is fitted to tests with homogeneous deformation: incompressible, or with a constant logarithmic Poisson's ratio.
//!
//! P = Σ_k m_k φ_k(λ): linear in the factors m of its terms. If a law has shape constants θ (an exponent, a limit of the chains), each term has one
//! of them.

use super::parameter::Parameter;
use super::principal::PrincipalDerivatives;

/// Description of a law for a fit.
#[derive(Clone, Copy, Debug)]
pub struct FitForm {
    /// Nominal stress as text
    pub formula: &'static str,
    pub source: &'static str,
    /// Fitted constants in the order of files, with those of the last terms at the end
    pub parameters: &'static [Parameter],
    /// Available numbers of terms
    pub term_counts: &'static [usize],
    /// The number of terms if none is chosen
    pub default_count: usize,
    /// The lateral stretches of a test follow Poisson's ratio ν, the keys `nu1`, `nu2`, … of the terms; otherwise the volume is constant
    pub compressible: bool,
    pub terms: FitTerms,
}

/// Dependence of the stress on the fitted constants.
#[derive(Clone, Copy, Debug)]
pub enum FitTerms {
    /// Linear: derivatives of term k with factor 1. The number of terms equals the number of constants.
    Linear(fn(usize, [f64; 3]) -> PrincipalDerivatives),
    /// A factor m and a shape constant θ per term, alternating
    Separable(ShapedTerm),
}

/// A term w(λ; θ) with factor c ≥ 0; its shape constant θ is searched as a number x in ±[`ShapedTerm::wall`].
#[derive(Clone, Copy, Debug)]
pub struct ShapedTerm {
    /// τ/c \[–\]; NaN where the term is not defined
    pub tau: fn(f64, [f64; 3]) -> [f64; 3],
    /// ∂τ/∂θ
    pub tau_by_shape: fn(f64, [f64; 3]) -> [f64; 3],
    /// θ and ∂θ/∂x at x, given the largest I₁ − 3 of the fitted data points
    pub shape: fn(f64, f64) -> (f64, f64),
    /// Starting values of x, ascending; |x| stays below twice the largest
    pub grid: &'static [f64],
    /// s(θ) and s′(θ) in m = s(θ)c, where m is the factor in files
    pub factor: fn(f64) -> (f64, f64),
}

impl ShapedTerm {
    /// Largest |x| that is searched: twice the largest starting value.
    pub fn wall(&self) -> f64 {
        2.0 * self.grid.iter().fold(0.0_f64, |w, g| w.max(g.abs()))
    }
}
