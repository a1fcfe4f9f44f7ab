//! What becomes of rows before a fit: conversion of true and raw columns, order, cycles, zero and toe, and what each did to the answer.

use crate::common::Random;
use crate::common::tables::{MU, log_of, stress};
use durometer::calibrate::{
    AuditKind, ColumnChoice, Cycle, Experiment, FitError, FitOptions, FitRequest, FitResult, FitWarning, Loss, Mode,
    Preparation, Treatment, fit, fit_experiment,
};
use std::fmt::Write;

fn stretches() -> Vec<f64> {
    (0..40).map(|k| 1.02 + 0.03 * f64::from(k)).collect()
}

fn read(text: &str, choice: &ColumnChoice) -> Result<Experiment, FitError> {
    Experiment::parse("made.csv", text.as_bytes(), None, choice, Some(Mode::Uniaxial))
}

fn prepared(text: &str, asked: &Preparation) -> Experiment {
    read(text, &ColumnChoice::default()).and_then(|e| e.prepare(asked)).unwrap_or_else(|e| panic!("{e}"))
}

fn refused(text: &str, asked: &Preparation) -> String {
    let answer = read(text, &ColumnChoice::default()).and_then(|e| e.prepare(asked));
    answer.expect_err("must be refused").to_string()
}

fn mu(e: &Experiment) -> f64 {
    fitted(e).parameters[0].value
}

fn fitted(e: &Experiment) -> FitResult {
    fit_experiment(e, &FitOptions::new("neo_hookean")).expect("well posed")
}

fn table(header: &str, rows: impl IntoIterator<Item = (f64, f64)>) -> String {
    let mut text = header.to_string() + "\n";
    rows.into_iter().for_each(|(x, y)| writeln!(text, "{x},{y}").expect("a string"));
    text
}

/// Tension and compression in one table are two loadings that are both fitted, in either order; where each is repeated, the first loading of each.
#[test]
fn tension_and_compression_have_loadings_of_their_own() {
    let up: Vec<f64> = (1..=20).map(|k| 1.0 + 0.05 * f64::from(k)).collect();
    let pressed: Vec<f64> = (1..=20).map(|k| 1.0 - 0.025 * f64::from(k)).collect();
    let rows =
        |stretches: &[f64]| table("stretch,stress (Pa)", stretches.iter().map(|l| (*l, stress(Mode::Uniaxial, *l))));
    for order in [[&up[..], &pressed], [&pressed, &up]] {
        let e = prepared(&rows(&order.concat()), &Preparation::default());
        assert_eq!((e.samples.len(), log_of(&e, AuditKind::LeftOut)), (40, String::new()));
        assert!(e.alternatives.is_empty() && (mu(&e) / MU - 1.0).abs() < 1e-12);
    }
    let back = |there: &[f64]| there.iter().rev().skip(1).copied().collect::<Vec<f64>>();
    let cycle = [&up[..], &back(&up), &pressed, &back(&pressed)].concat();
    let e = prepared(&rows(&[&cycle[..], &cycle].concat()), &Preparation::default());
    let fitted: Vec<f64> = e.samples.iter().map(|s| s.stretch).collect();
    // In the order of stretch, as data points without time
    let by_stretch = [pressed.iter().rev().copied().collect(), up.clone()].concat();
    assert_eq!(fitted, by_stretch);
    let log = log_of(&e, AuditKind::LeftOut);
    assert!(log.contains("2 of uniaxial in tension, 2 of uniaxial in compression"), "{log}");
    // Data points near rest are no other side
    let noisy: Vec<f64> = [0.999].into_iter().chain(up).collect();
    assert_eq!(prepared(&rows(&noisy), &Preparation::default()).samples.len(), 21);
}

