//! `durometer run STUDY`

use super::outcome::{CommandResult, Outcome};
use super::{bars::Bars, files};
use durometer::study::expand::Study;
use durometer::study::record::CaseRecord;
use durometer::study::report;
use durometer::study::runner::{self, Options};
use std::path::PathBuf;
use std::sync::atomic::Ordering;

/// Run a study: every case that has no result yet, then the report
///
/// Ctrl-C keeps what is finished; the next run goes on from there. A case is run again when its scene, its mesh or the
/// program's version has changed.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer run finger-convergence
  durometer run finger-convergence --jobs 1           undisturbed wall times
  durometer run finger-convergence --only tet10       these cases; the report shows what exists
  durometer run finger-convergence --set laws.rubber.nu=0.49 --out reports/nu-49
  durometer run my-study/study.toml --json > summary.json

Exit codes: 0 every case converged, 2 bad input, 3 some case did not complete or Ctrl-C stopped the run.")]
pub struct Args {
    /// Name of a folder in studies/, or path of a study.toml
    study: PathBuf,
    /// Change a key of every scene, e.g. --set laws.rubber.nu=0.49
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Write fields of every case for ParaView (VTU, PVD) into cases/<id>/; runs also what is done without them
    #[arg(long)]
    vtu: bool,
    #[command(flatten)]
    how: How,
}

pub fn main(args: Args) -> CommandResult {
    let file = files::find(&args.study, "study.toml")?;
    let study = Study::read(&file, &super::arguments::changes(&args.set)?)?;
    execute(&study, args.how, args.vtu)
}

/// How a study is run, from the command line.
#[derive(clap::Args)]
pub struct How {
    /// Folder of the results [default: reports/<study>]
    #[arg(long)]
    out: Option<PathBuf>,
    /// Cases that run at the same time [default: one per core; 1 for costs that nothing disturbs]
    #[arg(long, value_parser = super::arguments::at_least_one)]
    jobs: Option<usize>,
    /// Run also what is done
    #[arg(long)]
    redo: bool,
    /// Only cases whose id contains this text
    #[arg(long, value_name = "CASE")]
    only: Option<String>,
    /// Print summary.json instead of progress
    #[arg(long)]
    json: bool,
}

/// Runs the cases of a study, with fields for ParaView where `vtu` asks for them, and writes its report.
pub fn execute(study: &Study, how: How, vtu: bool) -> CommandResult {
    let dir = how.out.unwrap_or_else(|| PathBuf::from("reports").join(&study.name));
    let jobs = how.jobs.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, Into::into));
    let stop = super::interrupt::stop_flag();
    let options = Options { jobs, redo: how.redo, only: how.only, vtu, stop };
    let bars = Bars::of(study.cases.iter().filter(|c| options.wants(&c.id)).count(), how.json);
    let records = runner::run(study, &dir, &options, &bars)?;
    if stop.load(Ordering::Relaxed) {
        let (kept, all) = (records.len(), study.cases.len());
        eprintln!("stopped: {kept} of {all} cases are finished and kept in {}; run again to go on", dir.display());
        return Ok(Outcome::Interrupted);
    }
    let summary = report::write(&dir)?;
    let failed: Vec<&CaseRecord> = records.iter().filter(|r| !r.converged()).collect();
    if how.json {
        println!("{}", serde_json::to_string_pretty(&summary)?);
    } else {
        println!("\n{}\n\nreport: {}", summary.verdict, dir.join("index.html").display());
    }
    for record in &failed {
        let detail = record.status_detail.as_deref().unwrap_or_default();
        eprintln!("not complete: {}: {}: {detail}", record.id, record.status);
    }
    Ok(if failed.is_empty() { Outcome::Complete } else { Outcome::RunIncomplete })
}
