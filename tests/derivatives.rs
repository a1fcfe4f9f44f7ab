//! Derivatives and invariances of every law in the registry: a new law is covered here without a line of its own.
//!
//! Finite differences. D(h) = (g(h) − g(−h))/2h = g′ + c₂h² + c₄h⁴ + c₆h⁶ + …; from h, h/2, h/4 Richardson's
//! D₆ = (64 D(h/4) − 20 D(h/2) + D(h))/45 leaves the term c₆h⁶/64. A law is analytic in a ball of radius ρ around F (to the
//! nearest J = 0 or s₂ + s₃ = 0), so |c₆| ≤ M/ρ⁷ by Cauchy's estimate, M the size of g there. With h = ρ/50:
//! truncation ≤ (1/50)⁶/64 · M/ρ ≈ 1e-12 M/ρ. Rounding: each g carries k ulp of M, and the weights give
//! (64·4 + 20·2 + 1)/45 ≈ 6.6 of them over h: 330 k ε M/ρ ≈ 7e-14 k M/ρ. The bound used is 1e-10 M/ρ: k up to 1000, which is
//! the condition of invariants for stretches in [0.3, 3] and κ/μ ≤ 500 (ln J costs κ/μ ulp of μ, part of M). M is taken as the
//! largest |g| on the stencil plus ρ|g′|.

// A[3i+J][3k+L] is read by its indices, as in the formulae.
#![allow(clippy::needless_range_loop)]

use durometer::material::{Choice, LAWS, Law, LawEntry, LawError, LawSpecError, Moduli, Response, Want, registry};
use durometer::math::random::SplitMix;
use durometer::math::tensor::{Mat3, Vec3};
use durometer::math::units::Dimension;

/// Seeded draws of states and laws.
struct Random(SplitMix);

impl Random {
    fn seed(seed: u64) -> Self {
        Self(SplitMix(seed))
    }

    fn unit(&mut self) -> f64 {
        self.0.unit()
    }

    fn between(&mut self, lower: f64, upper: f64) -> f64 {
        lower + (upper - lower) * self.unit()
    }

    /// A rotation: a random unit quaternion.
    fn rotation(&mut self) -> Mat3 {
        let q = nalgebra::Quaternion::new(
            self.between(-1.0, 1.0),
            self.between(-1.0, 1.0),
            self.between(-1.0, 1.0),
            self.between(-1.0, 1.0),
        );
        nalgebra::UnitQuaternion::from_quaternion(q).to_rotation_matrix().into_inner()
    }

    /// Parameters inside their bounds, moduli over three decades and of either sign where it is free, any number of the optional ones, any
    /// option; drawn again until the shear modulus at F = I is positive.
    fn law(&mut self, entry: &LawEntry) -> Box<dyn Law> {
        let info = entry.info;
        for _ in 0..1000 {
            let absent = (self.unit() * (info.optional as f64 + 1.0)) as usize;
            let mut values = Vec::new();
            for p in &info.parameters[..info.parameters.len() - absent] {
                let (lower, upper) = p.bounds;
                values.push(if p.dimension == Dimension::PRESSURE {
                    let sign = if lower < 0.0 && self.unit() < 0.4 { -1.0 } else { 1.0 };
                    sign * 1e3 * 1e3_f64.powf(self.unit())
                } else {
                    let (a, b) = (lower.max(-10.0), upper.min(10.0));
                    self.between(a + 0.002 * (b - a), b - 0.0015 * (b - a))
                });
            }
            let option = |c: &Choice, r: f64| c.options[(r * c.options.len() as f64) as usize];
            let options: Vec<_> = info.choices.iter().map(|c| option(c, self.unit())).collect();
            match entry.build_with(&values, &options) {
                Ok(law) => return law,
                Err(LawSpecError::NotStable { .. }) => {}
                // Half of a pair (μ, α) is left
                Err(LawSpecError::Missing { .. }) if absent > 0 => {}
                Err(e) => panic!("{}: {e} from {values:?}", info.name),
            }
        }
        panic!("{}: no draw has a positive shear modulus", info.name)
    }

