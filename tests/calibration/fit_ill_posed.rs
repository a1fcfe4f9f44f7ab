//! Data that cannot carry the law: too few rows, one mode, outliers, other use than fit.

use crate::common::Random;
use crate::common::made::{fitted, models, options, samples, table, truth};
use durometer::calibrate::{
    FitOptions, FitResult, FitWarning, FittableLaw, Loss, Mode, Sample, SolverCheck, StretchRange, compare_experiment,
    fit_experiment,
};
use durometer::math::statistics::larger;

/// Reference case 21b: two rows and six constants. No standard error is finite, and the directions are named.
#[test]
fn two_points_do_not_determine_ogden() {
    let model = FittableLaw::new("ogden", Some(3)).expect("registered");
    let clean = samples(model, &truth("ogden", 3), &[Mode::Uniaxial], [1.3, 1.9], 2, |p| p);
    let r = fitted(model, &[Mode::Uniaxial], clean);
    assert!(!r.is_determined() && r.parameters.iter().all(|e| e.std_error.is_infinite()), "{:?}", r.parameters);
    assert!(r.unidentified.len() >= 4, "two rows see two directions of six: {:?}", r.unidentified);
    let words: String = r.warnings.iter().map(|w| format!("{w}\n")).collect();
    assert!(words.contains("unidentifiable: the data are insensitive to") && words.contains("α"), "{words}");
}

/// Strains of rounding are refused before any solver sees them; those that a machine may resolve are fitted.
#[test]
fn strains_of_rounding_are_refused() {
    for law in ["neo_hookean", "mooney_rivlin", "ogden"] {
        let model = FittableLaw::new(law, None).expect("registered");
        let of = |largest: f64| {
            let rows = (1..40).map(|k| 1.0 + largest * f64::from(k) / 39.0);
            let rows = rows.map(|stretch| Sample {
                mode: Mode::Uniaxial,
                second: 1.0,
                stretch,
                stress: 1e5 * (stretch - stretch.powi(-2)),
                line: 2,
                specimen: 0,
            });
            fit_experiment(&table(rows.collect()), &options(model, &[Mode::Uniaxial]))
        };
        let error = of(4e-8).expect_err("no strain").to_string();
        assert!(error.contains("the largest strain is 4.000e-8, below 1e-6") && error.contains("its unit"), "{error}");
        assert!(of(1e-4).is_ok(), "{law}");
    }
}

/// Planar tests see C10 + C01 alone (I₁ = I₂): the direction and what is determined are named.
#[test]
fn planar_tests_see_the_sum_of_mooney_rivlin() {
    let model = FittableLaw::new("mooney_rivlin", Some(2)).expect("registered");
    let clean = samples(model, &[0.1e6, 0.1e6], &[Mode::Planar], [1.05, 2.0], 12, |p| p);
    let r = fitted(model, &[Mode::Planar], clean);
    assert!(r.parameters.iter().all(|e| e.std_error.is_infinite()));
    let [d] = &r.unidentified[..] else { panic!("{:?}", r.unidentified) };
    assert_eq!((d.half_width, d.known.as_deref()), (None, Some("C10 + 1.000 C01")));
    let sum: f64 = r.parameters.iter().map(|e| e.value).sum();
    assert!((sum / 0.2e6 - 1.0).abs() < 1e-9, "the sum is determined: {sum}");
}

