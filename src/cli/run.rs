//! `durometer run STUDY`

use super::{INCOMPLETE, Outcome, bars::Bars, files};
use durometer::study::record::CaseRecord;
use durometer::study::report;
use durometer::study::runner::{self, Options};
use durometer::study::spec::Study;
use std::path::PathBuf;
use std::process::ExitCode;
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
  durometer run hard-cases --scene my-scene.toml      where does this scene hold? time step, load, ν, mesh, start

Exit codes: 0 every case converged, 2 bad input, 3 some case did not complete or Ctrl-C stopped the run.")]
pub struct Args {
    /// Name of a folder in studies/, or path of a study.toml
    study: PathBuf,
    /// Folder of the results [default: reports/<study>]
    #[arg(long)]
    out: Option<PathBuf>,
    /// Cases that run side by side [default: one per core; 1 for prices that nothing disturbs]
    #[arg(long, value_parser = super::at_least_one)]
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
    /// Draw the maps of a study of kind stability around this scene, and run nothing else of it
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
    /// Of a study of kind stability, the quick half only
    #[arg(long, conflicts_with = "scene")]
    quick: bool,
    /// Print summary.json instead of progress
    #[arg(long)]
    json: bool,
}

pub fn main(args: Args) -> Outcome {
    let file = files::find(&args.study, "study.toml")?;
    let scene = args.scene.as_ref().map(|scene| files::find(scene, "scene.toml")).transpose()?;
    let mut study = Study::read_around(&file, scene.as_deref(), &super::changes(&args.set)?)?;
    if args.quick {
        study = study.quick();
    }
    let around = args.scene.as_ref().and_then(|s| s.file_stem()).map(|s| format!("-{}", s.to_string_lossy()));
    let folder = format!("{}{}", study.name, around.unwrap_or_default());
    let dir = args.out.unwrap_or_else(|| PathBuf::from("reports").join(folder));
    let jobs = args.jobs.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, Into::into));
    let stop = super::stop_flag();
    let options = Options { jobs, redo: args.redo, only: args.only, vtu: args.vtu, stop };
    let bars = Bars::of(study.cases.iter().filter(|c| options.wants(&c.id)).count(), args.json);
    let records = runner::run(&study, &dir, &options, &bars)?;
    if stop.load(Ordering::Relaxed) {
        let (kept, all) = (records.len(), study.cases.len());
        eprintln!("stopped: {kept} of {all} cases are finished and kept in {}; run again to go on", dir.display());
        return Ok(ExitCode::from(INCOMPLETE));
    }
    let summary = report::write(&dir)?;
    let failed: Vec<&CaseRecord> = records.iter().filter(|r| !r.converged()).collect();
    if args.json {
        println!("{}", serde_json::to_string_pretty(&summary)?);
    } else {
        println!("\n{}\n\nreport: {}", summary.verdict, dir.join("index.html").display());
    }
    for record in &failed {
        let detail = record.status_detail.as_deref().unwrap_or_default();
        eprintln!("not complete: {}: {}: {detail}", record.id, record.status);
    }
    Ok(if failed.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(INCOMPLETE) })
}