/// The same test written in four ways: nominal, true (σ = λP, e = ln λ), and as a machine records it (a piece of 33 × 6 × 3 mm, and a
/// cylinder), each gives the constant back to rounding. The log names the conversion.
#[test]
fn true_and_raw_columns_become_nominal() {
    let p = |l: f64| stress(Mode::Uniaxial, l);
    let of = |header: &str, row: &dyn Fn(f64) -> (f64, f64)| table(header, stretches().into_iter().map(row));
    let strip = ["33 mm", "6 mm", "3 mm"];
    let text = of("true strain,true stress (Pa)", &|l| (l.ln(), l * p(l)));
    let e = read(&text, &ColumnChoice::default()).expect("readable");
    assert!((mu(&e) / MU - 1.0).abs() < 1e-12);
    let log = log_of(&e, AuditKind::Intake);
    assert!(log.contains("λ = exp(true strain)") && log.contains("P = σ/λ"), "{log}");

    let mut choice = ColumnChoice::default();
    for (key, value) in ["gauge_length", "width", "thickness"].into_iter().zip(strip) {
        choice.dimensions.set(key, value).expect("valid");
    }
    let raw = of("Traversenweg [mm],Standardkraft [N]", &|l| (33.0 * (l - 1.0), p(l) * 18e-6));
    let e = read(&raw, &choice).expect("readable");
    assert!((mu(&e) / MU - 1.0).abs() < 1e-12);
    let log = log_of(&e, AuditKind::Intake);
    assert!(log.contains("gauge length 33.0") && log.contains("18.000000 mm² (6 mm × 3 mm)"), "{log}");
    assert!(log_of(&e, AuditKind::Doubt).contains("--strain-from extensometer"));
    let row = e.raw[3];
    let l = stretches()[3];
    assert!((row.displacement.expect("recorded") / (33e-3 * (l - 1.0)) - 1.0).abs() < 1e-12);
    assert!((row.force.expect("recorded") / (18e-6 * p(l)) - 1.0).abs() < 1e-12);
    choice.strain_measurement = Some("extensometer".into());
    let measured = read(&raw, &choice).expect("readable");
    assert!(log_of(&measured, AuditKind::Doubt).is_empty());

    let area = std::f64::consts::PI * 0.25 * 1e-4;
    let with_header = "Diameter (mm),10\nGauge length,2 cm\n".to_string()
        + &of("Extension (mm),Load (kN)", &|l| (20.0 * (l - 1.0), 1e-3 * p(l) * area));
    let e = read(&with_header, &ColumnChoice::default()).expect("the header has the dimensions");
    assert!((mu(&e) / MU - 1.0).abs() < 1e-12);

    choice.dimensions.set("area", "20 mm^2").expect("valid");
    let message = read(&raw, &choice).expect_err("6 × 3 is not 20").to_string();
    assert!(message.contains("20.0000 mm² from one set of dimensions and 18.0000 mm² from another"), "{message}");
    let message = choice.dimensions.set("width", "-3 mm").expect_err("negative").to_string();
    assert!(message.contains("width") && message.contains("above zero"), "{message}");
}

/// Dimensions, measurement and preparation of a card; a force and its strain in one table.
#[test]
fn a_card_gives_dimensions_and_preparation() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let rows = stretches().into_iter().map(|l| (100.0 * (l - 1.0 + 0.01), stress(Mode::Uniaxial, l) * 18e-6));
    let data = folder.path().join("t.csv");
    std::fs::write(&data, table("Dehnung (%),Kraft (N)", rows)).expect("writable");
    let card = "name = \"t\"\nfile = \"t.csv\"\nstatus = \"own\"\nmode = \"uniaxial\"\nstrain_measurement = \"extensometer\"\n\
                [specimen]\nwidth = \"6 mm\"\nthickness = \"3 mm\"\n[preparation]\ntoe = \"30 kPa\"\n";
    std::fs::write(folder.path().join("card.toml"), card).expect("writable");
    let r = fit(&FitRequest::new(&data, "neo_hookean")).expect("fits");
    let toe = r.otherwise.iter().find(|o| o.treatment == Treatment::WithoutToe).expect("asked by the card");
    assert!((r.parameters[0].value / MU - 1.0).abs() < (toe.parameters[0].value / MU - 1.0).abs());
    std::fs::write(folder.path().join("card.toml"), card.replace("6 mm", "6 kPa")).expect("writable");
    let message = fit(&FitRequest::new(&data, "neo_hookean")).expect_err("a width in kPa").to_string();
    assert!(message.contains("width = \"6 kPa\"") && message.contains("wrong dimension"), "{message}");
}

