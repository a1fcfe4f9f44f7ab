//! Ranges that end earlier, in compression as in tension.

use crate::common::made::table;
use durometer::calibrate::{FitOptions, Mode, Sample, SlackChoice, fit_experiment};

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
