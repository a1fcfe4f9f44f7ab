//! Tables, figures and files of the report of a convergence study, from synthetic cases.

use super::limits_of_families::of_family;
use crate::common::synthetic::{SIZES, size, store, study};
use durometer::report::numbers::percent_cell;
use durometer::study::estimate::method::Method;
use durometer::study::kinds::convergence::analysis::analyse;
use durometer::study::kinds::convergence::bars;
use durometer::study::kinds::convergence::figures;
use durometer::study::kinds::convergence::report::quantities::quantities;
use durometer::study::report;
use durometer::study::store::record::*;
use durometer::study::store::results::Results;
use std::collections::BTreeMap;
use std::path::Path;

/// A study with its cases, as they are stored.
pub fn results(study: &StudyRecord, cases: &[StoredCase]) -> Results {
    Results {
        study: study.clone(),
        cases: cases.to_vec(),
        skins: BTreeMap::new(),
        motions: BTreeMap::new(),
        found: BTreeMap::new(),
        sensitivities: BTreeMap::new(),
        derived: None,
        damaged: vec![],
        outdated: vec![],
    }
}

/// A quantity that decides in one variant is none that another one judges: there all that is listed decides, as none of it is marked.
#[test]
fn curves_show_what_decides_in_their_variant() {
    let (mut study, cases) = study();
    let listed = study.quantities.get_mut("length").expect("variant");
    listed.iter_mut().for_each(|q| q.deciding = q.name == "cable_tension_N");
    study.quantities.get_mut("tension").expect("variant").iter_mut().for_each(|q| q.headline = false);
    let found = analyse(&study, &cases).found;
    let shows = |variant: &str| {
        let svg = figures::curves::draw(&results(&study, &cases), &found, variant).expect("a figure").svg;
        ["Bending angle", "Cable tension"].map(|title| svg.contains(title))
    };
    assert_eq!([shows("length"), shows("tension")], [[false, true], [true, false]]);
}

/// The uncertainty in the table is a share of what the bars are shares of.
#[test]
fn the_table_of_limits_knows_absolute_tolerances() {
    let (mut study, cases) = study();
    let listed = study.quantities.get_mut("length").expect("variant");
    listed.iter_mut().for_each(|q| q.absolute_tolerance = Some(1e3));
    let a = analyse(&study, &cases);
    let table = quantities(&a);
    let share = table.columns.iter().position(|c| c.0 == "U(f*)").expect("a column");
    let own = a.quantities.iter().flat_map(|q| q.estimates.iter().map(move |e| (q, e)));
    for (row, (q, e)) in table.rows.iter().zip(own) {
        let scale = if q.variant == "length" { 1e3 / study.tolerance } else { e.extrapolated.abs() };
        assert_eq!(row[share], percent_cell(e.uncertainty / scale), "{row:?}");
    }
}

/// The methods of a paper name the terms of the bars, and no term that no bar has.
#[test]
fn sources_of_bars_are_those_that_were_there() {
    let (study, cases) = study();
    let all = bars::errors(&analyse(&study, &cases));
    for words in
        ["the error of the time steps", "[@celik2008]", "[@eca2014]", "[@roache1994]", "added as absolute values"]
    {
        assert!(all.contains(words), "{words}: {all}");
    }
    let several = "the distance between the limits of the families";
    let sizes: Vec<StoredCase> = cases.iter().filter(|c| c.record.family == "sizes").cloned().collect();
    assert!(all.contains(several) && !bars::errors(&analyse(&study, &sizes)).contains(several), "{all}");
    assert!(!all.contains("uncertain constants"), "{all}");
    let without_steps: Vec<StoredCase> = cases.iter().filter(|c| c.record.family != "time_step").cloned().collect();
    let fewer = bars::errors(&analyse(&study, &without_steps));
    assert!(!fewer.contains("time steps") && fewer.contains("added as absolute values"), "{fewer}");
    let one: Vec<StoredCase> = cases.iter().take(1).cloned().collect();
    assert!(bars::errors(&analyse(&study, &one)).starts_with("No error bar is computed"));
}