/// A misspelt dimension of a card is refused, the card of another table is named, and a correction that one of two specimens lacks is a doubt.
#[test]
fn nothing_of_a_card_is_passed_over() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name);
    for (name, scale) in [("t.csv", 1.0), ("u.csv", 1.05)] {
        let rows = stretches().into_iter().map(|l| (33.0 * (l - 1.0), scale * stress(Mode::Uniaxial, l) * 18e-6));
        std::fs::write(at(name), table("Extension (mm),Load (N)", rows)).expect("writable");
    }
    let card = |file: &str, compliance: &str| {
        let own = "[specimen]\nshape = \"a strip\"\ngauge_length = \"33 mm\"\narea = \"18 mm^2\"\n";
        let text = format!("name = \"t\"\nfile = \"{file}\"\nstatus = \"own\"\nmode = \"uniaxial\"\n{own}");
        std::fs::write(at("card.toml"), format!("{text}{compliance} = \"0.002 mm/N\"\n")).expect("writable");
    };
    card("t.csv", "complience");
    let message = fit(&FitRequest::new(at("t.csv"), "neo_hookean")).expect_err("misspelt").to_string();
    assert!(message.contains("`complience`") && message.contains("write `compliance`"), "{message}");
    let logged = |file: &str, more: &[&str], kind: AuditKind| {
        card(file, "compliance");
        let mut request = FitRequest::new(at("t.csv"), "neo_hookean");
        request.more = more.iter().map(|name| at(name)).collect();
        request.options.modes = vec![Mode::Uniaxial];
        request.columns.dimensions.set("gauge_length", "33 mm").expect("valid");
        request.columns.dimensions.set("area", "18 mm^2").expect("valid");
        let audit = fit(&request).expect("fits").audit;
        audit.of(kind).map(|entry| format!("{}\n", entry.message)).collect::<String>()
    };
    let unequal = "the compliance of the machine was corrected in t.csv, and not in u.csv";
    let doubts = logged("t.csv", &["u.csv"], AuditKind::Doubt);
    assert!(doubts.contains(unequal), "{doubts}");
    let read = logged("t.csv", &["u.csv"], AuditKind::Intake);
    assert!(read.contains("u.csv: card.toml next to the table is of \"t.csv\", and was not used"), "{read}");
    assert!(!logged("t.csv", &[], AuditKind::Doubt).contains("corrected in"));
    let doubts = logged("T.csv", &[], AuditKind::Doubt);
    assert!(doubts.contains("card.toml next to the table is of \"T.csv\", and was not used"), "{doubts}");
}

/// Reference case 21f. Slack of 0.05, noise of 200 Pa before the piece carries, an offset of 700 Pa, no origin row. The line through the rows
/// between p = 4 kPa and 3p moves the zero by −3(p/E)² = −4e-5 (E = 3μ) and noise by about 200 Pa/E/√3 = 1e-4: 1e-3 holds both tenfold.
#[test]
fn toe_and_offset_are_handled_and_logged() {
    let mut noise = Random::seed(21);
    let slack = 0.05;
    let row = |k: u32| {
        let e = 0.001 * f64::from(k + 1);
        let p = if e > slack { stress(Mode::Uniaxial, 1.0 + e - slack) } else { 0.0 };
        (e, p + 700.0 + 200.0 * noise.normal())
    };
    let text = table("engineering strain,nominal stress (Pa)", (0..400).map(row));
    let asked = Preparation { zero: Some(30), toe: Some("4 kPa".into()), cycle: None };
    let e = prepared(&text, &asked);
    let first = e.samples[0];
    let raw = 0.001 * (first.line - 1) as f64;
    let shift = raw - (first.stretch - 1.0);
    assert!((shift - slack).abs() < 1e-3, "{shift}");
    let changed = log_of(&e, AuditKind::Changed);
    assert!(changed.contains("first 30 data points") && changed.contains("reaches zero stress at 0.0"), "{changed}");
    assert!(log_of(&e, AuditKind::LeftOut).contains("uniaxial data points of the toe"));
    // Of μ: noise 200 Pa over 350 rows of up to 200 kPa, 1e-4, and the offset of 700 Pa, known to 200/√30 = 37 Pa: 1e-3 of μ at most
    let r = fitted(&e);
    assert!((r.parameters[0].value / MU - 1.0).abs() < 5e-3, "{}", r.parameters[0].value / MU);
    let without = |t: Treatment| r.otherwise.iter().find(|o| o.treatment == t).expect("tried").clone();
    let toe = without(Treatment::WithoutToe);
    assert!((toe.parameters[0].value / MU - 1.0).abs() > 0.05 && toe.change > 0.05, "{toe:?}");
    assert!(without(Treatment::WithoutZero).change < toe.change);
    let said = r.to_string();
    assert!(said.contains("without toe compensation (") && said.contains("without zeroing ("), "{said}");
    assert!(r.law_text().contains("was shifted by"), "the law file says so too");

    let ask = |zero, toe: Option<&str>| Preparation { zero, toe: toe.map(Into::into), cycle: None };
    assert!(refused(&text, &ask(Some(201), None)).contains("from 1 to half of them"));
    assert!(refused(&text, &ask(None, Some("9 MPa"))).contains("give a lower level"));
    assert!(refused(&text, &ask(None, Some("4"))).contains("4 has no unit"));
    assert!(refused(&text, &ask(None, Some("0 Pa"))).contains("above zero"));
}

