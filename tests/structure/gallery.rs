//! The gallery, `docs/gallery.md`, says what the published results say. `DUROMETER_BLESS=1 cargo test --test structure gallery::` writes it anew.

use crate::source::root;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fmt::Write;

/// Published studies with the picture that shows what they are about, in the order of the page.
const PICTURES: [(&str, &str); 20] = [
    ("finger-convergence", "bent"),
    ("finger-locking", "formulations"),
    ("finger-cost", "work-precision-length"),
    ("finger-materials", "comparison-tension"),
    ("coverage", "coverage"),
    ("hard-cases", "matrix-1"),
    ("gripper", "against-one_force_x_N-hold"),
    ("finger-cube", "bent"),
    ("contact-cost", "sweep-barrier"),
    ("contact-loops", "work-precision-ball"),
    ("trunk", "map-two-cables"),
    ("bellows", "comparison-pressure"),
    ("parallel-robot", "against-bending_angle_deg-side"),
    ("tripod", "map-servos"),
    ("wound-actuator", "against-tip_x_m-layer"),
    ("pneunet-gripper", "comparison-bar"),
    ("validation-beam", "budget"),
    ("validation-beam-tensile", "score"),
    ("validation-tentacle", "budget"),
    ("validation-comsol", "score"),
];

const HEAD: &str = "# Gallery

Every published study with the first sentence of its verdict, the files that make it, and its cost: the CPU time of all cases, as its `summary.json` states it. They were run one case at a time on an
idle machine with two cores; `coverage` and the validations ran next to other work ([how each is made](../reports/published)). Every one of them runs anew by `durometer run NAME`, with its meshes from the program.
";

/// Longest sentence that keeps what is in parentheses \[bytes\].
const LONGEST: usize = 360;

/// The first sentence of a verdict; of a list of findings the first one. A long one loses what is in parentheses.
fn first_sentence(verdict: &str) -> String {
    let ends = verdict.match_indices(['.', ';']).filter(|(at, mark)| {
        let rest = &verdict[at + 1..];
        let next = rest.trim_start().chars().next();
        let is_inside = verdict[..*at].matches('(').count() > verdict[..*at].matches(')').count();
        (*mark == ";" && *at > 160 && !is_inside)
            || (*mark == "." && rest.starts_with(' ') && next.is_some_and(char::is_uppercase))
    });
    let end = ends.map(|(at, _)| at).next().unwrap_or(verdict.trim_end_matches('.').len());
    let sentence = &verdict[..end];
    if sentence.len() <= LONGEST { format!("{sentence}.") } else { format!("{}.", without_parentheses(sentence)) }
}

/// A text without what is in parentheses, and without the blank before them.
fn without_parentheses(text: &str) -> String {
    let (mut out, mut depth) = (String::new(), 0);
    for c in text.chars() {
        match c {
            '(' => {
                depth += 1;
                out.truncate(out.trim_end().len());
            }
            ')' => depth -= 1,
            _ if depth == 0 => out.push(c),
            _ => {}
        }
    }
    out
}

/// Number of cases and CPU time of all of them.
fn cost_of(summary: &Value) -> Option<String> {
    let cases = summary["cases"].as_array()?;
    let seconds: f64 = cases.iter().filter_map(|case| case["cpu_s"].as_f64()).sum();
    let time = if seconds < 90.0 { format!("{seconds:.0} s") } else { format!("{:.1} min", seconds / 60.0) };
    (!cases.is_empty()).then(|| format!("{} cases, {time}", cases.len()))
}

/// The published results of a study.
fn summary_of(name: &str) -> Value {
    let text = std::fs::read_to_string(root().join("reports/published").join(name).join("summary.json"));
    serde_json::from_str(&text.expect("a published summary")).expect("JSON")
}

