//! Numerical checks of the properties that every law must have.
//!
//! [`check_law`] takes the declaration of a law, draws constants inside their bounds and deformation gradients, and compares energy, stress and
//! tangent with each other. The laws of the library pass it in the tests; a law defined elsewhere is checked in the same way.
//!
//! Finite differences. D(h) = (g(h) − g(−h))/2h = g′ + c₂h² + c₄h⁴ + c₆h⁶ + …; from h, h/2, h/4 Richardson's D₆ = (64 D(h/4) − 20 D(h/2) + D(h))/45
//! leaves the term c₆h⁶/64. A law is analytic in a ball of radius ρ around F (to the nearest J = 0 or s₂ + s₃ = 0), so |c₆| ≤ M/ρ⁷ by Cauchy's
//! estimate, with M the size of g there. With h = ρ/50: truncation ≤ (1/50)⁶/64 · M/ρ ≈ 1e-12 M/ρ. Rounding: each g carries k ulp of M, and the
//! weights give (64·4 + 20·2 + 1)/45 ≈ 6.6 of them over h: 330 k ε M/ρ ≈ 7e-14 k M/ρ. The bound used is 1e-10 M/ρ: k up to 1000, which is the
//! condition of invariants for stretches in [0.3, 3] and κ/μ ≤ 500 (ln J costs κ/μ ulp of μ, part of M). M is taken as the largest |g| on the stencil
//! plus ρ|g′|.

// A[3i+J][3k+L] is read by its indices, as in the formulae.
#![allow(clippy::needless_range_loop)]

use super::draws::{self, gradient, gradient_within, rotation};
use super::entry::LawEntry;
use super::law::Law;
use super::moduli::Moduli;
use super::parameter::Parameter;
use super::registry::given_as;
use super::response::{LaneResponse, LawError, Response, Want};
use crate::math::lanes::{LANES, Lanes};
use crate::math::random::SplitMix;
use crate::math::tensor::{Mat3, Vec3};
use crate::math::units::{Dimension, shown};

/// A property of a law that [`check_property`] verifies.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum LawProperty {
    /// The description is complete, and the example lies inside the bounds of the parameters
    Declaration,
    /// P = ∂ψ/∂F
    Stress,
    /// A = ∂P/∂F
    Tangent,
    /// A = ∂P/∂F where principal stretches coincide or nearly do
    RepeatedStretches,
    /// A is symmetric
    MajorSymmetry,
    /// ψ(QF) = ψ(F) and P(QF) = Q P(F) for a law that declares itself objective, and not otherwise
    Objectivity,
    /// ψ(I) = 0, P(I) = 0, and A(I) is Hooke's law with the constants of [`Law::small_strain`]
    Reference,
    /// ψ keeps its significant digits at small strain
    SmallStrain,
    /// The law is the sum of the parts of [`Law::split`], the first of them isochoric where it is declared
    Split,
    /// Energy and stress do not depend on what else is requested, and nothing is computed that is not requested
    Want,
    /// J ≤ 0 is refused, or, if the law declares so, handled with finite values
    Inversion,
    /// The values and choices of a law rebuild the same law
    Values,
    /// [`Law::eval_lanes`] agrees with [`Law::eval`]
    Lanes,
    /// [`Law::along`] is the derivative with respect to the constants
    Constants,
}

impl LawProperty {
    pub const ALL: [Self; 14] = [
        Self::Declaration,
        Self::Stress,
        Self::Tangent,
        Self::RepeatedStretches,
        Self::MajorSymmetry,
        Self::Objectivity,
        Self::Reference,
        Self::SmallStrain,
        Self::Split,
        Self::Want,
        Self::Inversion,
        Self::Values,
        Self::Lanes,
        Self::Constants,
    ];

