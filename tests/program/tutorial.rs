//! The tutorial is gone through literally: its listings are written and its commands are run, in an empty folder with the program alone, and the
//! program prints what the page shows.
#![cfg(unix)]

use std::path::{Path, PathBuf};
use std::process::Command;

const PAGE: &str = "docs/tutorial/README.md";

/// A reader at work.
struct Reader {
    keep: tempfile::TempDir,
    /// Where the reader is
    folder: PathBuf,
    /// What the last commands printed
    printed: String,
    /// What a comment in the page says to do with the next listing
    order: Option<String>,
}

impl Reader {
    fn new() -> Self {
        let keep = tempfile::tempdir().expect("a temporary folder");
        let folder = keep.path().join("work");
        for name in ["bin", "work"] {
            std::fs::create_dir(keep.path().join(name)).expect("writable");
        }
        let program = Path::new(env!("CARGO_BIN_EXE_durometer"));
        let copy = keep.path().join("bin/durometer");
        std::fs::hard_link(program, &copy).or_else(|_| std::fs::copy(program, &copy).map(|_| ())).expect("a copy");
        Self { keep, folder, printed: String::new(), order: None }
    }

    /// Runs a line of shell, which ends with this code. What installs the program is done already.
    fn run(&mut self, line: &str, code: i32) {
        if line.starts_with("cargo ") {
            return;
        }
        let here = self.keep.path().join("here");
        let mut shell = Command::new("sh");
        shell.arg("-c").arg(format!("{line}; code=$?; pwd > '{}'; exit $code", here.display()));
        shell.current_dir(&self.folder).env("DUROMETER_CACHE", self.keep.path().join("cache"));
        for name in ["CARGO_MANIFEST_DIR", "DUROMETER_HOME"] {
            shell.env_remove(name);
        }
        let path = std::env::var("PATH").unwrap_or_default();
        shell.env("PATH", format!("{}:{path}", self.keep.path().join("bin").display()));
        let output = shell.output().expect("a shell");
        let said = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
        assert_eq!(output.status.code(), Some(code), "{line}: {said}");
        self.printed.push_str(&said);
        self.folder = std::fs::read_to_string(here).expect("the shell wrote it").trim().into();
    }

    /// Does what a comment says: `file: NAME` and `append: NAME` take the next listing, `remove: NAME from LINE` and `set: NAME KEY = VALUE` change a file.
    fn obey(&mut self, comment: &str) {
        let words: Vec<&str> = comment.splitn(4, ' ').collect();
        let change = |name: &str, edit: &dyn Fn(&str) -> String| {
            let file = self.folder.join(name);
            let text = std::fs::read_to_string(&file).expect("a file of the reader");
            std::fs::write(&file, edit(&text)).expect("writable");
        };
        match words[..] {
            ["file:" | "append:", _] => self.order = Some(comment.into()),
            ["remove:", name, "from", line] => {
                change(name, &|text| text.split(line).next().unwrap_or_default().into());
            }
            ["set:", name, key, value] => change(name, &|text| {
                let line =
                    |l: &str| if l.starts_with(&format!("{key} =")) { format!("{key} {value}") } else { l.into() };
                text.lines().map(line).collect::<Vec<_>>().join("\n")
            }),
            _ => panic!("a comment that is not understood: {comment}"),
        }
    }

    /// Writes a listing where its comment says.
    fn write(&mut self, listing: &str) {
        let order = self.order.take().unwrap_or_else(|| panic!("no comment says where this goes:\n{listing}"));
        let (what, name) = order.split_once(": ").expect("an order and a name");
        let file = self.folder.join(name);
        let before =
            if what == "append" { std::fs::read_to_string(&file).expect("a file") + "\n" } else { String::new() };
        std::fs::write(&file, before + listing).expect("writable");
    }

    /// Every line that the page shows was printed, numbers to 0.2 %.
    fn expect(&self, shown: &str) {
        for line in shown.lines() {
            let found = self.printed.lines().any(|printed| is_like(line, printed));
            assert!(found, "the page shows\n{line}\nand the program printed\n{}", self.printed);
        }
    }
}

/// Whether a printed line is the one that is shown, which may leave out the end of it.
fn is_like(shown: &str, printed: &str) -> bool {
    let words = |line: &str| -> Vec<String> {
        line.split([' ', '(', ')', ',', ';']).filter(|word| !word.is_empty()).map(String::from).collect()
    };
    let (mut a, mut b) = (words(shown), words(printed));
    if a.last().is_some_and(|word| word == "…") {
        a.pop();
        b.truncate(a.len());
    }
    let close = |(a, b): (&String, &String)| match (a.parse::<f64>(), b.parse::<f64>()) {
        // A zero is shown as one
        (Ok(0.0), Ok(b)) => b == 0.0,
        (Ok(a), Ok(b)) => (a - b).abs() <= 2e-3 * a.abs() + 1e-6,
        _ => a == b,
    };
    a.len() == b.len() && a.iter().zip(&b).all(close)
}

#[test]
fn the_tutorial_works_as_it_is_written() {
    let page = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(PAGE)).expect("the page");
    let mut reader = Reader::new();
    let mut lines = page.lines();
    let mut done = [0, 0, 0];
    while let Some(line) = lines.next() {
        if let Some(comment) = line.strip_prefix("<!-- ").and_then(|rest| rest.strip_suffix(" -->")) {
            reader.obey(comment);
        }
        let Some(language) = line.strip_prefix("```") else { continue };
        let listing: Vec<&str> = lines.by_ref().take_while(|l| *l != "```").collect();
        match language {
            "sh" => {
                reader.printed.clear();
                // The next listing shows what is printed: an error, where the command is refused
                let shown = lines.clone().skip_while(|l| !l.starts_with("```")).nth(1);
                let code = if shown.is_some_and(|l| l.starts_with("error:")) { 2 } else { 0 };
                listing.iter().for_each(|line| reader.run(line, code));
                done[0] += listing.len();
            }
            "toml" => {
                reader.write(&(listing.join("\n") + "\n"));
                done[1] += 1;
            }
            "text" => {
                reader.expect(&listing.join("\n"));
                done[2] += 1;
            }
            other => panic!("a listing in {other}"),
        }
    }
    assert!(done[0] > 12 && done[1] == 3 && done[2] >= 5, "{done:?}");
}

#[test]
fn a_line_is_compared_by_its_numbers() {
    assert!(is_like("a  1.000 at 2.0 s", "a 1.001 at 2.0 s"));
    assert!(!is_like("a  1.000 at 2.0 s", "a 1.010 at 2.0 s"));
    assert!(!is_like("a  1.000", "b 1.000"));
    assert!(is_like("final 0.00000", "final 0.00000") && !is_like("final 0.00000", "final 1.4787e-13"));
    assert!(is_like("error bar 3.28 %, …", "error bar 3.28 %, 2.5 s per case."));
    assert!(!is_like("error bar 3.28 %, …", "error bar 4.28 %, 2.5 s per case."));
}
