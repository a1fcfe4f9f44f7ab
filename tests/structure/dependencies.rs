//! Licences and sources of every dependency, as `deny.toml` allows them; `cargo deny check` looks at duplicates and advisories too.

use crate::source::root;
use serde_json::Value;
use std::collections::BTreeSet;
use std::process::Command;

#[test]
fn every_dependency_has_an_allowed_licence_and_comes_from_the_registry() {
    let allowed = allowed();
    let packages = packages();
    let foreign: Vec<&Value> = packages.iter().filter(|package| !package["source"].is_null()).collect();
    assert!(foreign.len() > 200, "{}", foreign.len());
    let mut wrong = vec![];
    for package in foreign {
        let text = |key: &str| package[key].as_str().unwrap_or_default().to_string();
        let is_allowed = holds(&text("license"), &allowed);
        if !is_allowed || !text("source").starts_with("registry+") {
            wrong.push(format!("{} {}: {} from {}", text("name"), text("version"), text("license"), text("source")));
        }
    }
    assert!(wrong.is_empty(), "replace them, or give a reason for their licence in deny.toml:\n{}", wrong.join("\n"));
}

/// The licence of this project is stated alike by all of its packages.
#[test]
fn own_packages_have_the_licence_of_the_project() {
    let packages = packages();
    let own: Vec<&Value> = packages.iter().filter(|package| package["source"].is_null()).collect();
    assert!(own.len() >= 3, "{}", own.len());
    for package in own {
        assert_eq!(package["license"], "MIT OR Apache-2.0", "{}", package["name"]);
        assert_eq!(package["rust_version"], "1.90", "{}", package["name"]);
    }
}

fn allowed() -> BTreeSet<String> {
    let text = std::fs::read_to_string(root().join("deny.toml")).expect("the rules");
    let rules: toml::Table = text.parse().expect("a table");
    let list = rules["licenses"]["allow"].as_array().expect("a list");
    list.iter().map(|name| name.as_str().expect("a name").to_string()).collect()
}

fn packages() -> Vec<Value> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let mut command = Command::new(cargo);
    // Dependencies of other systems are fetched, which a build for this one does not need
    command.args(["metadata", "--format-version", "1", "--locked"]).current_dir(root());
    let output = command.output().expect("cargo starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    read["packages"].as_array().expect("a list").clone()
}

/// Whether an SPDX expression can be satisfied by the allowed licences. The slash of older manifests means OR.
fn holds(expression: &str, allowed: &BTreeSet<String>) -> bool {
    let spaced = expression.replace('(', " ( ").replace(')', " ) ").replace('/', " OR ");
    let words: Vec<&str> = spaced.split_whitespace().collect();
    let mut at = 0;
    let value = any(&words, &mut at, allowed);
    value && at == words.len()
}

fn any(words: &[&str], at: &mut usize, allowed: &BTreeSet<String>) -> bool {
    let mut value = all(words, at, allowed);
    while words.get(*at) == Some(&"OR") {
        *at += 1;
        value |= all(words, at, allowed);
    }
    value
}

fn all(words: &[&str], at: &mut usize, allowed: &BTreeSet<String>) -> bool {
    let mut value = one(words, at, allowed);
    while words.get(*at) == Some(&"AND") {
        *at += 1;
        value &= one(words, at, allowed);
    }
    value
}

fn one(words: &[&str], at: &mut usize, allowed: &BTreeSet<String>) -> bool {
    let Some(word) = words.get(*at) else { return false };
    *at += 1;
    if *word == "(" {
        let value = any(words, at, allowed);
        *at += 1;
        return value;
    }
    let mut name = (*word).to_string();
    if words.get(*at) == Some(&"WITH") {
        name = format!("{name} WITH {}", words.get(*at + 1).copied().unwrap_or_default());
        *at += 2;
    }
    allowed.contains(&name)
}

#[test]
fn expressions_are_read_as_spdx_defines_them() {
    let allowed = BTreeSet::from(["MIT", "Zlib", "Apache-2.0 WITH LLVM-exception"].map(String::from));
    for (expression, expected) in [
        ("MIT", true),
        ("GPL-3.0", false),
        ("GPL-3.0 OR MIT", true),
        ("GPL-3.0/MIT", true),
        ("MIT AND Zlib", true),
        ("MIT AND GPL-3.0", false),
        ("(GPL-3.0 OR MIT) AND Zlib", true),
        ("MIT AND (GPL-3.0 OR AGPL-3.0)", false),
        ("GPL-3.0 OR MIT AND AGPL-3.0", false),
        ("Apache-2.0 WITH LLVM-exception OR GPL-3.0", true),
        ("Apache-2.0", false),
        ("", false),
        ("MIT MIT", false),
    ] {
        assert_eq!(holds(expression, &allowed), expected, "{expression}");
    }
}

/// `cargo build` and `cargo test` take the same features of every crate, so that the second does not compile the library again: 4 minutes on two cores.
/// Where this fails, `src/Cargo.toml` asks for the features of the tests too.
#[test]
fn tests_ask_for_no_feature_that_the_program_does_not() {
    let features = |edges: &str| {
        let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
        let mut command = Command::new(cargo);
        command.args(["tree", "--locked", "--prefix", "none", "--format", "{p} {f}", "--edges", edges]);
        let output = command.current_dir(root()).output().expect("cargo starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        text.lines().map(|line| line.trim_end_matches(" (*)").trim_end().to_string()).collect::<BTreeSet<_>>()
    };
    let (building, testing) = (features("normal,build"), features("normal,build,dev"));
    assert!(building.len() > 200 && testing.len() > building.len());
    let other: Vec<&String> = building.difference(&testing).collect();
    assert!(other.is_empty(), "with other features in tests: {other:#?}");
}
