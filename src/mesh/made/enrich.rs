//! Enriched meshes of a body, which can represent every field of the original mesh: each cell is split into eight, or linear cells are raised to
//! quadratic ones.
//!
//! A split cell has a child at each corner and four more around the shortest diagonal of the octahedron between them (J. Bey,
//! Tetrahedral grid refinement, *Computing* 55 (1995) 355–378). The nodes of the children lie on the map of the cell, so that a curved
//! quadratic cell is exactly the union of its children, and the spaces are nested.

use crate::mesh::element::{CELL_EDGES, CELL_NODES, FACET_EDGES, cell_shape};
use crate::mesh::{Order, Region, TetMesh};
use std::collections::{BTreeMap, HashMap};

/// Children at the corners, in terms of reference nodes of the cell.
const AT_CORNERS: [[usize; 4]; 4] = [[0, 4, 6, 7], [4, 1, 5, 8], [6, 5, 2, 9], [7, 8, 9, 3]];

/// The three diagonals of the octahedron and, around each, its other four corners in a ring.
const DIAGONALS: [([usize; 2], [usize; 4]); 3] =
    [([6, 8], [4, 5, 9, 7]), ([4, 9], [5, 6, 7, 8]), ([5, 7], [4, 6, 9, 8])];

/// Children of a facet, in terms of reference nodes of the facet.
const OF_FACET: [[usize; 3]; 4] = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];

/// A mesh whose space contains that of another mesh, with the map of fields from that mesh.
#[derive(Clone, Debug)]
pub struct Enriched {
    pub mesh: TetMesh,
    /// \[cells of the enriched mesh\] the cell of the other mesh to which it belongs
    pub parents: Vec<u32>,
    /// \[nodes of the enriched mesh\] the field value there, as weighted nodes of the other mesh
    pub weights: Vec<Vec<(u32, f64)>>,
    /// Weights for a field that is linear between the corners, for the nodes that are corners of the enriched mesh
    pub corner_weights: HashMap<u32, Vec<(u32, f64)>>,
    /// \[nodes of the enriched mesh\] for new nodes, the two nodes between which they lie
    ends: Vec<Option<[u32; 2]>>,
}

impl Enriched {
    /// Splits each cell into eight of the same order.
    pub fn by_splitting(mesh: &TetMesh) -> Self {
        let mut builder = Builder::new(mesh);
        let corners = builder.with_mid_nodes();
        let (mut fine, mut parents) = (Vec::with_capacity(8 * mesh.cells.len()), Vec::new());
        for (c, nodes) in corners.chunks_exact(10).enumerate() {
            for child in builder.children(nodes) {
                let own = child.map(|k| nodes[k]);
                fine.extend(own);
                if mesh.order == Order::Quadratic {
                    for [i, j] in CELL_EDGES {
                        let middle = std::array::from_fn(|d| 0.5 * (CELL_NODES[child[i]][d] + CELL_NODES[child[j]][d]));
                        fine.push(builder.between(own[i], own[j], c, middle));
                    }
                }
                parents.push(c as u32);
            }
        }
        let mut facets = Vec::with_capacity(4 * mesh.facets.len());
        for f in 0..mesh.facet_count() {
            let nodes = builder.facet(f);
            for child in OF_FACET {
                let own = child.map(|k| nodes[k]);
                facets.extend(own);
                if mesh.order == Order::Quadratic {
                    facets.extend(FACET_EDGES.map(|[i, j]| builder.known(own[i], own[j])));
                }
            }
        }
        builder.finish(mesh.order, fine, facets, parents, [8, 4])
    }

    /// Replaces linear cells by quadratic ones with straight edges.
    ///
    /// # Panics
    /// If the cells are already quadratic.
    pub fn by_raising(mesh: &TetMesh) -> Self {
        assert_eq!(mesh.order, Order::Linear, "only linear cells are raised");
        let mut builder = Builder::new(mesh);
        let cells = builder.with_mid_nodes();
        let facets = (0..mesh.facet_count()).flat_map(|f| builder.facet(f)).collect();
        let parents = (0..mesh.cell_count() as u32).collect();
        builder.finish(Order::Quadratic, cells, facets, parents, [1, 1])
    }

