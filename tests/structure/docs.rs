//! The documentation agrees with the code: the reference names every key of the files, links resolve, command lines
//! parse, example scenes and studies are read.

use crate::parts::each_part;
use crate::source::{root, rust_files};
use durometer::scene::spec::{ConstraintSpec, EffectSpec, ProbeSpec, SelectorSpec};
use durometer::scene::{ParameterKey, overrides, read_scene};
use durometer::study::schema;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

fn text(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The pages of `docs/reference`, in the order of their names.
fn reference() -> String {
    let folder = std::fs::read_dir(root().join("docs/reference")).expect("the folder of the reference");
    let mut pages: Vec<PathBuf> = folder.flatten().map(|entry| entry.path()).collect();
    pages.sort();
    pages.iter().map(text).collect::<Vec<_>>().join("\n")
}

/// Words in code style: between backticks or in fenced blocks.
fn code_words(markdown: &str) -> BTreeSet<String> {
    let mut words = BTreeSet::new();
    let mut fenced = false;
    for line in markdown.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
            continue;
        }
        for (k, part) in line.split('`').enumerate() {
            if fenced || k % 2 == 1 {
                let split = part.split(|c: char| !c.is_alphanumeric() && c != '_');
                words.extend(split.filter(|w| !w.is_empty()).map(str::to_string));
            }
        }
    }
    words
}

fn missing(keys: BTreeSet<String>) -> Vec<String> {
    let words = code_words(&reference());
    keys.into_iter().filter(|key| !words.contains(key)).collect()
}

/// Names that a file may hold by its schema: its keys, and the words that a value is one of.
fn names_of(schema: &Value) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    each_part(schema, &mut |path, part| {
        let mut ends = path.rsplit('/');
        match (ends.next(), ends.next()) {
            (Some(key), Some("properties")) => names.extend([key.to_string()]),
            (Some("const"), _) | (_, Some("enum")) => names.extend(part.as_str().map(String::from)),
            _ => {}
        }
    });
    names
}

#[test]
fn the_reference_names_every_key_of_a_scene_and_a_study() {
    for schema in [schema::scene(), schema::study()] {
        let names = names_of(schema.as_value());
        assert!(names.len() > 100, "{names:?}");
        assert_eq!(missing(names), Vec::<String>::new(), "not in docs/reference");
    }
}

#[test]
fn the_reference_names_every_law_constant_and_body() {
    let laws = durometer::material::LAWS;
    let keys = laws.iter().flat_map(|l| l.keys.iter().map(|k| k.name)).chain(laws.iter().map(|l| l.info.name));
    assert_eq!(missing(keys.map(str::to_string).collect()), Vec::<String>::new(), "not in docs/reference");
    let bodies: BTreeSet<String> = durometer::mesh::generate::body::names(&root()).into_iter().collect();
    assert!(bodies.contains("finger"));
    let (described, reference) = (code_words(&text("meshes/README.md")), code_words(&reference()));
    for body in bodies {
        assert!(reference.contains(&body), "{body} is not in docs/reference");
        assert!(described.contains(&body), "{body} is not in meshes/README.md");
    }
}

/// Names of the integrators, as a stage has them.
fn integrators() -> BTreeSet<String> {
    let schema = schema::scene();
    let kinds = schema.pointer("/$defs/IntegratorSpec/oneOf").and_then(Value::as_array).expect("a table for each kind");
    kinds.iter().filter_map(|kind| kind["properties"]["kind"]["const"].as_str()).map(String::from).collect()
}

#[test]
fn the_explanation_has_a_section_for_every_effect_probe_law_and_integrator() {
    let laws: Vec<&str> = durometer::material::LAWS.iter().map(|law| law.info.name).collect();
    for (kinds, page) in [
        (EffectSpec::KINDS, "effects"),
        (ConstraintSpec::KINDS, "effects"),
        (ProbeSpec::KINDS, "probes"),
        (laws.as_slice(), "laws"),
    ] {
        let page = format!("docs/explanation/{page}.md");
        let headings: BTreeSet<String> =
            text(&page).lines().filter(|line| line.starts_with('#')).flat_map(code_words).collect();
        let missing: Vec<&&str> = kinds.iter().filter(|kind| !headings.contains(**kind)).collect();
        assert!(missing.is_empty(), "{page} has no section with the heading `KIND` of {missing:?}");
    }
    // One section serves the three forms of implicit Euler
    let words = code_words(&text("docs/explanation/integrators.md"));
    let integrators = integrators();
    assert!(integrators.len() > 4, "{integrators:?}");
    let missing: Vec<&String> = integrators.iter().filter(|kind| !words.contains(*kind)).collect();
    assert!(missing.is_empty(), "docs/explanation/integrators.md has no {missing:?}");
}

