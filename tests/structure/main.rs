//! Rules of the source that no compiler checks: which module uses which, what may print, how long a function is,
//! and that no two files use each other.
//!
//! Files are parsed, and paths are followed through imports and re-exports to the file that defines the item.

mod cycles;
mod dependencies;
mod docs;
mod errors;
mod evidence;
#[path = "../common/files.rs"]
mod files;
mod folds;
mod gallery;
mod language;
mod names;
#[path = "../schema/parts.rs"]
mod parts;
mod source;

use std::collections::BTreeSet;

use names::Names;
use source::{Package, Source, line, root, rust_files};
use syn::visit::{self, Visit};

/// A module of the library may use those before it.
const ORDER: [&str; 18] = [
    "wording",
    "storage",
    "subprocess",
    "schema",
    "catalogue",
    "math",
    "mesh",
    "material",
    "system",
    "effect",
    "solve",
    "scene",
    "reduction",
    "calibrate",
    "motion",
    "report",
    "live",
    "study",
];
/// Beyond the order: what a module may use of the library at all.
const ONLY: [(&str, &[&str]); 1] = [("solve", &["math", "system", "solve"])];
/// Modules that offer the items of the others and are used by none of them.
const FACADE: [&str; 2] = ["lib", "prelude"];
/// Lines of a function, from its first word to its closing brace.
const LONGEST_FUNCTION: usize = 80;
/// Files that may hold `impl` blocks of one type.
const MOST_FILES_OF_A_TYPE: usize = 2;

fn assert_none(offenders: &[String], remedy: &str) {
    let count = offenders.len();
    assert!(offenders.is_empty(), "{count} to change: {remedy}\n{}", offenders.join("\n"));
}

#[test]
fn modules_use_only_those_before_them() {
    assert_none(&wrong_uses(&rust_files("src")), "a module uses only those before it in the order of this test");
}

fn wrong_uses(sources: &[Source]) -> Vec<String> {
    let names = Names::new(sources);
    let rank = |module: &str| ORDER.iter().position(|m| *m == module);
    let mut wrong = BTreeSet::new();
    for (source, written) in sources.iter().zip(&names.written) {
        let own = source.top();
        if FACADE.contains(&own) || source.package != Package::Library || source.is_test() {
            continue;
        }
        for path in written {
            let other = names.taken_from(path);
            let allowed = rank(other).is_some_and(|theirs| rank(own).is_some_and(|own| theirs <= own));
            let only = ONLY.iter().find(|(module, _)| *module == own);
            if !allowed || only.is_some_and(|(_, list)| !list.contains(&other)) {
                wrong.insert(format!("{}:{}: {own} must not use {other}", source.name, path.line));
            }
        }
    }
    wrong.into_iter().collect()
}

#[test]
fn every_module_has_its_place_in_the_order() {
    let lib = std::fs::read_to_string(root().join("src/lib.rs")).expect("the root of the library");
    for name in lib.lines().filter_map(|l| l.strip_prefix("pub mod ")) {
        let module = name.trim_end_matches(';');
        let known = ORDER.contains(&module) || FACADE.contains(&module);
        assert!(known, "module {module} is not in the order of tests/structure/main.rs");
    }
    let printed = lib.lines().find(|l| l.contains(" → ")).expect("the order in the text of the library");
    let expected = [&ORDER[..], &["prelude"]].concat().join(" → ");
    assert_eq!(printed.trim_start_matches("//! "), expected, "the order in src/lib.rs");
    let contributing = std::fs::read_to_string(root().join("CONTRIBUTING.md")).expect("the rules for contributors");
    let drawn = contributing.split("```text").nth(1).and_then(|t| t.split("```").next()).expect("the drawing");
    let words: Vec<&str> = drawn.split(|c: char| !c.is_ascii_lowercase()).collect();
    for module in ORDER {
        assert!(words.contains(&module), "module {module} is not in the drawing of CONTRIBUTING.md");
    }
}

/// A program of tests that was compiled in one worktree and runs in another checks the files of the second.
#[test]
fn these_tests_read_the_files_of_the_worktree_that_they_run_in() {
    let of_compilation = ["CARGO", "MANIFEST", "DIR"].join("_");
    let others = rust_files("tests/structure").into_iter().filter(|source| source.name != "tests/structure/source.rs");
    let wrong: Vec<String> = others.filter(|s| s.text.contains(&of_compilation)).map(|s| s.name).collect();
    assert_none(&wrong, "take `root()` of tests/structure/source.rs");
}