/// A text on one line.
fn flat(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn section(name: &str, picture: &str) -> String {
    let report = format!("reports/published/{name}");
    let summary = summary_of(name);
    let words = |key: &str| summary[key].as_str().unwrap_or_default().to_string();
    let mut out = format!("\n## {name}\n\n*{}*\n\n{}\n\n", words("question"), first_sentence(&words("verdict")));
    write!(out, "![{name}: {}](../{report}/figures/{picture}.png)\n\n", picture.replace(['-', '_'], " "))
        .expect("a text");
    let page = format!("{report}/index.html");
    let page = if root().join(&page).is_file() { format!("[report](../{page}), ") } else { String::new() };
    let cost = cost_of(&summary).map_or(String::new(), |cost| format!("; {cost} of CPU time"));
    writeln!(
        out,
        "{page}[about](../studies/{name}), [study.toml](../studies/{name}/study.toml), \
         [summary.json](../{report}/summary.json){cost}"
    )
    .expect("a text");
    out
}

#[test]
fn the_gallery_says_what_the_published_results_say() {
    let page: String = std::iter::once(HEAD.to_string()).chain(PICTURES.map(|(name, of)| section(name, of))).collect();
    let path = root().join("docs/gallery.md");
    if std::env::var_os("DUROMETER_BLESS").is_some() {
        std::fs::write(&path, &page).expect("writable");
    }
    let stored = std::fs::read_to_string(&path).unwrap_or_default();
    let line = page.lines().zip(stored.lines()).find(|(new, old)| new != old);
    assert!(stored == page, "docs/gallery.md is not that of the published results: {line:?}");
}

#[test]
fn every_published_study_is_in_the_gallery() {
    let folders = std::fs::read_dir(root().join("reports/published")).expect("the folder").flatten();
    let published = folders.filter(|e| e.path().join("summary.json").is_file());
    let published: BTreeSet<String> = published.map(|e| e.file_name().to_string_lossy().into_owned()).collect();
    let shown: BTreeSet<String> = PICTURES.iter().map(|(name, _)| (*name).to_string()).collect();
    assert_eq!(published, shown, "give each published study a line with its picture in PICTURES of this file");
}

/// The README quotes verdicts and costs.
#[test]
fn the_readme_says_what_the_published_results_say() {
    let readme = std::fs::read_to_string(root().join("README.md")).expect("the README");
    let flat = flat(&readme);
    let verdict = |name: &str| first_sentence(summary_of(name)["verdict"].as_str().unwrap_or_default());
    let hard = verdict("hard-cases").replacen(" cases,", " hard cases,", 1);
    assert!(flat.contains(hard.trim_end_matches('.')), "{hard}");
    let finger = verdict("finger-convergence");
    let (trusted, cost) =
        (finger.split(':').next().unwrap_or_default(), finger.rsplit(", ").next().unwrap_or_default());
    assert!(flat.contains(&format!("{trusted}, for {cost}")), "{trusted}, for {cost}");
    let rows: Vec<&str> = readme.lines().filter(|line| line.starts_with("| [") && line.contains(" cases, ")).collect();
    assert!(rows.len() > 3);
    for row in rows {
        let name = row.split(['[', ']']).nth(1).unwrap_or_default();
        let cost = cost_of(&summary_of(name)).expect("a result with cases");
        assert!(row.ends_with(&format!("| {cost} |")), "{row} is {cost}");
    }
}

/// The page of a study that quotes its verdict quotes all of the published one.
#[test]
fn pages_of_studies_quote_the_published_verdicts() {
    let mut quotes = 0;
    for (name, _) in PICTURES {
        let page = format!("studies/{name}/README.md");
        let text = std::fs::read_to_string(root().join(&page)).expect("the page of a study");
        let quote: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("> ")).collect();
        if !quote.is_empty() {
            let summary = summary_of(name);
            assert_eq!(flat(&quote.join(" ")), flat(summary["verdict"].as_str().unwrap_or_default()), "{page}");
            quotes += 1;
        }
    }
    assert!(quotes > 5, "{quotes}");
}
