//! Effects and rows that see the body through few weighted means, w_k = Σ_i w_ki u_i: their r and K_e are those by w, and what they
//! give to the body is r = B r_w and K = B S Bᵀ, which is never written out ([`Pattern`]).

use super::projection::project;
use super::{Assembled, At, BlockValues, Blocks, Cone, Dofs, EvalError, System, Want};
use crate::math::low_rank::{LowRank, Pattern};
use crate::math::sparse::SymPattern;
use crate::math::tensor::Vec3;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Weighted means of the displacement of nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Means {
    /// Per mean: (node, weight); none for a place that does not move
    lists: Vec<Vec<(u32, f64)>>,
    /// \[means × means\] Σ_i w_ki w_li
    overlap: Vec<f64>,
}

impl Means {
    /// Lists of (node, weight); weights of a node that comes twice add up.
    pub fn new<'a>(lists: impl Iterator<Item = &'a [(u32, f64)]>) -> Self {
        let summed: Vec<BTreeMap<u32, f64>> = lists
            .map(|list| {
                let mut sum = BTreeMap::new();
                list.iter().for_each(|&(node, w)| *sum.entry(node).or_insert(0.0) += w);
                sum
            })
            .collect();
        let common = |a: &BTreeMap<u32, f64>, b: &BTreeMap<u32, f64>| -> f64 {
            a.iter().filter_map(|(node, w)| b.get(node).map(|v| v * w)).sum()
        };
        let overlap = summed.iter().flat_map(|a| summed.iter().map(move |b| common(a, b))).collect();
        Self { lists: summed.into_iter().map(|sum| sum.into_iter().collect()).collect(), overlap }
    }

    /// w_k of u \[unknowns\].
    pub fn one(&self, u: &[f64], k: usize) -> Vec3 {
        let of = |&(node, w): &(u32, f64)| w * Vec3::from_column_slice(&u[3 * node as usize..][..3]);
        self.lists[k].iter().map(of).sum()
    }

    /// \[3 × means\] of u \[unknowns\].
    pub fn of(&self, u: &[f64]) -> Vec<f64> {
        (0..self.lists.len()).flat_map(|k| <[f64; 3]>::from(self.one(u, k))).collect()
    }

    /// B r_w of r_w \[3 × means\], dof by dof; a dof comes once for every mean that it is in.
    pub fn spread(&self, of_means: &[f64], mut each: impl FnMut(u32, f64)) {
        for (list, r) in self.lists.iter().zip(of_means.chunks_exact(3)) {
            for &(node, w) in list {
                (3 * node..).zip(r).for_each(|(dof, r)| each(dof, w * r));
            }
        }
    }

    /// ‖B r_w‖ of r_w on the means of a block.
    fn norm(&self, block: &[u32], r: &[f64]) -> f64 {
        let force = |a: usize| Vec3::from_column_slice(&r[3 * a..3 * a + 3]);
        let overlap = |a: usize, b: usize| self.overlap[block[a] as usize * self.lists.len() + block[b] as usize];
        let pairs = (0..block.len()).flat_map(|a| (0..block.len()).map(move |b| (a, b)));
        pairs.map(|(a, b)| overlap(a, b) * force(a).dot(&force(b))).sum::<f64>().max(0.0).sqrt()
    }
}

/// The means of a system, each set once, and what is coupled by them.
pub(super) struct Coupled<'a> {
    sets: Vec<(&'a Arc<Means>, u32)>,
    /// Pairs of means in one block
    pub pairs: Vec<(u32, u32)>,
    /// (mean, node)
    pub nodes: Vec<(u32, u32)>,
    pub count: usize,
}

impl<'a> Coupled<'a> {
    /// Of those that put something into the tangent.
    pub fn new(all: impl Iterator<Item = (&'a Arc<Means>, &'a Blocks)>) -> Self {
        let mut out = Self { sets: Vec::new(), pairs: Vec::new(), nodes: Vec::new(), count: 0 };
        for (means, list) in all {
            let first = out.first(means).unwrap_or_else(|| {
                let first = out.count as u32;
                let of_mean = |(k, list): (u32, &Vec<(u32, f64)>)| list.iter().map(|n| (k, n.0)).collect::<Vec<_>>();
                out.nodes.extend((first..).zip(&means.lists).flat_map(of_mean));
                out.sets.push((means, first));
                out.count += means.lists.len();
                first
            });
            for b in 0..list.len() {
                let block = list.nodes(b);
                let pairs = block.iter().enumerate().flat_map(|(a, &k)| block[..=a].iter().map(move |&l| (k, l)));
                out.pairs.extend(pairs.map(|(k, l)| (first + k, first + l)));
            }
        }
        out
    }