    /// F with principal stretches in [0.3, 3], inverted on request, and its distance ρ to the nearest singularity of any law.
    fn gradient(&mut self, inverted: bool) -> (Mat3, f64) {
        self.gradient_within(inverted, 1.0)
    }

    /// The same with the logarithms of the stretches times `range`.
    fn gradient_within(&mut self, inverted: bool, range: f64) -> (Mat3, f64) {
        let mut s = [0, 1, 2].map(|_| (0.3 * 10_f64.powf(self.unit())).powf(range));
        s.sort_by(f64::total_cmp);
        if inverted {
            s[1] = s[1].max(s[0] + 0.3);
            s[2] = s[2].max(s[1]);
            s[0] = -s[0];
        }
        let rho = s[0].abs().min(s[0] + s[1]).min(1.0);
        (self.rotation() * Mat3::from_diagonal(&Vec3::from(s)) * self.rotation(), rho)
    }
}

/// Runs a check over laws, random parameters and random states (inverted ones where the law takes them).
fn over_laws(seed: u64, check: impl Fn(&str, &dyn Law, &Mat3, f64, &mut Random)) {
    assert!(!LAWS.is_empty());
    for entry in LAWS {
        let mut random = Random::seed(seed);
        for n in 0..60 {
            let law = random.law(entry);
            let (mut f, mut rho) = random.gradient(entry.info.survives_inversion && n % 3 == 0);
            let mut range = 1.0;
            while let Err(e) = law.eval(&f, Want::Energy) {
                assert!(matches!(e, LawError::Locked { .. }), "{e}");
                range *= 0.8;
                (f, rho) = random.gradient_within(false, range);
            }
            let label = format!("{} {:?} at F = {:?}", entry.info.name, law.values(), f.as_slice());
            check(&label, law.as_ref(), &f, rho, &mut random);
        }
    }
}

fn eval(law: &dyn Law, f: &Mat3) -> Response {
    law.eval(f, Want::Tangent).expect("the state is inside the domain of the law")
}

/// The radius for the differences: a quarter of the distance to the singularity, so that a pole of a high power (λ⁻¹⁰) has not grown out of
/// scale there, or half of the length over which P changes by itself where that is shorter (exponentials, locking). The lower end is for P near
/// zero, where that length means nothing.
fn smooth(law: &dyn Law, f: &Mat3, rho: f64) -> f64 {
    let r = eval(law, f);
    let a = r.a.as_flattened().iter().map(|x| x * x).sum::<f64>().sqrt();
    (0.25 * rho).min(0.5 * r.p.norm() / a).max(1e-4 * rho)
}

fn unit(k: usize) -> Mat3 {
    let mut e = Mat3::zeros();
    e[(k / 3, k % 3)] = 1.0;
    e
}

/// D₆ of g at 0 and the size M of g on the stencil.
fn difference(rho: f64, g: impl Fn(f64) -> f64) -> (f64, f64) {
    let h = rho / 50.0;
    let mut size = 0.0_f64;
    let [d1, d2, d4] = [h, h / 2.0, h / 4.0].map(|h| {
        let (plus, minus) = (g(h), g(-h));
        size = size.max(plus.abs()).max(minus.abs());
        (plus - minus) / (2.0 * h)
    });
    let d = (64.0 * d4 - 20.0 * d2 + d1) / 45.0;
    (d, size + rho * d.abs())
}

#[test]
fn stress_is_the_derivative_of_energy() {
    over_laws(1, |label, law, f, rho, _| {
        let p = eval(law, f).p;
        let rho = smooth(law, f, rho);
        for k in 0..9 {
            let (d, size) = difference(rho, |h| eval(law, &(f + unit(k) * h)).psi);
            let got = p[(k / 3, k % 3)];
            assert!((got - d).abs() <= 1e-10 * size / rho, "{label}: P[{k}] = {got}, energy says {d}");
        }
    });
}

#[test]
fn tangent_is_the_derivative_of_stress() {
    over_laws(2, |label, law, f, rho, _| {
        let Response { a, p, .. } = eval(law, f);
        let rho = smooth(law, f, rho);
        for column in 0..9 {
            for row in 0..9 {
                let (d, size) = difference(rho, |h| eval(law, &(f + unit(column) * h)).p[(row / 3, row % 3)]);
                // Each entry carries the rounding of the whole of P.
                let size = size + p.norm();
                let got = a[row][column];
                assert!((got - d).abs() <= 1e-10 * size / rho, "{label}: A[{row}][{column}] = {got}, stress says {d}");
            }
        }
    });
}

