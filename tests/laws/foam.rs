//! Foams: the law in scenes, and its fit to stress and lateral strain.

use crate::common;
use crate::common::{Random, column, run, scene};
use durometer::calibrate::{
    AuditKind, FitError, FitOptions, FitRequest, FitResult, FittableLaw, Mode, Partner, Sample, Sign, SlackChoice,
    StrainKind, fit, fit_experiment,
};
use durometer::material::{LoadCase, Want};
use durometer::math::tensor::Mat3;
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use nalgebra::Vector3;
use rayon::prelude::*;

/// μ [Pa] and α of a soft foam that densifies in compression.
const ONE: &[f64] = &[20e3, 5.0];
const TWO: &[f64] = &[20e3, 8.0, 6e3, -2.0];
const NU: f64 = 0.12;

fn model(terms: usize, nu: f64) -> FittableLaw {
    FittableLaw::new("hyperfoam", Some(terms)).expect("registered").with_poisson(nu)
}

/// The stresses of the fit are those of the law of scenes, whose lateral stretches are solved from zero lateral stress, in every mode; the
/// sensitivities are their differences.
#[test]
fn stresses_are_those_of_the_scenes_law() {
    let cases = [
        (Mode::Uniaxial, LoadCase::Uniaxial),
        (Mode::Equibiaxial, LoadCase::Equibiaxial),
        (Mode::Planar, LoadCase::Planar),
        (Mode::SimpleShear, LoadCase::SimpleShear),
    ];
    for (nu, values) in [0.0, NU, 0.4].into_iter().flat_map(|nu| [(nu, ONE), (nu, TWO)]) {
        let model = model(values.len() / 2, nu);
        let law = model.law(values, 0.0).expect("a foam");
        assert!((law.small_strain().nu - nu).abs() < 1e-12 && law.split().is_none());
        for ((mode, case), stretch) in cases.into_iter().flat_map(|c| [0.3, 0.8, 1.02, 1.7].map(|l| (c, l))) {
            let amount = if mode == Mode::SimpleShear { mode.strain(stretch) } else { stretch };
            let state = case.state(law.as_ref(), amount).expect("an equilibrium");
            let r = law.eval(&state.f, Want::Residual).expect("J > 0");
            let own = if mode == Mode::SimpleShear { r.p[(0, 1)] } else { r.p[(0, 0)] };
            let p = model.stress(values, mode, stretch);
            assert!((p / own - 1.0).abs() < 1e-8, "{mode} {stretch} ν = {nu}: {p} not {own}");
            let sample = Sample { mode, stretch, second: 1.0, stress: 0.0, line: 1, specimen: 0 };
            for (k, s) in model.sensitivities(values, &sample).into_iter().enumerate() {
                let h = 1e-5 * values[k].abs();
                let moved = |d: f64| {
                    let mut v = values.to_vec();
                    v[k] += d;
                    model.stress(&v, mode, stretch)
                };
                let slope = (moved(h) - moved(-h)) / (2.0 * h);
                assert!((s - slope).abs() < 1e-7 * (p / values[k]).abs().max(slope.abs()), "{mode} {k}");
            }
        }
        // Two stresses of a biaxial test, with the third direction free
        let sample = Sample { mode: Mode::Biaxial, stretch: 1.3, second: 0.8, stress: 0.0, line: 1, specimen: 0 };
        let f = Mat3::from_diagonal(&Vector3::from(sample.stretches(nu)));
        let p = law.eval(&f, Want::Residual).expect("J > 0").p;
        assert!(p[(2, 2)].abs() < 1e-9 * p[(0, 0)].abs());
        assert!((model.at(values, &sample) / p[(0, 0)] - 1.0).abs() < 1e-9);
    }
}

