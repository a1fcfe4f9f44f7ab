//! `durometer run STUDY --engine …`: a study run by the scheduler of a cluster.

use super::outcome::{CommandResult, Outcome};
use durometer::catalogue::Launch;
use durometer::math::units::{self, Dimension};
use durometer::mesh::generate::{MeshStore, interpreter};
use durometer::study::engine::batches::{Packing, pack};
use durometer::study::engine::{EngineFile, Requests, Submission, hyperqueue, slurm};
use durometer::study::expand::Study;
use durometer::study::listing::{Listed, State, list, prepare};
use durometer::study::store::folder::Store;
use std::path::Path;

/// Ratio of the memory of a case in the list of cases to the size of its scene text; 9 was measured with 100 000 cases.
const TEXT_FACTOR: u64 = 16;
const GIB: f64 = 1024.0 * 1024.0 * 1024.0;

/// The program that decides where and when cases run.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// This process
    Local,
    /// Array jobs of Slurm
    Slurm,
    /// A job of HyperQueue
    Hyperqueue,
}

/// Flags of cases that run here. Every option of an engine conflicts with them, because clap no longer requires an argument that conflicts with a given
/// one, such as `--engine`.
const HERE: [&str; 6] = ["only", "partition", "batch", "redo", "extend", "jobs"];

/// How a scheduler runs a study, from the command line.
#[derive(clap::Args)]
#[command(next_help_heading = "Options of an engine")]
pub struct EngineArgs {
    /// Run the cases here, or submit them to a scheduler and return
    #[arg(long, value_enum, default_value = "local", conflicts_with_all = HERE)]
    pub engine: Engine,
    /// Print the files of the engine, and submit nothing
    #[arg(long, requires = "engine", conflicts_with_all = HERE)]
    dry_run: bool,
    /// Option of the scheduler, e.g. --engine-option=--partition=long (for sbatch, or for hq before its command); may be repeated
    #[arg(long, value_name = "OPTION", allow_hyphen_values = true, requires = "engine", conflicts_with_all = HERE)]
    engine_option: Vec<String>,
    /// Shell command that is run before each task, e.g. "module load gcc"; may be repeated
    #[arg(long, value_name = "LINE", requires = "engine", conflicts_with_all = HERE)]
    before: Vec<String>,
    /// Expected time of a task; cases are packed into a task up to this time
    #[arg(long, value_name = "TIME", default_value = "60 min", requires = "engine", conflicts_with_all = HERE)]
    task_time: String,
    /// Largest number of tasks
    #[arg(long, value_name = "N", default_value = "1000", requires = "engine", conflicts_with_all = HERE, value_parser = super::arguments::at_least_one)]
    tasks: usize,
    /// Expected time of a case for which no stored result gives an estimate
    #[arg(long, value_name = "TIME", default_value = "10 min", requires = "engine", conflicts_with_all = HERE)]
    case_time: String,
    /// Expected memory of such a case, and of the report, in GiB
    #[arg(long, value_name = "GIB", default_value = "2", requires = "engine", conflicts_with_all = HERE)]
    case_memory: f64,
    /// Ratio of the requested to the expected time
    #[arg(long, value_name = "FACTOR", default_value = "2", requires = "engine", conflicts_with_all = HERE)]
    time_factor: f64,
    /// Ratio of the requested to the expected memory; 0 requests no memory
    #[arg(long, value_name = "FACTOR", default_value = "1.5", requires = "engine", conflicts_with_all = HERE)]
    memory_factor: f64,
}

impl EngineArgs {
    /// Refuses options of a scheduler for cases that run here.
    pub fn check_local(&self) -> Result<(), String> {
        numbers(self)?;
        match self.dry_run {
            true => Err("--dry-run prints the files of a scheduler; name it, --engine slurm, or leave it out".into()),
            false => Ok(()),
        }
    }
}

