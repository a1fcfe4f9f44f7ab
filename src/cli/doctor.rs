//! `durometer doctor`

use super::outcome::{CommandResult, Outcome};
use durometer::mesh::generate::MeshStore;

/// Say what is missing on this machine, with the exact commands
///
/// Only new meshes need it: committed meshes and all solving work without.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer doctor             what is there, and the command for what is not
  durometer doctor --setup     make .venv in the project and install the mesher into it

Exit codes: 0 new meshes can be made, 2 something is missing.")]
pub struct Args {
    /// Set the mesher's environment up: .venv with the pinned versions of gmsh, CGAL and meshio
    #[arg(long)]
    setup: bool,
}

pub fn main(args: Args) -> CommandResult {
    let mut store = MeshStore::find()?;
    if args.setup {
        store.mesher().setup_environment(&mut |line| eprintln!("{line}"))?;
        store = MeshStore::find()?;
    }
    let mut sound = true;
    for check in store.mesher().diagnose() {
        let mark = match (check.ok, check.optional) {
            (true, _) => "ok     ",
            (false, true) => "absent ",
            (false, false) => "MISSING",
        };
        println!("{mark} {:24} {}", check.what, check.detail);
        if let Some(remedy) = check.remedy.filter(|_| !check.ok) {
            println!("        run: {remedy}");
        }
        sound &= check.ok || check.optional;
    }
    if !sound {
        println!("\nOnly new meshes need what is missing: studies on stored meshes run without it.");
    }
    Ok(if sound { Outcome::Complete } else { Outcome::NotReady })
}
