//! `durometer store …`

use super::outcome::{CommandResult, Outcome};
use durometer::math::units::{self, Dimension};
use durometer::study::store::archive::{ImportOptions, export, import};
use durometer::study::store::case_files::Unsound;
use durometer::study::store::upkeep::{clean, verify};
use std::path::PathBuf;
use std::time::Duration;

/// Maintain a folder of results: verify it, clean it, move it to another machine
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer store verify reports/finger-convergence
  durometer store gc reports/finger-convergence --dry-run
  durometer store export reports/finger-convergence results.tar.gz
  durometer store import results.tar.gz reports/finger-convergence

Exit codes: 0 done, 2 bad input, 3 a stored result is damaged, or differs from that of the archive.")]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    Verify(VerifyArgs),
    Gc(GcArgs),
    Export(ExportArgs),
    Import(ImportArgs),
}

/// Compare every stored file with its stored digest, and name those that differ
#[derive(clap::Args)]
struct VerifyArgs {
    /// Folder of the results
    dir: PathBuf,
    /// Print an object with `sound`, `missing` and `damaged`
    #[arg(long)]
    json: bool,
}

/// Remove files that belong to no case of the study, and leftovers of killed runs
///
/// Unknown files are listed and kept.
#[derive(clap::Args)]
struct GcArgs {
    /// Folder of the results
    dir: PathBuf,
    /// List what would be removed, and remove nothing
    #[arg(long)]
    dry_run: bool,
    /// Age after the last change at which half-written files, locks and set-aside records are removed
    #[arg(long, value_name = "TIME", default_value = "60 min")]
    older_than: String,
    /// Print an object with `removed` and `unknown`
    #[arg(long)]
    json: bool,
}

/// Write all sound results into one archive; the same results give the same bytes
#[derive(clap::Args)]
struct ExportArgs {
    /// Folder of the results
    dir: PathBuf,
    /// Archive that is written, e.g. results.tar.gz
    archive: PathBuf,
}

/// Merge the results of an archive into a folder, after verifying all of it
#[derive(clap::Args)]
struct ImportArgs {
    /// Archive that `durometer store export` has written
    archive: PathBuf,
    /// Folder of the results; it is created if it does not exist
    dir: PathBuf,
    /// If results of a case differ, take that of the archive, with its study
    #[arg(long)]
    replace: bool,
    /// Largest size of the unpacked archive in GiB
    #[arg(long, value_name = "GIB", default_value = "64")]
    limit: u64,
    /// Print an object with `added`, `kept`, `replaced`, `conflicts`, and, if not empty, `removed`
    #[arg(long)]
    json: bool,
}

pub fn main(args: Args) -> CommandResult {
    match args.command {
        Command::Verify(args) => verified(&args),
        Command::Gc(args) => cleaned(&args),
        Command::Export(args) => exported(&args),
        Command::Import(args) => imported(&args),
    }
}

fn verified(args: &VerifyArgs) -> CommandResult {
    let found = verify(&args.dir)?;
    if args.json {
        say!("{}", serde_json::to_string_pretty(&found)?);
    } else {
        say!("{} cases are sound, {} have no result", found.sound, found.missing.len());
    }
    Ok(told(&found.damaged))
}

/// Prints the damaged files.
fn told(damaged: &[Unsound]) -> Outcome {
    for Unsound { file, fact } in damaged {
        tell!("damaged: {file}: {fact}; run the study again, the other cases are kept");
    }
    if damaged.is_empty() { Outcome::Complete } else { Outcome::NotSound }
}

fn cleaned(args: &GcArgs) -> CommandResult {
    let age = units::parse(&args.older_than, Dimension::TIME).map_err(|e| format!("--older-than: {e}"))?;
    let age = Duration::try_from_secs_f64(age)
        .map_err(|_| format!("--older-than: it is {age} s; give a time of 0 s or more, for example \"60 min\""))?;
    let done = clean(&args.dir, age, args.dry_run)?;
    if args.json {
        say!("{}", serde_json::to_string_pretty(&done)?);
        return Ok(Outcome::Complete);
    }
    let verb = if args.dry_run { "would be removed" } else { "removed" };
    done.removed.iter().for_each(|r| say!("{verb}: {} ({} bytes): {}", r.file, r.bytes, r.why));
    done.unknown.iter().for_each(|file| say!("unknown, stays: {file}"));
    let bytes: u64 = done.removed.iter().map(|r| r.bytes).sum();
    say!("{} files, {bytes} bytes {verb}", done.removed.len());
    Ok(Outcome::Complete)
}

fn exported(args: &ExportArgs) -> CommandResult {
    let done = export(&args.dir, &args.archive)?;
    say!("{}: {} cases, {} files, {} bytes unpacked", args.archive.display(), done.cases, done.files, done.bytes);
    if done.missing > 0 {
        tell!("note: {} cases of the study have no result", done.missing);
    }
    if !done.outdated.is_empty() {
        tell!("left out: {}: of other inputs than the study has now", done.outdated.join(", "));
    }
    let told = told(&done.damaged);
    Ok(if done.cases == 0 { Outcome::NotSound } else { told })
}

fn imported(args: &ImportArgs) -> CommandResult {
    let limit = args.limit.saturating_mul(1 << 30);
    let done = import(&args.archive, &args.dir, ImportOptions { replace: args.replace, limit })?;
    if args.json {
        say!("{}", serde_json::to_string_pretty(&done)?);
    } else {
        say!("{} cases added, {} kept, {} replaced", done.added.len(), done.kept, done.replaced.len());
    }
    for name in &done.removed {
        tell!("removed: {name}: the study of the archive has no cases that were added there");
    }
    for conflict in &done.conflicts {
        tell!("conflict: {}: {}; that of the folder is kept", conflict.what, conflict.fact);
    }
    if !done.conflicts.is_empty() && !args.replace {
        tell!("take those of the archive with --replace, or import it into another folder");
    }
    Ok(if done.conflicts.is_empty() { Outcome::Complete } else { Outcome::NotSound })
}