/// A pull to a stretch of 2 with a hold, in which the stress relaxes by a quarter, and the way back. With the data points of the hold μ is 9 % too small; without them it is that of the
/// pull, to the noise of 0.1 % (3 standard errors). The log says so, and `--cycle all` takes them.
#[test]
fn a_hold_at_the_peak_is_no_loading() {
    let up = || (0..50).map(|k| 1.0 + f64::from(k) / 49.0);
    let made = |hold: u32, back: bool| {
        let mut noise = Random::seed(7);
        let relaxed = move |k: u32| 1.0 - 0.25 * (1.0 - (-4.0 * f64::from(k) / f64::from(hold)).exp());
        let pull = up().map(|l| (l, stress(Mode::Uniaxial, l)));
        let held = (0..hold).map(|k| (2.0, relaxed(k) * stress(Mode::Uniaxial, 2.0)));
        let down = up().rev().skip(1).filter(|_| back).map(|l| (l, 0.7 * stress(Mode::Uniaxial, l)));
        let all: Vec<(f64, f64)> = pull.chain(held).chain(down).collect();
        let rows = all.into_iter().map(|(l, p)| (l + 1e-4 * noise.normal() * f64::from(u8::from(l == 2.0)), p));
        let rows: Vec<(f64, f64)> = rows.collect();
        table("stretch,nominal stress (Pa)", rows.into_iter().map(|(l, p)| (l, p + 0.001 * MU * noise.normal())))
    };
    for (hold, back) in [(30, false), (30, true), (200, false), (200, true)] {
        let e = prepared(&made(hold, back), &Preparation::default());
        // 0.1 % of μ, with fifty data points of up to 1.75 μ: 3e-4, and 1e-4 of a stretch of 2
        assert!((mu(&e) / MU - 1.0).abs() < 1e-3, "{hold} {back}: {}", mu(&e) / MU);
        let left = log_of(&e, AuditKind::LeftOut);
        assert!(
            left.contains("hold at the peak: the stress relaxes by 2") && left.contains("`durometer prony`"),
            "{left}"
        );
        let r = fitted(&e);
        let with = r.otherwise.iter().find(|o| o.treatment == Treatment::WithHold).expect("tried");
        assert!(with.parameters[0].value < 0.97 * MU && r.to_string().contains("with the hold at the peak"), "{r}");
        let warned = r.warnings.iter().any(|w| matches!(w, FitWarning::Cycles { .. }));
        assert_eq!(warned, back, "a hold alone is no cycle: {r}");
        let all = prepared(&made(hold, back), &Preparation { cycle: Some(Cycle::All), ..Preparation::default() });
        assert!(log_of(&all, AuditKind::LeftOut).is_empty() && mu(&all) < 0.97 * MU);
    }
}

/// One data point of forty that is five times the modulus: no rupture, so that all of them are fitted, and the terminal names its file and line, of one table and of several.
/// Huber's loss gives the constant back.
#[test]
fn a_spike_is_named_and_removes_nothing() {
    let mut noise = Random::seed(3);
    let mut made = |wrong: Option<usize>| {
        let row = |k: usize| {
            let l = 1.02 + 0.025 * k as f64;
            (l, if wrong == Some(k) { 5.0 * MU } else { stress(Mode::Uniaxial, l) + 0.005 * MU * noise.normal() })
        };
        table("stretch,nominal stress (Pa)", (0..40).map(row))
    };
    let [first, second] = [made(None), made(Some(3))];
    let e = prepared(&second, &Preparation::default());
    assert!(log_of(&e, AuditKind::LeftOut).is_empty());
    let squares = fitted(&e);
    assert_eq!(squares.rows, 40);
    let warned =
        "warning: data points far from their neighbours influence the fit (1 of made.csv: line 5); pass --loss";
    assert!(squares.to_string().contains(warned), "{squares}");
    let huber = FitOptions { loss: Loss::Huber, ..FitOptions::new("neo_hookean") };
    let huber = fit_experiment(&e, &huber).expect("well posed");
    // 0.5 % of μ in forty data points of up to 1.75 μ is 1e-3 of it; the limited one moves it by a few times that
    assert!((huber.parameters[0].value / MU - 1.0).abs() < 0.01, "{}", huber.parameters[0].value / MU);
    let noted =
        "note: data points far from their neighbours have a limited weight by --loss huber (1 of made.csv: line 5)";
    assert!(huber.to_string().contains(noted), "{huber}");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [one, two] = [("one.csv", &first), ("two.csv", &second)].map(|(name, text)| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("writable");
        path
    });
    let mut request = FitRequest::new(&one, "neo_hookean");
    (request.options.modes, request.more) = (vec![Mode::Uniaxial], vec![two]);
    let both = fit(&request).expect("fits");
    assert!(both.to_string().contains("influence the fit (1 of two.csv: line 5)"), "{both}");
}

