//! The report of a fit: figure, tables and page come from the stored fit alone, the same bytes each time.

use crate::common::tables::{MU, stress};
use durometer::calibrate::{
    FitRequest, FitResult, FitWarning, Mode, SlackChoice, StretchRange, Treatment, compare, fit,
};
use durometer::report;
use std::collections::BTreeMap;
use std::path::Path;

/// Treloar's table, uniaxial rows up to λ = 1.6 fitted; both other modes are held out.
fn store(dir: &Path) {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/treloar-1944/treloar-1944.csv");
    let mut request = FitRequest::new(data, "neo_hookean");
    request.options.modes = vec![Mode::Uniaxial];
    request.options.range = Some(StretchRange { from: 1.0, to: 1.6 });
    let result = fit(&request).expect("the table is part of the project");
    result.write_json(&dir.join("fit.json")).expect("writable");
    result.write_law(&dir.join("law.toml")).expect("writable");
}

/// Every file under `dir` but the stored fit.
fn files(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut out = BTreeMap::new();
    for folder in ["", "figures", "tables"] {
        for entry in std::fs::read_dir(dir.join(folder)).expect("written") {
            let path = entry.expect("readable").path();
            if path.is_file() {
                let name = path.strip_prefix(dir).expect("inside").display().to_string();
                out.insert(name, std::fs::read(&path).expect("readable"));
            }
        }
    }
    out
}

#[test]
fn the_report_has_its_figure_and_a_redraw_has_the_same_bytes() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    store(dir.path());
    assert!(report::fit::is_fit(dir.path()));
    let answer = report::fit::write(dir.path()).expect("a report");
    assert!(answer.contains("μ = 357 kPa (95 % interval 334 to 380 kPa)"), "{answer}");
    assert!(answer.contains("more than the interval says"), "{answer}");
    let first = files(dir.path());
    assert!(first["figures/fit.png"].starts_with(b"\x89PNG") && first["figures/fit.pdf"].starts_with(b"%PDF"));
    for table in ["parameters", "predictions", "ranges"] {
        assert!(
            first.contains_key(&format!("tables/{table}.csv")) && first.contains_key(&format!("tables/{table}.tex"))
        );
    }
    let svg = String::from_utf8(first["figures/fit.svg"].clone()).expect("text");
    for words in ["uniaxial, fitted", "uniaxial, not fitted", "planar, not fitted", "law, predicted", "fitted range"] {
        assert!(svg.contains(words), "{words}");
    }
    assert!(!svg.contains("equibiaxial, fitted") && !svg.contains("NaN"));
    // The line of the law, in the dark colour of its mode, lies over the data points
    let place = |colour: &str| svg.to_uppercase().find(colour).unwrap_or_else(|| panic!("{colour} in {svg}"));
    assert!(place("#003E61") > place("#0072B2"));
    report::fit::write(dir.path()).expect("again");
    let second = files(dir.path());
    assert_eq!(first.keys().collect::<Vec<_>>(), second.keys().collect::<Vec<_>>());
    for (name, bytes) in &first {
        assert!(second[name] == *bytes, "{name} changed");
    }
}

#[test]
fn the_page_needs_no_other_file_and_agrees_with_the_fit() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    store(dir.path());
    report::fit::write(dir.path()).expect("a report");
    let page = std::fs::read_to_string(dir.path().join("index.html")).expect("the page");
    for outside in ["src=", "<link", "<script", "@import", "url(http"] {
        assert!(!page.contains(outside), "{outside}");
    }
    // Links lead to files next to the page
    for link in page.split("href=\"").skip(1).filter_map(|l| l.split('"').next()) {
        assert!(link.starts_with('#') || dir.path().join(link).is_file(), "{link}");
    }
    let plain = &page;
    let stored: serde_json::Value =
        serde_json::from_slice(&std::fs::read(dir.path().join("fit.json")).expect("stored")).expect("JSON");
    for message in stored["messages"].as_array().expect("a list") {
        let tail: String = message.as_str().expect("text").chars().skip(1).collect::<String>().replace('<', "&lt;");
        assert!(plain.contains(&tail), "{tail}");
    }
    assert!(plain.contains("delimiter &quot;,&quot;") && plain.contains("law = &quot;neo_hookean&quot;"));
    assert!(plain.contains("<svg ") && plain.contains("class=\"verdict refused\""));
}

