//! Which unknowns are free, and in which order they are eliminated.

use super::Blocks;
use crate::math::signal::Signal;
use crate::math::sparse::{SymPattern, minimum_degree};

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
    /// [3 × nodes] equation of a dof, [`Dofs::FIXED`] where it is prescribed
    pub equation: Vec<u32>,
    /// [equations] dof of an equation
    pub free: Vec<u32>,
}

impl Dofs {
    pub const FIXED: u32 = u32::MAX;

    /// Numbers the free dofs in the elimination order of the node graph (3×3 blocks stay together).
    pub fn new<'a>(nodes: usize, prescribed: &[Prescribed], blocks: impl Iterator<Item = &'a Blocks> + Clone) -> Self {
        let mut equation = vec![0; 3 * nodes];
        for p in prescribed {
            equation[p.dof as usize] = Self::FIXED;
        }
        let pairs = blocks.flat_map(|list| {
            (0..list.len()).flat_map(move |b| {
                let n = list.nodes(b);
                n.iter().enumerate().flat_map(move |(k, &i)| n[..k].iter().map(move |&j| (i, j)))
            })
        });
        let mut free = Vec::with_capacity(3 * nodes);
        for node in minimum_degree(&SymPattern::from_pairs(nodes, pairs)) {
            for dof in 3 * node..3 * node + 3 {
                if equation[dof as usize] != Self::FIXED {
                    equation[dof as usize] = free.len() as u32;
                    free.push(dof);
                }
            }
        }
        Self { equation, free }
    }
}