/// A table of a press: compressive strain and stress are positive, the lateral strain is that of expansion. Noise as deviations of the stress [Pa] and
/// of the lateral strain.
fn press(name: &str, values: &[f64], nu: f64, noise: [f64; 2], seed: u64) -> FitRequest {
    let model = model(values.len() / 2, nu);
    let mut random = Random::seed(seed.wrapping_mul(0x9e37_79b9) + 5);
    let row = |k: u32| {
        let e = 0.012 * f64::from(k);
        let (stress, lateral) = (model.stress(values, Mode::Uniaxial, 1.0 - e), (1.0 - e).powf(-nu) - 1.0);
        let (p, t) = (-stress + noise[0] * random.normal(), lateral + noise[1] * random.normal());
        format!("{},{},{}\n", 100.0 * e, p / 1e3, 100.0 * t)
    };
    let path = common::folder("foam").join(format!("{name}.csv"));
    let rows: String = (1..=50).map(row).collect();
    let head = "compressive strain [%],compressive stress [kPa],lateral strain [%]\n";
    std::fs::write(&path, format!("{head}{rows}")).expect("written");
    let mut request = FitRequest::new(path, "hyperfoam");
    request.options.modes = vec![Mode::Uniaxial];
    request.options.terms = Some(values.len() / 2);
    request
}

fn fitted(request: &FitRequest) -> FitResult {
    fit(request).unwrap_or_else(|e| panic!("{e}"))
}

/// Without noise constants and ratio come back, whatever the number of terms; the law file is a law of scenes with ν in every term.
#[test]
fn a_table_of_a_press_gives_the_foam_back() {
    for (name, values, nu) in [("one", ONE, NU), ("two", TWO, NU), ("cork", ONE, 0.01), ("tight", ONE, 0.4)] {
        let r = fitted(&press(name, values, nu, [0.0; 2], 1));
        let poisson = r.poisson.as_ref().expect("measured");
        assert!(poisson.measured && (poisson.ratio.value - nu).abs() < 1e-10, "{r}");
        for (e, truth) in r.parameters.iter().zip(values) {
            assert!((e.value / truth - 1.0).abs() < 1e-5, "{name}: {e:?} not {truth}\n{r}");
        }
        let said = r.to_string();
        assert!(r.partner.is_none() && said.contains("Poisson's ratio by the lateral strain"), "{r}");
        // The test is one of compression, and reaches 60 %
        assert!(
            said.contains("rms of the data from stretch 1 down to 0.4") && !said.contains("small for a test"),
            "{r}"
        );
        let law = durometer::material::law_from_table(&{
            let mut table: toml::Table = r.law_text().parse().expect("TOML");
            table.remove("provenance").expect("with its origin");
            table
        })
        .expect("a law");
        assert_eq!(law.values().len(), 3 * values.len() / 2);
        let state = LoadCase::Uniaxial.state(law.as_ref(), 0.5).expect("an equilibrium");
        let expected = model(values.len() / 2, nu).stress(values, Mode::Uniaxial, 0.5);
        let p = law.eval(&state.f, Want::Residual).expect("J > 0").p[(0, 0)];
        assert!((p / expected - 1.0).abs() < 1e-6, "{p} not {expected}");
    }
}

/// 200 draws with errors of 1 % of the largest stress and of 0.3 % lateral strain: the intervals of μ, α and ν hold the truth in 95 ± 3 %, and two standard
/// deviations of the count, 3.1 %, are allowed for. The error of ν is a part of that of μ.
#[test]
fn intervals_of_a_foam_cover_the_truth() {
    let one = |seed: u64| {
        let mut request = press(&format!("draw-{seed}"), ONE, NU, [250.0, 3e-3], seed);
        request.options.ranges = 0;
        let r = fitted(&request);
        let poisson = r.poisson.as_ref().expect("measured").ratio;
        let ends = r.parameters.iter().map(|e| e.interval).chain([poisson.interval]);
        let truths = ONE.iter().chain([&NU]);
        ends.zip(truths).map(|([a, b], t)| f64::from(u8::from(a <= *t && *t <= b))).collect::<Vec<f64>>()
    };
    let draws: Vec<Vec<f64>> = (1..=200_u64).into_par_iter().map(one).collect();
    let covered: Vec<f64> = (0..3).map(|k| draws.iter().map(|d| d[k]).sum::<f64>() / 200.0).collect();
    println!("coverage of mu, alpha, nu in 200 draws: {covered:.3?}");
    assert!(covered.iter().all(|c| (c - 0.95).abs() <= 0.03 + 0.016), "{covered:?}");
}