#[test]
fn a_folder_without_results_and_a_damaged_fit_are_refused_with_the_remedy() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let error = report::fit::write(dir.path()).expect_err("empty").to_string();
    assert!(error.contains("durometer fit CSV"), "{error}");
    std::fs::write(dir.path().join("fit.json"), "{\"law\": 1}").expect("writable");
    let error = report::fit::write(dir.path()).expect_err("damaged").to_string();
    assert!(error.contains("fit.json is not a valid record") && error.contains("line 1"), "{error}");
}

/// Data with one mode in tension and compression, with little noise.
fn clean(dir: &Path) -> FitResult {
    let mut text = String::from("stretch,nominal stress (kPa)\n");
    for k in 0..30 {
        let l = 0.8 + 0.02 * f64::from(k);
        text += &format!("{l},{}\n", 20.0 * (l - 1.0 / (l * l)) + if k % 2 == 0 { 0.1 } else { -0.1 });
    }
    let csv = dir.join("made.csv");
    std::fs::write(&csv, text).expect("writable");
    let mut request = FitRequest::new(csv, "neo_hookean");
    request.options.modes = vec![Mode::Uniaxial];
    fit(&request).expect("clean")
}

/// The page of the report of this fit.
fn page(dir: &Path, result: &FitResult) -> String {
    result.write_json(&dir.join("fit.json")).expect("writable");
    report::fit::write(dir).expect("a report");
    std::fs::read_to_string(dir.join("index.html")).expect("the page")
}

/// Data with one mode, all fitted, in tension and compression: one column, no second panel.
#[test]
fn a_fit_of_every_row_has_one_column() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    page(dir.path(), &clean(dir.path()));
    let svg = std::fs::read_to_string(dir.path().join("figures/fit.svg")).expect("the figure");
    assert!(!svg.contains("All data") && !svg.contains("(a)") && !svg.contains("law, predicted"));
}

/// A piece that was slack and then broke: the page names both in the words of the terminal, and the methods say what was left out.
#[test]
fn rupture_and_slack_are_named_in_the_report() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let mut text = String::from("stretch,nominal stress (Pa)\n");
    for k in 1..=40 {
        let l = 1.0 + 0.025 * f64::from(k);
        let carried = if k < 30 { stress(Mode::Uniaxial, (l - 0.1).max(1.0)) } else { 0.01 * MU };
        text += &format!("{l},{carried}\n");
    }
    let csv = dir.path().join("torn.csv");
    std::fs::write(&csv, text).expect("writable");
    let mut request = FitRequest::new(csv, "neo_hookean");
    request.options.modes = vec![Mode::Uniaxial];
    request.options.slack = SlackChoice::No;
    let page = page(dir.path(), &fit(&request).expect("fits"));
    for words in
        ["Left out: uniaxial data points after rupture in torn.csv: ", "Doubt: uniaxial: up to a strain of 0.1"]
    {
        assert!(page.contains(words), "{words} in {page}");
    }
    let methods = std::fs::read_to_string(dir.path().join("paper/methods.md")).expect("the methods");
    assert!(methods.contains("Uniaxial data points after rupture in torn.csv"), "{methods}");
}

/// The methods of a paper have the warnings of the page, but no notes, and say that the material was taken as incompressible.
#[test]
fn the_methods_state_the_limits_of_a_fit() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let mut result = clean(dir.path());
    let (file, lines) = (String::from("made.csv"), vec![2]);
    let mut methods = |warnings: Vec<FitWarning>| {
        result.warnings = warnings;
        page(dir.path(), &result);
        std::fs::read_to_string(dir.path().join("paper/methods.md")).expect("the methods")
    };
    let text = methods(vec![
        FitWarning::Data { message: "strain comes from crosshead travel".into() },
        FitWarning::Misfit { test: None, rms_relative: 0.2, tolerance: 0.1 },
        FitWarning::LimitedOutliers { file: file.clone(), lines: lines.clone() },
    ]);
    assert!(text.contains("**Limits.** Strain comes from crosshead travel. Misfit 20.0 % rms"), "{text}");
    assert!(!text.contains("have a limited weight"), "{text}");
    assert!(text.contains("The material was taken as incompressible (J = 1)."), "{text}");
    let text = methods(vec![FitWarning::LimitedOutliers { file, lines }]);
    assert!(!text.contains("**Limits.**"), "{text}");
}