    /// Help for a law that lacks the property.
    fn remedy(self) -> &'static str {
        match self {
            Self::Declaration => "complete the description of the law",
            Self::Stress => "let the stress be ∂ψ/∂F, row by row",
            Self::Tangent => "let the tangent be ∂P/∂F, A[3i + J][3k + L] = ∂P[i][J]/∂F[k][L]",
            Self::RepeatedStretches => "let the tangent be ∂P/∂F where principal stretches coincide, too",
            Self::MajorSymmetry => "let the tangent be ∂²ψ/∂F∂F, which is symmetric",
            Self::Objectivity => {
                "let the law declare as objective whether a rotation of the body leaves its energy as it is"
            }
            Self::Reference => "let energy and stress vanish at F = I, and the stiffness there be that of the moduli",
            Self::SmallStrain => "compute the energy without cancellation near F = I, as by Invariants",
            Self::Split => "let the law be the sum of its parts, the first of them isochoric where that is declared",
            Self::Want => "let energy and stress not depend on what else is wanted, and compute nothing that is not",
            Self::Inversion => "let the law declare whether it survives inversion, J ≤ 0",
            Self::Values => "let the values and choices of the law be those that make it again",
            Self::Lanes => "let the evaluation of several gradients at a time agree with that of one",
            Self::Constants => {
                "let the derivatives by the constants be right, and declare a law as linear in them only where it is"
            }
        }
    }
}

/// A violation of a property by a law.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[error("law `{law}` fails the check {property:?}: {detail}; {}", property.remedy())]
pub struct LawViolation {
    pub law: &'static str,
    pub property: LawProperty,
    /// Constants, the deformation gradient if the property does not determine it, and the numbers that differ
    pub detail: String,
}

/// Checks every property of a law.
///
/// # Errors
///
/// Returns the first property that does not hold, with the state at which it fails.
pub fn check_law(entry: &LawEntry) -> Result<(), LawViolation> {
    LawProperty::ALL.into_iter().try_for_each(|property| check_property(entry, property))
}

/// Checks one property of a law.
///
/// # Errors
///
/// Returns the property if it does not hold, with the state at which it fails.
pub fn check_property(entry: &LawEntry, property: LawProperty) -> Result<(), LawViolation> {
    let result = match property {
        LawProperty::Declaration => declaration(entry),
        LawProperty::Stress => at_random_states(entry, 1, stress),
        LawProperty::Tangent => at_random_states(entry, 2, tangent),
        LawProperty::RepeatedStretches => repeated_stretches(entry),
        LawProperty::MajorSymmetry => at_random_states(entry, 3, major_symmetry),
        LawProperty::Objectivity => at_random_states(entry, 4, objectivity),
        LawProperty::Reference => of_random_laws(entry, 5, |law, _, _, _| reference(law)),
        LawProperty::SmallStrain => of_random_laws(entry, 6, |law, _, _, random| small_strain(law, random)),
        LawProperty::Split => at_random_states(entry, 11, split),
        LawProperty::Want => at_random_states(entry, 7, want),
        LawProperty::Inversion => inversion(entry),
        LawProperty::Values => at_random_states(entry, 10, |law, f, _, _| values(entry, law, f)),
        LawProperty::Lanes => at_random_states(entry, 12, lanes),
        LawProperty::Constants => constants(entry),
    };
    // A message of the law may contain its own remedy, which is meant for runs
    result.map_err(|detail| LawViolation { law: entry.info.name, property, detail: detail.replace("; ", ", ") })
}

type Check = Result<(), String>;

/// Returns an error with this text unless the condition holds.
fn ensure(condition: bool, text: impl FnOnce() -> String) -> Check {
    if condition { Ok(()) } else { Err(text()) }
}

/// Runs a check over random parameters and random states (inverted ones if the law accepts them); an error names them.
fn at_random_states(
    entry: &LawEntry,
    seed: u64,
    check: impl Fn(&dyn Law, &Mat3, f64, &mut SplitMix) -> Check,
) -> Check {
    of_random_laws(entry, seed, |law, f, rho, random| {
        check(law, f, rho, random).map_err(|e| format!("at F = {:?}: {e}", by_rows(f)))
    })
}

/// Runs a check over random parameters; an error names only the parameters.
fn of_random_laws(entry: &LawEntry, seed: u64, check: impl Fn(&dyn Law, &Mat3, f64, &mut SplitMix) -> Check) -> Check {
    let mut random = SplitMix(seed);
    for n in 0..60 {
        let law = draws::law(&mut random, entry)?;
        let (mut f, mut rho) = gradient(&mut random, entry.info.survives_inversion && n % 3 == 0);
        let mut range = 1.0;
        while let Err(e) = law.eval(&f, Want::Energy) {
            let at = || format!("{} at F = {:?}: {e}", constants_of(law.as_ref()), by_rows(&f));
            ensure(matches!(e, LawError::Locked { .. } | LawError::Undefined) && range > 1e-6, at)?;
            range *= 0.8;
            (f, rho) = gradient_within(&mut random, false, range);
        }
        check(law.as_ref(), &f, rho, &mut random).map_err(|e| format!("{} {e}", constants_of(law.as_ref())))?;
    }
    Ok(())
}