/// Reference case 21c: 5 % of the rows ten times too large. Huber's loss keeps the constants within 2 %, squares do not, and say which
/// rows pull.
#[test]
fn outliers_pull_at_squares_and_not_at_huber() {
    let model = FittableLaw::new("yeoh", Some(2)).expect("registered");
    let values = [0.17e6, 4e3];
    let mut noise = Random::seed(5);
    let mut rows = samples(model, &values, &[Mode::Uniaxial], [1.05, 2.5], 100, |p| p * (1.0 + 0.005 * noise.normal()));
    let wrong: Vec<usize> = (0..5).map(|k| 7 + 20 * k).collect();
    wrong.iter().for_each(|k| rows[*k].stress *= 10.0);
    let e = table(rows);
    let mut o = options(model, &[Mode::Uniaxial]);
    let squares = fit_experiment(&e, &o).expect("fits");
    let lines: Vec<u64> = wrong.iter().map(|k| *k as u64 + 2).collect();
    let named = |w: &FitWarning| matches!(w, FitWarning::Outliers { lines: found, .. } if *found == lines);
    assert!(squares.warnings.iter().any(named), "{:?}", squares.warnings);
    o.loss = Loss::Huber;
    let huber = fit_experiment(&e, &o).expect("fits");
    let limited = |w: &FitWarning| matches!(w, FitWarning::LimitedOutliers { lines: found, .. } if *found == lines);
    assert!(huber.warnings.iter().any(limited) && !huber.warnings.iter().any(named), "{:?}", huber.warnings);
    let said = huber.to_string();
    assert!(
        said.contains("note: data points far from their neighbours have a limited weight") && said.contains("(5 of ")
    );
    let off = |r: &FitResult| r.parameters.iter().zip(values).map(|(e, t)| (e.value / t - 1.0).abs()).fold(0.0, larger);
    assert!(off(&huber) < 0.02 && off(&squares) > 0.1, "{} and {}", off(&huber), off(&squares));
}

/// Compression to λ = 0.4 has principal stretches of 0.4 and 0.4^-½ = 1.58. A law that loses its stability between 1.58 and 2.5 in equibiaxial tension is stable where it was fitted: no warning says
/// otherwise, and a comparison does not rank it among the unstable ones.
#[test]
fn compression_reaches_its_principal_stretches() {
    let model = FittableLaw::new("yeoh", Some(2)).expect("registered");
    let compressed = |values: &[f64]| table(samples(model, values, &[Mode::Uniaxial], [0.99, 0.4], 40, |p| p));
    let o = options(model, &[Mode::Uniaxial]);
    let values = [20e3, -1e3];
    let r = fit_experiment(&compressed(&values), &o).expect("fits");
    assert!((r.parameters[1].value / values[1] - 1.0).abs() < 1e-6, "nothing holds it back: {r}");
    let above = r.stability.iter().find(|s| s.mode == Mode::Equibiaxial).and_then(|s| s.above).expect("softens");
    let unstable = r.warnings.iter().any(|w| matches!(w, FitWarning::Unstable { .. }));
    assert!(1.59 < above && above < 2.5 && !unstable, "{above}: {:?}", r.warnings);
    let all = compare_experiment(&compressed(&values), &o).expect("compares");
    let yeoh = all.laws.iter().find(|c| c.law == "yeoh" && c.terms == 2).expect("listed");
    assert!(yeoh.lost.is_empty(), "{all}");
}

/// Reference case 21e: uniaxial data that give C01 < 0. The law is kept stable where it was fitted, the loss in equibiaxial tension is
/// warned of at the stretch at which C10, C01 lose it, and --stable removes it.
#[test]
fn uniaxial_data_warn_of_biaxial_use() {
    let model = FittableLaw::new("mooney_rivlin", Some(2)).expect("registered");
    let (c10, c01) = (0.2e6, -0.03e6);
    let e = table(samples(model, &[c10, c01], &[Mode::Uniaxial], [1.02, 2.0], 30, |p| p));
    let mut o = options(model, &[Mode::Uniaxial]);
    let r = fit_experiment(&e, &o).expect("fits");
    assert!((r.parameters[1].value / c01 - 1.0).abs() < 1e-6, "stable in tension, nothing holds it back");
    let lost = r.warnings.iter().find_map(|w| match w {
        FitWarning::Unstable { lost, .. } => {
            lost.iter().find(|(mode, _)| *mode == Mode::Equibiaxial).map(|(_, at)| *at)
        }
        _ => None,
    });
    // Independent: the largest Cauchy stress (λ² − λ⁻⁴)(C10 + C01λ²) in equibiaxial tension
    let tau = |l: f64| (l * l - l.powi(-4)) * (c10 + c01 * l * l);
    let peak = (0..20_000).map(|k| 1.0 + 1e-4 * f64::from(k)).max_by(|a, b| tau(*a).total_cmp(&tau(*b))).expect("some");
    let at = lost.unwrap_or_else(|| panic!("no warning: {:?}", r.warnings));
    assert!((at / peak - 1.0).abs() < 1e-3, "{at}, not {peak}");
    assert!(r.warnings.iter().any(|w| matches!(w, FitWarning::OneMode { .. })));
    o.stable = Some(StretchRange { from: 0.5, to: 2.0 });
    let kept = fit_experiment(&e, &o).expect("fits");
    assert_eq!(kept.solver_check, Some(SolverCheck::Constrained));
    assert!(kept.warnings.iter().any(|w| matches!(w, FitWarning::Held { mode: Mode::Equibiaxial, .. })));
    let unstable = |w: &FitWarning| matches!(w, FitWarning::Unstable { .. });
    assert!(!kept.warnings.iter().any(unstable), "{:?}", kept.warnings);
    assert!(kept.misfit.rms_relative > r.misfit.rms_relative && kept.parameters[1].value > c01);
}

