//! Groups of consecutive blocks, whose sums are made apart and then added in order.
//!
//! Threads share an assembly by groups. A group is small enough for its sums to stay in the cache, which also makes it faster on one
//! thread: the entries of K that several blocks of a group have in common are added to the large matrix once. The groups follow from
//! the blocks alone, and their sums are added in their order, so that the same bits come from any number of threads.

use super::projection::project;
use super::{Assembled, At, Batch, Batched, BlockValues, Blocks, Dofs, Effect, EvalError, Want};
use crate::math::lanes::{LANES, Lanes};
use crate::math::ranked_set::RankedSet;
use crate::math::threads;
use crate::math::vector::norm;
use std::ops::Range;

/// Local entries of K of a group, and different ones among them, which 16 bits count together with one more.
const MOST: (usize, usize) = (100_000, 50_000);
/// Groups whose sums wait to be added: as many as the cache holds.
const WAITING: usize = 16;
/// Entries of K that one thread adds at a time.
const PIECE: usize = 1 << 16;

/// Blocks, and the places of their unknowns and entries.
pub(super) struct Group {
    blocks: Range<usize>,
    /// Unknowns of the largest block
    largest: usize,
    /// Unknowns of the blocks, ascending
    dofs: Vec<u32>,
    /// Slots in K of their entries, ascending
    slots: Vec<u32>,
    /// Place in `dofs` of each local unknown, block after block
    of_unknowns: Vec<u16>,
    /// Place in `slots` of each local entry with column ≤ row, block after block; behind the last one where a dof is prescribed
    of_entries: Vec<u16>,
}

/// Divides blocks into groups; `slots` gives those of the entries of some blocks, [`Dofs::FIXED`] where a dof is prescribed.
pub(super) fn divide(blocks: &Blocks, slots: impl Fn(Range<usize>) -> Vec<u32> + Sync) -> Vec<Group> {
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
    let one = |range: Range<usize>| Group::all(blocks, range, &slots);
    threads::map(ranges, one).into_iter().flatten().collect()
}

/// Entries of a block of `n` unknowns with column ≤ row.
pub(super) fn triangle(n: usize) -> usize {
    n * (n + 1) / 2
}

impl Group {
    /// One group, or more where the blocks have too many different entries.
    fn all(blocks: &Blocks, range: Range<usize>, slots: &(impl Fn(Range<usize>) -> Vec<u32> + Sync)) -> Vec<Self> {
        let entries = slots(range.clone());
        let different = RankedSet::new(entries.iter().copied().filter(|slot| *slot != Dofs::FIXED));
        if different.count() > MOST.1 && range.len() > LANES {
            let middle = range.start + (range.len() / 2).div_ceil(LANES) * LANES;
            let halves = [range.start..middle, middle..range.end];
            return halves.into_iter().flat_map(|half| Self::all(blocks, half, slots)).collect();
        }
        let unknowns: Vec<u32> = range.clone().flat_map(|b| blocks.dofs(b)).collect();
        let dofs = RankedSet::new(unknowns.iter().copied());
        let place = |slot: u32| if slot == Dofs::FIXED { different.count() } else { different.rank(slot) };
        let of_entries = entries.iter().map(|&slot| place(slot) as u16).collect();
        let of_unknowns = unknowns.iter().map(|&dof| dofs.rank(dof) as u16).collect();
        let largest = range.clone().map(|b| blocks.size(b)).max().unwrap_or(0);
        let (dofs, slots) = (dofs.members(), different.members());
        vec![Self { blocks: range, largest, dofs, slots, of_unknowns, of_entries }]
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
    /// \[slots + 1\] and the entries of prescribed dofs
    k: Vec<f64>,
}

/// An effect with what its assembly takes.
pub(super) struct Grouped<'a> {
    pub effect: &'a dyn Effect,
    /// Position of the effect in the system
    pub index: usize,
    pub groups: &'a [Group],
    pub batched: Option<&'a dyn Batched>,
    pub projected: bool,
    pub want: Want,
    /// \[unknowns\] prescribed increment
    pub increment: Option<&'a [f64]>,
    /// \[unknowns\] equation of a dof
    pub equation: &'a [u32],
}

