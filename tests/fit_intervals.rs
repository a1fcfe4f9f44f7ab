//! Intervals of a fit in addition to the covariance: profile likelihood and the bootstrap, against closed forms and coverage.

mod common;

use common::Random;
use durometer::calibrate::{
    ColumnChoice, Drawn, Experiment, FitOptions, FitRequest, FitResult, FitWarning, Mode, Model, Sample, fit,
    fit_experiment,
};
use rayon::prelude::*;

/// A table of uniaxial rows at evenly spread λ with these errors [Pa].
fn table(model: Model, values: &[f64], [low, high]: [f64; 2], errors: &[f64]) -> Experiment {
    let text = b"stretch,nominal stress (Pa)\n1.1,1\n1.2,1\n";
    let mut e =
        Experiment::parse("made.csv", text, None, &ColumnChoice::default(), Some(Mode::Uniaxial)).expect("valid");
    let sample = |(k, error): (usize, &f64)| {
        let stretch = low + (high - low) * k as f64 / (errors.len() - 1) as f64;
        let stress = model.stress(values, Mode::Uniaxial, stretch) + error;
        Sample { mode: Mode::Uniaxial, stretch, stress, line: k as u64 + 2, specimen: 0, second: 1.0 }
    };
    e.samples = errors.iter().enumerate().map(sample).collect();
    e
}

fn fitted(e: &Experiment, model: Model, bootstrap: usize) -> FitResult {
    let mut o = FitOptions::new(model.name());
    (o.terms, o.bootstrap) = (Some(model.terms), bootstrap);
    fit_experiment(e, &o).unwrap_or_else(|e| panic!("{}: {e}", model.label()))
}

fn white(seed: u64, n: usize, size: f64) -> Vec<f64> {
    let mut noise = Random(seed);
    (0..n).map(|_| size * noise.normal()).collect()
}

/// eₖ = 0.9 eₖ₋₁ + √(1 − 0.81) zₖ: variance 1, correlated over ten rows.
fn correlated(seed: u64, n: usize, size: f64) -> Vec<f64> {
    let mut noise = Random(seed);
    let mut e = noise.normal();
    let next = |_| {
        e = 0.9 * e + 0.19_f64.sqrt() * noise.normal();
        size * e
    };
    (0..n).map(next).collect()
}

/// Of a law that is linear in its constants S is a parabola: both intervals are the same. The end is found to 1e-6 of √(S − Ŝ), and with it
/// to 1e-6 of the width.
#[test]
fn the_profile_of_a_linear_law_is_the_covariance() {
    for (law, terms, values) in
        [("neo_hookean", 1, vec![0.3e6]), ("yeoh", 3, vec![0.17e6, -1.8e3, 40.0]), ("mooney_rivlin", 2, vec![1e5, 5e4])]
    {
        let model = Model::new(law, Some(terms)).expect("registered");
        let r = fitted(&table(model, &values, [1.05, 3.5], &white(3, 40, 2e3)), model, 0);
        for (e, p) in r.parameters.iter().zip(r.profile.as_ref().expect("nothing holds it back")) {
            let width = e.interval[1] - e.interval[0];
            for (a, b) in e.interval.iter().zip(p) {
                assert!((a - b).abs() < 1e-5 * width, "{law} {}: {:?} {p:?}", e.symbol, e.interval);
            }
        }
    }
}

/// Gent, by another way: with J_m fixed μ is a quotient of two sums. S at both ends of J_m is Ŝ(1 + t²/(n − p)), t₀.₉₇₅(38) = 2.02439 as
/// tabulated. The interval is skewed: J_m is seen less the larger it is.
#[test]
fn the_profile_of_gent_ends_where_the_likelihood_says() {
    let model = Model::new("gent", None).expect("registered");
    let e = table(model, &[0.3e6, 60.0], [1.05, 5.0], &white(11, 40, 1e4));
    let r = fitted(&e, model, 0);
    let square = |jm: f64| {
        let rows: Vec<(f64, f64)> =
            e.samples.iter().map(|s| (model.stress(&[1.0, jm], Mode::Uniaxial, s.stretch), s.stress)).collect();
        let mu = rows.iter().map(|(a, b)| a * b).sum::<f64>() / rows.iter().map(|(a, _)| a * a).sum::<f64>();
        rows.iter().map(|(a, b)| (b - mu * a).powi(2)).sum::<f64>()
    };
    let (jm, least) = (r.parameters[1].value, square(r.parameters[1].value));
    let [low, high] = r.profile.as_ref().expect("free")[1];
    for end in [low, high] {
        let ratio = (square(end) / least - 1.0) * 38.0 / 2.02439_f64.powi(2);
        // t to six digits, √ratio to 1e-6
        assert!((ratio - 1.0).abs() < 2e-5, "{end}: {ratio}");
    }
    assert!(high - jm > 1.02 * (jm - low), "{low} {jm} {high}");
}

