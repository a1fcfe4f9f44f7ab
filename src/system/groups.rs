//! Groups of consecutive blocks, which are summed separately and then added in order.
//!
//! An assembly is distributed over threads by groups. A group is small enough for its sums to stay in the cache, which also makes it faster on one
//! thread: the entries of K that several blocks of a group share are added to the large matrix once. The groups depend only on the blocks, and their
//! sums are added in order, so that the results are bit-identical for any number of threads.

use super::projection::project;
use super::vertex_pairs::{Components, LARGEST, Pair, Places, triangle};
use super::{Assembled, At, Batch, Batched, BlockValues, Blocks, Dofs, Effect, EvalError, Want};
use crate::math::lanes::{LANES, Lanes};
use crate::math::low_rank::Pattern;
use crate::math::ranked_set::RankedSet;
use crate::math::sparse::SymPattern;
use crate::math::threads;
use crate::math::vector::norm;
use std::ops::Range;

/// Largest numbers of local entries of K in a group, and of distinct ones among them: as many as fit into the cache.
const MOST: (usize, usize) = (100_000, 50_000);
/// Number of groups whose sums wait to be added: as many as fit into the cache.
const WAITING: usize = 16;
/// Smallest number of entries of K that one thread adds at a time.
const PIECE: u32 = 1 << 16;

/// Blocks in groups.
pub(super) struct Groups {
    groups: Vec<Group>,
    /// Slots at which K is divided for threads, each the first slot of a vertex, and the end
    pieces: Vec<u32>,
}

/// A range of blocks, and the positions of their unknowns and entries in its sums.
struct Group {
    blocks: Range<usize>,
    /// Number of unknowns of the largest block
    largest: usize,
    /// Unknowns of the blocks
    dofs: Vec<u32>,
    /// [`Places::vertices`] in `dofs`, block after block
    of_vertices: Vec<u32>,
    /// Distinct pairs of vertices, in ascending order of their slots
    pairs: Vec<Pair>,
    /// [`Places::pairs`] in the sums, block after block; pairs without an entry in K point past the last one
    of_pairs: Vec<u32>,
    /// Number of entries in the sums of all pairs
    entries: u32,
}

/// Divides blocks whose couplings are in the pattern into groups.
pub(super) fn divide(blocks: &Blocks, dofs: &Dofs, pattern: &Pattern) -> Groups {
    let mut ranges = Vec::new();
    let mut start = 0;
    while start < blocks.len() {
        let mut entries = 0;
        let fits = (start..blocks.len()).take_while(|&b| {
            entries += triangle(blocks.size(b));
            entries <= MOST.0
        });
        let whole = fits.count().max(1);
        let end =
            if start + whole == blocks.len() { start + whole } else { start + (whole / LANES * LANES).max(LANES) };
        ranges.push(start..end.min(blocks.len()));
        start = end;
    }
    let one = |range: Range<usize>| Group::all(blocks, range, dofs, pattern);
    let groups = threads::map(ranges, one).into_iter().flatten().collect();
    Groups { groups, pieces: pieces(dofs, pattern) }
}

impl Groups {
    /// Splits K into its pieces, each with its range of slots.
    fn split<'k>(&self, mut k: &'k mut [f64]) -> Vec<(Range<u32>, &'k mut [f64])> {
        let piece = |ends: &[u32]| {
            let (own, rest) = std::mem::take(&mut k).split_at_mut((ends[1] - ends[0]) as usize);
            k = rest;
            (ends[0]..ends[1], own)
        };
        self.pieces.windows(2).map(piece).collect()
    }
}

/// Slots at which K is divided for threads.
fn pieces(dofs: &Dofs, pattern: &Pattern) -> Vec<u32> {
    let mut pieces = vec![0];
    for (e, &dof) in dofs.free.iter().enumerate().skip(1) {
        let begins = dofs.vertex(dof) != dofs.vertex(dofs.free[e - 1]);
        let slot = pattern.on_diagonal(e) as u32;
        if begins && slot - pieces[pieces.len() - 1] >= PIECE {
            pieces.push(slot);
        }
    }
    pieces.push(pattern.nnz() as u32);
    pieces
}

/// The first unknown of each vertex of a block: nodes come first, then unknowns of the second field.
fn vertices(blocks: &Blocks, b: usize) -> impl Iterator<Item = u32> + '_ {
    blocks.nodes(b).iter().map(|node| 3 * node).chain(blocks.scalars(b).iter().copied())
}

