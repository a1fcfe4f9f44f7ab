//! Volumetric parts U(J) \[J/m³\] of split laws ψ = ψ_rest(F) + U(J); each has U(1) = U′(1) = 0 and U″(1) = κ.
//!
//! Sources: ½κ(J − 1)²: Bonet & Wood, *Nonlinear Continuum Mechanics for Finite Element Analysis*, 2nd ed. 2008, ch. 6.
//! ½κ(ln J)² and ¼κ(J² − 1 − 2 ln J): Simo & Taylor, *Quasi-incompressible finite elasticity in principal stretches*, CMAME 85, 1991;
//! Holzapfel, *Nonlinear Solid Mechanics*, 2000, ch. 6.

use super::kinematics::x_minus_ln_1p;
use super::parameter::{Choice, Chosen};
use super::response::LawError;

/// The form of U(J).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum VolumetricKind {
    /// U = ½κ(J − 1)²; finite at J = 0
    Quadratic,
    /// U = ½κ(ln J)²; softens in strong dilatation, concave beyond J = e
    Logarithmic,
    /// U = ¼κ(J² − 1 − 2 ln J); convex, infinite at J = 0 and at J → ∞
    SimoTaylor,
}

impl VolumetricKind {
    pub const ALL: [Self; 3] = [Self::Quadratic, Self::Logarithmic, Self::SimoTaylor];

    /// The chosen form.
    pub(crate) fn chosen(chosen: &Chosen) -> Self {
        let name = chosen[CHOICE.name];
        Self::ALL.into_iter().find(|k| k.name() == name).expect("the options of the choice are the names of the kinds")
    }

    /// U as a function of J.
    pub fn formula(self) -> &'static str {
        match self {
            Self::Quadratic => "½κ(J − 1)²",
            Self::Logarithmic => "½κ(ln J)²",
            Self::SimoTaylor => "¼κ(J² − 1 − 2 ln J)",
        }
    }

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Quadratic => "quadratic",
            Self::Logarithmic => "logarithmic",
            Self::SimoTaylor => "simo_taylor",
        }
    }
}

/// `volumetric = "…"` in files; the form is a physical choice, so that there is no default.
pub const CHOICE: Choice = Choice {
    name: "volumetric",
    options: &["quadratic", "logarithmic", "simo_taylor"],
    default: None,
    meaning: "U(J): ½κ(J − 1)², ½κ(ln J)² or ¼κ(J² − 1 − 2 ln J)",
    formulas: &[],
};

/// The choices of a law without further ones.
pub const CHOICES: &[Choice] = &[CHOICE];

/// U(J) with its bulk modulus.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Volumetric {
    pub kind: VolumetricKind,
    /// Bulk modulus κ = U″(1) \[Pa\]
    pub kappa: f64,
}

impl Volumetric {
    /// U \[J/m³\] at J > 0 \[–\].
    pub fn u(&self, j: f64) -> f64 {
        self.at(j - 1.0).0
    }

    /// U′ = dU/dJ \[Pa\] at J > 0 \[–\]: the pressure, positive in tension.
    pub fn du(&self, j: f64) -> f64 {
        self.at(j - 1.0).1
    }

    /// U″ \[Pa\] at J > 0 \[–\].
    pub fn d2u(&self, j: f64) -> f64 {
        self.at(j - 1.0).2
    }

    /// U, U′ and U″ at x = J − 1 > −1 \[–\], which keeps the digits that are lost in J near 1.
    #[inline(always)]
    pub fn at(&self, x: f64) -> (f64, f64, f64) {
        let (kappa, j) = (self.kappa, 1.0 + x);
        match self.kind {
            VolumetricKind::Quadratic => (0.5 * kappa * x * x, kappa * x, kappa),
            VolumetricKind::Logarithmic => {
                let ln = x.ln_1p();
                (0.5 * kappa * ln * ln, kappa * ln / j, kappa * (1.0 - ln) / (j * j))
            }
            // J² − 1 − 2 ln J = x² + 2[x − ln(1 + x)]; J − 1/J = x(J + 1)/J
            VolumetricKind::SimoTaylor => (
                0.25 * kappa * (x * x + 2.0 * x_minus_ln_1p(x)),
                0.5 * kappa * x * (j + 1.0) / j,
                0.5 * kappa * (1.0 + 1.0 / (j * j)),
            ),
        }
    }

