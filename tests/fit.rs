//! Calibration of the incompressible Neo-Hookean law: recovery, refusals, Treloar's table, silicone tables.

mod common;

use common::Random;
use durometer::calibrate::{
    AuditKind, ColumnChoice, Experiment, FitCurves, FitError, FitOptions, FitRequest, FitResult, FitWarning, Mode,
    Partner, PredictionKind, Sample, SolverCheck, StretchRange, fit, fit_experiment, read_law_file, read_law_table,
};
use std::path::{Path, PathBuf};

const MU: f64 = 0.371e6;

fn stress(mode: Mode, l: f64) -> f64 {
    MU * match mode {
        Mode::Uniaxial => l - 1.0 / (l * l),
        Mode::Equibiaxial => l - l.powi(-5),
        Mode::Planar => l - l.powi(-3),
    }
}

fn parse(text: &str) -> Result<Experiment, FitError> {
    Experiment::parse("test.csv", text.as_bytes(), None, &ColumnChoice::default(), Some(Mode::Uniaxial))
}

fn parsed(text: &str) -> Experiment {
    parse(text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn fitted(text: &str) -> FitResult {
    fit_experiment(&parsed(text), &FitOptions::new("neo_hookean")).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn refusal(text: &str) -> String {
    let answer = parse(text).and_then(|e| fit_experiment(&e, &FitOptions::new("neo_hookean")));
    answer.err().unwrap_or_else(|| panic!("must be refused:\n{text}")).to_string()
}

/// A clean table with stretch and stress / `unit`.
fn table(mode: Mode, header: &str, unit: f64) -> String {
    let row = |k: usize| {
        let l = 0.8 + 0.05 * k as f64;
        format!("{l},{}\n", stress(mode, l) / unit)
    };
    header.to_string() + "\n" + &(0..30).map(row).collect::<String>()
}

fn log_of(e: &Experiment, kind: AuditKind) -> String {
    e.audit.of(kind).map(|entry| format!("{entry}\n")).collect()
}

#[test]
fn clean_data_give_the_constant_back_in_every_mode() {
    for mode in Mode::ALL {
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
        assert!((r.validity.tension_to.expect("tension") - 2.25).abs() < 1e-12);
        assert!((r.validity.compression_to.expect("compression") - 0.8).abs() < 1e-12);
    }
}

/// 2000 tables of 12 rows with normal noise of 3 kPa. The interval is exact for this noise, so its coverage is
/// binomial with standard deviation √(0.95·0.05/2000) = 0.49 %: 1.5 % is three of them. The warning on a pattern in
/// the residuals has a false-alarm rate of at most 5 % by construction.
#[test]
fn the_interval_covers_the_truth_in_95_of_100_tables() {
    let mut e = parsed("stretch,nominal stress (Pa)\n1.1,1\n1.2,1\n");
    let (mut covered, mut alarms) = (0, 0);
    let tables = 2000;
    for seed in 0..tables {
        let mut noise = Random(0x5eed_0000 + seed);
        let sample = |k: u32| {
            let stretch = 1.05 + 0.05 * f64::from(k);
            let stress = stress(Mode::Uniaxial, stretch) + 3e3 * noise.normal();
            Sample { mode: Mode::Uniaxial, stretch, stress, line: u64::from(k) + 2 }
        };
        e.samples = (0..12).map(sample).collect();
        let r = fit_experiment(&e, &FitOptions::new("neo_hookean")).expect("well posed");
        let [low, high] = r.parameters[0].interval;
        covered += usize::from(low <= MU && MU <= high);
        alarms += usize::from(r.warnings.iter().any(|w| matches!(w, FitWarning::Systematic { .. })));
    }
    let percent = |n: usize| 100.0 * n as f64 / tables as f64;
    println!("covered {:.2} %, false alarms {:.2} %", percent(covered), percent(alarms));
    assert!((percent(covered) - 95.0).abs() < 1.5, "{:.2} %", percent(covered));
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

#[test]
fn every_dialect_of_a_table_reads_alike() {
    let expected = [(1.1, 0.1e6), (1.25, 0.2e6), (1.5, 0.3e6)];
    for text in [
        "stretch,nominal stress (MPa)\n1.1,0.1\n1.25,0.2\n1.5,0.3\n",
        "\u{feff}stretch;stress (MPa)\r\n1,1;0,1\r\n1,25;0,2\r\n1,5;0,3\r\n",
        "Specimen\tA\nTime (s)\tEngineering Strain (%)\tTrue Stress (MPa)\tEngineering Stress (MPa)\n0\t10\t9\t0.1\n1\t25\t9\t0.2\n2\t50\t9\t0.3\n",
        "stretch,stress (MPa)\n\"1,1\",\"0,1\"\n\"1,25\",\"0,2\"\n\"1,5\",\"0,3\"\n",
        "strain,true strain,stress/kPa\n0.1,7,100\n0.25,7,200\n0.5,7,300\n",
    ] {
        let e = parsed(text);
        assert_eq!(e.samples.len(), 3, "{text}");
        for (s, (stretch, stress)) in e.samples.iter().zip(expected) {
            assert!(
                (s.stretch / stretch - 1.0).abs() < 1e-14 && (s.stress / stress - 1.0).abs() < 1e-14,
                "{s:?} {text}"
            );
        }
    }
    let e = parsed("strain,stress (MPa)\n0.1,0.1\n0.2,0.2\n");
    let log = log_of(&e, AuditKind::Intake);
    assert!(log.contains("taken as engineering strain") && log.contains("taken as nominal stress"), "{log}");
}

#[test]
fn unusual_rows_are_logged_and_unreadable_rows_named() {
    let e = parsed(
        "stretch,nominal stress (MPa)\n1,0.01\n1.1,0.1\n1.2,NaN\n1.3,\n1.4,0.3\n1.2,0.2\n1.2,0.2\n1.2,0.21\n1.5,-0.1\n-0.1,1\n1.6\nend,of\n",
    );
    let left_out = log_of(&e, AuditKind::LeftOut);
    for fact in [
        "line 4: column \"nominal stress (MPa)\" holds \"NaN\"",
        "line 5: column \"nominal stress (MPa)\" is empty",
        "line 11: stretch -0.1 is not positive",
        "line 12: column \"nominal stress (MPa)\" is empty",
        "line 13: column \"stretch\" holds \"end\", which is not a number",
    ] {
        assert!(left_out.contains(fact), "{fact} not in:\n{left_out}");
    }
    let kept = log_of(&e, AuditKind::Kept);
    for fact in [
        "counts each time (line 8)",
        "both count (line 9)",
        "smaller than in the row before (order of the file or unloading); the order does not enter the fit, unloading would (line 7)",
        "under tension) (line 10)",
        "offset was not taken off (line 2)",
    ] {
        assert!(kept.contains(fact), "{fact} not in:\n{kept}");
    }
    assert_eq!(e.samples.len(), 7);
    assert!(log_of(&e, AuditKind::Doubt).contains("5 of 12 rows could not be read"));
}

#[test]
fn bad_tables_are_refused_with_fact_and_remedy() {
    for (text, facts) in [
        ("stretch,nominal stress (MPa)\n1.1,0\n1.2,0\n", &["every stress", "zero", "check the stress column"][..]),
        ("stretch,nominal stress (MPa)\n1.1,-1\n1.2,-2\n", &["against the stretch", "check the sign"]),
        ("Displacement (mm),Force (N)\n1,2\n2,3\n", &["\"Displacement (mm)\", \"Force (N)\"", "--strain-column"]),
        ("a;b\n1,5;2,5\n", &["the columns are: \"a\", \"b\""]),
        ("stretch,true stress (MPa)\n1.1,0.1\n", &["no column of", "\"true stress (MPa)\""]),
        ("stretch,nominal stress\n1.1,0.1\n", &["\"nominal stress\" has no unit", "--stress-unit MPa"]),
        ("stretch,nominal stress (mpa)\n1.1,0.1\n", &["unit \"mpa\"", "MPa"]),
        ("stretch,stress (MPa),stress 2 (MPa)\n1.1,0.1,1\n", &["may be any of", "--stress-column"]),
        ("stretch,nominal stress (MPa)\n", &["no rows below the column names"]),
        ("stretch,nominal stress (MPa)\nx,1\n", &["line 2", "not a number"]),
        ("stretch,nominal stress (MPa)\n1.1,0.1\n", &["holds 1 rows", "2 are needed"]),
        ("stretch,nominal stress (MPa)\n1,0.1\n1,0.2\n", &["holds 0 rows"]),
        ("mode,stretch,nominal stress (MPa)\ntorsion,1.1,0.1\n", &["line 2", "\"torsion\" is not a mode"]),
        ("", &["the file is empty"]),
    ] {
        let message = refusal(text);
        for fact in facts {
            assert!(message.contains(fact), "\"{fact}\" not in \"{message}\"");
        }
    }
}

#[test]
fn requests_that_cannot_be_met_are_refused() {
    let two = parsed("mode,stretch,nominal stress (MPa)\nuniaxial,1.1,0.1\nuniaxial,1.2,0.2\npure_shear,1.1,0.1\n");
    let ask = |change: &dyn Fn(&mut FitOptions)| {
        let mut options = FitOptions::new("neo_hookean");
        change(&mut options);
        fit_experiment(&two, &options).expect_err("must be refused").to_string()
    };
    assert!(ask(&|_| {}).contains("several modes (uniaxial, planar); pass --mode"));
    assert!(ask(&|o| o.modes = vec![Mode::Equibiaxial]).contains("no equibiaxial rows; present: uniaxial, planar"));
    assert!(ask(&|o| o.law = "neo_hokean".into()).contains("did you mean \"neo_hookean\"?"));
    let half = Some(Partner::Nu(0.5));
    assert!(ask(&|o| (o.modes, o.partner) = (vec![Mode::Uniaxial], half)).contains("below 0.5"));
    let narrow = Some(StretchRange { from: 1.5, to: 1.6 });
    let message = ask(&|o| (o.modes, o.range) = (vec![Mode::Uniaxial], narrow));
    assert!(message.contains("the data reach from 1.1 to 1.2: widen --range"), "{message}");
    let text = b"stretch,nominal stress (MPa)\n1.1,0.1\n1.2,0.2\n";
    let unknown = Experiment::parse("t.csv", text, None, &ColumnChoice::default(), None).expect_err("no mode");
    assert!(unknown.to_string().contains("pass --mode uniaxial"));
    let absent = fit(&FitRequest::new("no-such-file.csv", "neo_hookean")).expect_err("absent").to_string();
    assert!(absent.contains("no-such-file.csv"), "{absent}");
}

#[test]
fn a_misread_unit_and_percent_are_doubted() {
    let unit_of = |header: &str, unit: f64| {
        let warnings = fitted(&table(Mode::Uniaxial, header, unit)).warnings;
        warnings.into_iter().find_map(|w| match w {
            FitWarning::Stiffness { instead, .. } => Some(instead),
            _ => None,
        })
    };
    // Numbers in kPa under a column that says MPa, and the other way round
    assert_eq!(unit_of("stretch,stress (MPa)", 1e3), Some(Some("kPa")));
    assert_eq!(unit_of("stretch,stress (kPa)", 1e6), Some(Some("MPa")));
    assert_eq!(unit_of("stretch,stress (kPa)", 1e3), None);
    let percent = parsed("engineering strain,stress (MPa)\n10,0.1\n50,0.3\n100,0.5\n");
    assert!(log_of(&percent, AuditKind::Doubt).contains("--strain-unit %"));
}

#[test]
fn columns_and_units_may_be_stated() {
    let text = b"e,f\n10,100\n20,200\n30,280\n";
    let choice = ColumnChoice {
        strain: Some("e".into()),
        strain_kind: Some("engineering".parse().expect("known")),
        strain_unit: Some("%".into()),
        stress: Some("f".into()),
        stress_unit: Some("kPa".into()),
        mode: None,
    };
    let e = Experiment::parse("t.csv", text, None, &choice, Some(Mode::Planar)).expect("all is stated");
    assert_eq!((e.samples[0].stretch, e.samples[0].stress), (1.1, 100e3));
    let untold = ColumnChoice { strain_kind: None, ..choice };
    let message = Experiment::parse("t.csv", text, None, &untold, None).expect_err("kind unknown").to_string();
    assert!(message.contains("--strain-kind"), "{message}");
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name)
}

fn treloar(modes: &[Mode], range: Option<&str>) -> FitResult {
    let mut request = FitRequest::new(data("treloar-1944/treloar-1944.csv"), "neo_hookean");
    request.options.modes = modes.to_vec();
    request.options.range = range.map(|r| r.parse().expect("valid range"));
    fit(&request).unwrap_or_else(|e| panic!("{e}"))
}

/// μ against Σ g P/Σ g² written out by hand for the five uniaxial rows up to stretch 1.6.
#[test]
fn treloar_at_moderate_stretch() {
    let r = treloar(&[Mode::Uniaxial], Some("1..1.6"));
    println!("{r}\n{}", r.audit.0.iter().map(|e| format!("{e}\n")).collect::<String>());
    for row in &r.range_dependence {
        let e = &row.parameters[0];
        println!(
            "to {:5}: {:2} rows, mu = {:.4} MPa, rms {:.2} %",
            row.to,
            row.rows,
            e.value / 1e6,
            100.0 * row.rms_relative
        );
    }
    let rows = [(1.02, 0.0255), (1.125, 0.13435), (1.24, 0.22555), (1.39, 0.31675), (1.585, 0.40796)];
    let g = |l: f64| l - 1.0 / (l * l);
    let top: f64 = rows.iter().map(|(l, p)| g(*l) * p * 1e6).sum();
    let bottom: f64 = rows.iter().map(|(l, _)| g(*l).powi(2)).sum();
    let mu = &r.parameters[0];
    assert!((mu.value / (top / bottom) - 1.0).abs() < 1e-10);
    assert!((0.3e6..0.4e6).contains(&mu.value));
    assert_eq!(r.rows, 5);
    // The law that ends at stretch 1.125 lies outside the 95 % interval: the range matters more than the scatter.
    let [low, high] = r.range_spread[0];
    assert!(low == mu.value && high > mu.interval[1], "{:?} {:?}", r.range_spread, mu.interval);
    // The table softens with stretch as every unfilled rubber does: the secant stiffness P/g falls row by row.
    let secant: Vec<f64> = r.residuals.iter().map(|x| x.measured / g(x.stretch)).collect();
    assert!(secant.windows(2).all(|w| w[1] < w[0]), "{secant:?}");
    assert!(r.warnings.iter().any(|w| matches!(w, FitWarning::Systematic { .. })), "{:?}", r.warnings);
    let kinds: Vec<_> = r.predictions.iter().map(|p| (p.mode, p.kind)).collect();
    assert_eq!(
        kinds,
        [
            (Mode::Uniaxial, PredictionKind::OutsideRange),
            (Mode::Equibiaxial, PredictionKind::OtherModeInRange),
            (Mode::Equibiaxial, PredictionKind::OtherMode),
            (Mode::Planar, PredictionKind::OtherModeInRange),
            (Mode::Planar, PredictionKind::OtherMode),
        ]
    );
}

#[test]
fn treloar_over_every_stretch_is_not_neo_hookean() {
    let r = treloar(&[Mode::Uniaxial], None);
    println!("{r}");
    assert_eq!(r.rows, 24, "the row at stretch 1 says nothing");
    let has = |f: fn(&FitWarning) -> bool| r.warnings.iter().any(f);
    assert!(has(|w| matches!(w, FitWarning::Systematic { .. })));
    assert!(has(|w| matches!(w, FitWarning::Misfit { .. })));
    let together = treloar(&Mode::ALL, Some("1..1.6"));
    println!("{together}");
    assert_eq!(together.modes, Mode::ALL);
    assert_eq!(together.curves.modes.len(), 3);
    let curve = &together.curves.modes[1];
    assert_eq!((curve.mode, curve.curve[0], curve.curve.len()), (Mode::Equibiaxial, [1.0, 0.0], 201));
    assert!((curve.curve[200][0] - 4.45).abs() < 1e-12);
    assert_eq!(curve.fitted.len() + curve.held_out.len(), 17);
}

fn assert_alike(a: &toml::Value, b: &toml::Value, at: &str) {
    let number = |v: &toml::Value| match v {
        toml::Value::String(s) => s.split(' ').next().and_then(|n| n.parse::<f64>().ok()),
        toml::Value::Float(x) => Some(*x),
        _ => None,
    };
    match (a, b) {
        (toml::Value::Table(x), toml::Value::Table(y)) => {
            assert_eq!(x.keys().collect::<Vec<_>>(), y.keys().collect::<Vec<_>>(), "{at}");
            for key in x.keys().filter(|k| *k != "durometer") {
                assert_alike(&x[key], &y[key], &format!("{at}.{key}"));
            }
        }
        (toml::Value::Array(x), toml::Value::Array(y)) => {
            assert_eq!(x.len(), y.len(), "{at}");
            x.iter().zip(y).for_each(|(x, y)| assert_alike(x, y, at));
        }
        _ => match (number(a), number(b)) {
            (Some(x), Some(y)) => assert!((x - y).abs() <= 1e-9 * x.abs().max(y.abs()), "{at}: {x} against {y}"),
            _ => assert_eq!(a, b, "{at}"),
        },
    }
}

/// The committed law is what the code writes. After a deliberate change: DUROMETER_BLESS=1 cargo test --test fit
#[test]
fn the_committed_law_of_treloar_is_reproduced() {
    let kept = data("treloar-1944/neo-hookean.toml");
    let r = treloar(&[Mode::Uniaxial], Some("1..1.6"));
    if std::env::var_os("DUROMETER_BLESS").is_some() {
        r.write_law(&kept).expect("the folder is there");
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let fresh = folder.path().join("law.toml");
    r.write_law(&fresh).expect("writable");
    let read = |path: &Path| {
        let text = std::fs::read_to_string(path).expect("readable");
        toml::Value::Table(toml::from_str(&text).expect("valid TOML"))
    };
    assert_alike(&read(&fresh), &read(&kept), "law");
    let law = read_law_table(&kept).expect("a law file");
    assert_eq!(law.keys().collect::<Vec<_>>(), ["law", "mu"], "no partner was given, none is written");
}

#[test]
fn a_law_file_reads_back_to_the_last_digit() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("law.toml");
    let mut request = FitRequest::new(data("treloar-1944/treloar-1944.csv"), "neo_hookean");
    request.options.modes = vec![Mode::Planar];
    request.options.partner = Some(Partner::Nu(0.45));
    let r = fit(&request).expect("fits");
    assert!(!r.warnings.iter().any(|w| matches!(w, FitWarning::NoPartner { .. })));
    // 2(1 + 0.45)/3 − 1 = −1/30
    let slope = |w: &FitWarning| matches!(w, FitWarning::Compressible { slope_relative: s, .. } if (s + 1.0 / 30.0).abs() < 1e-12);
    assert!(r.warnings.iter().any(slope), "{:?}", r.warnings);
    r.write_law(&path).expect("writable");
    let (law, provenance) = read_law_file(&path).expect("just written");
    assert_eq!(law["nu"].as_float(), Some(0.45));
    let mu = law["mu"].as_str().and_then(|t| t.strip_suffix(" Pa")).and_then(|t| t.parse().ok());
    assert_eq!(mu, Some(r.parameters[0].value));
    assert_eq!(provenance["sha256"].as_str(), Some(r.data_sha256.as_str()));
    assert!(provenance["source"].as_str().is_some_and(|s| s.contains("Treloar") && s.contains("1944")));
    let json = folder.path().join("fit.json");
    r.write_json(&json).expect("writable");
    let text = std::fs::read_to_string(&json).expect("readable");
    let value: serde_json::Value = serde_json::from_str(&text).expect("valid JSON");
    assert_eq!(value["parameters"][0]["value"].as_f64(), Some(r.parameters[0].value));
    let curves: FitCurves = serde_json::from_value(value["curves"].clone()).expect("a figure is drawn from the file");
    assert_eq!(curves, r.curves);
    assert_eq!(value["messages"].as_array().map(Vec::len), Some(r.warnings.len()));
    let missing = folder.path().join("absent").join("law.toml");
    assert!(r.write_law(&missing).expect_err("no folder").to_string().contains("cannot be written"));
    std::fs::write(&path, "mu = \"1 Pa\"\n").expect("writable");
    assert!(read_law_table(&path).expect_err("no law").to_string().contains("has no law"));
}

#[test]
fn a_card_with_an_unknown_key_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let table = folder.path().join("t.csv");
    std::fs::write(&table, "stretch,stress\n1.1,0.1\n1.2,0.2\n").expect("writable");
    let card =
        "name = \"t\"\nfile = \"t.csv\"\nstatus = \"own\"\nmode = \"uniaxial\"\nstrain_measurement = \"crosshead\"\n";
    let write =
        |more: &str| std::fs::write(folder.path().join("card.toml"), format!("{card}{more}")).expect("writable");
    write("[columns]\nstress_unit = \"MPa\"\n");
    let r = fit(&FitRequest::new(&table, "neo_hookean")).expect("the card says what the table does not");
    let crosshead = |w: &FitWarning| matches!(w, FitWarning::Data { message } if message.contains("crosshead"));
    assert!(r.warnings.iter().any(crosshead), "{:?}", r.warnings);
    write("[columns]\nstress_units = \"MPa\"\n");
    let message = fit(&FitRequest::new(&table, "neo_hookean")).expect_err("unknown key").to_string();
    assert!(message.contains("card.toml") && message.contains("stress_units"), "{message}");
}

/// Tensile tables of seven silicones lie beside a checkout, not in it: DUROMETER_SHARED, else `../shared`.
#[test]
fn silicone_tables_go_through_untouched() {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let shared = std::env::var_os("DUROMETER_SHARED").map_or_else(beside, PathBuf::from);
    let folder = shared.join("data/tensile");
    if !folder.is_dir() {
        println!("skipped: the silicone tables are not here; set DUROMETER_SHARED to the folder above data/tensile");
        return;
    }
    for (name, rows) in [
        ("dragon-skin-20", 404),
        ("dragon-skin-30", 311),
        ("dragon-skin-fx-pro-slacker", 798),
        ("ecoflex-00-30", 705),
        ("ecoflex-00-50", 721),
        ("mold-star-16-fast", 359),
        ("rtv615", 84),
    ] {
        let mut request = FitRequest::new(folder.join(format!("{name}.csv")), "neo_hookean");
        request.options.range = Some(StretchRange { from: 1.0, to: 1.6 });
        let r = fit(&request).unwrap_or_else(|e| panic!("{e}"));
        println!("{name}: {} ({:.1} % rms, {} rows)", r.answer(), 100.0 * r.misfit.rms_relative, r.rows);
        let e = Experiment::read(&request.data, None, &ColumnChoice::default(), None).expect("read before");
        assert_eq!(e.samples.len(), rows, "{name}");
        assert_eq!(e.modes(), [Mode::Uniaxial], "ASTM D412 is a tensile test");
        assert!(log_of(&e, AuditKind::Doubt).contains("crosshead travel"), "{name}");
        assert!(log_of(&e, AuditKind::LeftOut).is_empty(), "{name}");
        assert!((1e3..1e6).contains(&r.parameters[0].value), "{name}");
        if name == "ecoflex-00-50" {
            assert!(log_of(&e, AuditKind::Kept).contains("under tension) (line 19)"));
        }
    }
}