/// The pairs of vertices of blocks, block after block; `local` holds the vertices of these blocks.
fn local_pairs<'a>(blocks: &'a Blocks, range: Range<usize>, local: &'a [u32]) -> impl Iterator<Item = (u32, u32)> + 'a {
    let mut rest = local;
    range.flat_map(move |b| {
        let (own, others) = rest.split_at(blocks.nodes(b).len() + blocks.scalars(b).len());
        rest = others;
        (0..own.len()).flat_map(move |a| own[..=a].iter().map(move |&other| (own[a], other)))
    })
}

impl Group {
    /// Builds one group, or several if the blocks have too many distinct entries.
    fn all(blocks: &Blocks, range: Range<usize>, dofs: &Dofs, pattern: &Pattern) -> Vec<Self> {
        let local: Vec<u32> = range.clone().flat_map(|b| vertices(blocks, b)).collect();
        let set = RankedSet::new(local.iter().copied());
        // In the order of their equations, followed by those without one
        let mut members: Vec<(u32, u32, Components)> = Vec::with_capacity(set.count());
        for first in set.members() {
            let components = Components::of(dofs, first);
            let free = components.each_free().next();
            members.push((free.map_or(Dofs::FIXED, |i| dofs.equation[first as usize + i]), first, components));
        }
        members.sort_unstable_by_key(|(equation, first, _)| (*equation, *first));
        let (mut place, mut first_of, mut unknowns) = (vec![0; members.len()], Vec::new(), Vec::new());
        for (k, (_, first, components)) in members.iter().enumerate() {
            place[set.rank(*first)] = k as u32;
            first_of.push(unknowns.len() as u32);
            unknowns.extend(*first..first + u32::from(components.count));
        }
        let local: Vec<u32> = local.into_iter().map(|first| place[set.rank(first)]).collect();
        let free = members.partition_point(|(equation, ..)| *equation != Dofs::FIXED);
        let graph = SymPattern::from_pairs(
            free,
            local_pairs(blocks, range.clone(), &local).filter(|(i, j)| (*i.max(j) as usize) < free),
        );
        let (mut pairs, mut entries, mut different) = (Vec::with_capacity(graph.nnz()), 0, 0);
        for (i, j) in graph.entries() {
            let ((row, _, rows), (column, _, columns)) = (members[i], members[j]);
            let slot = pattern.slot(row, column).expect("the pattern holds every pair of a block");
            let stride = (pattern.on_diagonal(column as usize + 1) - pattern.on_diagonal(column as usize)) as u32 - 1;
            let pair = Pair { slot, stride, offset: entries, rows, columns, on_diagonal: i == j };
            entries += u32::from(rows.count) * u32::from(columns.count);
            different += pair.count();
            pairs.push(pair);
        }
        if different > MOST.1 && range.len() > LANES {
            let middle = range.start + (range.len() / 2).div_ceil(LANES) * LANES;
            let halves = [range.start..middle, middle..range.end];
            return halves.into_iter().flat_map(|half| Self::all(blocks, half, dofs, pattern)).collect();
        }
        let offset = |(i, j): (u32, u32)| {
            if i.max(j) as usize >= free {
                return 2 * entries;
            }
            let pair = graph.slot(i, j).expect("made of all pairs");
            2 * pairs[pair as usize].offset + u32::from(i < j)
        };
        let of_pairs = local_pairs(blocks, range.clone(), &local).map(offset).collect();
        let of_vertices = local.into_iter().map(|k| first_of[k as usize]).collect();
        let largest = range.clone().map(|b| blocks.size(b)).max().unwrap_or(0);
        vec![Self { blocks: range, largest, dofs: unknowns, of_vertices, pairs, of_pairs, entries }]
    }
}

/// Sums over the blocks of a group.
#[derive(Default)]
struct GroupSums {
    energy: f64,
    dissipated: f64,
    /// Σ_e ‖r_e‖
    forces: f64,
    /// \[dofs\]
    r: Vec<f64>,
    /// \[dofs\] Σ K_e d of the prescribed increment d, if there is one
    increment_force: Vec<f64>,
    /// \[entries\] sums of K, followed by room for the entries of prescribed dofs
    k: Vec<f64>,
}

/// An effect with the data for its assembly.
pub(super) struct Grouped<'a> {
    pub effect: &'a dyn Effect,
    /// Position of the effect in the system
    pub index: usize,
    pub groups: &'a Groups,
    pub batched: Option<&'a dyn Batched>,
    pub projected: bool,
    pub want: Want,
    /// \[unknowns\] prescribed increment
    pub increment: Option<&'a [f64]>,
    /// \[unknowns\] equation of each dof
    pub equation: &'a [u32],
}

