//! `durometer studies`

use super::outcome::{CommandResult, Outcome};
use durometer::catalogue::host;
use durometer::mesh::generate::MeshStore;
use durometer::study::shipped::{Shipped, shipped};

/// List the studies and scenes that come with the program
///
/// Every command accepts their names, e.g. `durometer run finger-convergence`. A folder `studies` in the current folder takes precedence.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer studies
  durometer studies --json | jq -r '.[] | select(.has_meshes) | .name'

A study marked with * has meshes that are not stored: its first run needs the mesher, which durometer doctor tells how to install.")]
pub struct Args {
    /// Print a list of objects instead of a table
    #[arg(long)]
    json: bool,
}

pub fn main(args: Args) -> CommandResult {
    let store = MeshStore::find()?;
    let (mut known, mut unread) = (vec![], vec![]);
    for found in shipped(&store) {
        match found {
            Ok(study) => known.push(study),
            Err((name, _)) => unread.push(name),
        }
    }
    let waiting = (!unread.is_empty()).then(|| {
        let (count, names) = (unread.len(), unread.join(", "));
        format!("{count} more cannot be run as they are: {names}; durometer check NAME says why, README.md in its folder what it needs")
    });
    if args.json {
        say!("{}", serde_json::to_string_pretty(&known)?);
        waiting.iter().for_each(|line| tell!("{line}"));
    } else {
        known.iter().for_each(show);
        say!("\n{} studies and scenes in {}", known.len(), store.home.studies().display());
        if known.iter().any(|study| !study.has_meshes) {
            say!("* meshes are made at the first run, by the mesher ({})", host::setup());
        }
        waiting.iter().for_each(|line| say!("{line}"));
    }
    Ok(Outcome::Complete)
}

fn show(study: &Shipped) {
    let mark = if study.has_meshes { "" } else { "*" };
    say!("{:24} {:12} {}", format!("{}{mark}", study.name), study.kind, study.about);
}
