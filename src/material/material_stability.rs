//! Drucker's stability along a homogeneous load case: every small change of the stretches does positive work.
//!
//! With τᵢ = λᵢ ∂ψ/∂λᵢ and eᵢ = ln λᵢ: Σᵢⱼ (∂τᵢ/∂eⱼ) deᵢ deⱼ > 0 for every de ≠ 0. For κ → ∞ this is the incompressible criterion, in
//! which Σ de = 0. Simple shear by γ has the principal stretches λ, 1, 1/λ with λ − 1/λ = γ.
//!
//! Source: Drucker 1959; for rubber as in Ogden, *Non-linear Elastic Deformations*, 1984, ch. 6 (Hill's inequality in ln λ).

use super::law::Law;
use super::load_case::{LoadCase, LoadCaseError};
use super::response::{LawError, Want};
use crate::math::tensor::{Mat3, Vec3};

/// The reason why a law is not used beyond an amount.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
pub enum Instability {
    /// There is a change of the stretches that does no positive work
    #[error("the incremental stiffness is no longer positive definite")]
    Drucker,
    /// No positive lateral stretch is stress-free
    #[error("no lateral stretch is free of stress")]
    NoEquilibrium,
    #[error(transparent)]
    Law(LawError),
}

/// End of the stable range.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct StabilityLimit {
    /// Stretch λ \[–\], in simple shear γ \[–\], to within 1e-9 of the distance to the last stable one
    pub amount: f64,
    pub why: Instability,
}

/// Ends of the stable range around the undeformed state; `None`: stable up to the end of the requested range.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct MaterialStability {
    /// Limit below the undeformed state
    pub below: Option<StabilityLimit>,
    /// Limit above the undeformed state
    pub above: Option<StabilityLimit>,
}

impl MaterialStability {
    pub fn holds(&self) -> bool {
        self.below.is_none() && self.above.is_none()
    }
}

/// Number of intervals of a scan in one direction; an unstable interval narrower than one of them may be missed.
const STEPS: u32 = 200;

/// First amounts, on both sides of the undeformed state, at which the law loses stability inside `range` \[–\].
pub fn material_stability(law: &dyn Law, case: LoadCase, range: [f64; 2]) -> Result<MaterialStability, LoadCaseError> {
    let rest = if case == LoadCase::SimpleShear { 0.0 } else { 1.0 };
    for amount in range {
        if !amount.is_finite() || (case != LoadCase::SimpleShear && amount <= 0.0) {
            return Err(LoadCaseError::NotAStretch { case, amount });
        }
    }
    Ok(MaterialStability {
        below: first(law, case, rest, range[0].min(rest)),
        above: first(law, case, rest, range[1].max(rest)),
    })
}

/// The first unstable amount between `rest` and `end`, by a scan with equal steps in ln λ (in γ) and bisection.
fn first(law: &dyn Law, case: LoadCase, rest: f64, end: f64) -> Option<StabilityLimit> {
    let at = |t: f64| if case == LoadCase::SimpleShear { end * t } else { end.powf(t) };
    if let Err(why) = check(law, case, rest) {
        return Some(StabilityLimit { amount: rest, why });
    }
    let (mut stable, mut step) = (0.0, None);
    for n in 1..=STEPS {
        let t = f64::from(n) / f64::from(STEPS);
        if let Err(why) = check(law, case, at(t)) {
            step = Some((t, why));
            break;
        }
        stable = t;
    }
    let (mut unstable, mut why) = step?;
    for _ in 0..30 {
        let t = 0.5 * (stable + unstable);
        match check(law, case, at(t)) {
            Ok(()) => stable = t,
            Err(reason) => (unstable, why) = (t, reason),
        }
    }
    Some(StabilityLimit { amount: at(unstable), why })
}

