//! The correlation of the constants in a law file.

use crate::common::Random;
use crate::common::made::table;
use durometer::calibrate::{FitOptions, FitResult, Mode, Sample, SlackChoice, correlation_of, fit_experiment};

/// Two constants of Mooney from one curve with noise.
fn fitted(accuracy: Option<&str>) -> FitResult {
    of_specimens(1, accuracy)
}

/// The same of specimens, each with constants of its own.
fn of_specimens(count: usize, accuracy: Option<&str>) -> FitResult {
    let mut random = Random::seed(7);
    let mut samples = vec![];
    for specimen in 0..count {
        let scatter = |random: &mut Random| if count > 1 { 1.0 + 0.1 * random.normal() } else { 1.0 };
        let (c10, c01) = (40e3 * scatter(&mut random), 10e3 * scatter(&mut random));
        samples.extend((0..100).map(|k: u64| {
            let l: f64 = 1.02 + 0.01 * k as f64;
            let stress = 2.0 * (c10 + c01 / l) * (l - l.powi(-2)) + 500.0 * random.normal();
            Sample { mode: Mode::Uniaxial, stretch: l, second: 1.0, stress, line: k + 2, specimen }
        }));
    }
    let mut o = FitOptions::new("mooney_rivlin");
    (o.modes, o.slack, o.ranges) = (vec![Mode::Uniaxial], SlackChoice::No, 0);
    o.accuracy = accuracy.map(|text| text.parse().expect("valid")).unwrap_or_default();
    let mut e = table(samples);
    e.specimens = (0..count).map(|k| format!("{k}.csv")).collect();
    fit_experiment(&e, &o).expect("fits")
}

/// Correlation of both constants in the law file.
fn read(r: &FitResult) -> f64 {
    let law: toml::Table = r.law_text().parse().expect("TOML");
    let provenance = law["provenance"].as_table().expect("a table").clone();
    assert_eq!(correlation_of(&provenance, "C10", "C01"), correlation_of(&provenance, "C01", "C10"));
    assert_eq!(correlation_of(&provenance, "C10", "C20"), 0.0);
    correlation_of(&provenance, "C10", "C01")
}

fn of(c: [[f64; 2]; 2]) -> f64 {
    c[0][1] / (c[0][0] * c[1][1]).sqrt()
}

fn half_width(r: &FitResult, k: usize) -> f64 {
    let [low, high] = r.parameters[k].interval;
    0.5 * (high - low)
}

/// Squared half-widths of both constants and their products, by the scatter and by a scale of 20 %.
fn total(plain: &FitResult, scaled: &FitResult) -> [[f64; 2]; 2] {
    let t = half_width(plain, 0) / plain.covariance[0][0].sqrt();
    let by_scale = [0, 1].map(|k| scaled.parameters[k].value * 0.2);
    [0, 1].map(|a| [0, 1].map(|b| t * t * plain.covariance[a][b] + by_scale[a] * by_scale[b]))
}

/// The scatter of one curve determines the sum of both constants far better than each, and a scale of the stress moves both in proportion: the correlation falls from near −1 with the size of
/// the scale, by t²C + hhᵀ with the half-widths h = 0.2 θ.
#[test]
fn the_law_file_has_the_correlation_of_its_constants() {
    let (plain, scaled) = (fitted(None), fitted(Some("stress_scale=20%")));
    let c = |a: usize, b: usize| plain.covariance[a][b];
    let own = [[c(0, 0), c(0, 1)], [c(1, 0), c(1, 1)]];
    assert!((read(&plain) - of(own)).abs() < 1e-9 && read(&plain) < -0.9, "{} {}", read(&plain), of(own));
    assert!(
        (read(&scaled) - of(total(&plain, &scaled))).abs() < 1e-6,
        "{} {:?}",
        read(&scaled),
        total(&plain, &scaled)
    );
    assert!(read(&scaled) > read(&plain) + 0.1, "{} {}", read(&scaled), read(&plain));
}

/// Half-widths of three specimens are 4.3 standard deviations, those of a stated error 1.96: the correlation is that of the half-widths, and the variance by both is the interval squared.
#[test]
fn the_correlation_of_few_specimens_is_that_of_the_half_widths() {
    let (plain, scaled) = (of_specimens(3, None), of_specimens(3, Some("stress_scale=20%")));
    assert_eq!(plain.degrees, 2);
    let total = total(&plain, &scaled);
    for (k, row) in total.iter().enumerate() {
        let own = half_width(&scaled, k);
        assert!((row[k].sqrt() - own).abs() < 1e-6 * own, "{k}: {} {own}", row[k].sqrt());
    }
    assert!((read(&scaled) - of(total)).abs() < 1e-6, "{} {}", read(&scaled), of(total));
}
