//! Weighted means of the displacement, through which some effects and constraints depend on the body.

use crate::math::tensor::Vec3;
use std::collections::BTreeMap;

/// Weighted means of the displacement of nodes, w_k = Σ_i w_ki u_i.
///
/// An effect that depends on the body through means provides r_w and K_w with respect to w; its residual is r = B r_w, and its tangent K = B S Bᵀ is
/// never formed ([`Pattern`](crate::math::low_rank::Pattern)).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Means {
    /// Per mean: (node, weight); an empty list for a point that does not move
    lists: Vec<Vec<(u32, f64)>>,
    /// \[means × means\] Σ_i w_ki w_li
    overlap: Vec<f64>,
}

impl Means {
    /// Builds means from lists of (node, weight); the weights of a repeated node add up.
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

    pub fn len(&self) -> usize {
        self.lists.len()
    }

    pub fn is_empty(&self) -> bool {
        self.lists.is_empty()
    }

    /// The nodes of all means, possibly repeated.
    pub(super) fn nodes(&self) -> impl Iterator<Item = u32> + '_ {
        self.lists.iter().flatten().map(|(node, _)| *node)
    }

    /// The lists of (node, weight), one for each mean.
    pub fn lists(&self) -> &[Vec<(u32, f64)>] {
        &self.lists
    }

    /// The mean w_k of u \[unknowns\].
    pub fn one(&self, u: &[f64], k: usize) -> Vec3 {
        let of = |&(node, w): &(u32, f64)| w * Vec3::from_column_slice(&u[3 * node as usize..][..3]);
        self.lists[k].iter().map(of).sum()
    }

    /// \[3 × means\] all means of u \[unknowns\].
    pub fn of(&self, u: &[f64]) -> Vec<f64> {
        (0..self.lists.len()).flat_map(|k| <[f64; 3]>::from(self.one(u, k))).collect()
    }

    /// Calls `each` with the entries of B r_w for r_w \[3 × means\]; a dof occurs once for every mean that contains it.
    pub fn spread(&self, of_means: &[f64], mut each: impl FnMut(u32, f64)) {
        for (list, r) in self.lists.iter().zip(of_means.chunks_exact(3)) {
            for &(node, w) in list {
                (3 * node..).zip(r).for_each(|(dof, r)| each(dof, w * r));
            }
        }
    }

    /// ‖B r_w‖ for r_w on the means of a block.
    pub(super) fn norm(&self, block: &[u32], r: &[f64]) -> f64 {
        let force = |a: usize| Vec3::from_column_slice(&r[3 * a..3 * a + 3]);
        let overlap = |a: usize, b: usize| self.overlap[block[a] as usize * self.lists.len() + block[b] as usize];
        let pairs = (0..block.len()).flat_map(|a| (0..block.len()).map(move |b| (a, b)));
        pairs.map(|(a, b)| overlap(a, b) * force(a).dot(&force(b))).sum::<f64>().max(0.0).sqrt()
    }
}
