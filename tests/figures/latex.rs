//! What a paper takes compiles with pdflatex and xelatex as it is, and text is text whatever it holds.

use crate::common::files::files_below;
use crate::common::synthetic;
use crate::common::tools;
use durometer::material::laws;
use durometer::report::latex::{self, PACKAGES, escape};
use durometer::report::page;
use durometer::report::table::Table;
use durometer::study::report;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use std::path::Path;
use std::process::{Command, Stdio};

const ENGINES: [&str; 2] = ["pdflatex", "xelatex"];

/// Whether the test ends here since LaTeX is missing.
fn without_latex() -> bool {
    let found = |tool: &&str| Command::new(tool).arg("--version").stdout(Stdio::null()).status().is_ok();
    let missing = ENGINES.iter().chain(&["bibtex"]).find(|tool| !found(tool));
    tools::is_missing(missing.is_none(), missing.unwrap_or(&"LaTeX"))
}

/// Runs a program of TeX in a folder; its output where it fails.
fn tex(dir: &Path, program: &str, arguments: &[&str]) -> Result<String, String> {
    let out = Command::new(program).args(arguments).current_dir(dir).stdin(Stdio::null()).output();
    let out = out.map_err(|e| e.to_string())?;
    let log = String::from_utf8_lossy(&out.stdout).into_owned();
    if out.status.success() { Ok(log) } else { Err(format!("{program}: {log}")) }
}

fn compile(dir: &Path, engine: &str, name: &str) -> String {
    tex(dir, engine, &["-interaction=nonstopmode", "-halt-on-error", name]).unwrap_or_else(|log| panic!("{log}"))
}

/// The log of what pdflatex would write, without writing it.
fn dry(dir: &Path, name: &str) -> String {
    let arguments = ["-draftmode", "-interaction=nonstopmode", "-halt-on-error", name];
    tex(dir, "pdflatex", &arguments).unwrap_or_else(|log| panic!("{log}"))
}

fn document(body: &str) -> String {
    format!("\\documentclass{{article}}\n{PACKAGES}\\begin{{document}}\n{body}\n\\end{{document}}\n")
}

/// Texts of every kind: specials of LaTeX, HTML and Markdown, letters of formulae, any character at all.
fn text() -> impl Strategy<Value = String> {
    let marks = "[\\\\{}$&#^_~%\"'`<>|*\\[\\]@,.?!-]{0,12}";
    prop_oneof![
        marks,
        "[a-z]{1,3}[\u{300}-\u{36f}]{0,3}[α-ωΑ-Ω]{0,3}[\u{300}-\u{36f}]{0,2}",
        "[\u{80}-\u{24f}\u{2000}-\u{22ff}]{0,12}",
        any::<String>(),
        Just("\\end{document}".to_string()),
        Just("a\n\n\\\\[2mm] b & c \\\\ * [".to_string()),
    ]
}

/// 300 random texts, the same in every run, after each character that has a command of its own or occurs in the source of the program.
fn texts() -> Vec<String> {
    let mut runner = TestRunner::deterministic();
    let mut all: Vec<String> = vec![];
    let sources = files_below(Path::new("src"));
    for entry in sources.iter().filter(|path| path.extension().is_some_and(|x| x == "rs")) {
        let source = std::fs::read_to_string(entry).expect("a source file");
        all.extend(source.chars().filter(|c| !c.is_ascii()).map(String::from));
    }
    all.sort();
    all.dedup();
    all.extend((0..300).map(|_| text().new_tree(&mut runner).expect("a text").current()));
    all
}

proptest! {
    /// A page shows exactly the text: nothing in it is markup, and nothing is lost.
    #[test]
    fn a_page_shows_the_text_itself(s in text()) {
        let shown = page::escape(&s);
        prop_assert!(!shown.contains(['<', '>', '"']));
        let back = shown.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&");
        prop_assert_eq!(back, s);
    }

    /// Nothing in a text of LaTeX opens a group, a comment or a paragraph, and all of it is ASCII.
    #[test]
    fn a_text_of_latex_is_closed(s in text()) {
        let shown = escape(&s);
        prop_assert!(shown.is_ascii() && !shown.contains('\n'));
        let mut depth = 0;
        let mut rest = shown.chars();
        while let Some(c) = rest.next() {
            match c {
                '\\' => _ = rest.next(),
                '{' => depth += 1,
                '}' => depth -= 1,
                c => prop_assert!(!"%&#$".contains(c), "{}", shown),
            }
            prop_assert!(depth >= 0, "{}", shown);
        }
        prop_assert_eq!(depth, 0);
    }
}

