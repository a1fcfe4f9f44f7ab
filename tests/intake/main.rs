//! Files of testing machines and of careless hands: each is understood or refused with its reason, none is misread without a word.
//!
//! Every table is the same Neo-Hookean test, so that a file that was understood has its constant. A hint is a reason to doubt in the audit
//! log, which the fit repeats as a warning.

#[path = "../common/mod.rs"]
mod common;

mod compared;
mod dialects;
mod hostile;
mod machines;
mod readers;

use common::tables::{MU, stress};
use durometer::calibrate::{
    AuditKind, ColumnChoice, Experiment, FitError, FitOptions, Mode, Preparation, SlackChoice, fit_experiment,
};

/// The outcome that a file must have.
pub enum Expected {
    /// The constant, to rounding of the numbers in the file
    Read,
    /// The constant, with these words in the audit log
    Logged(&'static [&'static str]),
    /// Any constant, with these words in a doubt
    Doubted(&'static [&'static str]),
    /// A message with these words
    Refused(&'static [&'static str]),
}
use Expected::{Doubted, Logged, Read, Refused};

/// A file and what a user says about it.
pub struct Case {
    pub name: String,
    pub bytes: Vec<u8>,
    pub choice: ColumnChoice,
    pub preparation: Preparation,
    pub expected: Expected,
}

pub fn case(name: &str, text: &str, expected: Expected) -> Case {
    let (choice, preparation) = (ColumnChoice::default(), Preparation::default());
    Case { name: name.into(), bytes: text.as_bytes().to_vec(), choice, preparation, expected }
}

impl Case {
    pub fn with(mut self, change: impl FnOnce(&mut ColumnChoice)) -> Self {
        change(&mut self.choice);
        self
    }

    pub fn prepared(mut self, change: impl FnOnce(&mut Preparation)) -> Self {
        change(&mut self.preparation);
        self
    }

    pub fn bytes(mut self, change: impl FnOnce(&str) -> Vec<u8>) -> Self {
        self.bytes = change(std::str::from_utf8(&self.bytes).expect("cases are written in UTF-8"));
        self
    }
}

/// λ of the data points, unless a file needs others.
pub fn stretches() -> Vec<f64> {
    (0..30).map(|k| 1.0 + 0.03 * f64::from(k)).collect()
}

/// P \[Pa\] of the test in uniaxial tension or compression.
pub fn nominal(l: f64) -> f64 {
    stress(Mode::Uniaxial, l)
}

/// Lines under a head, each written from λ.
pub fn lines(head: &str, stretches: &[f64], row: impl Fn(usize, f64) -> String) -> String {
    let rows = stretches.iter().enumerate().map(|(k, l)| row(k, *l) + "\n");
    format!("{head}\n") + &rows.collect::<String>()
}

/// The usual table: two columns and a comma.
pub fn table(head: &str, row: impl Fn(f64) -> (f64, f64)) -> String {
    lines(head, &stretches(), |_, l| {
        let (x, y) = row(l);
        format!("{x},{y}")
    })
}

fn log_of(e: &Experiment) -> String {
    e.audit.0.iter().map(|entry| format!("{entry}\n")).collect()
}

/// What is wrong with the outcome of a case, if anything is.
fn fault(case: &Case) -> Option<String> {
    let read = || -> Result<(f64, Experiment), FitError> {
        let e = Experiment::parse("test.csv", &case.bytes, None, &case.choice, Some(Mode::Uniaxial))?;
        let e = e.prepare(&case.preparation)?;
        let result = fit_experiment(&e, &FitOptions::new("neo_hookean"))?;
        Ok((result.parameters[0].value, e))
    };
    let absent = |text: &str, facts: &[&str]| {
        let missing: Vec<_> = facts.iter().filter(|f| !text.contains(**f)).collect();
        (!missing.is_empty()).then(|| format!("{missing:?} not in:\n{text}"))
    };
    // Numbers in the files have ten digits or more
    let off = |mu: f64, e: &Experiment| {
        ((mu / MU - 1.0).abs() > 1e-7).then(|| format!("μ = {mu} instead of {MU}\n{}", log_of(e)))
    };
    match (read(), &case.expected) {
        (Ok((mu, e)), Read) => off(mu, &e),
        (Ok((mu, e)), Logged(facts)) => off(mu, &e).or_else(|| absent(&log_of(&e), facts)),
        (Ok((_, e)), Doubted(facts)) => {
            let doubts = [AuditKind::Doubt, AuditKind::Slack].into_iter().flat_map(|kind| e.audit.of(kind));
            absent(&doubts.map(|d| d.to_string() + "\n").collect::<String>(), facts)
        }
        (Err(error), Refused(facts)) => absent(&error.to_string(), facts),
        (Ok((mu, e)), Refused(_)) => Some(format!("was not refused: μ = {mu}\n{}", log_of(&e))),
        (Err(error), _) => Some(format!("was refused: {error}")),
    }
}

