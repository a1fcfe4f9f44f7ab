//! Selectors `union`, `intersection`, `difference` and `complement`: regions made of other regions.

use super::part::{Ground, PickSpec, Refusal, SelectedEntities, SelectorPart};
use crate::mesh::boundary::facet_cells;
use crate::mesh::select::Pick;
use crate::mesh::{Region, TetMesh};
use schemars::JsonSchema;
use serde::Deserialize;

/// Everything that is in one of the regions.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UnionSelector {
    /// Names of the regions
    pub of: Vec<String>,
    /// Kind of entities that are taken from each region
    pub pick: Option<PickSpec>,
}

/// Everything that is in all of the regions.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IntersectionSelector {
    /// Names of the regions
    pub of: Vec<String>,
    /// Kind of entities that are taken from each region
    pub pick: Option<PickSpec>,
}

/// The first region without the others.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DifferenceSelector {
    /// Names of the regions
    pub of: Vec<String>,
    /// Kind of entities that are taken from each region
    pub pick: Option<PickSpec>,
}

/// Everything that is not in the region.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComplementSelector {
    /// Names of the regions
    pub of: [String; 1],
    /// Kind of entities that are taken from the region
    pub pick: Option<PickSpec>,
}

impl SelectorPart for UnionSelector {
    fn of(&self) -> &[String] {
        &self.of
    }

    fn find(&self, ground: &Ground) -> Result<SelectedEntities, Refusal> {
        combine(ground, &self.of, self.pick, |_, operands| {
            let mut all = operands.concat();
            all.sort_unstable();
            all.dedup();
            all
        })
    }

    fn words(&self) -> String {
        format!("the union of {}", quoted(&self.of))
    }
}

impl SelectorPart for IntersectionSelector {
    fn of(&self) -> &[String] {
        &self.of
    }

    fn find(&self, ground: &Ground) -> Result<SelectedEntities, Refusal> {
        combine(ground, &self.of, self.pick, |_, operands| {
            let is_in_all = |k: &u32| operands[1..].iter().all(|other| other.binary_search(k).is_ok());
            operands[0].iter().copied().filter(is_in_all).collect()
        })
    }

    fn words(&self) -> String {
        format!("the intersection of {}", quoted(&self.of))
    }
}

impl SelectorPart for DifferenceSelector {
    fn of(&self) -> &[String] {
        &self.of
    }

    fn find(&self, ground: &Ground) -> Result<SelectedEntities, Refusal> {
        combine(ground, &self.of, self.pick, |_, operands| without(&operands[0], &operands[1..]))
    }

    fn words(&self) -> String {
        format!("the difference of {}", quoted(&self.of))
    }
}

impl SelectorPart for ComplementSelector {
    fn of(&self) -> &[String] {
        &self.of
    }

    fn find(&self, ground: &Ground) -> Result<SelectedEntities, Refusal> {
        combine(ground, &self.of, self.pick, without)
    }

    fn words(&self) -> String {
        format!("the complement of {}", quoted(&self.of))
    }
}

fn quoted(names: &[String]) -> String {
    names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
}

fn without(first: &[u32], others: &[Vec<u32>]) -> Vec<u32> {
    first.iter().copied().filter(|k| others.iter().all(|other| other.binary_search(k).is_err())).collect()
}

/// The result of an operation on the set of all entities and on the entities of the regions, which are of one kind.
fn combine(
    ground: &Ground,
    names: &[String],
    pick: Option<PickSpec>,
    operation: impl Fn(&[u32], &[Vec<u32>]) -> Vec<u32>,
) -> Result<SelectedEntities, Refusal> {
    if names.is_empty() {
        return Err(Refusal::new("`of` names no region", "name those that it is made of"));
    }
    let regions = || names.iter().map(|name| (name, &ground.regions[name]));
    let pick = match pick {
        Some(pick) => pick.pick(),
        None => common(regions())?,
    };
    let taken: Result<Vec<Vec<u32>>, Refusal> =
        regions().map(|(name, region)| entities(ground.mesh, name, region, pick)).collect();
    let depends_on_mesh = regions().any(|(_, region)| region.depends_on_mesh);
    Ok(SelectedEntities { pick, entities: operation(&pick.every(ground.mesh), &taken?), depends_on_mesh, note: None })
}

/// The kind of entities that all of the regions contain.
fn common<'a>(regions: impl Iterator<Item = (&'a String, &'a Region)> + Clone) -> Result<Pick, Refusal> {
    let holds = |region: &Region| {
        let counts =
            [(Pick::Nodes, region.nodes.len()), (Pick::Facets, region.facets.len()), (Pick::Cells, region.cells.len())];
        counts.into_iter().filter(|(_, count)| *count > 0).collect::<Vec<_>>()
    };
    let kinds: Vec<Vec<Pick>> =
        regions.clone().map(|(_, r)| holds(r).into_iter().map(|(pick, _)| pick).collect()).collect();
    match kinds[0][..] {
        [pick] if kinds.iter().all(|k| *k == [pick]) => Ok(pick),
        _ => {
            let list = regions.map(|(name, region)| {
                let counts: Vec<String> = holds(region).iter().map(|(p, n)| format!("{n} {}", p.words())).collect();
                format!("\"{name}\" {}", counts.join(" and "))
            });
            let fact = format!("the regions hold different things: {}", list.collect::<Vec<_>>().join(", "));
            Err(Refusal::new(fact, "add for example pick = \"nodes\", to take the nodes of each"))
        }
    }
}

/// The entities of a region of the given kind: its own, or the facets and nodes of its cells, or the nodes of its facets.
fn entities(mesh: &TetMesh, name: &str, region: &Region, pick: Pick) -> Result<Vec<u32>, Refusal> {
    match pick {
        Pick::Nodes => return Ok(mesh.nodes_of(region)),
        Pick::Facets if !region.facets.is_empty() => return Ok(region.facets.clone()),
        Pick::Facets if !region.cells.is_empty() => {
            let of = facet_cells(mesh);
            let is_own = |f: &u32| region.cells.binary_search(&of[*f as usize].0).is_ok();
            return Ok(Pick::Facets.every(mesh).into_iter().filter(is_own).collect());
        }
        Pick::Cells if !region.cells.is_empty() => return Ok(region.cells.clone()),
        Pick::Facets | Pick::Cells => {}
    }
    let fact = format!("region \"{name}\" holds no {}", pick.words());
    Err(Refusal::new(fact, "take pick = \"nodes\", or another region"))
}
