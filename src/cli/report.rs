//! `durometer report DIR`

use super::outcome::{CommandResult, Outcome};
use super::style::StyleArgs;
use durometer::report::{self, style};
use durometer::storage::results::add;
use durometer::storage::writing::Writing;
use durometer::storage::{self, DATA_LIMIT};
use durometer::study::report::Summary;
use durometer::wording::few;
use std::path::{Path, PathBuf};

/// Redraw the report of a study, a fit or a comparison of fits from its stored results
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  durometer report reports/finger-convergence\n  durometer report reports/finger-convergence --style one-column --font serif\n\nNeither the solver nor the mesher is needed.\n\nExit codes: 0 done, 2 bad input, 3 a stored file of a study is missing or not the one that was stored, or a study has no result, such as a reduced model."
)]
pub struct Args {
    /// Folder of the results, e.g. reports/finger-convergence or reports/fit-treloar-1944-ogden; or the record of a run,
    /// reports/simulate/scene.json, for the methods of a paper
    dir: PathBuf,
    #[command(flatten)]
    style: StyleArgs,
    /// Print summary.json (for a fit: fit.json, a comparison of all laws: compare.json, a Prony series: prony.json, softening: mullins.json, a change of
    /// volume: volume.json)
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
    if let Some((file, answer)) = fit(&args.dir)? {
        if args.json {
            say!("{}", storage::read_text(&file, DATA_LIMIT)?);
        } else {
            say!("{answer}report: {}", args.dir.join("index.html").display());
        }
        return Ok(Outcome::Complete);
    }
    let summary = durometer::study::report::write_report(&args.dir)?;
    if args.json {
        say!("{}", serde_json::to_string_pretty(&summary)?);
    } else {
        say!("{}\n\nreport: {}", summary.verdict, args.dir.join("index.html").display());
    }
    let sound = soundness(&summary);
    if let Some(why) = &summary.without_result {
        summary.warnings.iter().for_each(|warning| tell!("warning: {warning}"));
        tell!("not complete: {why}");
        return Ok(Outcome::RunIncomplete);
    }
    Ok(sound)
}

/// Draws the report of a folder with a fit of any kind, and lists its files. Returns the path of the stored result and the answer as text; `None` if the
/// folder holds no fit.
fn fit(dir: &Path) -> Result<Option<(PathBuf, String)>, Box<dyn std::error::Error>> {
    let writing = Writing::begin();
    let drawn = if report::fit::is_comparison(dir) {
        report::fit::comparison::write(dir)?;
        (dir.join("compare.json"), String::new())
    } else if report::fit::is_fit(dir) {
        (dir.join("fit.json"), format!("{}\n\n", report::fit::write(dir)?))
    } else if let Some(file) = report::service_fit::result_of(dir) {
        (file, format!("{}\n\n", report::service_fit::write(dir)?))
    } else {
        return Ok(None);
    };
    add(dir, writing.files())?;
    Ok(Some(drawn))
}

/// Prints the damaged stored files and the results that do not count.
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
