//! Stable neo-Hookean law, defined and restoring for every F.
//!
//! ψ = ½μ(I₁ − 3) + ½λ(J − α)² − ½μ ln(I₁ + 1) − ψ₀, α = 1 + μ/λ − μ/(4λ), I₁ = F:F, ψ₀ so that ψ(I) = 0
//!
//! Source: Smith, de Goes & Kim, *Stable Neo-Hookean flesh simulation*, ACM TOG 37(2), 2018: energy eq. 14 and the Lamé conversion after it.
//!
//! This is the version with ln(I₁ + 1). Without this term ∂²ψ/∂F² = μ𝕀 at F = 0, and a cell that is collapsed to a point is in a local minimum. With
//! it the Hessian vanishes there, F = 0 is a saddle of the cubic −λαJ, and ψ remains smooth for every F.
//!
//! The law's μ, λ are not Lamé's: μ = 4/3 μ_L and λ = λ_L + 5/6 μ_L make the tangent at F = I equal Hooke's. λ > 0 for every ν > −1.
//!
//! Limits: no barrier at J = 0, so that cells invert under sufficient load (and recover when it is removed). As ν → ½ the law is stiff in J but
//! bounds it only by the penalty ½λ(J − α)². In uniaxial tension the response at large stretch is neo-Hookean with 4/3 μ_L.

use super::assemble::{add_dyad, isotropic};
use super::entry::LawEntry;
use super::kinematics::{Invariants, x_minus_ln_1p};
use super::law::{Law, LawInfo};
use super::moduli;
use super::moduli::Moduli;
use super::response::{LawError, Response, Want};
use crate::math::tensor::{Mat3, rows};

pub static INFO: LawInfo = LawInfo {
    name: "stable_neo_hookean",
    title: "stable Neo-Hookean",
    formula: "ψ = ½μ(I₁ − 3) + ½λ(J − α)² − ½μ ln(I₁ + 1) − ψ₀, α = 1 + ¾μ/λ, μ = 4/3 μ_L, λ = λ_L + 5/6 μ_L",
    source: "Smith, de Goes & Kim 2018, eq. 14",
    limits: "no barrier at J = 0; stiffens from μ_L towards 4/3 μ_L with stretch",
    parameters: moduli::PAIR,
    optional: 0,
    choices: &[],
    survives_inversion: true,
    objective: true,
    isochoric: false,
};

/// The law in the registry.
pub const ENTRY: LawEntry = LawEntry::elastic(&INFO, |v, _| Ok(Box::new(StableNeoHookean::new(Moduli::from_map(v)?))));

/// Stable neo-Hookean law, built from Hooke's constants.
#[derive(Clone, Copy, Debug)]
pub struct StableNeoHookean {
    hooke: Moduli,
    mu: f64,
    lambda: f64,
}

impl StableNeoHookean {
    /// The law whose tangent at F = I has these constants.
    pub fn new(hooke: Moduli) -> Self {
        Self { hooke, mu: 4.0 / 3.0 * hooke.mu, lambda: hooke.lambda + 5.0 / 6.0 * hooke.mu }
    }
}

impl Law for StableNeoHookean {
    fn info(&self) -> &'static LawInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        vec![self.hooke.e, self.hooke.nu]
    }

    fn small_strain(&self) -> Moduli {
        self.hooke
    }

    /// ψ is linear in μ_L and λ_L: λ(J − α) = λ(J − 1) − ¾μ.
    fn along(&self, rates: &[f64]) -> Box<dyn Law> {
        Box::new(Self::new(self.hooke.along(rates)))
    }

    /// With C = cof F and λ(J − α) = λ(J − 1) − ¾μ: P = μ(1 − 1/(I₁ + 1))F + λ(J − α)C;
    /// A_iJkL = μ(1 − 1/(I₁ + 1)) δ_ik δ_JL + 2μ/(I₁ + 1)² F_iJ F_kL + λ C_iJ C_kL + λ(J − α) ε_ikm ε_JLn F_mn.
    fn eval(&self, f: &Mat3, want: Want) -> Result<Response, LawError> {
        let Self { mu, lambda, .. } = *self;
        let k = Invariants::of(f);
        let x = k.x;
        // ½(I₁ − 3) − ½ ln((I₁ + 1)/4) − ¾x = ⅜[I₁ − 3 − 2x] + ½[q − ln(1 + q)], q = (I₁ − 3)/4
        let mut r = Response::energy(mu * (0.375 * k.i_2x + 0.5 * x_minus_ln_1p(0.25 * k.i)) + 0.5 * lambda * x * x);
        if want >= Want::Residual {
            // 1 − 1/(I₁ + 1) = I₁/(I₁ + 1): exactly ¾ at F = I, so that P(I) = 0 exactly
            let i1 = k.i + 3.0;
            let c = mu * (i1 / (i1 + 1.0));
            let p = lambda * x - 0.75 * mu;
            r.p = f * c + k.cof * p;
            if want >= Want::Tangent {
                r.a = isotropic(c, lambda, 0.0, &rows(&k.cof));
                let row = rows(f);
                add_dyad(&mut r.a, 2.0 * mu / ((i1 + 1.0) * (i1 + 1.0)), &row, &row);
                add_cofactor_derivative(&mut r.a, p, f);
            }
        }
        Ok(r)
    }
}

/// a += p ∂(cof F)_iJ/∂F_kL = p ε_ikm ε_JLn F_mn.
#[inline(always)]
fn add_cofactor_derivative(a: &mut crate::math::tensor::Mat9, p: f64, f: &Mat3) {
    for (i, k, m) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
        for (j, l, n) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            let x = p * f[(m, n)];
            a[3 * i + j][3 * k + l] += x;
            a[3 * k + l][3 * i + j] += x;
            a[3 * i + l][3 * k + j] -= x;
            a[3 * k + j][3 * i + l] -= x;
        }
    }
}