impl Grouped<'_> {
    /// Adds the sums of all blocks; returns Σ_e ‖r_e‖.
    pub fn add(&self, at: &At, out: &mut Assembled) -> Result<f64, EvalError> {
        let mut forces = 0.0;
        for groups in self.groups.groups.chunks(WAITING) {
            let sums = threads::map(groups.iter().collect(), |group| self.sum(at, group));
            // The first error in the order of the blocks
            let sums: Vec<GroupSums> = sums.into_iter().collect::<Result<_, _>>()?;
            for (group, sums) in groups.iter().zip(&sums) {
                out.energy[self.index] += sums.energy;
                out.dissipated[self.index] += sums.dissipated;
                forces += sums.forces;
                group.dofs.iter().zip(&sums.r).for_each(|(&dof, r)| out.r[dof as usize] += r);
                for (&dof, force) in group.dofs.iter().zip(&sums.increment_force) {
                    if let Some(to) = out.increment_force.get_mut(self.equation[dof as usize] as usize) {
                        *to += force;
                    }
                }
            }
            if self.want == Want::Tangent {
                threads::map(self.groups.split(&mut out.k), |(slots, k)| {
                    for (group, sums) in groups.iter().zip(&sums) {
                        let [start, end] =
                            [slots.start, slots.end].map(|end| group.pairs.partition_point(|pair| pair.slot < end));
                        group.pairs[start..end].iter().for_each(|pair| pair.add(&sums.k, slots.start, k));
                    }
                });
            }
        }
        Ok(forces)
    }

    /// The prescribed increment if it moves block `b`: few blocks have a prescribed dof.
    fn increment_of(&self, b: usize) -> Option<&[f64]> {
        self.increment.filter(|d| self.effect.blocks().dofs(b).any(|dof| d[dof as usize] != 0.0))
    }

    fn sum(&self, at: &At, group: &Group) -> Result<GroupSums, EvalError> {
        let n = group.largest;
        let (batch, values) = (&mut Batch::new(if self.batched.is_some() { n } else { 0 }), &mut BlockValues::new(n));
        let mut sums = GroupSums { r: vec![0.0; group.dofs.len()], ..GroupSums::default() };
        if self.want == Want::Tangent {
            sums.k = vec![0.0; group.entries as usize + LARGEST];
            if self.increment.is_some() {
                sums.increment_force = vec![0.0; group.dofs.len()];
            }
        }
        let blocks = self.effect.blocks();
        let (mut of_vertices, mut of_pairs) = (&group.of_vertices[..], &group.of_pairs[..]);
        let mut next = |b: usize| {
            let nodes = blocks.nodes(b).len();
            let count = nodes + blocks.scalars(b).len();
            let (vertices, others) = of_vertices.split_at(count);
            let (pairs, rest) = of_pairs.split_at(triangle(count));
            (of_vertices, of_pairs) = (others, rest);
            Places { nodes, vertices, pairs }
        };
        let mut b = group.blocks.start;
        while let Some(batched) = self.batched.filter(|_| b + LANES <= group.blocks.end) {
            let n = blocks.size(b);
            batch.reset(n);
            batched.eval(at, b, self.want, batch)?;
            let squares = batch.r.iter().fold(Lanes::ZERO, |sum, r| sum + *r * *r);
            for lane in 0..LANES {
                let places = next(b + lane);
                sums.energy += batch.energy.0[lane];
                sums.forces += squares.0[lane].sqrt();
                places.add_vector(&mut sums.r, |i| batch.r[i].0[lane]);
                if self.want < Want::Tangent {
                    continue;
                }
                places.add_matrix(&mut sums.k, n, &batch.k, |k| k.0[lane]);
                if let Some(d) = self.increment_of(b + lane) {
                    values.k.iter_mut().zip(&batch.k).for_each(|(to, from)| *to = from.0[lane]);
                    places.add_increment_force(&mut sums.increment_force, blocks.dofs(b + lane), values, d);
                }
            }
            b += LANES;
        }
        for b in b..group.blocks.end {
            let n = blocks.size(b);
            let places = next(b);
            values.reset(n, self.want);
            self.effect.eval(at, b, self.want, values)?;
            if self.projected {
                project(values, n, 3 * blocks.nodes(b).len());
            }
            sums.energy += values.energy;
            sums.dissipated += values.dissipated;
            sums.forces += norm(&values.r[..n]);
            places.add_vector(&mut sums.r, |i| values.r[i]);
            if self.want == Want::Tangent {
                places.add_matrix(&mut sums.k, n, &values.k, |k| *k);
                if let Some(d) = self.increment_of(b) {
                    places.add_increment_force(&mut sums.increment_force, blocks.dofs(b), values, d);
                }
            }
        }
        Ok(sums)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix;
    use crate::math::signal::Signal;
    use crate::system::{EnergyRole, Prescribed, Rates, System};
    use std::collections::BTreeMap;

    /// Blocks of 2 to 5 nodes, some with one or two unknowns of the second field; entries are small integers, whose sums are exact.
    struct Integers(Blocks);

    impl Integers {
        fn entry(b: usize, i: usize, j: usize) -> f64 {
            ((7 * b + 31 * i.max(j) + 57 * i.min(j)) % 41) as f64 - 20.0
        }
    }

    impl Effect for Integers {
        fn name(&self) -> &str {
            "integers"
        }
        fn role(&self) -> EnergyRole {
            EnergyRole::Stored
        }
        fn blocks(&self) -> &Blocks {
            &self.0
        }
        fn eval(&self, _: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
            let n = self.0.size(b);
            (0..n).for_each(|i| out.r[i] += Self::entry(b, i, i));
            if want == Want::Tangent {
                (0..n * n).filter(|k| k % n <= k / n).for_each(|k| out.k[k] += Self::entry(b, k / n, k % n));
            }
            Ok(())
        }
    }

    /// Residual, tangent and the forces of a prescribed increment equal the sums over all blocks, with nodes held in none, some or all of their
    /// components, and blocks that fill several groups.
    #[test]
    fn sums_of_groups_are_those_of_the_blocks() {
        let (nodes, count) = (400, 8000);
        let mut random = SplitMix(17);
        let mut below = |n: usize| (random.unit() * n as f64) as usize;
        let hosts: Vec<u32> = (0..nodes as u32).step_by(2).collect();
        let lists: Vec<(Vec<u32>, Vec<u32>)> = (0..count)
            .map(|_| {
                let (start, size) = (below(nodes - 40), 2 + below(4));
                let mut own: Vec<u32> = (0..size).map(|k| (start + 8 * k + below(8)) as u32).collect();
                let swapped = below(size);
                own.swap(0, swapped);
                let guests = own.iter().filter(|n| **n % 2 == 0).map(|n| 3 * nodes as u32 + n / 2).take(below(3));
                (own.clone(), guests.collect())
            })
            .collect();
        let blocks = Blocks::with_scalars(lists.iter().map(|(n, s)| (&n[..], &s[..])));
        let held = (0..nodes as u32)
            .step_by(5)
            .flat_map(|n| (0..3).filter(move |i| (n / 5) >> i & 1 == 1).map(move |i| 3 * n + i));
        let prescribed: Vec<Prescribed> = held.map(|dof| Prescribed { dof, signal: Signal::Constant(0.0) }).collect();
        let mut increment = vec![0.0; 3 * nodes + hosts.len()];
        prescribed.iter().for_each(|p| increment[p.dof as usize] = 1.0 + f64::from(p.dof % 4));
        let effect = Integers(blocks.clone());
        let system =
            System::with_scalars(nodes, &hosts, vec![Box::new(effect)], vec![], prescribed).expect("not empty");
        let groups = divide(&blocks, &system.dofs, &system.pattern);
        assert!(groups.groups.len() > 3);

        let (mut r, mut forces) = (vec![0.0; increment.len()], vec![0.0; system.dofs.free.len()]);
        let mut k: BTreeMap<(u32, u32), f64> = BTreeMap::new();
        for b in 0..blocks.len() {
            let dofs: Vec<u32> = blocks.dofs(b).collect();
            for (i, &to) in dofs.iter().enumerate() {
                r[to as usize] += Integers::entry(b, i, i);
                let row = system.dofs.equation[to as usize];
                for (j, &from) in dofs.iter().enumerate().filter(|_| row != Dofs::FIXED) {
                    forces[row as usize] += Integers::entry(b, i, j) * increment[from as usize];
                    let column = system.dofs.equation[from as usize];
                    if column <= row {
                        *k.entry((row, column)).or_default() += Integers::entry(b, i, j);
                    }
                }
            }
        }
        let x = vec![0.0; increment.len()];
        let rates = Rates::default();
        let at = At { t: 0.0, dt: 1.0, x: &x, v: &x, a: &x, old: &x, history: &[], inputs: &[], rates };
        let mut sums = system.workspace();
        system.assemble(&at, &[], Want::Tangent, Some(&increment), &mut sums).expect("no law");
        assert_eq!((sums.r, sums.increment_force), (r, forces));
        for ((row, column), sum) in system.pattern.sparse.entries().zip(&sums.k) {
            let expected = k.remove(&(row as u32, column as u32)).unwrap_or(0.0);
            assert_eq!(*sum, expected, "row {row}, column {column}");
        }
        assert!(k.is_empty());
    }
}
