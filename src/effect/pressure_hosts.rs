//! Pressure unknowns of a mixed formulation, which are continuous within groups of cells.
//!
//! The volume of a cell with prescribed deformation does not determine that of the cells around it. With a common pressure, the mean of two different
//! pressures would act on both sides of their interface; such cells are therefore in separate groups.

use crate::mesh::TetMesh;

/// Corners that carry a pressure in the cells of a region, one for each group of cells around the corner.
#[derive(Clone, Debug)]
pub struct PressureHosts {
    /// (group, node) of each pressure, ascending
    pub places: Vec<(u32, u32)>,
    /// \[cells of the region\] the pressures at the corners, by their index in `places`
    pub of_cells: Vec<[u32; 4]>,
}

impl PressureHosts {
    /// Builds the hosts; `groups` \[cells of the mesh\] contains the group of each cell; if it is empty, all cells belong to group 0.
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

    /// Returns the index of the pressure of a group at a node.
    pub fn number(&self, group: u32, node: u32) -> Option<usize> {
        self.places.binary_search(&(group, node)).ok()
    }
}
