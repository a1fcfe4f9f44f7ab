//! Tetrahedra with boundary facets and named regions.

use super::{MeshError, Order};
use crate::math::tensor::Vec3;
use std::collections::BTreeMap;

/// A named set of cells, facets or nodes; indices into the mesh, in ascending order, without duplicates.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Region {
    pub cells: Vec<u32>,
    pub facets: Vec<u32>,
    /// Nodes listed explicitly (selectors, node sets); the nodes of `cells` and `facets` need not be repeated here.
    pub nodes: Vec<u32>,
    /// Whether the nodes of the region are only `nodes`: a node set of a file, in which an element set of the same name is a different set.
    pub is_node_set: bool,
    /// Whether the border of the selector that made it runs through cells: an O(h) boundary condition.
    pub depends_on_mesh: bool,
}

/// Tetrahedra, all of one order, with boundary facets and named regions. Lengths in metres.
///
/// Node order is VTK's: corners 0–3, then mid-edges (0,1) (1,2) (0,2) (0,3) (1,3) (2,3); facets: corners 0–2, then
/// (0,1) (1,2) (2,0), outward by the right-hand rule. Every cell has positive volume.
#[derive(Clone, PartialEq, Debug)]
pub struct TetMesh {
    pub order: Order,
    /// \[nodes\] positions \[m\]
    pub points: Vec<Vec3>,
    /// \[cells × order.cell_nodes()\] node indices
    pub cells: Vec<u32>,
    /// \[facets × order.facet_nodes()\] node indices of the boundary facets
    pub facets: Vec<u32>,
    /// Regions by name (`root`, `tip`, …). `body`, all cells, is always there.
    pub regions: BTreeMap<String, Region>,
}

impl TetMesh {
    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.cells.len() / self.order.cell_nodes()
    }

    /// Number of boundary facets.
    pub fn facet_count(&self) -> usize {
        self.facets.len() / self.order.facet_nodes()
    }

    /// Nodes of cell `c`.
    pub fn cell(&self, c: usize) -> &[u32] {
        let n = self.order.cell_nodes();
        &self.cells[c * n..(c + 1) * n]
    }

    /// Nodes of facet `f`.
    pub fn facet(&self, f: usize) -> &[u32] {
        let n = self.order.facet_nodes();
        &self.facets[f * n..(f + 1) * n]
    }

    /// Returns all nodes of a region, in ascending order, without duplicates: those of a node set, or else those of its cells, facets and nodes.
    pub fn nodes_of(&self, region: &Region) -> Vec<u32> {
        let mut nodes = region.nodes.clone();
        if region.is_node_set {
            return nodes;
        }
        nodes.extend(region.cells.iter().flat_map(|&c| self.cell(c as usize)));
        nodes.extend(region.facets.iter().flat_map(|&f| self.facet(f as usize)));
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// Returns the nodes of the facets of a region, in ascending order, without duplicates.
    pub(crate) fn nodes_of_facets(&self, region: &Region) -> Vec<u32> {
        self.nodes_of(&Region { facets: region.facets.clone(), ..Region::default() })
    }

    /// Returns the facets on which the nodes of a region lie: empty for a node set whose nodes are not exactly those of its facets.
    pub fn facets_of<'a>(&self, region: &'a Region) -> &'a [u32] {
        let are_apart = region.is_node_set && region.nodes != self.nodes_of_facets(region);
        if are_apart { &[] } else { &region.facets }
    }

    /// Returns the region `name`.
    ///
    /// # Errors
    ///
    /// The mesh has no such region; the error lists the regions that it has.
    pub fn region(&self, name: &str) -> Result<&Region, MeshError> {
        let known = || self.regions.keys().cloned().collect();
        self.regions.get(name).ok_or_else(|| MeshError::NoRegion { name: name.into(), known: known() })
    }
}
