//! What tables may look like: dialects, unusual rows, refusals, cards, silicone tables.

use crate::common::tables::{fitted, log_of, parsed, refusal, stress, table};
use crate::common::tools;
use durometer::calibrate::{
    AuditKind, ColumnChoice, Experiment, FitOptions, FitRequest, FitResult, FitWarning, Mode, Partner, Preparation,
    Sign, StretchRange, fit, fit_experiment,
};
use std::path::PathBuf;

#[test]
fn every_dialect_of_a_table_reads_alike() {
    let expected = [(1.1, 0.1e6), (1.25, 0.2e6), (1.5, 0.3e6)];
    for text in [
        "stretch,nominal stress (MPa)\n1.1,0.1\n1.25,0.2\n1.5,0.3\n",
        "\u{feff}stretch;stress (MPa)\r\n1,1;0,1\r\n1,25;0,2\r\n1,5;0,3\r\n",
        "Specimen\tA\nTime (s)\tEngineering Strain (%)\tTrue Stress (MPa)\tEngineering Stress (MPa)\n0\t10\t9\t0.1\n1\t25\t9\t0.2\n2\t50\t9\t0.3\n",
        "stretch,stress (MPa)\n\"1,1\",\"0,1\"\n\"1,25\",\"0,2\"\n\"1,5\",\"0,3\"\n",
        "strain,true strain,stress/kPa\n0.1,7,100\n0.25,7,200\n0.5,7,300\n",
        "Zeit;Dehnung;Spannung\ns;%;MPa\n0;10;0,1\n1;25;0,2\n2;50;0,3\n",
        "Nennspannung in MPa\ttechnische Dehnung in %\n0,1\t10\n0,2\t25\n0,3\t50\n",
        "extension ratio,stress (MPa)\n1.1,0.1\n1.25,0.2\n1.5,0.3\n",
        "Extension_Ratio [-];stress [MPa]\n1.1;0.1\n1.25;0.2\n1.5;0.3\n",
        "Control;Displacement;Load\nstretch;stress (Pa)\n1.1;100,000.0\n1.25;200,000.0\n1.5;300,000.0\n",
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
        "each occurrence counts (line 8)",
        "both count (line 9)",
        "smaller than in the data point before (order of the file or unloading); the order does not enter the fit, unloading would (line 7)",
        "under tension) (line 10)",
        "offset was not subtracted (line 2)",
    ] {
        assert!(kept.contains(fact), "{fact} not in:\n{kept}");
    }
    assert_eq!(e.samples.len(), 7);
    assert!(log_of(&e, AuditKind::Doubt).contains("5 of 12 data points could not be read"));
}