#[test]
fn any_text_compiles_in_cells_captions_and_headings() {
    if without_latex() {
        return;
    }
    let dir = tempfile::tempdir().expect("a temporary folder");
    let all = texts();
    let columns = vec![("Text".to_string(), String::new(), false), ("\\x & °".into(), "µm·%".into(), true)];
    let rows = |texts: &[String]| texts.iter().map(|t| vec![t.clone(), t.clone()]).collect();
    let one = |(k, texts): (usize, &[String])| {
        let caption = texts.join(" ");
        let table = Table { name: "t", caption, columns: columns.clone(), rows: rows(texts), pick: None };
        format!("{}\\clearpage % {k}\n", latex::table(&table))
    };
    let formulae: String = all.iter().map(|text| latex::formula(text) + "\n\n").collect();
    let body: String = all.chunks(25).enumerate().map(one).chain([formulae]).collect();
    std::fs::write(dir.path().join("texts.tex"), document(&body)).expect("a file");
    for engine in ENGINES {
        let log = compile(dir.path(), engine, "texts");
        assert!(!log.contains("Missing character"), "{engine} has no glyph: {log}");
    }
}

/// Committed tables as they are written today, from their comma-separated values: by pdflatex alone, which stops at a letter without a command, where xelatex
/// goes on. That letters, wide and long tables have both engines is tested apart.
#[test]
fn tables_of_every_published_study_compile() {
    if without_latex() {
        return;
    }
    let dir = tempfile::tempdir().expect("a temporary folder");
    let mut studies: Vec<_> = std::fs::read_dir("reports/published").expect("results").flatten().collect();
    studies.sort_by_key(std::fs::DirEntry::path);
    let mut body = String::new();
    let mut count = 0;
    for folder in studies.iter().filter_map(|s| std::fs::read_dir(s.path().join("tables")).ok()) {
        for file in folder.flatten().map(|f| f.path()).filter(|f| f.extension().is_some_and(|e| e == "csv")) {
            body += &latex::table(&published(&file));
            body += "\\clearpage\n";
            count += 1;
        }
    }
    assert!(count > 60, "{count} tables");
    std::fs::write(dir.path().join("tables.tex"), document(&body)).expect("a file");
    assert_fits(&dry(dir.path(), "tables"));
}

/// Nothing is wider than the text by more than a point, and no float is taller than the page.
fn assert_fits(log: &str) {
    let too_wide = |line: &&str| {
        let by = line.strip_prefix("Overfull \\hbox (").and_then(|rest| rest.split_once("pt")).map(|(by, _)| by);
        by.is_some_and(|by| by.parse::<f64>().expect("a width") > 1.0)
    };
    let beyond: Vec<&str> = log.lines().filter(|l| too_wide(l) || l.contains("Float too large")).collect();
    assert!(beyond.is_empty(), "{} beyond the text:\n{}", beyond.len(), beyond.join("\n"));
}

