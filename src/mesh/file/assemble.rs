//! Assembly of the content of a file into a checked [`TetMesh`]: units, orientation, boundary, regions.

use super::mid_nodes::Numbers;
use super::solid::{Solid, triangles};
use super::validate;
use crate::math::tensor::Vec3;
use crate::mesh::error::MeshError;
use crate::mesh::surface::boundary::{Faces, push_boundary, push_facet, sorted};
use crate::mesh::{Order, Region, TetMesh};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::PathBuf;
use std::sync::Arc;

/// Index of a node that has been removed.
const GONE: u32 = u32::MAX;

/// Names and counts of the element kinds of a file, for messages.
pub(super) type Kinds = BTreeMap<&'static str, usize>;

/// Options for cells and nodes of a file that a mesh cannot contain as they are.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Reading {
    /// Metres per unit of the file
    pub unit_m: f64,
    /// Whether to split hexahedra, wedges and pyramids into tetrahedra
    pub split: bool,
    /// Distance within which nodes are merged \[m\]; `None` to merge none
    pub merge: Option<f64>,
}

/// Changes made to the content of a file when it was read.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Changes {
    /// Number of nodes that belonged to no cell and were dropped
    pub dropped_nodes: usize,
    /// Number of nodes that were merged with another
    pub merged_nodes: usize,
    /// Number of cells that were split into tetrahedra
    pub split_cells: usize,
    /// Sentences on parts of the file that were not read
    pub notes: Vec<String>,
}

/// A cell as a reader found it: its kind, the position of its first node, and its number in the file.
#[derive(Clone, Copy)]
pub(super) struct RawCell {
    solid: Solid,
    begin: usize,
    tag: u64,
}

/// A triangle or quadrilateral of the file, given by its corners.
pub(super) struct RawFacet {
    pub corners: Vec<u32>,
    pub tag: u64,
    /// Names of the regions, shared by the facets of one entity
    pub regions: Arc<[String]>,
}

/// A mesh as a reader found it. Tags are the numbers used in the file, for messages.
#[derive(Default)]
pub(super) struct RawMesh {
    pub file: PathBuf,
    pub points: Vec<Vec3>,
    pub node_tags: Vec<u64>,
    /// \[points\] whether the node may belong to no cell, because it lies on a lower-dimensional entity of the geometry
    pub may_be_free: Vec<bool>,
    pub cells: Vec<RawCell>,
    /// Nodes of all cells, tet10 in VTK's order, as indices into `points`
    pub cell_nodes: Vec<u32>,
    /// Indices into the cells
    pub cell_regions: BTreeMap<String, Vec<u32>>,
    pub facets: Vec<RawFacet>,
    /// Indices into `points`
    pub node_regions: BTreeMap<String, Vec<u32>>,
    /// Names of node sets; facets and cells of the same name form separate sets. A set without nodes of its own has the nodes of the facets.
    pub node_sets: BTreeSet<String>,
    /// Kinds of volume elements that are refused
    pub other_volumes: Kinds,
    /// Kinds of elements that are skipped
    pub other: Kinds,
    /// Sentences on parts of the file that are not read
    pub notes: Vec<String>,
}

impl RawMesh {
    /// Appends a cell; returns its index.
    pub fn push(&mut self, solid: Solid, nodes: &[u32], tag: u64) -> u32 {
        self.cells.push(RawCell { solid, begin: self.cell_nodes.len(), tag });
        self.cell_nodes.extend(&nodes[..solid.nodes()]);
        self.cells.len() as u32 - 1
    }

    /// Nodes of cell `c`.
    pub fn nodes(&self, c: usize) -> &[u32] {
        let cell = &self.cells[c];
        &self.cell_nodes[cell.begin..cell.begin + cell.solid.nodes()]
    }

    /// Kind of cell `c`.
    pub fn solid(&self, c: usize) -> Solid {
        self.cells[c].solid
    }