/// Reference case 21g: three terms stay three. No two exponents are alike and no factor is zero.
#[test]
fn three_ogden_terms_do_not_collapse() {
    let model = FittableLaw::new("ogden", Some(3)).expect("registered");
    let clean = samples(model, &truth("ogden", 3), &[Mode::Uniaxial], [1.05, 7.0], 30, |p| p);
    let r = fitted(model, &[Mode::Uniaxial], clean);
    let alpha: Vec<f64> = r.parameters.iter().skip(1).step_by(2).map(|e| e.value).collect();
    for (a, b) in [(0, 1), (0, 2), (1, 2)] {
        assert!((alpha[a] - alpha[b]).abs() > 0.5, "{alpha:?}");
    }
    assert!(r.parameters.iter().all(|e| e.value != 0.0) && r.misfit.rms_relative < 1e-6, "{}", r.misfit.rms_relative);
}

#[test]
fn terms_and_volumetric_parts_are_checked() {
    let e = table(samples(models()[0], &[0.3e6], &[Mode::Uniaxial], [1.1, 2.0], 9, |p| p));
    let refuse = |law: &str, terms: Option<usize>, volumetric: Option<&str>| {
        let mut o = FitOptions::new(law);
        (o.terms, o.volumetric) = (terms, volumetric.map(Into::into));
        fit_experiment(&e, &o).expect_err("must be refused").to_string()
    };
    assert!(refuse("mooney_rivlin", Some(4), None).contains("4 terms; pass --terms with one of 2, 3, 5"));
    assert!(refuse("gent", None, Some("cubic")).contains("take one of quadratic, logarithmic"));
    assert!(refuse("neo_hookean", None, Some("quadratic")).contains("omit it"));
}

/// A Neo-Hookean rubber with noise, fitted by Yeoh's three constants: C30 is zero, and its 95 % interval says so in 38 of 40 tables, give or
/// take 4√(40·0.95·0.05) = 5.5. C10 of the same fit and μ of the right law are never named.
#[test]
fn constants_that_may_be_zero_are_named() {
    let model = |law: &str| FittableLaw::new(law, None).expect("registered");
    let named = |law: &str, seed: u64| {
        let mut noise = Random::seed(seed);
        let rows =
            samples(model("neo_hookean"), &[0.3e6], &[Mode::Uniaxial], [1.05, 2.0], 40, |p| p + 5e3 * noise.normal());
        let warnings = fitted(model(law), &[Mode::Uniaxial], rows).warnings;
        let found = warnings.into_iter().find_map(|w| match w {
            FitWarning::MayBeZero { symbols } => Some(symbols),
            _ => None,
        });
        found.unwrap_or_default()
    };
    assert!((0..5).all(|seed| named("neo_hookean", seed).is_empty()));
    let yeoh: Vec<_> = (0..40).map(|seed| named("yeoh", seed)).collect();
    assert!(yeoh.iter().all(|n| !n.contains(&"C10")));
    let count = yeoh.iter().filter(|n| n.contains(&"C30")).count();
    assert!(count >= 32, "{count} of 40: {yeoh:?}");
}

