//! Which file uses which: every path of the code, followed through imports and re-exports to the file that defines it.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};

use crate::source::{Package, Source, line};

/// How often an import may lead to another import.
const LONGEST_CHAIN: usize = 30;

/// Where a path leads to.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum Target {
    /// A module, by its index.
    Module(usize),
    /// An item, by the index of the file that defines it and its name there.
    Item { file: usize, name: String },
    /// Another crate, a generic parameter or a local name.
    Outside,
}

/// A path as it is written in the code.
pub struct Written {
    pub segments: Vec<String>,
    pub line: usize,
    kind: Kind,
    /// Index of the module that contains it.
    module: usize,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// Part of an expression, a type or a pattern
    Path,
    /// Call of a macro
    Macro,
    /// `use …`
    Import,
    /// `pub use …`, `pub(crate) use …`
    Reexport,
    /// `use …::*`
    Glob,
}

impl Written {
    pub fn is_macro(&self) -> bool {
        self.kind == Kind::Macro
    }
}

/// One file uses an item of another file.
pub struct Edge {
    pub from: usize,
    pub to: usize,
    pub line: usize,
    /// The path that makes the edge
    pub path: String,
}

struct Module {
    file: usize,
    parent: Option<usize>,
    children: HashMap<String, usize>,
    items: HashSet<String>,
    imports: HashMap<String, Vec<String>>,
}

/// All modules of the library and of the command line, with the paths that are written in them.
pub struct Names<'a> {
    pub sources: &'a [Source],
    modules: Vec<Module>,
    /// Index of the module of each file.
    of_file: Vec<usize>,
    /// Paths of each file.
    pub written: Vec<Vec<Written>>,
    library: usize,
}

impl<'a> Names<'a> {
    pub fn new(sources: &'a [Source]) -> Self {
        let (modules, of_file) = tree(sources);
        let library = (0..sources.len()).find(|&k| sources[k].name == "src/lib.rs").map_or(0, |k| of_file[k]);
        let mut names = Self { sources, modules, of_file, written: Vec::new(), library };
        for (k, source) in sources.iter().enumerate() {
            let module = names.of_file[k];
            let mut reader = Reader { names: &mut names, file: k, module, written: Vec::new() };
            reader.visit_file(&source.tree);
            let written = reader.written;
            names.written.push(written);
        }
        names
    }

    /// Follows a path that is written in a file.
    pub fn target(&self, written: &Written) -> Target {
        self.follow(written.module, &written.segments, 0)
    }

    /// Follows the path of a type that is written in a module.
    fn follow(&self, from: usize, segments: &[String], chain: usize) -> Target {
        if chain > LONGEST_CHAIN {
            return Target::Outside;
        }
        let mut at = from;
        for (k, segment) in segments.iter().enumerate() {
            let module = &self.modules[at];
            let last = k + 1 == segments.len();
            let child = module.children.get(segment);
            match segment.as_str() {
                "crate" => at = self.of_crate(at),
                "self" => {}
                "super" => match module.parent {
                    Some(parent) => at = parent,
                    None => return Target::Outside,
                },
                "durometer" if k == 0 => at = self.library,
                // A module and a function may share a name; a path goes on only through the module.
                _ if !last && child.is_some() => at = child.copied().expect("a child"),
                name if module.items.contains(name) => {
                    return Target::Item { file: module.file, name: name.to_string() };
                }
                name if module.imports.contains_key(name) => {
                    let path = [&module.imports[name], &segments[k + 1..]].concat();
                    let own = path.first() == Some(segment) && path.len() == 1;
                    return if own { Target::Outside } else { self.follow(at, &path, chain + 1) };
                }
                _ => match child {
                    Some(&child) => at = child,
                    None => return Target::Outside,
                },
            }
        }
        Target::Module(at)
    }

