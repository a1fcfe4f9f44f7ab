//! `durometer report DIR`

use super::outcome::{CommandResult, Outcome};
use super::style::StyleArgs;
use durometer::report::style;
use durometer::study::report::Summary;
use durometer::wording::few;
use std::path::PathBuf;

/// Draw the report of a study, a fit or a comparison of fits again from its stored results
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  durometer report reports/finger-convergence\n  durometer report reports/finger-convergence --style one-column --font serif\n\nNeither the solver nor the mesher is needed.\n\nExit codes: 0 done, 2 bad input, 3 a stored file of a study is missing or not the one that was stored."
)]
pub struct Args {
    /// Folder of the results, e.g. reports/finger-convergence or reports/fit-treloar-1944-ogden; or the record of a run,
    /// reports/simulate/scene.json, for the methods of a paper
    dir: PathBuf,
    #[command(flatten)]
    style: StyleArgs,
    /// Print summary.json (of a fit: fit.json, of a comparison of all laws: compare.json, of a Prony series: prony.json, of softening: mullins.json, of a change of volume: volume.json)
    #[arg(long)]
    json: bool,
}

pub fn main(args: Args) -> CommandResult {
    style::within(args.style.style()?, || redraw(args))
}

fn redraw(args: Args) -> CommandResult {
    if args.dir.is_file() {
        let paper = durometer::study::paper::of_run(&args.dir)?;
        say!("paper: {}", paper.display());
        return Ok(Outcome::Complete);
    }
    if durometer::report::fit::is_comparison(&args.dir) {
        durometer::report::fit::comparison::write(&args.dir)?;
        if args.json {
            say!("{}", durometer::storage::read_text(&args.dir.join("compare.json"), durometer::storage::DATA_LIMIT)?);
        } else {
            say!("report: {}", args.dir.join("index.html").display());
        }
        return Ok(Outcome::Complete);
    }
    if durometer::report::fit::is_fit(&args.dir) {
        let answer = durometer::report::fit::write(&args.dir)?;
        if args.json {
            say!("{}", durometer::storage::read_text(&args.dir.join("fit.json"), durometer::storage::DATA_LIMIT)?);
        } else {
            say!("{answer}\n\nreport: {}", args.dir.join("index.html").display());
        }
        return Ok(Outcome::Complete);
    }
    if let Some(file) = durometer::report::summary::result_of(&args.dir) {
        let answer = durometer::report::summary::write(&args.dir)?;
        if args.json {
            say!("{}", durometer::storage::read_text(&file, durometer::storage::DATA_LIMIT)?);
        } else {
            say!("{answer}\n\nreport: {}", args.dir.join("index.html").display());
        }
        return Ok(Outcome::Complete);
    }
    let summary = durometer::study::report::write(&args.dir)?;
    if args.json {
        say!("{}", serde_json::to_string_pretty(&summary)?);
    } else {
        say!("{}\n\nreport: {}", summary.verdict, args.dir.join("index.html").display());
    }
    Ok(soundness(&summary))
}

/// Names the stored files that are not sound, and the results that do not count.
pub fn soundness(summary: &Summary) -> Outcome {
    summary.damaged.iter().for_each(|fact| tell!("damaged: {fact}"));
    match &summary.outdated[..] {
        [] => {}
        [id] => tell!("note: the stored result of {id} is of other inputs than the study has now, and does not count"),
        all => {
            let (n, few) = (all.len(), few(all));
            tell!("note: {n} stored results are of other inputs than the study has now, and do not count: {few}");
        }
    }
    if summary.damaged.is_empty() { Outcome::Complete } else { Outcome::NotSound }
}