/// The contribution of ν to the intervals is the change of the answer with ν; a given ν is exact unless its accuracy is stated.
#[test]
fn the_error_of_the_ratio_is_in_the_intervals() {
    // Little noise: the second derivatives of the sum of squares, which the contribution leaves out, are of the size of the misfit
    let mut request = press("accuracy", ONE, NU, [2.0, 0.0], 3);
    request.options.ranges = 0;
    let given = |nu: f64, half: Option<&str>| {
        let mut request = request.clone();
        request.options.partner = Some(Partner::Nu(nu));
        if let Some(half) = half {
            request.options.accuracy = format!("poisson={half}").parse().expect("a half-width");
        }
        fitted(&request)
    };
    let exact = given(NU, None);
    assert!(exact.measurement.is_empty() && exact.to_string().contains("0.12 as given, taken as exact"), "{exact}");
    let wide = given(NU, Some("0.05"));
    let ends = [given(NU + 1e-3, None), given(NU - 1e-3, None)];
    for (k, by) in wide.measurement[0].moves.iter().enumerate() {
        let real = 0.5 * 50.0 * (ends[0].parameters[k].value - ends[1].parameters[k].value).abs();
        assert!((by / real - 1.0).abs() < 0.02, "{k}: {by} not {real}");
        let half = |r: &FitResult| 0.5 * (r.parameters[k].interval[1] - r.parameters[k].interval[0]);
        assert!(half(&wide) > half(&exact).hypot(0.9 * by), "{k}");
    }
    assert!(wide.to_string().contains("of which the Poisson's ratio: "), "{wide}");
}

/// True stress over the section under load, λ_t² of the undeformed one, is the same test; without the lateral strain it is refused, whatever ν is stated.
#[test]
fn a_true_stress_takes_the_lateral_strain() {
    let nominal = press("nominal", ONE, NU, [0.0; 2], 1);
    let text = std::fs::read_to_string(&nominal.data).expect("read");
    let written = |name: &str, head: &str, row: &dyn Fn(f64, f64, f64) -> String| {
        let one = |line: &str| {
            let x: Vec<f64> = line.split(',').map(|c| c.parse().expect("a number")).collect();
            row(x[0], x[1] / (1.0 + x[2] / 100.0).powi(2), x[2])
        };
        let rows: Vec<String> = text.lines().skip(1).map(one).collect();
        let path = nominal.data.with_file_name(name);
        std::fs::write(&path, format!("{head}\n{}\n", rows.join("\n"))).expect("written");
        FitRequest { data: path, ..nominal.clone() }
    };
    let head = "compressive strain [%],compressive true stress [kPa]";
    let measured = written("true.csv", &format!("{head},lateral strain [%]"), &|e, p, t| format!("{e},{p},{t}"));
    let r = fitted(&measured);
    for (e, truth) in r.parameters.iter().zip(ONE) {
        assert!((e.value / truth - 1.0).abs() < 1e-5, "{e:?} not {truth}\n{r}");
    }
    let mut bare = written("true-bare.csv", head, &|e, p, _| format!("{e},{p}"));
    bare.options.partner = Some(Partner::Nu(NU));
    let message = fit(&bare).expect_err("no lateral strain").to_string();
    assert!(message.contains("is a true stress") && message.contains("--lateral-column"), "{message}");
    let unit = written("no-unit.csv", &format!("{head},lateral strain"), &|e, p, t| format!("{e},{p},{t}"));
    let message = fit(&unit).expect_err("no unit").to_string();
    assert!(message.contains("--lateral-unit %") && !message.contains("--unit"), "{message}");
}