/// The table of the reference with this head has a row for each kind that a scene file can choose, and no other.
#[test]
fn the_reference_has_a_row_for_every_kind() {
    let integrators = integrators();
    let integrators: Vec<&str> = integrators.iter().map(String::as_str).collect();
    for (kinds, page, head) in [
        (EffectSpec::KINDS, "effects", "| `kind` | keys |"),
        (ConstraintSpec::KINDS, "constraints", "| `kind` | keys |"),
        (ProbeSpec::KINDS, "probes", "| `kind` | keys | columns |"),
        (SelectorSpec::KINDS, "mesh", "| `kind` of a selector | keys | contains |"),
        (integrators.as_slice(), "stages", "| `integrator` | keys |"),
    ] {
        let page = format!("docs/reference/{page}.md");
        let text = text(&page);
        let rows = text.lines().skip_while(|line| *line != head).skip(2).take_while(|line| line.starts_with('|'));
        let first = rows.map(|row| row.split('|').nth(1).unwrap_or_default().trim().trim_matches('`'));
        // `"static"` and `{ kind = "newmark", … }`
        let name = |cell: &str| cell.split('"').nth(1).unwrap_or(cell).to_string();
        let rows: BTreeSet<String> = first.map(name).collect();
        assert_eq!(rows, kinds.iter().map(ToString::to_string).collect::<BTreeSet<_>>(), "{page}, {head}");
    }
}

/// Names of the laws in code style on lines of a page.
fn laws_on<'a>(lines: impl Iterator<Item = &'a str>) -> BTreeSet<String> {
    let words: BTreeSet<String> = lines.flat_map(code_words).collect();
    words.into_iter().filter(|word| durometer::material::LAWS.iter().any(|law| law.info.name == word)).collect()
}

/// The lists of laws that pages have are those of the registry.
#[test]
fn lists_of_laws_are_complete() {
    let those = |of: fn(&durometer::material::LawEntry) -> bool| -> BTreeSet<String> {
        durometer::material::LAWS.iter().filter(|law| of(law)).map(|law| law.info.name.to_string()).collect()
    };
    let terms = |law: &durometer::material::LawEntry| law.fit.is_some_and(|form| form.term_counts.len() > 1);
    for (page, head, expected) in [
        ("docs/reference/commands.md", "| `--law LAW` | required; ", those(|law| law.fit.is_some())),
        ("docs/reference/commands.md", "| `--terms TERMS` | number of terms: ", those(terms)),
        ("docs/explanation/effects.md", "- **Laws.** ", those(|law| law.info.isochoric)),
    ] {
        let page_text = text(page);
        let line = page_text.lines().filter(|line| line.starts_with(head));
        assert_eq!(laws_on(line), expected, "{page}: {head}");
    }
    for (page, head, expected) in [
        ("docs/explanation/laws.md", "| law | any rotation ", those(|_| true)),
        ("docs/explanation/calibration.md", "| law | constants (linear in bold) ", those(|law| law.fit.is_some())),
    ] {
        let page_text = text(page);
        let table =
            page_text.lines().skip_while(|line| !line.starts_with(head)).take_while(|line| line.starts_with('|'));
        assert_eq!(laws_on(table.filter_map(|row| row.split('|').nth(1))), expected, "{page}: {head}");
    }
}

fn pages(folder: &Path, out: &mut Vec<PathBuf>) {
    let skipped = ["target", ".git", ".venv", "reports", "node_modules"];
    for entry in std::fs::read_dir(folder).expect("a folder of the project").flatten() {
        let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
        if path.is_dir() && !skipped.contains(&name.as_str()) {
            pages(&path, out);
        } else if name.ends_with(".md") {
            out.push(path);
        }
    }
}

