//! Groups of cells by the cause of their deformation: the unknowns, or only the motions of constraints.

use super::part::{Motion, Moved};
use crate::mesh::{Region, TetMesh};
use std::collections::{BTreeMap, HashMap};

/// The group of each cell \[cells\]. Group 0 holds the cells that the unknowns deform. Cells whose nodes are all held, prescribed or in one rigid part are in
/// further groups: one group for all cells that the same constraints move, which therefore share their volumetric strain, and one for each cell between
/// different motions.
pub(super) fn cell_groups<'a>(
    mesh: &TetMesh,
    regions: &BTreeMap<String, Region>,
    moved: impl Iterator<Item = Moved<'a>>,
) -> Vec<u32> {
    let mut motions = vec![[Motion::Free; 3]; mesh.points.len()];
    for moved in moved {
        // A region that does not exist is refused where the constraint is built
        let Some(region) = regions.get(moved.region) else { continue };
        // A rigid part consists of cells, whatever nodes of its own its region has
        let of_cells = Region { cells: region.cells.clone(), ..Region::default() };
        let region = if matches!(moved.motion, Motion::Rigid(_)) { &of_cells } else { region };
        let components: Vec<usize> = moved.components.chars().filter_map(|c| "xyz".find(c)).collect();
        for node in mesh.nodes_of(region) {
            for &k in &components {
                let own = &mut motions[node as usize][k];
                if *own == Motion::Free {
                    *own = moved.motion;
                }
            }
        }
    }
    let mut count = 0;
    let mut next = || {
        count += 1;
        count
    };
    let mut alike = HashMap::new();
    let group = |c: usize| {
        let first = motions[mesh.cell(c)[0] as usize];
        let all = || mesh.cell(c).iter().map(|&node| motions[node as usize]);
        let any = |is: fn(&Motion) -> bool| all().flatten().any(|motion| is(&motion));
        if any(|motion| *motion == Motion::Free) {
            0
        } else if all().all(|own| own == first) {
            *alike.entry(first).or_insert_with(&mut next)
        } else if any(|motion| matches!(motion, Motion::Rigid(_))) {
            0
        } else {
            next()
        }
    };
    (0..mesh.cell_count()).map(group).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Order;
    use crate::mesh::structured::block;

    /// The groups in three boxes in a row, of which constraints move the nodes of the first and of the last as given: (region, components, motion).
    fn groups(order: Order, moved: &[(&'static str, &'static str, Motion)]) -> [Vec<u32>; 3] {
        let mesh = block(3, 1, 1, 3.0, 1.0, 1.0, order);
        let nodes = |is_in: fn(f64) -> bool| {
            let is_own = |k: &u32| is_in(mesh.points[*k as usize].x);
            let nodes = (0..mesh.points.len() as u32).filter(is_own).collect();
            let cells = (0..mesh.cell_count() as u32).filter(|&c| mesh.cell(c as usize).iter().all(is_own)).collect();
            Region { nodes, cells, ..Region::default() }
        };
        let regions = [("root".to_string(), nodes(|x| x < 1.1)), ("tip".to_string(), nodes(|x| x > 1.9))].into();
        let moved = moved.iter().map(|&(region, components, motion)| Moved { region, components, motion });
        let groups = cell_groups(&mesh, &regions, moved);
        [0, 1, 2].map(|k| {
            let own = (0..groups.len()).filter(|&c| mesh.position(c, [0.25; 3]).x as usize == k);
            own.map(|c| groups[c]).collect()
        })
    }

    /// A node set with the name of a rigid part does not change its cells.
    #[test]
    fn a_rigid_part_is_one_of_cells() {
        let mesh = block(2, 1, 1, 2.0, 1.0, 1.0, Order::Linear);
        let cells: Vec<u32> =
            (0..mesh.cell_count() as u32).filter(|&c| mesh.position(c as usize, [0.25; 3]).x < 1.0).collect();
        let of = |region: Region| {
            let moved = Moved { region: "plate", components: "xyz", motion: Motion::Rigid(1) };
            cell_groups(&mesh, &[("plate".to_string(), region)].into(), std::iter::once(moved))
        };
        let plain = of(Region { cells: cells.clone(), ..Region::default() });
        assert_eq!(plain.iter().filter(|group| **group == 1).count(), cells.len());
        assert_eq!(of(Region { cells, nodes: vec![0], is_node_set: true, ..Region::default() }), plain);
    }

    /// Cells of a part that is held or moved as a whole are one group, cells between two such parts are one group each, and all others are in group 0.
    #[test]
    fn cells_that_constraints_move_are_grouped_by_their_motion() {
        for order in [Order::Linear, Order::Quadratic] {
            // Mid-nodes between the two parts are free on quadratic cells
            let between = if order == Order::Linear { vec![2, 3, 4, 5, 6, 7] } else { vec![0; 6] };
            let last = if order == Order::Linear { 8 } else { 2 };
            let (root, tip) = (("root", "xyz", Motion::Held), ("tip", "xyz", Motion::Prescribed(1)));
            assert_eq!(groups(order, &[root, tip]), [vec![1; 6], between, vec![last; 6]]);
            let rigid = ("tip", "xyz", Motion::Rigid(1));
            assert_eq!(groups(order, &[root, rigid]), [vec![1; 6], vec![0; 6], vec![2; 6]]);
            let parts = [("root", "z", Motion::Held), ("root", "xy", Motion::Prescribed(1))];
            assert_eq!(groups(order, &parts), [vec![1; 6], vec![0; 6], vec![0; 6]]);
            let parts = [("root", "xy", Motion::Held), ("tip", "z", Motion::Held)];
            assert_eq!(groups(order, &parts).concat(), [0; 18]);
        }
    }
}
