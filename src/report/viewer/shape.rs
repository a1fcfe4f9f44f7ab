//! Geometry of a page: points, element faces, cells for sections, and parts that follow the body.

use super::coarsen::coarsen;
use crate::mesh::TetMesh;
use crate::mesh::boundary::{boundary_facets, facet_cells};
use std::collections::{BTreeSet, HashMap};

/// Limits of what a page shows; anything beyond is left out or simplified, with a note.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Largest number of cells, for sections through the inside
    pub cells: usize,
    /// Largest number of facets of the surface
    pub facets: usize,
}

impl Limits {
    /// Sizes that a browser rotates smoothly and that fit into a page of a few megabytes.
    pub const USUAL: Self = Self { cells: 150_000, facets: 120_000 };
}

/// Kind of a part that follows the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartKind {
    /// A polyline
    Cable,
    /// A rigid body, or an obstacle
    Rigid,
    /// A surface that is carried along
    Skin,
    /// Four points in the plane of an unbounded obstacle, counter-clockwise about its normal: the page draws the plane below everything that it shows
    Floor,
}

impl PartKind {
    pub const ALL: [Self; 4] = [Self::Cable, Self::Rigid, Self::Skin, Self::Floor];

    /// Returns its name in the data of a page.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cable => "cable",
            Self::Rigid => "rigid",
            Self::Skin => "skin",
            Self::Floor => "floor",
        }
    }
}

/// A line or surface with its own points.
#[derive(Clone, Debug)]
pub struct ShapePart {
    pub name: String,
    pub kind: PartKind,
    /// Index of its first point among the points of the shape
    pub first: u32,
    pub count: u32,
    /// Corners \[triangles\], counted from `first`; empty for a line
    pub triangles: Vec<[u32; 3]>,
}

/// A named part of the surface, or a set of nodes.
#[derive(Clone, Debug)]
pub struct Marked {
    pub name: String,
    /// Kind of the set: `region`, `cavity` or `held`
    pub kind: &'static str,
    /// Facets of the shape
    pub facets: Vec<u32>,
    /// Points of the shape
    pub points: Vec<u32>,
}

/// Everything that a page draws, at rest.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    /// Positions at rest \[points\] \[m\]: nodes of the mesh, then the points of the parts
    pub points: Vec<[f64; 3]>,
    /// Number of each node in the mesh, ascending \[nodes\]
    pub nodes: Vec<u32>,
    /// Whether the numbers in the mesh are unknown, so that the page numbers the nodes itself
    pub has_own_numbers: bool,
    /// Number of nodes of a facet, 3 or 6
    pub facet_nodes: usize,
    /// Points \[facets × `facet_nodes`\], in the order of [`TetMesh`]
    pub facets: Vec<u32>,
    /// Number of each facet in the mesh \[facets\]
    pub facet_numbers: Vec<u32>,
    /// Index in `cell_numbers` of the cell of each facet \[facets\]
    pub facet_cells: Vec<u32>,
    /// Points \[cells × nodes of a cell\]; empty if the inside is left out
    pub cells: Vec<u32>,
    /// Number in the mesh of each cell with values, ascending: all cells, or those at the surface
    pub cell_numbers: Vec<u32>,
    pub parts: Vec<ShapePart>,
    pub marked: Vec<Marked>,
    /// Sentences on the parts that were left out or simplified
    pub notes: Vec<String>,
}

impl Shape {
    /// Builds the surface of a mesh and, within the limits, its cells.
    pub fn of_mesh(mesh: &TetMesh, limits: &Limits) -> Self {
        let (all, of_cell) = (boundary_facets(mesh), facet_cells(mesh));
        let count = all.len();
        let (numbers, corners) = coarsen(mesh, all, limits.facets);
        let is_coarse = numbers.len() < count;
        let has_inside = mesh.cell_count() <= limits.cells && !is_coarse;
        let facet_nodes = if is_coarse { 3 } else { mesh.order.facet_nodes() };
        let facets: Vec<u32> = if is_coarse {
            corners.into_iter().flatten().collect()
        } else {
            numbers.iter().flat_map(|&f| mesh.facet(f as usize)).copied().collect()
        };
        let used: BTreeSet<u32> =
            if has_inside { (0..mesh.points.len() as u32).collect() } else { facets.iter().copied().collect() };
        let nodes: Vec<u32> = used.into_iter().collect();
        let point: HashMap<u32, u32> = nodes.iter().enumerate().map(|(k, &n)| (n, k as u32)).collect();
        let cell_of = |f: &u32| of_cell[*f as usize].0;
        let cell_numbers: Vec<u32> = match has_inside {
            true => (0..mesh.cell_count() as u32).collect(),
            false => numbers.iter().map(cell_of).collect::<BTreeSet<u32>>().into_iter().collect(),
        };
        let position: HashMap<u32, u32> = cell_numbers.iter().enumerate().map(|(k, &c)| (c, k as u32)).collect();
        let points = |nodes: &[u32]| nodes.iter().map(|n| point[n]).collect::<Vec<u32>>();
        let mut notes = vec![];
        if is_coarse {
            notes.push(format!(
                "The surface has {count} element faces; it is simplified to {} triangles, whose edges are not those of elements.",
                numbers.len()
            ));
        }
        if !has_inside {
            notes
                .push(format!("The inside of {} cells is left out: a section shows a hollow body.", mesh.cell_count()));
        }
        Self {
            points: nodes.iter().map(|&n| mesh.points[n as usize].into()).collect(),
            facet_nodes,
            facets: points(&facets),
            facet_cells: numbers.iter().map(|f| position[&cell_of(f)]).collect(),
            facet_numbers: numbers,
            cells: if has_inside { points(&mesh.cells) } else { vec![] },
            cell_numbers,
            nodes,
            notes,
            ..Self::default()
        }
    }