/// Anchor of a heading, as the usual hosts make it.
fn anchor(heading: &str) -> String {
    let kept = heading.trim_start_matches('#').trim().to_lowercase();
    kept.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c)).map(|c| if c == ' ' { '-' } else { c }).collect()
}

#[test]
fn every_relative_link_leads_somewhere() {
    let mut all = Vec::new();
    pages(&root(), &mut all);
    assert!(all.len() > 10);
    let mut broken = Vec::new();
    for page in &all {
        let text = std::fs::read_to_string(page).expect("a page");
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            if target.contains("://") || target.contains(' ') {
                continue;
            }
            let (path, fragment) = target.split_once('#').unwrap_or((target, ""));
            let folder = page.parent().expect("a file has a folder");
            let goal = if path.is_empty() { page.clone() } else { folder.join(path) };
            let found = if fragment.is_empty() || goal.extension().is_none_or(|e| e != "md") {
                goal.exists()
            } else {
                std::fs::read_to_string(&goal)
                    .is_ok_and(|t| t.lines().filter(|l| l.starts_with('#')).any(|heading| anchor(heading) == fragment))
            };
            if !found {
                broken.push(format!("{}: {target}", page.display()));
            }
        }
    }
    assert_eq!(broken, Vec::<String>::new());
}

/// Fenced blocks of a language.
fn blocks(markdown: &str, language: &str) -> Vec<String> {
    let mut out = Vec::new();
    let mut lines = markdown.lines();
    while let Some(line) = lines.next() {
        if line.trim_start().starts_with("```") {
            let block: Vec<&str> = lines.by_ref().take_while(|l| !l.trim_start().starts_with("```")).collect();
            if line.trim_start().trim_start_matches('`') == language {
                out.push(block.join("\n") + "\n");
            }
        }
    }
    out
}

/// Words of a command line; quotes hold words together.
fn words(line: &str) -> Vec<String> {
    let (mut out, mut word, mut quote) = (Vec::new(), String::new(), None);
    for c in line.chars() {
        match (quote, c) {
            (Some(q), c) if c == q => quote = None,
            (None, '\'' | '"') => quote = Some(c),
            (None, ' ') => out.push(std::mem::take(&mut word)),
            _ => word.push(c),
        }
    }
    out.push(word);
    out.into_iter().filter(|w| !w.is_empty()).collect()
}

/// The arguments of every line that calls the program, without the comment at its end and the file that its output goes to, and of every call in a table of the README.
fn calls(page: &str) -> Vec<Vec<String>> {
    let text = text(page);
    let mut blocks = blocks(&text.replace("\\\n", " "), "sh");
    if page == "README.md" {
        let rows = text.lines().filter(|line| line.starts_with('|'));
        blocks.extend(rows.flat_map(|row| row.split('`').skip(1).step_by(2)).map(String::from));
    }
    let before = |line: &str, mark: &str| line.split(mark).next().unwrap_or_default().to_string();
    let lines = blocks.iter().flat_map(|b| b.lines()).map(|line| before(&before(line, " #"), " > "));
    let heads = ["durometer ", "cargo run --release -- "];
    lines.filter_map(|l| heads.iter().find_map(|h| l.strip_prefix(h)).map(words)).collect()
}

/// The calls in the examples of every help, without the words after two spaces, which say what a call does.
fn examples() -> Vec<Vec<String>> {
    let leaves = commands(&[]);
    let all: BTreeSet<&[String]> = leaves.iter().flat_map(|leaf| (1..=leaf.len()).map(move |n| &leaf[..n])).collect();
    let mut lines: Vec<String> = Vec::new();
    for help in all.into_iter().map(help) {
        let list = help.lines().skip_while(|line| *line != "Examples:").skip(1).take_while(|line| !line.is_empty());
        for line in list.map(str::trim) {
            let begins = ["durometer ", "echo "].iter().any(|head| line.starts_with(head));
            match lines.last_mut() {
                // The help breaks long lines.
                Some(last) if !begins => last.extend([" ", line]),
                _ => lines.push(line.to_string()),
            }
        }
    }
    let code = lines.iter().filter_map(|line| line.split("  ").next());
    let calls = code.flat_map(|line| line.split(" | ")).filter_map(|call| call.strip_prefix("durometer "));
    calls.filter_map(|call| call.split(" > ").next()?.split(" < ").next()).map(words).collect()
}