/// The same where principal stretches coincide, or nearly: double (either pair), triple, and 1e-3 … 1e-12 apart.
#[test]
fn tangent_at_repeated_stretches() {
    let mut random = Random::seed(12);
    for entry in LAWS {
        for gap in [0.0, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-3] {
            for s in
                [[0.9, 0.9 + gap, 1.2], [0.8, 1.1, 1.1 - gap], [1.1, 1.1 + gap, 1.1 - 2.0 * gap], [1.0, 1.0 + gap, 1.0]]
            {
                let f = random.rotation() * Mat3::from_diagonal(&Vec3::from(s)) * random.rotation();
                let law = loop {
                    let law = random.law(entry);
                    if law.eval(&f, Want::Energy).is_ok() {
                        break law;
                    }
                };
                let r = eval(law.as_ref(), &f);
                // Undeformed the lengths of `smooth` mean nothing; a power of 10 or a rate of 10 is smooth over 1/20.
                let rho = 0.05 * if law.info().name == "gent" { law.values()[2].min(1.0) } else { 1.0 };
                for column in 0..9 {
                    for row in 0..9 {
                        let (d, size) =
                            difference(rho, |h| eval(law.as_ref(), &(f + unit(column) * h)).p[(row / 3, row % 3)]);
                        let label = format!("{} {:?} at {s:?}", entry.info.name, law.values());
                        let error = (r.a[row][column] - d).abs();
                        let a = r.a.as_flattened().iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                        assert!(error <= 1e-10 * (size / rho + a), "{label}: A[{row}][{column}] off by {error}, A {a}");
                    }
                }
            }
        }
    }
}

