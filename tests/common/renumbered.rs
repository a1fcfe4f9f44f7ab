//! One mesh with other numbers.

use durometer::mesh::TetMesh;

/// Nodes and cells in another order; `below` draws a number below its argument.
pub fn renumbered(mesh: &TetMesh, below: &mut dyn FnMut(usize) -> usize) -> TetMesh {
    let mut order = |n: usize| {
        let mut all: Vec<u32> = (0..n as u32).collect();
        (1..n).rev().for_each(|k| all.swap(k, below(k + 1)));
        all
    };
    let (nodes, cells) = (order(mesh.points.len()), order(mesh.cell_count()));
    // nodes[old] = new, cells[new] = old
    let mut points = mesh.points.clone();
    nodes.iter().zip(&mesh.points).for_each(|(&new, p)| points[new as usize] = *p);
    let renamed = |list: &[u32]| list.iter().map(|&k| nodes[k as usize]).collect::<Vec<u32>>();
    let mut place = vec![0; cells.len()];
    cells.iter().enumerate().for_each(|(new, &old)| place[old as usize] = new as u32);
    let mut regions = mesh.regions.clone();
    for region in regions.values_mut() {
        region.cells = region.cells.iter().map(|&c| place[c as usize]).collect();
        region.nodes = renamed(&region.nodes);
        region.cells.sort_unstable();
        region.nodes.sort_unstable();
    }
    TetMesh {
        order: mesh.order,
        points,
        cells: cells.iter().flat_map(|&old| renamed(mesh.cell(old as usize))).collect(),
        facets: renamed(&mesh.facets),
        regions,
    }
}
