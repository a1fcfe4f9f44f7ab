//! Numbering of the free unknowns in elimination order.

use super::{Blocks, Ties};
use crate::math::ordering::fill_reducing;
use crate::math::signal::Signal;
use crate::math::sparse::SymPattern;

/// A displacement component that follows a signal.
#[derive(Clone, Debug)]
pub struct Prescribed {
    /// Index 3·node + component
    pub dof: u32,
    /// Displacement \[m\] over time
    pub signal: Signal,
}

/// Weighted means as vertices of the elimination graph.
#[derive(Default)]
pub(super) struct MeanGraph {
    /// Number of means
    pub count: usize,
    /// Pairs of means in one block
    pub pairs: Vec<(u32, u32)>,
    /// Pairs (mean, node)
    pub nodes: Vec<(u32, u32)>,
}

/// Number of nodes that are eliminated after all means. Without them K would be singular in a body that is held through means alone.
const LAST: usize = 8;

/// The numbering of the free unknowns. Prescribed dofs are eliminated; the residual there is the reaction.
#[derive(Clone, Debug)]
pub struct Dofs {
    /// \[3 × nodes + scalars\] equation of each dof; [`Dofs::FIXED`] if it is prescribed or follows others
    pub equation: Vec<u32>,
    /// \[equations\] dof of each equation
    pub free: Vec<u32>,
    /// Number of displacement dofs, which come first
    pub displacements: u32,
    /// Per mean: number of equations that are eliminated before it
    pub after: Vec<u32>,
}

impl Dofs {
    pub const FIXED: u32 = u32::MAX;

    /// Numbers the free dofs in the elimination order of the node graph (3×3 blocks stay together); a scalar of the second field follows the node
    /// that hosts it. A mean is also a vertex of the graph, coupled to its nodes and to the means in its blocks.
    pub(super) fn new<'a>(
        nodes: usize,
        hosts: &[u32],
        (prescribed, ties): (&[Prescribed], &Ties),
        blocks: impl Iterator<Item = &'a Blocks> + Clone,
        means: &MeanGraph,
    ) -> Self {
        let displacements = 3 * nodes as u32;
        let mut equation = vec![0; 3 * nodes + hosts.len()];
        for p in prescribed {
            equation[p.dof as usize] = Self::FIXED;
        }
        for node in ties.nodes() {
            equation[3 * node as usize..][..3].fill(Self::FIXED);
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
        let first = nodes as u32;
        let of_means = means.pairs.iter().map(|&(k, l)| (first + k, first + l));
        let to_nodes = means.nodes.iter().map(|&(k, node)| (first + k, node));
        let graph = SymPattern::from_pairs(nodes + means.count, pairs.chain(of_means).chain(to_nodes));
        let order = means_before_the_last_nodes(fill_reducing(&graph), first);
        let (mut free, mut after) = (Vec::with_capacity(equation.len()), vec![0; means.count]);
        for node in order {
            if node >= first {
                after[(node - first) as usize] = free.len() as u32;
                continue;
            }
            for dof in (3 * node..3 * node + 3).chain(guests[node as usize].iter().copied()) {
                if equation[dof as usize] != Self::FIXED {
                    equation[dof as usize] = free.len() as u32;
                    free.push(dof);
                }
            }
        }
        Self { equation, free, displacements, after }
    }

    /// The vertex of a dof: its node, or the dof itself if it belongs to the second field.
    pub(super) fn vertex(&self, dof: u32) -> u32 {
        if dof < self.displacements { dof / 3 } else { dof }
    }

    /// Whether equation `e` belongs to the second field.
    pub fn is_scalar(&self, e: usize) -> bool {
        self.free[e] >= self.displacements
    }
}

/// Moves the means, which are numbered from `first` on, before the last nodes of an order. The last vertices of an elimination order are all coupled
/// with each other anyway.
fn means_before_the_last_nodes(order: Vec<u32>, first: u32) -> Vec<u32> {
    let nodes = order.iter().enumerate().rev().filter(|(_, v)| **v < first);
    let start = nodes.take(LAST).last().map_or(0, |(place, _)| place);
    let (means, last): (Vec<u32>, Vec<u32>) = order[start..].iter().partition(|v| **v >= first);
    [&order[..start], &means, &last].concat()
}
