//! Reasons why there is no plan.

use crate::report::numbers::seconds;
use crate::scene::SceneError;
use crate::wording::all;
use std::path::PathBuf;

/// Reason why there is no plan.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    #[error(transparent)]
    Scene(Box<SceneError>),
    #[error("{}: mesh.size is given, and a plan chooses mesh.cells; replace it by `cells`", file.display())]
    EdgeLength { file: PathBuf },
    #[error("{}: fewer than three sizes of its body are stored, and the mesher is not installed; run: durometer doctor --setup", file.display())]
    FewMeshes { file: PathBuf },
    #[error("{0}")]
    Mesh(String),
    #[error("{}: {fact}", file.display())]
    Quantity { file: PathBuf, fact: String },
    #[error(
        "no element came through its pilots, three where meshes are chosen, within their share of the budget ({spent:.0} s spent, meshing included{}{}); raise --budget, or take a larger dt",
        ran(.done), told(.lost)
    )]
    FewPilots { spent: f64, done: Vec<(String, usize, f64)>, lost: Vec<(String, String)> },
    /// The time limit of the mesher came from the budget, not from the scene
    #[error("the mesher was ended after {}, which is all that the budget has left for it; raise --budget", seconds(*.after_s))]
    MeshLate { after_s: f64 },
    #[error("stopped")]
    Stopped,
}

/// The complete pilots: name, cells, CPU time \[s\].
fn ran(done: &[(String, usize, f64)]) -> String {
    let one = |(name, cells, cpu_s): &(String, usize, f64)| format!("{name} of {cells} cells in {}", seconds(*cpu_s));
    match done {
        [] => String::new(),
        done => format!("; complete: {}", all(&done.iter().map(one).collect::<Vec<_>>())),
    }
}

fn told(lost: &[(String, String)]) -> String {
    lost.iter().map(|(what, why)| format!("; {what}: {why}")).collect()
}

impl From<SceneError> for PlanError {
    fn from(error: SceneError) -> Self {
        Self::Scene(Box::new(error))
    }
}
