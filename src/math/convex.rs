//! Convex quadratic programs with conic constraints, solved by clarabel.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus};
use nalgebra::{DMatrix, DVector};

pub use clarabel::solver::{NonnegativeConeT, SecondOrderConeT, SupportedConeT};

/// The minimum of a program was not found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("clarabel did not finish ({status}) on a problem with one minimum; please report it")]
pub struct Unfinished {
    pub status: String,
}

/// Minimises ½ xᵀPx + qᵀx subject to b − Ax in the cones, which apply to consecutive rows. `tolerance` is the tolerance of the duality gap and of the
/// constraints; the default is that of clarabel.
pub fn minimum(
    (p, q): (&DMatrix<f64>, &DVector<f64>),
    (a, b): (&DMatrix<f64>, &DVector<f64>),
    cones: &[SupportedConeT<f64>],
    tolerance: Option<f64>,
) -> Result<DVector<f64>, Unfinished> {
    let mut settings = DefaultSettings { verbose: false, ..DefaultSettings::default() };
    if let Some(tolerance) = tolerance {
        (settings.tol_gap_abs, settings.tol_gap_rel, settings.tol_feas) = (tolerance, tolerance, tolerance);
    }
    let fail = |status: String| Unfinished { status };
    let mut solver = DefaultSolver::new(&sparse(p), q.as_slice(), &sparse(a), b.as_slice(), cones, settings)
        .map_err(|e| fail(format!("{e:?}")))?;
    solver.solve();
    match solver.solution.status {
        SolverStatus::Solved | SolverStatus::AlmostSolved => Ok(DVector::from_vec(solver.solution.x.clone())),
        status => Err(fail(format!("{status:?}"))),
    }
}

fn sparse(matrix: &DMatrix<f64>) -> CscMatrix<f64> {
    let rows: Vec<Vec<f64>> = matrix.row_iter().map(|row| row.iter().copied().collect()).collect();
    CscMatrix::from(&rows)
}