/// Rows that soften show no upturn: J_m may grow without end, which a symmetric interval cannot say.
#[test]
fn a_constant_without_a_limit_has_an_open_profile() {
    let model = Model::new("gent", None).expect("registered");
    let e = table(model, &[0.3e6, 400.0], [1.05, 2.0], &white(2, 40, 3e4));
    let r = fitted(&e, model, 0);
    let [low, high] = r.profile.as_ref().expect("free")[1];
    assert!(high == f64::INFINITY && low > 0.0, "{low} {high}");
    let folder = tempfile::tempdir().expect("a temporary folder");
    r.write_json(&folder.path().join("fit.json")).expect("writable");
    durometer::report::fit::write(folder.path()).expect("a report");
    let csv = std::fs::read_to_string(folder.path().join("tables/intervals.csv")).expect("the table");
    assert!(csv.contains("to open"), "{csv}");
}

/// Uncorrelated rows are drawn one by one; the deviation is the sandwich √Σg²r²/Σg² (White, Econometrica 48, 1980). 2000 samples know it
/// to 1/√4000 = 1.6 %, three times that is 5 %; the terms of order 1/n that the sandwich leaves away are 1/100 here.
#[test]
fn the_bootstrap_of_independent_rows_is_the_sandwich() {
    let model = Model::new("neo_hookean", None).expect("registered");
    let r = fitted(&table(model, &[0.3e6], [1.05, 2.5], &white(5, 100, 5e3)), model, 2000);
    let b = r.bootstrap.as_ref().expect("asked for");
    assert_eq!((b.samples, b.failed, &b.drawn), (2000, 0, &Drawn::Rows { block: 1 }));
    let g = |l: f64| l - 1.0 / (l * l);
    let top: f64 = r.residuals.iter().map(|x| (g(x.stretch) * x.residual).powi(2)).sum();
    let sandwich = top.sqrt() / r.residuals.iter().map(|x| g(x.stretch).powi(2)).sum::<f64>();
    assert!((b.std_errors[0] / sandwich - 1.0).abs() < 0.06, "{} {sandwich}", b.std_errors[0]);
    let (low, high) = (r.parameters[0].value - 1.96 * sandwich, r.parameters[0].value + 1.96 * sandwich);
    // Percentiles of 2000 normal numbers scatter by 0.06 σ
    for (a, e) in b.intervals[0].iter().zip([low, high]) {
        assert!((a - e).abs() < 0.25 * sandwich, "{:?} not {low} {high}", b.intervals);
    }
}

/// 200 tables of 200 rows with errors correlated over ten rows. The covariance takes every row for news; blocks do not.
/// Measured: 59 and 150 of 200, with a standard deviation of at most 7; the bounds are 2.8 of them off. The stiffest quarter of the rows
/// carries μ, five independent rows or so: no percentile makes up for that. About two seconds.
#[test]
fn blocks_know_of_correlated_rows() {
    let model = Model::new("neo_hookean", None).expect("registered");
    let hit = |seed: u64| {
        let r = fitted(&table(model, &[0.3e6], [1.05, 3.0], &correlated(seed, 200, 5e3)), model, 200);
        let holds = |[low, high]: [f64; 2]| u32::from(low <= 0.3e6 && 0.3e6 <= high);
        let b = r.bootstrap.as_ref().expect("asked for");
        let narrow = u32::from(r.warnings.iter().any(|w| matches!(w, FitWarning::Narrow { .. })));
        [holds(r.parameters[0].interval), holds(b.intervals[0]), narrow]
    };
    let add = |a: [u32; 3], b: [u32; 3]| [0, 1, 2].map(|k| a[k] + b[k]);
    let [covariance, blocks, narrow] = (0..200).into_par_iter().map(hit).reduce(|| [0; 3], add);
    println!("covered: covariance {covariance}, blocks {blocks} of 200; warned {narrow}");
    assert!(covariance < 80 && blocks > 130 && narrow > 160, "{covariance} {blocks} {narrow}");
}

