//! The prepared solver for matrices of one pattern: a factorisation, or a multigrid hierarchy in its place.

use super::bordered::Bordered;
use super::error::LinearError;
use super::method::{Cost, Method, gigabytes};
use crate::math::low_rank::Pattern;
use crate::math::multigrid::{BottomFactor, Multigrid};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The solver that is ready for the current matrix.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Ready {
    None,
    Direct,
    Iterative,
}

/// Reason why a right-hand side was not solved for.
#[derive(Clone, Copy, Debug)]
pub(super) enum GaveUp {
    /// The Krylov method found negative curvature
    Indefinite,
    /// The Krylov method took too many iterations
    Slow,
    /// ‖Ax − b‖/‖b‖ stayed above the bound, and above the rounding level, after refinement
    Inaccurate { residual: f64 },
}

/// The kind of matrices that are expected.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Definiteness {
    /// Positive definite: LLᵀ is tried first
    Positive,
    /// Saddle points, with negative eigenvalues: LDLᵀ at once
    Saddle,
}

/// Numbers of right-hand sides that the Krylov method solved to full accuracy, and of the iterations for them.
#[derive(Clone, Copy, Default, PartialEq, Eq, Debug)]
pub struct GradientCounts {
    pub solves: usize,
    pub iterations: usize,
}

/// Factorisation of matrices of one pattern, or the hierarchy in its place. Symbolic work is done once; buffers are reused.
pub struct Factor {
    pub(super) pattern: Arc<Pattern>,
    method: Method,
    /// The direct factorisation; `None` on the iterative path as long as it was not needed
    pub(super) direct: Option<Bordered>,
    /// The hierarchy, on the iterative path
    pub(super) multigrid: Option<Multigrid>,
    pub(super) ready: Ready,
    /// Memory of the factor of this pattern if it was larger than allowed \[GB\]
    too_large: Option<f64>,
    /// Whether the unknowns are numbered in elimination order
    in_order: bool,
    definiteness: Definiteness,
    /// \[unknowns\] u at the next factorisation \[m\]; empty at rest
    displacement: Vec<f64>,
    /// Number of negative eigenvalues of the matrix that was factorised last, from its negative pivots (Sylvester's law of inertia). They are not
    /// counted on the iterative path.
    pub negative_eigenvalues: usize,
    /// Reason for the choice of this path
    pub why: String,
    /// Number of numeric factorisations, or set-ups of a hierarchy, so far.
    pub count: usize,
    /// Number of these factorisations that were made because the iterative path gave up
    pub fallbacks: usize,
    /// Number of right-hand sides solved for so far; on the iterative path, of applications of the hierarchy, one for each iteration of the Krylov
    /// method
    pub solves: usize,
    pub gradients: GradientCounts,
    pub factor_time: Duration,
    pub solve_time: Duration,
}

/// Average number of entries in a column of L at which a factorisation takes as long as one back-substitution (measured on bodies of 12 000 to 25 000
/// unknowns).
const ENTRIES_PER_SOLVE: f64 = 45.0;
/// Number of applications of a hierarchy that take as long as its set-up (measured on bodies of 45 000 to 290 000 unknowns).
const CYCLES_PER_SET_UP: f64 = 20.0;
/// Memory of a set-up per entry of the tangent \[bytes\] (measured: 69 and 70 for tet4 with half a million and 150 000 cells; 59 for tet10 with
/// pressures and 200 000 cells).
const SET_UP_BYTES: f64 = 72.0;
/// Number of iterations with a lagged hierarchy that is worth a new one.
const PATIENCE: usize = 150;

impl Factor {
    /// A factor for matrices that are expected to be positive definite.
    pub fn new(pattern: impl Into<Arc<Pattern>>) -> Self {
        Self::by(Method::default(), pattern.into(), Definiteness::Positive)
    }

    /// A factor for matrices of saddle points, which uses LDLᵀ at once.
    pub fn indefinite(pattern: impl Into<Arc<Pattern>>) -> Self {
        Self::by(Method::default(), pattern.into(), Definiteness::Saddle)
    }

    /// A factor that is direct or iterative, as `method` decides.
    pub fn by(method: Method, pattern: Arc<Pattern>, definiteness: Definiteness) -> Self {
        Self::with(pattern, method, definiteness, true)
    }

