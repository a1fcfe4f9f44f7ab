//! `durometer report DIR`

use super::Outcome;
use std::path::PathBuf;
use std::process::ExitCode;

/// Draw the report of a study again from its stored results
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  durometer report reports/finger-convergence\n\nNeither the solver nor the mesher is needed."
)]
pub struct Args {
    /// Folder of the results, e.g. reports/finger-convergence
    dir: PathBuf,
    /// Print summary.json
    #[arg(long)]
    json: bool,
}

pub fn main(args: Args) -> Outcome {
    let summary = durometer::report::write(&args.dir)?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&summary)?);
    } else {
        println!("{}\n\nreport: {}", summary.verdict, args.dir.join("index.html").display());
    }
    Ok(ExitCode::SUCCESS)
}