    /// Returns the shape without its inside, which keeps only the points of the surface and of the parts, and the indices of the kept points and
    /// cells.
    pub fn hollow(&self) -> (Self, Vec<u32>, Vec<u32>) {
        let nodes = self.nodes.len() as u32;
        let used: BTreeSet<u32> = self.facets.iter().copied().chain(nodes..self.points.len() as u32).collect();
        let kept: Vec<u32> = used.into_iter().collect();
        let point: HashMap<u32, u32> = kept.iter().enumerate().map(|(k, &p)| (p, k as u32)).collect();
        let own: BTreeSet<u32> = self.facet_cells.iter().copied().collect();
        let position: HashMap<u32, u32> = own.iter().enumerate().map(|(k, &c)| (c, k as u32)).collect();
        let mut notes = self.notes.clone();
        notes.push("The inside is left out to keep the page small: a section shows a hollow body.".into());
        let shape = Self {
            points: kept.iter().map(|&p| self.points[p as usize]).collect(),
            nodes: kept.iter().filter(|p| **p < nodes).map(|&p| self.nodes[p as usize]).collect(),
            facets: self.facets.iter().map(|p| point[p]).collect(),
            facet_cells: self.facet_cells.iter().map(|c| position[c]).collect(),
            cells: vec![],
            cell_numbers: own.iter().map(|&c| self.cell_numbers[c as usize]).collect(),
            parts: self
                .parts
                .iter()
                .map(|p| ShapePart { first: point.get(&p.first).copied().unwrap_or(0), ..p.clone() })
                .collect(),
            marked: self
                .marked
                .iter()
                .map(|m| Marked {
                    points: m.points.iter().filter_map(|p| point.get(p).copied()).collect(),
                    ..m.clone()
                })
                .collect(),
            notes,
            ..self.clone()
        };
        (shape, kept, own.into_iter().collect())
    }

    /// Returns the largest extent of the points \[m\].
    pub fn diagonal(&self) -> f64 {
        let ends = self.points.iter().fold([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], |[low, high], p| {
            [std::array::from_fn(|i| low[i].min(p[i])), std::array::from_fn(|i| high[i].max(p[i]))]
        });
        let size = (0..3).map(|i| (ends[1][i] - ends[0][i]).max(0.0).powi(2)).sum::<f64>().sqrt();
        if size.is_finite() { size } else { 0.0 }
    }

    /// Adds a part with its points at rest.
    pub fn add_part(&mut self, name: &str, kind: PartKind, points: &[[f64; 3]], triangles: Vec<[u32; 3]>) {
        let (first, count) = (self.points.len() as u32, points.len() as u32);
        self.points.extend(points);
        self.parts.push(ShapePart { name: name.into(), kind, first, count, triangles });
    }

    /// Marks facets and nodes of the mesh by a name; those that are not shown are ignored.
    pub fn mark(&mut self, name: &str, kind: &'static str, facets: impl Fn(u32) -> bool, nodes: &[u32]) {
        let on_surface =
            (0..self.facet_numbers.len() as u32).filter(|&k| facets(self.facet_numbers[k as usize])).collect();
        let points = nodes.iter().filter_map(|n| self.nodes.binary_search(n).ok()).map(|k| k as u32).collect();
        self.marked.push(Marked { name: name.into(), kind, facets: on_surface, points });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Order;
    use crate::mesh::structured::block;

    #[test]
    fn a_small_mesh_is_shown_whole_and_a_large_one_by_its_surface() {
        let mesh = block(4, 3, 2, 4.0, 3.0, 2.0, Order::Quadratic);
        let whole = Shape::of_mesh(&mesh, &Limits::USUAL);
        assert_eq!((whole.points.len(), whole.cells.len()), (mesh.points.len(), mesh.cells.len()));
        assert_eq!((whole.facet_nodes, whole.facets.len()), (6, 2 * 2 * 26 * 6));
        assert!(whole.notes.is_empty());
        assert!((whole.diagonal() - 29f64.sqrt()).abs() < 1e-12);
        for f in 0..whole.facet_numbers.len() {
            let node = |k: usize| whole.nodes[whole.facets[6 * f + k] as usize];
            assert_eq!((0..6).map(node).collect::<Vec<_>>(), mesh.facet(whole.facet_numbers[f] as usize));
        }
        let surface = Shape::of_mesh(&mesh, &Limits { cells: 10, facets: 1000 });
        assert!(surface.cells.is_empty() && surface.points.len() < whole.points.len());
        assert!(surface.notes[0].contains("hollow"), "{:?}", surface.notes);
        let (hollow, kept, cells) = whole.hollow();
        assert_eq!((&hollow.points, &hollow.facets, &hollow.nodes), (&surface.points, &surface.facets, &surface.nodes));
        assert_eq!((&hollow.facet_cells, &hollow.cell_numbers), (&surface.facet_cells, &surface.cell_numbers));
        assert_eq!((kept.len(), cells.len()), (surface.points.len(), surface.cell_numbers.len()));
    }

    #[test]
    fn a_very_large_surface_is_simplified_with_a_note() {
        let mesh = block(20, 20, 20, 1.0, 1.0, 1.0, Order::Linear);
        let coarse = Shape::of_mesh(&mesh, &Limits { cells: 10, facets: 500 });
        assert!((100..=500).contains(&coarse.facet_numbers.len()), "{}", coarse.facet_numbers.len());
        assert!(coarse.notes[0].contains("simplified"), "{:?}", coarse.notes);
        assert!((coarse.diagonal() - 3f64.sqrt()).abs() < 0.3, "{}", coarse.diagonal());
    }
}
