//! Homogeneous load cases of isotropic laws: nominal stress against stretch.
//!
//! Compressible laws: the free lateral stretch is solved from zero lateral stress. Incompressible Neo-Hookean, in closed form:
//! P/μ = λ − λ⁻² (uniaxial), λ − λ⁻⁵ (equibiaxial), λ − λ⁻³ (planar), γ (simple shear). Source: Treloar, *The Physics of
//! Rubber Elasticity*, 3rd ed. 1975, ch. 5.

use super::{Law, LawError, Response, Want};
use crate::math::tensor::Mat3;

/// A homogeneous deformation; its amount is the stretch λ [–], or the shear γ [–] of simple shear.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum LoadCase {
    /// F = diag(λ, a, a), P₂₂ = P₃₃ = 0
    Uniaxial,
    /// F = diag(λ, λ, a), P₃₃ = 0
    Equibiaxial,
    /// F = diag(λ, 1, a), P₃₃ = 0; also called pure shear
    Planar,
    /// F = I + γ e₁ ⊗ e₂; nothing is free
    SimpleShear,
}

/// State of a homogeneously deformed block.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Homogeneous {
    pub f: Mat3,
    /// Lateral stretch a [–]; 1 in simple shear
    pub lateral: f64,
    /// Nominal stress [Pa]: P₁₁, in simple shear P₁₂
    pub stress: f64,
    /// dstress/d(amount) along the equilibrium path [Pa]
    pub slope: f64,
}

/// Why a load case has no state.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
pub enum LoadCaseError {
    #[error("{case:?} at {amount}: a stretch is a positive finite number (1 = undeformed, not the strain)")]
    NotAStretch { case: LoadCase, amount: f64 },
    #[error(
        "law `{law}` has no positive lateral stretch free of stress at {case:?} {amount}; it is beyond the range of the law ({limits})"
    )]
    NoLateralEquilibrium { law: &'static str, limits: &'static str, case: LoadCase, amount: f64 },
    #[error(transparent)]
    Law(#[from] LawError),
}

impl LoadCase {
    pub const ALL: [Self; 4] = [Self::Uniaxial, Self::Equibiaxial, Self::Planar, Self::SimpleShear];

    /// F at this amount [–] and lateral stretch a [–].
    fn gradient(self, amount: f64, a: f64) -> Mat3 {
        let (x, y, z) = match self {
            Self::Uniaxial => (amount, a, a),
            Self::Equibiaxial => (amount, amount, a),
            Self::Planar => (amount, 1.0, a),
            Self::SimpleShear => (1.0, 1.0, 1.0),
        };
        let mut f = Mat3::from_diagonal(&nalgebra::Vector3::new(x, y, z));
        if self == Self::SimpleShear {
            f[(0, 1)] = amount;
        }
        f
    }

    /// Lateral stretch [–] of an incompressible material.
    fn isochoric(self, amount: f64) -> f64 {
        match self {
            Self::Uniaxial => amount.powf(-0.5),
            Self::Equibiaxial => amount.powi(-2),
            Self::Planar => 1.0 / amount,
            Self::SimpleShear => 1.0,
        }
    }

    /// The diagonal entries of F, as rows of A, that follow the amount and those that follow a.
    fn moving(self) -> (&'static [usize], &'static [usize]) {
        match self {
            Self::Uniaxial => (&[0], &[4, 8]),
            Self::Equibiaxial => (&[0, 4], &[8]),
            Self::Planar => (&[0], &[8]),
            Self::SimpleShear => (&[1], &[]),
        }
    }

    /// Nominal stress of an incompressible Neo-Hookean material of shear modulus `mu` [Pa].
    pub fn incompressible_neo_hookean(self, mu: f64, amount: f64) -> f64 {
        mu * match self {
            Self::Uniaxial => amount - amount.powi(-2),
            Self::Equibiaxial => amount - amount.powi(-5),
            Self::Planar => amount - amount.powi(-3),
            Self::SimpleShear => amount,
        }
    }

    /// State of an isotropic law at this stretch λ (or shear γ) [–], lateral faces free.
    pub fn state(self, law: &dyn Law, amount: f64) -> Result<Homogeneous, LoadCaseError> {
        if !amount.is_finite() || (self != Self::SimpleShear && amount <= 0.0) {
            return Err(LoadCaseError::NotAStretch { case: self, amount });
        }
        let a = if self == Self::SimpleShear { 1.0 } else { self.lateral(law, amount)? };
        let f = self.gradient(amount, a);
        let r = law.eval(&f, Want::Tangent)?;
        let (driven, free) = self.moving();
        let sum = |row: usize, columns: &[usize]| columns.iter().map(|c| r.a[row][*c]).sum::<f64>();
        let mut slope = sum(driven[0], driven);
        if let Some(&side) = free.first() {
            // Along P_side = 0: da/d(amount) = −(∂P_side/∂amount)/(∂P_side/∂a)
            slope -= sum(driven[0], free) * sum(side, driven) / sum(side, free);
        }
        let stress = if self == Self::SimpleShear { r.p[(0, 1)] } else { r.p[(0, 0)] };
        Ok(Homogeneous { f, lateral: a, stress, slope })
    }

    /// Lateral stretch a [–] with P_side(a) = 0 to rounding: Newton inside a bracket, bisection where it would leave it.
    fn lateral(self, law: &dyn Law, amount: f64) -> Result<f64, LoadCaseError> {
        let free = self.moving().1;
        let side = |a: f64| -> Result<(f64, f64), LoadCaseError> {
            let Response { p, a: tangent, .. } = law.eval(&self.gradient(amount, a), Want::Tangent)?;
            Ok((p[(2, 2)], free.iter().map(|c| tangent[8][*c]).sum()))
        };
        let none = || LoadCaseError::NoLateralEquilibrium {
            law: law.info().name,
            limits: law.info().limits,
            case: self,
            amount,
        };
        // Bracket: pulled inwards below, pushed outwards above. Small steps stay on the branch that begins at F = I.
        let start = self.isochoric(amount);
        let (mut lo, mut hi) = (start, start);
        let mut steps = 0..400;
        while side(lo)?.0 > 0.0 {
            steps.next().ok_or_else(none)?;
            (hi, lo) = (lo, lo / 1.1);
        }
        while side(hi)?.0 < 0.0 {
            steps.next().ok_or_else(none)?;
            (lo, hi) = (hi, hi * 1.1);
        }
        let mut a = 0.5 * (lo + hi);
        for _ in 0..200 {
            let (p, slope) = side(a)?;
            if p < 0.0 {
                lo = a;
            } else {
                hi = a;
            }
            let newton = a - p / slope;
            let next = if lo < newton && newton < hi { newton } else { 0.5 * (lo + hi) };
            // Two ulp: the next step would move by rounding only
            if (newton - a).abs() <= 2.0 * f64::EPSILON * a || p == 0.0 || next == a {
                return Ok(a);
            }
            a = next;
        }
        Ok(a)
    }
}
