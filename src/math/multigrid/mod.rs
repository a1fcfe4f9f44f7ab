//! Smoothed-aggregation multigrid: a preconditioner for tangents whose factor would be too large.
//!
//! ```text
//! M⁻¹: forward block Gauss–Seidel, Pᵀ to the next level and back, backward block Gauss–Seidel;  next A = Pᵀ A P;  LLᵀ at the bottom
//! ```
//!
//! Nodes are grouped by the strength of their coupling, and each group has the six rigid motions of its nodes as unknowns. Source: Vaněk, Mandel &
//! Brezina, Computing 56, 1996; for elasticity also Adams, Brezina, Hu & Tuminaro, J. Comput. Phys. 188, 2003. M is symmetric, and positive definite
//! where A is. Limits: A has to be positive definite; locking cells (a displacement formulation near incompressibility) need several times as many
//! iterations.

mod aggregate;
mod blocks;
mod level;
mod nodal;
mod places;
mod prolong;
mod saddle;
#[cfg(test)]
mod tests;

pub use places::Places;

use super::linear::Direct;
use super::sparse::SymPattern;
use aggregate::aggregate;
use blocks::{Block, BlockMatrix};
pub use level::NotDefinite;
use level::{Level, inverses};
use nodal::Nodal;
use prolong::{largest_eigenvalue, smoothed, tentative};
use saddle::Pressures;
use std::sync::Arc;

/// Threshold θ of strong coupling on the finest level; it is halved on each further level (Vaněk, Mandel & Brezina 1996).
const STRONG: f64 = 0.08;
/// Largest number of groups on the bottom level, whose factor is almost dense: a few megabytes.
const BOTTOM: usize = 300;
/// Smallest ratio of the numbers of nodes on successive levels; a level that coarsens less is factorised.
const COARSENING: f64 = 1.5;

/// Treatment of a matrix at the bottom of the hierarchy that is not positive definite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BottomFactor {
    /// It is refused
    Definite,
    /// It is factorised by LDLᵀ. The preconditioner is then indefinite, which minimal residuals allow and conjugate gradients do not
    Indefinite,
}

/// The hierarchy of the last matrix, and the structure shared by all matrices of one pattern.
pub struct Multigrid {
    /// Pattern of the whole matrix
    pattern: Arc<SymPattern>,
    /// The pressures of a mixed formulation, and the pattern of the displacements alone
    pressures: Option<(Pressures, SymPattern)>,
    places: Arc<Places>,
    nodal: Nodal,
    levels: Option<(Level<3>, Vec<Level<6>>, Bottom)>,
    /// Size of the hierarchy that was set up last
    pub size: Size,
}

/// Size of a hierarchy.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Size {
    /// Number of levels, including the bottom
    pub levels: usize,
    /// Operator complexity: entries of the matrices of all levels over those of the finest
    pub complexity: f64,
    /// Number of stored scalars
    pub entries: usize,
    /// Number of multiplications of the set-up
    pub set_up: f64,
}

struct Bottom {
    pattern: Arc<SymPattern>,
    factor: Direct,
}

impl Multigrid {
    pub fn new(pattern: Arc<SymPattern>, places: Arc<Places>) -> Self {
        let (pressures, places) = match Pressures::split(&pattern, &places) {
            Some((pressures, a, displaced)) => (Some((pressures, a)), displaced.into()),
            None => (None, places),
        };
        let nodal = Nodal::new(pressures.as_ref().map_or(&pattern, |(_, a)| a), &places);
        Self { pattern, pressures, places, nodal, levels: None, size: Size::default() }
    }

    /// Sets up the hierarchy of A, with the nodes displaced by u \[3 × nodes\], or at rest if `displacement` is empty.
    pub fn set_up(&mut self, values: &[f64], displacement: &[f64], bottom: BottomFactor) -> Result<(), NotDefinite> {
        let last = self.size;
        let result = self.set_up_levels(values, displacement, bottom);
        if result.is_err() {
            self.size = last;
        }
        result
    }