/// Two files that use each other are one subject in two files, or share a third one. A parent may use its children;
/// a child that uses an item defined in its parent's `mod.rs` while the parent uses the child closes a cycle.
/// A re-export alone is no use (see [`Names::edges`]).
#[test]
fn no_files_use_each_other() {
    let sources = rust_files("src");
    let remedy = "break each cycle: move what both files need into a file of its own, or merge what is one subject";
    assert_none(&cycles_among(&sources), remedy);
}

fn cycles_among(sources: &[Source]) -> Vec<String> {
    let edges = Names::new(sources).edges();
    let describe = |group: Vec<usize>| {
        let inside = edges.iter().filter(|e| group.contains(&e.from) && group.contains(&e.to));
        let line =
            |e: &names::Edge| format!("    {}:{}: {} in {}", sources[e.from].name, e.line, e.path, sources[e.to].name);
        let lines: Vec<String> = inside.map(line).collect();
        format!("  {} files:\n{}", group.len(), lines.join("\n"))
    };
    cycles::cycles(sources.len(), &edges).into_iter().map(describe).collect()
}

#[test]
fn a_type_is_implemented_in_at_most_two_files() {
    let sources = rust_files("src");
    let names = Names::new(&sources);
    let mut wrong = Vec::new();
    for ((home, name), blocks) in names.implementations() {
        let files: BTreeSet<&str> = blocks.iter().map(|(file, _)| sources[*file].name.as_str()).collect();
        if files.len() > MOST_FILES_OF_A_TYPE {
            let places: Vec<String> =
                blocks.iter().map(|(f, line)| format!("    {}:{line}", sources[*f].name)).collect();
            wrong.push(format!("{home}: {name} in {} files\n{}", files.len(), places.join("\n")));
        }
    }
    assert_none(&wrong, "give each part a type or functions of its own, or merge the files");
}

#[test]
fn functions_are_short() {
    let folders = ["src", "tests", "examples", "benches", "python"];
    let mut wrong = Vec::new();
    for source in folders.iter().flat_map(|folder| rust_files(folder)) {
        let mut reader = Functions { name: &source.name, long: Vec::new() };
        reader.visit_file(&source.tree);
        wrong.extend(reader.long);
    }
    assert_none(&wrong, &format!("a function has at most {LONGEST_FUNCTION} lines; give its steps names"));
}

/// Collects functions that are too long.
struct Functions<'a> {
    name: &'a str,
    long: Vec<String>,
}

impl Functions<'_> {
    fn measure(&mut self, signature: &syn::Signature, body: &syn::Block) {
        let (start, end) = (line(signature), body.brace_token.span.close().end().line);
        let lines = end + 1 - start;
        if lines > LONGEST_FUNCTION {
            self.long.push(format!("{}:{start}: {} has {lines} lines", self.name, signature.ident));
        }
    }
}

impl<'ast> Visit<'ast> for Functions<'_> {
    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        self.measure(&item.sig, &item.block);
        visit::visit_item_fn(self, item);
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        self.measure(&item.sig, &item.block);
        visit::visit_impl_item_fn(self, item);
    }

    fn visit_trait_item_fn(&mut self, item: &'ast syn::TraitItemFn) {
        if let Some(body) = &item.default {
            self.measure(&item.sig, body);
        }
        visit::visit_trait_item_fn(self, item);
    }
}

/// Files of one kind each, and the files that may name them: their registry, and the root of their module. So a new
/// kind is its own file or folder and one line.
struct Registry {
    /// Kind of a file, by its name and text; none for other files.
    kind: fn(&Source) -> Option<&str>,
    named_by: &'static [&'static str],
}

const REGISTRIES: [Registry; 6] = [
    // A law declares itself.
    Registry {
        kind: |source| {
            let law = source.name.starts_with("src/material/") && source.text.contains("const ENTRY: LawEntry");
            law.then_some(source.name.as_str())
        },
        named_by: &["src/material/registry.rs", "src/material/mod.rs"],
    },
    // A kind of study is a folder.
    Registry {
        kind: |source| source.name.strip_prefix("src/study/kinds/")?.split_once('/').map(|(folder, _)| folder),
        named_by: &["src/study/kinds/mod.rs"],
    },
    Registry { kind: |source| kind_of_part(source, "effects"), named_by: &["src/scene/parts/effects/mod.rs"] },
    Registry { kind: |source| kind_of_part(source, "probes"), named_by: &["src/scene/parts/probes/mod.rs"] },
    Registry { kind: |source| kind_of_part(source, "selectors"), named_by: &["src/scene/parts/selectors/mod.rs"] },
    Registry {
        kind: |source| kind_of_part(source, "constraints"),
        named_by: &[
            "src/scene/parts/constraints/mod.rs",
            // Cables and cavities are lists of a scene, and a run follows its cables.
            "src/scene/build/mod.rs",
            "src/scene/run/checkpoint.rs",
            "src/scene/control/prepare.rs",
            "src/scene/run/mod.rs",
            "src/study/store/record.rs",
        ],
    },
];

