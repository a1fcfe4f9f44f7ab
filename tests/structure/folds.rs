//! Largest and smallest values in tests: of one that is not a number no bound holds.

use regex::Regex;
use std::collections::BTreeMap;

use crate::source::{Source, rust_files};

/// `f64::max` and `f64::min` leave out what is not a number, so that a test whose values are all none passes.
#[test]
fn tests_leave_out_no_value_that_is_not_a_number() {
    // The tests of the sources compute no values
    let sources: Vec<Source> =
        rust_files("tests").into_iter().filter(|s| !s.name.starts_with("tests/structure/")).collect();
    assert!(sources.len() > 100, "the tests have moved: {} files", sources.len());
    let wrong: Vec<String> = sources.iter().flat_map(without_some).collect();
    super::assert_none(&wrong, "take `larger` or `smaller` of durometer::math::statistics");
}

/// Places where `max` or `min` of two values is passed on, is the closure of a fold, replaces the first of the two, or is that of two errors.
fn without_some(source: &Source) -> Vec<String> {
    let passed = r"\bf64::(?:max|min)\b\s*[^\s(]";
    let closure = r"\|(\w+)(?:: f64)?, [^|]*\|\s*(\w+)\.(?:max|min)\(";
    let turned = r"\|(\w+)(?:: f64)?, [^|]*\|\s*\w+\.(?:abs\(\)\.)?(?:max|min)\((\w+)\)";
    let of_one_kind = r"\b(\w+)\([^()]*\)\.(?:max|min)\((\w+)\(";
    let of_differences = r"\([^()]* [-+] [^()]*\)\.abs\(\)\.(?:max|min)\(\([^()]* [-+] ";
    let text = &source.text;
    let mut found = BTreeMap::new();
    for pattern in [passed, closure, turned, of_one_kind, of_differences] {
        for one in Regex::new(pattern).expect("a pattern").captures_iter(text) {
            let name = |k: usize| one.get(k).map(|name| name.as_str());
            let whole = one.get(0).expect("a match");
            if name(1) == name(2) {
                found.insert(whole.start(), whole.as_str());
            }
        }
    }
    for one in Regex::new(r"\b(\w+)(?:\[\w+\])?\.(?:max|min)\(").expect("a pattern").captures_iter(text) {
        let whole = one.get(0).expect("a match");
        if is_given_to(&one[1], &text[..whole.start()]) {
            found.insert(whole.start(), whole.as_str());
        }
    }
    let line = |at: usize| 1 + text[..at].matches('\n').count();
    found.into_iter().map(|(at, what)| format!("{}:{}: {what}", source.name, line(at))).collect()
}

/// Whether the statement that this text begins gives its value, that of a branch, or one of a tuple to the variable of this name.
fn is_given_to(name: &str, text: &str) -> bool {
    let statement = text.rsplit(';').next().unwrap_or(text);
    statement.match_indices(" = ").any(|(at, equals)| {
        let (left, right) = (&statement[..at], &statement[at + equals.len()..]);
        let left = left.rsplit(['{', '}', '\n', '|']).next().unwrap_or(left);
        let mut names = left.split(|c: char| !c.is_alphanumeric() && c != '_');
        let is_whole =
            ["", "*"].contains(&right) || ["(", "if ", "match "].iter().any(|start| right.starts_with(start));
        is_whole && !left.contains("if let ") && !left.contains("while let ") && names.any(|n| n == name)
    })
}

#[test]
fn folds_that_leave_out_values_are_found() {
    let of = |line: &str| without_some(&Source::new("tests/a.rs", &format!("fn f() {{\n    {line}\n}}"))).len();
    for line in [
        "assert!(v.fold(0.0, f64::max) < 1.0);",
        "v.reduce(f64::min);",
        "v.fold(0.0, |m: f64, v| m.max(v.abs()));",
        "v.fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));",
        "v.fold(0.0, |m, v| v.max(m));",
        "v.fold(0.0, |m, v| v.abs().max(m));",
        "worst = worst.max(error);",
        "v.for_each(|w| *w = w.max(error));",
        "largest[k] = largest[k].max(error / size);",
        "(worst, most) = (worst.max(error), most);",
        "(worst, most) = (worst, most.max(got.abs() / size));",
        "worst = if got == expected { worst } else { worst.max(error) };",
        "let uneven = even(a).max(even(b));",
        "let away = (u[0] - v[1]).abs().max((u[1] - v[0]).abs());",
    ] {
        assert_eq!(of(line), 1, "{line}");
    }
    for line in [
        "v.fold(0.0, larger);",
        "v.fold(0.0, |sum, v| sum + v.max(0.0));",
        "let a = f64::max(0.0, b);",
        "let end = t.min(r);",
        "let size = (p / k).abs().max(slope.abs());",
        "if let Some(v) = (a < v.max(b)).then_some(c) {}",
        "from_fn(9, 9, |i, j| k[i.max(j) * 9 + i.min(j)]);",
    ] {
        assert_eq!(of(line), 0, "{line}");
    }
}