/// Tables of many columns, long texts and long headings, short and long, fit into the text.
#[test]
fn a_wide_table_fits_into_the_text() {
    if without_latex() {
        return;
    }
    let heading = |k: usize| match k % 3 {
        0 => (format!("Largest displacement of tip {k} in x"), "mm".to_string(), true),
        1 => (format!("at, tip {k}"), "s".to_string(), true),
        _ => (format!("Reason {k}"), String::new(), false),
    };
    let sentence = "The step was cut 12 times and did not converge, see coarse-implicit_euler-with-a-long-name; ";
    let cell = |row: usize, k: usize| match k {
        0 => format!("family-variant-{row}"),
        // The same in every row
        _ if k.is_multiple_of(7) => "7".to_string(),
        _ if k % 3 == 2 => format!("{row} {}", sentence.repeat(k % 4)),
        _ => format!("-{}.{row}e-12", k * row),
    };
    let table = |columns: usize, rows: usize| {
        let columns: Vec<_> =
            std::iter::once(("Case".to_string(), String::new(), false)).chain((1..columns).map(heading)).collect();
        let rows = (0..rows).map(|row| (0..columns.len()).map(|k| cell(row, k)).collect()).collect();
        latex::table(&Table { name: "wide", caption: "Wide.".into(), columns, rows, pick: None })
    };
    for (columns, rows) in [(4, 3), (9, 30), (30, 5), (30, 60), (30, 1)] {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let source = table(columns, rows);
        if columns == 30 {
            assert!(source.matches("  Case & ").count() > 1, "each part begins with the first column: {source}");
            assert_eq!(
                source.contains("The same in every row: Reason 14 7; Largest displacement of tip 21 in x {[}mm] 7."),
                rows > 1,
                "{source}"
            );
        }
        std::fs::write(dir.path().join("wide.tex"), document(&source)).expect("a file");
        for engine in ENGINES {
            assert_fits(&compile(dir.path(), engine, "wide"));
        }
    }
}

/// A table as its CSV has it, at most as many rows as a page takes three times.
fn published(file: &Path) -> Table {
    let mut reader = csv::ReaderBuilder::new().from_path(file).expect("a table");
    let split = |h: &str| match h.strip_suffix(']').and_then(|h| h.rsplit_once(" [")) {
        Some((name, unit)) => (name.to_string(), unit.to_string()),
        None => (h.to_string(), String::new()),
    };
    let heads: Vec<(String, String)> = reader.headers().expect("a header").iter().map(split).collect();
    let rows = reader.records().take(120).map(|r| r.expect("a row").iter().map(String::from).collect());
    let rows: Vec<Vec<String>> = rows.collect();
    let numbers =
        |k: usize| rows.first().is_some_and(|r| r[k].chars().next().is_some_and(|c| "–-0123456789".contains(c)));
    let columns = heads.into_iter().enumerate().map(|(k, (name, unit))| (name, unit, numbers(k))).collect();
    let caption = format!("The table {} of a published study", file.file_stem().expect("a name").display());
    Table { name: "published", caption, columns, rows, pick: None }
}

#[test]
fn the_generated_parts_make_a_paper_of_two_pages() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let mut study = synthetic::study();
    for (case, integrator) in
        study.1.iter_mut().zip(["static", "implicit_euler", "generalised_alpha"].into_iter().cycle())
    {
        case.record.integrator = integrator.into();
    }
    synthetic::store(dir.path(), &study);
    report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    let paper = dir.path().join("paper");
    let read = |name: &str| std::fs::read_to_string(paper.join(name)).expect("a part");
    let (methods, bib, markdown) = (read("methods.tex"), read("references.bib"), read("methods.md"));
    let (document, question) = (read("paper.tex"), &study.0.question);
    assert!(!question.is_empty() && document.contains(&format!("\\title{{{question}}}")), "{document}");
    assert!(document.contains("\n\\input{../figures/") && document.contains("\n% \\input{../figures/"), "{document}");
    let cited = methods.split("\\cite{").skip(1).filter_map(|s| s.split('}').next()).flat_map(|keys| keys.split(','));
    let cited: std::collections::BTreeSet<&str> = cited.collect();
    assert!(cited.contains("durometer") && cited.contains("celik2008"), "{cited:?}");
    let time = "The solution is quasi-static, a sequence of equilibria along the protocol. The equations of motion are integrated by implicit Euler and \
                generalised-α [@chung1993; @arnold2007].";
    assert!(markdown.contains(time), "{markdown}");
    for key in &cited {
        assert_eq!(bib.matches(&format!("{{{key},")).count(), 1, "{key}");
        assert!(markdown.contains(&format!("@{key}")), "{key}");
    }
    assert_eq!(bib.matches("\n}").count(), cited.len(), "no entry that is not cited");
    if without_latex() {
        return;
    }
    for engine in ENGINES {
        let log = paper_log(&paper, engine);
        assert!(log.contains("(2 pages"), "{engine}: {log}");
    }
}

