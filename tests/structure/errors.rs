//! Public functions of scenes say when they fail.

use crate::source::{Source, line, rust_files};
use syn::visit::{self, Visit};

/// Collects public functions that return a `Result` without a section `# Errors`.
struct Silent<'a> {
    name: &'a str,
    found: Vec<String>,
}

impl Silent<'_> {
    fn look(&mut self, visibility: &syn::Visibility, attributes: &[syn::Attribute], signature: &syn::Signature) {
        let is_public = matches!(visibility, syn::Visibility::Public(_));
        if is_public && returns_result(signature) && !attributes.iter().any(is_section) {
            self.found.push(format!("{}:{}: {}", self.name, line(signature), signature.ident));
        }
    }
}

fn returns_result(signature: &syn::Signature) -> bool {
    let syn::ReturnType::Type(_, returned) = &signature.output else { return false };
    let syn::Type::Path(path) = &**returned else { return false };
    path.path.segments.last().is_some_and(|segment| segment.ident == "Result")
}

/// Whether a line of a doc comment is the heading `# Errors`.
fn is_section(attribute: &syn::Attribute) -> bool {
    let syn::Meta::NameValue(doc) = &attribute.meta else { return false };
    let syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(text), .. }) = &doc.value else { return false };
    doc.path.is_ident("doc") && text.value().trim() == "# Errors"
}

impl<'ast> Visit<'ast> for Silent<'_> {
    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        self.look(&item.vis, &item.attrs, &item.sig);
        visit::visit_item_fn(self, item);
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        self.look(&item.vis, &item.attrs, &item.sig);
        visit::visit_impl_item_fn(self, item);
    }
}

fn silent(source: &Source) -> Vec<String> {
    let mut reader = Silent { name: &source.name, found: Vec::new() };
    reader.visit_file(&source.tree);
    reader.found
}

#[test]
fn public_functions_of_scenes_say_when_they_fail() {
    let wrong: Vec<String> = rust_files("src/scene").iter().flat_map(silent).collect();
    crate::assert_none(&wrong, "add a section `# Errors` to the doc comment");
}

#[test]
fn functions_that_do_not_say_when_they_fail_are_found() {
    let text = "/// Reads.\n///\n/// # Errors\n///\n/// Never.\npub fn a() -> Result<(), E> { b() }\nfn b() -> Result<(), E> { Ok(()) }\n\
                impl A {\n/// # Errors, not as a heading\npub fn c() -> io::Result<()> { Ok(()) }\npub fn d() -> bool { true }\n}";
    assert_eq!(silent(&Source::new("src/scene/a.rs", text)), ["src/scene/a.rs:10: c"]);
}