    /// Returns these nodes of the other mesh and the new nodes that lie between two of them, in ascending order.
    pub fn with_nodes_between(&self, nodes: &[u32]) -> Vec<u32> {
        between(&self.ends, nodes, |_, _| true)
    }

    /// Transfers a field \[components × nodes\] of the other mesh to the enriched one.
    pub fn prolong(&self, components: usize, field: &[f64]) -> Vec<f64> {
        let value = |weights: &Vec<(u32, f64)>, d: usize| -> f64 {
            weights.iter().map(|(node, w)| w * field[components * *node as usize + d]).sum()
        };
        self.weights.iter().flat_map(|weights| (0..components).map(move |d| value(weights, d))).collect()
    }
}

/// Nodes of the enriched mesh during its construction.
struct Builder<'a> {
    mesh: &'a TetMesh,
    weights: Vec<Vec<(u32, f64)>>,
    /// Nodes between two others
    middles: HashMap<[u32; 2], u32>,
    /// \[nodes so far\] for new nodes, the two nodes between which they lie
    ends: Vec<Option<[u32; 2]>>,
}

impl<'a> Builder<'a> {
    fn new(mesh: &'a TetMesh) -> Self {
        let nodes = mesh.points.len() as u32;
        let weights = (0..nodes).map(|k| vec![(k, 1.0)]).collect();
        Self { mesh, weights, middles: HashMap::new(), ends: vec![None; nodes as usize] }
    }

    /// Returns ten nodes per cell: those of a quadratic mesh, or those of a linear mesh with new nodes at the midpoints of the edges.
    fn with_mid_nodes(&mut self) -> Vec<u32> {
        if self.mesh.order == Order::Quadratic {
            for c in 0..self.mesh.cell_count() {
                let cell = self.mesh.cell(c);
                let own = CELL_EDGES.iter().enumerate().map(|(e, [i, j])| ([cell[*i], cell[*j]], cell[4 + e]));
                self.middles.extend(own.map(|(ends, middle)| (sorted(ends), middle)));
            }
            return self.mesh.cells.clone();
        }
        let mut cells = Vec::with_capacity(10 * self.mesh.cell_count());
        for c in 0..self.mesh.cell_count() {
            let corners: Vec<u32> = self.mesh.cell(c).to_vec();
            cells.extend(&corners);
            for (e, [i, j]) in CELL_EDGES.into_iter().enumerate() {
                let middle = self.between(corners[i], corners[j], c, CELL_NODES[4 + e]);
                cells.push(middle);
            }
        }
        cells
    }

    /// Returns the node between two others, at `xi` of cell `c`.
    fn between(&mut self, a: u32, b: u32, c: usize, xi: [f64; 3]) -> u32 {
        let Self { mesh, weights, middles, ends } = self;
        *middles.entry(sorted([a, b])).or_insert_with(|| {
            let shape = cell_shape(mesh.order, xi);
            let weighted = mesh.cell(c).iter().zip(shape).filter(|(_, w)| *w != 0.0);
            weights.push(weighted.map(|(node, w)| (*node, w)).collect());
            ends.push(Some([a, b]));
            weights.len() as u32 - 1
        })
    }

    fn known(&self, a: u32, b: u32) -> u32 {
        self.middles[&sorted([a, b])]
    }

    /// Six nodes of a facet.
    fn facet(&self, f: usize) -> [u32; 6] {
        let own = self.mesh.facet(f);
        let middle = FACET_EDGES.map(|[i, j]| self.known(own[i], own[j]));
        [own[0], own[1], own[2], middle[0], middle[1], middle[2]]
    }