/// A call has known flags, and files of the project that it names exist.
fn assert_call(place: &str, call: &[String]) {
    for file in call.iter().filter(|w| w.starts_with("studies/") || w.starts_with("data/")) {
        assert!(root().join(file).exists(), "{place}: {file} does not exist");
    }
    // Everything before it is parsed first: an unknown flag or command is an error, --help ends well.
    let mut program = Command::new(env!("CARGO_BIN_EXE_durometer"));
    let output = program.args(call).arg("--help").output().expect("the program runs");
    assert!(output.status.success(), "{place}: {call:?}: {}", String::from_utf8_lossy(&output.stderr));
    let flags = String::from_utf8_lossy(&output.stdout).into_owned();
    for flag in call.iter().filter(|w| w.starts_with("--")) {
        assert!(flags.contains(flag.as_str()), "{place}: {call:?}: there is no flag {flag}");
    }
    assert_keys(place, call);
    assert_models(place, call);
}

/// The keys of a call are keys of the scene that it names, where that is one of the project.
fn assert_keys(place: &str, call: &[String]) {
    let scene_of = |word: &String| {
        let path = if word.starts_with("studies/") { word.clone() } else { format!("studies/{word}/scene.toml") };
        Some(root().join(path)).filter(|path| path.ends_with("scene.toml") && path.is_file())
    };
    let values =
        |flag: &str| -> Vec<&String> { call.windows(2).filter(|pair| pair[0] == flag).map(|pair| &pair[1]).collect() };
    let (changes, keys) = (values("--set"), values("--sensitivity"));
    let Some(file) = call.iter().find_map(scene_of).filter(|_| !changes.is_empty() || !keys.is_empty()) else { return };
    let changes: Result<Vec<_>, _> = changes.iter().map(|change| overrides::parse(change)).collect();
    let changes = changes.unwrap_or_else(|e| panic!("{place}: {call:?}: {e}"));
    let (_, resolved) = read_scene(&file, &changes).unwrap_or_else(|e| panic!("{place}: {call:?}: {e}"));
    let scene: toml::Table = resolved.parse().expect("a scene");
    for key in keys {
        let value = key.parse().and_then(|key: ParameterKey| key.value(&scene));
        assert!(value.is_ok(), "{place}: {call:?}: {}", value.expect_err("a reason"));
    }
}

/// A reduced model that a call names is one that its study makes.
fn assert_models(place: &str, call: &[String]) {
    let model = regex::Regex::new(r"^reports/(.+)/models/(.+)-(\d+)\.durom$").expect("a pattern");
    for found in call.iter().filter_map(|word| model.captures(word)) {
        let study: toml::Table = text(format!("studies/{}/study.toml", &found[1])).parse().expect("a study");
        let modes: i64 = found[3].parse().expect("a number");
        let made = study["modes"].as_array().expect("a list").iter().any(|number| number.as_integer() == Some(modes));
        assert!(made && found[1] == found[2], "{place}: {} is not made: modes = {}", &found[0], study["modes"]);
    }
}

#[test]
fn command_lines_parse() {
    let mut pages_with_calls = 0;
    let mut all = Vec::new();
    pages(&root(), &mut all);
    let names = all.iter().map(|page| page.strip_prefix(root()).expect("a page of the project").to_string_lossy());
    for page in names {
        let page = page.as_ref();
        let calls = calls(page);
        pages_with_calls += usize::from(!calls.is_empty());
        calls.iter().for_each(|call| assert_call(page, call));
    }
    assert!(pages_with_calls > 3);
}

/// The examples of every help are calls that the program takes, with keys and models that are there.
#[test]
fn examples_of_the_help_are_calls_of_the_program() {
    let examples = examples();
    assert!(examples.len() > 60, "{}", examples.len());
    examples.iter().for_each(|call| assert_call("--help", call));
}

