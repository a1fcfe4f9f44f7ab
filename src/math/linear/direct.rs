//! LLᵀ and LDLᵀ of sparse matrices of one pattern, by supernodes.

use crate::math::sparse::SymPattern;
use crate::math::vector::norm;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::mat::MatMut;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::supernodal::SupernodalLdltRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Par, Side};

/// The factorisation held in the buffers.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Kind {
    None,
    Llt,
    Ldlt,
}

/// A pivot is zero or not finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ZeroPivot;

/// The symbolic work is done once; L has its memory from the first factorisation on.
pub struct Direct {
    n: usize,
    symbolic: SymbolicCholesky<u32>,
    l: Vec<f64>,
    /// L in single precision, for [`Direct::solve_roughly`]; empty until it is needed
    single: Vec<f32>,
    kind: Kind,
}

impl Direct {
    /// `in_order`: the unknowns are numbered in elimination order, so the factorisation permutes nothing. None where L has more
    /// entries than 32 bits count.
    pub fn new(pattern: &SymPattern, in_order: bool) -> Option<Self> {
        let n = pattern.n;
        // Without a permutation the symbolic phase reads the upper triangle, the numeric one the lower.
        let (col_ptr, row_idx) = pattern.upper();
        let matrix = SymbolicSparseColMatRef::new_checked(n, n, &col_ptr, None, &row_idx);
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let ordering = if in_order { SymmetricOrdering::Identity } else { SymmetricOrdering::Amd };
        let symbolic = factorize_symbolic_cholesky(matrix, Side::Upper, ordering, params).ok()?;
        Some(Self { n, symbolic, l: Vec::new(), single: Vec::new(), kind: Kind::None })
    }

    /// Entries of L.
    pub fn nnz(&self) -> usize {
        self.symbolic.len_val()
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

    /// Memory apart from L while it is computed \[bytes\].
    pub fn work_bytes(&self) -> usize {
        self.symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()).unaligned_bytes_required()
    }

    /// LLᵀ; false where a pivot is not positive.
    pub fn definite(&mut self, pattern: &SymPattern, values: &[f64]) -> bool {
        let request = self.symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let mut memory = self.prepare(request);
        let matrix = matrix(pattern, values);
        let (l, stack) = (&mut self.l, MemStack::new(&mut memory));
        let (settings, regularisation) = Default::default();
        let llt =
            self.symbolic.factorize_numeric_llt(l, matrix, Side::Lower, settings, Par::Seq, stack, regularisation);
        self.kind = if llt.is_ok() { Kind::Llt } else { Kind::None };
        llt.is_ok()
    }

    /// LDLᵀ without pivoting; the number of negative pivots.
    pub fn indefinite(&mut self, pattern: &SymPattern, values: &[f64]) -> Result<usize, ZeroPivot> {
        let request = self.symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default());
        let mut memory = self.prepare(request);
        let matrix = matrix(pattern, values);
        let (l, stack) = (&mut self.l, MemStack::new(&mut memory));
        let (settings, regularisation) = Default::default();
        self.symbolic
            .factorize_numeric_ldlt(l, matrix, Side::Lower, settings, Par::Seq, stack, regularisation)
            .map_err(|_| ZeroPivot)?;
        let negative = self.count_negative()?;
        self.kind = Kind::Ldlt;
        Ok(negative)
    }

    fn prepare(&mut self, request: faer::dyn_stack::StackReq) -> MemBuffer {
        self.kind = Kind::None;
        self.single.clear();
        self.l.resize(self.symbolic.len_val(), 0.0);
        MemBuffer::new(request)
    }

    fn count_negative(&self) -> Result<usize, ZeroPivot> {
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
                    return Err(ZeroPivot);
                }
                negative += usize::from(d < 0.0);
            }
        }
        Ok(negative)
    }

    /// In place, unchecked; `columns` of length n one after the other.
    pub fn solve(&self, columns: &mut [f64]) {
        let k = columns.len() / self.n;
        let mut memory = MemBuffer::new(self.symbolic.solve_in_place_scratch::<f64>(k, Par::Seq));
        let (rhs, stack) = (MatMut::from_column_major_slice_mut(columns, self.n, k), MemStack::new(&mut memory));
        let (symbolic, l) = (&self.symbolic, &self.l[..]);
        match self.kind {
            Kind::Llt => LltRef::new(symbolic, l).solve_in_place_with_conj(Conj::No, rhs, Par::Seq, stack),
            Kind::Ldlt => LdltRef::new(symbolic, l).solve_in_place_with_conj(Conj::No, rhs, Par::Seq, stack),
            Kind::None => unreachable!("solve is called only after a successful factorisation"),
        }
    }

    /// With L rounded to single precision: half the memory traffic. Columns are scaled to the range of single precision.
    pub fn solve_roughly(&mut self, columns: &mut [f64]) {
        if self.single.is_empty() {
            self.single.extend(self.l.iter().map(|l| *l as f32));
        }
        let n = self.n;
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
    }
}

fn matrix<'a>(pattern: &'a SymPattern, values: &'a [f64]) -> SparseColMatRef<'a, u32, f64> {
    let (n, col_ptr, row_idx) = (pattern.n, &pattern.col_ptr, &pattern.row_idx);
    SparseColMatRef::new(SymbolicSparseColMatRef::new_checked(n, n, col_ptr, None, row_idx), values)
}
