//! Calibration of the incompressible Neo-Hookean law: recovery, interval, units.

use crate::common::Random;
use crate::common::tables::{MU, fitted, parsed, stress, table};
use durometer::calibrate::{
    ColumnChoice, ErrorModel, Experiment, FitOptions, FitWarning, Mode, Sample, SolverCheck, fit_experiment,
};

#[test]
fn clean_data_give_the_constant_back_in_every_mode() {
    for mode in Mode::PULLED {
        let text = table(mode, "stretch,nominal stress (Pa)", 1.0);
        let e = Experiment::parse("clean.csv", text.as_bytes(), None, &ColumnChoice::default(), Some(mode));
        let r = fit_experiment(&e.expect("clean"), &FitOptions::new("neo_hookean")).expect("clean");
        let mu = &r.parameters[0];
        assert!((mu.value / MU - 1.0).abs() < 1e-10, "{mode}: {}", mu.value);
        assert!((mu.interval[1] - mu.interval[0]) / MU < 1e-9, "{mode}: {:?}", mu.interval);
        let Some(SolverCheck::Convex { relative_difference, allowed }) = r.solver_check else {
            panic!("{mode}: {:?}", r.solver_check)
        };
        assert!(relative_difference <= allowed);
        assert_eq!(r.warnings, [FitWarning::NoPartner { volumetric: false }], "{mode}");
        let to: Vec<f64> = r.validity.tests.iter().map(|t| t.to.expect("exact")).collect();
        assert!((to[0] - 2.25).abs() < 1e-12 && (to[1] - 0.8).abs() < 1e-12 && to.len() == 2, "{mode}: {to:?}");
    }
}

/// The range of trust ends where the law first fails, also if later rows, with their larger stresses, make up for it: rows
/// at 1.1, 1.2 and 1.3 are exact, those at 1.4 and 1.5 are doubled, the rest is exact again.
#[test]
fn validity_ends_at_the_first_failure() {
    let row = |k: usize| {
        let l = 1.0 + 0.1 * k as f64;
        let factor = if (4..=5).contains(&k) { 2.0 } else { 1.0 };
        format!("{l},{}\n", factor * stress(Mode::Uniaxial, l))
    };
    let r = fitted(&("stretch,nominal stress (Pa)\n".to_string() + &(1..=60).map(row).collect::<String>()));
    let whole = r.misfit.rms_relative;
    assert!(whole < 0.1, "over all rows the misfit is small: {whole}");
    assert!((r.validity.tests[0].to.expect("three exact rows") - 1.3).abs() < 1e-12, "{:?}", r.validity);
}

/// 400 tables of 12 rows with normal noise of 3 kPa. Errors that count as they are, independent and of one size, have the interval μ ± t s/√Σg² by hand with t₀.₉₇₅(11) = 2.200985, which is exact for this noise; a
/// few tables look otherwise. The coverage is binomial with standard deviation √(0.95·0.05/400) = 1.09 %: 3.3 % is three of them. The warning on a pattern in
/// the residuals has a false-alarm rate of at most 5 % by construction.
#[test]
fn the_interval_covers_the_truth_in_95_of_100_tables() {
    let mut e = parsed("stretch,nominal stress (Pa)\n1.1,1\n1.2,1\n");
    let (mut covered, mut alarms, mut independent) = (0, 0, 0);
    let tables = 400;
    for seed in 0..tables {
        let mut noise = Random::seed(0x5eed_0000 + seed);
        let sample = |k: u32| {
            let stretch = 1.05 + 0.05 * f64::from(k);
            let stress = stress(Mode::Uniaxial, stretch) + 3e3 * noise.normal();
            Sample { mode: Mode::Uniaxial, stretch, stress, line: u64::from(k) + 2, specimen: 0, second: 1.0 }
        };
        e.samples = (0..12).map(sample).collect();
        let r = fit_experiment(&e, &FitOptions { ranges: 0, ..FitOptions::new("neo_hookean") }).expect("well posed");
        let [low, high] = r.parameters[0].interval;
        if r.errors == ErrorModel::Independent {
            independent += 1;
            let g = |s: &Sample| stress(Mode::Uniaxial, s.stretch) / MU;
            let sum = |of: &dyn Fn(&Sample) -> f64| e.samples.iter().map(of).sum::<f64>();
            let g2 = sum(&|s| g(s).powi(2));
            let mu = sum(&|s| g(s) * s.stress) / g2;
            let half = 2.200_985 * (sum(&|s| (s.stress - mu * g(s)).powi(2)) / 11.0 / g2).sqrt();
            let near = |end: f64, by_hand: f64| (end - by_hand).abs() < 1e-6 * half;
            assert!(near(low, mu - half) && near(high, mu + half), "{seed}: {low} to {high}, not {mu} ± {half}");
        }
        covered += usize::from(low <= MU && MU <= high);
        alarms += usize::from(r.warnings.iter().any(|w| matches!(w, FitWarning::Systematic { .. })));
    }
    let percent = |n: usize| 100.0 * n as f64 / tables as f64;
    println!("covered {:.2} %, false alarms {:.2} %, {independent} exact", percent(covered), percent(alarms));
    assert!((percent(covered) - 95.0).abs() < 3.3 && independent >= 300, "{:.2} %, {independent}", percent(covered));
    assert!(percent(alarms) < 5.0 + 1.5, "{:.2} %", percent(alarms));
}

#[test]
fn units_change_the_unit_and_nothing_else() {
    let pa = fitted(&table(Mode::Uniaxial, "stretch,nominal stress (Pa)", 1.0));
    for (header, unit) in [
        ("stretch,nominal stress (kPa)", 1e3),
        ("stretch,nominal_stress_MPa", 1e6),
        ("stretch,eng. stress [N/mm^2]", 1e6),
        ("lambda,stress psi", 6894.757293168361),
    ] {
        let other = fitted(&table(Mode::Uniaxial, header, unit));
        assert!((other.parameters[0].value / pa.parameters[0].value - 1.0).abs() < 1e-12, "{header}");
        assert_eq!(other.rows, pa.rows);
    }
    // The same numbers in another unit: stiffness, interval and residuals scale, what has no unit stays.
    let noisy = "1.1,0.10\n1.2,0.21\n1.3,0.26\n1.5,0.39\n";
    let (mega, kilo) = (
        fitted(&format!("stretch,nominal stress (MPa)\n{noisy}")),
        fitted(&format!("stretch,nominal stress (kPa)\n{noisy}")),
    );
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} against {b}");
    let (a, b) = (&mega.parameters[0], &kilo.parameters[0]);
    close(a.value, 1e3 * b.value);
    close(a.interval[0], 1e3 * b.interval[0]);
    close(mega.misfit.rms_pa, 1e3 * kilo.misfit.rms_pa);
    close(mega.misfit.rms_relative, kilo.misfit.rms_relative);
    assert_eq!(mega.validity, kilo.validity);
}
