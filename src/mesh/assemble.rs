//! From what a file holds to a checked [`TetMesh`]: units, orientation, boundary, regions.

use super::boundary::{Faces, push_boundary, push_facet, sorted};
use super::error::MeshError;
use super::validate;
use super::{Order, Region, TetMesh};
use crate::math::tensor::Vec3;
use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;

/// Names and counts of the element kinds of a file, for messages.
pub(super) type Kinds = BTreeMap<&'static str, usize>;

/// A mesh as a reader found it. Tags are the numbers of the file, for messages.
#[derive(Default)]
pub(super) struct RawMesh {
    pub file: PathBuf,
    pub points: Vec<Vec3>,
    pub node_tags: Vec<u64>,
    /// \[points\] a node that may belong to no cell: it lies on a lower-dimensional entity of the geometry
    pub may_be_free: Vec<bool>,
    /// tet4 cells \[4 per cell\] and tet10 cells \[10 per cell, VTK order\], as indices into `points`
    pub tet4: Vec<u32>,
    pub tet10: Vec<u32>,
    pub cell_tags: Vec<u64>,
    pub cell_regions: BTreeMap<String, Vec<u32>>,
    /// Corners of triangles of the file, with its tag and regions
    pub triangles: Vec<([u32; 3], u64, Vec<String>)>,
    /// All other kinds of the file; volumetric ones are refused
    pub other_volumes: Kinds,
    pub other: Kinds,
}