/// Every grave warning marks the answer as doubtful, and others do not; a file of before, which does not say it, is marked by any warning.
#[test]
fn grave_warnings_mark_the_answer() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let mut result = clean(dir.path());
    let (mode, rms_relative, answer) = (Mode::Uniaxial, 0.2, String::from("μ = 1 kPa"));
    let grave = [
        FitWarning::Systematic { runs: Some(3), runs_p: Some(1e-3), departure_p: None, rms_relative, wider: false },
        FitWarning::Misfit { test: None, rms_relative, tolerance: 0.1 },
        FitWarning::Stiffness { mu_pa: 1.0, unit: "Pa".into(), instead: None },
        FitWarning::Data { message: "a doubt".into() },
        FitWarning::Unidentifiable { directions: vec![] },
        FitWarning::NoFreedom { constants: 1, rows: 1, least: "μ".into() },
        FitWarning::Limit { found: vec![("α", 1.0)] },
        FitWarning::Undefined { rows: 1, nearest: 2.0 },
        FitWarning::Unstable { lost: vec![(mode, 1.5)], reach: 2.0, linear: false },
        FitWarning::Held { mode, range: [1.0, 2.0] },
        FitWarning::Outliers { file: "made.csv".into(), lines: vec![2] },
        FitWarning::Specimen { file: "made.csv".into(), level: 2.0 },
        FitWarning::Cycles { treatment: Treatment::LastLoading, change: 0.3, answer: answer.clone() },
        FitWarning::OpenSigns { symbols: vec!["α"], decides: None },
    ];
    let file = dir.path().join("fit.json");
    let stored = || -> serde_json::Value {
        serde_json::from_str(&std::fs::read_to_string(&file).expect("written")).expect("JSON")
    };
    for warning in grave {
        result.warnings = vec![warning];
        result.write_json(&file).expect("writable");
        assert_eq!(stored()["doubtful"].as_bool(), Some(true), "{:?}", result.warnings);
    }
    assert!(page(dir.path(), &result).contains("class=\"verdict refused\""));
    result.warnings = vec![
        FitWarning::NoPartner { volumetric: false },
        FitWarning::OneMode { mode },
        FitWarning::Unequal,
        FitWarning::OtherMinimum { answer, minima: 1, decides: None },
    ];
    assert!(page(dir.path(), &result).contains("class=\"verdict\""));
    let mut before = stored();
    before.as_object_mut().expect("a table").remove("doubtful").expect("stored");
    std::fs::write(&file, before.to_string()).expect("writable");
    report::fit::write(dir.path()).expect("a file of before");
    let page = std::fs::read_to_string(dir.path().join("index.html")).expect("the page");
    assert!(page.contains("class=\"verdict refused\""));
}

/// Sixty data points in tension that a law describes, and ten in compression that it misses by more than a third of their stresses: terminal, page and warning tell the two apart. Without data in compression
/// nothing is said of it.
#[test]
fn each_side_of_rest_has_its_misfit() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let stress = |l: f64| 2.0 * (l - l.powi(-2)) * (2e4 + 4e4 / l);
    let row = |l: f64| format!("{l},{}\n", stress(l));
    let tension: String = (0..60).map(|k| row(1.02 + 3.98 * f64::from(k) / 59.0)).collect();
    let compression: String = (0..10).map(|k| row(0.8 + 0.02 * f64::from(k))).collect();
    let ask = |rows: &str| {
        let data = dir.path().join("made.csv");
        std::fs::write(&data, format!("stretch,nominal stress (Pa)\n{rows}")).expect("writable");
        let mut request = FitRequest::new(data, "yeoh");
        (request.options.modes, request.options.terms) = (vec![Mode::Uniaxial], Some(3));
        fit(&request).expect("fits")
    };
    let both = ask(&(compression + &tension));
    let found: Vec<_> = both.validity.tests.iter().map(|t| (t.test.compression, t.to.is_some())).collect();
    assert_eq!(found, [(false, true), (true, false)], "{both}");
    let off = |w: &FitWarning| match w {
        FitWarning::Misfit { test, rms_relative, .. } => test.map(|test| (test.compression, *rms_relative > 0.3)),
        _ => None,
    };
    assert_eq!(both.warnings.iter().filter_map(off).collect::<Vec<_>>(), [(true, true)], "{both}");
    let said = both.to_string();
    for words in [
        "rms of the data of uniaxial in tension from",
        "at no stretch within 10 % rms of the data of uniaxial in compression",
    ] {
        assert!(said.contains(words), "{words} in {said}");
    }
    let html = page(dir.path(), &both);
    assert!(html.contains("uniaxial in tension up to stretch 5, uniaxial in compression at no stretch."), "{html}");
    let alone = ask(&tension);
    assert!(alone.validity.tests.len() == 1 && !alone.to_string().contains("in compression"), "{alone}");
    assert!(page(dir.path(), &alone).contains("of these tests up to stretch 5."));
}

