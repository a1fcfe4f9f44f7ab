//! Rules of the source that no compiler checks: who may use whom, who may print, how long a file may be.

use std::path::{Path, PathBuf};

/// A module may use those before it. `cli`, with `main`, may use the library only.
const ORDER: [&str; 10] =
    ["math", "mesh", "material", "system", "effect", "solve", "scene", "calibrate", "study", "report"];
/// Beyond the order: what a module may use of the library at all.
const ONLY: [(&str, &[&str]); 1] = [("solve", &["math", "system", "solve"])];
const LONGEST: usize = 400;

struct Source {
    /// Relative to `src/`: `scene/build.rs`
    name: String,
    /// `scene`, or `lib` and `main` for the roots
    module: String,
    text: String,
}

fn sources() -> Vec<Source> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).expect("a folder of sources").flatten() {
            let path = entry.path();
            if path.is_dir() {
                walk(&path, found);
            } else if path.extension().is_some_and(|x| x == "rs") {
                found.push(path);
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    walk(&root, &mut files);
    files.sort();
    let read = |path: PathBuf| {
        let name = path.strip_prefix(&root).expect("below src").to_string_lossy().into_owned();
        let first = name.split('/').next().expect("a name");
        let module = first.trim_end_matches(".rs").to_string();
        Source { name, module, text: std::fs::read_to_string(path).expect("a source file") }
    };
    files.into_iter().map(read).collect()
}

/// The code of a file: without comments, and without its tests, which stand last.
fn code(source: &Source) -> String {
    let text = source.text.split("#[cfg(test)]\nmod tests {").next().expect("a part");
    text.lines().map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

/// First segments of the paths `crate::…` in the code, with those of groups `crate::{a::…, b::…}`.
fn used(code: &str) -> Vec<String> {
    let word = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut found = Vec::new();
    for part in code.split("crate::").skip(1) {
        let Some(group) = part.strip_prefix('{') else {
            found.push(word(part));
            continue;
        };
        let (mut depth, mut start) = (0, true);
        for (k, c) in group.char_indices() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => start = true,
                c if start && c.is_alphanumeric() => {
                    found.push(word(&group[k..]));
                    start = false;
                }
                _ => {}
            }
        }
    }
    found.retain(|w| !w.is_empty());
    found
}

#[test]
fn paths_are_found_in_groups_too() {
    let code =
        "use crate::math::tensor::Vec3;\nuse crate::{mesh::{TetMesh, Order}, system::At};\nlet x = crate::solve::f();";
    assert_eq!(used(code), ["math", "mesh", "system", "solve"]);
}

#[test]
fn modules_use_only_those_before_them() {
    let rank = |module: &str| ORDER.iter().position(|m| *m == module);
    let mut wrong = Vec::new();
    for source in sources().iter().filter(|s| s.module != "lib") {
        for other in used(&code(source)) {
            let Some(theirs) = rank(&other) else {
                // In the binary `crate` is the command line itself.
                if rank(&source.module).is_some() {
                    wrong.push(format!("{}: crate::{other} is no module of the order", source.name));
                }
                continue;
            };
            let allowed = rank(&source.module).is_some_and(|own| theirs <= own);
            let only = ONLY.iter().find(|(m, _)| *m == source.module);
            if !allowed || only.is_some_and(|(_, list)| !list.contains(&other.as_str())) {
                wrong.push(format!("{}: {} must not use {other}", source.name, source.module));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_module_has_its_place_in_the_order() {
    let lib = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs")).expect("there");
    for line in lib.lines().filter_map(|l| l.strip_prefix("pub mod ")) {
        let module = line.trim_end_matches(';');
        assert!(ORDER.contains(&module), "module {module} is not in the order of tests/structure.rs");
    }
}

#[test]
fn the_library_neither_prints_nor_exits() {
    let loud = ["println!", "eprintln!", "print!(", "eprint!(", "dbg!(", "process::exit", "todo!(", "unimplemented!("];
    for source in sources().iter().filter(|s| s.module != "cli" && s.module != "main") {
        let code = code(source);
        for word in loud {
            assert!(!code.contains(word), "{}: {word}", source.name);
        }
    }
}

#[test]
fn files_are_short_and_say_what_they_are() {
    for source in sources() {
        let lines = source.text.lines().count();
        assert!(lines <= LONGEST, "{} has {lines} lines; split it at {LONGEST}", source.name);
        let generated_test = source.name.ends_with("/tests.rs");
        assert!(source.text.starts_with("//!") || generated_test, "{}: the first line says what is in it", source.name);
    }
}

/// Kinds of `pub enum Name { … }` in files: its variants in snake case.
fn kinds(text: &str, name: &str) -> Vec<String> {
    let start = text.find(&format!("pub enum {name} {{")).unwrap_or_else(|| panic!("{name} is gone"));
    let body = &text[start..];
    let body = &body[..body.find("\n}").expect("its end")];
    let variant = |line: &str| {
        let line = line.strip_prefix("    ")?;
        let word: String = line.chars().take_while(|c| c.is_alphanumeric()).collect();
        word.starts_with(|c: char| c.is_uppercase()).then_some(word)
    };
    let snake = |word: String| {
        let mut out = String::new();
        for c in word.chars() {
            if c.is_uppercase() && !out.is_empty() {
                out.push('_');
            }
            out.extend(c.to_lowercase());
        }
        out
    };
    body.lines().skip(1).filter_map(variant).map(snake).collect()
}

/// The reference names every kind that a scene file can choose.
#[test]
fn every_kind_is_in_the_reference() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = |file: &str| std::fs::read_to_string(root.join("src/scene").join(file)).expect("there");
    let spec = text("spec.rs") + &text("mesh_spec.rs");
    let names = ["EffectSpec", "ConstraintSpec", "ProbeSpec", "IntegratorSpec", "SelectorSpec"];
    let kinds: Vec<String> = names.iter().flat_map(|name| kinds(&spec, name)).collect();
    for known in ["elastic", "cable", "bending_angle", "generalised_alpha", "box"] {
        assert!(kinds.iter().any(|k| k == known), "{known} is not found: {kinds:?}");
    }
    let folder = std::fs::read_dir(root.join("docs/reference")).expect("the folder of the reference");
    let pages: Vec<String> = folder.flatten().map(|p| std::fs::read_to_string(p.path()).expect("a page")).collect();
    let reference = pages.join("\n");
    let named =
        |k: &str| [format!("`{k}`"), format!("\"{k}\""), format!("{k} = {{")].iter().any(|t| reference.contains(t));
    let missing: Vec<&String> = kinds.iter().filter(|k| !named(k)).collect();
    assert!(missing.is_empty(), "docs/reference does not name {missing:?}");
}