#[test]
fn bad_tables_are_refused_with_fact_and_remedy() {
    for (text, facts) in [
        ("stretch,nominal stress (MPa)\n1.1,0\n1.2,0\n", &["every stress", "zero", "check the stress column"][..]),
        (
            "stretch,nominal stress (MPa)\n1.1,-1\n1.2,-2\n",
            &["against the stretch", "pass --stress-positive compression"],
        ),
        (
            "Displacement (mm),Force (N)\n1,2\n2,3\n",
            &[
                "\"Displacement (mm)\" is a displacement",
                "--gauge-length",
                "gauge_length under [specimen] of a card.toml with name, file and status",
            ],
        ),
        (
            "strain,Force (N)\n1,2\n2,3\n",
            &[
                "\"Force (N)\" is a force",
                "--width and --thickness",
                "under [specimen] of a card.toml with name, file and status",
            ],
        ),
        ("Time (s),Temperature\n1,2\n2,3\n", &["\"Time (s)\", \"Temperature\"", "--strain-column"]),
        ("Extension,Load (N)\n1,2\n2,3\n", &["\"Extension\" has no unit", "--strain-unit mm"]),
        ("a;b\n1,5;2,5\n", &["the columns are: \"a\", \"b\""]),
        (
            "engineering strain,stress (MPa)\n10,0.1\n50,0.3\n100,0.5\n",
            &["a stretch of 101", "percent", "--strain-unit %"],
        ),
        ("stretch,stress (MPa)\n1,0.1\n81,0.3\n", &["a stretch of 81", "--strain-unit 1"]),
        ("strain;stress (MPa)\n1,250;1,125\n2,500;2,250\n", &["\"1,250\" may be a decimal", "--decimal comma"]),
        ("strain,stress (MPa)\n0,1,0,5\n0,2,0,9\n", &["line 2 has 4 cells under 2 names", "export it with ;"]),
        ("shear strain,stress (MPa),mode\n0.1,0.5,biaxial\n", &["biaxial data points need --mode biaxial"]),
        ("stretch,nominal stress\n1.1,0.1\n", &["\"nominal stress\" has no unit", "--stress-unit MPa"]),
        ("stretch,nominal stress (mpa)\n1.1,0.1\n", &["unit \"mpa\"", "MPa"]),
        ("stretch,stress (MPa),stress 2 (MPa)\n1.1,0.1,1\n", &["may be any of", "--stress-column"]),
        ("stretch,nominal stress (MPa)\n", &["no data below the column names"]),
        ("stretch,nominal stress (MPa)\nx,1\n", &["line 2", "not a number"]),
        ("stretch,nominal stress (MPa)\n1.1,0.1\n", &["holds 1 data points", "2 are needed"]),
        ("stretch,nominal stress (MPa)\n1,0.1\n1,0.2\n", &["holds 0 data points"]),
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
    assert!(ask(&|o| o.modes = vec![Mode::Equibiaxial]).contains("no equibiaxial data; present: uniaxial, planar"));
    assert!(ask(&|o| o.law = "neo_hokean".into()).contains("did you mean `neo_hookean`? (known: "));
    let far = ask(&|o| o.law = "xyz".into());
    assert!(far.contains("law \"xyz\" cannot be fitted; known: "), "{far}");
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
fn a_misread_unit_is_doubted() {
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
        ..ColumnChoice::default()
    };
    let e = Experiment::parse("t.csv", text, None, &choice, Some(Mode::Planar)).expect("all is stated");
    assert_eq!((e.samples[0].stretch, e.samples[0].stress), (1.1, 100e3));
    let untold = ColumnChoice { strain_kind: None, ..choice };
    let message = Experiment::parse("t.csv", text, None, &untold, None).expect_err("kind unknown").to_string();
    assert!(message.contains("--strain-kind"), "{message}");
}

#[test]
fn a_card_with_an_unknown_key_or_without_its_beginning_is_refused() {
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
    assert!(!message.contains("a card begins with"), "{message}");
    std::fs::write(folder.path().join("card.toml"), "[specimen]\ngauge_length = \"33 mm\"\n").expect("writable");
    let message = fit(&FitRequest::new(&table, "neo_hookean")).expect_err("no name").to_string();
    let words = ["missing field `name`", "; a card begins with name = \"…\", file = \"…\"", "and status = "];
    assert!(words.iter().all(|w| message.contains(w)), "{message}");
}

/// A flag that no table and no law makes use of is refused; the same flag is taken where it acts.
#[test]
fn flags_without_effect_are_refused() {
    type Change<'a> = &'a dyn Fn(&mut FitRequest);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, text: String| {
        std::fs::write(folder.path().join(name), text).expect("writable");
        folder.path().join(name)
    };
    let plain = write("plain.csv", table(Mode::Uniaxial, "stretch,nominal stress (MPa)", 1e6));
    let row = |k: u32| {
        let l = 1.0 + 0.05 * f64::from(k);
        format!("{},{}\n", 33.0 * (l - 1.0), 18e-6 * stress(Mode::Uniaxial, l))
    };
    let raw = write("raw.csv", format!("Extension (mm),Load (N)\n{}", (1..30).map(row).collect::<String>()));
    let answer = |data: &PathBuf, law: &str, change: Change| {
        let mut request = FitRequest::new(data, law);
        request.options.modes = vec![Mode::Uniaxial];
        change(&mut request);
        fit(&request).map_err(|e| e.to_string())
    };
    let size = |key, text| move |r: &mut FitRequest| r.columns.dimensions.set(key, text).expect("valid");
    let (length, area) = (size("gauge_length", "33 mm"), size("area", "18 mm^2"));
    let (width, thickness, diameter) = (size("width", "6 mm"), size("thickness", "3 mm"), size("diameter", "5 mm"));
    let stable = |r: &mut FitRequest| r.options.stable = Some(StretchRange { from: 0.5, to: 2.0 });
    let named = |r: &mut FitRequest| (r.columns.strain_2, r.columns.lateral) = (Some("a".into()), Some("b".into()));
    let whole = |r: &mut FitRequest| [&length as Change, &area].into_iter().for_each(|change| change(r));
    let cases: [(&str, &PathBuf, &str, Change); 11] = [
        ("strain-column-2", &plain, "neo_hookean", &named),
        ("stress-column-2", &plain, "neo_hookean", &|r| r.columns.stress_2 = Some("a".into())),
        ("lateral-column", &plain, "neo_hookean", &|r| r.columns.lateral = Some("b".into())),
        ("lateral-unit", &plain, "neo_hookean", &|r| r.columns.lateral_unit = Some("%".into())),
        ("gauge-length", &plain, "neo_hookean", &length),
        ("area", &plain, "neo_hookean", &area),
        ("diameter", &plain, "neo_hookean", &diameter),
        ("width", &raw, "neo_hookean", &|r| [&whole as Change, &width].into_iter().for_each(|change| change(r))),
        ("thickness", &raw, "neo_hookean", &|r| {
            [&whole as Change, &thickness].into_iter().for_each(|change| change(r))
        }),
        ("stable", &plain, "ogden", &stable),
        ("stable", &plain, "gent", &stable),
    ];
    for (flag, data, law, change) in cases {
        let said = answer(data, law, change).expect_err(flag);
        assert!(said.starts_with(&format!("--{flag} has no effect here: ")), "{flag}: {said}");
        assert!(said.ends_with("; leave it out"), "{flag}: {said}");
    }
    let all: [Change; 5] = [&length, &width, &thickness, &area, &stable];
    let taken = answer(&raw, "yeoh", &|r| all.into_iter().for_each(|change| change(r)));
    taken.unwrap_or_else(|e| panic!("{e}"));
    // An error of the compliance takes the dimensions too
    let errors = |r: &mut FitRequest| {
        whole(r);
        r.options.accuracy = "compliance=0.0001 mm/N".parse().expect("valid");
    };
    answer(&plain, "neo_hookean", &errors).unwrap_or_else(|e| panic!("{e}"));
}

/// A mode that is asked for twice is one; several need a column that says which data points are of which.
#[test]
fn several_modes_need_a_column() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let data = folder.path().join("t.csv");
    std::fs::write(&data, table(Mode::Uniaxial, "stretch,nominal stress (MPa)", 1e6)).expect("writable");
    let fitted = |modes: &[Mode]| {
        let mut request = FitRequest::new(&data, "neo_hookean");
        request.options.modes = modes.to_vec();
        fit(&request).map(|r| r.modes).map_err(|e| e.to_string())
    };
    assert_eq!(fitted(&[Mode::Uniaxial; 2]), Ok(vec![Mode::Uniaxial]));
    let said = fitted(&[Mode::Uniaxial, Mode::Planar]).expect_err("one table of two modes");
    assert!(said.contains("no column says which data points are uniaxial or planar"), "{said}");
}