/// Compiles the document of a folder `paper` with its references; the log of the last run.
fn paper_log(paper: &Path, engine: &str) -> String {
    compile(paper, engine, "paper");
    let log = tex(paper, "bibtex", &["paper"]).unwrap_or_else(|log| panic!("{log}"));
    assert!(!log.contains("Warning"), "{log}");
    compile(paper, engine, "paper");
    let log = compile(paper, engine, "paper");
    assert!(!log.contains("undefined"), "{}: {log}", paper.display());
    log
}

/// BibTeX itself reads every reference without a warning, and sets each of them.
#[test]
fn bibtex_reads_every_reference() {
    if without_latex() {
        return;
    }
    let dir = tempfile::tempdir().expect("a temporary folder");
    let all = include_str!("../../src/report/paper/references.bib");
    let kept: Vec<&str> = all.lines().filter(|l| !l.trim_start().starts_with("shorthand")).collect();
    std::fs::write(dir.path().join("all.bib"), kept.join("\n")).expect("a file");
    let body = "\\nocite{*}\\bibliographystyle{unsrt}\\bibliography{all}";
    std::fs::write(dir.path().join("all.tex"), document(body)).expect("a file");
    for engine in ENGINES {
        compile(dir.path(), engine, "all");
        let log = tex(dir.path(), "bibtex", &["all"]).unwrap_or_else(|log| panic!("{log}"));
        assert!(!log.contains("Warning"), "{log}");
        let set = std::fs::read_to_string(dir.path().join("all.bbl")).expect("a bibliography");
        assert_eq!(set.matches("\\bibitem").count(), all.lines().filter(|l| l.starts_with('@')).count());
        compile(dir.path(), engine, "all");
    }
}

#[test]
fn formulae_of_laws_compile() {
    if without_latex() {
        return;
    }
    let of_fits = laws().into_iter().filter_map(|law| Some(law.fit.as_ref()?.formula));
    let all = laws().into_iter().map(|law| law.info.formula).chain(of_fits);
    let body: String = all.map(|text| format!("{}\n\n", latex::formula(text))).collect();
    let dir = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(dir.path().join("formulae.tex"), document(&body)).expect("a file");
    for engine in ENGINES {
        let log = compile(dir.path(), engine, "formulae");
        assert!(!log.contains("Missing character") && !log.contains("Overfull"), "{engine}: {log}");
    }
}

/// Fits, comparisons of laws, relaxation and measured motion give the same parts as studies.
#[test]
fn papers_of_fits_and_motion_compile() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let root = env!("CARGO_MANIFEST_DIR");
    let [treloar, relaxation, motion] =
        ["data/treloar-1944/treloar-1944.csv", "tests/figures/relaxation.csv", "tests/motion/gravity_a.csv"]
            .map(|file| format!("{root}/{file}"));
    let runs: [(&str, Vec<&str>, &str); 4] = [
        ("fit", vec!["fit", &treloar, "--law", "yeoh", "--mode", "uniaxial", "--range", "1..2"], "@yeoh1993]"),
        (
            "compare",
            vec!["fit", &treloar, "--law", "all", "--mode", "uniaxial", "--range", "1..2"],
            "ranked by what they predict",
        ),
        ("prony", vec!["prony", &relaxation, "--experiment", "relaxation", "--ramp", "0 s"], "Constants: "),
        ("motion", vec!["motion", &motion, "--body", "tip1,tip2,tip3"], "[@umeyama1991]"),
    ];
    for (name, words, said) in runs {
        let out = dir.path().join(name);
        let output = Command::new(env!("CARGO_BIN_EXE_durometer")).args(&words).arg("--out").arg(&out).output();
        let output = output.expect("the program starts");
        assert!(matches!(output.status.code(), Some(0 | 3)), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        let methods = std::fs::read_to_string(out.join("paper/methods.md")).expect("methods");
        assert!(
            methods.contains(said) && methods.contains("**Software.** Durometer [@durometer]"),
            "{name}: {methods}"
        );
        for figure in std::fs::read_dir(out.join("figures")).into_iter().flatten().flatten().map(|f| f.path()) {
            assert!(figure.with_extension("tex").is_file(), "{}", figure.display());
        }
        if !without_latex() {
            ENGINES.iter().for_each(|engine| drop(paper_log(&out.join("paper"), engine)));
        }
    }
}