/// A call of single tests, as `cargo test --test effects cable::`, names programs and files of tests.
#[test]
fn calls_of_tests_name_tests_that_exist() {
    let program = regex::Regex::new(r"--test\s+(\w+)").expect("a pattern");
    let module = regex::Regex::new(r"(?:^| )((?:\w+::)+)").expect("a pattern");
    let library = rust_files("src");
    let (mut all, mut calls) = (Vec::new(), 0);
    pages(&root(), &mut all);
    for page in all {
        let text = text(&page);
        let code = text.split('`').skip(1).step_by(2);
        for call in code.filter(|code| code.starts_with("--test ") || code.contains("cargo test")) {
            let programs: Vec<&str> =
                program.captures_iter(call).filter_map(|found| found.get(1)).map(|m| m.as_str()).collect();
            // `--test N` of `durometer fit`
            for name in programs.iter().filter(|name| !name.chars().all(|c| c.is_ascii_digit() || c == 'N')) {
                let place = root().join("tests").join(name);
                assert!(
                    place.join("main.rs").is_file() || place.with_extension("rs").is_file() || *name == "units",
                    "{}: {call}",
                    page.display()
                );
                calls += 1;
            }
            for name in module.captures_iter(call).filter_map(|found| found.get(1)) {
                let name = name.as_str().trim_end_matches("::");
                let file = format!("{}.rs", name.replace("::", "/"));
                let is_there = programs.iter().any(|program| match *program {
                    "units" => library.iter().any(|source| source.module.join("::").ends_with(name)),
                    program => root().join("tests").join(program).join(&file).is_file(),
                });
                assert!(is_there, "{}: {call}: there is no {file}", page.display());
            }
        }
    }
    assert!(calls > 50, "{calls}");
}

/// Files, and functions of the tests, that contributors are sent to.
#[test]
fn contributors_are_sent_to_files_and_functions_that_exist() {
    let page = text("CONTRIBUTING.md");
    let code: Vec<&str> =
        page.split('`').skip(1).step_by(2).filter(|code| !code.contains(['<', '*', ' ', '\n'])).collect();
    let folders = ["src/", "tests/", "examples/", "meshes/", "viewer/", ".ci/"];
    let files = code.iter().filter(|code| folders.iter().any(|folder| code.starts_with(folder)));
    let files: Vec<PathBuf> = files.map(|file| root().join(file)).collect();
    let absent: Vec<&PathBuf> = files.iter().filter(|file| !file.exists()).collect();
    assert!(files.len() > 20 && absent.is_empty(), "{absent:?} of {}", files.len());
    let tests = text("tests/effects/every_kind.rs");
    for name in ["effect_kind", "momentum_balances"] {
        assert!(code.contains(&name) && tests.contains(&format!("fn {name}(")), "{name}");
    }
}

/// The names of the methods of a trait in a file.
fn methods_of(file: &str, name: &str) -> BTreeSet<String> {
    let tree = syn::parse_file(&text(file)).expect("a source file");
    let of = tree.items.into_iter().find_map(|item| match item {
        syn::Item::Trait(of) if of.ident == name => Some(of.items),
        _ => None,
    });
    let methods = of.unwrap_or_else(|| panic!("{name} has moved")).into_iter().filter_map(|item| match item {
        syn::TraitItem::Fn(method) => Some(method.sig.ident.to_string()),
        _ => None,
    });
    methods.collect()
}

/// Who adds a probe reads of every method that it may have, by its name.
#[test]
fn contributors_read_of_every_method_of_a_probe() {
    let page = text("CONTRIBUTING.md");
    let paragraph = page.split("\n\n").find(|paragraph| paragraph.starts_with("`Probe` has ")).expect("a paragraph");
    let mut expected = methods_of("src/scene/parts/probes/part.rs", "Probe");
    expected.extend(methods_of("src/scene/record/recorder.rs", "Recorder"));
    expected.extend(["Probe", "Recorder"].map(String::from));
    assert_eq!(code_words(paragraph), expected);
}

/// The complete check knows the flags that contributors read of, and installs nothing of the system without looking at them.
#[test]
fn the_complete_check_has_the_flags_that_contributors_read_of() {
    let (page, script) = (text("CONTRIBUTING.md"), text(".ci/run"));
    let calls: Vec<&str> = page.split('`').filter_map(|code| code.strip_prefix(".ci/run ")).collect();
    assert!(!calls.is_empty());
    for flag in calls.iter().flat_map(|call| call.split(' ')) {
        assert!(script.contains(&format!("\n{flag}) ")), ".ci/run does not know {flag}");
    }
    let tools = script.split("\ntools() {\n").nth(1).and_then(|rest| rest.split("\n}\n").next()).expect("the function");
    assert!(tools.trim_start().starts_with("[ -n \"$all_tools\" ] || return 0"), "{tools}");
    assert_eq!(script.matches("apt-get ").count(), tools.matches("apt-get ").count(), "apt-get outside of tools()");
}