// --- the report --------------------------------------------------------------------------------------------------

#[test]
fn a_report_is_complete_and_can_be_redrawn() {
    let dir = tempfile::tempdir().expect("temporary folder");
    store(dir.path(), &study());
    // REPORT_EXAMPLE=DIR leaves the stored study and its report there, to look at the pictures
    if let Ok(keep) = std::env::var("REPORT_EXAMPLE") {
        let keep = Path::new(&keep);
        if !keep.join("study.json").exists() {
            store(keep, &study());
        }
        report::write_report(keep).unwrap_or_else(|e| panic!("{e}"));
    }
    let first = report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    let read = |name: &str| std::fs::read_to_string(dir.path().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
    let (page, summary) = (read("index.html"), read("summary.json"));
    assert!(page.contains(&first.verdict) && page.contains("<svg"));
    assert!(!page.contains("src=") && !page.contains("http-equiv"), "nothing outside of the page");
    let json: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
    let analysis = &json["analysis"];
    assert_eq!(analysis["variant"], "tension");
    assert_eq!(analysis["recommended_case"], "element-tension-2200");
    for key in ["observed_order", "richardson_peak", "gci_percent", "convergence_ratio"] {
        assert!(analysis[key].is_f64(), "{key}: {}", analysis[key]);
    }
    assert!(analysis["cable_tension_N"]["length"]["reference"]["value"].is_f64());
    let case = &json["cases"][0];
    for key in ["id", "formulation", "law", "dt_s", "status", "wall_s", "steps", "newton_iterations", "effects"] {
        assert!(!case[key].is_null(), "{key}");
    }
    assert!(case["mesh"]["h_m"].is_f64() && case["probes"]["bending_angle_deg"]["final"].is_f64());
    assert!(read("tables/cases.csv").lines().count() > 30 && read("tables/quantities.tex").contains("\\toprule"));
    let svg = read("figures/curves-length.svg");
    assert!(svg.contains("Liberation Sans, Arial") && !svg.contains('\u{e000}'));
    for e in std::fs::read_dir(dir.path().join("figures")).expect("folder").flatten() {
        let least = if e.path().extension().is_some_and(|e| e == "tex") { 200 } else { 1000 };
        assert!(e.metadata().expect("file").len() > least, "{:?} is empty", e.path());
    }
    report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(summary, read("summary.json"), "redrawing changes nothing");
    assert_eq!(page, read("index.html"), "redrawing changes nothing");
}

/// The error of the four sizes has two powers of h, so that the order of the least squares, which f* is found with, is not that of the three finest: next to f*
/// the table has the former, as the figure has.
#[test]
fn table_and_figure_have_the_order_of_the_limit() {
    let (study, mut cases) = study();
    for c in cases.iter_mut().filter(|c| c.is_in("sizes", "length")) {
        let h = c.record.mesh.h_m / size(4_500);
        c.record.probes.get_mut("cable_tension_N").expect("probe").peak = 6.4 * (1.0 + 0.15 * h + 0.1 * h.powi(3));
    }
    let a = analyse(&study, &cases);
    let tension = a.find("length", "cable_tension_N").expect("listed");
    let [sizes, nested] = ["sizes", "nested"].map(|family| tension.estimate(family).expect("meshes"));
    let [finest, p] = [sizes.observed_order, sizes.order_of_limit()].map(|p| p.expect("monotone"));
    assert!(
        matches!(sizes.method, Method::LeastSquares { .. }) && (finest - p).abs() > 0.05,
        "{finest} and {p}: {sizes:?}"
    );
    assert_eq!((&nested.method, nested.order_of_limit()), (&Method::Richardson, nested.observed_order));
    for e in [sizes, nested] {
        let law = |h: f64| e.power_law(h).expect("an order");
        let range = (e.values[0] - e.extrapolated).abs();
        // A millionth of h, to a power of more than one
        assert!((law(1e-6 * e.h_m[0]) - e.extrapolated).abs() < 1e-4 * range, "{e:?}");
        assert!((law(e.h_m[0]) - e.values[0]).abs() < 0.05 * range, "{e:?}");
    }
    let table = quantities(&a);
    let column = |name: &str| table.columns.iter().position(|c| c.0 == name).unwrap_or_else(|| panic!("{name}"));
    let is_row = |row: &&Vec<String>| row[0] == tension.peak_label() && row[1] == "length" && row[2].contains("sizes");
    let row = table.rows.iter().find(is_row).expect("a row");
    assert_eq!([&row[column("p finest")], &row[column("p")]], [&format!("{finest:.2}"), &format!("{p:.2}")]);
    let dir = tempfile::tempdir().expect("temporary folder");
    store(dir.path(), &(study, cases));
    report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    let svg = std::fs::read_to_string(dir.path().join("figures/error-h.svg")).expect("written");
    assert!(svg.contains(&format!("</tspan> = {p:.2}\n")), "no p = {p:.2}");
    // Where noise hides the differences nothing is extrapolated, although there is a fit
    let f = SIZES.map(|n| 60.0 + 6.0 * (size(n) / size(4500)).powf(1.8));
    let noisy = of_family(Role::Sizes, &f, Some(3.0));
    assert!(noisy.fit.is_some() && noisy.order_of_limit().is_none() && noisy.power_law(size(4500)).is_none());
}

#[test]
fn missing_and_failed_cases_still_get_a_report_and_broken_files_a_remedy() {
    let dir = tempfile::tempdir().expect("temporary folder");
    let message = || report::write_report(dir.path()).expect_err("must be refused").to_string();
    assert!(message().contains("study.json does not exist") && message().contains("durometer run"));
    store(dir.path(), &study());
    let path = |name: &str| dir.path().join(name);
    for e in std::fs::read_dir(path("cases")).expect("folder").flatten() {
        if !e.file_name().to_string_lossy().starts_with("sizes-length") {
            std::fs::remove_file(e.path()).expect("file");
        }
    }
    let summary = report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    assert!(summary.verdict.starts_with("No verdict"), "{}", summary.verdict);
    let not_run: Vec<&String> = summary.warnings.iter().filter(|w| w.contains("no result")).collect();
    assert!(not_run.len() == 1 && not_run[0].contains(" cases have no result yet: "), "{not_run:?}");
    assert!(not_run[0].ends_with(" more.") && summary.verdict.contains(" more."), "{not_run:?}: {}", summary.verdict);
    std::fs::write(path("cases/sizes-length-4500.csv"), "t_s,bending_angle_deg\n0,0\n0.1,fast\n").expect("file");
    let damaged = || report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}")).damaged.join("\n");
    assert!(damaged().contains("line 3: bending_angle_deg is \"fast\""), "{}", damaged());
    std::fs::write(path("cases/sizes-length-9300.json"), "{\"id\": 3").expect("file");
    assert!(damaged().contains("sizes-length-9300.json: it is not a valid record"), "{}", damaged());
    for (provenance, wrote) in [
        (r#"{"version": "0.1.0", "scene": ""}"#, "an earlier build of durometer 0.1.0"),
        (
            r#"{"scene": "", "build": {"version": "0.0.7", "source_sha256": "4f2a00112233", "compiler": "rustc 1.70", "cpu": "x86_64"}}"#,
            "durometer 0.0.7, sources 4f2a00112233, rustc 1.70",
        ),
    ] {
        let text = format!(r#"{{"id": "sizes-length-9300", "provenance": {provenance}}}"#);
        std::fs::write(path("cases/sizes-length-9300.json"), text).expect("file");
        let said = message();
        assert!(
            said.contains(wrote) && said.contains("missing field") && said.contains("run the study again"),
            "{said}"
        );
    }
    store(dir.path(), &study());
    std::fs::remove_dir_all(path("figures")).expect("folder");
    std::fs::write(path("figures"), "in the way").expect("file");
    assert!(message().contains("cannot write") && message().contains("figures"), "{}", message());
}
