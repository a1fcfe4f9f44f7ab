//! Volumetric parts U(J) [J/m³] of split laws ψ = ψ_iso(F) + U(J); each has U(1) = U′(1) = 0 and U″(1) = κ.
//!
//! Sources: ½κ(J − 1)²: Bonet & Wood, *Nonlinear Continuum Mechanics for Finite Element Analysis*, 2nd ed. 2008, ch. 6.
//! ½κ(ln J)² and ¼κ(J² − 1 − 2 ln J): Simo & Taylor, *Quasi-incompressible finite elasticity in principal stretches*, CMAME 85, 1991;
//! Holzapfel, *Nonlinear Solid Mechanics*, 2000, ch. 6.

use super::kinematics::x_minus_ln_1p;

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

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Quadratic => "quadratic",
            Self::Logarithmic => "logarithmic",
            Self::SimoTaylor => "simo_taylor",
        }
    }
}

/// U(J) with its bulk modulus.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Volumetric {
    pub kind: VolumetricKind,
    /// Bulk modulus κ = U″(1) [Pa]
    pub kappa: f64,
}

impl Volumetric {
    /// U [J/m³] at J > 0 [–].
    pub fn u(&self, j: f64) -> f64 {
        self.at(j - 1.0).0
    }

    /// U′ = dU/dJ [Pa] at J > 0 [–]: the pressure, positive in tension.
    pub fn du(&self, j: f64) -> f64 {
        self.at(j - 1.0).1
    }

    /// U″ [Pa] at J > 0 [–].
    pub fn d2u(&self, j: f64) -> f64 {
        self.at(j - 1.0).2
    }

    /// U, U′ and U″ at x = J − 1 > −1 [–], which keeps the digits that J near 1 has lost.
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
}

#[cfg(test)]
mod tests {
    use super::*;

    /// U(1) = U′(1) = 0, U″(1) = κ to the last bit; the derivatives against central differences, h = 1e-4 J: truncation h²U‴/6 ≈ 1e-8 U‴.
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
