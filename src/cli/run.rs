//! `durometer run STUDY`

use super::engine::{Engine, EngineArgs};
use super::outcome::{CommandResult, Outcome};
use super::report::soundness;
use super::{files, progress::Bars};
use durometer::catalogue::Launch;
use durometer::live::Relay;
use durometer::math::threads;
use durometer::report::ReportError;
use durometer::study::engine::batches;
use durometer::study::expand::Study;
use durometer::study::extension::{ADD, AddedMeshes};
use durometer::study::listing::{Listed, State, list};
use durometer::study::report::{self, Summary};
use durometer::study::run::growing;
use durometer::study::run::only::{Only, Partition};
use durometer::study::run::other_study::{HeldError, check, check_folder};
use durometer::study::run::runner::{Isolation, Options};
use durometer::study::store::folder;
use durometer::study::store::record::CaseRecord;
use durometer::study::time_left::TimeLeft;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Run a study: every case without a result, then the report
///
/// Ctrl-C keeps what is finished; the next run continues from there. A case is run again when its scene, a file
/// that it names, its mesh, or the build of this program has changed.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer run finger-convergence
  durometer run finger-convergence --jobs 1           undisturbed wall times
  durometer run finger-convergence --only tet10       these cases; the report shows what exists and counts
  durometer run my-study --live                       watch the cases in a browser
  durometer run my-study --extend                     one more mesh where the verdict is refused
  durometer run my-study --engine slurm --dry-run     the files that a cluster would get
  durometer run my-study --partition 2/8              the second of eight parts; then durometer report reports/my-study
  durometer run finger-convergence --set laws.rubber.nu=0.49 --out reports/nu-49
  durometer run my-study/study.toml --json > summary.json

Exit codes: 0 every case converged, or ended as its study expects, 2 bad input, 3 some case did not complete or Ctrl-C stopped the run.")]
pub struct Args {
    /// Name of a folder in studies/, or path of a study.toml
    study: PathBuf,
    /// Change a key of every scene, e.g. --set laws.rubber.nu=0.49
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Write fields of every case for ParaView (VTU, PVD; Warp By Vector deforms them) into cases/<id>/; cases that are done without fields are run again
    #[arg(long)]
    vtu: bool,
    /// If the evidence supports no verdict, add the mesh that the report asks for and run it; it is kept in extension.toml in the folder of
    /// the results
    #[arg(long, conflicts_with_all = ["only", "partition", "batch"])]
    extend: bool,
    /// Show a case in a browser while it runs: serves a page on this machine only (127.0.0.1), at a printed address with a token. Of several cases, the
    /// one that has run longest is shown; reload the page when it has ended. The page can pause the case; pauses do not count as run time
    #[arg(long)]
    live: bool,
    /// Port of the live view; 0 takes a free port
    #[arg(long, value_name = "N", default_value_t = 0, requires = "live")]
    port: u16,
    #[command(flatten)]
    how: How,
    #[command(flatten)]
    engine: EngineArgs,
}

pub fn main(args: Args) -> CommandResult {
    let file = files::find(&args.study, "study.toml")?;
    let changes = super::arguments::changes(&args.set)?;
    let dir = args.how.dir_of(&Study::name_of(&file), &file)?;
    let study = Study::read_with_added(&file, &changes, &dir)?;
    args.how.check(&study)?;
    if let Some(why) = study.record.without_verdict() {
        tell!("{why}");
    }
    if args.engine.engine != Engine::Local {
        if args.live {
            return Err("--live shows cases that run on this machine; leave --engine or --live out".into());
        }
        let flags = [("--accept-build", args.how.accept_build), ("--vtu", args.vtu)];
        let flags = flags.iter().filter(|(_, given)| *given).map(|(flag, _)| flag.to_string());
        let set = args.set.iter().map(|change| format!("--set={change}"));
        let options: Vec<String> = ["--jobs=1".to_string()].into_iter().chain(flags).chain(set).collect();
        return super::engine::submit(&args.engine, &study, &dir, &options, args.how.accept_build);
    }
    args.engine.check_local()?;
    let (relay, _served) = super::live::listen(args.live, args.port)?.and_then(super::live::relay).unzip();
    let done = execute(&study, &args.how, args.vtu, relay.as_ref())?;
    let extension = match &done.end {
        End::Report(summary) => summary.extension.as_ref(),
        _ => None,
    };
    let Some(extension) = extension.filter(|_| args.extend) else {
        if args.extend {
            tell!("nothing is added: there is a verdict, or no family whose meshes can be refined by their keys");
        }
        return done.tell(&args.how, &args.study);
    };
    let file_of_added = AddedMeshes::file(&dir);
    folder::write(&file_of_added, &AddedMeshes::read(&dir)?.with(extension).text())?;
    tell!("added: {} to family {}, in {}", extension.member, extension.family, file_of_added.display());
    let how = How { redo: false, ..args.how };
    execute(&Study::read_with_added(&file, &changes, &dir)?, &how, args.vtu, relay.as_ref())?.tell(&how, &args.study)
}

