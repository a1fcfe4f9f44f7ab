//! `durometer new NAME`

use super::files;
use super::outcome::{CommandResult, Outcome};
use durometer::study::starters::{STARTERS, create};
use std::path::{Path, PathBuf};

/// Make a project folder with a scene, a study and a page that explains what to do next
///
/// NAME is a starter (finger, pneunet, gripper), or a mesh, surface or CAD file: the body is then held at one end under its own weight, and the values to be replaced are marked. The project runs as it is.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer new finger
  durometer new gripper my-gripper
  durometer new robot.step --unit mm
  durometer new robot.step --cells 10000")]
pub struct Args {
    /// Name of a starter, or a file
    name: Option<String>,
    /// Folder of the project [default: named after the starter or the file]
    folder: Option<PathBuf>,
    /// Unit of length of the file, instead of a guess from the size
    #[arg(long)]
    unit: Option<String>,
    /// Number of cells of a surface or CAD file, instead of about 2000
    #[arg(long)]
    cells: Option<usize>,
}

pub fn main(args: Args) -> CommandResult {
    let Some(name) = args.name else {
        STARTERS.iter().for_each(|starter| say!("{:10} {}", starter.name, starter.summary));
        say!("{:10} any mesh, surface or CAD file: its shape, held at one end under its own weight", "FILE");
        return Ok(Outcome::Complete);
    };
    let file = files::brought(Path::new(&name))?;
    let how = (args.unit.as_deref(), args.cells);
    let folder = create(&file.to_string_lossy(), args.folder.as_deref(), how, &mut |line| tell!("{line}"))?;
    say!("{}: scene.toml, study.toml, README.md", folder.display());
    say!("next, in {}: durometer simulate scene.toml", folder.display());
    Ok(Outcome::Complete)
}