    /// Which file uses which other file of the same crate, once for each pair. A re-export alone is no use: a
    /// `mod.rs` may offer the items of its children and define what they need. It counts if its file uses the name.
    pub fn edges(&self) -> Vec<Edge> {
        let mut found = BTreeMap::new();
        for (from, paths) in self.written.iter().enumerate() {
            if self.sources[from].is_test() {
                continue;
            }
            let used: BTreeSet<&str> = paths
                .iter()
                .filter(|w| matches!(w.kind, Kind::Path | Kind::Macro))
                .map(|w| w.segments[0].as_str())
                .collect();
            for written in paths {
                let name = written.segments.last().map_or("", String::as_str);
                if written.kind == Kind::Reexport && !used.contains(name) {
                    continue;
                }
                let to = match self.target(written) {
                    Target::Item { file, .. } => file,
                    Target::Module(module) if written.kind == Kind::Glob => self.modules[module].file,
                    _ => continue,
                };
                if to != from && self.sources[to].package == self.sources[from].package {
                    let edge = || Edge { from, to, line: written.line, path: written.segments.join("::") };
                    found.entry((from, to)).or_insert_with(edge);
                }
            }
        }
        found.into_values().collect()
    }

    /// Module at the top of the crate that a path takes from, without following imports: of `crate::system::Want`
    /// it is `system`, wherever `Want` is defined.
    pub fn taken_from(&self, written: &Written) -> &str {
        let mut at = written.module;
        for (k, segment) in written.segments.iter().enumerate() {
            let module = &self.modules[at];
            at = match segment.as_str() {
                "crate" if k == 0 => self.of_crate(at),
                "self" => at,
                "super" => module.parent.unwrap_or(at),
                name => match module.children.get(name) {
                    Some(&child) => child,
                    None => break,
                },
            };
        }
        self.sources[self.modules[at].file].top()
    }

    /// The root of the crate of a module.
    fn of_crate(&self, mut at: usize) -> usize {
        while let Some(parent) = self.modules[at].parent {
            at = parent;
        }
        at
    }

    /// Types with inherent `impl` blocks, each with the files and lines of these.
    pub fn implementations(&self) -> BTreeMap<(String, String), Vec<(usize, usize)>> {
        let mut found: BTreeMap<_, Vec<_>> = BTreeMap::new();
        for (file, source) in self.sources.iter().enumerate() {
            for item in &source.tree.items {
                let syn::Item::Impl(block) = item else { continue };
                let syn::Type::Path(of) = &*block.self_ty else { continue };
                if block.trait_.is_some() {
                    continue;
                }
                let segments: Vec<String> = of.path.segments.iter().map(|s| s.ident.to_string()).collect();
                if let Target::Item { file: home, name } = self.follow(self.of_file[file], &segments, 0) {
                    found.entry((self.sources[home].name.clone(), name)).or_default().push((file, line(block)));
                }
            }
        }
        found
    }
}

/// Modules by files. Inline modules are added while reading.
fn tree(sources: &[Source]) -> (Vec<Module>, Vec<usize>) {
    let mut modules: Vec<Module> = Vec::new();
    let mut index: HashMap<(Package, Vec<String>), usize> = HashMap::new();
    let mut order: Vec<usize> = (0..sources.len()).collect();
    order.sort_by_key(|&k| sources[k].module.len());
    let mut of_file = vec![0; sources.len()];
    for file in order {
        let source = &sources[file];
        let own = modules.len();
        let parent =
            source.module.split_last().map(|(name, above)| (name, index.get(&(source.package, above.to_vec()))));
        if let Some((name, Some(&parent))) = parent {
            modules[parent].children.insert(name.clone(), own);
        }
        let parent = parent.and_then(|(_, parent)| parent.copied());
        modules.push(Module { file, parent, children: HashMap::new(), items: HashSet::new(), imports: HashMap::new() });
        index.insert((source.package, source.module.clone()), own);
        of_file[file] = own;
    }
    (modules, of_file)
}

/// Reads items, imports and paths of one file.
struct Reader<'n, 'a> {
    names: &'n mut Names<'a>,
    file: usize,
    module: usize,
    written: Vec<Written>,
}

impl Reader<'_, '_> {
    fn add(&mut self, segments: Vec<String>, line: usize, kind: Kind) {
        self.written.push(Written { segments, line, kind, module: self.module });
    }

    fn define(&mut self, name: &syn::Ident) {
        self.names.modules[self.module].items.insert(name.to_string());
    }

