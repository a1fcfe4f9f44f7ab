//! `durometer compare OLD NEW`

use super::outcome::{CommandResult, Outcome};
use durometer::math::units::{self, Dimension};
use durometer::report::numbers::{percent_cell, seconds, significant};
use durometer::study::changes::{Change, Changes, Judgement, compare};
use durometer::wording::few;
use std::path::{Path, PathBuf};

/// The default of `--tolerance` \[–\], a hundred times the accuracy of the solver
const TOLERANCE: f64 = 1e-4;

/// Compare two results of a study: what changed, and whether it exceeds the error bars
///
/// A change exceeds the error bars if it is larger than √(h₁² + h₂²), with the half-widths h₁ and h₂ of both. A value without an error bar is judged by
/// --tolerance. Values are those that the study judges: peaks, or the largest change of a quantity that does not start at zero.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer compare reports/published/finger-convergence reports/finger-convergence
  durometer compare old new --tolerance \"1 %\" --all

Exit codes: 0 nothing changed beyond the error bars, 2 bad input, 3 something did, or the verdict or a decision changed, or a case or a value is gone, or
a case converges no longer.")]
pub struct Args {
    /// Folder of the earlier result
    old: PathBuf,
    /// Folder of the later result
    new: PathBuf,
    /// Largest relative change that is accepted for a value without an error bar; the default is a hundred times the accuracy of the solver
    #[arg(long, value_name = "SHARE", default_value = "0.01 %")]
    tolerance: String,
    /// Also list the values that did not change
    #[arg(long)]
    all: bool,
    /// Print everything as JSON
    #[arg(long)]
    json: bool,
}

pub fn main(args: Args) -> CommandResult {
    let tolerance = units::parse(&args.tolerance, Dimension::NONE).map_err(|e| format!("--tolerance: {e}"))?;
    if !(tolerance >= 0.0 && tolerance.is_finite()) {
        return Err(
            format!("--tolerance: {} is no share of a value; give 0 or more, such as \"1 %\"", args.tolerance).into()
        );
    }
    let changes = compare(&args.old, &args.new, tolerance)?;
    if args.json {
        say!("{}", serde_json::to_string_pretty(&changes)?);
    } else {
        print(&changes, [&args.old, &args.new], args.all);
    }
    Ok(outcome(&changes))
}

/// Compares two results with the default tolerance, and prints what changed.
pub fn told(old: &Path, new: &Path) -> CommandResult {
    let changes = compare(old, new, TOLERANCE)?;
    print(&changes, [old, new], false);
    Ok(outcome(&changes))
}

fn outcome(changes: &Changes) -> Outcome {
    if changes.is_beyond() { Outcome::ChangedBeyondBars } else { Outcome::Complete }
}

fn print(c: &Changes, folders: [&Path; 2], all: bool) {
    let pair = |name: &str, [old, new]: &[String; 2]| {
        if old != new {
            say!("{name}: {old}\n  now: {new}");
        }
    };
    pair("study", &c.study);
    pair("version", &c.version);
    pair("tolerance", &c.tolerance.map(|t| format!("{} %", percent_cell(t))));
    c.settings.iter().for_each(|s| say!("{}: {}, now {}", s.what, s.old, s.new));
    // The numbers of a verdict are costs, or values that are listed below
    if c.verdict_changed || without_numbers(&c.verdict[0]) != without_numbers(&c.verdict[1]) {
        pair("verdict", &c.verdict);
    }
    print_decisions(c, folders);
    if !c.inputs.is_empty() {
        let (n, few) = (c.inputs.len(), few(&c.inputs));
        say!("inputs: {n} of the common cases were computed from another scene, other files or another mesh: {few}");
    }
    c.missing.iter().for_each(|id| say!("case {id}: gone"));
    c.added.iter().for_each(|id| say!("case {id}: new"));
    c.statuses.iter().for_each(|(id, old, new)| say!("case {id}: {old}, now {new}"));
    c.meshes.iter().for_each(|(id, old, new)| say!("case {id}: {old} cells, now {new}"));
    let named = |values: &[String], what: &str| {
        if let [first, rest @ ..] = values {
            let more = if rest.is_empty() { String::new() } else { format!(" and {} more", rest.len()) };
            say!("{first}{more}: {what}");
        }
    };
    named(&c.gone, "gone, judged in the earlier result only");
    named(&c.new, "new, judged in the later result only");
    named(&c.unmatched, "an error bar in one result only, judged by the tolerance");
    for v in c.values.iter().filter(|v| all || v.judgement != Judgement::Same) {
        say!("{}", words(v));
    }
    let count = |j: Judgement| c.values.iter().filter(|v| v.judgement == j).count();
    say!(
        "{} {}: {} unchanged, {} changed within their bars, {} beyond{}",
        c.values.len(),
        if c.values.len() == 1 { "value" } else { "values" },
        count(Judgement::Same),
        count(Judgement::Within),
        count(Judgement::Beyond),
        if c.verdict_changed { "; the VERDICT CHANGED" } else { "" }
    );
    say!("CPU time of the common cases: {}, now {}", seconds(c.cpu_s[0]), seconds(c.cpu_s[1]));
}

fn print_decisions(c: &Changes, folders: [&Path; 2]) {
    for d in &c.decisions {
        say!("decision: {}: {}, {}", d.what, d.old, d.new.as_ref().map_or("gone".into(), |new| format!("now {new}")));
    }
    for (folder, _) in folders.iter().zip(c.undecided).filter(|(_, is)| *is) {
        let folder = folder.display();
        say!("decisions are not compared: {folder} does not state its own; `durometer report {folder}` writes them");
    }
}

/// A verdict without the digits of its numbers.
fn without_numbers(verdict: &str) -> String {
    verdict.chars().filter(|c| !c.is_ascii_digit() && *c != '.').collect()
}

/// `tet10-length-4500: cable_tension_N: 2.6571 N, now 2.6602 N (+0.12 %), within the error bars (0.03 of them)`
fn words(v: &Change) -> String {
    let unit = if v.unit.is_empty() { String::new() } else { format!(" {}", v.unit) };
    let relative =
        v.relative.map_or(String::new(), |r| format!(" ({}{} %)", if r > 0.0 { "+" } else { "" }, percent_cell(r)));
    let judged = match (v.judgement, v.normalised) {
        (Judgement::Same, _) => "unchanged".into(),
        (Judgement::Within, Some(e)) => format!("within the error bars ({} of them)", significant(e, 2)),
        (Judgement::Beyond, Some(e)) => format!("BEYOND the error bars ({} times)", significant(e, 2)),
        (Judgement::Within, None) => "within the tolerance; no error bar".into(),
        (Judgement::Beyond, None) => "BEYOND the tolerance; no error bar".into(),
    };
    format!("{}: {}{unit}, now {}{unit}{relative}, {judged}", v.what, significant(v.old, 6), significant(v.new, 6))
}