    /// Switches to another pattern of the same size, with its own elimination order; counts and times continue.
    pub fn take_pattern(&mut self, pattern: &Arc<Pattern>, in_order: bool) {
        if Arc::ptr_eq(&self.pattern, pattern) {
            return;
        }
        if self.pattern == *pattern {
            self.pattern = pattern.clone();
            return;
        }
        let start = Instant::now();
        let Self { count, fallbacks, solves, gradients, factor_time, solve_time, .. } = *self;
        let other = Self::with(pattern.clone(), self.method.clone(), self.definiteness, in_order);
        let factor_time = factor_time + start.elapsed();
        *self = Self { count, fallbacks, solves, gradients, solve_time, factor_time, ..other };
    }

    fn with(pattern: Arc<Pattern>, method: Method, definiteness: Definiteness, in_order: bool) -> Self {
        let mut direct = (!method.is_asked_for()).then(|| Bordered::new(&pattern, in_order)).flatten();
        let cost = direct.as_ref().map(|d| Cost { nnz: d.nnz(), flops: d.flops(), matrix: pattern.nnz() });
        let (places, why) = method.choose(cost);
        let multigrid = places.map(|places| Multigrid::new(pattern.sparse.clone(), places));
        if multigrid.is_some() {
            direct = None;
        }
        Self {
            pattern,
            method,
            direct,
            multigrid,
            ready: Ready::None,
            too_large: None,
            in_order,
            definiteness,
            displacement: Vec::new(),
            negative_eigenvalues: 0,
            why,
            count: 0,
            fallbacks: 0,
            solves: 0,
            gradients: GradientCounts::default(),
            factor_time: Duration::ZERO,
            solve_time: Duration::ZERO,
        }
    }

    pub fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// The hierarchy, on the iterative path.
    pub fn multigrid(&self) -> Option<&Multigrid> {
        self.multigrid.as_ref()
    }

    /// Whether the last factorisation determined the inertia of the matrix, so that its negative eigenvalues are counted.
    pub fn has_inertia(&self) -> bool {
        self.ready == Ready::Direct
    }

    /// Whether this matrix alone is factorised although the iterative path was chosen.
    pub fn fell_back(&self) -> bool {
        self.multigrid.is_some() && self.ready == Ready::Direct
    }

    /// Number of stored entries of the factor L, or of the hierarchy.
    pub fn nnz(&self) -> usize {
        match (&self.multigrid, &self.direct) {
            (Some(multigrid), _) => multigrid.size.entries,
            (None, direct) => direct.as_ref().map_or(0, Bordered::nnz),
        }
    }

    /// Memory that the factorisation will take \[bytes\]: L, its copy in single precision, and the messages that wait during the elimination. On the
    /// iterative path it is estimated from set-ups that were measured on large meshes.
    pub fn bytes(&self) -> f64 {
        match &self.direct {
            Some(direct) => 12.0 * direct.nnz() as f64 + direct.work_bytes() as f64,
            None => SET_UP_BYTES * self.pattern.nnz() as f64,
        }
    }

    /// Cost of a factorisation in back-substitutions, by operation counts; on the iterative path, cost of a set-up in applications of the hierarchy.
    pub fn relative_cost(&self) -> f64 {
        match &self.multigrid {
            Some(_) => CYCLES_PER_SET_UP,
            None => self.nnz() as f64 / self.pattern.n as f64 / ENTRIES_PER_SOLVE,
        }
    }

    /// Largest number of iterations with a lagged factor that costs less than a new factorisation, by operation counts.
    pub fn patience(&self, solves: f64) -> usize {
        if self.multigrid.is_some() { PATIENCE } else { (solves * self.relative_cost()).ceil() as usize }
    }

    /// Number of additions and multiplications of one factorisation: the sum of the squared column lengths of L. On the iterative path, that of one
    /// set-up.
    pub fn flops(&self) -> f64 {
        match (&self.multigrid, &self.direct) {
            (Some(multigrid), _) => multigrid.size.set_up,
            (None, direct) => direct.as_ref().map_or(0.0, Bordered::flops),
        }
    }

    /// Sets the displacements \[unknowns\] at which the next matrix is the tangent, because rigid motions depend on the positions of the nodes.
    pub fn move_to(&mut self, x: &[f64]) {
        if self.multigrid.is_some() {
            self.displacement.clear();
            self.displacement.extend_from_slice(x);
        }
    }