/// A wild data point in one of two specimens drives the Gent law to its end there; no other data point sees the constants. The fit says so.
#[test]
fn a_wild_data_point_of_a_specimen_is_no_panic() {
    let model = FittableLaw::new("gent", None).expect("registered");
    let mut rows = vec![];
    for specimen in 0..2 {
        let of = samples(model, &[0.1e6, 80.0], &[Mode::Uniaxial], [1.1, 1.5], 5, |p| p);
        rows.extend(of.into_iter().map(|s| Sample { specimen, ..s }));
    }
    rows[9].stress = 1.4e13;
    let mut e = table(rows);
    e.specimens = ["a.csv", "b.csv"].map(String::from).to_vec();
    let r = fit_experiment(&e, &options(model, &[Mode::Uniaxial])).expect("fitted");
    assert!(!r.is_determined() && !r.warnings.is_empty(), "{r}");
}

/// Planar tests and simple shear have the same stresses with α and −α, μ and −μ: with noise and without it the fit names the constants, has both signs in their intervals and counts them as not
/// determined; one more mode decides. Equibiaxial tests tell the signs apart.
#[test]
fn the_sign_of_terms_is_open_in_planar_tests() {
    let model = |terms: usize| FittableLaw::new("ogden", Some(terms)).expect("registered");
    let one: &[f64] = &[0.3e6, 1.8];
    let two: &[f64] = &[0.4e6, 1.3, 2e3, 5.0];
    let fit = |values: &[f64], modes: &[Mode], end: f64, noise: f64, seed: u64| {
        let (model, mut random) = (model(values.len() / 2), Random::seed(seed));
        let size = noise * model.stress(values, Mode::Planar, end).abs();
        let rows = samples(model, values, modes, [1.02, end], 40, |p| p + size * random.normal());
        fit_experiment(&table(rows), &options(model, modes)).expect("fits")
    };
    let open = |r: &FitResult| r.warnings.iter().any(|w| matches!(w, FitWarning::OpenSigns { .. }));
    for (values, modes, end, noise) in [
        (one, &[Mode::Planar][..], 3.0, 0.01),
        (one, &[Mode::Planar], 3.0, 0.0),
        (one, &[Mode::SimpleShear], 2.0, 0.01),
        (one, &[Mode::Planar, Mode::SimpleShear], 2.0, 0.01),
        (two, &[Mode::Planar], 6.0, 0.002),
    ] {
        for seed in 1..5 {
            let r = fit(values, modes, end, noise, seed);
            assert!(open(&r) && !r.is_determined() && r.open_signs.len() == values.len(), "{r}");
            for (e, truth) in r.parameters.iter().zip(values) {
                let [low, high] = e.interval;
                assert!(e.value > 0.0 && low == -high && high >= e.value, "{} {truth}: {e:?}", e.symbol);
            }
            let said = r.to_string();
            assert!(said.contains("the sign of μ₁, α₁") && said.contains("Add modes: a test in "), "{said}");
            let other = |w: &FitWarning| matches!(w, FitWarning::MayBeZero { .. });
            assert!(values.len() > 2 || !r.warnings.iter().any(other), "{said}");
        }
    }
    for modes in [&[Mode::Equibiaxial][..], &[Mode::Uniaxial, Mode::Planar]] {
        let r = fit(one, modes, 3.0, 0.01, 1);
        let [low, high] = r.parameters[1].interval;
        assert!(!open(&r) && r.is_determined() && low > 1.5 && high < 2.1, "{r}");
    }
    // The data of a term of the other sign are those of the positive one
    let r = fit(&[-0.3e6, -1.8], &[Mode::Planar], 3.0, 0.0, 1);
    assert!((r.parameters[1].value - 1.8).abs() < 1e-6 && open(&r), "{r}");
}
