//! Language of the sources, of the documentation and of the messages: terms that this project does not use, each with
//! the field's word, and the form of doc comments.

use std::path::PathBuf;
use std::sync::LazyLock;

use regex::{Regex, RegexBuilder};

use crate::files::files_below;
use crate::source::root;

/// A phrase that is not used, as a regular expression without regard to case, and what is written instead. Where the
/// third expression matches too, the phrase is meant as everyone uses it.
const BANNED: &[(&str, &str, &str)] = &[
    // home-made terms
    (r"\b(over)?price[sd]?\b", "cost", ""),
    (r"\bdear(er|est)?\b", "expensive, more expensive", ""),
    (r"\boverkill\b", "reference run", ""),
    (r"\bwreck(s|ed|age)?\b", "failed case", ""),
    (r"\bledgers?\b", "energy balance", ""),
    (r"\bworkshops?\b", "mesh store", ""),
    (r"\bsteer(s|ed|ing)?\b", "run options, control", ""),
    (r"\brungs?\b", "member, increment", ""),
    (r"\bladders?\b", "cumulative sequence", ""),
    (r"\bremark(s|ed|ing)?\b", "note (information), warning (limits how numbers may be used)", ""),
    (r"\bmeetings?\b", "transient coupling, contact", ""),
    (r"\bmeets (another|itself|others|an obstacle|a surface)\b", "is in contact with", ""),
    (r"\bwhat (meets|they meet|it meets)\b", "what is in contact with it", ""),
    (r"\btouch(es|ed|ing)\b", "in contact, contact points", ""),
    (r"\b(the|a|this|each|every|one) touch\b", "a contact point", ""),
    (r"\bstale(ness)?\b", "lagged (factor), outdated (result)", ""),
    (r"\bkept factors?\b|\bkeep from\b|\bfactors? (is|was|are|were) kept\b", "lagged factor, reuse_threshold", ""),
    (r"\bcourse (of|at|from|file)\b", "checkpoint, history", ""),
    (r"\b(a|an|its|each|every|one|of the|in the|effect) contracts?\b", "trait, interface", ""),
    (r"\b(nodal|all|its|their|of|these|no) turns\b|\bstruct turns\b", "rotations", r"turns (out|into|about)"),
    (r"\bslopes? (of|by) (the |a |each |every |any )?(probe|parameter|constant|run|simulation)s?\b", "derivative", ""),
    (r"--slope\b|\bslopes? (option|key)\b", "--sensitivity", ""),
    (r"\bcreep (speed|velocity)\b|\bfriction's creep\b", "stick velocity", ""),
    (r"\b(this|the) house\b|\bhouse rules?\b", "architecture", ""),
    (r"\bwaist\b", "core interface", ""),
    // idiom
    (r"\bbeside\b", "next to, in addition to, alongside, apart from", ""),
    (r"\bstands\b", "is, is given, lies", ""),
    (r"\bstood\b", "was, was given", ""),
    (r"\bstand (in|for|at|on|there|here|last|first|next|open|apart|alone)\b", "be, be given, represent", ""),
    (r"\bto the bit\b", "bit for bit", ""),
    (r"\bof (its|their) own accord\b", "by itself, automatically", ""),
    (r"\bon (the|its|their) way\b", "during the run, in between", ""),
    (r"\b(by )?one way or the other\b", "directly or iteratively", ""),
    (r"\b(iterative|direct) ways?\b", "iterative method, direct method", ""),
    (r"\b(go|goes|gone|went) (the|one|both|its|all the) ([a-z]+ )?ways?\b", "use a method, move in a direction", ""),
    (r"\bthe ways? (of|gone|travelled)\b", "path, displacement, method", ""),
    (r"\bwhich way\b", "how, which method, which direction", ""),
    (r"\bno ways? of\b", "no method for, cannot", ""),
    (r"\bat hand\b", "available, given", ""),
];

/// Folders and files that are read, below the root of the repository.
const READ: &[&str] = &[
    "src",
    "tests",
    "examples",
    "benches",
    "docs",
    "studies",
    "data",
    "meshes",
    "python",
    "README.md",
    "CONTRIBUTING.md",
    "Cargo.toml",
];
/// The glossary names the terms it replaces, this file lists them, and the gallery quotes the verdicts of published results.
const EXEMPT: &[&str] = &["docs/glossary.md", "tests/structure/language.rs", "docs/gallery.md"];
const ENDINGS: &[&str] = &["rs", "md", "toml", "py"];

