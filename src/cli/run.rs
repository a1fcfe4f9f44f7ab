//! `durometer run STUDY`

use super::{INCOMPLETE, Outcome, bars::Bars};
use durometer::report;
use durometer::study::runner::{self, Options};
use durometer::study::spec::Study;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::Ordering;

/// Runs every case of a study that has no result yet, then writes the report.
///
/// Ctrl-C keeps what is finished; the next run goes on from there. A case is run again when its scene, its mesh or the
/// program's version has changed.
#[derive(clap::Args)]
pub struct Args {
    /// Name of a folder in studies/, or path of a study.toml
    study: PathBuf,
    /// Folder of the results [default: reports/<study>]
    #[arg(long)]
    out: Option<PathBuf>,
    /// Cases that run side by side [default: one per core; 1 for prices that nothing disturbs]
    #[arg(long)]
    jobs: Option<usize>,
    /// Run also what is done
    #[arg(long)]
    redo: bool,
    /// Only cases whose id contains this text
    #[arg(long, value_name = "CASE")]
    only: Option<String>,
    /// Change a key of every scene, e.g. --set laws.rubber.nu=0.49
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Write fields of every case for ParaView (VTU, PVD) into cases/<id>/; runs also what is done without them
    #[arg(long)]
    vtu: bool,
    /// Print summary.json instead of progress
    #[arg(long)]
    json: bool,
}

pub fn main(args: Args) -> Outcome {
    let study = Study::read(&super::find(&args.study, "study.toml"), &super::changes(&args.set)?)?;
    let dir = args.out.unwrap_or_else(|| PathBuf::from("reports").join(&study.name));
    let jobs = args.jobs.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, Into::into));
    let stop = super::stop_flag();
    let options = Options { jobs, redo: args.redo, only: args.only, vtu: args.vtu, stop };
    let records = runner::run(&study, &dir, &options, &Bars::new(args.json))?;
    if stop.load(Ordering::Relaxed) {
        eprintln!("stopped: {} finished cases are kept in {}; run again to go on", records.len(), dir.display());
        return Ok(ExitCode::from(INCOMPLETE));
    }
    let summary = report::write(&dir)?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&summary)?);
    } else {
        println!("\n{}\n\nreport: {}", summary.verdict, dir.join("index.html").display());
    }
    let complete = records.iter().all(|r| r.status == durometer::study::convergence::CONVERGED);
    Ok(if complete { ExitCode::SUCCESS } else { ExitCode::from(INCOMPLETE) })
}
