//! The polynomial order of the cells.

/// Polynomial order of the cells, which determines the element: `tet4` (4 nodes) or `tet10` (10 nodes).
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash)]
pub enum Order {
    Linear,
    Quadratic,
}

impl Order {
    /// Nodes per cell: 4 or 10.
    pub const fn cell_nodes(self) -> usize {
        match self {
            Self::Linear => 4,
            Self::Quadratic => 10,
        }
    }

    /// Nodes per facet: 3 or 6.
    pub const fn facet_nodes(self) -> usize {
        match self {
            Self::Linear => 3,
            Self::Quadratic => 6,
        }
    }
}
