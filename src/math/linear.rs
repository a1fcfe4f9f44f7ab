//! Direct solution of symmetric sparse systems: LLᵀ where the matrix is positive definite, LDLᵀ where it is not.
//!
//! The unknowns are numbered in elimination order before the matrix is assembled, so the factorisation permutes nothing.

use super::sparse::SymPattern;
use faer::Conj;
use faer::Par;
use faer::Side;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::mat::MatMut;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::supernodal::SupernodalLdltRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use std::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Which factorisation stands in the buffers.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Kind {
    None,
    Llt,
    Ldlt,
}

/// A matrix without a usable factorisation.
#[derive(Clone, Debug, PartialEq)]
pub enum LinearError {
    /// Zero or non-finite pivot: the matrix is singular to working precision.
    Singular,
    /// ‖Ax − b‖/‖b‖ stayed above the bound, and above rounding, after refinement.
    Inaccurate { residual: f64 },
}

impl fmt::Display for LinearError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Singular => write!(f, "the tangent matrix is singular to working precision"),
            Self::Inaccurate { residual } => {
                write!(f, "the linear solve is inaccurate (relative residual {residual:e})")
            }
        }
    }
}

impl std::error::Error for LinearError {}

/// Factorisation of matrices of one pattern. Symbolic work is done once; buffers are reused.
pub struct Factor {
    pattern: Arc<SymPattern>,
    symbolic: SymbolicCholesky<u32>,
    l: Vec<f64>,
    /// L in single precision, for [`Factor::solve_roughly`]; empty until it is asked for
    single: Vec<f32>,
    memory: MemBuffer,
    kind: Kind,
    /// Try LLᵀ first; off where negative eigenvalues are in the nature of the matrix
    try_llt: bool,
    /// Negative pivots of the last factorisation: the number of negative eigenvalues (Sylvester's law of inertia).
    pub negative_pivots: usize,
    /// Numeric factorisations so far.
    pub count: usize,
    /// Right sides solved for so far
    pub solves: usize,
    pub factor_time: Duration,
    pub solve_time: Duration,
}

/// Largest accepted ‖Ax − b‖/‖b‖ of a solve, after refinement.
pub(super) const SOLVE_TOLERANCE: f64 = 1e-9;
/// A residual of this share of ‖|A||x|‖ is rounding: slender bodies and stiffness ratios have no smaller one, and x is the
/// exact solution of a matrix that differs from A in its last digits (Oettli & Prager 1964).
pub(super) const ROUNDING: f64 = 16.0 * f64::EPSILON;
/// Entries of a column of L, on average, for which a factorisation takes as long as one back-substitution (measured on bodies
/// of 12 000 to 25 000 unknowns).
const ENTRIES_PER_SOLVE: f64 = 45.0;

impl Factor {
    /// For matrices that are expected to be positive definite.
    pub fn new(pattern: impl Into<Arc<SymPattern>>) -> Self {
        Self::with(pattern.into(), true, SymmetricOrdering::Identity)
    }

    /// For matrices of saddle points: LDLᵀ at once.
    pub fn indefinite(pattern: impl Into<Arc<SymPattern>>) -> Self {
        Self::with(pattern.into(), false, SymmetricOrdering::Identity)
    }

    /// For another pattern of the same size, with an elimination order of its own; counts and times go on.
    pub fn take_pattern(&mut self, pattern: &Arc<SymPattern>, in_order: bool) {
        if Arc::ptr_eq(&self.pattern, pattern) {
            return;
        }
        if self.pattern == *pattern {
            self.pattern = pattern.clone();
            return;
        }
        let start = Instant::now();
        let ordering = if in_order { SymmetricOrdering::Identity } else { SymmetricOrdering::Amd };
        let Self { count, solves, factor_time, solve_time, .. } = *self;
        let other = Self::with(pattern.clone(), self.try_llt, ordering);
        *self = Self { count, solves, solve_time, factor_time: factor_time + start.elapsed(), ..other };
    }