/// A piece that breaks after three quarters of the table: the rest is left out, the terminal names its file and lines, and the fit is repeated with it.
#[test]
fn a_rupture_is_named_with_the_answer_without_it() {
    let row = |k: u32| {
        let l = 1.0 + 0.025 * f64::from(k);
        (l, if k < 30 { stress(Mode::Uniaxial, l) } else { 0.01 * MU })
    };
    let rows = (1..=40).map(row);
    let r = fitted(&prepared(&table("stretch,nominal stress (Pa)", rows), &Preparation::default()));
    assert!(r.rows == 29 && (r.parameters[0].value / MU - 1.0).abs() < 1e-9, "{r}");
    let with = r.otherwise.iter().find(|o| o.treatment == Treatment::WithRupture).expect("tried");
    assert!(with.rows == 40 && !with.unasked && with.parameters[0].value < 0.9 * MU, "{with:?}");
    let said = r.to_string();
    assert!(said.contains("with the data points after rupture (40 data points): μ = "), "{said}");
    assert!(
        said.contains("note: left out: uniaxial data points after rupture in made.csv: ")
            && said.contains("lines 31, ")
    );
}

/// Of two tables the first one is of a piece that breaks: the fit is repeated with all of its data points, and with those of the other as they are.
#[test]
fn a_rupture_in_one_of_several_tables_is_told_with_the_answer_without_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, rows: Vec<(f64, f64)>| {
        let path = folder.path().join(name);
        std::fs::write(&path, table("stretch,nominal stress (Pa)", rows)).expect("writable");
        path
    };
    let pulled = |step: f64, rows: u32, whole: u32| {
        let at = |k: u32| {
            let l = 1.0 + step * f64::from(k);
            (l, if k < whole { stress(Mode::Uniaxial, l) } else { 0.01 * MU })
        };
        (1..=rows).map(at).collect::<Vec<_>>()
    };
    let torn = write("torn.csv", pulled(0.025, 40, 30));
    let mut request = FitRequest::new(&torn, "neo_hookean");
    request.options.modes = vec![Mode::Uniaxial];
    request.more = vec![write("whole.csv", pulled(0.03, 20, 21))];
    let r = fit(&request).expect("fits");
    assert!(r.rows == 49 && (r.parameters[0].value / MU - 1.0).abs() < 1e-9, "{r}");
    let with = r.otherwise.iter().find(|o| o.treatment == Treatment::WithRupture).expect("tried");
    assert!(with.rows == 60 && !with.unasked && with.parameters[0].value < 0.9 * MU, "{with:?}");
}

