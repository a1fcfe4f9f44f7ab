//! One stiffness μ ≥ 0 from P ≈ μ g, twice: as a convex QP by clarabel and by gradient descent of argmin.
//!
//! Both see the unit-free problem min ½‖m ĝ − p̂‖² with ĝ = g/‖g‖, p̂ = P/‖P‖, so m* = ĝ·p̂ = cos(g, P) ≤ 1 and
//! μ = m ‖P‖/‖g‖. The second derivative is 1, hence |m − m*| equals the gradient left over. Both stop at a gradient
//! ≤ 1e-10, their answers differ by at most 2e-10, and relative to m* ≥ [`LEAST_COSINE`] by at most 1e-8.

use super::FitError;
use argmin::core::{CostFunction, Error, Executor, Gradient, State};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus};
use serde::Serialize;

/// Largest gradient left over by either solver [–]
const GRADIENT: f64 = 1e-10;
/// Data that are nearly orthogonal to the law say nothing on its stiffness [–]
pub const LEAST_COSINE: f64 = 0.02;
/// Largest relative difference of the two answers [–]
const AGREEMENT: f64 = 2.0 * GRADIENT / LEAST_COSINE;

/// The two answers side by side.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct SolverCheck {
    /// [SI unit of the parameter]
    pub clarabel: f64,
    /// [SI unit of the parameter]
    pub argmin: f64,
    pub relative_difference: f64,
    pub allowed: f64,
}

struct Scaled<'a> {
    g: &'a [f64],
    p: &'a [f64],
}

impl CostFunction for Scaled<'_> {
    type Param = Vec<f64>;
    type Output = f64;
    fn cost(&self, m: &Vec<f64>) -> Result<f64, Error> {
        Ok(self.g.iter().zip(self.p).map(|(g, p)| 0.5 * (m[0] * g - p).powi(2)).sum())
    }
}

impl Gradient for Scaled<'_> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;
    fn gradient(&self, m: &Vec<f64>) -> Result<Vec<f64>, Error> {
        Ok(vec![self.g.iter().zip(self.p).map(|(g, p)| g * (m[0] * g - p)).sum()])
    }
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// μ ≥ 0 of least squares for P [Pa] ≈ μ g [–], row by row.
pub fn stiffness(g: &[f64], p: &[f64]) -> Result<SolverCheck, FitError> {
    let (g_norm, p_norm) = (norm(g), norm(p));
    if p_norm == 0.0 {
        return Err(FitError::ZeroStress);
    }
    let g: Vec<f64> = g.iter().map(|x| x / g_norm).collect();
    let p: Vec<f64> = p.iter().map(|x| x / p_norm).collect();
    let cosine: f64 = g.iter().zip(&p).map(|(g, p)| g * p).sum();
    if cosine < LEAST_COSINE {
        return Err(FitError::NotPositive { cosine });
    }
    let (qp, descent) = (by_clarabel(cosine)?, by_argmin(&g, &p)?);
    let difference = (qp - descent).abs() / qp.abs();
    if difference.is_nan() || difference > AGREEMENT {
        return Err(FitError::Disagree { clarabel: qp, argmin: descent, difference, tolerance: AGREEMENT });
    }
    let scale = p_norm / g_norm;
    Ok(SolverCheck {
        clarabel: qp * scale,
        argmin: descent * scale,
        relative_difference: difference,
        allowed: AGREEMENT,
    })
}

/// min ½m² − (ĝ·p̂) m, m ≥ 0
fn by_clarabel(cosine: f64) -> Result<f64, FitError> {
    let quadratic = CscMatrix::from(&[[1.0]]);
    let lower_bound = CscMatrix::from(&[[-1.0]]);
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 0.01 * GRADIENT,
        tol_gap_rel: 0.01 * GRADIENT,
        tol_feas: 0.01 * GRADIENT,
        ..DefaultSettings::default()
    };
    let fail = |status: String| FitError::Solver { solver: "clarabel", status };
    let mut solver = DefaultSolver::new(&quadratic, &[-cosine], &lower_bound, &[0.0], &[NonnegativeConeT(1)], settings)
        .map_err(|e| fail(format!("{e:?}")))?;
    solver.solve();
    match solver.solution.status {
        SolverStatus::Solved => Ok(solver.solution.x[0]),
        status => Err(fail(format!("{status:?}"))),
    }
}

/// L-BFGS with the line search of Moré and Thuente on the residuals themselves, from m = 0
fn by_argmin(g: &[f64], p: &[f64]) -> Result<f64, FitError> {
    let fail = |status: String| FitError::Solver { solver: "argmin", status };
    let solver = LBFGS::new(MoreThuenteLineSearch::new(), 3)
        .with_tolerance_grad(GRADIENT)
        .and_then(|s| s.with_tolerance_cost(0.0))
        .map_err(|e| fail(e.to_string()))?;
    let run = Executor::new(Scaled { g, p }, solver)
        .configure(|state| state.param(vec![0.0]).max_iters(50))
        .run()
        .map_err(|e| fail(e.to_string()))?;
    run.state().get_best_param().map(|m| m[0]).ok_or_else(|| fail("no answer".into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_solvers_meet_the_closed_form() {
        let g = [0.06, 0.33, 0.59, 0.87];
        let p = [0.03e6, 0.13e6, 0.22e6, 0.32e6];
        let closed: f64 = g.iter().zip(&p).map(|(g, p)| g * p).sum::<f64>() / g.iter().map(|g| g * g).sum::<f64>();
        let check = stiffness(&g, &p).expect("solvable");
        assert!((check.clarabel / closed - 1.0).abs() < 1e-10, "{check:?} against {closed}");
        assert!((check.argmin / closed - 1.0).abs() < 1e-10, "{check:?} against {closed}");
    }

    #[test]
    fn stress_against_the_stretch_is_refused() {
        assert!(matches!(stiffness(&[1.0, 2.0], &[-1.0, -2.0]), Err(FitError::NotPositive { .. })));
        assert!(matches!(stiffness(&[1.0, 2.0], &[2.0, -1.0]), Err(FitError::NotPositive { .. })));
        assert!(matches!(stiffness(&[1.0, 2.0], &[0.0, 0.0]), Err(FitError::ZeroStress)));
    }
}