    /// Where the means of a set begin.
    fn first(&self, means: &Arc<Means>) -> Option<u32> {
        self.sets.iter().find(|(set, _)| Arc::ptr_eq(set, means)).map(|(_, first)| *first)
    }

    /// B on the free dofs, three columns a mean, and the pattern of S.
    pub fn low_rank(&self, dofs: &Dofs) -> LowRank {
        if self.count == 0 {
            return LowRank::default();
        }
        let lists = self.sets.iter().flat_map(|(means, _)| &means.lists);
        let column = |list: &Vec<(u32, f64)>, i: u32| {
            let entries = list.iter().map(|&(node, w)| (dofs.equation[(3 * node + i) as usize], w));
            let mut entries: Vec<(u32, f64)> = entries.filter(|(row, _)| *row != Dofs::FIXED).collect();
            entries.sort_by_key(|(row, _)| *row);
            entries
        };
        let columns = lists.flat_map(|list| (0..3).map(move |i| column(list, i))).collect();
        let components = (0..3).flat_map(|i| (0..3).map(move |j| (i, j)));
        let pairs = self.pairs.iter().flat_map(|&(k, l)| components.clone().map(move |(i, j)| (3 * k + i, 3 * l + j)));
        let after = dofs.after.iter().flat_map(|&rows| [rows; 3]).collect();
        LowRank { columns, inner: Some(SymPattern::from_pairs(3 * self.count, pairs)), after }
    }