/// Names below the root and texts of all files below `folders` with one of the endings.
fn texts(folders: &[&str], endings: &[&str]) -> Vec<(String, String)> {
    let root = root();
    let is_text = |path: &PathBuf| path.extension().is_some_and(|x| endings.iter().any(|ending| x == *ending));
    let mut files: Vec<PathBuf> =
        folders.iter().flat_map(|folder| files_below(&root.join(folder))).filter(is_text).collect();
    files.sort();
    let read = |path: PathBuf| {
        let name = path.strip_prefix(&root).expect("a path below the root").to_string_lossy().into_owned();
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        (!EXEMPT.contains(&name.as_str())).then_some((name, text))
    };
    files.into_iter().filter_map(read).collect()
}

/// The running text of a file: without the signs at the start of lines, so that a phrase may go over the end of one,
/// and with names in words, `price_of` and `PriceList` as `price of` and `Price List`.
struct Running {
    text: String,
    /// Where each line starts in the text.
    starts: Vec<usize>,
}

impl Running {
    fn new(file: &str) -> Self {
        let (mut text, mut starts) = (String::new(), Vec::new());
        for line in file.lines() {
            starts.push(text.len());
            let line = line.trim_start().trim_start_matches("//!").trim_start_matches('/');
            let line = line.trim_start_matches(['#', '>', '*']).trim();
            let mut before = ' ';
            for c in line.chars() {
                if before.is_lowercase() && c.is_uppercase() {
                    text.push(' ');
                }
                text.push(if c == '_' { ' ' } else { c });
                before = c;
            }
            // A line of a text in quotes may end with a backslash.
            if text.ends_with('\\') {
                text.pop();
            }
            text.push(' ');
        }
        Self { text, starts }
    }

    fn line(&self, at: usize) -> usize {
        self.starts.partition_point(|start| *start <= at)
    }
}

/// A banned phrase, ready to search.
struct Ban {
    phrase: Regex,
    instead: &'static str,
    unless: Option<Regex>,
}

static BANS: LazyLock<Vec<Ban>> = LazyLock::new(|| {
    let expression = |text: &str| RegexBuilder::new(text).case_insensitive(true).build().expect("a valid expression");
    let ban = |(phrase, instead, unless): &(&str, &'static str, &str)| Ban {
        phrase: expression(phrase),
        instead,
        unless: (!unless.is_empty()).then(|| expression(unless)),
    };
    BANNED.iter().map(ban).collect()
});

/// Places of a phrase in the text, with the words found.
fn places(running: &Running, ban: &Ban) -> Vec<(usize, String)> {
    let fine: Vec<_> =
        ban.unless.iter().flat_map(|unless| unless.find_iter(&running.text)).map(|m| m.range()).collect();
    ban.phrase
        .find_iter(&running.text)
        .filter(|found| !fine.iter().any(|range| range.start < found.end() && found.start() < range.end))
        .map(|found| (running.line(found.start()), found.as_str().to_string()))
        .collect()
}

fn banned(file: &str) -> Vec<(usize, String)> {
    let running = Running::new(file);
    let mut found = Vec::new();
    for ban in BANS.iter() {
        for (line, words) in places(&running, ban) {
            found.push((line, format!("\"{words}\": write {}", ban.instead)));
        }
    }
    found.sort();
    found
}

#[test]
fn only_terms_of_the_field_are_used() {
    let offenders: Vec<String> = texts(READ, ENDINGS)
        .iter()
        .flat_map(|(name, text)| banned(text).into_iter().map(move |(line, fault)| format!("{name}:{line}: {fault}")))
        .collect();
    assert!(offenders.is_empty(), "{} phrases to replace:\n{}", offenders.len(), offenders.join("\n"));
}