fn eval(law: &dyn Law, f: &Mat3) -> Result<Response, String> {
    law.eval(f, Want::Tangent).map_err(|e| format!("refused at F = {:?}: {e}", by_rows(f)))
}

/// The constants of a law with their units, such as `with E = 180000 Pa, nu = 0.3`.
fn constants_of(law: &dyn Law) -> String {
    let one = |(p, value): (&Parameter, f64)| match p.dimension {
        Dimension::NONE => format!("{} = {}", p.name, shown(value)),
        dimension => format!("{} = {} {}", p.name, shown(value), dimension.si_unit()),
    };
    let all: Vec<String> = law.info().parameters.iter().zip(law.values()).map(one).collect();
    format!("with {}", all.join(", "))
}

/// The rows of a tensor.
fn by_rows(f: &Mat3) -> [[f64; 3]; 3] {
    f.transpose().into()
}

/// Frobenius norm of A \[Pa\].
fn norm(r: &Response) -> f64 {
    r.a.as_flattened().iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The radius for the differences: a quarter of the distance to the singularity, so that a pole of high order (λ⁻¹⁰) does not dominate the scale, or
/// half of the length over which P changes by its own size if that is shorter (exponentials, locking). The lower bound is for P near zero, where that
/// length has no meaning.
fn smooth(r: &Response, rho: f64) -> f64 {
    (0.25 * rho).min(0.5 * r.p.norm() / norm(r)).max(1e-4 * rho)
}

fn unit(k: usize) -> Mat3 {
    let mut e = Mat3::zeros();
    e[(k / 3, k % 3)] = 1.0;
    e
}

/// D₆ from D(h), D(h/2) and D(h/4).
fn richardson([whole, half, quarter]: [f64; 3]) -> f64 {
    (64.0 * quarter - 20.0 * half + whole) / 45.0
}

/// D₆ of g at 0 and the size M of g on the stencil.
fn difference(rho: f64, g: impl Fn(f64) -> Result<f64, String>) -> Result<(f64, f64), String> {
    let h = rho / 50.0;
    let mut size = 0.0_f64;
    let mut d = [0.0; 3];
    for (d, h) in d.iter_mut().zip([h, h / 2.0, h / 4.0]) {
        let (plus, minus) = (g(h)?, g(-h)?);
        size = size.max(plus.abs()).max(minus.abs());
        *d = (plus - minus) / (2.0 * h);
    }
    let d = richardson(d);
    Ok((d, size + rho * d.abs()))
}

fn declaration(entry: &LawEntry) -> Check {
    let i = entry.info;
    let texts = [i.name, i.formula, i.source, i.limits];
    ensure(texts.iter().all(|t| !t.is_empty()), || "name, formula, source and limits must not be empty".into())?;
    ensure(!i.parameters.is_empty() && i.optional < i.parameters.len(), || "no parameter is required".into())?;
    let known = |p: &Parameter| entry.keys.iter().any(|k| k.name == p.name);
    ensure(i.parameters.iter().all(known), || "a parameter is not among the keys of files".into())?;
    let law = entry.example().map_err(|e| format!("the example is refused: {e}"))?;
    ensure(law.info().name == i.name, || format!("the example is of the law `{}`", law.info().name))?;
    let table = given_as(entry, &entry.example_table()).map_err(|e| format!("the table of the example: {e}"))?;
    let again = entry.build(&table.0, &table.1).map_err(|e| format!("the table of the example is refused: {e}"))?;
    ensure(again.values() == law.values(), || format!("the table of the example gives {:?}", again.values()))
}

fn stress(law: &dyn Law, f: &Mat3, rho: f64, _: &mut SplitMix) -> Check {
    let r = eval(law, f)?;
    let rho = smooth(&r, rho);
    for k in 0..9 {
        let (d, size) = difference(rho, |h| Ok(eval(law, &(f + unit(k) * h))?.psi))?;
        let got = r.p[(k / 3, k % 3)];
        ensure((got - d).abs() <= 1e-10 * size / rho, || {
            format!("P[{}][{}] = {got}, differences of the energy give {d}", k / 3, k % 3)
        })?;
    }
    Ok(())
}

fn tangent(law: &dyn Law, f: &Mat3, rho: f64, _: &mut SplitMix) -> Check {
    let r = eval(law, f)?;
    let rho = smooth(&r, rho);
    for column in 0..9 {
        for row in 0..9 {
            let (d, size) = difference(rho, |h| Ok(eval(law, &(f + unit(column) * h))?.p[(row / 3, row % 3)]))?;
            // Each entry carries the rounding of the whole of P.
            let size = size + r.p.norm();
            let got = r.a[row][column];
            let wrong = || format!("A[{row}][{column}] = {got}, differences of the stress give {d}");
            ensure((got - d).abs() <= 1e-10 * size / rho, wrong)?;
        }
    }
    Ok(())
}

/// Two (either pair) or three equal principal stretches, and stretches 1e-3 … 1e-12 apart.
fn repeated_stretches(entry: &LawEntry) -> Check {
    let mut random = SplitMix(12);
    for gap in [0.0, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-3] {
        for s in
            [[0.9, 0.9 + gap, 1.2], [0.8, 1.1, 1.1 - gap], [1.1, 1.1 + gap, 1.1 - 2.0 * gap], [1.0, 1.0 + gap, 1.0]]
        {
            let f = rotation(&mut random) * Mat3::from_diagonal(&Vec3::from(s)) * rotation(&mut random);
            let defined = (0..1000).find_map(|_| match draws::law(&mut random, entry) {
                Ok(law) if law.eval(&f, Want::Energy).is_err() => None,
                other => Some(other),
            });
            let law = defined.ok_or_else(|| format!("no draw of constants is defined at the stretches {s:?}"))??;
            let law = law.as_ref();
            let r = eval(law, &f)?;
            // In the undeformed state the lengths of `smooth` have no meaning; a power of 10 or a rate of 10 is smooth over 1/20.
            let rho = 0.05 * locking(law);
            for column in 0..9 {
                for row in 0..9 {
                    let (d, size) = difference(rho, |h| Ok(eval(law, &(f + unit(column) * h))?.p[(row / 3, row % 3)]))?;
                    let error = (r.a[row][column] - d).abs();
                    let a = r.a.as_flattened().iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                    ensure(error <= 1e-10 * (size / rho + a), || {
                        format!(
                            "{} at the stretches {s:?}: A[{row}][{column}] is off by {error} of {a}",
                            constants_of(law)
                        )
                    })?;
                }
            }
        }
    }
    Ok(())
}

/// Ī₁ − 3 ≈ (4/3)d² \[–\] for the largest extension d ≤ 1 at which the law is defined, at most 1.
fn locking(law: &dyn Law) -> f64 {
    let defined = |d: f64| law.eval(&Mat3::from_diagonal(&Vec3::new(1.0 + d, 1.0, 1.0)), Want::Energy).is_ok();
    if defined(1.0) {
        return 1.0;
    }
    let (mut inside, mut outside) = (0.0, 1.0);
    for _ in 0..30 {
        let middle = 0.5 * (inside + outside);
        if defined(middle) { inside = middle } else { outside = middle }
    }
    (4.0 / 3.0 * inside * inside).clamp(1e-6, 1.0)
}

/// A is symmetric up to the rounding of a sum of a few terms of the size of A.
fn major_symmetry(law: &dyn Law, f: &Mat3, _: f64, _: &mut SplitMix) -> Check {
    let a = eval(law, f)?.a;
    let size = a.as_flattened().iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    for row in 0..9 {
        for column in 0..row {
            let (x, y) = (a[row][column], a[column][row]);
            ensure((x - y).abs() <= 1e-14 * size, || format!("A[{row}][{column}] = {x}, transposed {y}"))?;
        }
    }
    Ok(())
}

/// F̃ = QF differs from the exact product by δ ≈ 3ε‖F‖, which changes ψ by |P|δ and P by |A|δ; the bound allows 30 times that for the rounding inside
/// the law.
fn objectivity(law: &dyn Law, f: &Mat3, _: f64, random: &mut SplitMix) -> Check {
    let q = rotation(random);
    let (r, rotated) = (eval(law, f)?, eval(law, &(q * f))?);
    let delta = 100.0 * f64::EPSILON * (1.0 + f.norm());
    let a = norm(&r);
    let energy = (rotated.psi - r.psi).abs() <= delta * (r.p.norm() + r.psi.abs() + a);
    let stress = (rotated.p - q * r.p).norm() <= delta * (r.p.norm() + a);
    if law.info().objective {
        ensure(energy && stress, || format!("ψ {} → {}, ΔP {}", r.psi, rotated.psi, (rotated.p - q * r.p).norm()))
    } else {
        ensure(!energy && !stress, || "it declares `objective: false` and is objective".into())
    }
}

/// ψ(I) = 0 and P(I) = 0 to two ulp of the stiffness; A(I) = λ δ_iJ δ_kL + μ(δ_ik δ_JL + δ_iL δ_kJ) with λ, μ computed here
/// from (E, ν).
fn reference(law: &dyn Law) -> Check {
    let Moduli { e, nu, .. } = law.small_strain();
    let (mu, lambda) = (e / (2.0 * (1.0 + nu)), e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)));
    let size = 2.0 * mu + lambda.abs();
    let r = eval(law, &Mat3::identity())?;
    ensure(r.psi.abs() <= 2.0 * f64::EPSILON * size, || format!("at F = I: ψ = {}", r.psi))?;
    ensure(r.p.amax() <= 2.0 * f64::EPSILON * size, || format!("at F = I: P = {:?}", by_rows(&r.p)))?;
    let delta = |a: usize, b: usize| f64::from(a == b);
    for row in 0..9 {
        for column in 0..9 {
            let (i, j, k, l) = (row / 3, row % 3, column / 3, column % 3);
            let hooke =
                lambda * delta(i, j) * delta(k, l) + mu * (delta(i, k) * delta(j, l) + delta(i, l) * delta(k, j));
            let got = r.a[row][column];
            ensure((got - hooke).abs() <= 1e-12 * size, || {
                format!("at F = I: A[{row}][{column}] = {got}, Hooke {hooke}")
            })?;
        }
    }
    Ok(())
}