    fn with(pattern: Arc<SymPattern>, try_llt: bool, ordering: SymmetricOrdering<'_, u32>) -> Self {
        let n = pattern.n;
        // Without a permutation the symbolic phase reads the upper triangle, the numeric one the lower.
        let (col_ptr, row_idx) = pattern.upper();
        let matrix = SymbolicSparseColMatRef::new_checked(n, n, &col_ptr, None, &row_idx);
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let symbolic = factorize_symbolic_cholesky(matrix, Side::Upper, ordering, params)
            .expect("the pattern of a mesh that fits in memory can be factorised");
        let request = symbolic
            .factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default())
            .or(symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default()))
            .or(symbolic.solve_in_place_scratch::<f64>(8, Par::Seq));
        let (l, memory) = (vec![0.0; symbolic.len_val()], MemBuffer::new(request));
        Self {
            pattern,
            symbolic,
            l,
            single: Vec::new(),
            memory,
            kind: Kind::None,
            try_llt,
            negative_pivots: 0,
            count: 0,
            solves: 0,
            factor_time: Duration::ZERO,
            solve_time: Duration::ZERO,
        }
    }

    pub fn pattern(&self) -> &SymPattern {
        &self.pattern
    }

    /// Stored entries of the factor L.
    pub fn nnz(&self) -> usize {
        self.l.len()
    }

    /// Back-substitutions that a factorisation costs, by counts.
    pub fn price(&self) -> f64 {
        self.nnz() as f64 / self.pattern.n as f64 / ENTRIES_PER_SOLVE
    }

    /// Additions and multiplications of one factorisation: Σ over the columns of L of the square of their length.
    pub fn flops(&self) -> f64 {
        let SymbolicCholeskyRaw::Supernodal(symbolic) = self.symbolic.raw() else {
            unreachable!("the supernodal path is forced");
        };
        let (begin, end) = (symbolic.supernode_begin(), symbolic.supernode_end());
        let below = symbolic.col_ptr_for_row_idx();
        let supernode = |s: usize| {
            let (width, below) = ((end[s] - begin[s]) as usize, (below[s + 1] - below[s]) as usize);
            (1..=width).map(|k| ((k + below) as f64).powi(2)).sum::<f64>()
        };
        (0..symbolic.n_supernodes()).map(supernode).sum()
    }

    /// Factorises A: LLᵀ, and where a pivot is not positive, LDLᵀ with the negative pivots counted.
    pub fn factorise(&mut self, values: &[f64]) -> Result<(), LinearError> {
        let start = Instant::now();
        let result = self.factorise_untimed(values);
        self.count += 1;
        self.factor_time += start.elapsed();
        result
    }

    fn factorise_untimed(&mut self, values: &[f64]) -> Result<(), LinearError> {
        let n = self.pattern.n;
        self.kind = Kind::None;
        self.single.clear();
        self.negative_pivots = 0;
        if values.iter().any(|v| !v.is_finite()) {
            return Err(LinearError::Singular);
        }
        let symbolic = SymbolicSparseColMatRef::new_checked(n, n, &self.pattern.col_ptr, None, &self.pattern.row_idx);
        let matrix = SparseColMatRef::new(symbolic, values);
        if self.try_llt {
            let llt = self.symbolic.factorize_numeric_llt(
                &mut self.l,
                matrix,
                Side::Lower,
                Default::default(),
                Par::Seq,
                MemStack::new(&mut self.memory),
                Default::default(),
            );
            if llt.is_ok() {
                self.kind = Kind::Llt;
                return Ok(());
            }
        }
        self.symbolic
            .factorize_numeric_ldlt(
                &mut self.l,
                matrix,
                Side::Lower,
                Default::default(),
                Par::Seq,
                MemStack::new(&mut self.memory),
                Default::default(),
            )
            .map_err(|_| LinearError::Singular)?;
        self.negative_pivots = self.count_negative()?;
        self.kind = Kind::Ldlt;
        Ok(())
    }

    fn count_negative(&self) -> Result<usize, LinearError> {
        let SymbolicCholeskyRaw::Supernodal(symbolic) = self.symbolic.raw() else {
            unreachable!("the supernodal path is forced");
        };
        let ldlt = SupernodalLdltRef::new(symbolic, &self.l);
        let mut negative = 0;
        for s in 0..symbolic.n_supernodes() {
            let block = ldlt.supernode(s).val();
            for j in 0..block.ncols() {
                let d = block[(j, j)];
                if !d.is_finite() || d == 0.0 {
                    return Err(LinearError::Singular);
                }
                negative += usize::from(d < 0.0);
            }
        }
        Ok(negative)
    }

    /// Solves A X = B in place; `columns` of length n one after the other. Checks the residual and refines once.
    pub fn solve(&mut self, values: &[f64], columns: &mut [f64]) -> Result<(), LinearError> {
        let start = Instant::now();
        let n = self.pattern.n;
        let rhs = columns.to_vec();
        self.solve_raw(columns);
        let mut residual = vec![0.0; n];
        let mut result = Ok(());
        for (x, b) in columns.chunks_exact_mut(n).zip(rhs.chunks_exact(n)) {
            let norm = norm(b);
            for refinement in 0..3 {
                self.pattern.multiply(values, x, &mut residual);
                residual.iter_mut().zip(b).for_each(|(r, b)| *r = b - *r);
                let relative = if norm > 0.0 { self::norm(&residual) / norm } else { 0.0 };
                if relative <= SOLVE_TOLERANCE
                    || self::norm(&residual) <= ROUNDING * self::norm(&self.pattern.multiply_abs(values, x))
                {
                    break;
                }
                if !relative.is_finite() || refinement == 2 {
                    result = Err(LinearError::Inaccurate { residual: relative });
                    break;
                }
                self.solve_raw(&mut residual);
                x.iter_mut().zip(&residual).for_each(|(x, d)| *x += d);
            }
        }
        self.solves += columns.len() / n;
        self.solve_time += start.elapsed();
        result
    }

    /// Solves with L rounded to single precision, unchecked: half the memory traffic, for a preconditioner. Columns are scaled to
    /// the range of single precision.
    pub fn solve_roughly(&mut self, columns: &mut [f64]) {
        let start = Instant::now();
        if self.single.is_empty() {
            self.single.extend(self.l.iter().map(|l| *l as f32));
        }
        let n = self.pattern.n;
        let sizes: Vec<f64> = columns.chunks_exact(n).map(norm).collect();
        let scaled = |(column, size): (&[f64], &f64)| -> Vec<f32> {
            column.iter().map(|x| if *size > 0.0 { (x / size) as f32 } else { 0.0 }).collect()
        };
        let mut single: Vec<f32> = columns.chunks_exact(n).zip(&sizes).flat_map(scaled).collect();
        let k = sizes.len();
        let mut memory = MemBuffer::new(self.symbolic.solve_in_place_scratch::<f32>(k, Par::Seq));
        let (rhs, stack) = (MatMut::from_column_major_slice_mut(&mut single, n, k), MemStack::new(&mut memory));
        let (symbolic, l) = (&self.symbolic, &self.single[..]);
        match self.kind {
            Kind::Llt => LltRef::new(symbolic, l).solve_in_place_with_conj(Conj::No, rhs, Par::Seq, stack),
            Kind::Ldlt => LdltRef::new(symbolic, l).solve_in_place_with_conj(Conj::No, rhs, Par::Seq, stack),
            Kind::None => unreachable!("solve is called only after a successful factorisation"),
        }
        for ((to, from), size) in columns.chunks_exact_mut(n).zip(single.chunks_exact(n)).zip(&sizes) {
            to.iter_mut().zip(from).for_each(|(to, from)| *to = f64::from(*from) * size);
        }
        self.solves += k;
        self.solve_time += start.elapsed();
    }

    fn solve_raw(&mut self, columns: &mut [f64]) {
        let n = self.pattern.n;
        let k = columns.len() / n;
        let mut extra;
        let memory = if k <= 8 {
            &mut self.memory
        } else {
            extra = MemBuffer::new(self.symbolic.solve_in_place_scratch::<f64>(k, Par::Seq));
            &mut extra
        };
        let stack = MemStack::new(memory);
        let rhs = MatMut::from_column_major_slice_mut(columns, n, k);
        match self.kind {
            Kind::Llt => LltRef::new(&self.symbolic, &self.l).solve_in_place_with_conj(Conj::No, rhs, Par::Seq, stack),
            Kind::Ldlt => {
                LdltRef::new(&self.symbolic, &self.l).solve_in_place_with_conj(Conj::No, rhs, Par::Seq, stack)
            }
            Kind::None => unreachable!("solve is called only after a successful factorisation"),
        }
    }
}

