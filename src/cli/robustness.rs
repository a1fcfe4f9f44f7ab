//! `durometer robustness [SCENE]`

use super::files;
use super::outcome::CommandResult;
use super::run::{How, execute};
use durometer::study::expand::Study;
use durometer::study::kind::StudyScope;
use std::path::{Path, PathBuf};

/// Map where a scene gives correct answers over time step, load, Poisson's ratio, mesh and start
///
/// Every answer is compared with the answer at the smallest time step. Without a scene, the study hard-cases is run: scenes that
/// break simulators. The study of a scene is called robustness-<scene>.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer robustness my-scene.toml
  durometer robustness finger-dynamics --only map-dt-load
  durometer robustness --quick                        half of the hard cases, without their maps, in about half a minute

Exit codes: 0 no case failed (a stated reason is the right end of some), 2 bad input, 3 a case failed or Ctrl-C stopped the run.")]
pub struct Args {
    /// Scene file (TOML), or the name of a folder in studies/
    scene: Option<PathBuf>,
    /// Only the quick half of the hard cases
    #[arg(long, conflicts_with = "scene")]
    quick: bool,
    /// Change a key of the scene, e.g. --set laws.rubber.nu=0.49
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    how: How,
}

pub fn main(args: Args) -> CommandResult {
    let changes = super::arguments::changes(&args.set)?;
    let scope = if args.quick { StudyScope::Quick } else { StudyScope::Whole };
    let study = match &args.scene {
        Some(scene) => Study::around(&files::find(scene, "scene.toml")?, &changes)?,
        None => Study::read_scope(&files::find(Path::new("hard-cases"), "study.toml")?, &changes, scope)?,
    };
    args.how.dir_of(&study.name, &study.file)?;
    args.how.check(&study)?;
    execute(&study, &args.how, false, None)?.tell(&args.how, &study.file)
}
