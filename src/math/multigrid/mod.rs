//! Smoothed aggregation: a preconditioner for the tangents of bodies whose factor is too large.
//!
//! ```text
//! M⁻¹: forward block Gauss–Seidel, Pᵀ to the next level and back, backward block Gauss–Seidel;  next A = Pᵀ A P;  LLᵀ at the bottom
//! ```
//!
//! Nodes are grouped by the strength of their coupling, a group has the six rigid motions of its nodes as unknowns. Source: Vaněk,
//! Mandel & Brezina, Computing 56, 1996; for elasticity also Adams, Brezina, Hu & Tuminaro, J. Comput. Phys. 188, 2003. M is symmetric,
//! and positive definite where A is. Limits: A is to be positive definite; locking cells (a displacement formulation near
//! incompressibility) cost several times the iterations.

mod aggregate;
mod blocks;
mod nodal;
mod places;
mod prolong;
#[cfg(test)]
mod tests;

pub use places::Places;

use super::linear::Direct;
use super::sparse::SymPattern;
use aggregate::aggregate;
use blocks::{Block, BlockMatrix, add_product, subtract_product};
use nodal::Nodal;
use prolong::{largest_eigenvalue, smoothed, tentative};
use std::sync::Arc;

/// Strength of a coupling that counts on the finest level; half of it on each next one (Vaněk, Mandel & Brezina 1996).
const STRONG: f64 = 0.08;
/// Groups of the bottom level, whose factor is dense almost: a few megabytes.
const BOTTOM: usize = 300;
/// Nodes of a level per node of the next, at least: what is coupled less is factorised.
const COARSENING: f64 = 1.5;

/// The matrix has a motion without positive stiffness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotDefinite;

/// A level with blocks of B × B, and the transfer to the next. In single precision, which halves the memory traffic: the same rounded numbers
/// are used for restriction and prolongation, so M⁻¹ is symmetric to the rounding of double precision.
struct Level<const B: usize> {
    a: BlockMatrix<B, B, f32>,
    /// Of the blocks of the diagonal
    inverse: Vec<Block<B, B>>,
    p: BlockMatrix<B, 6, f32>,
}

/// The hierarchy of the last matrix, and the structure that matrices of one pattern share.
pub struct Multigrid {
    pattern: Arc<SymPattern>,
    places: Arc<Places>,
    nodal: Nodal,
    levels: Option<(Level<3>, Vec<Level<6>>, Bottom)>,
    /// Of the last set-up
    pub size: Size,
}

/// Size of a hierarchy in numbers.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Size {
    /// Levels, the bottom included
    pub levels: usize,
    /// Entries of the matrices of all levels over those of the finest
    pub complexity: f64,
    /// Stored numbers
    pub entries: usize,
    /// Multiplications of the set-up
    pub set_up: f64,
}

struct Bottom {
    pattern: Arc<SymPattern>,
    factor: Direct,
}

impl Multigrid {
    pub fn new(pattern: Arc<SymPattern>, places: Arc<Places>) -> Self {
        let nodal = Nodal::new(&pattern, &places);
        Self { pattern, places, nodal, levels: None, size: Size::default() }
    }

    /// The hierarchy of A, the nodes being displaced by u \[3 × nodes\] or at rest.
    pub fn set_up(&mut self, values: &[f64], displacement: &[f64]) -> Result<(), NotDefinite> {
        self.levels = None;
        self.size = Size { levels: 2, ..Size::default() };
        let a = self.nodal.matrix(&self.pattern, values);
        let modes = self.places.rigid_modes(displacement);
        let finest = a.entries() as f64;
        let (fine, mut a, mut modes) = self.level(a, &modes, STRONG)?;
        let mut coarse = Vec::new();
        let mut theta = 0.5 * STRONG;
        while a.rows() > BOTTOM {
            let rows = a.rows();
            let level;
            (level, a, modes) = self.level(a, &modes, theta)?;
            coarse.push(level);
            theta *= 0.5;
            if rows as f64 <= COARSENING * a.rows() as f64 {
                break;
            }
        }
        let bottom = Bottom::new(&a)?;
        let of_levels: usize = coarse.iter().map(|l| l.a.entries()).sum();
        let size = &mut self.size;
        size.set_up += bottom.factor.flops();
        size.levels += coarse.len();
        size.complexity = 1.0 + (of_levels + 2 * bottom.pattern.nnz()) as f64 / finest;
        size.entries = fine.entries() + coarse.iter().map(Level::entries).sum::<usize>() + bottom.factor.nnz();
        self.levels = Some((fine, coarse, bottom));
        Ok(())
    }