fn build(name: &str, values: &[f64]) -> Box<dyn Law> {
    registry::find(name).and_then(|e| e.build_with(values, &["quadratic"])).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// Both laws give the same ψ, P and A: rounding is a few hundred ulp of A‖F‖² (condition of the invariants) plus `model` of it.
fn assert_same(a: &dyn Law, b: &dyn Law, f: &Mat3, model: f64) {
    let (ra, rb) = (eval(a, f), eval(b, f));
    let norm = |r: &Response| r.a.as_flattened().iter().map(|x| x * x).sum::<f64>().sqrt();
    let size = (1e-13 + model) * norm(&rb) * f.norm_squared();
    let label = format!("{} {:?} and {} at {f}", a.info().name, a.values(), b.info().name);
    assert!((ra.psi - rb.psi).abs() <= size, "{label}: ψ {} {}", ra.psi, rb.psi);
    assert!((ra.p - rb.p).norm() <= size, "{label}: P {} {}", ra.p, rb.p);
    for (x, y) in ra.a.as_flattened().iter().zip(rb.a.as_flattened()) {
        assert!((x - y).abs() <= size, "{label}: A {x} {y}");
    }
}

/// Powers 2, −2 and 4 are polynomials of the invariants: Σλ̄² = Ī₁, Σλ̄⁻² = Ī₂, Σλ̄⁴ = Ī₁² − 2Ī₂. So principal stretches and invariants, which
/// share no code but U(J), must agree, at random F and where stretches coincide or nearly do.
#[test]
fn even_powers_of_ogden_are_mooney_rivlin() {
    let mut random = Random::seed(13);
    let kappa = 500e3;
    let (a, b, c) = (40e3, 15e3, 8e3);
    let one = [build("ogden", &[kappa, a, 2.0]), build("mooney_rivlin", &[kappa, 0.5 * a, 0.0])];
    let two = [build("ogden", &[kappa, a, 2.0, -b, -2.0]), build("mooney_rivlin", &[kappa, 0.5 * a, 0.5 * b])];
    // (c/4)(Ī₁² − 2Ī₂ − 3) = (c/4)(6i + i² − 2k)
    let mixed = [kappa, 0.5 * a + 1.5 * c, 0.5 * b - 0.5 * c, 0.0, 0.25 * c];
    let three = [build("ogden", &[kappa, a, 2.0, -b, -2.0, c, 4.0]), build("mooney_rivlin", &mixed)];
    let neo = registry::find("neo_hookean_split").expect("registered");
    let moduli = Moduli::from_pair(("mu", a), ("kappa", kappa)).expect("consistent");
    let neo = neo.build_from(&[moduli.e, moduli.nu]).expect("in bounds");
    let mut check = |s: [f64; 3]| {
        let f = random.rotation() * Mat3::from_diagonal(&Vec3::from(s)) * random.rotation();
        let straight = Mat3::from_diagonal(&Vec3::from(s));
        for f in [f, straight] {
            for [x, y] in [&one, &two, &three] {
                assert_same(x.as_ref(), y.as_ref(), &f, 0.0);
            }
            assert_same(one[0].as_ref(), neo.as_ref(), &f, 0.0);
        }
    };
    for gap in [0.0, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3] {
        check([0.6, 1.7, 1.7 + gap]);
        check([0.6, 0.6 + gap, 1.7]);
        check([1.3, 1.3 + gap, 1.3 - gap]);
        check([1.0, 1.0 + gap, 1.0 - 2.0 * gap]);
    }
    let mut draw = Random::seed(14);
    for _ in 0..50 {
        check([0, 1, 2].map(|_| 0.3 * 10_f64.powf(draw.unit())));
    }
}

/// At a small strain of the size 1e-7 the energies of the two ways still agree to their last digits, far below ‖H‖³.
#[test]
fn small_energies_of_both_ways_agree() {
    let mut random = Random::seed(15);
    let ogden = build("ogden", &[500e3, 40e3, 2.0, -15e3, -2.0]);
    let invariants = build("mooney_rivlin", &[500e3, 20e3, 7.5e3]);
    for _ in 0..50 {
        let f = Mat3::identity() + Mat3::from_fn(|_, _| random.between(-1e-7, 1e-7));
        let (x, y) = (eval(ogden.as_ref(), &f).psi, eval(invariants.as_ref(), &f).psi);
        assert!((x / y - 1.0).abs() < 1e-13, "{x} {y}");
    }
}

/// Special and limiting cases. Gent: ln(1 − t) differs from −t by ½t², t = (Ī₁ − 3)/J_m ≤ 2e-8 here. Arruda–Boyce: the second term is
/// (3/5)/λ_m² of the first, times Ī₁²/Ī₁ ≤ 25/3.
#[test]
fn limits_are_neo_hookean() {
    let (mu, kappa) = (40e3, 300e3);
    let neo = build("yeoh", &[kappa, 0.5 * mu]);
    let mut random = Random::seed(16);
    for _ in 0..50 {
        let f = random.gradient(false).0;
        assert_same(build("yeoh", &[kappa, 0.5 * mu, 0.0, 0.0]).as_ref(), neo.as_ref(), &f, 0.0);
        assert_same(build("mooney_rivlin", &[kappa, 0.5 * mu, 0.0]).as_ref(), neo.as_ref(), &f, 0.0);
        assert_same(build("ogden", &[kappa, mu, 2.0]).as_ref(), neo.as_ref(), &f, 0.0);
        assert_same(build("gent", &[kappa, mu, 1e9]).as_ref(), neo.as_ref(), &f, 1e-7);
        assert_same(build("arruda_boyce", &[kappa, mu, 1e4]).as_ref(), neo.as_ref(), &f, 1e-7);
        let far = |law: &str, limit: f64| {
            (eval(build(law, &[kappa, mu, limit]).as_ref(), &f).psi / eval(neo.as_ref(), &f).psi - 1.0).abs()
        };
        // and of first order in 1/J_m, 1/λ_m²
        assert!((far("gent", 1e5) / far("gent", 1e6) - 10.0).abs() < 0.1);
        assert!((far("arruda_boyce", 1e2) / far("arruda_boyce", 1e3) - 100.0).abs() < 1.0);
    }
}

/// The three conventions of Ogden's factors describe the same law when their factors are converted.
#[test]
fn conventions_of_ogden() {
    let entry = registry::find("ogden").expect("registered");
    let with = |convention, factor: fn(f64, f64) -> f64| {
        let terms = [(30e3, 1.3), (-2e3, -4.0)].iter().flat_map(|(mu, alpha)| [factor(*mu, *alpha), *alpha]);
        let values: Vec<f64> = std::iter::once(400e3).chain(terms).collect();
        entry.build_with(&values, &["quadratic", convention]).expect("in bounds")
    };
    let own = with("ogden", |mu, _| mu);
    let (abaqus, febio) = (with("abaqus", |mu, alpha| 0.5 * mu * alpha), with("febio", |mu, alpha| mu * alpha));
    let mut random = Random::seed(17);
    for _ in 0..20 {
        let f = random.gradient(false).0;
        assert_same(abaqus.as_ref(), own.as_ref(), &f, 0.0);
        assert_same(febio.as_ref(), own.as_ref(), &f, 0.0);
    }
}

/// Published shear moduli: Ogden's constants for Treloar's rubber, μ = 6.3, 0.012, −0.1 · 10⁵ Pa and α = 1.3, 5, −2, give 4.225 · 10⁵ Pa (Ogden 1972;
/// Holzapfel 2000, ch. 6.5); the series of Arruda and Boyce as in the manual of Abaqus.
#[test]
fn published_shear_moduli() {
    let ogden = build("ogden", &[1e9, 6.3e5, 1.3, 0.012e5, 5.0, -0.1e5, -2.0]);
    assert!((ogden.small_strain().mu / 4.225e5 - 1.0).abs() < 1e-14);
    let z = 2.5_f64.powi(-2);
    let factor = 1.0 + z * (3.0 / 5.0 + z * (99.0 / 175.0 + z * (513.0 / 875.0 + z * (42039.0 / 67375.0))));
    let arruda = build("arruda_boyce", &[1e9, 1e5, 2.5]);
    assert!((arruda.small_strain().mu / (1e5 * factor) - 1.0).abs() < 1e-14);
}

/// A locking law is refused at its limit, with the value that reached it, and defined up to it.
#[test]
fn locking_is_refused() {
    let law = build("gent", &[1e6, 30e3, 2.0]);
    let uniaxial = |l: f64| Mat3::from_diagonal(&Vec3::new(l, l.powf(-0.5), l.powf(-0.5)));
    // λ² + 2/λ = 5 at λ = 2
    assert!(law.eval(&uniaxial(1.99999), Want::Tangent).is_ok_and(|r| r.p[(0, 0)].is_finite()));
    match law.eval(&uniaxial(2.00001), Want::Energy) {
        Err(LawError::Locked { i, limit }) => assert!(limit == 2.0 && i > 2.0 && i < 2.001),
        other => panic!("{other:?}"),
    }
}

/// Symmetric to the rounding of a sum of a handful of terms of the size of A.
#[test]
fn tangent_has_major_symmetry() {
    over_laws(3, |label, law, f, _, _| {
        let a = eval(law, f).a;
        let size = a.as_flattened().iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        for row in 0..9 {
            for column in 0..row {
                assert!((a[row][column] - a[column][row]).abs() <= 1e-14 * size, "{label}: A[{row}][{column}]");
            }
        }
    });
}

/// ψ(QF) = ψ(F), P(QF) = Q P(F). F̃ = QF differs from the exact product by δ ≈ 3ε‖F‖, which moves ψ by |P|δ and P by |A|δ;
/// the bound leaves 30 times that for the rounding inside the law. A law that declares itself not objective must fail it.
#[test]
fn objectivity() {
    over_laws(4, |label, law, f, _, random| {
        let q = random.rotation();
        let (r, turned) = (eval(law, f), eval(law, &(q * f)));
        let delta = 100.0 * f64::EPSILON * (1.0 + f.norm());
        let a = r.a.as_flattened().iter().map(|x| x * x).sum::<f64>().sqrt();
        let energy = (turned.psi - r.psi).abs() <= delta * (r.p.norm() + r.psi.abs() + a);
        let stress = (turned.p - q * r.p).norm() <= delta * (r.p.norm() + a);
        if law.info().objective {
            assert!(energy && stress, "{label}: ψ {} → {}, ΔP {}", r.psi, turned.psi, (turned.p - q * r.p).norm());
        } else {
            assert!(!energy && !stress, "{label} declares `objective: false` and is");
        }
    });
}

#[test]
fn only_the_linear_law_is_not_objective() {
    let not: Vec<_> = LAWS.iter().filter(|e| !e.info.objective).map(|e| e.info.name).collect();
    assert_eq!(not, ["linear"]);
}

/// ψ(I) = 0 and P(I) = 0 to two ulp of the stiffness; A(I) = λ δ_iJ δ_kL + μ(δ_ik δ_JL + δ_iL δ_kJ) with λ, μ computed here
/// from (E, ν).
#[test]
fn reference_is_stress_free_and_hooke() {
    over_laws(5, |label, law, _, _, _| {
        let Moduli { e, nu, .. } = law.small_strain();
        let (mu, lambda) = (e / (2.0 * (1.0 + nu)), e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)));
        let size = 2.0 * mu + lambda.abs();
        let r = eval(law, &Mat3::identity());
        assert!(r.psi.abs() <= 2.0 * f64::EPSILON * size, "{label}: ψ(I) = {}", r.psi);
        assert!(r.p.amax() <= 2.0 * f64::EPSILON * size, "{label}: P(I) = {}", r.p);
        let delta = |a: usize, b: usize| f64::from(a == b);
        for row in 0..9 {
            for column in 0..9 {
                let (i, j, k, l) = (row / 3, row % 3, column / 3, column % 3);
                let hooke =
                    lambda * delta(i, j) * delta(k, l) + mu * (delta(i, k) * delta(j, l) + delta(i, l) * delta(k, j));
                let got = r.a[row][column];
                assert!((got - hooke).abs() <= 1e-12 * size, "{label}: A[{row}][{column}] = {got}, Hooke {hooke}");
            }
        }
    });
}