/// The lateral strain is read as the fit reads strain and stress: with the columns of a card, in the test that was chosen, and with the sign that the name of the stress gives.
#[test]
fn the_lateral_strain_is_read_as_the_fit_reads_the_table() {
    let plain = press("plain", ONE, NU, [0.0; 2], 1);
    let expected = fitted(&plain);
    let text = std::fs::read_to_string(&plain.data).expect("read");
    let rows: Vec<&str> = text.lines().skip(1).collect();
    let folder = common::folder("foam-read");
    let written = |name: &str, head: &str, row: &dyn Fn(&str) -> String| {
        let path = folder.join(name);
        let rows: String = rows.iter().map(|line| row(line) + "\n").collect();
        std::fs::write(&path, format!("{head}\n{rows}")).expect("written");
        FitRequest { data: path, ..plain.clone() }
    };
    let same = |request: &FitRequest| {
        let r = fitted(request);
        let ratio = |r: &FitResult| r.poisson.as_ref().expect("measured").ratio;
        assert_eq!(ratio(&r), ratio(&expected), "{r}");
        assert!((r.parameters[0].value / expected.parameters[0].value - 1.0).abs() < 1e-9, "{r}");
    };
    same(&written("half.csv", "Strain [%],Compressive stress [kPa],lateral strain [%]", &str::to_owned));
    let card = "name = \"Foam\"\nfile = \"carded.csv\"\nstatus = \"own measurement\"\nmode = \"uniaxial\"\n[columns]\nstrain = \"e (%)\"\nstrain_kind = \"engineering\"\n\
                stress = \"p (kPa)\"\nlateral = \"et\"\nlateral_unit = \"%\"\npositive = \"compression\"\n";
    std::fs::write(folder.join("card.toml"), card).expect("written");
    same(&written("carded.csv", "e (%),p (kPa),et", &str::to_owned));
    let names = |k: u32| format!("compressive strain {k} [%],compressive stress {k} [kPa],lateral strain {k} [%]");
    let doubled = |line: &str| {
        let x: Vec<f64> = line.split(',').map(|c| c.parse().expect("a number")).collect();
        format!("{line},{},{},{}", 1.001 * x[0], 1.1 * x[1], 2.0 * x[2])
    };
    let mut side = written("side.csv", &[names(1), names(2)].join(","), &doubled);
    side.columns.test = Some(1);
    same(&side);
}

