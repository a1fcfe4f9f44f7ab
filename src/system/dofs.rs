//! Which unknowns are free, and in which order they are eliminated.

use super::Blocks;
use crate::math::ordering::fill_reducing;
use crate::math::signal::Signal;
use crate::math::sparse::SymPattern;

/// A displacement component that follows a signal.
#[derive(Clone, Debug)]
pub struct Prescribed {
    /// 3·node + component
    pub dof: u32,
    /// [m]
    pub signal: Signal,
}

/// Numbering of the free unknowns. Prescribed ones are eliminated: the reaction is the residual there.
#[derive(Clone, Debug)]
pub struct Dofs {
    /// [3 × nodes + scalars] equation of a dof, [`Dofs::FIXED`] where it is prescribed
    pub equation: Vec<u32>,
    /// [equations] dof of an equation
    pub free: Vec<u32>,
    /// Dofs below this are displacements
    pub displacements: u32,
}

impl Dofs {
    pub const FIXED: u32 = u32::MAX;

    /// Numbers the free dofs in the elimination order of the node graph (3×3 blocks stay together); a scalar of the second
    /// field follows the node that hosts it.
    pub fn new<'a>(
        nodes: usize,
        hosts: &[u32],
        prescribed: &[Prescribed],
        blocks: impl Iterator<Item = &'a Blocks> + Clone,
    ) -> Self {
        let displacements = 3 * nodes as u32;
        let mut equation = vec![0; 3 * nodes + hosts.len()];
        for p in prescribed {
            equation[p.dof as usize] = Self::FIXED;
        }
        let mut guests = vec![Vec::new(); nodes];
        for (dof, &host) in (displacements..).zip(hosts) {
            guests[host as usize].push(dof);
        }
        let pairs = blocks.flat_map(|list| {
            (0..list.len()).flat_map(move |b| {
                let n = list.nodes(b);
                n.iter().enumerate().flat_map(move |(k, &i)| n[..k].iter().map(move |&j| (i, j)))
            })
        });
        let mut free = Vec::with_capacity(equation.len());
        for node in fill_reducing(&SymPattern::from_pairs(nodes, pairs)) {
            for dof in (3 * node..3 * node + 3).chain(guests[node as usize].iter().copied()) {
                if equation[dof as usize] != Self::FIXED {
                    equation[dof as usize] = free.len() as u32;
                    free.push(dof);
                }
            }
        }
        Self { equation, free, displacements }
    }

    /// Is equation `e` one of the second field?
    pub fn is_scalar(&self, e: usize) -> bool {
        self.free[e] >= self.displacements
    }
}