    /// G, G′ and G″ \[–\] at x = J − 1 \[–\], where U = ½κG² with G = x + O(x²): the measure of volume change in the perturbed Lagrangian p G −
    /// p²/2κ, with pressure p = κG and U′ = pG′. The quadratic form is defined for every J, the others for J > 0.
    pub fn gap(&self, x: f64) -> Result<(f64, f64, f64), LawError> {
        let j = 1.0 + x;
        match self.kind {
            VolumetricKind::Quadratic => Ok((x, 1.0, 0.0)),
            _ if j.is_nan() || j <= 0.0 => Err(LawError::Inverted { j }),
            VolumetricKind::Logarithmic => Ok((x.ln_1p(), 1.0 / j, -1.0 / (j * j))),
            // With r = [x − ln(1 + x) − ½x²]/x³ and g² = 1 + xr: G = xg; G G′ = U′/κ and (G G′)′ = U″/κ, with the common factors cancelled
            // analytically.
            VolumetricKind::SimoTaylor => {
                let r = if x.abs() < 0.2 {
                    (3..28).rev().fold(0.0, |s, n| -s * x - 1.0 / f64::from(n))
                } else {
                    (x - x.ln_1p() - 0.5 * x * x) / (x * x * x)
                };
                let g = (1.0 + x * r).sqrt();
                let second = (0.5 * x + (2.0 + 2.0 * x + x * x) * r) / (2.0 * j * j * g * g * g);
                Ok((x * g, 0.5 * (j + 1.0) / (j * g), second))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// U(1) = U′(1) = 0, U″(1) = κ exactly; the derivatives agree with central differences, h = 1e-4 J: truncation h²U‴/6 ≈ 1e-8 U‴.
    #[test]
    fn derivatives() {
        for kind in VolumetricKind::ALL {
            let v = Volumetric { kind, kappa: 2.0 };
            assert_eq!(v.at(0.0), (0.0, 0.0, 2.0), "{kind:?}");
            for j in [0.1_f64, 0.7, 0.999, 1.001, 1.4, 5.0] {
                let h = 1e-4 * j;
                let first = (v.u(j + h) - v.u(j - h)) / (2.0 * h);
                let second = (v.du(j + h) - v.du(j - h)) / (2.0 * h);
                let size = v.kappa * (1.0 + j.powi(-4));
                assert!((v.du(j) - first).abs() < 1e-7 * size, "{kind:?} U′({j}) = {}, not {first}", v.du(j));
                assert!((v.d2u(j) - second).abs() < 1e-7 * size, "{kind:?} U″({j}) = {}, not {second}", v.d2u(j));
            }
        }
    }

    /// U = ½κG², U′ = κGG′, U″ = κ(G′² + GG″), on both sides of the switch to the series and at x = 0.
    #[test]
    fn gap_is_the_root_of_the_energy() {
        for kind in VolumetricKind::ALL {
            let v = Volumetric { kind, kappa: 3.0 };
            for x in [-0.9, -0.2000001, -0.1999999, -1e-3, -1e-9, 0.0, 1e-12, 1e-4, 0.1999999, 0.2000001, 1.0, 6.0] {
                let (u, du, d2u) = v.at(x);
                let (g, dg, d2g) = v.gap(x).expect("J > 0");
                let near = |a: f64, b: f64| (a - b).abs() <= 2e-14 * b.abs();
                assert!(near(1.5 * g * g, u) && near(3.0 * g * dg, du), "{kind:?} at {x}: G = {g}, G′ = {dg}");
                let size = 3.0 * (dg * dg + (g * d2g).abs());
                assert!((3.0 * (dg * dg + g * d2g) - d2u).abs() <= 1e-14 * size, "{kind:?} at {x}: G″ = {d2g}");
            }
            assert_eq!(v.gap(-1.5).is_ok(), kind == VolumetricKind::Quadratic, "{kind:?} at J < 0");
        }
    }

    /// G″ of the Simo–Taylor form agrees with the central difference of G′ with h = 1e-3, also at x = 0, where (G′² + GG″) does not contain it.
    #[test]
    fn second_derivative_of_the_gap() {
        let v = Volumetric { kind: VolumetricKind::SimoTaylor, kappa: 1.0 };
        for x in [-0.5, 0.0, 0.1, 2.0] {
            let h = 1e-4;
            let d = |h: f64| v.gap(x + h).expect("J > 0").1;
            let (difference, exact) = ((d(h) - d(-h)) / (2.0 * h), v.gap(x).expect("J > 0").2);
            assert!((difference - exact).abs() < 1e-6, "{exact}, difference {difference} at {x}");
        }
    }

    /// U = ½κx² + O(x³) keeps its digits at x = 1e-9.
    #[test]
    fn digits_near_one() {
        for kind in VolumetricKind::ALL {
            let v = Volumetric { kind, kappa: 1.0 };
            let x = 1e-9;
            let cubic = match kind {
                VolumetricKind::Quadratic => 0.0,
                VolumetricKind::Logarithmic => -0.5 * x * x * x,
                VolumetricKind::SimoTaylor => -x * x * x / 6.0,
            };
            let expected = 0.5 * x * x + cubic;
            assert!((v.at(x).0 / expected - 1.0).abs() < 1e-15, "{kind:?}");
        }
    }
}