/// Options of the command line on how a study is run.
#[derive(clap::Args)]
pub struct How {
    /// Folder of the results [default: reports/<study>]
    #[arg(long)]
    out: Option<PathBuf>,
    /// Cases that run at the same time [default: one per core; use 1 for undisturbed costs]; if fewer are left, a case uses several threads
    #[arg(long, value_parser = super::arguments::threads)]
    jobs: Option<usize>,
    /// Memory that the cases may take together, e.g. "8 GB" [default: 90 % of the available memory]; a case waits until it fits
    #[arg(long, value_parser = super::arguments::memory)]
    memory: Option<u64>,
    /// Also rerun cases that are done
    #[arg(long)]
    redo: bool,
    /// Keep results of the same inputs that another build of this program computed; the report names them
    #[arg(long)]
    accept_build: bool,
    /// Only cases whose id contains this text
    #[arg(long, value_name = "CASE")]
    only: Option<String>,
    /// Only the cases of the K-th of N parts, by the hash of their ids, so that several runs into one folder can share a study. No report is written
    #[arg(long, value_name = "K/N", conflicts_with = "only")]
    partition: Option<Partition>,
    /// Only the cases on the K-th line of FILE, ids separated by spaces: a task of a scheduler. No report is written
    #[arg(long, value_name = "FILE:K", conflicts_with_all = ["only", "partition"])]
    batch: Option<String>,
    /// Print summary.json instead of progress
    #[arg(long)]
    json: bool,
}

impl How {
    /// Returns the folder of the results of a study of this name.
    fn dir(&self, study: &str) -> PathBuf {
        self.out.clone().unwrap_or_else(|| PathBuf::from("reports").join(study))
    }

    /// Returns the folder of the results of the study `study` in this file. A folder with the results of another command is refused; the default folder
    /// is also refused if it holds results of another study of the same name.
    pub fn dir_of(&self, study: &str, file: &Path) -> Result<PathBuf, HeldError> {
        let dir = self.dir(study);
        check_folder(&dir, file, self.out.is_none())?;
        Ok(dir)
    }

    /// Refuses a folder with results of another study, which the run would replace.
    pub fn check(&self, study: &Study) -> Result<(), HeldError> {
        check(study, &self.dir(&study.name))
    }

    /// Returns the selected cases; `None` if all are selected.
    fn only(&self, study: &Study) -> Result<Option<Only>, batches::BatchError> {
        if let Some(batch) = &self.batch {
            let known = study.cases.iter().map(|c| c.id.as_str()).collect();
            return Ok(Some(Only::Listed(batches::read(batch, &known)?)));
        }
        Ok(self.partition.map(Only::Partition).or_else(|| self.only.as_deref().map(Only::from)))
    }
}

/// A study that was run.
pub struct Done {
    dir: PathBuf,
    end: End,
    records: Vec<CaseRecord>,
}

/// Ending of the message on a part of a study that searches for further cases.
const SEARCH_WAITS: &str =
    "; the search for further cases waits for a run of the study without --partition, once all parts are done";

/// How the run of a study ended.
enum End {
    Stopped,
    /// One part of several is done
    Part {
        part: Only,
        /// Cases of this part that wait for the results of others
        waiting: usize,
        /// Whether further cases may follow from the results of all parts
        searching: bool,
        /// Whether a case that did not converge is a result of its own
        keep_refusals: bool,
    },
    /// All cases crashed, and have earlier results of other inputs
    NoResult,
    Report(Box<Summary>),
}