/// ψ(I + H) = μ ε:ε + ½λ tr²ε + O(‖H‖³) keeps its digits at ‖H‖ ≈ 1e-6, where I₁ − 3 − 2 ln J cancels twelve of them. The
/// cubic term is at most of the size κ‖H‖³ (a handful of them), and H = F − I is exact as formed here. Objective laws have the same ε:ε.
#[test]
fn small_strain_energy_keeps_its_digits() {
    over_laws(6, |label, law, _, _, random| {
        let f = Mat3::identity() + Mat3::from_fn(|_, _| random.between(-1e-6, 1e-6));
        let h = f - Mat3::identity();
        let eps = (h + h.transpose()) * 0.5;
        let m = law.small_strain();
        let hooke = m.mu * eps.norm_squared() + 0.5 * m.lambda * eps.trace().powi(2);
        let psi = eval(law, &f).psi;
        let cubic = 20.0 * (m.mu + m.kappa) * h.norm().powi(3);
        assert!((psi - hooke).abs() <= cubic + 1e-12 * hooke, "{label}: ψ = {psi}, Hooke {hooke}");
    });
}

/// A split law is the sum of its parts, P = P_rest + U′C; an isochoric rest sees no change of volume: ψ_rest(cF) = ψ_rest(F), P_rest:F = 0.
/// Rounding: a handful of terms of the size of A‖F‖.
#[test]
fn split_laws_are_the_sum_of_their_parts() {
    over_laws(11, |label, law, f, _, random| {
        let Some((rest, u)) = law.split() else {
            assert!(!law.info().isochoric, "{label} declares an isochoric part and gives none");
            return;
        };
        let [whole, part] = [eval(law, f), eval(rest.as_ref(), f)];
        let scaled = eval(rest.as_ref(), &(f * random.between(0.5, 2.0)));
        let j = f.determinant();
        let norm = |r: &Response| r.a.as_flattened().iter().map(|x| x * x).sum::<f64>().sqrt();
        let size = 1e-13 * (norm(&whole) + norm(&part) + whole.p.norm() + part.p.norm()) * f.norm() * f.norm();
        let cof = f.try_inverse().expect("J > 0").transpose() * j;
        assert!((whole.psi - part.psi - u.u(j)).abs() <= size, "{label}: ψ");
        assert!((whole.p - part.p - cof * u.du(j)).norm() <= size, "{label}: P");
        if law.info().isochoric {
            assert!((u.d2u(1.0) / law.small_strain().kappa - 1.0).abs() < 1e-12, "{label}: κ");
            assert!((scaled.psi - part.psi).abs() <= size, "{label}: ψ_rest(cF)");
            assert!(part.p.dot(f).abs() <= size, "{label}: P_rest:F = {}", part.p.dot(f));
        }
        for row in 0..9 {
            for column in 0..9 {
                let g = |n: usize| cof[(n / 3, n % 3)] / j;
                let cross = cof[(row / 3, column % 3)] * cof[(column / 3, row % 3)] / j;
                let volumetric = u.d2u(j) * j * j * g(row) * g(column) + u.du(j) * (j * g(row) * g(column) - cross);
                let error = whole.a[row][column] - part.a[row][column] - volumetric;
                assert!(error.abs() <= size, "{label}: A[{row}][{column}] off by {error}");
            }
        }
    });
}

