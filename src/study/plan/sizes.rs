//! Choices of a plan: elements, and the meshes of the body of the scene that are given, stored, or can be made.

use crate::mesh::generate::MeshStore;
use crate::scene::spec::GridSpec;
use crate::scene::{ElementSpec, SceneError, SceneSpec, request};
use crate::scene::{divisions_of_grid, divisions_value, mesh_of_grid, similar_grids};
use crate::study::plan::error::PlanError;
use std::collections::BTreeMap;
use std::path::Path;
use toml::Value;

/// An element with its formulation, and its possible meshes.
#[derive(Clone, Debug, Default)]
pub struct ElementMeshes {
    /// Short name: `tet10_up`
    pub name: String,
    /// Changes to the scene, by path
    pub set: Vec<(String, Value)>,
    /// Numbers of cells, increasing; empty if the mesh is given
    pub sizes: Vec<u64>,
    /// Number of cells → `mesh.grid.divisions`; empty if a mesher makes the mesh
    pub divisions: BTreeMap<u64, Value>,
    /// Element of the cells, without its formulation
    pub element: ElementSpec,
}

/// Origin of the meshes.
#[derive(serde::Serialize, Clone, Copy, Debug, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Meshes {
    /// The stored meshes of the body
    Stored,
    /// The stored meshes, and those that the mesher makes
    Made,
    /// Grids with the proportions of that of the scene
    Scaled,
    /// A single mesh: a volume mesh, or a grid without coarser ones
    Given,
}

/// Number of cells of the coarsest mesh, if the body has one with so few; for the next one h decreases by a factor of 1.3, the smallest ratio
/// recommended by Roache.
const COARSEST: f64 = 600.0;
const RATIO: f64 = 2.2;
/// Largest number of cells that is planned.
const MOST: f64 = 2e6;

/// The choices for a scene: grids with its proportions, stored meshes only, or also those that the mesher makes.
pub fn choices(file: &Path, spec: &SceneSpec) -> Result<(Vec<ElementMeshes>, Meshes), PlanError> {
    if let Some(grid) = spec.mesh.grid.as_ref().filter(|_| spec.mesh.parts.is_empty()) {
        let divisions = grids(file, grid, 8u64.saturating_pow(spec.mesh.levels))?;
        let sizes: Vec<u64> = divisions.keys().copied().collect();
        let all = [ElementSpec::Tet4, ElementSpec::Tet10].map(|element| formulations(spec, element, &sizes));
        let choices = all.into_iter().flatten().map(|choice| ElementMeshes { divisions: divisions.clone(), ..choice });
        return Ok(if sizes.len() > 2 { (choices.collect(), Meshes::Scaled) } else { (given(spec), Meshes::Given) });
    }
    if spec.mesh.body.is_none() && spec.mesh.cells.is_none() && spec.mesh.size.is_none() {
        return Ok((given(spec), Meshes::Given));
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
            // A generated mesh next to a stored one of nearly the same size would not be a new level
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

/// The choices on the mesh of a scene.
pub fn given(spec: &SceneSpec) -> Vec<ElementMeshes> {
    formulations(spec, spec.mesh.element, &[])
}

/// Number of cells → divisions of grids with the same proportions, each of whose cells is split into `parts`. From the largest grid of at most
/// [`COARSEST`] cells on, h decreases by a factor of at least 1.3.
fn grids(file: &Path, spec: &GridSpec, parts: u64) -> Result<BTreeMap<u64, Value>, SceneError> {
    let mut out = BTreeMap::new();
    let Some(first) = similar_grids(spec).next() else { return Ok(out) };
    let of_first = parts as f64 * mesh_of_grid(file, &first, ElementSpec::Tet4)?.cell_count() as f64;
    let along = |grid: &GridSpec| divisions_of_grid(grid)[0] as f64;
    let counted = |grid: &GridSpec| of_first * (along(grid) / along(&first)).powi(3);
    let mut last = 0.0;
    for grid in similar_grids(spec).take_while(|grid| counted(grid) < MOST) {
        let cells = counted(&grid);
        if cells <= COARSEST {
            out.clear();
        } else if cells < RATIO * last {
            continue;
        }
        last = cells;
        out.insert(cells.round() as u64, divisions_value(&grid));
    }
    Ok(out)
}

/// The element with and without a pressure field, on meshes of these sizes.
fn formulations(spec: &SceneSpec, element: ElementSpec, sizes: &[u64]) -> Vec<ElementMeshes> {
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
        let name = format!("{}{suffix}", element.name());
        out.push(ElementMeshes { name, set, sizes: sizes.to_vec(), element, divisions: BTreeMap::new() });
    }
    out
}

impl ElementMeshes {
    /// Starts the sizes at `cells`, the fewest that the mesher can make.
    pub fn start_at(&mut self, cells: u64) {
        let more = (1..).map(|k| (cells as f64 * RATIO.powi(k)).round());
        self.sizes = std::iter::once(cells).chain(more.take_while(|n| *n < MOST).map(|n| n as u64)).collect();
    }

    /// The changes that turn the scene into this choice.
    pub fn changes(&self, cells: u64) -> Vec<(String, Value)> {
        self.set.iter().cloned().chain(self.size(cells)).collect()
    }

    /// The change of the size alone; `None` if the mesh is given.
    pub fn size(&self, cells: u64) -> Option<(String, Value)> {
        match self.divisions.get(&cells) {
            Some(divisions) => Some(("mesh.grid.divisions".to_string(), divisions.clone())),
            None if self.sizes.is_empty() => None,
            None => Some(("mesh.cells".to_string(), Value::Integer(cells as i64))),
        }
    }

    /// Name of the choice with its number of cells; the name alone for a given mesh, whose size is not a choice.
    pub fn words(&self, cells: u64) -> String {
        if self.sizes.is_empty() { self.name.clone() } else { format!("{}, {cells} cells", self.name) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_start_at_the_least_that_the_mesher_reaches() {
        let mut choice = ElementMeshes {
            name: "tet10_up".into(),
            sizes: vec![600, 1320],
            element: ElementSpec::Tet10,
            ..ElementMeshes::default()
        };
        choice.start_at(2724);
        assert_eq!(choice.sizes[..3], [2724, 5993, 13_184]);
        assert!(choice.sizes.iter().all(|n| (*n as f64) < MOST) && choice.sizes.len() > 4, "{:?}", choice.sizes);
    }

    /// The coarsest grid has at most 600 cells, and each of the next at least 2.2 times as many as the one before.
    #[test]
    fn grids_have_the_proportions_of_that_of_the_scene() {
        let size = [0.1, 0.02, 0.02].map(crate::scene::Length);
        let of = |divisions| {
            let grids = grids(Path::new("scene.toml"), &GridSpec::Box { size, divisions }, 1).expect("a grid");
            grids.into_iter().take(5).map(|(cells, divisions)| (cells, divisions.to_string())).collect::<Vec<_>>()
        };
        let pair = |cells: u64, divisions: &str| (cells, divisions.to_string());
        let expected = [
            pair(240, "[10, 2, 2]"),
            pair(810, "[15, 3, 3]"),
            pair(1920, "[20, 4, 4]"),
            pair(6480, "[30, 6, 6]"),
            pair(15360, "[40, 8, 8]"),
        ];
        assert_eq!(of([20, 4, 4]), expected);
        assert_eq!(of([61, 31, 30]).len(), 1);
    }
}
