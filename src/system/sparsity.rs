//! Sparsity of the tangent: the numbering of the unknowns, the pattern of K, and the slot of every local entry in it.

use super::dofs::MeanGraph;
use super::groups::{self, Groups};
use super::{Blocks, Dofs, Means, Prescribed, Ties};
use crate::math::low_rank::{LowRank, Pattern};
use crate::math::sparse::SymPattern;
use std::rc::Rc;
use std::sync::Arc;

/// Blocks that contribute to the tangent.
#[derive(Clone, Copy)]
pub(super) struct TangentBlocks<'a> {
    pub blocks: &'a Blocks,
    /// Means through which they depend on the body, if any
    pub means: Option<&'a Arc<Means>>,
    /// Whether all of them contribute at every state and are summed in groups
    pub in_groups: bool,
}

/// Slots in K of the local entries of a list of blocks.
pub(super) enum Slots {
    /// Slot of each entry with column ≤ row, block after block
    Entries(Vec<u32>),
    Groups(Groups),
}

/// Numbering, pattern and slots.
pub(super) struct Sparsity {
    pub dofs: Dofs,
    pub pattern: Pattern,
    /// Per list of blocks
    pub slots: Vec<Slots>,
}

impl Sparsity {
    /// Builds numbering and pattern for these lists of blocks, given the prescribed dofs and the ties; `None` if no dof is free.
    pub fn new(nodes: usize, hosts: &[u32], held: (&[Prescribed], &Ties), all: &[TangentBlocks]) -> Option<Self> {
        let direct = || all.iter().filter(|list| list.means.is_none()).map(|list| list.blocks);
        let coupled = CoupledMeans::new(all);
        let dofs = Dofs::new(nodes, hosts, held, direct(), &coupled.graph);
        if dofs.free.is_empty() {
            return None;
        }
        let pattern = Pattern::new(sparse(&dofs, direct()), coupled.low_rank(&dofs));
        let of_blocks = |&TangentBlocks { blocks, means, in_groups }: &TangentBlocks| match means {
            Some(means) => Slots::Entries(coupled.slots(&pattern, means, blocks)),
            None if in_groups => Slots::Groups(groups::divide(blocks, &dofs, &pattern)),
            None => Slots::Entries(slots(&dofs, &pattern, blocks)),
        };
        let slots = all.iter().map(of_blocks).collect();
        Some(Self { dofs, pattern, slots })
    }
}

/// The pattern of K. All unknowns of a node couple with the same other unknowns, so that pairs of nodes are sorted instead of pairs of unknowns.
fn sparse<'a>(dofs: &Dofs, all: impl Iterator<Item = &'a Blocks>) -> SymPattern {
    let (mut first, mut of_equation, mut last) = (Vec::new(), Vec::with_capacity(dofs.free.len()), None);
    for (e, &dof) in dofs.free.iter().enumerate() {
        if last.replace(dofs.vertex(dof)) != Some(dofs.vertex(dof)) {
            first.push(e as u32);
        }
        of_equation.push(first.len() as u32 - 1);
    }
    let vertices = first.len();
    first.push(dofs.free.len() as u32);
    let of_equation = &of_equation;
    let pairs = all.flat_map(|list| {
        (0..list.len()).flat_map(move |b| {
            let equations = equations(dofs, list, b);
            let free = equations.iter().filter(|e| **e != Dofs::FIXED);
            let mut vertices: Vec<u32> = free.map(|&e| of_equation[e as usize]).collect();
            vertices.dedup();
            let vertices = vertices.as_slice();
            let below = |i: usize| vertices[..i].iter().map(move |&column| (vertices[i], column));
            (0..vertices.len()).flat_map(below).collect::<Vec<_>>()
        })
    });
    let graph = SymPattern::from_pairs(vertices, pairs);
    let mut pattern = SymPattern { n: dofs.free.len(), col_ptr: vec![0], row_idx: Vec::new() };
    for v in 0..vertices {
        let below = &graph.row_idx[graph.col_ptr[v] as usize..graph.col_ptr[v + 1] as usize];
        for j in first[v]..first[v + 1] {
            let of_vertex = |&w: &u32| first[w as usize].max(j)..first[w as usize + 1];
            pattern.row_idx.extend(below.iter().flat_map(of_vertex));
            pattern.col_ptr.push(pattern.row_idx.len() as u32);
        }
    }
    pattern
}

