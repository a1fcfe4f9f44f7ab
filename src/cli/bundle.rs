//! `durometer bundle …`

use super::files;
use super::outcome::{CommandResult, Outcome};
use durometer::catalogue::Launch;
use durometer::study::bundle::{Bundle, open, write};
use durometer::study::expand::Study;
use std::path::{Path, PathBuf};

/// Publish a study: inputs, results, environment and checksums in one folder, from which it runs again
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer bundle write finger-convergence finger-convergence-crate --license https://creativecommons.org/licenses/by/4.0/
  durometer bundle rerun finger-convergence-crate

The folder is an RO-Crate 1.1. Results that are not those of the study as it is are refused (exit code 2).
Exit codes of rerun: those of run, then those of compare.")]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    Write(WriteArgs),
    Rerun(RerunArgs),
}

/// Write a bundle into a folder that does not exist yet
#[derive(clap::Args)]
struct WriteArgs {
    /// Name of a folder in studies/, or path of a study.toml
    study: PathBuf,
    /// Folder that is written
    out: PathBuf,
    /// Folder of the results [default: reports/<study>, as written by run, here or next to the study]
    #[arg(long)]
    results: Option<PathBuf>,
    /// Licence of the bundle: its URL, or words
    #[arg(long, default_value = "No licence is stated; ask the authors before you use it.")]
    license: String,
    /// Print what was written as JSON
    #[arg(long)]
    json: bool,
}

/// Verify a bundle, run its study again, and compare the results with those in the bundle
#[derive(clap::Args)]
struct RerunArgs {
    /// Folder of the bundle
    dir: PathBuf,
    /// Folder of the new results
    #[arg(long, default_value = "reports/rerun")]
    out: PathBuf,
    /// Let the bundle make meshes that are not stored in it: this runs programs in Python that the bundle brings
    #[arg(long)]
    with_mesher: bool,
}

pub fn main(args: Args) -> CommandResult {
    match args.command {
        Command::Write(args) => written(&args),
        Command::Rerun(args) => rerun(&args),
    }
}

fn written(args: &WriteArgs) -> CommandResult {
    let file = files::find(&args.study, "study.toml")?;
    let name = Study::read(&file, &[])?.name;
    let results = args.results.clone().map_or_else(|| results_of(&file, &name), Ok)?;
    let done = write(&file, &name, &results, &args.out, &args.license)?;
    if args.json {
        say!("{}", serde_json::to_string_pretty(&done)?);
    } else {
        say!("{} files, {:.1} MB: {}", done.files, 1e-6 * done.bytes as f64, args.out.display());
        for mesh in &done.without_mesh {
            tell!("note: the mesh {mesh} is not stored in the bundle; a rerun makes it again with --with-mesher");
        }
    }
    Ok(Outcome::Complete)
}

/// Finds the results of a study: where `run` writes them if it is called from the current folder, or else from the folder of the study.
fn results_of(file: &Path, name: &str) -> Result<PathBuf, String> {
    let here = Path::new("reports").join(name);
    let next_to_it = file.parent().unwrap_or(Path::new("")).join(&here);
    let places = if next_to_it == here { vec![here] } else { vec![here, next_to_it] };
    if let Some(found) = places.iter().find(|dir| dir.join("study.json").is_file()) {
        return Ok(found.clone());
    }
    let places: Vec<String> = places.iter().map(|dir| dir.display().to_string()).collect();
    let places = places.join(" or in ");
    Err(format!("there are no results of {name} in {places}; run the study, or name their folder by --results"))
}

fn rerun(args: &RerunArgs) -> CommandResult {
    let bundle = open(&args.dir)?;
    tell!("every file of the bundle is the one that was written");
    bundle.extend(&args.out)?;
    let mut run = Launch::running()?.command();
    run.arg("run").arg(&bundle.study).arg("--out").arg(&args.out);
    if let Bundle { home, has_bodies: true, .. } = &bundle {
        run.env("DUROMETER_HOME", std::path::absolute(home)?);
    }
    if !args.with_mesher {
        // An empty name disables the mesher: no program has it
        run.env("DUROMETER_PYTHON", "");
    }
    let status = run.status()?;
    match status.code() {
        Some(0) => {}
        Some(3) => return Ok(Outcome::RunIncomplete),
        _ => return Err("the run of the bundle was refused; its message is above".into()),
    }
    super::compare::told(&bundle.results, &args.out)
}
