//! The interface of a kind of selector to the scene.

use crate::mesh::error::point;
use crate::mesh::select::Pick;
use crate::mesh::{Region, TetMesh};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// Specification of a selector: the rule by which a region is found on a mesh.
pub(in crate::scene) trait SelectorPart {
    /// Names of the regions from which the region is made.
    fn of(&self) -> &[String] {
        &[]
    }

    /// Finds the entities of the region.
    fn find(&self, ground: &Ground) -> Result<SelectedEntities, Refusal>;

    /// The position of the region in words: `the sphere of radius 3 mm at (0, 0, 0) mm`.
    fn words(&self) -> String;

    /// Whether the region may contain all entities, because the file says so.
    fn may_be_everything(&self) -> bool {
        false
    }
}

/// Mesh and regions on which a selector works.
pub(in crate::scene) struct Ground<'a> {
    pub mesh: &'a TetMesh,
    /// How often each cell of a volume mesh from a file was split, which keeps the facets of the file; `None` for other meshes
    pub levels: Option<u32>,
    /// Folder of the scene, for relative paths
    pub base: &'a Path,
    /// Regions that are known so far
    pub regions: &'a BTreeMap<String, Region>,
}

/// Entities that a selector has found.
pub(in crate::scene) struct SelectedEntities {
    pub pick: Pick,
    /// Indices in ascending order, without repetition
    pub entities: Vec<u32>,
    /// Whether the extent differs on another mesh of the same body.
    pub depends_on_mesh: bool,
    /// A doubt about the result
    pub note: Option<String>,
}

/// Fact and remedy of a selector that gives no region.
pub(in crate::scene) struct Refusal {
    pub fact: String,
    pub remedy: String,
}

impl Refusal {
    /// Builds a refusal from its two sentences.
    pub(in crate::scene) fn new(fact: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { fact: fact.into(), remedy: remedy.into() }
    }
}

/// Kind of entities that a selector picks.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq, Default)]
#[serde(rename_all = "snake_case")]
pub enum PickSpec {
    /// Nodes
    #[default]
    Nodes,
    /// Facets of the boundary
    Facets,
    /// Cells
    Cells,
}

impl PickSpec {
    /// The corresponding kind of entities of a mesh.
    pub(super) fn pick(self) -> Pick {
        match self {
            Self::Nodes => Pick::Nodes,
            Self::Facets => Pick::Facets,
            Self::Cells => Pick::Cells,
        }
    }
}

/// The region of a selector, with its note; an empty region is refused, as is one that silently contains everything.
pub(in crate::scene) fn region_of(
    selector: &dyn SelectorPart,
    ground: &Ground,
) -> Result<(Region, Option<String>), Refusal> {
    let SelectedEntities { pick, entities, depends_on_mesh, note } = selector.find(ground)?;
    if entities.is_empty() {
        let (low, high) = ground.mesh.bounding_box();
        let fact = format!("{} holds no {}", selector.words(), pick.words());
        return Err(Refusal::new(fact, format!("the mesh fills {} to {}", point(&low), point(&high))));
    }
    let every = pick.every(ground.mesh);
    if !selector.may_be_everything() && every.iter().all(|k| entities.binary_search(k).is_ok()) {
        let fact = format!("{} holds all {} {}", selector.words(), every.len(), pick.words());
        let name = if pick == Pick::Facets { "skin" } else { "body" };
        let remedy = "check its lengths and their units";
        // The mesh may use this name for a part of the surface
        let is_whole = pick != Pick::Facets || ground.regions.get(name).is_some_and(|skin| skin.facets == every);
        return Err(match is_whole {
            true => Refusal::new(fact, format!("{remedy}, or use the region \"{name}\", which holds them all")),
            false => Refusal::new(fact, remedy),
        });
    }
    Ok((pick.region(entities, depends_on_mesh), note))
}
