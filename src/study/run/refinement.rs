//! Adaptive meshes of the cases of a study. All of them are stored with the result, and their cost is part of its cost.

use crate::math::stopwatch::Spent;
use crate::scene::{Body, Progress, RefineError, RefinementStep, RefinementWatch, SceneSpec, refine};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::Arc;

/// One mesh of a refinement.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct RefinementRecord {
    /// File name of the mesh; empty in records of earlier versions
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub mesh: String,
    pub cells: usize,
    /// Value of the quantity that controls the refinement, in its unit
    pub value: f64,
    pub bar: f64,
    pub tolerance: f64,
    /// Parts of the error missing in the error bar, in words
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lacks: Option<String>,
    /// Wall time of run, estimate and next mesh \[s\]
    pub wall_s: f64,
    pub cpu_s: f64,
}

impl RefinementRecord {
    fn new(step: &RefinementStep) -> Self {
        let RefinementStep { mesh, cells, error, bar, tolerance, spent, .. } = step;
        let Spent { wall_s, cpu_s } = *spent;
        Self {
            mesh: mesh.clone(),
            cells: *cells,
            value: error.value,
            bar: *bar,
            tolerance: *tolerance,
            lacks: error.lacks(),
            wall_s,
            cpu_s,
        }
    }

    /// The wall and CPU time of run, estimate and next mesh.
    pub fn spent(&self) -> Spent {
        Spent { wall_s: self.wall_s, cpu_s: self.cpu_s }
    }
}

/// The body of a case, and the adaptive meshes that led to its mesh.
pub struct Prepared {
    pub body: Arc<Body>,
    /// Empty if the scene requests no refinement
    pub refinement: Vec<RefinementRecord>,
}

/// Prepares the body of a scene (file, specification, text), refined from `first` if the scene requests it.
pub fn refined(
    scene: (&Path, &SceneSpec, &str),
    first: Arc<Body>,
    mesher: &mut dyn FnMut(&str),
    go_on: &mut dyn FnMut(Progress) -> bool,
) -> Result<Prepared, RefineError> {
    let Some(wanted) = &scene.1.mesh.refine else {
        return Ok(Prepared { body: first, refinement: vec![] });
    };
    let mut watch = RefinementWatch { step: &mut |_| {}, mesher, progress: go_on, stop: None };
    let found = refine(scene, wanted, first, None, &mut watch)?;
    Ok(Prepared { body: found.body, refinement: found.steps.iter().map(RefinementRecord::new).collect() })
}

/// The note of a case if none of its meshes is within the tolerance.
pub fn note(steps: &[RefinementRecord]) -> Option<String> {
    let last = steps.last()?;
    if let Some(parts) = &last.lacks {
        return Some(format!(
            "the error bar of the last of {} adaptive meshes, {:.3e} with {} cells, is without {parts}, so that none is known to be within its tolerance {:.3e}",
            steps.len(),
            last.bar,
            last.cells,
            last.tolerance
        ));
    }
    if last.bar <= last.tolerance {
        return None;
    }
    let best = steps.iter().min_by(|a, b| a.bar.total_cmp(&b.bar))?;
    Some(format!(
        "the smallest error bar of {} adaptive meshes, {:.3e} with {} cells, is above its tolerance {:.3e}; allow more `meshes`",
        steps.len(),
        best.bar,
        best.cells,
        last.tolerance
    ))
}