/// A part of a scene is a file or folder next to its registry; the files listed here serve several kinds.
fn kind_of_part<'a>(source: &'a Source, folder: &str) -> Option<&'a str> {
    let below = source.name.strip_prefix("src/scene/parts/")?.strip_prefix(folder)?.strip_prefix('/')?;
    let name = below.split('/').next()?.trim_end_matches(".rs");
    (!["mod", "part", "mean", "drive", "place"].contains(&name)).then_some(name)
}

/// Kinds may use each other; nothing else names one of them.
#[test]
fn a_kind_is_named_by_its_registry_alone() {
    let sources = rust_files("src");
    let names = Names::new(&sources);
    let mut wrong = Vec::new();
    for registry in &REGISTRIES {
        let kinds: BTreeSet<&str> = sources.iter().filter_map(|source| (registry.kind)(source)).collect();
        assert!(kinds.len() > 3, "the kinds have moved: {kinds:?}");
        for edge in names.edges() {
            let (from, to) = (&sources[edge.from], &sources[edge.to]);
            let general = (registry.kind)(from).is_none() && !registry.named_by.contains(&from.name.as_str());
            if general && (registry.kind)(to).is_some() {
                wrong.push(format!("{}:{}: {} in {}", from.name, edge.line, edge.path, to.name));
            }
        }
    }
    assert_none(&wrong, "let the kind offer it through its registry, or move what is general out of the kind");
}

#[test]
fn the_library_neither_prints_nor_exits() {
    assert_none(&loud(&rust_files("src")), "return an error or a result; only the command line prints and exits");
}

#[test]
fn the_command_line_prints_by_say_and_tell() {
    let remedy = "write say!(…) or tell!(…): println! and eprintln! panic where the output cannot be written";
    assert_none(&panicking(&rust_files("src")), remedy);
}

fn loud(sources: &[Source]) -> Vec<String> {
    let macros = ["println", "eprintln", "print", "eprint", "dbg", "todo", "unimplemented"];
    calls(sources, &macros, true, |package| package == Package::Library)
}

fn panicking(sources: &[Source]) -> Vec<String> {
    calls(sources, &["println", "print", "eprintln", "eprint", "dbg"], false, |package| package != Package::Library)
}

/// Calls of these macros in some packages, and of `exit` where it counts too.
fn calls(sources: &[Source], macros: &[&str], with_exit: bool, of: fn(Package) -> bool) -> Vec<String> {
    let names = Names::new(sources);
    let mut wrong = Vec::new();
    for (source, written) in sources.iter().zip(&names.written).filter(|(s, _)| of(s.package) && !s.is_test()) {
        for path in written {
            let exits = with_exit && path.segments.ends_with(&["process".into(), "exit".into()]);
            let loud = path.is_macro() && path.segments.last().is_some_and(|name| macros.contains(&name.as_str()));
            if exits || loud {
                wrong.push(format!("{}:{}: {}", source.name, path.line, path.segments.join("::")));
            }
        }
    }
    wrong
}

#[test]
fn files_begin_with_their_subject() {
    let missing = |source: &Source| !source.text.starts_with("//!") && !source.is_test();
    let wrong: Vec<String> = ["src", "python"]
        .iter()
        .flat_map(|folder| rust_files(folder))
        .filter(missing)
        .map(|s| format!("{}:1", s.name))
        .collect();
    assert_none(&wrong, "the first line of a file is a `//!` comment with its subject");
}

