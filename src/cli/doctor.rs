//! `durometer doctor`

use super::outcome::{CommandResult, Outcome};
use durometer::catalogue::{Home, Origin, archive, cache};
use durometer::mesh::generate::MeshStore;

/// Report what is missing on this machine, with the exact commands to install it
///
/// Only new meshes need the mesher: committed meshes and the solver work without it.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer doctor             what is there, and the command for what is not
  durometer doctor --setup     make the environment of the mesher and install its packages

Exit codes: 0 new meshes can be made, 2 something is missing.")]
pub struct Args {
    /// Set up the mesher's environment with the pinned versions of gmsh, CGAL and meshio: .venv in a project, otherwise in the cache
    #[arg(long)]
    setup: bool,
}

pub fn main(args: Args) -> CommandResult {
    let mut store = MeshStore::find()?;
    if args.setup {
        store.mesher().setup_environment(&mut |line| tell!("{line}"))?;
        store = MeshStore::find()?;
    }
    let mut sound = files(&store.home);
    for check in store.mesher().diagnose() {
        let mark = match (check.ok, check.optional) {
            (true, _) => "ok     ",
            (false, true) => "absent ",
            (false, false) => "MISSING",
        };
        say!("{mark} {:24} {}", check.what, check.detail);
        if let Some(remedy) = check.remedy.filter(|_| !check.ok) {
            say!("        run: {remedy}");
        }
        sound &= check.ok || check.optional;
    }
    if !sound {
        say!("\nOnly new meshes need what is missing: studies on stored meshes run without it.");
    }
    Ok(if sound { Outcome::Complete } else { Outcome::NotReady })
}

/// Prints where studies, bodies and meshes are taken from, and whether the program's own files are unmodified.
fn files(home: &Home) -> bool {
    let why = match home.origin {
        Origin::Named => "DUROMETER_HOME names this folder",
        Origin::Checkout => "the program was built in this folder",
        Origin::Program => "the files of the program, unpacked",
    };
    say!("ok      {:24} {} ({why})", "files", home.path.display());
    say!("ok      {:24} {}", "made meshes", home.meshes.display());
    let Some(archive) = archive().ok().filter(|_| home.origin == Origin::Program) else {
        return true;
    };
    let altered = cache::altered(&archive, &home.path);
    if !altered.is_empty() {
        say!("MISSING {:24} altered: {}", "files", altered.join(", "));
        say!("        run: rm -r {}", home.path.display());
    }
    for other in home.path.parent().map(|folder| cache::others(&archive, folder)).unwrap_or_default() {
        say!("ok      {:24} {} is of another version of the program; it may be deleted", "files", other.display());
    }
    altered.is_empty()
}
