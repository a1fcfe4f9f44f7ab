//! Choices of a plan: elements, and the meshes of the scene's body that are stored or can be made.

use crate::mesh::generate::MeshStore;
use crate::scene::{ElementSpec, SceneSpec, request};
use crate::study::plan::error::PlanError;
use std::path::Path;
use toml::Value;

/// An element with its formulation, and the meshes it may have.
#[derive(Clone, Debug)]
pub struct Choice {
    /// `tet10_up`
    pub name: String,
    /// Changes to the scene, by path
    pub set: Vec<(String, Value)>,
    /// `mesh.cells`, rising
    pub sizes: Vec<u64>,
}

/// Where the meshes come from.
#[derive(serde::Serialize, Clone, Copy, Debug, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Meshes {
    /// The stored ones of the body
    Stored,
    /// Those, and what the mesher makes
    Made,
}

/// Cells of the coarsest mesh that is made, and the ratio of the next: h falls by 1.3, Roache's least.
const COARSEST: f64 = 600.0;
const RATIO: f64 = 2.2;
/// No mesh is planned beyond.
const MOST: f64 = 2e6;

/// The choices for a scene; stored meshes only, or also what the mesher makes.
pub fn choices(file: &Path, spec: &SceneSpec) -> Result<(Vec<Choice>, Meshes), PlanError> {
    if spec.mesh.body.is_none() && spec.mesh.cells.is_none() && spec.mesh.size.is_none() {
        return Err(PlanError::OneMesh { file: file.into() });
    }
    if spec.mesh.size.is_some() {
        return Err(PlanError::EdgeLength { file: file.into() });
    }
    let store = MeshStore::find().map_err(|e| PlanError::Mesh(e.to_string()))?;
    let able = store.mesher().diagnose().iter().all(|c| c.ok || c.optional);
    let meshes = if able { Meshes::Made } else { Meshes::Stored };
    let mut out = vec![];
    for element in [ElementSpec::Tet4, ElementSpec::Tet10] {
        let mut mesh = spec.mesh.clone();
        (mesh.element, mesh.size, mesh.cells) = (element, None, Some(COARSEST as usize));
        let request = request(file, &mesh)?;
        let mut sizes = store.stored_sizes(&request).map_err(|e| PlanError::Mesh(e.to_string()))?;
        if able {
            // A generated mesh next to a stored one of nearly its size would be no new level
            let mut cells = COARSEST;
            while cells < MOST {
                if sizes.iter().all(|s| (*s as f64 / cells).ln().abs() > 0.5 * RATIO.ln()) {
                    sizes.push(cells.round() as u64);
                }
                cells *= RATIO;
            }
            sizes.sort_unstable();
        }
        for mixed in [true, false] {
            let mut own = vec![("mesh.element".to_string(), Value::from(element.name()))];
            let elastic = spec.effects.iter().enumerate().filter(|(_, e)| e.kind() == "elastic");
            let formulation = if mixed { "mixed" } else { "displacement" };
            let formulations: Vec<_> =
                elastic.map(|(k, _)| (format!("effect.{k}.formulation"), Value::from(formulation))).collect();
            if mixed && formulations.is_empty() {
                continue;
            }
            own.extend(formulations);
            let suffix = if mixed { "_up" } else { "" };
            out.push(Choice { name: format!("{}{suffix}", element.name()), set: own, sizes: sizes.clone() });
        }
    }
    out.retain(|c| c.sizes.len() > 2);
    match out.is_empty() {
        true => Err(PlanError::FewMeshes { file: file.into() }),
        false => Ok((out, meshes)),
    }
}

impl Choice {
    /// The changes that make a scene of it.
    pub fn changes(&self, cells: u64) -> Vec<(String, Value)> {
        let cells = ("mesh.cells".to_string(), Value::Integer(cells as i64));
        self.set.iter().cloned().chain([cells]).collect()
    }
}
