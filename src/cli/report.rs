//! `durometer report DIR`

use super::outcome::{CommandResult, Outcome};
use std::path::PathBuf;

/// Draw the report of a study, a fit or a comparison of fits again from its stored results
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  durometer report reports/finger-convergence\n\nNeither the solver nor the mesher is needed."
)]
pub struct Args {
    /// Folder of the results, e.g. reports/finger-convergence or reports/fit-treloar-1944-ogden
    dir: PathBuf,
    /// Print summary.json (of a fit: fit.json, of a comparison of all laws: compare.json, of a Prony series: prony.json, of softening: mullins.json, of a change of volume: volume.json)
    #[arg(long)]
    json: bool,
}

pub fn main(args: Args) -> CommandResult {
    if durometer::report::fit::is_comparison(&args.dir) {
        durometer::report::fit::comparison::write(&args.dir)?;
        if args.json {
            println!(
                "{}",
                durometer::storage::read_text(&args.dir.join("compare.json"), durometer::storage::DATA_LIMIT)?
            );
        } else {
            println!("report: {}", args.dir.join("index.html").display());
        }
        return Ok(Outcome::Complete);
    }
    if durometer::report::fit::is_fit(&args.dir) {
        let answer = durometer::report::fit::write(&args.dir)?;
        if args.json {
            println!("{}", durometer::storage::read_text(&args.dir.join("fit.json"), durometer::storage::DATA_LIMIT)?);
        } else {
            println!("{answer}\n\nreport: {}", args.dir.join("index.html").display());
        }
        return Ok(Outcome::Complete);
    }
    if let Some(file) = durometer::report::summary::result_of(&args.dir) {
        let answer = durometer::report::summary::write(&args.dir)?;
        if args.json {
            println!("{}", durometer::storage::read_text(&file, durometer::storage::DATA_LIMIT)?);
        } else {
            println!("{answer}\n\nreport: {}", args.dir.join("index.html").display());
        }
        return Ok(Outcome::Complete);
    }
    let summary = durometer::study::report::write(&args.dir)?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&summary)?);
    } else {
        println!("{}\n\nreport: {}", summary.verdict, args.dir.join("index.html").display());
    }
    Ok(Outcome::Complete)
}
