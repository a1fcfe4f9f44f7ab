//! The assignment of unknowns to displacements of nodes, and the rigid motions of the nodes.
//!
//! ```text
//! u_a = e_k,  u_a = e_k × (x_a − x̄)/L,  k = 1, 2, 3,  x̄ the mean and L the largest distance from it
//! ```
//!
//! The tangent resists these motions little, whatever the material of the body: without held nodes translations have no stiffness, and rotations
//! about the current position only the one that stems from the stress.

use super::blocks::Block;
use crate::math::tensor::Vec3;

/// The unknowns of a matrix as displacements of nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Places {
    /// \[equations\] 3·node + component; those of a node are consecutive
    pub dofs: Vec<u32>,
    /// \[nodes\] positions X at rest \[m\]
    pub points: Vec<Vec3>,
}

impl Places {
    /// Nodes with an equation, in the order of the equations.
    pub fn nodes(&self) -> Vec<u32> {
        let mut nodes: Vec<u32> = self.dofs.iter().map(|dof| dof / 3).collect();
        nodes.dedup();
        nodes
    }

    /// \[equations\] index into [`Places::nodes`], and component.
    pub fn components(&self) -> Vec<(u32, u8)> {
        let mut block = 0;
        let mut last = self.dofs.first().map_or(0, |dof| dof / 3);
        let component = |&dof: &u32| {
            if dof / 3 != last {
                (block, last) = (block + 1, dof / 3);
            }
            (block, (dof % 3) as u8)
        };
        self.dofs.iter().map(component).collect()
    }

    /// The six rigid motions of each node that has an equation; components without an equation are zero. `displacement` is \[3 × nodes\] u \[m\], or
    /// empty at rest.
    pub fn rigid_modes(&self, displacement: &[f64]) -> Vec<Block<3, 6>> {
        let nodes = self.nodes();
        let at = |&n: &u32| {
            let n = n as usize;
            let u = displacement.get(3 * n..3 * n + 3).map_or_else(Vec3::zeros, Vec3::from_column_slice);
            self.points[n] + u
        };
        let centre = nodes.iter().map(at).sum::<Vec3>() / nodes.len() as f64;
        let size = nodes.iter().map(|n| (at(n) - centre).norm()).fold(f64::MIN_POSITIVE, f64::max);
        let mut modes = vec![[[0.0; 3]; 6]; nodes.len()];
        for (&(block, c), dof) in self.components().iter().zip(&self.dofs) {
            let (mode, c) = (&mut modes[block as usize], c as usize);
            let arm = (at(&(dof / 3)) - centre) / size;
            mode[c][c] = 1.0;
            // (e_k × arm)_c
            mode[3 + (c + 1) % 3][c] = arm[(c + 2) % 3];
            mode[3 + (c + 2) % 3][c] = -arm[(c + 1) % 3];
        }
        modes
    }
}