/// Whether the law is stable at this amount.
fn check(law: &dyn Law, case: LoadCase, amount: f64) -> Result<(), Instability> {
    let stretches = if case == LoadCase::SimpleShear {
        let s = (0.5 * amount).asinh().exp();
        Vec3::new(s, 1.0, 1.0 / s)
    } else {
        match case.deformed(law, amount) {
            Ok((f, _)) => f.diagonal(),
            Err(LoadCaseError::Law(e)) => return Err(Instability::Law(e)),
            Err(_) => return Err(Instability::NoEquilibrium),
        }
    };
    let r = law.eval(&Mat3::from_diagonal(&stretches), Want::Tangent).map_err(Instability::Law)?;
    let d = Mat3::from_fn(|i, j| {
        let own = if i == j { stretches[i] * r.p[(i, i)] } else { 0.0 };
        stretches[i] * stretches[j] * r.a[4 * i][4 * j] + own
    });
    // Positive definite ⇔ the Cholesky factor exists.
    if nalgebra::Cholesky::new(d).is_some() { Ok(()) } else { Err(Instability::Drucker) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{LAWS, registry};

    fn build(name: &str, values: &[f64]) -> Box<dyn Law> {
        let entry = registry::find(name).expect("registered");
        entry.build_with(values, &["quadratic"]).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Incompressible Yeoh law, uniaxial: in the mode of further stretching, dτ/de ∝ W₁(2λ² + 1/λ) + 2W₁₁(λ² − 1/λ)²; the mode that makes the section
    /// oval remains stable longer, as long as W₁ > 0. κ/μ = 1e5 shifts the loss by about 1e-5.
    #[test]
    fn yeoh_with_negative_second_term() {
        let (c10, c20) = (20e3, -1e3);
        let law = build("yeoh", &[4e9, c10, c20]);
        let stiffness = |l: f64| {
            let i = l * l + 2.0 / l - 3.0;
            (c10 + 2.0 * c20 * i) * (2.0 * l * l + 1.0 / l) + 4.0 * c20 * (l * l - 1.0 / l).powi(2)
        };
        let (mut lo, mut hi) = (1.0, 4.0);
        for _ in 0..100 {
            let mid = 0.5 * (lo + hi);
            if stiffness(mid) > 0.0 { lo = mid } else { hi = mid }
        }
        let got = material_stability(law.as_ref(), LoadCase::Uniaxial, [0.8, 4.0]).expect("a range of stretches");
        let above = got.above.expect("C20 < 0 ends somewhere");
        assert_eq!((got.below, above.why), (None, Instability::Drucker));
        assert!((above.amount / lo - 1.0).abs() < 1e-4, "{} not {lo}", above.amount);
    }

    /// Neo-Hookean and Mooney–Rivlin laws with positive terms are stable in every mode; the direction in which the range is given does not matter.
    #[test]
    fn stable_laws_are() {
        for law in [build("yeoh", &[4e7, 20e3]), build("mooney_rivlin", &[4e7, 15e3, 5e3])] {
            for case in LoadCase::ALL {
                let got = material_stability(law.as_ref(), case, [0.3, 4.0]).expect("a range");
                assert!(got.holds(), "{} {case:?}: {got:?}", law.info().name);
            }
        }
    }

    /// Incompressible Mooney–Rivlin law with C01 = −C10/10. In equibiaxial tension τ ∝ (λ² − λ⁻⁴)(C10 + C01λ²) has its maximum at the loss. Uniaxial
    /// tension remains stable further: there the section becomes oval, at C10 + C01λ² = 0.
    #[test]
    fn the_mode_matters() {
        let law = build("mooney_rivlin", &[4e9, 20e3, -2e3]);
        let at =
            |case| material_stability(law.as_ref(), case, [1.0, 4.0]).expect("a range").above.expect("lost").amount;
        assert!((at(LoadCase::Uniaxial) / 10.0_f64.sqrt() - 1.0).abs() < 1e-3, "{}", at(LoadCase::Uniaxial));
        let l = at(LoadCase::Equibiaxial);
        let tau = |l: f64| (l * l - l.powi(-4)) * (20e3 - 2e3 * l * l);
        assert!(tau(l) > tau(l * 1.01) && tau(l) > tau(l / 1.01) && (l - 2.2).abs() < 0.1, "{l}");
    }

    /// Gent's law ends at λ² + 2/λ = 3 + J_m with the error of the law.
    #[test]
    fn locking_is_an_end() {
        let law = build("gent", &[3e9, 30e3, 2.0]);
        let limit =
            material_stability(law.as_ref(), LoadCase::Uniaxial, [0.9, 3.0]).expect("a range").above.expect("it locks");
        assert!(matches!(limit.why, Instability::Law(LawError::Locked { .. })), "{limit:?}");
        assert!((limit.amount - 2.0).abs() < 1e-3, "{limit:?}");
    }

    #[test]
    fn every_law_is_stable_at_rest_and_ranges_are_checked() {
        for entry in LAWS {
            let law = entry.example().expect("the example of a law");
            for case in LoadCase::ALL {
                let small = if case == LoadCase::SimpleShear { [-0.01, 0.01] } else { [0.99, 1.01] };
                assert!(
                    material_stability(law.as_ref(), case, small).expect("a range").holds(),
                    "{} {case:?}",
                    law.info().name
                );
            }
        }
        let law = LAWS[0].example().expect("the example of a law");
        assert!(material_stability(law.as_ref(), LoadCase::Uniaxial, [0.0, 2.0]).is_err());
        assert!(material_stability(law.as_ref(), LoadCase::Uniaxial, [0.5, f64::NAN]).is_err());
    }
}