    /// Checks the mesh, converts it to metres and completes the boundary.
    pub fn finish(mut self, how: &Reading) -> Result<(TetMesh, Changes), MeshError> {
        let order = self.order(how)?;
        if let Some(i) = self.points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(MeshError::NotFinite { file: self.file, node: self.node_tags[i] });
        }
        let mut changes = Changes { notes: std::mem::take(&mut self.notes), ..Changes::default() };
        if let Some(distance) = how.merge {
            changes.merged_nodes = self.merge(distance / how.unit_m)?;
        }
        changes.split_cells = self.split();
        changes.dropped_nodes = self.drop_unused();
        let points: Vec<Vec3> = self.points.iter().map(|p| p * how.unit_m).collect();
        if let Some(&(i, j)) = validate::doubled(&points).first() {
            let (first, second, at) = (self.node_tags[i], self.node_tags[j], points[i]);
            return Err(MeshError::DuplicateNode { file: self.file, first, second, at });
        }
        let cells = std::mem::take(&mut self.cell_nodes);
        let mut mesh = TetMesh { order, points, cells, facets: vec![], regions: BTreeMap::new() };
        if order == Order::Quadratic {
            self.numbers().check_order(&mesh)?;
        }
        self.orient(&mut mesh)?;
        self.regions(&mut mesh)?;
        Ok((mesh, changes))
    }

    /// Returns the number of cells by kind, and of all other elements in the file.
    pub fn kinds(&self) -> Kinds {
        let mut kinds = self.other_volumes.clone();
        self.cells.iter().for_each(|cell| *kinds.entry(cell.solid.name()).or_default() += 1);
        kinds
    }

    /// Returns the order of the cells; refuses everything except tetrahedra of one order and cells that will be split into such.
    fn order(&self, how: &Reading) -> Result<Order, MeshError> {
        let has = |solid| self.cells.iter().any(|cell| cell.solid == solid);
        let solids = [Solid::Pyramid, Solid::Wedge, Solid::Hexahedron].into_iter().any(has);
        let list = |kinds: &Kinds| kinds.iter().map(|(k, n)| format!("{n} × {k}")).collect::<Vec<_>>().join(", ");
        let file = self.file.clone();
        match (has(Solid::Tet10), has(Solid::Tet4) || solids) {
            (quadratic, linear) if !self.other_volumes.is_empty() || (quadratic && linear) => {
                Err(MeshError::MixedCells { file, kinds: list(&self.kinds()) })
            }
            _ if solids && !how.split => Err(MeshError::NotSplit { file, kinds: list(&self.kinds()) }),
            (false, false) => {
                let mut found = self.other.clone();
                for facet in &self.facets {
                    let name = if facet.corners.len() == 3 { "triangles" } else { "quadrangles" };
                    *found.entry(name).or_default() += 1;
                }
                let found =
                    if found.is_empty() { "no elements at all".into() } else { format!("only {}", list(&found)) };
                Err(MeshError::NoCells { file, found })
            }
            (quadratic, _) => Ok(if quadratic { Order::Quadratic } else { Order::Linear }),
        }
    }

    /// Replaces nodes within a distance \[units of the file\] of an earlier node by that node; returns their number. A cell that loses a corner is
    /// refused.
    fn merge(&mut self, distance: f64) -> Result<usize, MeshError> {
        let mut number: Vec<u32> = (0..self.points.len() as u32).collect();
        let pairs = validate::closer_than(&self.points, distance);
        pairs.iter().for_each(|&(first, second)| number[second] = number[first]);
        for (k, cell) in self.cells.iter().enumerate() {
            let mut nodes: Vec<u32> = self.nodes(k).iter().map(|&i| number[i as usize]).collect();
            nodes.sort_unstable();
            if let Some(w) = nodes.windows(2).find(|w| w[0] == w[1]) {
                let node = self.node_tags[w[0] as usize];
                return Err(MeshError::MergedCell { file: self.file.clone(), cell: cell.tag, node });
            }
        }
        let lists = self.facets.iter_mut().map(|f| &mut f.corners).chain(self.node_regions.values_mut());
        lists.chain([&mut self.cell_nodes]).flatten().for_each(|i| *i = number[*i as usize]);
        // A replaced node is in no cell, but does not count as unused in the file.
        pairs.iter().for_each(|&(_, second)| self.may_be_free[second] = true);
        Ok(pairs.len())
    }

    /// Splits all cells that are not tetrahedra, with their regions; returns their number. Kinds whose cells are all numbered with the opposite
    /// orientation are reversed.
    fn split(&mut self) -> usize {
        let divided = |solid: Solid| !matches!(solid, Solid::Tet4 | Solid::Tet10);
        let count = self.cells.iter().filter(|c| divided(c.solid)).count();
        if count == 0 {
            return 0;
        }
        let tets = |k: usize| match self.solid(k) {
            Solid::Tet4 => vec![[0, 1, 2, 3].map(|i| self.nodes(k)[i])],
            solid => solid.divide(self.nodes(k)),
        };
        let mut parts: Vec<Vec<[u32; 4]>> = (0..self.cells.len()).map(tets).collect();
        for kind in [Solid::Tet4, Solid::Pyramid, Solid::Wedge, Solid::Hexahedron] {
            let of_kind = || self.cells.iter().zip(&parts).filter(|(cell, _)| cell.solid == kind);
            if of_kind().all(|(_, tets)| tets.iter().all(|t| self.volume(t) < 0.0)) {
                let turned = self.cells.iter().zip(&mut parts).filter(|(cell, _)| cell.solid == kind);
                turned.flat_map(|(_, tets)| tets).for_each(|t| t.swap(1, 2));
            }
        }
        let (mut cells, mut all, mut begin) = (Vec::new(), Vec::new(), vec![0u32]);
        for (cell, tets) in self.cells.iter().zip(parts) {
            for tet in tets {
                cells.push(RawCell { solid: Solid::Tet4, begin: all.len(), tag: cell.tag });
                all.extend(tet);
            }
            begin.push(cells.len() as u32);
        }
        (self.cells, self.cell_nodes) = (cells, all);
        for list in self.cell_regions.values_mut() {
            *list = list.iter().flat_map(|&c| begin[c as usize]..begin[c as usize + 1]).collect();
        }
        count
    }

    /// Returns six times the signed volume of a tetrahedron.
    pub fn volume(&self, nodes: &[u32; 4]) -> f64 {
        let [a, b, c, d] = nodes.map(|i| self.points[i as usize]);
        (b - a).cross(&(c - a)).dot(&(d - a))
    }

    /// Keeps only the nodes of cells, renumbered in file order. Returns the number of the others, except those on a lower-dimensional entity (centres
    /// of arcs, points that only carry a size).
    fn drop_unused(&mut self) -> usize {
        let mut used = vec![false; self.points.len()];
        self.cell_nodes.iter().for_each(|&i| used[i as usize] = true);
        let dropped = (0..used.len()).filter(|&i| !used[i] && !self.may_be_free[i]).count();
        let mut number = vec![GONE; used.len()];
        let kept: Vec<usize> = (0..used.len()).filter(|&i| used[i]).collect();
        kept.iter().enumerate().for_each(|(new, &old)| number[old] = new as u32);
        // A facet with a dropped node is not a face of a cell: its corner remains GONE and is detected later.
        let lists = self.facets.iter_mut().map(|f| &mut f.corners).chain(self.node_regions.values_mut());
        lists.chain([&mut self.cell_nodes]).flatten().for_each(|i| *i = number[*i as usize]);
        self.node_regions.values_mut().for_each(|list| list.retain(|&i| i != GONE));
        self.node_tags = kept.iter().map(|&i| self.node_tags[i]).collect();
        self.points = kept.iter().map(|&i| self.points[i]).collect();
        dropped
    }

    /// Makes all volumes positive: a file with the opposite convention is reoriented as a whole; a single inverted cell, a cell without volume and a
    /// folded curved cell are errors.
    fn orient(&self, mesh: &mut TetMesh) -> Result<(), MeshError> {
        let count = mesh.cell_count();
        let volumes: Vec<f64> = (0..count).map(|c| mesh.cell_volume(c)).collect();
        for (c, &volume) in volumes.iter().enumerate() {
            let corners = &mesh.cell(c)[..4];
            let edge =
                |a: usize, b: usize| (mesh.points[corners[a] as usize] - mesh.points[corners[b] as usize]).norm();
            let longest = crate::mesh::element::CELL_EDGES.into_iter().map(|[a, b]| edge(a, b)).fold(0.0, f64::max);
            if volume.abs() <= 1e-12 * longest.powi(3) {
                return Err(MeshError::ZeroVolume { file: self.file.clone(), cell: self.cells[c].tag, volume });
            }
        }
        let negative = volumes.iter().filter(|v| **v < 0.0).count();
        if negative == count {
            let swaps: &[(usize, usize)] =
                if mesh.order == Order::Linear { &[(1, 2)] } else { &[(1, 2), (4, 6), (8, 9)] };
            for cell in mesh.cells.chunks_exact_mut(mesh.order.cell_nodes()) {
                swaps.iter().for_each(|&(a, b)| cell.swap(a, b));
            }
        } else if negative > 0 {
            // The minority is taken to be wrong.
            let wrong = if 2 * negative <= count { -1.0 } else { 1.0 };
            let c = volumes.iter().position(|v| v.signum() == wrong).expect("both signs occur");
            let wrong_count = negative.min(count - negative);
            let (file, cell) = (self.file.clone(), self.cells[c].tag);
            return Err(MeshError::InvertedCell { file, cell, volume: volumes[c], count: wrong_count, cells: count });
        }
        if mesh.order == Order::Quadratic {
            for c in 0..count {
                let min_det = validate::min_det(mesh, c);
                if min_det.is_nan() || min_det <= 0.0 {
                    return Err(MeshError::FoldedCell { file: self.file.clone(), cell: self.cells[c].tag, min_det });
                }
            }
        }
        Ok(())
    }

    /// Returns the numbers of nodes and cells in the file, once they are those of the mesh.
    fn numbers(&self) -> Numbers<'_, impl Fn(usize) -> u64> {
        Numbers { file: &self.file, nodes: &self.node_tags, cell: |c| self.cells[c].tag }
    }

    /// Builds facets and regions: first the triangles of the file that are faces of cells, then the rest of the boundary.
    fn regions(mut self, mesh: &mut TetMesh) -> Result<(), MeshError> {
        let faces =
            Faces::of(mesh).map_err(|c| MeshError::SharedFace { file: self.file.clone(), cell: self.cells[c].tag })?;
        if let Some(cells) = faces.overlap(mesh) {
            return Err(MeshError::Overlap { cells: cells.map(|c| self.cells[c].tag), file: self.file });
        }
        if mesh.order == Order::Quadratic {
            self.numbers().check_faces(mesh, &faces)?;
        }
        let mut number: HashMap<[u32; 3], u32> = HashMap::new();
        let mut facet_regions: BTreeMap<String, Vec<u32>> = BTreeMap::new();
        for RawFacet { corners, tag, regions } in std::mem::take(&mut self.facets) {
            let Some(region) = regions.first() else { continue };
            for corners in triangles(&corners) {
                let key = sorted(corners);
                let Some(&(cell, face, _)) = faces.0.get(&key) else {
                    return Err(MeshError::LooseFacet { file: self.file, facet: tag, region: region.clone() });
                };
                let f = *number.entry(key).or_insert_with(|| push_facet(mesh, cell, face));
                regions.iter().for_each(|name| facet_regions.entry(name.clone()).or_default().push(f));
            }
        }
        push_boundary(mesh, &faces, |key| number.contains_key(key));
        for (name, cells) in std::mem::take(&mut self.cell_regions) {
            mesh.regions.entry(name).or_default().cells = ascending(cells);
        }
        for (name, facets) in facet_regions {
            mesh.regions.entry(name).or_default().facets = ascending(facets);
        }
        for (name, nodes) in std::mem::take(&mut self.node_regions) {
            // A set of reference points of another program contains no node of a cell.
            if !nodes.is_empty() {
                mesh.regions.entry(name).or_default().nodes = ascending(nodes);
            }
        }
        for name in &self.node_sets {
            let Some(region) = mesh.regions.get(name) else { continue };
            let own = match region.nodes.is_empty() {
                true => mesh.nodes_of_facets(region),
                false => region.nodes.clone(),
            };
            let region = mesh.regions.get_mut(name).expect("found before");
            (region.is_node_set, region.nodes) = (true, own);
        }
        let cells = mesh.cell_count();
        if let Some(body) = mesh.regions.get("body")
            && (body.cells.len() != cells || !body.facets.is_empty())
        {
            return Err(MeshError::PartialBody { file: self.file, count: body.cells.len(), cells });
        }
        add_body(mesh);
        Ok(())
    }
}

fn ascending(mut list: Vec<u32>) -> Vec<u32> {
    list.sort_unstable();
    list.dedup();
    list
}

/// Sets the region `body` to all cells.
pub(in crate::mesh) fn add_body(mesh: &mut TetMesh) {
    let cells = (0..mesh.cell_count() as u32).collect();
    mesh.regions.insert("body".into(), Region { cells, ..Region::default() });
}