/// Every sample has its own seed: one thread and two give the same bits. Too few samples make no percentile.
#[test]
fn the_bootstrap_does_not_depend_on_threads() {
    let model = Model::new("ogden", Some(2)).expect("registered");
    let e = table(model, &[0.3e6, 1.5, 2e3, 5.0], [1.05, 4.0], &correlated(9, 60, 4e3));
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| fitted(&e, model, 60))
    };
    let (one, two) = (on(1), on(2));
    assert!(one.bootstrap.is_some() && one.profile.is_some());
    assert_eq!((one.bootstrap, one.profile), (two.bootstrap, two.profile));
    assert!(fitted(&e, model, 20).bootstrap.is_none());
}

/// Five specimens whose stiffness scatters by 3 %, the last one 40 % stiffer. Each constant alone is Σ gP/Σg² of its rows; mean, deviation
/// and t₀.₉₇₅(4) = 2.776 by hand.
#[test]
fn specimens_scatter_and_one_is_an_outlier() {
    let model = Model::new("neo_hookean", None).expect("registered");
    let moduli = [0.297e6, 0.309e6, 0.3e6, 0.294e6, 0.42e6];
    let folder = tempfile::tempdir().expect("a temporary folder");
    let files: Vec<_> = (0..5).map(|k| folder.path().join(format!("{}.csv", ["a", "b", "c", "d", "e"][k]))).collect();
    for (file, mu) in files.iter().zip(moduli) {
        let e = table(model, &[mu], [1.05, 2.0], &white(mu as u64, 20, 500.0));
        let rows: String = e.samples.iter().map(|s| format!("{},{}\n", s.stretch, s.stress)).collect();
        std::fs::write(file, format!("stretch,nominal stress (Pa)\n{rows}")).expect("writable");
    }
    let ask = |files: &[std::path::PathBuf]| {
        let mut request = FitRequest::new(&files[0], "neo_hookean");
        (request.more, request.options.modes) = (files[1..].to_vec(), vec![Mode::Uniaxial]);
        request.options.bootstrap = 200;
        fit(&request)
    };
    let r = ask(&files).expect("fits");
    let s = r.scatter.as_ref().expect("five specimens");
    assert_eq!((r.rows, s.specimens.len(), s.outlier.as_deref()), (100, 5, Some("e.csv")));
    // Noise of 500 Pa moves μ of 20 rows by about 1e2 Pa
    assert!(s.specimens.iter().zip(moduli).all(|(one, mu)| (one.parameters[0].value - mu).abs() < 1e3));
    let all: Vec<f64> = s.specimens.iter().map(|one| one.parameters[0].value).collect();
    let mean = all.iter().sum::<f64>() / 5.0;
    let deviation = (all.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 4.0).sqrt();
    assert!((s.means[0] / mean - 1.0).abs() < 1e-12 && (s.deviations[0] / deviation - 1.0).abs() < 1e-12);
    // t to four digits
    assert!(((s.intervals[0][1] - mean) / (2.776 * deviation / 5.0_f64.sqrt()) - 1.0).abs() < 2e-4);
    let named = |w: &FitWarning| matches!(w, FitWarning::Specimen { file, level } if file == "e.csv" && *level > 1.2);
    assert!(r.warnings.iter().any(named), "{:?}", r.warnings);
    let b = r.bootstrap.as_ref().expect("asked for");
    assert_eq!(b.drawn, Drawn::Specimens { specimens: 5 });
    assert!(b.std_errors[0] > r.parameters[0].std_error, "rows of one specimen are no news");
    assert!(r.audit.0.iter().any(|e| e.message.starts_with("c.csv: delimiter")));
    let four = ask(&files[..4]).expect("fits");
    assert_eq!(four.scatter.as_ref().expect("four").outlier, None);
    let twice = ask(&[files[0].clone(), files[1].clone(), files[0].clone()]).expect_err("the same file").to_string();
    assert!(twice.contains("a.csv and a.csv hold the same bytes; give each specimen once"), "{twice}");
    r.write_json(&folder.path().join("fit.json")).expect("writable");
    durometer::report::fit::write(folder.path()).expect("a report");
    let csv = std::fs::read_to_string(folder.path().join("tables/specimens.csv")).expect("the table");
    assert!(csv.contains("e.csv,20,1.") && csv.contains("standard deviation"), "{csv}");
}
