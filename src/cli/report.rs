//! `durometer report DIR`

use super::outcome::{CommandResult, Outcome};
use durometer::report::style::{self, Style};
use std::path::PathBuf;

/// Draw the report of a study, a fit or a comparison of fits again from its stored results
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  durometer report reports/finger-convergence\n  durometer report reports/finger-convergence --style one-column --font serif\n\nNeither the solver nor the mesher is needed."
)]
pub struct Args {
    /// Folder of the results, e.g. reports/finger-convergence or reports/fit-treloar-1944-ogden; or the record of a run,
    /// reports/simulate/scene.json, for the methods of a paper
    dir: PathBuf,
    /// Width of the figures and size of their type: default (180 mm, 8 pt), one-column (88 mm, 7 pt), two-column (180 mm, 7 pt), slides (254 mm,
    /// 16 pt)
    #[arg(long, value_name = "NAME", default_value = "default")]
    style: String,
    /// Size of the labels in points, in place of that of the style
    #[arg(long, value_name = "POINTS")]
    font_size: Option<f64>,
    /// Family of the type: sans or serif
    #[arg(long, value_name = "FAMILY")]
    font: Option<String>,
    /// Print summary.json (of a fit: fit.json, of a comparison of all laws: compare.json, of a Prony series: prony.json, of softening: mullins.json, of a change of volume: volume.json)
    #[arg(long)]
    json: bool,
}

pub fn main(args: Args) -> CommandResult {
    let style = Style::named(&args.style, args.font_size, args.font.as_deref())?;
    style::within(style, || redraw(args))
}

fn redraw(args: Args) -> CommandResult {
    if args.dir.is_file() {
        let paper = durometer::study::paper::of_run(&args.dir)?;
        println!("paper: {}", paper.display());
        return Ok(Outcome::Complete);
    }
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