/// A press whose columns do not say that compression is positive: its lateral strain grows, and the foam follows it as compression. Tension is no doubt.
#[test]
fn a_press_that_is_read_as_tension_is_doubted() {
    let one = press("open", ONE, NU, [0.0; 2], 1);
    let rows = |side: f64, lateral: bool| {
        let row = |k: u32| {
            let e = 0.012 * f64::from(k);
            let l = 1.0 + side * e;
            let stress = side * model(1, NU).stress(ONE, Mode::Uniaxial, l) / 1e3;
            let across = if lateral { format!(",{}", l.powf(-NU) - 1.0) } else { String::new() };
            format!("{e},{stress}{across}\n")
        };
        let head = if lateral { "strain [1],stress [kPa],lateral strain [1]" } else { "strain [1],stress [kPa]" };
        format!("{head}\n{}", (1..=50).map(row).collect::<String>())
    };
    let request = |name: &str, rows: String, nu: Option<f64>| {
        let data = one.data.with_file_name(format!("{name}.csv"));
        std::fs::write(&data, rows).expect("written");
        let mut request = FitRequest { data, ..one.clone() };
        request.options.partner = nu.map(Partner::Nu);
        request
    };
    let doubts = |request: &FitRequest| {
        let audit = fitted(request).audit;
        audit.of(AuditKind::Doubt).map(|entry| format!("{}\n", entry.message)).collect::<String>()
    };
    let measured =
        fit(&request("sign-measured", rows(-1.0, true), None)).expect_err("the ratio is negative").to_string();
    assert!(
        measured.contains("grows with the axial one") && measured.contains("pass --positive compression"),
        "{measured}"
    );
    let given = doubts(&request("sign-given", rows(-1.0, true), Some(NU)));
    assert!(given.contains("column \"lateral strain [1]\" grows with them"), "{given}");
    let mut bare = request("sign-bare", rows(-1.0, false), Some(NU));
    let said = doubts(&bare);
    assert!(said.contains("a foam of one term follows them within 0.0 % rms as compression"), "{said}");
    bare.columns.positive = Some(Sign::Compression);
    assert!(!doubts(&bare).contains("read as tension"));
    for lateral in [true, false] {
        let pulled = doubts(&request("sign-pulled", rows(1.0, lateral), Some(NU)));
        assert!(!pulled.contains("read as tension"), "{pulled}");
    }
    // A zero of the lateral strain, and noise about it, are no growth
    let row = |k: u32| {
        let e = 0.012 * f64::from(k);
        let stress = model(1, NU).stress(ONE, Mode::Uniaxial, 1.0 + e) / 1e3;
        format!("{e},{stress},{}\n", 1e-3 + 1e-4 * f64::from(k % 2))
    };
    let still = format!("strain [1],stress [kPa],lateral strain [1]\n{}", (1..=50).map(row).collect::<String>());
    let said = doubts(&request("sign-still", still, Some(NU)));
    assert!(!said.contains("read as tension"), "{said}");
}