/// The page of `--law all` has the rows of compare.json in its order; without the file it is refused.
#[test]
fn the_comparison_of_laws_has_a_table() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    assert!(report::fit::comparison::write(dir.path()).is_err());
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/treloar-1944/treloar-1944.csv");
    let mut request = FitRequest::new(data, "all");
    request.options.modes = vec![Mode::Uniaxial];
    request.options.range = Some(StretchRange { from: 1.0, to: 1.6 });
    let laws = compare(&request).expect("the table is part of the project");
    laws.write_json(&dir.path().join("compare.json")).expect("writable");
    report::fit::comparison::write(dir.path()).expect("a page");
    let csv = std::fs::read_to_string(dir.path().join("tables/comparison.csv")).expect("the table");
    let names: Vec<&str> = csv.lines().skip(1).filter_map(|l| l.split(',').next()).collect();
    assert_eq!(names, laws.laws.iter().map(|c| c.label.as_str()).collect::<Vec<_>>());
    let page = std::fs::read_to_string(dir.path().join("index.html")).expect("the page");
    assert!(names.iter().all(|name| page.contains(&format!("<td>{name}</td>"))));
}

/// A prediction of a law that is not defined at the data is no prediction that cannot be had: JSON has no infinity, and the page says what the terminal does. A file of before has no such mark.
#[test]
fn a_law_that_failed_a_prediction_is_marked() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/treloar-1944/treloar-1944.csv");
    let mut request = FitRequest::new(data, "all");
    request.options.modes = vec![Mode::Uniaxial];
    request.options.range = Some(StretchRange { from: 1.0, to: 1.6 });
    let mut laws = compare(&request).expect("the table is part of the project");
    laws.laws.truncate(1);
    (laws.laws[0].hold_out, laws.laws[0].failed) = (Some(f64::INFINITY), vec!["hold_out"]);
    let row = |laws: &durometer::calibrate::Comparison| {
        laws.write_json(&dir.path().join("compare.json")).expect("writable");
        report::fit::comparison::write(dir.path()).expect("a page");
        std::fs::read_to_string(dir.path().join("tables/comparison.csv")).expect("the table")
    };
    assert!(row(&laws).contains(",failed,") && laws.to_string().contains("failed"), "{laws}");
    laws.laws[0].failed.clear();
    assert!(!row(&laws).contains("failed"), "{laws}");
}

/// The Veronda–Westmann law of the first five data points is infinite at them: such a range is left out, and the stored fit can be read again.
#[test]
fn a_range_whose_law_is_infinite_has_no_row() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/treloar-1944/treloar-1944.csv");
    let mut request = FitRequest::new(data, "veronda_westmann");
    request.options.modes = vec![Mode::Uniaxial];
    request.options.range = Some(StretchRange { from: 1.0, to: 3.0 });
    let result = fit(&request).expect("the table is part of the project");
    assert!(!result.range_dependence.is_empty());
    assert!(result.range_dependence.iter().all(|row| row.rms_pa.is_finite()), "{:?}", result.range_dependence);
    result.write_json(&dir.path().join("fit.json")).expect("writable");
    report::fit::write(dir.path()).expect("a report");
}
