//! Numbers of pages are those of published results. `DUROMETER_BLESS=1 cargo test --test structure evidence::` writes the rows of coverage anew.

use crate::source::root;
use serde_json::Value;
use std::path::PathBuf;

fn published(path: &str) -> PathBuf {
    root().join("reports/published").join(path)
}

fn page(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// Rows of a published table, of these columns.
fn rows<const N: usize>(path: &str, columns: [&str; N]) -> Vec<[String; N]> {
    let mut table = csv::Reader::from_path(published(path)).unwrap_or_else(|e| panic!("{path}: {e}"));
    let head = table.headers().expect("a head").clone();
    let place = |name: &str| head.iter().position(|own| own == name).unwrap_or_else(|| panic!("{path}: no {name}"));
    let places = columns.map(place);
    let row = |row: Result<csv::StringRecord, csv::Error>| places.map(|k| row.as_ref().expect("a row")[k].to_string());
    table.records().map(row).collect()
}

/// Bars of a group and how many of them hold, their share, and the median of bar over error.
struct Share {
    bar: String,
    group: String,
    hold: String,
    percent: String,
    median: String,
}

/// Those of the study of coverage, with the groups in the words of the page.
fn shares() -> Vec<Share> {
    let columns = ["Bar", "By", "Group", "Bars", "Hold", "Share [%]", "Median bar/error"];
    let share = |[bar, by, group, bars, hold, percent, median]: [String; 7]| {
        let group = match (by.as_str(), group.as_str()) {
            ("problem", "fresh") => "fresh problems".into(),
            ("problem", _) => "problems that bounds were chosen on".into(),
            ("boundary", group) => format!("{group} boundary"),
            ("locking", group) => format!("locking: {group}"),
            ("family", group) => format!("U(f\\*) {group}"),
            _ => group,
        };
        Share { bar, group, hold: format!("{hold} of {bars}"), percent, median }
    };
    rows("coverage/tables/coverage.csv", columns).into_iter().map(share).collect()
}

const HEAD: &str =
    "| bars | one run: hold | median bar/error | many runs: hold | median bar/error |\n|---|---|---|---|---|\n";

#[test]
fn the_rows_of_coverage_are_those_of_the_published_study() {
    let shares = shares();
    let mut groups: Vec<&str> = Vec::new();
    for share in &shares {
        if !groups.contains(&&*share.group) {
            groups.push(&share.group);
        }
    }
    let cells = |group: &str, bar: &str| match shares.iter().find(|s| s.group == group && s.bar == bar) {
        Some(s) => format!("{}, {} % | {}", s.hold, s.percent, s.median),
        None => "– | –".into(),
    };
    let row = |group: &str| format!("| {group} | {} | {} |\n", cells(group, "one run"), cells(group, "many runs"));
    let expected: String = groups.into_iter().map(row).collect();
    let file = "docs/verification.md";
    let text = page(file);
    let (before, rest) = text.split_once(HEAD).expect("the table of coverage");
    let (stored, after) = rest.split_at(rest.find("\n\n").expect("the end of the table") + 1);
    if std::env::var_os("DUROMETER_BLESS").is_some() {
        std::fs::write(root().join(file), [before, HEAD, &expected, after].concat()).expect("writable");
        return;
    }
    assert!(stored == expected, "{file} has other rows than reports/published/coverage:\n{expected}");
}

/// What README and paper say of bars and of the tension on linear meshes.
#[test]
fn numbers_of_readme_and_paper_are_those_of_published_studies() {
    let (readme, paper) = (page("README.md"), page("docs/paper/paper.md"));
    let flat = paper.split_whitespace().collect::<Vec<_>>().join(" ");
    for all in shares().iter().filter(|s| s.group == "all") {
        assert!(flat.contains(&all.hold), "docs/paper/paper.md: {} bars hold: {}", all.bar, all.hold);
        let times = format!("{} times the error", all.median);
        assert!(all.bar != "one run" || flat.contains(&times), "docs/paper/paper.md: bars are {times}");
    }
    let text = std::fs::read_to_string(published("finger-convergence/summary.json")).expect("a summary");
    let summary: Value = serde_json::from_str(&text).expect("JSON");
    let reference = &summary["analysis"]["cable_tension_N"]["length"]["reference"]["value"];
    let reference = reference.as_f64().expect("a number");
    let cases = rows("finger-convergence/tables/cases.csv", ["Case", "Maximum cable tension [N]"]);
    let linear = cases.iter().filter(|[case, _]| case.starts_with("sizes-length-"));
    let mut above: Vec<f64> =
        linear.map(|[_, tension]| 100.0 * (tension.parse::<f64>().expect("a number") / reference - 1.0)).collect();
    above.sort_by(f64::total_cmp);
    assert_eq!(above.len(), 4, "linear meshes of the paper");
    let range = format!("{:.0} to {:.0} %", above[0], above[3]);
    for (name, text) in [("README.md", &readme), ("docs/paper/paper.md", &paper)] {
        assert!(text.contains(&range), "{name}: the tension is {range} above the reference");
    }
}