/// ψ(I + H) = μ ε:ε + ½λ tr²ε + O(‖H‖³) keeps its digits at ‖H‖ ≈ 1e-6, where twelve of them cancel in I₁ − 3 − 2 ln J. The cubic term is at most a
/// few times κ‖H‖³, and H = F − I is exact as formed here. Objective laws have the same ε:ε.
fn small_strain(law: &dyn Law, random: &mut SplitMix) -> Check {
    let f = Mat3::identity() + Mat3::from_fn(|_, _| random.between(-1e-6, 1e-6));
    let h = f - Mat3::identity();
    let eps = (h + h.transpose()) * 0.5;
    let m = law.small_strain();
    let hooke = m.mu * eps.norm_squared() + 0.5 * m.lambda * eps.trace().powi(2);
    let psi = eval(law, &f)?.psi;
    let cubic = 20.0 * (m.mu + m.kappa) * h.norm().powi(3);
    ensure((psi - hooke).abs() <= cubic + 1e-12 * hooke, || {
        format!("at F − I = {:?}: ψ = {psi}, Hooke {hooke}", by_rows(&h))
    })
}

/// A split law is the sum of its parts, P = P_rest + U′C; an isochoric rest does not depend on the volume: ψ_rest(cF) = ψ_rest(F), P_rest:F = 0.
/// Rounding: a few terms of the size of A‖F‖.
fn split(law: &dyn Law, f: &Mat3, _: f64, random: &mut SplitMix) -> Check {
    let Some((rest, u)) = law.split() else {
        return ensure(!law.info().isochoric, || "it declares an isochoric part and gives none".into());
    };
    let [whole, part] = [eval(law, f)?, eval(rest.as_ref(), f)?];
    let scaled = eval(rest.as_ref(), &(f * random.between(0.5, 2.0)))?;
    let j = f.determinant();
    let size = 1e-13 * (norm(&whole) + norm(&part) + whole.p.norm() + part.p.norm()) * f.norm() * f.norm();
    let cof = f.try_inverse().ok_or("F is singular")?.transpose() * j;
    ensure((whole.psi - part.psi - u.u(j)).abs() <= size, || "ψ is not ψ_rest + U".into())?;
    ensure((whole.p - part.p - cof * u.du(j)).norm() <= size, || "P is not P_rest + U′ cof F".into())?;
    if law.info().isochoric {
        ensure((u.d2u(1.0) / law.small_strain().kappa - 1.0).abs() < 1e-12, || "U″(1) is not κ".into())?;
        ensure((scaled.psi - part.psi).abs() <= size, || "ψ_rest(cF) is not ψ_rest(F)".into())?;
        ensure(part.p.dot(f).abs() <= size, || format!("P_rest:F = {}", part.p.dot(f)))?;
    }
    for row in 0..9 {
        for column in 0..9 {
            let g = |n: usize| cof[(n / 3, n % 3)] / j;
            let cross = cof[(row / 3, column % 3)] * cof[(column / 3, row % 3)] / j;
            let volumetric = u.d2u(j) * j * j * g(row) * g(column) + u.du(j) * (j * g(row) * g(column) - cross);
            let error = whole.a[row][column] - part.a[row][column] - volumetric;
            ensure(error.abs() <= size, || format!("A[{row}][{column}] of the parts is off by {error}"))?;
        }
    }
    Ok(())
}

