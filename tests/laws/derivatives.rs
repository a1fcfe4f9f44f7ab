//! Every law of the registry has every property that the library can check; special and limiting cases of single laws.

use durometer::material::check::check_property;
use durometer::material::draws::{gradient, rotation};
use durometer::material::{LAWS, Law, LawError, LawProperty, Moduli, Response, Want, registry};
use durometer::math::random::SplitMix;
use durometer::math::tensor::{Mat3, Vec3};

#[test]
fn every_law_has_every_property() {
    for entry in LAWS {
        for property in LawProperty::ALL {
            check_property(entry, property).unwrap_or_else(|e| panic!("{e}"));
        }
    }
}

fn eval(law: &dyn Law, f: &Mat3) -> Response {
    law.eval(f, Want::Tangent).expect("the state is inside the domain of the law")
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
    let mut random = SplitMix(13);
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
        let f = rotation(&mut random) * Mat3::from_diagonal(&Vec3::from(s)) * rotation(&mut random);
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
    let mut draw = SplitMix(14);
    for _ in 0..50 {
        check([0, 1, 2].map(|_| 0.3 * 10_f64.powf(draw.between(0.0, 1.0))));
    }
}

/// At a small strain of the size 1e-7 the energies of both methods still agree to their last digits, far below ‖H‖³.
#[test]
fn small_energies_of_both_methods_agree() {
    let mut random = SplitMix(15);
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
    let mut random = SplitMix(16);
    for _ in 0..50 {
        let f = gradient(&mut random, false).0;
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
    let mut random = SplitMix(17);
    for _ in 0..20 {
        let f = gradient(&mut random, false).0;
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

#[test]
fn only_the_linear_law_is_not_objective() {
    let not: Vec<_> = LAWS.iter().filter(|e| !e.info.objective).map(|e| e.info.name).collect();
    assert_eq!(not, ["linear"]);
}

#[test]
fn names_are_unique() {
    let mut names: Vec<_> = LAWS.iter().map(|e| e.info.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), LAWS.len());
}
