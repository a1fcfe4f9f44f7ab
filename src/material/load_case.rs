//! Homogeneous load cases of isotropic laws: nominal stress against stretch.
//!
//! Compressible laws: the free lateral stretch is solved from zero lateral stress. Incompressible limit of a law ψ_rest + U(J): J = 1, and the
//! undetermined pressure follows from the free face, P = P₁₁ − (a/λ)P₃₃ of ψ_rest. For the neo-Hookean law this is P/μ = λ − λ⁻² (uniaxial), λ − λ⁻⁵
//! (equibiaxial), λ − λ⁻³ (planar), γ (simple shear). Source: Treloar, *The Physics of Rubber Elasticity*, 3rd ed. 1975, ch. 5.

use super::law::Law;
use super::response::{LawError, Response, Want};
use crate::math::tensor::Mat3;

/// A homogeneous deformation; its amount is the stretch λ \[–\], or in simple shear the shear γ \[–\].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum LoadCase {
    /// F = diag(λ, a, a), P₂₂ = P₃₃ = 0
    Uniaxial,
    /// F = diag(λ, λ, a), P₃₃ = 0
    Equibiaxial,
    /// F = diag(λ, 1, a), P₃₃ = 0; also called pure shear
    Planar,
    /// F = I + γ e₁ ⊗ e₂; no face is free
    SimpleShear,
}

/// State of a homogeneously deformed block.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Homogeneous {
    pub f: Mat3,
    /// Lateral stretch a \[–\]; 1 in simple shear
    pub lateral: f64,
    /// Nominal stress \[Pa\]: P₁₁, in simple shear P₁₂
    pub stress: f64,
    /// dstress/d(amount) along the equilibrium path \[Pa\]
    pub stiffness: f64,
}