/// Faults of the doc comments of a source file: a comment of `///` or `//!` that ends as a question or begins with
/// "What", and a comment of `//` that begins with it.
fn faults_of_comments(file: &str) -> Vec<(usize, String)> {
    let mut faults = Vec::new();
    // kind and last line of the comment that is being read
    let mut open: Option<(&str, usize, &str)> = None;
    for (k, line) in file.lines().enumerate().chain([(usize::MAX, "")]) {
        let line = line.trim();
        let kind = ["///", "//!", "//"].into_iter().find(|kind| line.starts_with(kind));
        let goes_on = kind.is_some() && kind == open.map(|(kind, ..)| kind);
        if let Some((_, at, last)) = open.filter(|(kind, ..)| !goes_on && *kind != "//")
            && last.ends_with('?')
        {
            faults.push((at, "a comment that asks: say what the item is, such as \"Whether …\"".to_string()));
        }
        open = kind.map(|kind| (kind, k + 1, line));
        if let Some(kind) = kind.filter(|_| !goes_on)
            && line[kind.len()..].trim_start().starts_with("What ")
        {
            faults.push((k + 1, "a comment that begins with \"What\": name the thing".to_string()));
        }
    }
    faults
}

/// Lines of doc comments of public items that begin with a preposition, such as "Of a pattern": they do not name the item. A type with a schema is read
/// where a value of it is described, and may do so.
fn bare_prepositions(file: &str) -> Vec<(usize, String)> {
    static BARE: LazyLock<Regex> = LazyLock::new(|| {
        let words =
            "About|After|Against|As|At|Before|Between|By|For|From|In|Into|Of|On|Over|To|Under|With|Within|Without";
        Regex::new(&format!(r"^///\s*({words})\s")).expect("a valid expression")
    });
    static ITEM: LazyLock<Regex> = LazyLock::new(|| {
        Regex::new(r"^pub(\([^)]*\))? (const |unsafe )*(fn|struct|enum|trait|const|static|type|mod)\b")
            .expect("a valid expression")
    });
    let (mut faults, mut open, mut has_schema) = (Vec::new(), None::<(usize, &str)>, false);
    for (k, line) in file.lines().map(str::trim).enumerate() {
        if line.starts_with("///") {
            open = open.or(Some((k + 1, line)));
        } else if line.starts_with("#[") {
            has_schema |= line.contains("JsonSchema");
        } else {
            let of_item = open.take().filter(|(_, first)| !has_schema && ITEM.is_match(line) && BARE.is_match(first));
            faults
                .extend(of_item.map(|(at, _)| (at, "a comment that begins with a preposition: name the thing".into())));
            has_schema = false;
        }
    }
    faults
}

#[test]
fn doc_comments_are_sentences_that_name_the_thing() {
    let offenders: Vec<String> = texts(&["src", "examples", "benches", "python"], &["rs"])
        .iter()
        .flat_map(|(name, text)| {
            let faults = faults_of_comments(text).into_iter().chain(bare_prepositions(text));
            faults.map(move |(line, fault)| format!("{name}:{line}: {fault}"))
        })
        .collect();
    assert!(offenders.is_empty(), "{} comments to rewrite:\n{}", offenders.len(), offenders.join("\n"));
}

#[test]
fn phrases_are_found_in_names_and_over_the_end_of_a_line() {
    let text = "/// A factor of its\n/// own accord.\nlet case_prices = PriceList;\nlet turns = 1; // all turns out\n";
    let found: Vec<usize> = banned(text).into_iter().map(|(line, _)| line).collect();
    assert_eq!(found, [1, 3, 3]);
}

#[test]
fn prepositions_are_found_in_comments_of_public_items() {
    let text = "/// Of a mesh,\n/// by cells.\n#[must_use]\npub fn f() {}\n/// With cells\nfn g() {}\n/// The cells\npub struct H;\n\
                /// By cells\n#[derive(JsonSchema)]\npub struct I;\n";
    let lines: Vec<usize> = bare_prepositions(text).into_iter().map(|(line, _)| line).collect();
    assert_eq!(lines, [1]);
}

#[test]
fn questions_and_what_are_found_in_comments() {
    let text = "//! What a file holds.\n\n/// Is it\n/// so?\nfn f() {\n    // Why not?\n    /// Whether it is\n    /// what it is.\n";
    let lines: Vec<usize> = faults_of_comments(text).into_iter().map(|(line, _)| line).collect();
    assert_eq!(lines, [1, 4]);
}