    fn position(&self, node: u32) -> crate::math::tensor::Vec3 {
        self.weights[node as usize].iter().map(|(k, w)| self.mesh.points[*k as usize] * *w).sum()
    }

    /// Returns the eight children of a cell with these ten nodes, in terms of reference nodes, with positive volumes.
    fn children(&self, nodes: &[u32]) -> Vec<[usize; 4]> {
        let length = |[a, b]: [usize; 2]| (self.position(nodes[a]) - self.position(nodes[b])).norm();
        let shorter =
            |a: &&([usize; 2], [usize; 4]), b: &&([usize; 2], [usize; 4])| length(a.0).total_cmp(&length(b.0));
        let ([a, b], ring) = DIAGONALS.iter().min_by(shorter).expect("three diagonals");
        let inner = (0..4).map(|k| oriented([*a, *b, ring[k], ring[(k + 1) % 4]]));
        AT_CORNERS.into_iter().chain(inner).collect()
    }

    fn finish(
        self,
        order: Order,
        cells: Vec<u32>,
        facets: Vec<u32>,
        parents: Vec<u32>,
        [cell_parts, facet_parts]: [u32; 2],
    ) -> Enriched {
        let points = (0..self.weights.len() as u32).map(|node| self.position(node)).collect();
        let parts = |of: &[u32], parts: u32| of.iter().flat_map(|k| parts * k..parts * (k + 1)).collect();
        let mut mesh = TetMesh { order, points, cells, facets, regions: BTreeMap::new() };
        let region = |coarse: &Region| {
            let (cells, facets) = (parts(&coarse.cells, cell_parts), parts(&coarse.facets, facet_parts));
            let mut fine = Region { cells, facets, ..coarse.clone() };
            fine.nodes = match coarse.is_node_set && !self.mesh.facets_of(coarse).is_empty() {
                true => mesh.nodes_of_facets(&fine),
                false => self.selected(&coarse.nodes, (order, &mesh.facets), facet_parts),
            };
            fine
        };
        let regions = self.mesh.regions.iter().map(|(name, own)| (name.clone(), region(own))).collect();
        mesh.regions = regions;
        let corner_weights = self.corner_weights(order, &mesh.cells);
        Enriched { mesh, parents, weights: self.weights, corner_weights, ends: self.ends }
    }

    /// Returns the nodes of a region that is given by nodes: a new node belongs to it if both of its ends do. An exception is an edge through the
    /// body from one face of the region to another: its ends are nodes of facets that lie entirely in the region, but the edge lies on none of these
    /// facets.
    fn selected(&self, nodes: &[u32], (order, facets): (Order, &[u32]), facet_parts: u32) -> Vec<u32> {
        if nodes.is_empty() {
            return Vec::new();
        }
        let mut is_own = vec![false; self.mesh.points.len()];
        nodes.iter().for_each(|&node| is_own[node as usize] = true);
        let (mut is_on_facet, children) = (vec![false; self.ends.len()], order.facet_nodes() * facet_parts as usize);
        for (f, fine) in facets.chunks_exact(children).enumerate() {
            if self.mesh.facet(f).iter().all(|&node| is_own[node as usize]) {
                fine.iter().for_each(|&node| is_on_facet[node as usize] = true);
            }
        }
        between(&self.ends, nodes, |node, ends| is_on_facet[node] || !ends.iter().all(|&end| is_on_facet[end as usize]))
    }

    /// Corner weights: each corner of the enriched mesh is a corner of the other mesh, or lies between two of its corners.
    fn corner_weights(&self, order: Order, cells: &[u32]) -> HashMap<u32, Vec<(u32, f64)>> {
        let halves: HashMap<u32, [u32; 2]> = self.middles.iter().map(|(ends, middle)| (*middle, *ends)).collect();
        let corners = cells.chunks_exact(order.cell_nodes()).flat_map(|cell| &cell[..4]);
        let weights = |node: &u32| match halves.get(node) {
            Some([a, b]) => vec![(*a, 0.5), (*b, 0.5)],
            None => vec![(*node, 1.0)],
        };
        corners.map(|node| (*node, weights(node))).collect()
    }
}