/// Runs the cases of a study, with fields for ParaView if `vtu` is set and a live view if there is a relay, and writes its report.
pub fn execute(
    study: &Study,
    how: &How,
    vtu: bool,
    relay: Option<&Arc<Relay>>,
) -> Result<Done, Box<dyn std::error::Error>> {
    let dir = how.dir(&study.name);
    let stop = super::interrupt::stop_flag();
    let mut options = Options {
        jobs: how.jobs.unwrap_or_else(threads::available),
        redo: how.redo,
        redo_registered: true,
        accept_build: how.accept_build,
        only: how.only(study)?,
        vtu,
        isolation: Isolation::Processes(Launch::running()?),
        memory: how.memory,
        stop,
    };
    let wanted = study.cases.iter().filter(|c| options.wants(&c.id)).count();
    // More jobs than cases are only useful up to the number of cores: a case takes several threads if few cases are left
    options.jobs = options.jobs.min(wanted.max(threads::available()));
    let jobs = options.jobs;
    let (expected, only, at) = (study.clone(), options.only.clone(), dir.clone());
    let wants = move |id: &str| only.as_ref().is_none_or(|only| only.takes(id));
    let mut bars = Bars::of(wanted, how.json, move || TimeLeft::of(&expected, &at, &wants, jobs));
    bars.relay = relay.cloned();
    let records = growing::run_study(study, &dir, &options, &bars)?;
    if stop.load(Ordering::Relaxed) {
        tell!("{}", words_of_stop(study, &dir, &options, (records.len(), wanted)));
        return Ok(Done { dir, end: End::Stopped, records });
    }
    let end = match options.only.filter(Only::is_part) {
        Some(part) => {
            let (waiting, keep_refusals) = (wanted - records.len(), study.rules.keep_refusals);
            End::Part { part, waiting, searching: growing::is_open(study, &dir), keep_refusals }
        }
        None => match report::write_report(&dir) {
            Ok(summary) => End::Report(summary.into()),
            // No case has a result that counts: the crashed cases are reported, and that earlier results are in their place
            Err(ReportError::NoCases { .. }) if records.iter().any(CaseRecord::broke) => End::NoResult,
            Err(why) => return Err(why.into()),
        },
    };
    if stop.load(Ordering::Relaxed) {
        tell!("stopped: all cases are finished; run again for a report that is surely whole");
        return Ok(Done { dir, end: End::Stopped, records });
    }
    Ok(Done { dir, end, records })
}

/// Returns the message on the results that a stopped run leaves, after `taken` of the `wanted` cases.
fn words_of_stop(study: &Study, dir: &Path, options: &Options, (taken, wanted): (usize, usize)) -> String {
    let counts = |state| state == State::Stored || (options.accept_build && state == State::OtherBuild);
    let is_kept = |c: &Listed| options.wants(&c.id) && counts(c.state);
    let (kept, place) = (list(study, dir).into_iter().filter(is_kept).count(), dir.display());
    match options.redo {
        true => format!(
            "stopped: {taken} of {wanted} cases were run again; {kept} have a result in {place}, also those that were not: run without --redo to \
             go on from these"
        ),
        false => format!("stopped: {kept} of {wanted} cases are finished and kept in {place}; run again to go on"),
    }
}

impl Done {
    /// Prints the verdict, or `summary.json`, and names the incomplete cases. Commands in the verdict name the study as `study`, the path that was given.
    pub fn tell(&self, how: &How, study: &Path) -> CommandResult {
        let failed = |only_broken: bool| -> Vec<String> {
            let has_failed = |r: &&CaseRecord| if only_broken { r.broke() } else { !r.converged() };
            self.records.iter().filter(has_failed).map(CaseRecord::end).collect()
        };
        let (text, missing) = match &self.end {
            End::Stopped => return Ok(Outcome::Interrupted),
            End::NoResult => {
                let fact = "no case has a result of the present inputs; the report is an earlier one".to_string();
                let text = if how.json { serde_json::json!({ "without_result": fact }).to_string() } else { fact };
                (text, failed(false))
            }
            End::Part { part, waiting, searching, keep_refusals } => {
                let (part, cases) = (part.to_string(), self.records.len());
                let text = match how.json {
                    true => {
                        serde_json::json!({ "part": part, "cases": cases, "waiting": waiting, "searching": searching })
                            .to_string()
                    }
                    false => {
                        let search = if *searching { SEARCH_WAITS } else { "" };
                        format!("\n{part}: {cases} cases are done{}{search}", Self::words_of_waiting(*waiting))
                    }
                };
                (text, failed(*keep_refusals))
            }
            End::Report(summary) => {
                let text = match how.json {
                    true => serde_json::to_string_pretty(summary)?,
                    false => {
                        let add = ADD.replace("STUDY", &study.display().to_string());
                        let (verdict, page) = (summary.verdict.replace(ADD, &add), self.dir.join("index.html"));
                        format!("\n{verdict}\n\nreport: {}", page.display())
                    }
                };
                (text, summary.incomplete(&self.records))
            }
        };
        say!("{text}");
        if let End::Report(summary) = &self.end
            && !how.json
        {
            summary.warnings.iter().for_each(|warning| tell!("warning: {warning}"));
        }
        missing.iter().for_each(|why| tell!("not complete: {why}"));
        let sound = match &self.end {
            End::Report(summary) => soundness(summary),
            _ => Outcome::Complete,
        };
        Ok(if missing.is_empty() { sound } else { Outcome::RunIncomplete })
    }

    fn words_of_waiting(waiting: usize) -> String {
        match waiting {
            0 => String::new(),
            n => format!(
                "; {n} wait for results of other parts: run this part again, or the whole study, when those are there"
            ),
        }
    }
}