    fn import(&mut self, tree: &syn::UseTree, prefix: &[String], kind: Kind) {
        let with = |name: &syn::Ident| [prefix, &[name.to_string()]].concat();
        match tree {
            syn::UseTree::Path(x) => self.import(&x.tree, &with(&x.ident), kind),
            syn::UseTree::Group(x) => x.items.iter().for_each(|tree| self.import(tree, prefix, kind)),
            syn::UseTree::Glob(x) => self.add(prefix.to_vec(), line(x), Kind::Glob),
            syn::UseTree::Name(x) => {
                let path = if x.ident == "self" { prefix.to_vec() } else { with(&x.ident) };
                self.bind(path.last().expect("a segment").clone(), path, line(x), kind);
            }
            syn::UseTree::Rename(x) => {
                let path = if x.ident == "self" { prefix.to_vec() } else { with(&x.ident) };
                self.bind(x.rename.to_string(), path, line(x), kind);
            }
        }
    }

    fn bind(&mut self, name: String, path: Vec<String>, line: usize, kind: Kind) {
        self.names.modules[self.module].imports.insert(name, path.clone());
        self.add(path, line, kind);
    }

    /// Paths among the tokens of a macro: identifiers joined by `::`; before a `!` they call another macro.
    fn tokens(&mut self, tokens: TokenStream) {
        let (mut path, mut colons, mut at) = (Vec::new(), 0, 0);
        for token in tokens {
            let before = std::mem::take(&mut colons);
            let mut kind = Kind::Path;
            match &token {
                TokenTree::Ident(name) => {
                    if before != 2 {
                        self.end(&mut path, at, kind);
                    }
                    at = name.span().start().line;
                    path.push(name.to_string());
                    continue;
                }
                TokenTree::Punct(mark) if mark.as_char() == ':' => {
                    colons = before + 1;
                    continue;
                }
                TokenTree::Punct(mark) if mark.as_char() == '!' => kind = Kind::Macro,
                TokenTree::Group(group) => self.tokens(group.stream()),
                _ => {}
            }
            self.end(&mut path, at, kind);
        }
        self.end(&mut path, at, Kind::Path);
    }

    fn end(&mut self, path: &mut Vec<String>, line: usize, kind: Kind) {
        if !path.is_empty() {
            self.add(std::mem::take(path), line, kind);
        }
    }
}

impl<'ast> Visit<'ast> for Reader<'_, '_> {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        match item {
            syn::Item::Const(x) => self.define(&x.ident),
            syn::Item::Enum(x) => self.define(&x.ident),
            syn::Item::Fn(x) => self.define(&x.sig.ident),
            syn::Item::Static(x) => self.define(&x.ident),
            syn::Item::Struct(x) => self.define(&x.ident),
            syn::Item::Trait(x) => self.define(&x.ident),
            syn::Item::Type(x) => self.define(&x.ident),
            syn::Item::Union(x) => self.define(&x.ident),
            syn::Item::Macro(x) => {
                if let Some(name) = &x.ident {
                    self.define(name);
                }
            }
            _ => {}
        }
        visit::visit_item(self, item);
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if item.content.is_none() {
            return;
        }
        let (outer, own) = (self.module, self.names.modules.len());
        self.names.modules.push(Module {
            file: self.file,
            parent: Some(outer),
            children: HashMap::new(),
            items: HashSet::new(),
            imports: HashMap::new(),
        });
        self.names.modules[outer].children.insert(item.ident.to_string(), own);
        self.module = own;
        visit::visit_item_mod(self, item);
        self.module = outer;
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        if item.leading_colon.is_none() {
            let kind = if matches!(item.vis, syn::Visibility::Inherited) { Kind::Import } else { Kind::Reexport };
            self.import(&item.tree, &[], kind);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        if path.leading_colon.is_none() {
            self.add(path.segments.iter().map(|s| s.ident.to_string()).collect(), line(path), Kind::Path);
        }
        visit::visit_path(self, path);
    }

    /// `pub(crate)` and the like use nothing.
    fn visit_visibility(&mut self, _: &'ast syn::Visibility) {}

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        self.add(call.path.segments.iter().map(|s| s.ident.to_string()).collect(), line(call), Kind::Macro);
        self.tokens(call.tokens.clone());
    }
}