    /// A level, the matrix of the next one, and its motions.
    #[allow(clippy::type_complexity)]
    fn level<const B: usize>(
        &mut self,
        a: BlockMatrix<B, B>,
        modes: &[Block<B, 6>],
        theta: f64,
    ) -> Result<(Level<B>, BlockMatrix<6, 6>, Vec<Block<6, 6>>), NotDefinite> {
        let (group, groups) = aggregate(&a, theta);
        let (p, next) = tentative(modes, &group, groups);
        let inverse = inverses(&a)?;
        let rho = largest_eigenvalue(&a, &inverse).ok_or(NotDefinite)?;
        let p = smoothed(&a, &inverse, &p, 4.0 / (3.0 * rho));
        let ap = a.times(&p);
        let mut coarse = p.transposed().times(&ap);
        for (g, modes) in next.iter().enumerate() {
            let k = coarse.diagonal(g);
            (0..6).filter(|&m| modes[m][m] == 0.0).for_each(|m| coarse.values[k][m][m] = 1.0);
        }
        let per_row = |m: &[u32], rows: usize| m.len() as f64 / rows as f64;
        let products = B as f64
            * (ap.entries() as f64 * per_row(&p.col, a.rows()) + p.entries() as f64 * per_row(&a.col, a.rows()));
        self.size.set_up += products + (p.entries() * 6) as f64 * per_row(&ap.col, a.rows());
        Ok((Level { a: a.rounded(), inverse, p: p.rounded() }, coarse, next))
    }

    /// z ← M⁻¹ r
    pub fn apply(&self, r: &mut [f64]) {
        let (fine, coarse, bottom) = self.levels.as_ref().expect("a hierarchy was set up");
        let z = fine.cycle(&self.nodal.gather(r), |r| descend(coarse, bottom, r));
        self.nodal.scatter(&z, r);
    }

    /// Gives its memory back.
    pub fn clear(&mut self) {
        self.levels = None;
    }
}

fn descend(levels: &[Level<6>], bottom: &Bottom, r: &[[f64; 6]]) -> Vec<[f64; 6]> {
    match levels {
        [] => bottom.solve(r),
        [level, rest @ ..] => level.cycle(r, |r| descend(rest, bottom, r)),
    }
}

impl<const B: usize> Level<B> {
    /// M⁻¹ r of this level, with that of the next.
    fn cycle(&self, r: &[[f64; B]], next: impl FnOnce(&[[f64; 6]]) -> Vec<[f64; 6]>) -> Vec<[f64; B]> {
        let n = r.len();
        let mut x = vec![[0.0; B]; n];
        for i in 0..n {
            let mut rest = r[i];
            self.a.row(i).take_while(|(j, _)| *j < i).for_each(|(j, a)| subtract_product(&mut rest, a, &x[j]));
            add_product(&mut x[i], &self.inverse[i], &rest);
        }
        // After a forward sweep from zero r − A x = −U x.
        let mut left = vec![[0.0; B]; n];
        for (i, left) in left.iter_mut().enumerate() {
            let start = self.a.diagonal(i) + 1;
            for k in start..self.a.range(i).end {
                subtract_product(left, &self.a.values[k], &x[self.a.col[k] as usize]);
            }
        }
        let correction = next(&self.p.transpose_times(&left));
        for (i, x) in x.iter_mut().enumerate() {
            self.p.row(i).for_each(|(g, p)| add_product(x, p, &correction[g]));
        }
        for i in (0..n).rev() {
            let mut rest = r[i];
            self.a.row(i).filter(|(j, _)| *j != i).for_each(|(j, a)| subtract_product(&mut rest, a, &x[j]));
            x[i] = [0.0; B];
            add_product(&mut x[i], &self.inverse[i], &rest);
        }
        x
    }

    fn entries(&self) -> usize {
        self.a.entries() + self.p.entries() + B * B * self.inverse.len()
    }
}

/// D⁻¹
fn inverses<const B: usize>(a: &BlockMatrix<B, B>) -> Result<Vec<Block<B, B>>, NotDefinite> {
    let of_row = |i: usize| {
        let block = nalgebra::SMatrix::<f64, B, B>::from(a.values[a.diagonal(i)]);
        let inverse = block.cholesky().ok_or(NotDefinite)?.inverse();
        Ok(inverse.into())
    };
    (0..a.rows()).map(of_row).collect()
}

impl Bottom {
    fn new(a: &BlockMatrix<6, 6>) -> Result<Self, NotDefinite> {
        let entries = |i: usize| {
            let lower = a.row(i).filter(move |(j, _)| *j >= i);
            lower.flat_map(move |(j, block)| {
                (0..36).map(move |k| (6 * i + k % 6, 6 * j + k / 6, block[k / 6][k % 6])).filter(|(r, c, _)| c >= r)
            })
        };
        let all = || (0..a.rows()).flat_map(entries);
        let pattern = Arc::new(SymPattern::from_pairs(6 * a.rows(), all().map(|(r, c, _)| (r as u32, c as u32))));
        let mut values = vec![0.0; pattern.nnz()];
        for (r, c, value) in all() {
            values[pattern.slot(r as u32, c as u32).expect("made of these pairs") as usize] = value;
        }
        let mut factor = Direct::new(&pattern, false).ok_or(NotDefinite)?;
        factor.definite(&values).then_some(()).ok_or(NotDefinite)?;
        Ok(Self { pattern, factor })
    }

    fn solve(&self, r: &[[f64; 6]]) -> Vec<[f64; 6]> {
        let mut x = r.concat();
        self.factor.solve(&mut x);
        x.chunks_exact(6).map(|c| c.try_into().expect("six")).collect()
    }
}
