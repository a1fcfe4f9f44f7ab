//! Ranges that are fitted, those that end earlier, and data that are held out: in compression as in tension, and of biaxial states.

use crate::common::Random;
use crate::common::made::{options, samples, table};
use durometer::calibrate::{
    FitOptions, FittableLaw, Mode, PredictionKind, Sample, SlackChoice, StretchRange, compare_experiment,
    fit_experiment,
};

/// A Mooney-Rivlin material under compression has the Neo-Hookean modulus 2(C₁₀ + C₀₁) near rest and a larger one in deep compression. A range that ends earlier has the shallow data points, whose constant is
/// Σ gP/Σ g² over them, and shorter ranges point to the smaller values.
#[test]
fn ranges_of_compression_end_at_their_deepest_data_point() {
    let (c10, c01) = (40e3, 10e3);
    let g = |l: f64| l - l.powi(-2);
    let stress = |l: f64| 2.0 * (c10 + c01 / l) * g(l);
    let row = |k: u64| {
        let stretch = 0.99 - 0.01 * k as f64;
        Sample { mode: Mode::Uniaxial, stretch, second: 1.0, stress: stress(stretch), line: k + 2, specimen: 0 }
    };
    let samples: Vec<Sample> = (0..50).map(row).collect();
    let mut o = FitOptions::new("neo_hookean");
    (o.modes, o.slack) = (vec![Mode::Uniaxial], SlackChoice::No);
    let r = fit_experiment(&table(samples.clone()), &o).expect("fits");
    let ends: Vec<f64> = r.range_dependence.iter().map(|row| row.to).collect();
    assert!(
        ends.len() > 5 && ends.windows(2).all(|w| w[1] < w[0]) && ends.last() == Some(&samples[49].stretch),
        "{ends:?}"
    );
    for row in &r.range_dependence {
        let own = samples.iter().filter(|s| s.stretch >= row.to);
        let (up, down) = own.fold((0.0, 0.0), |(u, d), s| (u + g(s.stretch) * s.stress, d + g(s.stretch).powi(2)));
        let mu = row.parameters[0].value;
        assert!((mu / (up / down) - 1.0).abs() < 1e-9, "to {}: {mu} not {}", row.to, up / down);
    }
    let (mu, [low, high]) = (r.parameters[0].value, r.range_spread[0]);
    assert!(low <= mu && high == mu, "{low} to {high}, {mu}");
}

/// Data that begin late have a hold-out, the last third of their own ln λ, in tension and compression: the Neo-Hookean modulus of the others is Σ gP/Σ g². Of two data points there is none, which is said.
#[test]
fn data_that_begin_late_have_a_hold_out() {
    let law = FittableLaw::new("yeoh", Some(2)).expect("registered");
    let ask = |ends: [f64; 2], count: u32| {
        let mut noise = Random::seed(7);
        let rows = samples(law, &[5e4, 2e3], &[Mode::Uniaxial], ends, count, |p| p + 200.0 * noise.normal());
        let table = compare_experiment(&table(rows.clone()), &options(law, &[Mode::Uniaxial])).expect("compares");
        let found = table.laws.iter().find(|c| c.law == "neo_hookean").expect("listed").hold_out;
        (rows, found, table.to_string())
    };
    for ends in [[2.2, 3.0], [0.5, 0.4]] {
        let (rows, found, said) = ask(ends, 60);
        // Evenly spread ln λ: the first 40 of 60 are within two thirds of it
        let (near, far) = rows.split_at(40);
        let g = |s: &Sample| s.stretch - s.stretch.powi(-2);
        let sum = |own: &[Sample], of: &dyn Fn(&Sample) -> f64| own.iter().map(of).sum::<f64>();
        let mu = sum(near, &|s| g(s) * s.stress) / sum(near, &|s| g(s).powi(2));
        let left = sum(far, &|s| (s.stress - mu * g(s)).powi(2)) / sum(far, &|s| s.stress.powi(2));
        let found = found.unwrap_or_else(|| panic!("{said}"));
        assert!((found / left.sqrt() - 1.0).abs() < 1e-9 && !said.contains("no law has a hold-out"), "{found} {said}");
    }
    let (_, found, said) = ask([1.2, 2.0], 2);
    assert!(found.is_none() && said.contains("no law has a hold-out"), "{said}");
}

/// A biaxial state has two stresses, which a range and a hold-out take together: the state is as far as its larger stretch. Independent: the Neo-Hookean modulus is Σ gP/Σ g² over
/// the states that are fitted, with g = λ − λ⁻³λ₂⁻².
#[test]
fn a_range_takes_both_stresses_of_a_biaxial_state() {
    let g = |l: f64, other: f64| l - l.powi(-3) * other.powi(-2);
    let stress = |l: f64, other: f64| {
        let i1 = l * l + other * other + (l * other).powi(-2) - 3.0;
        (60e3 + 2e3 * i1) * g(l, other)
    };
    let row = |(stretch, second): (f64, f64), line: u64| {
        let stress = stress(stretch, second);
        Sample { mode: Mode::Biaxial, stretch, second, stress, line, specimen: 0 }
    };
    let states = (0..26_u64).flat_map(|k| [1.0, 1.2].map(|second| (1.05 + 0.098 * k as f64, second)));
    let samples: Vec<Sample> =
        states.zip(2..).flat_map(|((a, b), line)| [row((a, b), line), row((b, a), line)]).collect();
    let experiment = table(samples.clone());
    let mut o = FitOptions::new("neo_hookean");
    (o.modes, o.slack) = (vec![Mode::Biaxial], SlackChoice::No);
    let modulus = |own: &[&Sample]| {
        let sum = |f: &dyn Fn(&Sample) -> f64| own.iter().map(|s| f(s)).sum::<f64>();
        sum(&|s| g(s.stretch, s.second) * s.stress) / sum(&|s| g(s.stretch, s.second).powi(2))
    };
    let largest = |s: &&Sample| s.stretch.max(s.second);

    o.range = Some(StretchRange { from: 1.0, to: 1.5 });
    let r = fit_experiment(&experiment, &o).expect("fits");
    let inside: Vec<&Sample> = samples.iter().filter(|s| largest(s) <= 1.5).collect();
    assert_eq!((r.rows, inside.len() % 2), (inside.len(), 0));
    assert!((r.parameters[0].value / modulus(&inside) - 1.0).abs() < 1e-9, "{}", r.parameters[0].value);
    let outside = r.predictions.iter().find(|p| p.kind == PredictionKind::OutsideRange).expect("states beyond");
    assert_eq!(outside.misfit.rows, samples.len() - inside.len());
    assert!(r.range_dependence.iter().all(|row| row.rows % 2 == 0), "{:?}", r.range_dependence);

    o.range = None;
    let table = compare_experiment(&experiment, &o).expect("compares");
    let hold_out = table.laws.iter().find(|c| c.law == "neo_hookean").and_then(|c| c.hold_out).expect("data points");
    // Two thirds of ln λ from the nearest state to the farthest one
    let end = (1.05_f64.ln() + 2.0 / 3.0 * (3.5_f64 / 1.05).ln()).exp();
    let (near, far): (Vec<&Sample>, Vec<&Sample>) = samples.iter().partition(|s| largest(s) <= end);
    let mu = modulus(&near);
    let left = far.iter().map(|s| (s.stress - mu * g(s.stretch, s.second)).powi(2)).sum::<f64>();
    let size = far.iter().map(|s| s.stress.powi(2)).sum::<f64>();
    assert!((hold_out / (left / size).sqrt() - 1.0).abs() < 1e-9, "{hold_out}, not {}", (left / size).sqrt());
}
