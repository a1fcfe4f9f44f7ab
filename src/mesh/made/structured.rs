//! Blocks of Kuhn tetrahedra, made without a mesher: for tests, benches and the smallest scenes.

use crate::math::tensor::Vec3;
use crate::mesh::element::CELL_EDGES;
use crate::mesh::file::assemble::add_body;
use crate::mesh::surface::boundary::add_boundary;
use crate::mesh::{Order, Region, TetMesh};
use std::collections::{BTreeMap, HashMap};

/// Builds a block \[0, lx\] × \[0, ly\] × \[0, lz\] \[m\] of nx × ny × nz boxes, each cut into 6 tetrahedra along its diagonal, with the regions
/// `xmin`, `xmax`, `ymin`, `ymax`, `zmin`, `zmax`.
///
/// ```
/// use durometer::prelude::*;
///
/// let mesh = block(2, 1, 1, 0.02, 0.01, 0.01, Order::Linear);
/// assert_eq!(mesh.points.len(), 12);
/// assert!(mesh.regions.contains_key("xmin"));
/// ```
pub fn block(nx: usize, ny: usize, nz: usize, lx: f64, ly: f64, lz: f64, order: Order) -> TetMesh {
    let node = |i: usize, j: usize, k: usize| (i + (nx + 1) * (j + (ny + 1) * k)) as u32;
    let at = |i: usize, n: usize, l: f64| l * i as f64 / n as f64;
    let mut mesh = TetMesh { order, points: vec![], cells: vec![], facets: vec![], regions: BTreeMap::new() };
    for k in 0..=nz {
        for j in 0..=ny {
            mesh.points.extend((0..=nx).map(|i| Vec3::new(at(i, nx, lx), at(j, ny, ly), at(k, nz, lz))));
        }
    }
    // Every permutation of the axes is a path from corner (0,0,0) to (1,1,1); odd ones are reoriented to positive volume.
    const PATHS: [([usize; 3], bool); 6] = [
        ([0, 1, 2], true),
        ([1, 2, 0], true),
        ([2, 0, 1], true),
        ([0, 2, 1], false),
        ([1, 0, 2], false),
        ([2, 1, 0], false),
    ];
    let mut linear = Vec::with_capacity(24 * nx * ny * nz);
    for (k, j, i) in (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| (k, j, i)))) {
        for (path, even) in PATHS {
            let mut p = [i, j, k];
            let mut cell = [node(i, j, k); 4];
            for (step, axis) in path.into_iter().enumerate() {
                p[axis] += 1;
                cell[step + 1] = node(p[0], p[1], p[2]);
            }
            if !even {
                cell.swap(1, 2);
            }
            linear.extend(cell);
        }
    }
    match order {
        Order::Linear => mesh.cells = linear,
        Order::Quadratic => add_mid_nodes(&mut mesh, &linear),
    }
    add_boundary(&mut mesh);
    add_body(&mut mesh);
    for (axis, (names, l)) in
        [(["xmin", "xmax"], lx), (["ymin", "ymax"], ly), (["zmin", "zmax"], lz)].into_iter().enumerate()
    {
        for (name, value) in names.into_iter().zip([0.0, l]) {
            let on = |f: &u32| {
                mesh.facet(*f as usize).iter().all(|&i| (mesh.points[i as usize][axis] - value).abs() < 1e-9 * l)
            };
            let facets = (0..mesh.facet_count() as u32).filter(on).collect();
            mesh.regions.insert(name.into(), Region { facets, ..Region::default() });
        }
    }
    mesh
}

/// Appends straight mid-edge nodes to linear cells.
fn add_mid_nodes(mesh: &mut TetMesh, linear: &[u32]) {
    let mut middle: HashMap<[u32; 2], u32> = HashMap::new();
    for corners in linear.chunks_exact(4) {
        mesh.cells.extend(corners);
        for [a, b] in CELL_EDGES {
            let (a, b) = (corners[a].min(corners[b]), corners[a].max(corners[b]));
            let points = &mut mesh.points;
            let node = *middle.entry([a, b]).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]) / 2.0);
                (points.len() - 1) as u32
            });
            mesh.cells.push(node);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::file::validate::min_det;
    use crate::mesh::made::disturb::distort;

    #[test]
    fn a_block_fills_its_box_and_its_surface_closes() {
        for order in [Order::Linear, Order::Quadratic] {
            let mut mesh = block(3, 2, 4, 0.3, 0.1, 0.2, order);
            distort(&mut mesh, 7, 0.2);
            assert_eq!((mesh.cell_count(), mesh.facet_count()), (144, 104));
            assert!((mesh.volume() / 0.006 - 1.0).abs() < 1e-13);
            assert!((0..144).all(|c| min_det(&mesh, c) > 0.0));
            for (name, area) in [("xmin", 0.02), ("ymax", 0.06), ("zmin", 0.03)] {
                assert!((mesh.region_area(&mesh.regions[name].facets) / area - 1.0).abs() < 1e-13, "{name}");
            }
            // Gauss: ∮ x·n dA = 3 V requires every facet, oriented outward.
            let flux: f64 = (0..mesh.facet_count())
                .map(|f| {
                    let x = mesh.facet(f)[..3].iter().map(|&i| mesh.points[i as usize]).sum::<Vec3>() / 3.0;
                    0.5 * mesh.facet_normal(f, [1.0 / 3.0; 2]).dot(&x)
                })
                .sum();
            assert!((flux / 0.018 - 1.0).abs() < 1e-13);
        }
    }
}
