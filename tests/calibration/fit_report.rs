//! The report of a fit: figure, tables and page come from the stored fit alone, the same bytes each time.

use durometer::calibrate::{FitRequest, Mode, StretchRange, compare, fit};
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

/// Data with one mode, all fitted, in tension and compression: one column, no second panel.
#[test]
fn a_fit_of_every_row_has_one_column() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let mut text = String::from("stretch,nominal stress (kPa)\n");
    for k in 0..30 {
        let l = 0.8 + 0.02 * f64::from(k);
        text += &format!("{l},{}\n", 20.0 * (l - 1.0 / (l * l)) + if k % 2 == 0 { 0.1 } else { -0.1 });
    }
    let csv = dir.path().join("made.csv");
    std::fs::write(&csv, text).expect("writable");
    let mut request = FitRequest::new(csv, "neo_hookean");
    request.options.modes = vec![Mode::Uniaxial];
    let result = fit(&request).expect("clean");
    result.write_json(&dir.path().join("fit.json")).expect("writable");
    report::fit::write(dir.path()).expect("a report");
    let svg = std::fs::read_to_string(dir.path().join("figures/fit.svg")).expect("the figure");
    assert!(!svg.contains("All data") && !svg.contains("(a)") && !svg.contains("law, predicted"));
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