/// What a command answers to `--help`.
fn help(command: &[String]) -> String {
    let mut program = Command::new(env!("CARGO_BIN_EXE_durometer"));
    let output = program.args(command).arg("--help").output().expect("it runs");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// The commands below one, by the list in its help; itself if it has none.
fn commands(command: &[String]) -> Vec<Vec<String>> {
    let help = help(command);
    let list = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.trim().is_empty());
    let names = list.filter_map(|line| line.strip_prefix("  ")?.split(' ').next().filter(|name| !name.is_empty()));
    let below: Vec<Vec<String>> = names
        .filter(|name| *name != "help")
        .flat_map(|name| commands(&[command, &[name.to_string()]].concat()))
        .collect();
    if below.is_empty() { vec![command.to_vec()] } else { below }
}

#[test]
fn every_flag_is_in_the_reference() {
    let page = text("docs/reference/commands.md");
    let commands = commands(&[]);
    assert!(commands.len() > 25, "{commands:?}");
    for command in commands {
        // Commands below one may share its section
        let heads = (1..=command.len()).rev().map(|n| format!("`durometer {}", command[..n].join(" ")));
        let of = |head: String| {
            page.split("\n## ").find(|s| s.strip_prefix(&head).is_some_and(|rest| rest.starts_with([' ', '`'])))
        };
        let section = heads.filter_map(of).next();
        let section = section.unwrap_or_else(|| panic!("the reference has no section on {command:?}"));
        for flag in help(&command).split_whitespace().filter(|w| w.starts_with("--") && w.len() > 3) {
            let flag = flag.trim_end_matches([',', '.', ':', '=', ']']);
            assert!(
                flag == "--help" || section.contains(flag),
                "{command:?}: {flag} is not in its section of the reference"
            );
        }
    }
}

/// The scene that the example of a validation names; a validation reads its scenes.
const VALIDATED: &str = r#"
[mesh]
body = "beam"
size = "6 mm"

[laws.rubber]
law = "neo_hookean"
E = "265 kPa"
nu = 0.45

[[effect]]
kind = "elastic"
region = "body"
law = "rubber"

[[effect]]
kind = "gravity"
region = "body"
density = "1070 kg/m^3"
direction = [0, 0, -1]
acceleration = { kind = "ramp", from = "0 m/s^2", to = "9.81 m/s^2", end = "1 s" }

[[constraint]]
kind = "fixed"
region = "root"

[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.25 s"

[[probe]]
kind = "position"
region = "tip"
"#;

#[test]
fn example_scenes_and_studies_are_read() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (mut scenes, mut studies) = (0, 0);
    let mut all = Vec::new();
    pages(&root(), &mut all);
    for page in all {
        let markdown = text(&page);
        let page = page.display();
        for block in blocks(&markdown, "toml").iter().filter(|b| b.contains("[[stage]]") || b.contains("[[family]]")) {
            if block.contains("[[family]]") {
                std::fs::write(folder.path().join("scene.toml"), VALIDATED).expect("a file is written");
                for name in block.lines().filter_map(|line| line.strip_prefix("file = \"")?.strip_suffix(".csv\"")) {
                    let measured = root().join("data/synthetic-dumbbell/pull.csv");
                    std::fs::copy(measured, folder.path().join(format!("{name}.csv"))).expect("a file is copied");
                }
                durometer::study::study_file::parse(
                    &folder.path().join("study.toml"),
                    block,
                    durometer::study::kind::StudyScope::Whole,
                )
                .unwrap_or_else(|e| panic!("{page}: {e}"));
                studies += 1;
                continue;
            }
            let file = folder.path().join("scene.toml");
            std::fs::write(&file, block).expect("a file is written");
            read_scene(&file, &[]).unwrap_or_else(|e| panic!("{page}: {e}"));
            scenes += 1;
        }
    }
    assert!(scenes >= 3 && studies >= 1, "{scenes} scenes, {studies} studies");
}

