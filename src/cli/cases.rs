//! `durometer cases STUDY`

use super::files;
use super::outcome::{CommandResult, Outcome};
use durometer::report::numbers::seconds;
use durometer::study::expand::Study;
use durometer::study::listing::{Listed, State, list};
use std::path::PathBuf;

/// List the cases of a study: what is stored for each, and what it is expected to cost
///
/// Nothing is run, meshed or written. Expected times and memory come from stored results of the case itself, or of other cases with its
/// formulation.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer cases finger-convergence
  durometer cases finger-convergence --json | jq -r '.[] | select(.state != \"stored\") | .id'

States: stored, other build (of the same inputs), partial (without what the study asks for now), outdated (of other inputs), damaged, missing, unmeshed (its mesh is not made yet).")]
pub struct Args {
    /// Name of a folder in studies/, or path of a study.toml
    study: PathBuf,
    /// Change a key of every scene, e.g. --set laws.rubber.nu=0.49
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Folder of the results [default: reports/<study>]
    #[arg(long)]
    out: Option<PathBuf>,
    /// Print a list of objects instead of a table
    #[arg(long)]
    json: bool,
}

pub fn main(args: Args) -> CommandResult {
    let file = files::find(&args.study, "study.toml")?;
    let changes = super::arguments::changes(&args.set)?;
    let dir = match args.out {
        Some(dir) => dir,
        None => PathBuf::from("reports").join(Study::name_of(&file)),
    };
    let cases = list(&Study::read_with_added(&file, &changes, &dir)?, &dir);
    if args.json {
        say!("{}", serde_json::to_string_pretty(&cases)?);
        return Ok(Outcome::Complete);
    }
    let none = || "–".to_string();
    say!("{:40} {:11} {:>8} {:>10} {:>9}  identity", "case", "state", "nodes", "time", "memory");
    for c in &cases {
        let nodes = c.nodes.map_or_else(none, |n| n.to_string());
        let cost = c.expected.cost_s.map_or_else(none, seconds);
        let memory = c.expected.memory_bytes.map_or_else(none, |b| format!("{} MiB", b >> 20));
        let identity = c.identity.as_ref().map_or_else(none, |i| i[..12].into());
        say!("{:40} {:11} {nodes:>8} {cost:>10} {memory:>9}  {identity}", c.id, c.state.words());
    }
    say!("\n{}", totals(&cases));
    Ok(Outcome::Complete)
}

/// `48 cases: 40 stored, 8 missing; 12 min expected for 8 of those to be run`
fn totals(cases: &[Listed]) -> String {
    let states = [
        State::Stored,
        State::OtherBuild,
        State::Partial,
        State::Outdated,
        State::Damaged,
        State::Missing,
        State::Unmeshed,
    ];
    let count = |state: State| cases.iter().filter(|c| c.state == state).count();
    let words = states.iter().filter(|s| count(**s) > 0).map(|s| format!("{} {}", count(*s), s.words()));
    let known: Vec<f64> = cases.iter().filter(|c| c.state != State::Stored).filter_map(|c| c.expected.cost_s).collect();
    let words = words.collect::<Vec<_>>().join(", ");
    match known[..] {
        [] => format!("{} cases: {words}", cases.len()),
        _ => {
            format!(
                "{} cases: {words}; {} expected for {} that are not stored",
                cases.len(),
                seconds(known.iter().sum()),
                known.len()
            )
        }
    }
}
