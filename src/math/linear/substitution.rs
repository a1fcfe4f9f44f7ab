//! Forward and back substitution for one supernode, on one thread.
//!
//! A substitution does only two operations with each entry of L, so that it is limited by the time to read L from memory. Columns of L are processed
//! [`TOGETHER`] at a time: the vector is read once for all of them, and they stay in the cache for further right-hand sides, which cost little.

use super::elimination_tree::{EliminationTree, Supernode};
use super::multifrontal::Kind;
use crate::math::lanes::{Kernel, widest};
use pulp::{Arch, Simd, WithSimd};
use std::ops::{AddAssign, Div, Mul, Sub, SubAssign};

/// Number of columns of L that are processed at a time.
const TOGETHER: usize = 4;
/// Number type of L and of the vectors.
pub(super) trait Number:
    Copy + Default + Send + Sync + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + AddAssign + SubAssign
{
    /// Dot products of a few columns with one vector.
    fn products<S: Simd, const N: usize>(simd: S, columns: [&[Self]; N], x: &[Self]) -> [Self; N];
}

macro_rules! number {
    ($number:ident, $split:ident, $splat:ident, $mul_add:ident, $sum:ident) => {
        impl Number for $number {
            #[inline(always)]
            fn products<S: Simd, const N: usize>(simd: S, columns: [&[Self]; N], x: &[Self]) -> [Self; N] {
                let (whole, rest) = S::$split(x);
                let mut parts = [(whole, rest); N];
                for k in 0..N {
                    parts[k] = S::$split(&columns[k][..x.len()]);
                }
                let mut sums = [simd.$splat(0.0); N];
                for (i, &x) in whole.iter().enumerate() {
                    for k in 0..N {
                        sums[k] = simd.$mul_add(parts[k].0[i], x, sums[k]);
                    }
                }
                let mut products = [0.0; N];
                for k in 0..N {
                    products[k] = simd.$sum(sums[k]);
                    parts[k].1.iter().zip(rest).for_each(|(l, x)| products[k] += l * x);
                }
                products
            }
        }
    };
}

number!(f32, as_simd_f32s, splat_f32s, mul_add_e_f32s, reduce_sum_f32s);
number!(f64, as_simd_f64s, splat_f64s, mul_add_e_f64s, reduce_sum_f64s);

/// Substitutes forward in the columns of a supernode: `own`, a vector b for each of `k` right-hand sides, becomes L⁻¹b. Returns, for each right-hand
/// side, the values of the columns followed by the contributions to the rows below.
pub(super) fn forward<T: Number>(
    tree: &EliminationTree,
    supernode: &Supernode,
    l: &[T],
    (own, k): (&mut [T], usize),
    children: &[Vec<T>],
    kind: Kind,
) -> Vec<T> {
    let columns = supernode.columns.len();
    let height = columns + supernode.rows.len();
    let mut all = vec![T::default(); k * height];
    for (right, (own, all)) in own.chunks_exact(columns).zip(all.chunks_exact_mut(height)).enumerate() {
        all[..columns].copy_from_slice(own);
        for (&child, message) in supernode.children.iter().zip(children) {
            let child = &tree.supernodes[child];
            let places = &tree.places[child.rows.clone()];
            let whole = child.columns.len() + places.len();
            let message = &message[right * whole + child.columns.len()..][..places.len()];
            places.iter().zip(message).for_each(|(&place, v)| all[place as usize] += *v);
        }
    }
    widest(Forward(Block::new(supernode, l, kind), &mut all));
    own.chunks_exact_mut(columns).zip(all.chunks_exact(height)).for_each(|(own, x)| own.copy_from_slice(&x[..columns]));
    all
}

/// Substitutes back in the columns of a supernode, given the values `above` of the rows below its columns, a vector for each of `k` right-hand sides;
/// pushes the values that its children need.
pub(super) fn back<T: Number>(
    tree: &EliminationTree,
    supernode: &Supernode,
    l: &[T],
    (own, k): (&mut [T], usize),
    above: &[T],
    messages: &mut Vec<Vec<T>>,
    kind: Kind,
) {
    let (columns, rows) = (supernode.columns.len(), supernode.rows.len());
    let block = Block::new(supernode, l, kind);
    let mut all = Vec::with_capacity(k * block.height);
    for (right, own) in own.chunks_exact(columns).enumerate() {
        all.extend_from_slice(own);
        all.extend_from_slice(&above[right * rows..][..rows]);
    }
    if kind == Kind::Ldlt {
        for x in all.chunks_exact_mut(block.height) {
            x[..columns].iter_mut().enumerate().for_each(|(j, x)| *x = *x / block.column(j)[0]);
        }
    }
    Arch::new().dispatch(Back(block, &mut all));
    own.chunks_exact_mut(columns)
        .zip(all.chunks_exact(block.height))
        .for_each(|(own, x)| own.copy_from_slice(&x[..columns]));
    for &child in &supernode.children {
        let places = &tree.places[tree.supernodes[child].rows.clone()];
        let mut message = Vec::with_capacity(k * places.len());
        for all in all.chunks_exact(block.height) {
            message.extend(places.iter().map(|&place| all[place as usize]));
        }
        messages.push(message);
    }
}