    fn set_up_levels(&mut self, values: &[f64], displacement: &[f64], bottom: BottomFactor) -> Result<(), NotDefinite> {
        self.levels = None;
        self.size = Size { levels: 2, ..Size::default() };
        let a = match &mut self.pressures {
            Some((pressures, a)) => self.nodal.matrix(a, &pressures.set_up(&self.pattern, values)),
            None => self.nodal.matrix(&self.pattern, values),
        };
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
        let bottom = Bottom::new(&a, bottom)?;
        let of_levels: usize = coarse.iter().map(Level::matrix_entries).sum();
        let size = &mut self.size;
        size.set_up += bottom.factor.flops();
        size.levels += coarse.len();
        size.complexity = 1.0 + (of_levels + 2 * bottom.pattern.nnz()) as f64 / finest;
        size.entries = fine.entries() + coarse.iter().map(Level::entries).sum::<usize>() + bottom.factor.nnz();
        size.entries += self.pressures.as_ref().map_or(0, |(pressures, _)| pressures.entries());
        self.levels = Some((fine, coarse, bottom));
        Ok(())
    }

    /// Builds a level, the matrix of the next level, and the rigid motions of the next level.
    #[allow(clippy::type_complexity)]
    fn level<const B: usize>(
        &mut self,
        a: BlockMatrix<B, B>,
        modes: &[Block<B, 6>],
        theta: f64,
    ) -> Result<(Level<B>, BlockMatrix<6, 6>, Vec<Block<6, 6>>), NotDefinite> {
        let (group, groups) = aggregate(&a, theta);
        let (p, next) = tentative(modes, &group, groups);
        let inverse = inverses(&a, &vec![[0.0; B]; a.rows()])?;
        let rho = largest_eigenvalue(&a, &inverse).ok_or(NotDefinite)?;
        let p = smoothed(&a, &inverse, &p, 4.0 / (3.0 * rho));
        let (mut coarse, of_ap) = p.galerkin(&a);
        for (g, modes) in next.iter().enumerate() {
            let k = coarse.diagonal(g);
            (0..6).filter(|&m| modes[m][m] == 0.0).for_each(|m| coarse.values[k][m][m] = 1.0);
        }
        let per_row = |blocks: usize| blocks as f64 / a.rows() as f64;
        let products =
            B as f64 * ((6 * B * of_ap) as f64 * per_row(p.col.len()) + p.entries() as f64 * per_row(a.col.len()));
        self.size.set_up += products + (p.entries() * 6) as f64 * per_row(of_ap);
        Ok((Level::new(a, p)?, coarse, next))
    }

    /// Whether M is symmetric: it is unless there are pressures.
    pub fn is_symmetric(&self) -> bool {
        self.pressures.is_none()
    }

    /// r ← M⁻¹ r
    pub fn apply(&self, r: &mut [f64]) {
        match &self.pressures {
            Some((pressures, _)) => pressures.apply(r, |u| self.cycle(u)),
            None => self.cycle(r),
        }
    }

    /// Applies one multigrid cycle to the displacements.
    fn cycle(&self, r: &mut [f64]) {
        let (fine, coarse, bottom) = self.levels.as_ref().expect("a hierarchy was set up");
        let z = fine.cycle(&self.nodal.gather(r), |r| descend(coarse, bottom, r));
        self.nodal.scatter(&z, r);
    }

    /// Frees the memory of the hierarchy.
    pub fn clear(&mut self) {
        self.levels = None;
        self.pressures.iter_mut().for_each(|(pressures, _)| pressures.clear());
    }
}

fn descend(levels: &[Level<6>], bottom: &Bottom, r: &[[f64; 6]]) -> Vec<[f64; 6]> {
    match levels {
        [] => bottom.solve(r),
        [level, rest @ ..] => level.cycle(r, |r| descend(rest, bottom, r)),
    }
}

impl Bottom {
    fn new(a: &BlockMatrix<6, 6>, accepted: BottomFactor) -> Result<Self, NotDefinite> {
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
        if !factor.definite(&values) {
            let indefinite = accepted == BottomFactor::Indefinite && factor.indefinite(&values).is_ok();
            indefinite.then_some(()).ok_or(NotDefinite)?;
        }
        Ok(Self { pattern, factor })
    }

    fn solve(&self, r: &[[f64; 6]]) -> Vec<[f64; 6]> {
        let mut x = r.concat();
        self.factor.solve(&mut x);
        x.chunks_exact(6).map(|c| c.try_into().expect("six")).collect()
    }
}