/// Euclidean norm.
pub fn norm(v: &[f64]) -> f64 {
    dot(v, v).sqrt()
}

/// Scalar product.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tridiagonal (−1, d, −1): eigenvalues d − 2 cos(kπ/(n+1)).
    fn tridiagonal(n: usize, d: f64) -> (SymPattern, Vec<f64>) {
        let pattern = SymPattern::from_pairs(n, (1..n as u32).map(|i| (i, i - 1)));
        let mut values = vec![-1.0; pattern.nnz()];
        for j in 0..n {
            values[pattern.slot(j as u32, j as u32).expect("diagonal") as usize] = d;
        }
        (pattern, values)
    }

    #[test]
    fn solves_and_counts_negative_eigenvalues() {
        let n = 40;
        for d in [2.5, 1.1, -0.3] {
            let (pattern, values) = tridiagonal(n, d);
            let x: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
            let mut b = vec![0.0; n];
            pattern.multiply(&values, &x, &mut b);
            let mut factor = Factor::new(pattern);
            factor.factorise(&values).expect("regular");
            let negative =
                (1..=n).filter(|&k| d < 2.0 * (k as f64 * std::f64::consts::PI / (n as f64 + 1.0)).cos()).count();
            assert_eq!(factor.negative_pivots, negative, "d = {d}");
            factor.solve(&values, &mut b).expect("accurate");
            // Condition number below 100, so 1e-12 leaves two digits of room.
            assert!(b.iter().zip(&x).all(|(b, x)| (b - x).abs() < 1e-12), "d = {d}");
        }
    }

    /// Condition number below 100 and single precision, ε = 6e-8: 1e-4 leaves room for a few roundings a row.
    #[test]
    fn solves_roughly_in_single_precision() {
        for d in [2.5, -0.3] {
            let (pattern, values) = tridiagonal(40, d);
            let x: Vec<f64> = (0..40).map(|i| (i as f64).sin()).collect();
            let mut b = vec![0.0; 40];
            pattern.multiply(&values, &x, &mut b);
            b.iter_mut().for_each(|b| *b *= 1e-60);
            let mut factor = Factor::new(pattern);
            factor.factorise(&values).expect("regular");
            factor.solve_roughly(&mut b);
            assert!(b.iter().zip(&x).all(|(b, x)| (b * 1e60 - x).abs() < 1e-4), "d = {d}");
        }
    }

    #[test]
    fn names_a_singular_matrix() {
        let pattern = SymPattern::from_pairs(2, [(1, 0)].into_iter());
        let mut factor = Factor::new(pattern);
        assert_eq!(factor.factorise(&[0.0, 0.0, 0.0]), Err(LinearError::Singular));
        assert_eq!(factor.factorise(&[1.0, f64::NAN, 1.0]), Err(LinearError::Singular));
    }
}