/// Tensile tables of seven silicones.
#[test]
#[ignore = "reads public data outside of the project, from the folder that DUROMETER_SHARED names"]
fn silicone_tables_go_through_untouched() {
    let folder = tools::shared("data/tensile");
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

/// Lines of strain and stress of a Neo-Hookean rubber with 1 % of noise; `real` is the stretch of a number.
fn pulled(header: &str, end: f64, real: impl Fn(f64) -> f64) -> String {
    let row = |k: usize| {
        let (e, wobble) = (end * (k + 1) as f64 / 30.0, 1.0 + 0.01 * (7.0 * k as f64).sin());
        format!("{e:.5},{:.7}\n", wobble * stress(Mode::Uniaxial, real(e)).abs() / 1e6)
    };
    format!("{header}\n") + &(0..30).map(row).collect::<String>()
}

/// A strain up to 1.5 without a unit is 150 %, which the answer says; where the stresses rise in a straight line, as those up to 1.5 % do, a doubt names the flag.
#[test]
fn percent_below_two_are_doubted_by_their_straight_line() {
    let doubt = |r: &FitResult| r.to_string().contains("column \"strain\" has no unit and was read in fractions");
    for end in [0.5, 1.0, 1.5, 2.0] {
        let fractions = fitted(&pulled("strain,stress (MPa)", end, |e| 1.0 + e));
        assert!(!doubt(&fractions), "{fractions}");
        let range = format!("(strain {} to {} %)", 100.0 * (end / 30.0 * 1e5).round() / 1e5, 100.0 * end);
        assert!(fractions.to_string().contains(&range[range.find("to").expect("a range")..]), "{range} {fractions}");
        let text = pulled("strain,stress (MPa)", end, |e| 1.0 + e / 100.0);
        let percent = fitted(&text);
        assert!(doubt(&percent) || end < 1.0, "{percent}");
        let said = percent.to_string();
        assert!(
            !doubt(&percent) || said.contains("--strain-unit % if its numbers are percent, --strain-unit 1"),
            "{said}"
        );
        for unit in ["1", "%"] {
            let choice = ColumnChoice { strain_unit: Some(unit.into()), ..ColumnChoice::default() };
            let e = Experiment::parse("test.csv", text.as_bytes(), None, &choice, Some(Mode::Uniaxial)).expect("valid");
            assert!(!log_of(&e, AuditKind::Doubt).contains("has no unit"), "{unit}");
        }
    }
}

/// A force that the machine counts as negative in tension: the refusal names the flag that turns this column alone, and no rupture is seen in the first data point, whose noise has the other sign.
#[test]
fn a_force_of_the_other_sign_is_turned_alone() {
    let row = |k: i32| {
        let stretch = 1.0 + 0.02 * f64::from(k);
        let stress = -100.0 * (stretch - stretch.powi(-2)) + if k == 0 { 0.4 } else { 0.0 };
        format!("{},{stress}\n", 100.0 * (stretch - 1.0))
    };
    let text = format!("strain [%],stress [kPa]\n{}", (0..50).map(row).collect::<String>());
    let read = |choice: &ColumnChoice| {
        let e =
            Experiment::parse("machine.csv", text.as_bytes(), None, choice, Some(Mode::Uniaxial)).expect("readable");
        fit_experiment(&e.prepare(&Preparation::default()).expect("prepared"), &FitOptions::new("neo_hookean"))
    };
    let refused = read(&ColumnChoice::default()).expect_err("against the stretch").to_string();
    assert!(refused.contains("pass --stress-positive compression"), "{refused}");
    let turned = ColumnChoice { stress_positive: Some(Sign::Compression), ..ColumnChoice::default() };
    let r = read(&turned).expect("fits");
    assert!((r.parameters[0].value / 100e3 - 1.0).abs() < 1e-3 && r.rows == 50, "{r}");
    // Strain alone: a compression test whose strain is positive
    let strain = ColumnChoice { positive: Some(Sign::Compression), stress_positive: Some(Sign::Tension), ..turned };
    let e = Experiment::parse("machine.csv", text.as_bytes(), None, &strain, Some(Mode::Uniaxial)).expect("readable");
    assert!(e.samples[1..].iter().all(|s| s.stretch < 1.0 && s.stress < 0.0), "{:?}", e.samples);
}

/// Compression whose numbers are all positive: a mode that says so refuses, the name of the file or a curve that bends up as in compression is a doubt. Tension is neither.
#[test]
fn positive_compression_is_doubted() {
    let read = |file: &str, text: &str, choice: &ColumnChoice| {
        Experiment::parse(file, text.as_bytes(), None, choice, Some(Mode::Uniaxial))
    };
    let plain = ColumnChoice::default();
    let compressed = pulled("strain,stress (MPa)", 0.4, |e| 1.0 - e);
    let pulled = pulled("strain,stress (MPa)", 0.4, |e| 1.0 + e);
    let doubt = |file: &str, text: &str| log_of(&read(file, text, &plain).expect("read"), AuditKind::Doubt);
    assert!(doubt("a.csv", &compressed).contains("as compression, and within"), "{}", doubt("a.csv", &compressed));
    for file in ["compression_test.csv", "Druckversuch 3.csv"] {
        let said = doubt(file, &pulled);
        assert!(said.contains("is called") && said.contains("--positive compression"), "{said}");
    }
    assert_eq!(doubt("a.csv", &pulled), "");
    let asked = ColumnChoice { compression: true, ..ColumnChoice::default() };
    let message = read("a.csv", &compressed, &asked).expect_err("a contradiction").to_string();
    assert!(message.contains("the mode is compression, but the data points are in tension"), "{message}");
    // A first data point on the other side of rest, by noise, changes nothing
    let noisy = compressed.replacen('\n', "\n-0.0002,0\n", 1);
    assert!(doubt("a.csv", &noisy).contains("as compression, and within"), "{}", doubt("a.csv", &noisy));
    let message = read("a.csv", &noisy, &asked).expect_err("a contradiction").to_string();
    assert!(message.contains("the mode is compression"), "{message}");
    let headed = "Test,ISO 7743 compression\n".to_string() + &noisy;
    let message = read("a.csv", &headed, &plain).expect_err("a contradiction").to_string();
    assert!(message.contains("the header speaks of compression"), "{message}");
    let rows = "mode,strain,stress (MPa)\ncompression,0.1,0.1\ncompression,0.2,0.2\n";
    let message =
        Experiment::parse("a.csv", rows.as_bytes(), None, &plain, None).expect_err("a contradiction").to_string();
    assert!(message.contains("the mode is compression"), "{message}");
    let negative = rows.replace(",0.", ",-0.");
    assert!(Experiment::parse("a.csv", negative.as_bytes(), None, &plain, None).is_ok());
    for positive in [Sign::Tension, Sign::Compression] {
        let choice = ColumnChoice { positive: Some(positive), ..asked.clone() };
        let e = read("compression.csv", &compressed, &choice).expect("stated");
        assert_eq!(log_of(&e, AuditKind::Doubt), "");
        assert_eq!(e.samples[0].stretch < 1.0, positive == Sign::Compression);
    }
}