fn equations(dofs: &Dofs, list: &Blocks, b: usize) -> Rc<[u32]> {
    list.dofs(b).map(|dof| dofs.equation[dof as usize]).collect()
}

/// Slots of the entries of blocks of dofs; [`Dofs::FIXED`] where a dof is prescribed.
fn slots(dofs: &Dofs, pattern: &Pattern, list: &Blocks) -> Vec<u32> {
    let mut out = Vec::new();
    for b in 0..list.len() {
        let equations = equations(dofs, list, b);
        for (i, &row) in equations.iter().enumerate() {
            for &column in &equations[..=i] {
                out.push(if row == Dofs::FIXED || column == Dofs::FIXED {
                    Dofs::FIXED
                } else {
                    pattern.slot(row, column).expect("the pattern holds every pair of a block")
                });
            }
        }
    }
    out
}

/// The means of a system, each set included once, and their couplings.
struct CoupledMeans<'a> {
    /// Sets of means, each with the index of its first mean
    sets: Vec<(&'a Arc<Means>, u32)>,
    graph: MeanGraph,
}

impl<'a> CoupledMeans<'a> {
    fn new(all: &[TangentBlocks<'a>]) -> Self {
        let mut out = Self { sets: Vec::new(), graph: MeanGraph::default() };
        for (means, list) in all.iter().filter_map(|list| Some((list.means?, list.blocks))) {
            let first = out.first(means).unwrap_or_else(|| {
                let first = out.graph.count as u32;
                let of_mean = |(k, list): (u32, &Vec<(u32, f64)>)| list.iter().map(|n| (k, n.0)).collect::<Vec<_>>();
                out.graph.nodes.extend((first..).zip(means.lists()).flat_map(of_mean));
                out.sets.push((means, first));
                out.graph.count += means.len();
                first
            });
            for b in 0..list.len() {
                let block = list.nodes(b);
                let pairs = block.iter().enumerate().flat_map(|(a, &k)| block[..=a].iter().map(move |&l| (k, l)));
                out.graph.pairs.extend(pairs.map(|(k, l)| (first + k, first + l)));
            }
        }
        out
    }

    /// Index of the first mean of a set.
    fn first(&self, means: &Arc<Means>) -> Option<u32> {
        self.sets.iter().find(|(set, _)| Arc::ptr_eq(set, means)).map(|(_, first)| *first)
    }

    /// B on the free dofs, three columns per mean, and the pattern of S.
    fn low_rank(&self, dofs: &Dofs) -> LowRank {
        if self.graph.count == 0 {
            return LowRank::default();
        }
        let lists = self.sets.iter().flat_map(|(means, _)| means.lists());
        let column = |list: &Vec<(u32, f64)>, i: u32| {
            let entries = list.iter().map(|&(node, w)| (dofs.equation[(3 * node + i) as usize], w));
            let mut entries: Vec<(u32, f64)> = entries.filter(|(equation, _)| *equation != Dofs::FIXED).collect();
            entries.sort_by_key(|(equation, _)| *equation);
            entries
        };
        let columns = lists.flat_map(|list| (0..3).map(move |i| column(list, i))).collect();
        let components = (0..3).flat_map(|i| (0..3).map(move |j| (i, j)));
        let pairs = self.graph.pairs.iter();
        let pairs = pairs.flat_map(|&(k, l)| components.clone().map(move |(i, j)| (3 * k + i, 3 * l + j)));
        let after = dofs.after.iter().flat_map(|&equations| [equations; 3]).collect();
        LowRank { columns, inner: Some(SymPattern::from_pairs(3 * self.graph.count, pairs)), after }
    }

    /// Slots in S of the entries of blocks of means.
    fn slots(&self, pattern: &Pattern, means: &Arc<Means>, list: &Blocks) -> Vec<u32> {
        let first = 3 * self.first(means).expect("its means are in the list");
        let mut out = Vec::new();
        for b in 0..list.len() {
            let columns: Vec<u32> = list.dofs(b).map(|dof| first + dof).collect();
            for (i, &row) in columns.iter().enumerate() {
                let slot = |column: &u32| pattern.inner_slot(row, *column).expect("S holds every pair of a block");
                out.extend(columns[..=i].iter().map(slot));
            }
        }
        out
    }
}