impl Grouped<'_> {
    /// Adds the sums of all blocks; returns Σ_e ‖r_e‖.
    pub fn add(&self, at: &At, out: &mut Assembled) -> Result<f64, EvalError> {
        let mut forces = 0.0;
        for groups in self.groups.chunks(WAITING) {
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
                threads::map(out.k.chunks_mut(PIECE).enumerate().collect(), |(piece, k)| {
                    let first = (piece * PIECE) as u32;
                    for (group, sums) in groups.iter().zip(&sums) {
                        let start = group.slots.partition_point(|&slot| slot < first);
                        let end = group.slots.partition_point(|&slot| slot < first + k.len() as u32);
                        for (&slot, value) in group.slots[start..end].iter().zip(&sums.k[start..end]) {
                            k[(slot - first) as usize] += value;
                        }
                    }
                });
            }
        }
        Ok(forces)
    }

    /// The prescribed increment where it moves block `b`: few blocks are at a prescribed dof.
    fn increment_of(&self, b: usize) -> Option<&[f64]> {
        self.increment.filter(|d| self.effect.blocks().dofs(b).any(|dof| d[dof as usize] != 0.0))
    }

    fn sum(&self, at: &At, group: &Group) -> Result<GroupSums, EvalError> {
        let n = group.largest;
        let (batch, values) = (&mut Batch::new(if self.batched.is_some() { n } else { 0 }), &mut BlockValues::new(n));
        let mut sums = GroupSums { r: vec![0.0; group.dofs.len()], ..GroupSums::default() };
        if self.want == Want::Tangent {
            sums.k = vec![0.0; group.slots.len() + 1];
            if self.increment.is_some() {
                sums.increment_force = vec![0.0; group.dofs.len()];
            }
        }
        let (mut unknowns, mut entries) = (&group.of_unknowns[..], &group.of_entries[..]);
        let mut next = |n: usize| {
            let (own, rest) = unknowns.split_at(n);
            let (of_k, others) = entries.split_at(triangle(n));
            (unknowns, entries) = (rest, others);
            (own, of_k)
        };
        let blocks = self.effect.blocks();
        let mut b = group.blocks.start;
        while let Some(batched) = self.batched.filter(|_| b + LANES <= group.blocks.end) {
            let n = blocks.size(b);
            batch.reset(n, self.want);
            batched.eval(at, b, self.want, batch)?;
            let squares = batch.r.iter().fold(Lanes::ZERO, |sum, r| sum + *r * *r);
            for lane in 0..LANES {
                let (of_r, of_k) = next(n);
                sums.energy += batch.energy.0[lane];
                sums.forces += squares.0[lane].sqrt();
                of_r.iter().zip(&batch.r).for_each(|(&to, r)| sums.r[to as usize] += r.0[lane]);
                if self.want < Want::Tangent {
                    continue;
                }
                add_matrix(&mut sums.k, of_k, n, |i| batch.k[i].0[lane]);
                if let Some(d) = self.increment_of(b + lane) {
                    values.k.iter_mut().zip(&batch.k).for_each(|(to, from)| *to = from.0[lane]);
                    add_increment_force(&mut sums, (of_r, blocks.dofs(b + lane)), n, values, d);
                }
            }
            b += LANES;
        }
        for b in b..group.blocks.end {
            let n = blocks.size(b);
            let (of_r, of_k) = next(n);
            values.reset(n, self.want);
            self.effect.eval(at, b, self.want, values)?;
            if self.projected {
                project(values, n, 3 * blocks.nodes(b).len());
            }
            sums.energy += values.energy;
            sums.dissipated += values.dissipated;
            sums.forces += norm(&values.r[..n]);
            of_r.iter().zip(&values.r).for_each(|(&to, r)| sums.r[to as usize] += r);
            if self.want == Want::Tangent {
                add_matrix(&mut sums.k, of_k, n, |i| values.k[i]);
                if let Some(d) = self.increment_of(b) {
                    add_increment_force(&mut sums, (of_r, blocks.dofs(b)), n, values, d);
                }
            }
        }
        Ok(sums)
    }
}

/// Adds the entries of a block of `n` unknowns with column ≤ row.
#[inline]
fn add_matrix(to: &mut [f64], places: &[u16], n: usize, entry: impl Fn(usize) -> f64) {
    let mut places = places.iter();
    for i in 0..n {
        for (j, &place) in (0..=i).zip(&mut places) {
            to[place as usize] += entry(i * n + j);
        }
    }
}

/// Adds K_e d_e; the prescribed increment d is zero on the free dofs.
fn add_increment_force(
    sums: &mut GroupSums,
    (places, dofs): (&[u16], impl Iterator<Item = u32>),
    n: usize,
    values: &BlockValues,
    d: &[f64],
) {
    for (j, from) in dofs.enumerate().filter(|(_, from)| d[*from as usize] != 0.0) {
        for (i, &to) in places.iter().enumerate() {
            sums.increment_force[to as usize] += values.k[i.max(j) * n + i.min(j)] * d[from as usize];
        }
    }
}
