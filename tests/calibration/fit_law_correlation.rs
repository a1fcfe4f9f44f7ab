//! The correlation of the constants in a law file.

use crate::common::Random;
use crate::common::made::table;
use durometer::calibrate::{FitOptions, FitResult, Mode, Sample, SlackChoice, correlation_of, fit_experiment};

/// Two constants of Mooney from one curve with noise.
fn fitted(accuracy: Option<&str>) -> FitResult {
    let mut random = Random::seed(7);
    let row = |k: u64| {
        let l: f64 = 1.02 + 0.01 * k as f64;
        let stress = 2.0 * (40e3 + 10e3 / l) * (l - l.powi(-2)) + 500.0 * random.normal();
        Sample { mode: Mode::Uniaxial, stretch: l, second: 1.0, stress, line: k + 2, specimen: 0 }
    };
    let samples = (0..100).map(row).collect();
    let mut o = FitOptions::new("mooney_rivlin");
    (o.modes, o.slack, o.ranges) = (vec![Mode::Uniaxial], SlackChoice::No, 0);
    o.accuracy = accuracy.map(|text| text.parse().expect("valid")).unwrap_or_default();
    fit_experiment(&table(samples), &o).expect("fits")
}

/// The scatter of one curve determines the sum of both constants far better than each, and a scale of the stress moves both in proportion: the correlation falls from near −1 with the size of
/// the scale, by Σ = C + θθᵀσ².
#[test]
fn the_law_file_has_the_correlation_of_its_constants() {
    let (plain, scaled) = (fitted(None), fitted(Some("stress_scale=20%")));
    let read = |r: &FitResult| {
        let law: toml::Table = r.law_text().parse().expect("TOML");
        let provenance = law["provenance"].as_table().expect("a table").clone();
        assert_eq!(correlation_of(&provenance, "C10", "C01"), correlation_of(&provenance, "C01", "C10"));
        assert_eq!(correlation_of(&provenance, "C10", "C20"), 0.0);
        correlation_of(&provenance, "C10", "C01")
    };
    let of = |c: [[f64; 2]; 2]| c[0][1] / (c[0][0] * c[1][1]).sqrt();
    let c = |a: usize, b: usize| plain.covariance[a][b];
    let own = [[c(0, 0), c(0, 1)], [c(1, 0), c(1, 1)]];
    assert!((read(&plain) - of(own)).abs() < 1e-9 && read(&plain) < -0.9, "{} {}", read(&plain), of(own));
    // A half-width of 20 % is a standard deviation of 10.2 %
    let theta = [0, 1].map(|k| scaled.parameters[k].value * 0.2 / 1.959_963_984_540_054);
    let total = [0, 1].map(|a| [0, 1].map(|b| scaled.covariance[a][b] + theta[a] * theta[b]));
    assert!((read(&scaled) - of(total)).abs() < 1e-6, "{} {}", read(&scaled), of(total));
    assert!(read(&scaled) > read(&plain) + 0.1, "{} {}", read(&scaled), read(&plain));
}
