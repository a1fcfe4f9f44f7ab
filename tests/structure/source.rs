//! The source files of the library and of the command line, parsed.

use std::path::{Path, PathBuf};

use syn::spanned::Spanned;

use crate::files::kept_below;

/// The packages below `src` whose files use each other.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Package {
    Library,
    /// `src/cli`
    Commands,
    /// `src/main.rs`
    Program,
}

/// One source file.
pub struct Source {
    /// Path below the root of the repository: `src/scene/build/mod.rs`.
    pub name: String,
    pub package: Package,
    /// Path of its module inside the package: `["scene", "build"]`; empty for the root.
    pub module: Vec<String>,
    pub text: String,
    /// Its syntax tree without items under `#[cfg(test)]`.
    pub tree: syn::File,
}

impl Source {
    /// Parses a file; `name` is its path below the root of the repository.
    pub fn new(name: &str, text: &str) -> Self {
        let path = name.strip_prefix("src/").unwrap_or(name);
        let path = path.trim_end_matches(".rs").trim_end_matches("/mod");
        let (package, path) = match path.strip_prefix("cli/") {
            Some(path) => (Package::Commands, path),
            None if path == "main" => (Package::Program, path),
            None => (Package::Library, path),
        };
        let mut module: Vec<String> = path.split('/').map(String::from).collect();
        if ["lib", "main", "mod"].contains(&path) {
            module.clear();
        }
        let mut tree = syn::parse_file(text).unwrap_or_else(|error| panic!("{name}: {error}"));
        drop_tests(&mut tree.items);
        Self { name: name.to_string(), package, module, text: text.to_string(), tree }
    }

    /// First module of the path, `lib` for the root of a package.
    pub fn top(&self) -> &str {
        self.module.first().map_or("lib", String::as_str)
    }

    /// Whether the whole file is a test, declared as `#[cfg(test)] mod tests;`.
    pub fn is_test(&self) -> bool {
        self.name.ends_with("/tests.rs")
    }
}

/// The root of the repository: of the process if Cargo started it, otherwise the one of compilation.
pub fn root() -> PathBuf {
    std::env::var_os("CARGO_MANIFEST_DIR").map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")), PathBuf::from)
}

/// All files with the ending `.rs` below a folder of the repository, in order of their names.
pub fn rust_files(folder: &str) -> Vec<Source> {
    let root = root();
    // Build scripts and packages that use nothing of the library are apart
    let is_package = |path: &Path| path.join("Cargo.toml").exists() && !path.ends_with("src/cli");
    let files = kept_below(&root.join(folder), &|path| !is_package(path) && !path.ends_with("src/build.rs"));
    let read = |path: &PathBuf| {
        let name = path.strip_prefix(&root).expect("a path below the root").to_string_lossy().into_owned();
        Source::new(&name, &std::fs::read_to_string(path).expect("a readable source file"))
    };
    files.iter().filter(|path| path.extension().is_some_and(|x| x == "rs")).map(read).collect()
}

fn drop_tests(items: &mut Vec<syn::Item>) {
    items.retain(|item| !is_for_tests(item));
    for item in items {
        if let syn::Item::Mod(syn::ItemMod { content: Some((_, inner)), .. }) = item {
            drop_tests(inner);
        }
    }
}

fn is_for_tests(item: &syn::Item) -> bool {
    let attributes = match item {
        syn::Item::Mod(x) => &x.attrs,
        syn::Item::Fn(x) => &x.attrs,
        syn::Item::Impl(x) => &x.attrs,
        syn::Item::Use(x) => &x.attrs,
        syn::Item::Struct(x) => &x.attrs,
        syn::Item::Enum(x) => &x.attrs,
        syn::Item::Const(x) => &x.attrs,
        _ => return false,
    };
    attributes.iter().any(|a| {
        a.path().is_ident("cfg") && a.parse_args::<syn::Path>().is_ok_and(|condition| condition.is_ident("test"))
    })
}

/// Line of a piece of syntax, from one.
pub fn line(part: &impl Spanned) -> usize {
    part.span().start().line
}