/// Parses the numbers of the options.
fn numbers(args: &EngineArgs) -> Result<(Packing, Requests), String> {
    let time = |name: &str, text: &str| {
        let seconds = units::parse(text, Dimension::TIME).map_err(|e| format!("--{name}: {e}"))?;
        let sound = seconds.is_finite() && seconds > 0.0;
        if sound {
            Ok(seconds)
        } else {
            Err(format!("--{name}: it is {seconds} s; give a positive time, for example \"60 min\""))
        }
    };
    let at_least = |name: &str, value: f64, least: f64| match value.is_finite() && value >= least {
        true => Ok(value),
        false => Err(format!("--{name}: it is {value}; give {least} or more")),
    };
    let case_bytes = (at_least("case-memory", args.case_memory, 0.0)? * GIB) as u64;
    let packing = Packing {
        batch_s: time("task-time", &args.task_time)?,
        most: args.tasks,
        unknown_s: time("case-time", &args.case_time)?,
        unknown_bytes: case_bytes,
    };
    let requests = Requests {
        time_factor: at_least("time-factor", args.time_factor, 1.0)?,
        memory_factor: at_least("memory-factor", args.memory_factor, 0.0)?,
        report_bytes: case_bytes,
        options: args.engine_option.clone(),
        before: args.before.clone(),
    };
    Ok((packing, requests))
}

/// Submits the cases of a study that have no result. `options` are the options of `run` that every task gets.
pub fn submit(args: &EngineArgs, study: &Study, dir: &Path, options: &[String], accept_build: bool) -> CommandResult {
    let (packing, requests) = numbers(args)?;
    if !args.dry_run {
        // Meshes are made once, here: otherwise every task that needs a mesh would make it
        prepare(study, &mut |case, line| tell!("{case}: mesher: {line}"))?;
    }
    let cases = list(study, dir);
    let counts = |c: &&Listed| c.state != State::Stored && !(accept_build && c.state == State::OtherBuild);
    let wanted: Vec<&Listed> = cases.iter().filter(counts).collect();
    if wanted.is_empty() {
        say!("all {} cases are stored; durometer report {} draws the report", cases.len(), dir.display());
        return Ok(Outcome::Complete);
    }
    let absolute = |path: &Path| std::path::absolute(path).map_err(|e| format!("{}: {e}", path.display()));
    let words = |path: &Path| absolute(path).map(|p| p.to_string_lossy().into_owned());
    let Launch { file, arguments } = Launch::lasting()?;
    let first = arguments.iter().map(|argument| argument.to_string_lossy().into_owned());
    let (program, place): (Vec<String>, _) = ([words(&file)?].into_iter().chain(first).collect(), words(dir)?);
    let own = ["run".into(), words(&study.file)?, "--out".into(), place.clone()];
    let run = [&program, own.as_slice(), options].concat();
    let submission = Submission {
        study: study.name.clone(),
        dir: absolute(dir)?,
        folder: std::env::current_dir()?,
        run,
        report: [program, vec!["report".into(), place]].concat(),
        list_bytes: TEXT_FACTOR * study.cases.iter().map(|c| c.text.len() as u64).sum::<u64>(),
        groups: pack(wanted.iter().copied(), packing),
        requests,
    };
    if args.dry_run {
        show(&match args.engine {
            Engine::Hyperqueue => hyperqueue::files(&submission)?,
            _ => slurm::files(&submission, slurm::max_array_size().unwrap_or(slurm::MAX_ARRAY_SIZE))?,
        });
        return Ok(Outcome::Complete);
    }
    let store = Store::open(dir)?;
    store.describe(&study.record)?;
    // A report must not mix results of other inputs with new ones, whichever tasks complete
    for case in cases.iter().filter(|c| c.state != State::Unmeshed) {
        store.compare_inputs(&case.id, case.identity.as_deref())?;
    }
    let said = match args.engine {
        Engine::Hyperqueue => {
            // The same Python as that of the mesher, also where the project is not found
            let python = MeshStore::find().map_or_else(|_| interpreter::of_system(), |store| store.python);
            hyperqueue::submit(&submission, &python)?
        }
        _ => {
            let jobs = slurm::submit(&submission)?;
            format!("jobs {}, of which the last draws the report", jobs.join(", "))
        }
    };
    let tasks: usize = submission.groups.iter().map(|g| g.batches.len()).sum();
    say!("submitted: {} of {} cases in {tasks} tasks: {said}", wanted.len(), cases.len());
    say!("results: {}; files and logs of the engine: {}", dir.display(), submission.place().display());
    Ok(Outcome::Complete)
}

fn show(files: &[EngineFile]) {
    for EngineFile { name, text } in files {
        say!("==> {name} <==\n{text}");
    }
}