/// Returns these nodes and the new nodes between two of them that are `admitted`, in ascending order.
fn between(ends: &[Option<[u32; 2]>], nodes: &[u32], admitted: impl Fn(usize, [u32; 2]) -> bool) -> Vec<u32> {
    let mut is_in = vec![false; ends.len()];
    nodes.iter().for_each(|&node| is_in[node as usize] = true);
    for (node, ends) in ends.iter().enumerate() {
        if let Some(ends) = *ends {
            is_in[node] = ends.iter().all(|&end| is_in[end as usize]) && admitted(node, ends);
        }
    }
    (0..is_in.len() as u32).filter(|node| is_in[*node as usize]).collect()
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Reorders corners such that the volume in the reference cell is positive.
fn oriented(corners: [usize; 4]) -> [usize; 4] {
    let p = corners.map(|k| crate::math::tensor::Vec3::from(CELL_NODES[k]));
    let [a, b, c, d] = corners;
    if (p[1] - p[0]).cross(&(p[2] - p[0])).dot(&(p[3] - p[0])) > 0.0 { [a, b, c, d] } else { [a, b, d, c] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::tensor::Vec3;
    use crate::mesh::made::curved::octant;
    use crate::mesh::made::structured::block;

    fn enriched() -> Vec<(TetMesh, Enriched)> {
        let meshes = [
            block(2, 1, 2, 1.0, 0.7, 1.3, Order::Linear),
            block(1, 2, 1, 1.0, 0.7, 1.3, Order::Quadratic),
            octant(1.0, 2.0, 2, 2, Order::Quadratic),
        ];
        let split = meshes.iter().map(|m| (m.clone(), Enriched::by_splitting(m)));
        let raised = (meshes[0].clone(), Enriched::by_raising(&meshes[0]));
        split.chain([raised]).collect()
    }

    #[test]
    fn volume_area_and_regions_stay() {
        for (mesh, fine) in enriched() {
            // Rounding of sums over a few hundred cells
            let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12 * b.abs(), "{a} and {b}");
            near(fine.mesh.volume(), mesh.volume());
            for (name, region) in &mesh.regions {
                let own = &fine.mesh.regions[name];
                near(fine.mesh.region_volume(&own.cells) + 1.0, mesh.region_volume(&region.cells) + 1.0);
                let (a, b) = (area_vector(&fine.mesh, &own.facets), area_vector(&mesh, &region.facets));
                assert!((a - b).norm() < 1e-12, "{name}: {a} and {b}");
            }
            for (cell, parent) in fine.parents.iter().enumerate() {
                let inside = fine.mesh.cell_volume(cell) <= mesh.cell_volume(*parent as usize) * (1.0 + 1e-12);
                assert!(fine.mesh.cell_volume(cell) > 0.0 && inside);
            }
        }
    }

    /// A surface given by nodes gains exactly the new nodes of its facets: edges through the body from side to side do not count.
    #[test]
    fn a_surface_by_nodes_is_the_one_by_facets() {
        for order in [Order::Linear, Order::Quadratic] {
            let mut mesh = block(2, 3, 2, 1.0, 1.2, 0.8, order);
            let surface = Region { facets: (0..mesh.facet_count() as u32).collect(), ..Region::default() };
            let nodes = Region { nodes: mesh.nodes_of(&surface), ..Region::default() };
            mesh.regions.extend([("facets".to_string(), surface), ("nodes".to_string(), nodes)]);
            let mut enriched = vec![Enriched::by_splitting(&mesh)];
            enriched.extend((order == Order::Linear).then(|| Enriched::by_raising(&mesh)));
            for fine in enriched {
                let of = |name: &str| fine.mesh.nodes_of(&fine.mesh.regions[name]);
                assert_eq!(of("nodes"), of("facets"), "{order:?}");
                let all = fine.with_nodes_between(&mesh.regions["nodes"].nodes);
                assert!(all.len() > of("nodes").len(), "{order:?}: edges go through the body");
            }
        }
    }

    /// A node set of the facets of two adjacent sides gains no new node on a facet of the third side whose corners all belong to it.
    #[test]
    fn a_node_set_of_facets_stays_one() {
        let mut mesh = block(2, 2, 2, 1.0, 1.2, 0.8, Order::Linear);
        let mut sides = mesh.regions["xmax"].clone();
        sides.facets.extend(&mesh.regions["ymin"].facets);
        sides.facets.sort_unstable();
        (sides.nodes, sides.is_node_set) = (mesh.nodes_of_facets(&sides), true);
        mesh.regions.insert("sides".into(), sides);
        let fine = Enriched::by_raising(&mesh).mesh;
        let sides = &fine.regions["sides"];
        assert_eq!(sides.nodes, fine.nodes_of_facets(sides));
        assert_eq!(fine.facets_of(sides), sides.facets);
    }

    /// The nodes of a line, which contains all nodes of no facet, gain the nodes between them.
    #[test]
    fn lines_of_nodes_stay_whole() {
        let mut mesh = block(3, 2, 2, 1.0, 0.7, 1.3, Order::Linear);
        let at_edge = |k: &u32| mesh.points[*k as usize].y == 0.0 && mesh.points[*k as usize].z == 0.0;
        let nodes = (0..mesh.points.len() as u32).filter(at_edge).collect();
        mesh.regions.insert("line".into(), Region { nodes, ..Region::default() });
        assert_eq!(Enriched::by_raising(&mesh).mesh.regions["line"].nodes.len(), 7);
    }

    /// ∫ n dA, whose integrand is quadratic.
    fn area_vector(mesh: &TetMesh, facets: &[u32]) -> Vec3 {
        let rule = crate::mesh::quadrature::tri(2);
        let normals = |f: &u32| -> Vec3 {
            rule.points.iter().zip(&rule.weights).map(|(xi, w)| mesh.facet_normal(*f as usize, *xi) * *w).sum()
        };
        facets.iter().map(normals).sum()
    }

    /// A field of the mesh is the same function on the enriched mesh: at random points of a child it has the value that it has there in the parent.
    #[test]
    fn fields_are_kept() {
        for (mesh, fine) in enriched() {
            let field: Vec<f64> = (0..mesh.points.len()).map(|k| (1.7 * k as f64).sin()).collect();
            let prolonged = fine.prolong(1, &field);
            let value = |mesh: &TetMesh, c: usize, xi: [f64; 3], field: &[f64]| -> f64 {
                mesh.cell(c).iter().zip(cell_shape(mesh.order, xi)).map(|(k, n)| n * field[*k as usize]).sum()
            };
            for (cell, &parent) in fine.parents.iter().enumerate().step_by(5) {
                let xi = [0.15, 0.35, 0.2];
                let at = fine.mesh.position(cell, xi);
                let inner = reference(&mesh, parent as usize, at);
                let (a, b) = (value(&fine.mesh, cell, xi, &prolonged), value(&mesh, parent as usize, inner, &field));
                // Newton's method for the reference position ends at 1e-13.
                assert!((a - b).abs() < 1e-10, "cell {cell}: {a} and {b}");
            }
        }
    }

    /// Returns ξ of a position in a cell, by Newton's method.
    fn reference(mesh: &TetMesh, c: usize, at: Vec3) -> [f64; 3] {
        let mut xi = Vec3::repeat(0.25);
        for _ in 0..30 {
            let off = at - mesh.position(c, xi.into());
            xi += mesh.jacobian(c, xi.into()).try_inverse().expect("positive volume") * off;
        }
        xi.into()
    }
}