fn want(law: &dyn Law, f: &Mat3, _: f64, _: &mut SplitMix) -> Check {
    let at = |w| law.eval(f, w).map_err(|e| e.to_string());
    let [energy, residual, tangent] = [at(Want::Energy)?, at(Want::Residual)?, at(Want::Tangent)?];
    let same = energy.psi == tangent.psi && residual.psi == tangent.psi && residual.p == tangent.p;
    ensure(same, || "ψ or P depends on what else is wanted".into())?;
    let zero = energy.p == Mat3::zeros() && residual.a.as_flattened().iter().all(|x| *x == 0.0);
    ensure(zero, || "P or A is filled in although it is not wanted".into())?;
    ensure(tangent.a.as_flattened().iter().any(|x| *x != 0.0), || "A = 0".into())
}

/// Checks F = 0, F collapsed to a line and to a plane, reflected, turned inside out, and NaN.
fn inversion(entry: &LawEntry) -> Check {
    let d = |x, y, z| Mat3::from_diagonal(&Vec3::new(x, y, z));
    let q = rotation(&mut SplitMix(8));
    let law = draws::law(&mut SplitMix(9), entry)?;
    for f in [d(0.0, 0.0, 0.0), d(2.0, 0.0, 0.0), d(1.0, 2.0, 0.0), d(-1.0, 1.0, 1.0), d(-0.5, -1.0, -2.0)] {
        for f in [f, q * f, f * q] {
            match law.eval(&f, Want::Tangent) {
                Ok(r) => {
                    ensure(entry.info.survives_inversion, || {
                        format!("it accepts F = {:?} but does not declare it", by_rows(&f))
                    })?;
                    let finite = r.psi.is_finite() && r.p.iter().chain(r.a.as_flattened()).all(|x| x.is_finite());
                    ensure(finite && r.psi >= 0.0, || format!("at F = {:?}: {r:?}", by_rows(&f)))?;
                }
                Err(LawError::Inverted { j }) => {
                    ensure(!entry.info.survives_inversion, || {
                        format!("it declares to survive inversion and refuses F = {:?}", by_rows(&f))
                    })?;
                    ensure(j <= 1e-14, || format!("it refuses J = {j} as inverted"))?;
                }
                Err(e) => return Err(format!("at J ≤ 0: {e}")),
            }
        }
    }
    let nan = law.eval(&d(f64::NAN, 1.0, 1.0), Want::Energy);
    ensure(nan.is_err() || nan.is_ok_and(|r| r.psi.is_nan()), || "F that is not a number gives a number".into())
}

