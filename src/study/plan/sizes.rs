//! Choices of a plan: elements, and the meshes of the scene's body that are given, stored or can be made.

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
    /// `mesh.cells`, rising; none where the mesh is given
    pub sizes: Vec<u64>,
    /// Of the cells, without its formulation
    pub element: ElementSpec,
}

/// Where the meshes come from.
#[derive(serde::Serialize, Clone, Copy, Debug, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Meshes {
    /// The stored ones of the body
    Stored,
    /// Those, and what the mesher makes
    Made,
    /// One only: a volume mesh or a grid
    Given,
}

/// Cells of the coarsest mesh that is made where the body has one of so few, and the ratio of the next: h falls by 1.3, Roache's least.
const COARSEST: f64 = 600.0;
const RATIO: f64 = 2.2;
/// No mesh is planned beyond.
const MOST: f64 = 2e6;

/// The choices for a scene; stored meshes only, or also what the mesher makes.
pub fn choices(file: &Path, spec: &SceneSpec) -> Result<(Vec<Choice>, Meshes), PlanError> {
    if spec.mesh.body.is_none() && spec.mesh.cells.is_none() && spec.mesh.size.is_none() {
        return Ok((formulations(spec, spec.mesh.element, &[]), Meshes::Given));
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
        out.extend(formulations(spec, element, &sizes));
    }
    out.retain(|c| c.sizes.len() > 2);
    match out.is_empty() {
        true => Err(PlanError::FewMeshes { file: file.into() }),
        false => Ok((out, meshes)),
    }
}

/// The element with and without a pressure field, on meshes of these sizes.
fn formulations(spec: &SceneSpec, element: ElementSpec, sizes: &[u64]) -> Vec<Choice> {
    let mut out = vec![];
    for mixed in [true, false] {
        let mut set = vec![];
        if !sizes.is_empty() {
            set.push(("mesh.element".to_string(), Value::from(element.name())));
        }
        let elastic = spec.effects.iter().enumerate().filter(|(_, e)| e.kind() == "elastic");
        let formulation = if mixed { "mixed" } else { "displacement" };
        let formulations: Vec<_> =
            elastic.map(|(k, _)| (format!("effect.{k}.formulation"), Value::from(formulation))).collect();
        if mixed && formulations.is_empty() {
            continue;
        }
        set.extend(formulations);
        let suffix = if mixed { "_up" } else { "" };
        out.push(Choice { name: format!("{}{suffix}", element.name()), set, sizes: sizes.to_vec(), element });
    }
    out
}

impl Choice {
    /// Starts at a mesh of so many cells, the fewest that the mesher reaches.
    pub fn start_at(&mut self, cells: u64) {
        let more = (1..).map(|k| (cells as f64 * RATIO.powi(k)).round());
        self.sizes = std::iter::once(cells).chain(more.take_while(|n| *n < MOST).map(|n| n as u64)).collect();
    }

    /// The changes that make a scene of it.
    pub fn changes(&self, cells: u64) -> Vec<(String, Value)> {
        self.set.iter().cloned().chain(self.size(cells)).collect()
    }

    /// The change of the size alone; none where the mesh is given.
    pub fn size(&self, cells: u64) -> Option<(String, Value)> {
        (!self.sizes.is_empty()).then(|| ("mesh.cells".to_string(), Value::Integer(cells as i64)))
    }

    /// So many cells of it; those of a given mesh are not a choice.
    pub fn words(&self, cells: u64) -> String {
        if self.sizes.is_empty() { self.name.clone() } else { format!("{}, {cells} cells", self.name) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_start_at_the_least_that_the_mesher_reaches() {
        let mut choice =
            Choice { name: "tet10_up".into(), set: vec![], sizes: vec![600, 1320], element: ElementSpec::Tet10 };
        choice.start_at(2724);
        assert_eq!(choice.sizes[..3], [2724, 5993, 13_184]);
        assert!(choice.sizes.iter().all(|n| (*n as f64) < MOST) && choice.sizes.len() > 4, "{:?}", choice.sizes);
    }
}