/// The columns of L of one supernode.
#[derive(Clone, Copy)]
struct Block<'a, T> {
    l: &'a [T],
    columns: usize,
    height: usize,
    /// Whether L is that of LDLᵀ, with a unit diagonal in whose place D is stored
    unit: bool,
}

impl<'a, T: Number> Block<'a, T> {
    fn new(supernode: &Supernode, l: &'a [T], kind: Kind) -> Self {
        let columns = supernode.columns.len();
        let height = columns + supernode.rows.len();
        Self { l: &l[supernode.values.clone()], columns, height, unit: kind == Kind::Ldlt }
    }

    /// The rows of column `j` from its diagonal on.
    #[inline(always)]
    fn column(&self, j: usize) -> &'a [T] {
        &self.l[j * self.height + j..(j + 1) * self.height]
    }

    /// x divided by the diagonal entry of a column.
    #[inline(always)]
    fn over_diagonal(&self, x: T, column: &[T]) -> T {
        if self.unit { x } else { x / column[0] }
    }
}

/// \[right-hand sides × (columns + rows)\] b becomes L⁻¹b in the columns, and their contribution is subtracted from the rows.
struct Forward<'a, T>(Block<'a, T>, &'a mut [T]);

impl<T: Number> Kernel for Forward<'_, T> {
    #[inline(always)]
    fn run(self) {
        let Self(block, all) = self;
        let in_fours = block.columns - block.columns % TOGETHER;
        for j in (0..in_fours).step_by(TOGETHER) {
            let [l0, l1, l2, l3] = [0, 1, 2, 3].map(|k| block.column(j + k));
            for b in all.chunks_exact_mut(block.height) {
                let (x, rest) = b[j..].split_at_mut(TOGETHER);
                let x0 = block.over_diagonal(x[0], l0);
                let x1 = block.over_diagonal(x[1] - l0[1] * x0, l1);
                let x2 = block.over_diagonal(x[2] - l0[2] * x0 - l1[1] * x1, l2);
                let x3 = block.over_diagonal(x[3] - l0[3] * x0 - l1[2] * x1 - l2[1] * x2, l3);
                x.copy_from_slice(&[x0, x1, x2, x3]);
                let n = rest.len();
                let (l0, l1, l2, l3) = (&l0[4..][..n], &l1[3..][..n], &l2[2..][..n], &l3[1..][..n]);
                for i in 0..n {
                    rest[i] = rest[i] - l0[i] * x0 - l1[i] * x1 - l2[i] * x2 - l3[i] * x3;
                }
            }
        }
        for j in in_fours..block.columns {
            let l = block.column(j);
            for b in all.chunks_exact_mut(block.height) {
                let x = block.over_diagonal(b[j], l);
                b[j] = x;
                b[j + 1..].iter_mut().zip(&l[1..]).for_each(|(b, l)| *b -= *l * x);
            }
        }
    }
}

/// \[right-hand sides × (columns + rows)\] b becomes L⁻ᵀb in the columns, given the solution in the rows.
struct Back<'a, T>(Block<'a, T>, &'a mut [T]);

impl<T: Number> WithSimd for Back<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self(block, all) = self;
        let in_fours = block.columns - block.columns % TOGETHER;
        for j in (in_fours..block.columns).rev() {
            let l = block.column(j);
            for b in all.chunks_exact_mut(block.height) {
                let [product] = T::products(simd, [&l[1..]], &b[j + 1..]);
                b[j] = block.over_diagonal(b[j] - product, l);
            }
        }
        for j in (0..in_fours).step_by(TOGETHER).rev() {
            let [l0, l1, l2, l3] = [0, 1, 2, 3].map(|k| block.column(j + k));
            for b in all.chunks_exact_mut(block.height) {
                let (x, rest) = b[j..].split_at_mut(TOGETHER);
                let [p0, p1, p2, p3] = T::products(simd, [&l0[4..], &l1[3..], &l2[2..], &l3[1..]], rest);
                let x3 = block.over_diagonal(x[3] - p3, l3);
                let x2 = block.over_diagonal(x[2] - p2 - l2[1] * x3, l2);
                let x1 = block.over_diagonal(x[1] - p1 - l1[1] * x2 - l1[2] * x3, l1);
                let x0 = block.over_diagonal(x[0] - p0 - l0[1] * x1 - l0[2] * x2 - l0[3] * x3, l0);
                x.copy_from_slice(&[x0, x1, x2, x3]);
            }
        }
    }
}