/// Types that the column "in the code" of the notation names are types of the source.
#[test]
fn the_notation_names_types_that_exist() {
    let source: String = rust_files("src").into_iter().map(|source| source.text).collect();
    let declared = |name: &str| {
        ["struct", "enum", "trait"].iter().any(|kind| {
            let head = format!("{kind} {name}");
            source
                .match_indices(&head)
                .any(|(at, _)| !source[at + head.len()..].starts_with(|c: char| c.is_alphanumeric()))
        })
    };
    let page = text("docs/explanation/notation.md");
    let cells = page.lines().filter(|line| line.starts_with('|')).filter_map(|line| line.split('|').nth(2));
    let names = cells.flat_map(|cell| cell.split('`').skip(1).step_by(2)).filter_map(|name| name.split("::").next());
    let types: Vec<&str> = names.filter(|name| name.starts_with(|c: char| c.is_uppercase()) && *name != "EA").collect();
    assert!(types.len() > 10, "{types:?}");
    let unknown: Vec<&&str> = types.iter().filter(|name| !declared(name)).collect();
    assert!(unknown.is_empty(), "docs/explanation/notation.md names types that do not exist: {unknown:?}");
}

#[test]
fn the_first_example_is_built_from_a_committed_mesh() {
    use durometer::scene::{Body, Scene};
    let folder = tempfile::tempdir().expect("a temporary folder");
    let page = "docs/reference/scene.md";
    let block = blocks(&text(page), "toml").into_iter().find(|b| b.contains("body = \"finger\"")).expect("an example");
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, &block).expect("a file is written");
    let (spec, resolved) = read_scene(&file, &[]).unwrap_or_else(|e| panic!("{page}: {e}"));
    let body = Body::load(&file, &spec.mesh, &mut |_| {}).unwrap_or_else(|e| panic!("{page}: {e}"));
    Scene::build(&file, spec, resolved, body.into()).unwrap_or_else(|e| panic!("{page}: {e}"));
}

/// The book has every page once, under its own title or a shorter one, and lists no other.
#[test]
fn the_book_has_every_page() {
    let mut all = Vec::new();
    pages(&root().join("docs"), &mut all);
    let folder = root().join("docs");
    let names = all.iter().map(|page| page.strip_prefix(&folder).expect("a page of the folder"));
    let names: BTreeSet<String> =
        names.map(|p| p.to_string_lossy().into_owned()).filter(|p| p != "SUMMARY.md").collect();
    let summary = text("docs/SUMMARY.md");
    let listed: Vec<&str> = summary.split("](").skip(1).filter_map(|rest| rest.split(')').next()).collect();
    let once: BTreeSet<String> = listed.iter().map(ToString::to_string).collect();
    assert_eq!(once.len(), listed.len(), "a page is listed twice");
    assert_eq!(once, names);
    let book = text("book.toml");
    assert!(book.contains("src = \"docs\""));
    // A link to a `README.md` leads to its page, which the book calls `index.html`
    for page in listed.iter().filter(|page| page.ends_with("README.md")) {
        let redirect = format!("\"/{}\" = \"index.html\"", page.replace(".md", ".html"));
        assert!(book.contains(&redirect), "book.toml does not redirect {page}");
    }
}