/// What is not wanted is zero, and what is wanted does not depend on what else is.
#[test]
fn want_only_adds() {
    over_laws(7, |label, law, f, _, _| {
        let [energy, residual, tangent] =
            [Want::Energy, Want::Residual, Want::Tangent].map(|w| law.eval(f, w).expect("inside the domain"));
        assert!(energy.psi == tangent.psi && residual.psi == tangent.psi && residual.p == tangent.p, "{label}");
        assert!(energy.p == Mat3::zeros() && residual.a.as_flattened().iter().all(|x| *x == 0.0), "{label}");
        assert!(tangent.a.as_flattened().iter().any(|x| *x != 0.0), "{label}");
    });
}

/// F = 0, collapsed to a line and to a plane, reflected, turned inside out, and not a number.
#[test]
fn inversion_is_refused_or_survived() {
    let d = |x, y, z| Mat3::from_diagonal(&Vec3::new(x, y, z));
    let q = Random::seed(8).rotation();
    for entry in LAWS {
        let name = entry.info.name;
        let law = Random::seed(9).law(entry);
        for f in [d(0.0, 0.0, 0.0), d(2.0, 0.0, 0.0), d(1.0, 2.0, 0.0), d(-1.0, 1.0, 1.0), d(-0.5, -1.0, -2.0)] {
            for f in [f, q * f, f * q] {
                match law.eval(&f, Want::Tangent) {
                    Ok(r) => {
                        assert!(entry.info.survives_inversion, "{name} accepts {f} but does not declare it");
                        let finite = r.psi.is_finite() && r.p.iter().chain(r.a.as_flattened()).all(|x| x.is_finite());
                        assert!(finite, "{name} at {f}: {r:?}");
                        assert!(r.psi >= 0.0, "{name} at {f}: ψ = {}", r.psi);
                    }
                    Err(LawError::Inverted { j }) => {
                        assert!(!entry.info.survives_inversion, "{name} declares to survive and refuses {f}");
                        assert!(j <= 1e-14, "{name} refuses J = {j}");
                    }
                    Err(e) => panic!("{name} at J ≤ 0: {e}"),
                }
            }
        }
        let nan = law.eval(&d(f64::NAN, 1.0, 1.0), Want::Energy);
        assert!(nan.is_err() || nan.is_ok_and(|r| r.psi.is_nan()), "{name} hides a NaN");
    }
}

/// A law is its name and the values of its parameters: building it from them gives the same law.
#[test]
fn values_rebuild_the_law() {
    over_laws(10, |label, law, f, _, _| {
        let entry = registry::find(law.info().name).expect("it came from the registry");
        let again = entry.build_with(&law.values(), &law.choices()).expect("the values are inside their bounds");
        assert_eq!((again.values(), again.choices()), (law.values(), law.choices()), "{label}");
        assert_eq!(eval(law, f).p, eval(again.as_ref(), f).p, "{label}");
    });
}

#[test]
fn names_are_unique() {
    let mut names: Vec<_> = LAWS.iter().map(|e| e.info.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), LAWS.len());
    for entry in LAWS {
        let i = entry.info;
        assert!(!i.formula.is_empty() && !i.source.is_empty() && !i.limits.is_empty() && !i.parameters.is_empty());
    }
}
