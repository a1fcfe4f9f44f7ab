//! Places of the pressures of a mixed formulation, which are continuous within groups of cells.
//!
//! The volume of a cell whose deformation is given says nothing about that of the cells around it. With one pressure for both, the mean of two that differ
//! would act on either side of their border, so that these cells are in groups of their own.

use crate::mesh::TetMesh;

/// Corners that carry a pressure in the cells of a region, one for each group of the cells around.
#[derive(Clone, Debug)]
pub struct PressureHosts {
    /// (group, node) of each pressure, ascending
    pub places: Vec<(u32, u32)>,
    /// \[cells of the region\] the pressures at the corners, by their number in `places`
    pub of_cells: Vec<[u32; 4]>,
}

impl PressureHosts {
    /// `groups` \[cells of the mesh\] is the group of each cell; where it is empty all are of group 0.
    pub fn new(mesh: &TetMesh, cells: &[u32], groups: &[u32]) -> Self {
        let at = |c: u32| {
            let group = groups.get(c as usize).copied().unwrap_or(0);
            let corners = &mesh.cell(c as usize)[..4];
            [0, 1, 2, 3].map(|k| (group, corners[k]))
        };
        let mut places: Vec<(u32, u32)> = cells.iter().flat_map(|&c| at(c)).collect();
        places.sort_unstable();
        places.dedup();
        let number = |place: &(u32, u32)| places.binary_search(place).expect("hosts are the corners") as u32;
        let of_cells = cells.iter().map(|&c| at(c).each_ref().map(number)).collect();
        Self { places, of_cells }
    }

    /// The node of each pressure.
    pub fn nodes(&self) -> impl Iterator<Item = u32> + '_ {
        self.places.iter().map(|(_, node)| *node)
    }

    /// The number of the pressure of a group at a node.
    pub fn number(&self, group: u32, node: u32) -> Option<usize> {
        self.places.binary_search(&(group, node)).ok()
    }
}