fn check(cases: Vec<Case>, least: usize) {
    assert!(cases.len() >= least, "{} cases", cases.len());
    let faults: Vec<String> = cases.iter().filter_map(|c| fault(c).map(|f| format!("{}: {f}", c.name))).collect();
    assert!(faults.is_empty(), "{} of {}:\n{}", faults.len(), cases.len(), faults.join("\n"));
}

#[test]
fn exports_of_testing_machines_are_understood_or_refused() {
    check(machines::cases(), 25);
}

/// 300 000 data points: means of neighbours have the same constant. A step whose cost grows with the square of the number would not end.
#[test]
fn very_long_tables_are_averaged() {
    let all: Vec<f64> = (0..300_000).map(|k| 1.0 + 3.0 * f64::from(k) / 300_000.0).collect();
    let text = lines("time (s),stretch,nominal stress (Pa)", &all, |k, l| format!("{k},{l},{}", nominal(l)));
    let long = case("long", &text, Logged(&["300000 uniaxial data points became 2000 means of 150 neighbours"]));
    assert_eq!(fault(&long), None);
}

#[test]
fn encodings_marks_and_units_are_understood_or_refused() {
    check(dialects::cases(), 45);
}

#[test]
fn hostile_and_ambiguous_tables_are_refused_or_doubted() {
    check(hostile::cases(), 45);
}

/// A note within a table does not end it: the rows below belong to the same specimen, however many tables follow. Rows of results above the next column names are
/// named.
#[test]
fn a_note_does_not_end_a_table() {
    let names = "stretch,stress (Pa)";
    let table = table(names, |l| (l, nominal(l)));
    let rows = table.lines().count() - 1;
    let (above, below) = table.split_at(table.match_indices('\n').nth(12).expect("twelve rows").0 + 1);
    let text = format!("{above}Pause\n{below}Results\n1,2\n{table}End\n");
    let read = Experiment::parse("test.csv", text.as_bytes(), None, &ColumnChoice::default(), Some(Mode::Uniaxial));
    let e = read.expect("two tables");
    assert_eq!((e.specimens.len(), e.raw.len()), (2, 2 * rows), "{}", log_of(&e));
    let log = log_of(&e);
    assert!(log.contains("1 rows of numbers belong to the title"), "{log}");
    assert!(log.contains("Pause"), "{log}");
}

/// Specimens are those of the rows: a line of text above the first row names none.
#[test]
fn a_line_of_text_is_no_specimen() {
    let parse = |labels: [&str; 2]| {
        let row = |k: usize, l: f64| format!("{},{l},{}", labels[k / 15], nominal(l));
        let text = lines("Specimen,stretch,stress (Pa)\n,begin,", &stretches(), row);
        let choice = ColumnChoice::default();
        Experiment::parse("test.csv", text.as_bytes(), None, &choice, Some(Mode::Uniaxial)).expect("a table")
    };
    let one = parse(["A", "A"]);
    assert!(!log_of(&one).contains("each of which is a specimen"), "{}", log_of(&one));
    let two = parse(["A", "B"]);
    assert!(log_of(&two).contains("holds 2 values, each of which is a specimen: A, B"), "{}", log_of(&two));
    assert_eq!(two.specimens.len(), 2);
}

/// A doubt about slack is no warning of a fit that has slack as an unknown.
#[test]
fn a_fitted_slack_is_no_doubt() {
    let fine: Vec<f64> = (0..90).map(|k| 1.0 + 0.01 * f64::from(k)).collect();
    let text = lines("stretch,stress (Pa)", &fine, |_, l| format!("{l},{}", nominal((l - 0.05).max(1.0))));
    let parsed = Experiment::parse("test.csv", text.as_bytes(), None, &ColumnChoice::default(), Some(Mode::Uniaxial));
    let e = parsed.and_then(|e| e.prepare(&Preparation::default())).unwrap_or_else(|e| panic!("{e}"));
    for (slack, is_warned) in [(SlackChoice::No, true), (SlackChoice::Yes, false), (SlackChoice::Auto, false)] {
        let options = FitOptions { slack, ..FitOptions::new("neo_hookean") };
        let result = fit_experiment(&e, &options).unwrap_or_else(|e| panic!("{e}"));
        let warnings: Vec<String> = result.warnings.iter().map(ToString::to_string).collect();
        assert_eq!(warnings.iter().any(|w| w.contains("it was slack")), is_warned, "{slack:?}: {warnings:?}");
    }
}
