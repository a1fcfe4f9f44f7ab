//! Intervals of a fit by every error model, against closed forms and dense matrices.

use crate::common::Random;
use crate::common::coverage::Coverage;
use durometer::calibrate::{
    AuditKind, Band, ColumnChoice, ErrorModel, Experiment, FitOptions, FitRequest, FitResult, FitWarning, FittableLaw,
    Mode, Preparation, Sample, SlackChoice, StretchRange, Treatment, fit, fit_experiment,
};
use durometer::math::statistics::{deviation, larger, median};
use nalgebra::{DMatrix, DVector};

/// A table of uniaxial rows at evenly spread λ with these errors [Pa].
fn table(model: FittableLaw, values: &[f64], [low, high]: [f64; 2], errors: &[f64]) -> Experiment {
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

fn fitted(e: &Experiment, model: FittableLaw) -> FitResult {
    let o = FitOptions { terms: Some(model.terms), ranges: 0, ..FitOptions::new(model.name()) };
    fit_experiment(e, &o).unwrap_or_else(|e| panic!("{}: {e}", model.label()))
}

fn white(seed: u64, n: usize, size: f64) -> Vec<f64> {
    let mut noise = Random::seed(seed);
    (0..n).map(|_| size * noise.normal()).collect()
}

/// Ogden's law with two terms on data of one: the second vanishes, and the first may share its stress with it in any parts. The interval of its factor
/// reaches to zero, its shape is open, and both hold whatever has the same stresses.
#[test]
fn a_term_that_may_share_with_a_vanished_one_is_open() {
    let model = FittableLaw::new("ogden", Some(2)).expect("registered");
    let mut seen = 0;
    for seed in 1..=12 {
        let e = table(model, &[40e3, 2.0, 0.0, 2.0], [1.02, 1.75], &white(seed, 25, 150.0));
        let r = fitted(&e, model);
        let [mu, alpha, other] = [0, 1, 2].map(|k| &r.parameters[k]);
        if other.value != 0.0 {
            continue;
        }
        seen += 1;
        assert!(mu.interval[0].abs() < 1e-3 * mu.value && mu.interval[1] > mu.value, "{seed}: {mu:?}");
        assert_eq!(alpha.interval, [f64::NEG_INFINITY, f64::INFINITY], "{seed}");
        let one = fitted(&e, FittableLaw::new("ogden", Some(1)).expect("registered"));
        assert!(one.is_determined() && (one.parameters[0].value / mu.value - 1.0).abs() < 1e-6);
    }
    assert!(seen > 2, "a term vanishes in {seen} of 12");
}

/// eₖ = 0.9 eₖ₋₁ + √(1 − 0.81) zₖ: variance 1, correlated over ten rows.
fn correlated(seed: u64, n: usize, size: f64) -> Vec<f64> {
    let mut noise = Random::seed(seed);
    let mut e = noise.normal();
    let next = |_| {
        e = 0.9 * e + 0.19_f64.sqrt() * noise.normal();
        size * e
    };
    (0..n).map(next).collect()
}

/// Gent, by another way: with J_m fixed μ is a quotient of two sums. S at both ends of J_m is Ŝ(1 + t²/(n − p)), t₀.₉₇₅(38) = 2.02439 as
/// tabulated. The interval is skewed: J_m is seen less the larger it is.
#[test]
fn the_profile_of_gent_ends_where_the_likelihood_says() {
    let model = FittableLaw::new("gent", None).expect("registered");
    let e = table(model, &[0.3e6, 60.0], [1.05, 5.0], &white(11, 40, 1e4));
    let r = fitted(&e, model);
    let square = |jm: f64| {
        let rows: Vec<(f64, f64)> =
            e.samples.iter().map(|s| (model.stress(&[1.0, jm], Mode::Uniaxial, s.stretch), s.stress)).collect();
        let mu = rows.iter().map(|(a, b)| a * b).sum::<f64>() / rows.iter().map(|(a, _)| a * a).sum::<f64>();
        rows.iter().map(|(a, b)| (b - mu * a).powi(2)).sum::<f64>()
    };
    let (jm, least) = (r.parameters[1].value, square(r.parameters[1].value));
    let [low, high] = r.parameters[1].interval;
    assert_eq!(r.errors, ErrorModel::Independent);
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
    let model = FittableLaw::new("gent", None).expect("registered");
    let e = table(model, &[0.3e6, 400.0], [1.05, 2.0], &white(2, 40, 3e4));
    let r = fitted(&e, model);
    let [low, high] = r.parameters[1].interval;
    assert!(high == f64::INFINITY && low > 0.0, "{low} {high}");
    let folder = tempfile::tempdir().expect("a temporary folder");
    r.write_json(&folder.path().join("fit.json")).expect("writable");
    durometer::report::fit::write(folder.path()).expect("a report");
    let csv = std::fs::read_to_string(folder.path().join("tables/parameters.csv")).expect("the table");
    assert!(csv.contains(",open,") && !r.is_determined(), "{csv}");
}

/// The covariance of correlated errors by dense matrices: Σ, its inverse and its determinant in full, on the same correlations and sizes. The sums over neighbours
/// lose no more than 1e-9 of it.
#[test]
fn correlated_errors_are_those_of_the_dense_matrices() {
    let model = FittableLaw::new("yeoh", Some(2)).expect("registered");
    let (n, p) = (40, 2);
    let e = table(model, &[0.17e6, 4e3], [1.05, 2.5], &correlated(4, n, 5e3));
    let r = fitted(&e, model);
    let ErrorModel::Correlated { rho: mean, effective, .. } = r.errors else { panic!("{}", r.errors) };
    let x = DMatrix::from_fn(n, p, |i, k| {
        let mut unit = [0.0; 2];
        unit[k] = 1.0;
        model.stress(&unit, Mode::Uniaxial, e.samples[i].stretch)
    });
    let y = DVector::from_fn(n, |i, _| e.samples[i].stress);
    let plain = (x.transpose() * &x).try_inverse().expect("regular");
    let by = &plain * x.transpose();
    let residual = &y - &x * (&by * &y);
    let root = |k: f64, w: f64| (40.0 - 4.0) / (40.0 - 4.0 + 8.0 * (1.0 - w)) * (k / 45.0).sqrt();
    // Shares of noise of each reading alone, with their parts of 0 to 1
    let shares = [(0.0, 0.05), (0.1, 0.125), (0.25, 0.175), (0.45, 0.2), (0.65, 0.175), (0.8, 0.125), (0.9, 0.15)];
    let hat = &x * &by;
    let law = &hat * &y;
    // Sizes of the errors: one, with the root of the stress, in proportion to it, with 5 % of the largest stress at least
    let size = |power: f64| law.map(|p| (p.abs() / law.amax()).max(0.05).powf(power));
    let one = |(power, k, (w, part)): (f64, usize, (f64, f64))| {
        let (k, rho, s) = (k as f64, root(k as f64, w), size(power));
        let wide = part * (root((k + 0.5).min(45.0), w) - root((k - 0.5).max(0.0), w));
        let of_drift = |i: usize, j: usize| (1.0 - w) * rho.powi(i.abs_diff(j) as i32);
        let sigma = DMatrix::from_fn(n, n, |i, j| s[i] * s[j] * (of_drift(i, j) + if i == j { w } else { 0.0 }));
        // Of least squares with the weights 1/s: residual, and the expectation of its square
        let over = DMatrix::from_diagonal(&s.map(|s| 1.0 / s));
        let (own, inverse) = (&over * &x, (&over * &sigma * &over).try_inverse().expect("regular"));
        let own_hat = &own * (own.transpose() * &own).try_inverse().expect("regular") * own.transpose();
        let own_left = DMatrix::identity(n, n) - &own_hat;
        let rest = &own_left * &over * &residual;
        let white = &over * &sigma * &over;
        let expected = (&inverse * &own_left * &white * &own_left).trace();
        let square = (rest.transpose() * &inverse * &rest)[(0, 0)] / expected;
        let columns = x.transpose() * sigma.clone().try_inverse().expect("regular") * &x;
        let log = sigma.clone().lu().determinant().ln() + columns.determinant().ln();
        let whole = rest.norm_squared() / (n as f64 - (&own_hat * &white * &own_hat).trace());
        let s2 = square.max(whole);
        ([rho, w], wide, -0.5 * (log + (n - p) as f64 * square.ln()), &by * sigma * by.transpose() * s2)
    };
    let of_share = |power: f64, share: (f64, f64)| (usize::from(share.0 > 0.0)..46).map(move |k| (power, k, share));
    let grid: Vec<_> = ([0.0, 0.5, 1.0].into_iter())
        .flat_map(|power| shares.into_iter().flat_map(move |share| of_share(power, share)))
        .map(one)
        .collect();
    let most = grid.iter().map(|g| g.2).fold(f64::NEG_INFINITY, larger);
    let sum: f64 = grid.iter().map(|g| g.1 * (g.2 - most).exp()).sum();
    type AtCorrelation = ([f64; 2], f64, f64, DMatrix<f64>);
    let mean_of =
        |of: &dyn Fn(&AtCorrelation) -> f64| grid.iter().map(|g| g.1 * (g.2 - most).exp() / sum * of(g)).sum::<f64>();
    assert!((mean_of(&|([rho, w], ..)| (1.0 - w) * rho) - mean).abs() < 1e-9);
    let independent = |[rho, w]: [f64; 2]| 40.0 * (1.0 - rho) / (1.0 - rho + 2.0 * (1.0 - w) * rho);
    assert!((mean_of(&|g| independent(g.0)) - effective).abs() < 1e-7);
    for (k, e) in r.parameters.iter().enumerate() {
        let by_hand = mean_of(&|g| g.3[(k, k)]).sqrt();
        // Correlations with a weight below 1e-5 are left out
        assert!((e.std_error / by_hand - 1.0).abs() < 1e-3, "{}: {} {by_hand}", e.symbol, e.std_error);
    }
    assert_eq!(r.degrees, (effective - 2.0) as usize);
}

/// A specimen that was recorded ten times as densely has the weight of the others: constants and intervals stay.
#[test]
fn a_specimen_counts_once() {
    let model = FittableLaw::new("neo_hookean", None).expect("registered");
    let own = |mu: f64, specimen: usize| {
        let e = table(model, &[mu], [1.05, 2.0], &white(mu as u64, 20, 500.0));
        e.samples.into_iter().map(move |s| Sample { specimen, ..s }).collect::<Vec<_>>()
    };
    let [a, b, c] = [own(0.3e6, 0), own(0.31e6, 1), own(0.29e6, 2)];
    let of = |all: Vec<Sample>| {
        let mut e = table(model, &[0.3e6], [1.05, 2.0], &white(1, 20, 500.0));
        (e.samples, e.specimens) = (all, vec!["a".into(), "b".into(), "c".into()]);
        fitted(&e, model)
    };
    let dense: Vec<Sample> = a.iter().flat_map(|s| [*s; 10]).collect();
    let [one, ten] =
        [of([a, b.clone(), c.clone()].concat()), of([dense, b, c].concat())].map(|r| r.parameters[0].clone());
    assert!((one.value / ten.value - 1.0).abs() < 1e-12 && (one.std_error / ten.std_error - 1.0).abs() < 1e-9);
}

/// Slack of 3 % of strain and noise of 100 Pa: the offset is found by itself, and named with its data points; a preload only if it is asked for. A curve
/// that begins after the slack has no data points without stress: its errors count as correlated, and the interval holds the truth. A biaxial test refuses.
#[test]
fn slack_is_fitted_where_it_shows() {
    let model = FittableLaw::new("neo_hookean", None).expect("registered");
    let made = |from: f64, e0: f64| {
        let mut e = table(model, &[0.3e6], [from, 2.0], &white(7, 100, 100.0));
        for s in &mut e.samples {
            let moved = (s.stretch - e0).max(1.0);
            s.stress +=
                model.stress(&[0.3e6], Mode::Uniaxial, moved) - model.stress(&[0.3e6], Mode::Uniaxial, s.stretch);
        }
        e
    };
    let ask = |e: &Experiment, slack: SlackChoice| {
        let mut o = FitOptions::new("neo_hookean");
        o.slack = slack;
        fit_experiment(e, &o).expect("fits")
    };
    let r = ask(&made(1.0, 0.03), SlackChoice::Auto);
    let [slack] = &r.slack[..] else { panic!("{:?}", r.slack) };
    // Rows at 1, 1.0101 and 1.0202
    assert_eq!((slack.rows, slack.asked), (3, false));
    assert!((slack.strain - 0.03).abs() < 5e-4 && slack.interval[0] < 0.03 && 0.03 < slack.interval[1], "{slack:?}");
    assert!((r.parameters[0].value / 0.3e6 - 1.0).abs() < 1e-3, "{:?}", r.parameters);
    let without = r.otherwise.iter().find(|o| o.treatment == Treatment::WithoutSlack).expect("shown");
    assert!(without.parameters[0].value < 0.3e6 * 0.975, "{without:?}");
    assert!(
        r.to_string().contains("slack of made.csv (uniaxial): 0.0") && r.law_text().contains("slack = [0.0"),
        "{r}"
    );
    let [preload] = &ask(&made(1.0, -0.02), SlackChoice::Yes).slack[..] else { panic!("asked for") };
    assert!((preload.strain + 0.02).abs() < 5e-4 && preload.asked, "{preload:?}");
    let late = ask(&made(1.05, 0.03), SlackChoice::Auto);
    assert!(late.slack.is_empty());
    let [low, high] = late.parameters[0].interval;
    assert!(low < 0.3e6 && 0.3e6 < high && !matches!(late.errors, ErrorModel::Independent), "{late}");
    let mut biaxial = made(1.0, 0.03);
    biaxial.samples.iter_mut().for_each(|s| (s.mode, s.second) = (Mode::Biaxial, 1.1));
    let mut o = FitOptions::new("neo_hookean");
    (o.modes, o.slack) = (vec![Mode::Biaxial], SlackChoice::Yes);
    let message = fit_experiment(&biaxial, &o).expect_err("two strains").to_string();
    assert!(message.contains("a biaxial test has two strains"), "{message}");
}

/// Play of 3 % on both sides of rest: no single offset describes it, so that it is refused, none is fitted or advised by itself, and one side alone gives it back whatever the table holds on the
/// other one, whose strains stay. Sheared to both sides alike.
#[test]
fn slack_is_that_of_one_side_of_rest() {
    let law = FittableLaw::new("neo_hookean", None).expect("registered");
    let row = |mode: Mode, strain: f64, play: f64| {
        let stress = law.stress(&[0.3e6], mode, mode.stretch(strain.signum() * (strain.abs() - play).max(0.0)));
        Sample { mode, stretch: mode.stretch(strain), second: 1.0, stress, line: 2, specimen: 0 }
    };
    let tension: Vec<Sample> = (0..=100).map(|k| row(Mode::Uniaxial, 0.01 * f64::from(k), 0.03)).collect();
    let compression = (1..=40).map(|k| row(Mode::Uniaxial, -0.01 * f64::from(k), 0.03));
    let both: Vec<Sample> = tension.iter().copied().chain(compression).collect();
    let sheared: Vec<Sample> =
        (-30..=30).map(|k| row(Mode::SimpleShear, 0.05 * f64::from(k), 0.0)).filter(Sample::is_informative).collect();
    let ask = |samples: &[Sample], slack: SlackChoice, range: Option<StretchRange>| {
        let mut e = table(law, &[0.3e6], [1.0, 2.0], &[0.0; 2]);
        e.samples = samples.to_vec();
        fit_experiment(&e, &FitOptions { slack, range, ..FitOptions::new("neo_hookean") })
    };
    for samples in [&both, &sheared] {
        let refused = ask(samples, SlackChoice::Yes, None).expect_err("two sides").to_string();
        assert!(refused.contains("no single offset") && refused.contains("--range"), "{refused}");
        let auto = ask(samples, SlackChoice::Auto, None).expect("fits");
        let advised = |w: &FitWarning| matches!(w, FitWarning::Slack { .. });
        assert!(auto.slack.is_empty() && !auto.warnings.iter().any(advised), "{auto}");
    }
    let up = Some(StretchRange { from: 1.0, to: 2.0 });
    let [own, alone] = [&both, &tension].map(|samples| ask(samples, SlackChoice::Yes, up).expect("one side"));
    assert!((own.slack[0].strain - 0.03).abs() < 1e-6 && own.parameters == alone.parameters, "{own}");
    let other = own.predictions.iter().find(|p| p.stretch[0] < 1.0).expect("compression");
    assert!(own.rows == alone.rows && other.misfit.rows == 40 && (other.stretch[0] - 0.6).abs() < 1e-12, "{own}");
}

/// Of a table to both sides of rest that misses zero nothing is advised that is refused.
#[test]
fn a_side_that_misses_zero_is_advised_what_can_be_had() {
    let law = FittableLaw::new("mooney_rivlin", Some(2)).expect("registered");
    let up = (0..60).map(|k| 1.0 + f64::from(k) / 59.0);
    let down = (1..50).map(|k| 1.0 - 0.4 * f64::from(k) / 49.0);
    let row = |l: f64| format!("{},{}\n", l + 0.02, law.stress(&[3e4, 1e4], Mode::Uniaxial, l));
    let text = format!("stretch,nominal stress (Pa)\n{}", up.chain(down).map(row).collect::<String>());
    let e = Experiment::parse("a.csv", text.as_bytes(), None, &ColumnChoice::default(), Some(Mode::Uniaxial));
    let e = e.and_then(|e| e.prepare(&Preparation::default())).unwrap_or_else(|e| panic!("{e}"));
    let doubts: Vec<&str> = e.audit.of(AuditKind::Slack).map(|entry| entry.message.as_str()).collect();
    assert!(!doubts.is_empty() && doubts.iter().all(|d| d.contains("(--slack yes of each side alone")), "{doubts:?}");
}

/// Specimens that are alike, of which one broke at 1.6 and the others at 3.5, and a law that describes neither range: levels are those at the same stretches, so that the one that broke is no outlier. Where
/// it is a fifth stiffer it is.
#[test]
fn a_specimen_that_broke_earlier_is_no_outlier() {
    let law = FittableLaw::new("yeoh", Some(3)).expect("registered");
    let scatter = |last: f64| {
        let levels = [1.0, 1.01, 0.99, 1.005, last];
        let of = |k: usize| {
            let end = if k < 4 { 3.5 } else { 1.6 };
            let at = move |i: u32| 1.02 + (end - 1.02) * f64::from(i) / 59.0;
            let stress = move |l: f64| levels[k] * law.stress(&[5e4, -1.5e3, 200.0], Mode::Uniaxial, l);
            (0..60).map(at).map(move |stretch| Sample {
                mode: Mode::Uniaxial,
                stretch,
                second: 1.0,
                stress: stress(stretch),
                line: 2,
                specimen: k,
            })
        };
        let mut e = table(law, &[5e4, 0.0, 0.0], [1.0, 2.0], &[0.0; 2]);
        e.samples = (0..5).flat_map(of).collect();
        e.specimens = (0..5).map(|k| format!("{k}.csv")).collect();
        let r = fit_experiment(&e, &FitOptions::new("neo_hookean")).expect("fits");
        let found = r.scatter.expect("five specimens");
        let own: Vec<f64> = found.specimens.iter().map(|s| s.level.expect("shared stretches")).collect();
        // Over the first specimen, whose factor is 1; the lines of the smoothing leave less than ½ %
        let off = own.iter().zip(levels).map(|(level, factor)| (level / own[0] / factor - 1.0).abs());
        assert!(off.fold(0.0, larger) < 5e-3, "{own:?}");
        found.outlier
    };
    assert_eq!((scatter(0.995), scatter(1.2)), (None, Some("4.csv".into())));
}

/// Five specimens whose stiffness scatters by 3 %, the last one 40 % stiffer. Each constant alone is Σ gP/Σg² of its rows; mean, deviation
/// and t₀.₉₇₅(4) = 2.776 by hand.
#[test]
fn specimens_scatter_and_one_is_an_outlier() {
    let model = FittableLaw::new("neo_hookean", None).expect("registered");
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
    // Tables with the same stretches: the interval of the fit is the one of the mean; t to four digits
    assert!((r.parameters[0].value / mean - 1.0).abs() < 1e-9 && r.errors == ErrorModel::Specimens { specimens: 5 });
    let half = r.parameters[0].interval[1] - mean;
    assert!((half / (2.776 * deviation / 5.0_f64.sqrt()) - 1.0).abs() < 2e-4);
    let named = |w: &FitWarning| matches!(w, FitWarning::Specimen { file, level } if file == "e.csv" && *level > 1.2);
    assert!(r.warnings.iter().any(named), "{:?}", r.warnings);
    assert!(r.audit.0.iter().any(|e| e.message.starts_with("c.csv: delimiter")));
    let four = ask(&files[..4]).expect("fits");
    assert_eq!(four.scatter.as_ref().expect("four").outlier, None);
    // The same test in another unit, with other line ends, counts once too
    let again = folder.path().join("again.csv");
    let text = std::fs::read_to_string(&files[1]).expect("readable");
    let scaled = |line: &str| {
        let (x, y) = line.split_once(',').expect("two columns");
        format!("{x};{:?}\r\n", 1e-3 * y.parse::<f64>().expect("a number"))
    };
    let rows: String = text.lines().skip(1).map(scaled).collect();
    std::fs::write(&again, format!("Stretch;Stress [kPa]\r\n{rows}\r\n")).expect("writable");
    let other = ask(&[files[0].clone(), files[1].clone(), again]).expect_err("the same numbers").to_string();
    assert!(other.starts_with("b.csv and again.csv hold the same numbers"), "{other}");
    let twice = ask(&[files[0].clone(), files[1].clone(), files[0].clone()]).expect_err("the same file").to_string();
    assert!(
        twice.contains(
            "a.csv and a.csv hold the same numbers, and would count as two specimens; give each specimen once"
        ),
        "{twice}"
    );
    r.write_json(&folder.path().join("fit.json")).expect("writable");
    durometer::report::fit::write(folder.path()).expect("a report");
    let csv = std::fs::read_to_string(folder.path().join("tables/specimens.csv")).expect("the table");
    assert!(csv.contains("e.csv,20,1.") && csv.contains("standard deviation"), "{csv}");
}

/// Three specimens with 1 % scatter, of which one has slack that shows and the others less than the distance of two data points: all have an offset, and the intervals hold the
/// mean constants in 50 draws. With slack of up to 5 % in all and an offset only where it shows, C10 was 8 % too small. Half-widths are t = 4.3 of two degrees of freedom times a
/// scatter whose median is 0.83 of the true one, 3.6 in all, known to 14 %: the scatter of the draws to 10 %, and the median as well.
#[test]
fn slack_of_one_specimen_is_sought_in_all() {
    let model = FittableLaw::new("yeoh", Some(2)).expect("known");
    let truth = [30e3, 5e3];
    let (mut all, mut said) = ([vec![], vec![]], 0);
    for seed in 0..50 {
        let mut random = Random::seed(1 + 7919 * seed);
        let mut e = table(model, &truth, [1.0, 2.0], &[0.0; 2]);
        e.samples.clear();
        for specimen in 0..3 {
            let slack = if specimen == 0 { 0.1 } else { 0.015 * (1.0 + specimen as f64) / 2.0 };
            let level = 1.0 + 0.01 * random.normal();
            let rows = (0..60).map(|k| {
                let stretch = 1.0 + k as f64 / 59.0;
                let stress = level * model.stress(&truth, Mode::Uniaxial, (stretch - slack).max(1.0));
                let stress = stress + 200.0 * random.normal();
                Sample { mode: Mode::Uniaxial, stretch, stress, line: k + 2, specimen, second: 1.0 }
            });
            e.samples.extend(rows);
        }
        e.specimens = (0..3).map(|k| format!("{k}.csv")).collect();
        let r = fitted(&e, model);
        // A level that is far from those of the others can hide the slack of a specimen, and then none is fitted
        assert!([0, 3].contains(&r.slack.len()), "{:?}", r.slack);
        if r.slack.is_empty() {
            continue;
        }
        said += i32::from(r.to_string().contains("with that of the other specimens"));
        all.iter_mut().zip(&r.parameters).for_each(|(all, p)| all.push((p.value, p.interval)));
    }
    // Slack in which no data point lies but the one at rest is that of the others
    assert!(all[0].len() >= 48 && said > 0, "{} of 50, {said} told", all[0].len());
    for (all, truth) in all.iter().zip(truth) {
        let found = Coverage::of(truth, all);
        println!("{found:?}");
        assert!(found.holds_within([2.1, 5.1]), "{found:?}");
    }
}

/// Gent specimens whose two constants scatter by 5 %, described by a Neo-Hookean law that misses their curves by some per cent: the band has the half-width t s√(1 + 1/4) with the scatter s of their true curves, and holds
/// the curve of one more specimen in 20 draws at each of its stretches. That of the laws alone held it in 52 % at the worst stretch.
#[test]
fn the_band_of_the_next_specimen_holds_with_a_law_that_does_not_fit() {
    let (truth, law) =
        (FittableLaw::new("gent", None).expect("known"), FittableLaw::new("neo_hookean", None).expect("known"));
    let (draws, specimens) = (20, 4);
    // t₀.₉₇₅ of three degrees of freedom
    let factor = 3.182_446 * 1.25_f64.sqrt();
    let (mut held, mut wide) = ([0; 11], vec![vec![]; 11]);
    for seed in 0..draws {
        let mut noise = Random::seed(1 + 7919 * seed);
        let mut constants = || [60e3 * (1.0 + 0.05 * noise.normal()), 20.0 * (1.0 + 0.05 * noise.normal())];
        let all: Vec<[f64; 2]> = (0..=specimens).map(|_| constants()).collect();
        let mut e = table(truth, &all[0], [1.02, 2.4], &[0.0; 2]);
        let of = |(k, values): (usize, &[f64; 2])| {
            let one = table(truth, values, [1.02, 2.4], &white(seed * 31 + k as u64 + 1, 50, 200.0));
            one.samples.into_iter().map(move |s| Sample { specimen: k, ..s })
        };
        e.samples = all[..specimens].iter().enumerate().flat_map(of).collect();
        e.specimens = (0..specimens).map(|k| format!("{k}.csv")).collect();
        let r = fitted(&e, law);
        assert!(r.misfit.rms_relative > 0.02, "{}", r.misfit.rms_relative);
        let next = &r.scatter.as_ref().expect("several").next;
        for ((count, wide), Band { stretch, interval: [low, high], .. }) in held.iter_mut().zip(&mut wide).zip(next) {
            let stresses: Vec<f64> = all.iter().map(|v| truth.stress(v, Mode::Uniaxial, *stretch)).collect();
            let real = stresses[specimens];
            *count += i32::from(*low <= real && real <= *high);
            wide.push(0.5 * (high - low) / (factor * deviation(&stresses[..specimens])));
        }
    }
    let wide: Vec<f64> = wide.iter().map(|all| median(all)).collect();
    println!("{held:?} of {draws}, half-widths {wide:.3?} of the right ones");
    // Of 20 with a probability of 95 % fewer do with a probability of 1.6 %
    assert!(held.iter().all(|n| *n >= 17), "{held:?} of {draws}");
    // At the first stretch the scatter is not much more than the noise
    assert!(wide[1..].iter().all(|w| (w - 1.0).abs() < 0.05), "{wide:?}");
}

/// Slack of 10 % of strain with noise of 0.05 to 3 % of the largest stress, 50 draws each: it is found by itself in 9 of 10 or more, and the interval of what was found holds it in 95 − 2·3.1 % or more and is
/// 2.0 of its scatter wide, which 50 draws know to 10 %; without noise it is found exactly. Before, noise counted as stress: with 3 % slack was found in 28 to 41 of 100 draws, those with too large an offset; and with less than 1 % in none, as the errors of the fit without it
/// counted as correlated. Without slack, and for a curve that only begins softly, none is found; nor where a law follows a curve that stiffens by an exponential only with an offset.
#[test]
fn slack_is_found_where_noise_leaves_it_visible() {
    let draws = 50;
    let fit = |law: &str, values: &[f64], slack: f64, noise: f64, soft: bool, seed: u64| {
        let model = FittableLaw::new(law, Some(values.len())).expect("registered");
        let stress = |l: f64| {
            model.stress(values, Mode::Uniaxial, l) * if soft { 1.0 - 0.6 * (5.0 - 5.0 * l).exp() } else { 1.0 }
        };
        let errors = white(1000 + seed, 100, noise * stress(2.0 - slack));
        let mut e = table(model, values, [1.0, 2.0], &errors);
        e.samples
            .iter_mut()
            .zip(&errors)
            .for_each(|(s, error)| s.stress = stress((s.stretch - slack).max(1.0)) + error);
        fitted(&e, model).slack
    };
    let study = |law: &str, values: &[f64], slack: f64, noise: f64, soft: bool| {
        let drawn = |seed| fit(law, values, slack, noise, soft, seed).first().map(|s| (s.strain, s.interval));
        let all: Vec<_> = (0..draws).filter_map(drawn).collect();
        let found = Coverage::of(slack, &all);
        println!("{law}, slack {slack}, noise {noise}, soft {soft}: {} of {draws}, {found:?}", all.len());
        (all.len(), found)
    };
    for rate in [2.0, 4.0, 6.0] {
        let mut e = table(FittableLaw::new("neo_hookean", None).expect("registered"), &[1e5], [1.0, 2.0], &[0.0; 100]);
        e.samples.iter_mut().for_each(|s| s.stress = 1e3 * (rate * (s.stretch - 1.0)).exp_m1());
        let r = fitted(&e, FittableLaw::new("neo_hookean", None).expect("registered"));
        assert!(r.slack.is_empty(), "exp {rate}: {:?}", r.slack);
    }
    for (law, values) in [("neo_hookean", &[1e5][..]), ("mooney_rivlin", &[4e4, 1e4])] {
        let exact = |slack, soft| fit(law, values, slack, 0.0, soft, 0);
        assert!(exact(0.0, false).is_empty() && exact(0.0, true).is_empty(), "{law}");
        let [found] = &exact(0.1, false)[..] else { panic!("{law}: without noise none is found") };
        assert!((found.strain - 0.1).abs() < 1e-6, "{law}: {found:?}");
        for noise in [0.0005, 0.001, 0.005, 0.01, 0.03] {
            let (count, found) = study(law, values, 0.1, noise, false);
            assert!(count >= 45 && found.covered >= 88.8, "{law} {noise}: {count}, {found:?}");
            assert!((1.5..2.9).contains(&found.wide), "{law} {noise}: {found:?}");
        }
        for noise in [0.001, 0.03] {
            let (none, soft) = (study(law, values, 0.0, noise, false).0, study(law, values, 0.0, noise, true).0);
            assert!(none == 0 && soft <= 2, "{law} {noise}: {none}, {soft}");
        }
    }
}