/// Python gives objects less alignment than some values need; the compiler compares them for the classes in the list of `python/src/lib.rs`.
#[test]
fn the_alignment_of_every_class_of_python_is_checked() {
    let sources = rust_files("python/src");
    let list = &sources.iter().find(|s| s.name == "python/src/lib.rs").expect("the module").text;
    let class = regex::Regex::new(r"#\[pyclass[^\]]*\]\s*pub struct (\w+)").expect("a pattern");
    let classes: Vec<(&str, String)> = sources
        .iter()
        .flat_map(|s| class.captures_iter(&s.text).map(|c| (s.name.as_str(), c[1].to_string())))
        .collect();
    assert!(classes.len() >= 10, "the classes have moved: {classes:?}");
    let wrong: Vec<String> = classes
        .iter()
        .filter(|(_, name)| !list.contains(&format!("::{name}>();")))
        .map(|(file, name)| format!("{file}: {name}"))
        .collect();
    assert_none(&wrong, "add is_aligned::<…>() to the list of python/src/lib.rs");
}

mod on_made_up_files {
    use super::*;

    fn sources(files: &[(&str, &str)]) -> Vec<Source> {
        files.iter().map(|(name, text)| Source::new(name, text)).collect()
    }

    #[test]
    fn wrong_uses_are_found_in_groups_macros_and_relative_paths() {
        let found = wrong_uses(&sources(&[
            ("src/lib.rs", "pub mod math; pub mod mesh; pub mod solve;"),
            (
                "src/math/mod.rs",
                "pub struct Vec3;\nuse crate::{mesh::TetMesh, solve};\npub(crate) fn f() { solve::f() }",
            ),
            ("src/mesh.rs", "pub struct TetMesh;\nfn f() { assert!(super::solve::f()); }\nuse crate::math::Vec3;"),
            ("src/solve.rs", "/// [`crate::report`]\npub fn f() -> bool { true }\nuse crate::mesh::TetMesh;"),
        ]));
        let expected = [
            "src/math/mod.rs:2: math must not use mesh",
            "src/math/mod.rs:2: math must not use solve",
            "src/mesh.rs:2: mesh must not use solve",
            "src/solve.rs:3: solve must not use mesh",
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn printing_is_found_inside_macros_and_a_method_of_that_name_is_not() {
        let text = "fn f() { x.print(); vec![dbg!(1)]; std::process::exit(1) }\nfn print() { print(); println!() }";
        let found = loud(&sources(&[("src/lib.rs", text)]));
        assert_eq!(found, ["src/lib.rs:1: dbg", "src/lib.rs:1: std::process::exit", "src/lib.rs:2: println"]);
        let found = panicking(&sources(&[("src/main.rs", text)]));
        assert_eq!(found, ["src/main.rs:1: dbg", "src/main.rs:2: println"]);
    }

    #[test]
    fn a_re_export_is_followed_and_is_no_use() {
        let files = [
            ("src/lib.rs", "mod a;"),
            ("src/a/mod.rs", "mod b; mod c;\npub use b::B;\npub use c::C;\npub trait Law {}"),
            ("src/a/b.rs", "use super::{C, Law};\npub struct B;\nimpl Law for B {}"),
            ("src/a/c.rs", "pub struct C;"),
        ];
        assert!(cycles_among(&sources(&files)).is_empty());
        let mut closed = files;
        closed[3].1 = "pub struct C;\nfn f() -> super::B { super::B }";
        let found = cycles_among(&sources(&closed));
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].contains("src/a/b.rs:1: super::C in src/a/c.rs"), "{found:?}");
        assert!(found[0].contains("src/a/c.rs:2: super::B in src/a/b.rs"), "{found:?}");
    }

    #[test]
    fn a_parent_and_a_child_that_use_each_other_are_a_cycle() {
        let files = [
            ("src/lib.rs", "mod a;"),
            ("src/a/mod.rs", "mod b;\npub trait Law {}\nfn f() { b::g() }"),
            ("src/a/b.rs", "use super::Law;\npub fn g() {}\nstruct B;\nimpl Law for B {}"),
        ];
        assert_eq!(cycles_among(&sources(&files)).len(), 1);
        let mut open = files;
        open[2].1 = "pub fn g() {}\n#[cfg(test)]\nmod tests { use super::super::Law; }";
        assert!(cycles_among(&sources(&open)).is_empty());
    }

    #[test]
    fn long_functions_are_found_in_blocks() {
        let body = "    let x = 1;\n".repeat(LONGEST_FUNCTION);
        let source =
            Source::new("src/a.rs", &format!("struct A;\nimpl A {{\nfn short() {{}}\nfn long() {{\n{body}}}\n}}"));
        let mut reader = Functions { name: "src/a.rs", long: Vec::new() };
        reader.visit_file(&source.tree);
        assert_eq!(reader.long, [format!("src/a.rs:4: long has {} lines", LONGEST_FUNCTION + 2)]);
    }
}