fn values(entry: &LawEntry, law: &dyn Law, f: &Mat3) -> Check {
    let again = entry.build_with(&law.values(), &law.choices()).map_err(|e| e.to_string())?;
    let same = (again.values(), again.choices()) == (law.values(), law.choices());
    ensure(same, || format!("rebuilt it has the values {:?}", again.values()))?;
    ensure(eval(law, f)?.p == eval(again.as_ref(), f)?.p, || "rebuilt it has another stress".into())
}

/// Lanes agree with single evaluations up to rounding: they may contract products and sums.
fn lanes(law: &dyn Law, f: &Mat3, _: f64, _: &mut SplitMix) -> Check {
    let mut packed = [Lanes::ZERO; 9];
    for (k, entry) in packed.iter_mut().enumerate() {
        entry.0 = [f[(k / 3, k % 3)]; LANES];
    }
    let one = eval(law, f)?;
    let mut out = LaneResponse::default();
    law.eval_lanes(&packed, Want::Tangent, &mut out).map_err(|(lane, e)| format!("lane {lane} is refused: {e}"))?;
    let (size, p) = (1e-12 * norm(&one) * (1.0 + f.norm_squared()), |k: usize| one.p[(k / 3, k % 3)]);
    for lane in 0..LANES {
        let energy = (out.psi.0[lane] - one.psi).abs() <= size;
        let stress = (0..9).all(|k| (out.p[k].0[lane] - p(k)).abs() <= size);
        let mut entries = out.a.as_flattened().iter().zip(one.a.as_flattened());
        let tangent = entries.all(|(x, y)| (x.0[lane] - y).abs() <= size);
        ensure(energy && stress && tangent, || format!("lane {lane} differs from the evaluation of one gradient"))?;
    }
    Ok(())
}