    /// Factorises A by LLᵀ or, if a pivot is not positive, by LDLᵀ with the negative pivots counted. On the iterative path a hierarchy is set up.
    pub fn factorise(&mut self, values: &[f64]) -> Result<(), LinearError> {
        let start = Instant::now();
        let result = self.factorise_untimed(values);
        self.factor_time += start.elapsed();
        result
    }

    fn factorise_untimed(&mut self, values: &[f64]) -> Result<(), LinearError> {
        self.count += 1;
        self.ready = Ready::None;
        self.negative_eigenvalues = 0;
        if values.iter().any(|v| !v.is_finite()) {
            return Err(LinearError::Singular);
        }
        if self.multigrid.is_none() {
            return self.factorise_directly(values);
        }
        // Frees the memory of an earlier factorisation, which a new one needs
        self.direct = None;
        if self.set_up_hierarchy(values, BottomFactor::Definite) {
            return Ok(());
        }
        match self.fall_back(values, GaveUp::Indefinite) {
            // The displacement block of a mixed formulation may be indefinite although the whole tangent is stable
            Err(LinearError::Indefinite { .. }) if self.set_up_hierarchy(values, BottomFactor::Indefinite) => Ok(()),
            other => other,
        }
    }

    /// Sets up a hierarchy of A with this treatment of the bottom; returns whether it succeeded.
    fn set_up_hierarchy(&mut self, values: &[f64], bottom: BottomFactor) -> bool {
        let Some(multigrid) = &mut self.multigrid else { return false };
        if bottom == BottomFactor::Indefinite && multigrid.is_symmetric() {
            return false;
        }
        let sparse = &values[..self.pattern.sparse.nnz()];
        let is_set_up = multigrid.set_up(sparse, &self.displacement, bottom).is_ok();
        if is_set_up {
            self.ready = Ready::Iterative;
        }
        is_set_up
    }

    /// Factorises A and counts its negative eigenvalues, on the iterative path too if the memory allows it.
    pub fn factorise_counting(&mut self, values: &[f64]) -> Result<(), LinearError> {
        if self.multigrid.is_none() {
            return self.factorise(values);
        }
        let start = Instant::now();
        self.count += 1;
        let result = self.fall_back(values, GaveUp::Indefinite);
        self.factor_time += start.elapsed();
        result
    }

    /// Factorises a matrix that is not suited for the Krylov method, or for which this is slow, if the memory allows it.
    pub(super) fn fall_back(&mut self, values: &[f64], gave_up: GaveUp) -> Result<(), LinearError> {
        self.ready = Ready::None;
        self.multigrid.iter_mut().for_each(Multigrid::clear);
        if self.too_large.is_none() {
            self.direct = Bordered::new(&self.pattern, self.in_order);
            match self.factorise_directly(values) {
                Err(LinearError::TooLarge { gigabytes }) => (self.direct, self.too_large) = (None, Some(gigabytes)),
                other => {
                    self.fallbacks += usize::from(other.is_ok());
                    return other;
                }
            }
        }
        let gigabytes = self.too_large.expect("it was found to be too large");
        match gave_up {
            GaveUp::Indefinite => Err(LinearError::Indefinite { gigabytes }),
            _ => Err(LinearError::Slow { gigabytes }),
        }
    }

    fn factorise_directly(&mut self, values: &[f64]) -> Result<(), LinearError> {
        let Some(direct) = self.direct.as_mut() else {
            return Err(LinearError::TooLarge { gigabytes: gigabytes(u32::MAX as usize) });
        };
        let gigabytes = gigabytes(direct.nnz());
        if gigabytes > self.method.factor_memory {
            return Err(LinearError::TooLarge { gigabytes });
        }
        if self.definiteness == Definiteness::Saddle || !direct.definite(values) {
            self.negative_eigenvalues = direct.indefinite(&self.pattern, values).map_err(|_| LinearError::Singular)?;
        }
        self.ready = Ready::Direct;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sparse::SymPattern;

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
            assert_eq!(factor.negative_eigenvalues, negative, "d = {d}");
            factor.solve(&values, &mut b).expect("accurate");
            // Condition number below 100, so that 1e-12 leaves a margin of two digits
            assert!(b.iter().zip(&x).all(|(b, x)| (b - x).abs() < 1e-12), "d = {d}");
        }
    }

    /// Condition number below 100 and single precision, ε = 6e-8: 1e-4 leaves room for a few roundings per row.
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