    /// Slot of each local entry with column ≤ row, block after block.
    pub fn slots(&self, pattern: &Pattern, means: &Arc<Means>, list: &Blocks) -> Vec<u32> {
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

/// Sums over the blocks of an effect or a row.
struct Sums {
    energy: f64,
    /// Σ_e ‖B r_e‖
    forces: f64,
    /// \[3 × means\] r_w
    r: Vec<f64>,
}

impl System {
    /// Energy, residual and tangent of effect `e`; returns Σ‖r_e‖.
    pub(super) fn add_effect_by_means(
        &self,
        (e, means): (usize, &Means),
        at: &At,
        want: Want,
        increment: Option<&[f64]>,
        out: &mut Assembled,
    ) -> Result<f64, EvalError> {
        let effect = &self.effects[e];
        let seen = means.of(at.x);
        let semidefinite =
            want == Want::Tangent && (out.projected || out.descending && effect.capabilities().semidefinite);
        let eval = |b: usize, local: &mut BlockValues| {
            effect.eval(&At { x: &seen, ..*at }, b, want, local)?;
            if semidefinite {
                let n = effect.blocks().size(b);
                project(local, n, n);
            }
            Ok(())
        };
        let sums = self.sum_blocks(e, (means, effect.blocks()), (1.0, want, increment), eval, out)?;
        out.energy[e] = sums.energy;
        means.spread(&sums.r, |dof, r| out.r[dof as usize] += r);
        Ok(sums.forces)
    }

    /// Row `c` with the multiplier λ: its share of g, its gradient, λ ∂c/∂x and λ ∂²c/∂x²; returns Σ‖r_e‖.
    pub(super) fn add_row_by_means(
        &self,
        (c, means): (usize, &Means),
        x: &[f64],
        lambda: f64,
        (want, increment): (Want, Option<&[f64]>),
        out: &mut Assembled,
    ) -> Result<f64, EvalError> {
        let row = &self.constraints[c];
        let seen = means.of(x);
        let eval = |b: usize, local: &mut BlockValues| row.eval(&seen, b, want, local);
        let watched = row.cone() == Cone::Watched;
        let want = if watched { Want::Residual } else { want };
        let i = self.effects.len() + c;
        let sums = self.sum_blocks(i, (means, row.blocks()), (lambda, want, increment), eval, out)?;
        out.g[c] -= sums.energy;
        means.spread(&sums.r, |dof, r| {
            match self.dofs.equation[dof as usize] {
                Dofs::FIXED => out.carried[c] += increment.map_or(0.0, |d| r * d[dof as usize]),
                equation => out.gradient[c][equation as usize] += r,
            }
            if !watched {
                out.r[dof as usize] += lambda * r;
            }
        });
        Ok(lambda.abs() * sums.forces)
    }

    /// Evaluates the blocks of effect or row `i`; `factor` times their K_e go into S, and what these make of a prescribed
    /// increment into `lift`.
    fn sum_blocks(
        &self,
        i: usize,
        (means, list): (&Means, &Blocks),
        (factor, want, increment): (f64, Want, Option<&[f64]>),
        eval: impl Fn(usize, &mut BlockValues) -> Result<(), EvalError>,
        out: &mut Assembled,
    ) -> Result<Sums, EvalError> {
        let moved = increment.filter(|_| want == Want::Tangent).map(|d| means.of(d));
        let mut sums = Sums { energy: 0.0, forces: 0.0, r: vec![0.0; 3 * means.lists.len()] };
        let mut lift = vec![0.0; sums.r.len()];
        let mut local = BlockValues::new(list.largest());
        let mut slots = self.slots(i).iter();
        for b in 0..list.len() {
            let n = list.size(b);
            local.reset(n, want);
            eval(b, &mut local)?;
            sums.energy += local.energy;
            sums.forces += means.norm(list.nodes(b), &local.r[..n]);
            list.dofs(b).zip(&local.r).for_each(|(dof, r)| sums.r[dof as usize] += r);
            if want < Want::Tangent {
                continue;
            }
            for row in 0..n {
                for (value, &slot) in local.k[row * n..=row * n + row].iter().zip(&mut slots) {
                    out.k[slot as usize] += factor * value;
                }
            }
            if let Some(moved) = &moved {
                let dofs: Vec<u32> = list.dofs(b).collect();
                local.add_product(&dofs, |_| true, factor, moved, &mut lift);
            }
        }
        if moved.is_some() {
            means.spread(&lift, |dof, force| {
                if let Some(to) = out.lift.get_mut(self.dofs.equation[dof as usize] as usize) {
                    *to += force;
                }
            });
        }
        Ok(sums)
    }

    /// Of an effect, or of a row with the multiplier λ: adds K dx + h dλ at the prescribed dofs to `r`, for each (dx, dλ).
    pub(super) fn add_reactions_by_means(
        &self,
        (means, list): (&Means, &Blocks),
        lambda: f64,
        changes: &[(&[f64], f64)],
        eval: impl Fn(&[f64], usize, &mut BlockValues) -> Result<(), EvalError>,
        x: &[f64],
        r: &mut [Vec<f64>],
    ) -> Result<(), EvalError> {
        let fixed = |dof: u32| self.dofs.equation[dof as usize] == Dofs::FIXED;
        let mut nodes = means.lists.iter().flatten().map(|(node, _)| *node);
        if !nodes.any(|node| (3 * node..3 * node + 3).any(fixed)) {
            return Ok(());
        }
        let seen = means.of(x);
        let moved: Vec<Vec<f64>> = changes.iter().map(|(dx, _)| means.of(dx)).collect();
        let mut forces = vec![vec![0.0; seen.len()]; changes.len()];
        let mut local = BlockValues::new(list.largest());
        for b in 0..list.len() {
            let dofs: Vec<u32> = list.dofs(b).collect();
            local.reset(dofs.len(), Want::Tangent);
            eval(&seen, b, &mut local)?;
            for ((moved, force), (_, dlambda)) in moved.iter().zip(&mut forces).zip(changes) {
                local.add_product(&dofs, |_| true, lambda, moved, force);
                dofs.iter().zip(&local.r).for_each(|(&dof, h)| force[dof as usize] += h * dlambda);
            }
        }
        for (force, r) in forces.iter().zip(r) {
            means.spread(force, |dof, force| r[dof as usize] += if fixed(dof) { force } else { 0.0 });
        }
        Ok(())
    }
}