/// Compares ∂/∂θ of ψ, P and A of the example, for each of its values, with differences over θ(1 ± h), h = 1e-2, h/2, h/4: truncation h⁶/64 with
/// poles 0.25 θ away is 1e-10 of the value, rounding 7ε/h·k ≈ 2e-13 k; the bound is 1e-8 of the size on the stencil.
fn constants(entry: &LawEntry) -> Check {
    let law = entry.example().map_err(|e| e.to_string())?;
    let numbers = |law: &dyn Law, f: &Mat3| {
        let Response { psi, p, a } = eval(law, f)?;
        Ok::<_, String>([&[psi], p.as_slice(), a.as_flattened()].concat())
    };
    let mut random = SplitMix(31);
    for _ in 0..12 {
        let mut h = Mat3::from_fn(|_, _| random.between(-0.25, 0.25));
        // A margin to the boundary of the domain, which moves with the constants
        while matches!(law.eval(&(Mat3::identity() + h * 1.1), Want::Energy), Err(LawError::Undefined))
            && h.norm() > 1e-6
        {
            h *= 0.8;
        }
        let f = Mat3::identity() + h;
        for (k, theta) in law.values().into_iter().enumerate().filter(|(_, theta)| *theta != 0.0) {
            let mut rates = vec![0.0; law.values().len()];
            rates[k] = 1.0;
            let got = numbers(law.along(&rates).as_ref(), &f)?;
            let at = |h: f64| {
                let mut values = law.values();
                values[k] = theta * (1.0 + h);
                let law = entry.build_with(&values, &law.choices()).map_err(|e| e.to_string())?;
                numbers(law.as_ref(), &f)
            };
            let mut d = [const { Vec::new() }; 3];
            let mut size = got.iter().fold(0.0_f64, |m, x| m.max((x * theta).abs()));
            for (d, h) in d.iter_mut().zip([1e-2, 5e-3, 2.5e-3]) {
                let (plus, minus) = (at(h)?, at(-h)?);
                size = plus.iter().fold(size, |m, x| m.max(x.abs()));
                *d = plus.iter().zip(&minus).map(|(a, b)| (a - b) / (2.0 * h * theta)).collect();
            }
            for (n, got) in got.iter().enumerate() {
                let expected = richardson(d.each_ref().map(|d| d[n]));
                let name = entry.info.parameters[k].name;
                let wrong = || format!("entry {n} by {name} is {got}, differences give {expected}");
                ensure((got - expected).abs() <= 1e-8 * size / theta.abs(), wrong)?;
            }
        }
    }
    Ok(())
}