/// Two cycles to a stretch of 2, the second 30 % softer, unloading softer still (as in Mullins' tests). Each choice gives the constant of its
/// loading back; without one the first is fitted, and the warning says what the last gives.
#[test]
fn cycles_are_told_apart() {
    let up: Vec<f64> = (1..=20).map(|k| 1.0 + 0.05 * f64::from(k)).collect();
    let branch = |factor: f64, reverse: bool| {
        let mut rows: Vec<(f64, f64)> = up.iter().map(|l| (*l, factor * stress(Mode::Uniaxial, *l))).collect();
        if reverse {
            rows.pop();
            rows.reverse();
        }
        rows
    };
    let rows = [branch(1.0, false), branch(0.6, true), branch(0.7, false), branch(0.6, true)].concat();
    let text = table("stretch,nominal stress (Pa)", rows);
    let with = |cycle| prepared(&text, &Preparation { cycle, ..Preparation::default() });
    for (cycle, factor, rows) in [
        (None, 1.0, 20),
        (Some(Cycle::FirstLoading), 1.0, 20),
        (Some(Cycle::LastLoading), 0.7, 19),
        (Some(Cycle::Loading(2)), 0.7, 19),
    ] {
        let e = with(cycle);
        assert_eq!(e.samples.len(), rows, "{cycle:?}");
        assert!((mu(&e) / (factor * MU) - 1.0).abs() < 1e-12, "{cycle:?}");
        assert!(log_of(&e, AuditKind::LeftOut).contains("data points of other branches"));
    }
    assert_eq!(with(Some(Cycle::All)).samples.len(), 78);
    let warned = |e: &Experiment| fitted(e).warnings.into_iter().find(|w| matches!(w, FitWarning::Cycles { .. }));
    let Some(FitWarning::Cycles { treatment: Treatment::LastLoading, change, answer }) = warned(&with(None)) else {
        panic!("no warning")
    };
    assert!((change - 0.3).abs() < 1e-12 && answer.contains("μ = 259.7 kPa"), "{change} {answer}");
    assert_eq!(warned(&with(Some(Cycle::LastLoading))), None, "asked for");
    let message = refused(&text, &Preparation { cycle: Some(Cycle::Loading(3)), ..Preparation::default() });
    assert!(message.contains("--cycle 3 asks for a loading that is not there: the table has 2"), "{message}");
    assert!("0".parse::<Cycle>().expect_err("counted from 1").contains("first-loading"));
}

/// The noise of an extensometer, up to four times the distance of two rows, is no unloading: of 25 monotonic pulls each, every row is fitted. Three cycles
/// with noise of 1 % of their range are still three.
#[test]
fn noise_of_the_strain_is_no_unloading() {
    let text = |stretches: &dyn Fn(usize) -> f64, rows: usize, deviation: f64, seed: u64| {
        let mut random = Random::seed(seed.wrapping_mul(0x9e37_79b9) + 5);
        let row = |k: usize| {
            let l = stretches(k);
            let (e, p) = (deviation * random.normal(), 200.0 * random.normal());
            (l + e, stress(Mode::Uniaxial, l) + p)
        };
        table("stretch,nominal stress (Pa)", (0..rows).map(row))
    };
    for (deviation, rows, last) in [(0.006, 200, 2.0), (0.008, 200, 2.0), (0.003, 200, 1.3), (0.003, 100, 1.3)] {
        let pull = |k: usize| 1.05 + (last - 1.05) * k as f64 / (rows - 1) as f64;
        for seed in 1..=25 {
            let e = prepared(&text(&pull, rows, deviation, seed), &Preparation::default());
            assert_eq!(e.samples.len(), rows, "errors of {deviation}, {rows} rows up to {last}, draw {seed}");
        }
    }
    let cycles = |k: usize| 1.5 - 0.4 * (std::f64::consts::TAU * k as f64 / 100.0).cos();
    for seed in 1..=25 {
        let e = prepared(&text(&cycles, 300, 0.008, seed), &Preparation::default());
        assert!((45..=55).contains(&e.samples.len()), "draw {seed}: {} rows", e.samples.len());
        assert!(log_of(&e, AuditKind::LeftOut).contains("the table has 3 of uniaxial loadings"));
    }
}

/// Rows of a cyclic test out of order are put into the order of time; a time column that goes back over a stretch that does not is not
/// believed, as where 40.9 is followed by 40.10.
#[test]
fn the_order_of_time_is_taken_where_it_is_one() {
    let row = |k: usize| {
        let l = 1.05 + 0.05 * (if k < 20 { k } else { 39 - k }) as f64;
        (k, l, stress(Mode::Uniaxial, l))
    };
    let text = |order: &dyn Fn(usize) -> usize, time: &dyn Fn(usize) -> f64| {
        let mut text = "time (s),stretch,nominal stress (Pa)\n".to_string();
        for (k, l, p) in (0..40).map(order).map(row) {
            writeln!(text, "{},{l},{p}", time(k)).expect("a string");
        }
        text
    };
    let e = prepared(&text(&|k| k * 17 % 40, &|k| k as f64), &Preparation::default());
    assert!(log_of(&e, AuditKind::Changed).contains("order of the time column"));
    assert_eq!(e.samples.len(), 21, "the loading, with both rows at its end");
    assert!(e.samples.windows(2).all(|w| w[0].stretch <= w[1].stretch));
    let e = prepared(&text(&|k| k, &|k| if k < 10 { k as f64 } else { 0.1 * k as f64 }), &Preparation::default());
    assert!(log_of(&e, AuditKind::Kept).contains("the order was kept"));
    assert!(log_of(&e, AuditKind::Changed).is_empty());
}
