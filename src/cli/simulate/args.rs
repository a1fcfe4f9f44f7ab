//! Arguments of `durometer simulate`.

use super::controls::ControlArgs;
use crate::arguments::{self, changes};
use crate::files;
use durometer::scene::{SceneSpec, read_scene};
use std::path::PathBuf;

/// Run one scene and write its time series
///
/// Writes <name>.csv (what the probes record), <name>.signals.csv (what is prescribed), <name>.json (the
/// record, with the time each effect took), <name>.html (the motion in three dimensions, for a browser), and fields for ParaView on request.
///
/// A run that does not complete keeps everything up to its last good state. One that is killed, or finds the disk full, leaves its rows in
/// <name>.partial.csv and a state to restart from in <name>-partial.state.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer simulate studies/finger-dynamics/scene.toml
  durometer simulate my-scene.toml --set mesh.cells=9300 --out out
  durometer simulate my-scene.toml --set 'constraint.cable.drive={ kind = \"tension\", signal = \"2 N\" }' --vtu
  durometer simulate my-scene.toml --save-state \"0.5 s\" --save-state end
  durometer simulate my-scene.toml --restart reports/simulate/my-scene-0.5s.state
  durometer simulate my-scene.toml --controller \"python3 studies/finger-control/pi.py 30\"
  durometer simulate studies/finger-control/scene.toml --live --paused
  durometer simulate studies/finger-control/scene.toml --replay reports/simulate/scene.control.csv
  durometer simulate finger-gravity --sensitivity laws.silicone.E --sensitivity effect.gravity.direction.0

In --set and --sensitivity a step into a list is its index from 0, or the name or kind of an entry.
Exit codes: 0 converged, 2 bad input, 3 the run did not complete.")]
pub struct Args {
    /// Scene file (TOML), or the name of a folder in studies/
    pub(super) scene: PathBuf,
    /// Folder of the results
    #[arg(long, default_value = "reports/simulate")]
    pub(super) out: PathBuf,
    /// Change a key, e.g. --set mesh.cells=9300
    #[arg(long, value_name = "KEY=VALUE")]
    pub(super) set: Vec<String>,
    /// Write displacement and stretch at every point of the time grid as VTU, with a PVD collection; in ParaView, Warp By Vector with displacement_m
    /// deforms the grid
    #[arg(long)]
    pub(super) vtu: bool,
    /// Write <name>.sensitivities.csv: derivatives of positions, angles, reactions and cables with respect to a number of the scene, such as
    /// laws.rubber.mu or effect.gravity.density; may be repeated; not with implicit_euler_linearised or _corrected
    #[arg(long, value_name = "KEY", conflicts_with_all = ["save_state", "restart", "controller", "replay"])]
    pub(super) sensitivity: Vec<String>,
    /// Do not write <name>.html, the page that shows the motion in three dimensions
    #[arg(long)]
    pub(super) no_view: bool,
    /// Estimate the discretisation error of a recorded quantity (may be repeated), or of all; writes <name>.errors.csv. Solves again on an
    /// enriched mesh: a static scene at the times of the largest deviation, a path-dependent scene from the start
    #[arg(long, value_name = "COLUMN", num_args = 0..=1, default_missing_value = "all",
          conflicts_with_all = ["restart", "controller", "replay"])]
    pub(super) error: Vec<String>,
    /// With --error: show on the page where in the mesh the error comes from, by the colour of the cells; takes one adjoint solution per
    /// quantity. Not for path-dependent scenes
    #[arg(long, requires = "error", conflicts_with = "no_view")]
    pub(super) error_cells: bool,
    /// Save a state to restart from at a time ("0.5 s"), or at the `end`; may be repeated
    #[arg(long, value_name = "WHEN")]
    pub(super) save_state: Vec<String>,
    /// Continue from a saved state of this scene; the files are the same as those of an uninterrupted run
    #[arg(long, value_name = "FILE")]
    pub(super) restart: Option<PathBuf>,
    /// Wall-clock interval at which <name>-partial.state is saved; it is removed when the results are written
    #[arg(long, value_name = "TIME", default_value = "2 min")]
    pub(super) checkpoint: String,
    #[command(flatten)]
    pub control: ControlArgs,
    /// Show the run in a browser while it computes: serves a page on this machine only (127.0.0.1), at a printed address with a token.
    /// The page can pause the run, take single steps, and set the `controlled` signals of the scene, which are recorded in <name>.control.csv
    #[arg(long)]
    pub(super) live: bool,
    /// Port of the live view; 0 takes a free port
    #[arg(long, value_name = "N", default_value_t = 0, requires = "live")]
    pub(super) port: u16,
    /// With --live: wait at the first state until a page starts the run
    #[arg(long, requires = "live")]
    pub(super) paused: bool,
    /// Threads that the run may use [default: one per core]; the results do not depend on it
    #[arg(long, value_name = "N", value_parser = arguments::threads)]
    pub(super) threads: Option<usize>,
    /// Print the record instead of progress
    #[arg(long)]
    pub(super) json: bool,
}

impl Args {
    /// Reads the scene and applies the changes; returns its file, content and text.
    pub(super) fn read(&self) -> Result<(PathBuf, SceneSpec, String), Box<dyn std::error::Error>> {
        let file = files::find(&self.scene, "scene.toml")?;
        let (spec, text) = read_scene(&file, &changes(&self.set)?)?;
        Ok((file, spec, text))
    }
}