/// Poisson's ratio is never assumed, and what makes no sense is refused.
#[test]
fn a_foam_without_its_ratio_is_refused() {
    let refused = |request: &FitRequest, says: &str| {
        let message = fit(request).expect_err(says).to_string();
        assert!(message.contains(says), "gave: {message}\nnot: {says}");
    };
    let measured = press("measured", ONE, NU, [0.0; 2], 1);
    let text = std::fs::read_to_string(&measured.data).expect("read");
    let bare: String = text.lines().map(|l| l.rsplit_once(',').expect("three cells").0.to_string() + "\n").collect();
    let path = measured.data.with_file_name("bare.csv");
    std::fs::write(&path, bare).expect("written");
    let bare = FitRequest { data: path, ..measured.clone() };
    refused(&bare, "needs Poisson's ratio: a column of lateral strain next to the strain, or --nu");
    refused(&bare, "no line names a column of lateral strain");
    refused(&bare, "Name it by --lateral-column");
    let path = measured.data.with_file_name("unit.csv");
    std::fs::write(&path, text.replace("lateral strain [%]", "lateral strain")).expect("written");
    refused(&FitRequest { data: path, ..measured.clone() }, "pass --lateral-unit … such as --lateral-unit %");
    let mut kappa = measured.clone();
    kappa.options.partner = Some(Partner::Kappa(1e6));
    refused(&kappa, "--kappa does not give it");
    let mut rubber = measured.clone();
    rubber.options.law = "ogden".into();
    rubber.options.accuracy = "poisson=0.01".parse().expect("a half-width");
    refused(&rubber, "fitted as incompressible and has no such error");
    refused(&press("rubber", ONE, 0.4995, [0.0, 2e-3], 1), "keeps its volume");
    // A column of zeros may be a gauge that was not connected: a foam that does not spread is stated
    let mut still = press("still", ONE, 0.0, [0.0; 2], 1);
    refused(&still, "the lateral strain does not vary");
    still.options.partner = Some(Partner::Nu(0.0));
    assert!(fit(&still).is_ok());
    let mut parts = measured.clone();
    parts.options.volumetric = Some("quadratic".into());
    refused(&parts, "has no choice of a volumetric part");
    let experiment = common::made::table(vec![]);
    let message = fit_experiment(&experiment, &FitOptions::new("hyperfoam")).expect_err("no ratio");
    assert!(matches!(message, FitError::NoPoisson { .. }), "{message}");
    // ν is read from the rows as they are written, also where these are so many that means of neighbours are fitted
    let rows = |k: u32| {
        let e = 0.4 * f64::from(k) / 3000.0;
        let stress = model(1, NU).stress(ONE, Mode::Uniaxial, 1.0 - e);
        format!("{},{},{}\n", 100.0 * e, -stress / 1e3, 100.0 * ((1.0 - e).powf(-NU) - 1.0))
    };
    let path = measured.data.with_file_name("many.csv");
    let names = text.lines().next().expect("names");
    std::fs::write(&path, format!("{names}\n{}", (1..=3000).map(rows).collect::<String>())).expect("written");
    let many = fitted(&FitRequest { data: path, ..measured.clone() });
    assert!(many.poisson.as_ref().is_some_and(|p| (p.ratio.value - NU).abs() < 1e-6), "{many}");
    let mut kind = measured.clone();
    kind.columns.strain_kind = Some(StrainKind::True);
    refused(&kind, "the fit takes another one (line 2: stretch");
    let rows = |mode: &str, lines: std::ops::Range<usize>| -> String {
        text.lines()
            .skip(1)
            .enumerate()
            .filter(|(k, _)| lines.contains(k))
            .map(|(_, line)| format!("{line},{mode}\n"))
            .collect()
    };
    let path = measured.data.with_file_name("modes.csv");
    std::fs::write(&path, format!("{names},mode\n{}{}", rows("uniaxial", 0..25), rows("planar", 25..50)))
        .expect("written");
    refused(
        &FitRequest { data: path, ..measured.clone() },
        "some are planar (line 27); fit the uniaxial rows in a table of their own",
    );
    let mut slack = measured.clone();
    slack.options.slack = SlackChoice::Yes;
    refused(&slack, "so that the lateral strain does not give the ratio; pass --nu, or --slack no");
    // Softening has no isochoric part to act on
    let mut cyclic = measured;
    cyclic.options.partner = Some(Partner::Nu(NU));
    let said = durometer::calibrate::softening::fit_softening(&cyclic).err().map(|e| e.to_string());
    assert!(said.as_ref().is_some_and(|e| e.contains("the law hyperfoam has no isochoric part")), "{said:?}");
}

/// A block of foam that a scene compresses to half its height between smooth plates has the stress of the fit.
#[test]
fn a_scene_compresses_the_foam() {
    let text = r#"
[mesh]
body = "block"
[laws.foam]
law = "hyperfoam"
mu1 = "20 kPa"
alpha1 = 8
nu1 = 0.12
mu2 = "6 kPa"
alpha2 = -2
nu2 = 0.12
[[effect]]
kind = "elastic"
region = "body"
law = "foam"
[[constraint]]
kind = "fixed"
region = "xmin"
components = "x"
[[constraint]]
kind = "fixed"
region = "ymin"
components = "y"
[[constraint]]
kind = "fixed"
region = "zmin"
components = "z"
[[constraint]]
kind = "prescribed"
region = "zmax"
components = "z"
displacement = { kind = "ramp", from = "0 mm", to = "-10 mm", start = "0 s", end = "1 s" }
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.1 s"
[[probe]]
kind = "reaction"
region = "zmax"
"#;
    let result = run(&scene(block(2, 2, 2, 0.02, 0.02, 0.02, Order::Linear), text));
    let force = column(&result, "zmax_reaction_z_N");
    for (k, f) in force.iter().enumerate().skip(1) {
        let expected = model(2, NU).stress(TWO, Mode::Uniaxial, 1.0 - 0.05 * k as f64) * 4e-4;
        // The run accepts a correction of 1e-6 of the displacement
        assert!((f / expected - 1.0).abs() < 1e-5, "step {k}: {f} not {expected}");
    }
    assert_eq!(force.len(), 11);
}