impl RawMesh {
    /// Checks everything, converts to metres (`unit_m` metres per unit of the file) and completes the boundary.
    pub fn finish(mut self, unit_m: f64) -> Result<TetMesh, MeshError> {
        let order = self.order()?;
        let cells =
            if order == Order::Linear { std::mem::take(&mut self.tet4) } else { std::mem::take(&mut self.tet10) };
        if let Some(i) = self.points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(MeshError::NotFinite { file: self.file, node: self.node_tags[i] });
        }
        let (points, cells) = self.used_nodes(cells, unit_m)?;
        if let Some((i, j)) = validate::duplicate(&points) {
            let (first, second, at) = (self.node_tags[i], self.node_tags[j], points[i]);
            return Err(MeshError::DuplicateNode { file: self.file, first, second, at });
        }
        let mut mesh = TetMesh { order, points, cells, facets: vec![], regions: BTreeMap::new() };
        self.orient(&mut mesh)?;
        self.regions(&mut mesh)?;
        Ok(mesh)
    }

    /// The order of the cells; refuses everything that is not tetrahedra of one order.
    fn order(&self) -> Result<Order, MeshError> {
        let mut kinds = self.other_volumes.clone();
        let (linear, quadratic) = (self.tet4.len() / 4, self.tet10.len() / 10);
        for (name, count) in [("4-node tetrahedra", linear), ("10-node tetrahedra", quadratic)] {
            if count > 0 {
                kinds.insert(name, count);
            }
        }
        let list = |kinds: &Kinds| kinds.iter().map(|(k, n)| format!("{n} × {k}")).collect::<Vec<_>>().join(", ");
        let file = self.file.clone();
        match (linear, quadratic) {
            _ if kinds.len() > 1 || !self.other_volumes.is_empty() => {
                Err(MeshError::MixedCells { file, kinds: list(&kinds) })
            }
            (0, 0) => {
                let mut found = self.other.clone();
                if !self.triangles.is_empty() {
                    found.insert("triangles", self.triangles.len());
                }
                let found =
                    if found.is_empty() { "no elements at all".into() } else { format!("only {}", list(&found)) };
                Err(MeshError::NoCells { file, found })
            }
            (_, 0) => Ok(Order::Linear),
            _ => Ok(Order::Quadratic),
        }
    }

    /// Keeps the nodes of the cells, renumbered in file order. A node without a cell is dropped if it lies on a
    /// lower-dimensional entity (centres of arcs, points that only carry a size) and an error otherwise.
    fn used_nodes(&mut self, mut cells: Vec<u32>, unit_m: f64) -> Result<(Vec<Vec3>, Vec<u32>), MeshError> {
        let mut used = vec![false; self.points.len()];
        cells.iter().for_each(|&i| used[i as usize] = true);
        let orphan = |i: &usize| !used[*i] && !self.may_be_free[*i];
        let count = (0..used.len()).filter(orphan).count();
        if let Some(i) = (0..used.len()).find(orphan) {
            let (node, at) = (self.node_tags[i], self.points[i] * unit_m);
            return Err(MeshError::OrphanNode { file: self.file.clone(), node, at, count });
        }
        const GONE: u32 = u32::MAX;
        let mut number = vec![GONE; used.len()];
        let kept: Vec<usize> = (0..used.len()).filter(|&i| used[i]).collect();
        kept.iter().enumerate().for_each(|(new, &old)| number[old] = new as u32);
        cells.iter_mut().for_each(|i| *i = number[*i as usize]);
        // A triangle with a dropped node is no face of a cell: its corner stays GONE and is found out later.
        self.triangles.iter_mut().for_each(|(corners, _, _)| corners.iter_mut().for_each(|i| *i = number[*i as usize]));
        self.node_tags = kept.iter().map(|&i| self.node_tags[i]).collect();
        Ok((kept.iter().map(|&i| self.points[i] * unit_m).collect(), cells))
    }

    /// Makes all volumes positive: a file with the opposite convention is reoriented as a whole, a single inverted cell is an
    /// error, and so is one without volume or a curved one that folds over.
    fn orient(&self, mesh: &mut TetMesh) -> Result<(), MeshError> {
        let count = mesh.cell_count();
        let volumes: Vec<f64> = (0..count).map(|c| mesh.cell_volume(c)).collect();
        for (c, &volume) in volumes.iter().enumerate() {
            let corners = &mesh.cell(c)[..4];
            let edge =
                |a: usize, b: usize| (mesh.points[corners[a] as usize] - mesh.points[corners[b] as usize]).norm();
            let longest = super::element::CELL_EDGES.into_iter().map(|[a, b]| edge(a, b)).fold(0.0, f64::max);
            if volume.abs() <= 1e-12 * longest.powi(3) {
                return Err(MeshError::ZeroVolume { file: self.file.clone(), cell: self.cell_tags[c], volume });
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
            // The minority is what is wrong.
            let wrong = if 2 * negative <= count { -1.0 } else { 1.0 };
            let c = volumes.iter().position(|v| v.signum() == wrong).expect("both signs occur");
            let wrong_count = negative.min(count - negative);
            let (file, cell) = (self.file.clone(), self.cell_tags[c]);
            return Err(MeshError::InvertedCell { file, cell, volume: volumes[c], count: wrong_count, cells: count });
        }
        if mesh.order == Order::Quadratic {
            for c in 0..count {
                let min_det = validate::min_det(mesh, c);
                if min_det <= 0.0 {
                    return Err(MeshError::FoldedCell { file: self.file.clone(), cell: self.cell_tags[c], min_det });
                }
            }
        }
        Ok(())
    }

    /// Facets and regions: the triangles of the file that are faces of cells, then the rest of the boundary.
    fn regions(mut self, mesh: &mut TetMesh) -> Result<(), MeshError> {
        let faces =
            Faces::of(mesh).map_err(|c| MeshError::SharedFace { file: self.file.clone(), cell: self.cell_tags[c] })?;
        let mut number: HashMap<[u32; 3], u32> = HashMap::new();
        let mut facet_regions: BTreeMap<String, Vec<u32>> = BTreeMap::new();
        for (corners, tag, regions) in std::mem::take(&mut self.triangles) {
            let key = sorted(corners);
            let Some(&(cell, face, _)) = faces.0.get(&key) else {
                match regions.first() {
                    Some(region) => {
                        return Err(MeshError::LooseFacet { file: self.file, facet: tag, region: region.clone() });
                    }
                    None => continue,
                }
            };
            if regions.is_empty() {
                continue;
            }
            let f = *number.entry(key).or_insert_with(|| push_facet(mesh, cell, face));
            regions.into_iter().for_each(|name| facet_regions.entry(name).or_default().push(f));
        }
        push_boundary(mesh, &faces, |key| number.contains_key(key));
        for (name, cells) in std::mem::take(&mut self.cell_regions) {
            mesh.regions.entry(name).or_default().cells = ascending(cells);
        }
        for (name, facets) in facet_regions {
            mesh.regions.entry(name).or_default().facets = ascending(facets);
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
pub(super) fn add_body(mesh: &mut TetMesh) {
    let cells = (0..mesh.cell_count() as u32).collect();
    mesh.regions.insert("body".into(), Region { cells, ..Region::default() });
}