/// The book makes `.html` of links that end with `.md`: a page outside of it is named by its folder, which also hosts show.
#[test]
fn the_book_links_to_folders_outside_of_it() {
    let mut all = Vec::new();
    pages(&root().join("docs"), &mut all);
    let mut wrong = Vec::new();
    for page in all {
        let depth = page.strip_prefix(root().join("docs")).expect("a page of the folder").components().count();
        let out = "../".repeat(depth);
        let markdown = text(&page);
        let links = markdown.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next());
        wrong.extend(
            links.filter(|l| l.starts_with(&out) && l.ends_with(".md")).map(|l| format!("{}: {l}", page.display())),
        );
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A schema that parts of a file fulfil: only what tells its tables apart is required.
fn of_parts(schema: &mut Value) {
    match schema {
        Value::Object(keys) => {
            if let Some(Value::Array(required)) = keys.get_mut("required") {
                required.retain(|key| ["kind", "law", "include"].iter().any(|needed| key == needed));
            }
            keys.values_mut().for_each(of_parts);
        }
        Value::Array(list) => list.iter_mut().for_each(of_parts),
        _ => {}
    }
}

/// Every listing in TOML parses, and the parts of scenes and studies have the keys of their schemas.
#[test]
fn listings_in_toml_have_known_keys() {
    let mut scene = schema::scene().to_value();
    let mut study = schema::study().to_value();
    of_parts(&mut scene);
    of_parts(&mut study);
    let kinds = study["oneOf"].take();
    kinds.as_array().into_iter().flatten().for_each(|kind| assert!(kind["properties"].is_object()));
    let mut kinds = kinds.as_array().cloned().unwrap_or_default();
    kinds.iter_mut().for_each(|kind| kind["required"] = serde_json::json!([]));
    let own = |of: &Value| -> BTreeSet<String> {
        of["properties"].as_object().into_iter().flatten().map(|(key, _)| key.clone()).collect()
    };
    let of_studies: BTreeSet<String> = kinds.iter().flat_map(own).collect();
    let of_scenes = own(&scene);
    study.as_object_mut().expect("an object").remove("oneOf");
    study["anyOf"] = kinds.into();
    let valid = [scene, study].map(|schema| jsonschema::validator_for(&schema).expect("a schema"));
    let (mut all, mut checked, mut wrong) = (Vec::new(), [0, 0], Vec::new());
    pages(&root(), &mut all);
    for page in all {
        for block in blocks(&text(&page), "toml") {
            let table: toml::Table = block.parse().unwrap_or_else(|e| panic!("{}: {e}\n{block}", page.display()));
            let content = serde_json::to_value(&table).expect("a table without dates");
            let fits = |keys: &BTreeSet<String>| table.keys().all(|key| keys.contains(key));
            let Some(kind) = [&of_scenes, &of_studies].iter().position(|keys| fits(keys)) else { continue };
            checked[kind] += 1;
            let of =
                |e: jsonschema::ValidationError| format!("{}: {}: {e}\n{block}", page.display(), e.instance_path());
            wrong.extend(valid[kind].iter_errors(&content).map(of));
        }
    }
    assert!(checked[0] > 40 && checked[1] > 6, "{checked:?}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Numbers in words, from zero.
const NUMBERS: &str = "no one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen sixteen seventeen \
    eighteen nineteen twenty";

/// The draft of a paper cites what its bibliography has, and all of it; its numbers are those of the verification and of published verdicts.
#[test]
fn the_paper_quotes_the_evidence() {
    let (paper, bibliography) = (text("docs/paper/paper.md"), text("docs/paper/paper.bib"));
    let cited: BTreeSet<&str> =
        paper.split('@').skip(1).filter_map(|rest| rest.split(|c: char| !c.is_ascii_alphanumeric()).next()).collect();
    let listed: BTreeSet<&str> =
        bibliography.split("\n@").filter_map(|entry| entry.split_once('{')?.1.split(',').next()).collect();
    assert_eq!(cited, listed);
    let flat = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let evidence = flat(
        &[text("docs/verification.md"), text("docs/performance.md"), text("README.md"), text("docs/gallery.md")]
            .concat(),
    );
    let paper = flat(&paper);
    for (said, known) in [
        ("84 problems", "84 problems"),
        (
            "Of 297 scenes that break simulators, 108 match their references, 147 converge and have no reference",
            "Of 297 hard cases, 108 match their references, 147 converge and have no reference",
        ),
        (
            "1119 cells holds the finger's tension within 5 %",
            "tet10 mean dilatation, 1119 cells can be trusted within 5 %",
        ),
        ("off by 260 % with 36 393 cells", "tet4, 36 393 | 24 651 | 7 253 127 | 58.0 | 107 | 18 | 164 | 260 |"),
    ] {
        assert!(paper.contains(said), "the paper no longer says: {said}");
        assert!(evidence.contains(known), "the evidence no longer says: {known}");
    }
    let number = NUMBERS.split(' ').nth(durometer::material::LAWS.len()).expect("a number in words");
    let laws = format!("{number} constitutive laws");
    assert!(paper.contains(&laws), "docs/paper/paper.md: the program has {laws}");
    // Two pages of the journal
    let words = paper.split("# Summary").nth(1).unwrap_or_default().split_whitespace().count();
    assert!((250..=1000).contains(&words), "{words}");
}