/// The reason why a load case has no equilibrium state.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
pub enum LoadCaseError {
    #[error("{case:?} at {amount}: a stretch is a positive finite number (1 = undeformed, not the strain)")]
    NotAStretch { case: LoadCase, amount: f64 },
    #[error(
        "law `{law}` has no positive lateral stretch free of stress at {case:?} {amount}; it is beyond the range of the law ({limits})"
    )]
    NoLateralEquilibrium { law: &'static str, limits: &'static str, case: LoadCase, amount: f64 },
    #[error(
        "law `{law}` has no volumetric part of its own, so that it has no incompressible limit; take a law with a split such as neo_hookean"
    )]
    NoSplit { law: &'static str },
    #[error(transparent)]
    Law(#[from] LawError),
}

impl LoadCase {
    pub const ALL: [Self; 4] = [Self::Uniaxial, Self::Equibiaxial, Self::Planar, Self::SimpleShear];

    /// F at this amount \[–\] and lateral stretch a \[–\].
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

    /// Lateral stretch \[–\] of an incompressible material.
    fn isochoric(self, amount: f64) -> f64 {
        match self {
            Self::Uniaxial => amount.powf(-0.5),
            Self::Equibiaxial => amount.powi(-2),
            Self::Planar => 1.0 / amount,
            Self::SimpleShear => 1.0,
        }
    }

    /// The diagonal entries of F, as rows of A, that follow the amount, and those that follow a.
    fn moving(self) -> (&'static [usize], &'static [usize]) {
        match self {
            Self::Uniaxial => (&[0], &[4, 8]),
            Self::Equibiaxial => (&[0, 4], &[8]),
            Self::Planar => (&[0], &[8]),
            Self::SimpleShear => (&[1], &[]),
        }
    }

    /// Nominal stress of an incompressible neo-Hookean material with shear modulus `mu` \[Pa\].
    pub fn incompressible_neo_hookean(self, mu: f64, amount: f64) -> f64 {
        mu * match self {
            Self::Uniaxial => amount - amount.powi(-2),
            Self::Equibiaxial => amount - amount.powi(-5),
            Self::Planar => amount - amount.powi(-3),
            Self::SimpleShear => amount,
        }
    }

    /// Nominal stress \[Pa\] of the incompressible limit of a law with a split, at this stretch λ (or shear γ) \[–\].
    pub fn incompressible(self, law: &dyn Law, amount: f64) -> Result<f64, LoadCaseError> {
        if !amount.is_finite() || (self != Self::SimpleShear && amount <= 0.0) {
            return Err(LoadCaseError::NotAStretch { case: self, amount });
        }
        let (rest, _) = law.split().ok_or(LoadCaseError::NoSplit { law: law.info().name })?;
        let a = self.isochoric(amount);
        let p = rest.eval(&self.gradient(amount, a), Want::Residual)?.p;
        // The pressure does no work in simple shear
        Ok(if self == Self::SimpleShear { p[(0, 1)] } else { p[(0, 0)] - p[(2, 2)] * a / amount })
    }

    /// F of an isotropic law at this stretch λ (or shear γ) \[–\] with free lateral faces, and its lateral stretch.
    pub(super) fn deformed(self, law: &dyn Law, amount: f64) -> Result<(Mat3, f64), LoadCaseError> {
        if !amount.is_finite() || (self != Self::SimpleShear && amount <= 0.0) {
            return Err(LoadCaseError::NotAStretch { case: self, amount });
        }
        let a = if self == Self::SimpleShear { 1.0 } else { self.lateral(law, amount)? };
        Ok((self.gradient(amount, a), a))
    }

    /// State of an isotropic law at this stretch λ (or shear γ) \[–\], with free lateral faces.
    pub fn state(self, law: &dyn Law, amount: f64) -> Result<Homogeneous, LoadCaseError> {
        let (f, a) = self.deformed(law, amount)?;
        let r = law.eval(&f, Want::Tangent)?;
        let (driven, free) = self.moving();
        let sum = |row: usize, columns: &[usize]| columns.iter().map(|c| r.a[row][*c]).sum::<f64>();
        let mut stiffness = sum(driven[0], driven);
        if let Some(&side) = free.first() {
            // Along P_side = 0: da/d(amount) = −(∂P_side/∂amount)/(∂P_side/∂a)
            stiffness -= sum(driven[0], free) * sum(side, driven) / sum(side, free);
        }
        let stress = if self == Self::SimpleShear { r.p[(0, 1)] } else { r.p[(0, 0)] };
        Ok(Homogeneous { f, lateral: a, stress, stiffness })
    }

    /// Lateral stretch a \[–\] with P_side(a) = 0 to rounding: Newton's method inside a bracket, starting from the end nearer to the isochoric
    /// stretch, which is close to the solution of a nearly incompressible law; bisection if a step would leave the bracket.
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
        // Bracket: the side is pulled inwards below the solution and pushed outwards above it. Small steps stay on the branch that begins at F = I.
        let mut a = self.isochoric(amount);
        let mut at = side(a)?;
        let step = if at.0 < 0.0 { 1.1 } else { 1.0 / 1.1 };
        let mut far = a * step;
        let mut steps = 0..400;
        loop {
            let there = side(far)?;
            if at.0 * there.0 <= 0.0 {
                break;
            }
            steps.next().ok_or_else(none)?;
            (a, at, far) = (far, there, far * step);
        }
        let (mut lo, mut hi) = (a.min(far), a.max(far));
        for _ in 0..200 {
            let (p, stiffness) = at;
            if p < 0.0 {
                lo = a;
            } else {
                hi = a;
            }
            let newton = a - p / stiffness;
            let next = if lo < newton && newton < hi { newton } else { 0.5 * (lo + hi) };
            // Two ulp: the next step would only be rounding
            if (newton - a).abs() <= 2.0 * f64::EPSILON * a || p == 0.0 || next == a {
                return Ok(a);
            }
            a = next;
            at = side(a)?;
        }
        Ok(a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::law::LawInfo;
    use crate::material::{LAWS, Moduli, neo_hookean::NeoHookean, stable_neo_hookean::StableNeoHookean};
    use std::sync::atomic::{AtomicU32, Ordering};

    fn neo_hookean(nu: f64) -> (NeoHookean, Moduli) {
        let m = Moduli::from_e_nu(100e3, nu).expect("within bounds");
        (NeoHookean(m), m)
    }

    /// Uniaxial neo-Hookean solution by scalar bisection in ln a, without the law: P₂₂ = 0 ⇔ μ(a² − 1) + λ_L ln(λ a²) = 0, which increases with a;
    /// then P₁₁/μ = λ − 1/λ + (λ_L/μ) ln(λ a²)/λ.
    fn independent(m: &Moduli, stretch: f64) -> (f64, f64) {
        let ratio = m.lambda / m.mu;
        let (mut lo, mut hi) = (-5.0_f64, 5.0_f64);
        for _ in 0..200 {
            let mid = 0.5 * (lo + hi);
            let side = (2.0 * mid).exp_m1() + ratio * (stretch.ln() + 2.0 * mid);
            if side < 0.0 { lo = mid } else { hi = mid }
        }
        let ln_a = 0.5 * (lo + hi);
        (stretch - 1.0 / stretch + ratio * (stretch.ln() + 2.0 * ln_a) / stretch, ln_a.exp())
    }

    /// A law that counts its evaluations.
    #[derive(Debug)]
    struct Counted(NeoHookean, AtomicU32);

    impl Law for Counted {
        fn info(&self) -> &'static LawInfo {
            self.0.info()
        }

        fn values(&self) -> Vec<f64> {
            self.0.values()
        }

        fn small_strain(&self) -> Moduli {
            self.0.small_strain()
        }

        fn eval(&self, f: &Mat3, want: Want) -> Result<Response, LawError> {
            self.1.fetch_add(1, Ordering::Relaxed);
            self.0.eval(f, want)
        }

        fn along(&self, rates: &[f64]) -> Box<dyn Law> {
            self.0.along(rates)
        }
    }

    /// Two evaluations for the bracket and two or three for Newton's method: a scan over stretches evaluates nearly incompressible laws several
    /// thousand times.
    #[test]
    fn a_nearly_incompressible_law_is_evaluated_five_times() {
        let law = Counted(neo_hookean(0.49999).0, AtomicU32::new(0));
        for (case, amount) in [LoadCase::Uniaxial, LoadCase::Equibiaxial, LoadCase::Planar]
            .into_iter()
            .flat_map(|case| [0.4, 0.9, 1.1, 3.0].map(|amount| (case, amount)))
        {
            law.1.store(0, Ordering::Relaxed);
            assert!(case.deformed(&law, amount).is_ok());
            let count = law.1.load(Ordering::Relaxed);
            assert!(count <= 5, "{case:?} {amount}: {count} evaluations");
        }
    }

    /// Case 1 of the reference values: (ν, λ, P/μ, a), printed to seven digits.
    #[test]
    fn uniaxial_neo_hookean_block() {
        for (nu, stretch, stress, lateral) in [
            (0.45, 2.0, 1.736509, 0.725935),
            (0.45, 0.5, -3.149698, 1.35087),
            (0.499, 2.0, 1.749750, 0.707461),
            (0.499, 0.5, -3.492024, 1.412803),
        ] {
            let (law, m) = neo_hookean(nu);
            let got = LoadCase::Uniaxial.state(&law, stretch).expect("ln J laws have a lateral equilibrium");
            let (p, a) = independent(&m, stretch);
            assert!((p - stress).abs() < 0.6e-6 && (a - lateral).abs() < 0.6e-5, "printed digits: {p}, {a}");
            // ln J to one ulp, times λ_L/μ ≤ 500: 1e-13 of P
            assert!((got.stress / m.mu / p - 1.0).abs() < 1e-12, "P/μ = {}, not {p}", got.stress / m.mu);
            assert!((got.lateral / a - 1.0).abs() < 1e-14, "a = {}, not {a}", got.lateral);
        }
    }

    /// As ν → ½ the compressible stress tends to the closed form with an error of first order in 1 − 2ν.
    #[test]
    fn incompressible_limit() {
        for case in LoadCase::ALL {
            for amount in [0.4, 0.8, 1.5, 3.0] {
                let limit = case.incompressible_neo_hookean(1.0, amount);
                let error = |nu: f64| {
                    let (law, m) = neo_hookean(nu);
                    (case.state(&law, amount).expect("in range").stress / m.mu - limit).abs()
                };
                let (coarse, fine) = (error(0.49999), error(0.499_999));
                let order = coarse / fine;
                assert!(fine < 1e-12 || (order - 10.0).abs() < 0.1, "{case:?} {amount}: {coarse} → {fine}");
                assert!(fine < 1e-3 * limit.abs().max(1.0), "{case:?} {amount}: off by {fine}");
            }
        }
    }

    /// For every law with a split the compressible stress tends to the incompressible one with an error of first order in 1/κ, so that ten times κ
    /// leaves a tenth of the difference; for the neo-Hookean law the limit is the closed form.
    #[test]
    fn incompressible_limit_of_every_split_law() {
        for entry in LAWS {
            let law = entry.example().expect("the example of a law");
            let name = entry.info.name;
            if law.split().is_none() {
                assert!(LoadCase::Planar.incompressible(law.as_ref(), 1.1).is_err(), "{name}");
                continue;
            }
            let options = law.choices();
            let stiff = |kappa: f64| {
                let m = law.small_strain();
                let pair = Moduli::from_pair(("mu", m.mu), ("kappa", kappa)).expect("stiff");
                let own = [vec![kappa], law.values()[1..].to_vec()].concat();
                let values = if entry.keys.iter().any(|k| k.name == "E") { vec![pair.e, pair.nu] } else { own };
                entry.build_with(&values, &options).unwrap_or_else(|e| panic!("{name}: {e}"))
            };
            let (near, nearer) = (stiff(1e9), stiff(1e10));
            for case in LoadCase::ALL {
                for amount in [0.7, 1.2, 1.8] {
                    let limit = case.incompressible(nearer.as_ref(), amount).expect("a split law");
                    let off = |law: &dyn Law| (case.state(law, amount).expect("in range").stress - limit).abs();
                    let (coarse, fine) = (off(near.as_ref()), off(nearer.as_ref()));
                    // κ/μ = 3e5; the pressure is a few μ, with Ogden's α = −4 up to 30 μ: 1e-4 of the volume, times the stiffness. The second order
                    // is the same share of the first; at ten times the change of volume it is 1 % of it: 0.1 of the ratio
                    assert!(fine < 1e-3 * limit.abs(), "{name} {case:?} {amount}: off by {fine}");
                    assert!(
                        fine < 1e-9 * limit.abs() || (coarse / fine - 10.0).abs() < 0.5,
                        "{name} {case:?}: {coarse} {fine}"
                    );
                    if name == "neo_hookean" {
                        let closed = case.incompressible_neo_hookean(law.small_strain().mu, amount);
                        assert!((limit / closed - 1.0).abs() < 1e-12, "{case:?} {amount}: {limit} not {closed}");
                    }
                }
            }
        }
    }

    /// For every law and case the free face is stress-free, the stiffness is the derivative of the stress (central difference, h = 1e-4: h² P‴/6 and
    /// ε P/h both below 1e-7 of the stiffness here), and the state at 1 is undeformed.
    #[test]
    fn every_law_and_case() {
        for entry in LAWS {
            let law = entry.example().expect("the example of a law");
            let stiffness = law.small_strain().kappa;
            for case in LoadCase::ALL {
                let label = format!("{} {case:?}", entry.info.name);
                for amount in [0.8, 0.95, 1.0, 1.1, 1.3] {
                    let at = |x: f64| case.state(law.as_ref(), x).unwrap_or_else(|e| panic!("{label}: {e}"));
                    let s = at(amount);
                    let p = law.eval(&s.f, Want::Residual).expect("just evaluated").p;
                    if case != LoadCase::SimpleShear {
                        assert!(p[(2, 2)].abs() < 1e-13 * stiffness, "{label} {amount}: P₃₃ = {}", p[(2, 2)]);
                        if amount == 1.0 {
                            assert!((s.lateral - 1.0).abs() < 1e-14 && s.stress.abs() < 1e-13 * stiffness, "{label}");
                        }
                    }
                    let h = 1e-4;
                    let difference = (at(amount + h).stress - at(amount - h).stress) / (2.0 * h);
                    assert!(
                        (s.stiffness - difference).abs() < 1e-6 * stiffness,
                        "{label} {amount}: {} not {difference}",
                        s.stiffness
                    );
                }
            }
        }
    }

    /// Smith et al.'s law at ν → ½: J = 1 and P₁₁ = μ(1 − 1/(I₁ + 1))(λ − λ⁻²) with μ = 4/3 μ_L.
    #[test]
    fn stable_neo_hookean_limit() {
        let m = Moduli::from_e_nu(100e3, 0.499_999).expect("within bounds");
        let law = StableNeoHookean::new(m);
        for stretch in [0.5_f64, 2.0, 3.0] {
            let i1 = stretch * stretch + 2.0 / stretch;
            let limit = 4.0 / 3.0 * m.mu * (1.0 - 1.0 / (i1 + 1.0)) * (stretch - stretch.powi(-2));
            let got = LoadCase::Uniaxial.state(&law, stretch).expect("in range").stress;
            // error of order 1 − 2ν = 2e-6
            assert!((got / limit - 1.0).abs() < 2e-5, "λ = {stretch}: {got}, limit {limit}");
        }
    }

    #[test]
    fn refuses_with_a_reason() {
        let (law, m) = neo_hookean(0.45);
        let message = |e: Result<Homogeneous, LoadCaseError>| e.expect_err("must be refused").to_string();
        assert!(message(LoadCase::Uniaxial.state(&law, 0.0)).contains("positive"));
        assert!(message(LoadCase::Planar.state(&law, f64::NAN)).contains("positive"));
        let stvk = crate::material::st_venant_kirchhoff::StVenantKirchhoff(m);
        // a² = 1 − ν(λ² − 1) < 0
        let beyond = message(LoadCase::Uniaxial.state(&stvk, 2.0));
        assert!(beyond.contains("st_venant_kirchhoff") && beyond.contains("range"), "{beyond}");
    }
}
