//! Largest and smallest values in tests: of one that is not a number no bound holds.

use regex::Regex;

use crate::source::{Source, rust_files};

/// `f64::max` and `f64::min` leave out what is not a number, so that a test whose values are all none passes.
#[test]
fn tests_leave_out_no_value_that_is_not_a_number() {
    let sources: Vec<Source> =
        rust_files("tests").into_iter().filter(|s| s.name != "tests/structure/folds.rs").collect();
    assert!(sources.len() > 100, "the tests have moved: {} files", sources.len());
    let wrong: Vec<String> = sources.iter().flat_map(without_some).collect();
    super::assert_none(&wrong, "take `larger` or `smaller` of durometer::math::statistics");
}

/// Places where `max` or `min` of two values is passed on, is the closure of a fold, or replaces the first of the two.
fn without_some(source: &Source) -> Vec<String> {
    let passed = r"\bf64::(?:max|min)\b\s*[^\s(]";
    let closure = r"\|(\w+)(?:: f64)?, [^|]*\|\s*(\w+)\.(?:max|min)\(";
    let turned = r"\|(\w+)(?:: f64)?, [^|]*\|\s*\w+\.(?:abs\(\)\.)?(?:max|min)\((\w+)\)";
    let replaced = r"(\w+) = \*?(\w+)\.(?:max|min)\(";
    let mut found = vec![];
    for pattern in [passed, closure, turned, replaced] {
        for one in Regex::new(pattern).expect("a pattern").captures_iter(&source.text) {
            let name = |k: usize| one.get(k).map(|name| name.as_str());
            if name(1) == name(2) {
                let whole = one.get(0).expect("a match");
                let line = 1 + source.text[..whole.start()].matches('\n').count();
                found.push(format!("{}:{line}: {}", source.name, whole.as_str()));
            }
        }
    }
    found
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
    ] {
        assert_eq!(of(line), 1, "{line}");
    }
    for line in [
        "v.fold(0.0, larger);",
        "v.fold(0.0, |sum, v| sum + v.max(0.0));",
        "let a = f64::max(0.0, b);",
        "let end = t.min(r);",
        "from_fn(9, 9, |i, j| k[i.max(j) * 9 + i.min(j)]);",
    ] {
        assert_eq!(of(line), 0, "{line}");
    }
}
