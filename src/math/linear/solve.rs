//! Solution with a prepared factor, checked: ‖b − Ax‖ ≤ 1e-9 ‖b‖, or the residual is at the rounding level.
//!
//! A column that the Krylov method does not solve is solved by a factorisation, if the memory allows one.

use super::error::LinearError;
use super::factor::{Factor, GaveUp, Ready};
use super::method::MOST_ITERATIONS;
use crate::math::gmres::gmres;
use crate::math::pcg::{Outcome, pcg};
use crate::math::vector::norm;
use std::time::Instant;

/// Largest accepted ‖Ax − b‖/‖b‖ of a solve, after refinement.
const SOLVE_TOLERANCE: f64 = 1e-9;
/// Reduction of the residual after which minimal residuals are restarted.
const RESTART: f64 = 1e-3;
/// Size of the residual relative to ‖|A||x|‖ that counts as rounding: slender bodies and large stiffness ratios allow no smaller one, and x is then
/// the exact solution of a matrix that differs from A in its last digits (Oettli & Prager 1964).
const ROUNDING: f64 = 16.0 * f64::EPSILON;

impl Factor {
    /// Solves A X = B in place; `columns` holds consecutive columns of length n. Checks the residual and refines at most twice.
    pub fn solve(&mut self, values: &[f64], columns: &mut [f64]) -> Result<(), LinearError> {
        let start = Instant::now();
        let rhs = columns.to_vec();
        let result = self.solve_checked(values, &rhs, columns);
        self.solve_time += start.elapsed();
        if self.ready == Ready::Direct {
            self.solves += columns.len() / self.pattern.n;
        }
        match result {
            Ok(()) => Ok(()),
            Err(GaveUp::Inaccurate { residual }) if self.ready == Ready::Direct => {
                Err(LinearError::Inaccurate { residual })
            }
            Err(why) => {
                let start = Instant::now();
                let factorised = self.fall_back(values, why);
                self.count += 1;
                self.factor_time += start.elapsed();
                factorised?;
                columns.copy_from_slice(&rhs);
                self.solve(values, columns)
            }
        }
    }

    fn solve_checked(&mut self, values: &[f64], rhs: &[f64], columns: &mut [f64]) -> Result<(), GaveUp> {
        let n = self.pattern.n;
        let bounds: Vec<f64> = rhs.chunks_exact(n).map(|b| SOLVE_TOLERANCE * norm(b)).collect();
        self.solve_once(values, columns, &bounds)?;
        let mut residual = vec![0.0; n];
        for ((x, b), bound) in columns.chunks_exact_mut(n).zip(rhs.chunks_exact(n)).zip(&bounds) {
            for refinement in 0..3 {
                self.pattern.multiply(values, x, &mut residual);
                residual.iter_mut().zip(b).for_each(|(r, b)| *r = b - *r);
                let size = norm(&residual);
                if size <= *bound || size <= ROUNDING * norm(&self.pattern.multiply_abs(values, x)) {
                    break;
                }
                if !size.is_finite() || refinement == 2 {
                    return Err(GaveUp::Inaccurate { residual: size / norm(b) });
                }
                self.solve_once(values, &mut residual, &[*bound])?;
                x.iter_mut().zip(&residual).for_each(|(x, d)| *x += d);
            }
        }
        Ok(())
    }

    /// Solves without a check; the Krylov method solves to half of the bounds \[columns\], which leaves room for rounding.
    fn solve_once(&mut self, values: &[f64], columns: &mut [f64], bounds: &[f64]) -> Result<(), GaveUp> {
        if self.ready == Ready::Direct {
            self.direct.as_ref().expect("it was factorised").solve(columns);
            return Ok(());
        }
        let multigrid = self.multigrid.as_ref().expect("a hierarchy was set up");
        let multiply = |v: &[f64]| {
            let mut product = vec![0.0; v.len()];
            self.pattern.multiply(values, v, &mut product);
            product
        };
        let precondition = |r: &[f64]| {
            let mut z = r.to_vec();
            multigrid.apply(&mut z);
            z
        };
        for (b, bound) in columns.chunks_exact_mut(self.pattern.n).zip(bounds) {
            let (outcome, iterations) = if multigrid.is_symmetric() {
                pcg(multiply, precondition, b, 0.5 * bound, MOST_ITERATIONS)
            } else {
                restarted(multiply, precondition, b, 0.5 * bound)
            };
            self.gradients.solves += 1;
            self.gradients.iterations += iterations;
            self.solves += iterations;
            match outcome {
                Outcome::Solved(x) => b.copy_from_slice(&x),
                Outcome::Indefinite => return Err(GaveUp::Indefinite),
                Outcome::Slow => return Err(GaveUp::Slow),
            }
        }
        Ok(())
    }

    /// Solves without a check, for use as a preconditioner: with L rounded to single precision, which halves the memory traffic, or by one
    /// application of the hierarchy.
    pub fn solve_roughly(&mut self, columns: &mut [f64]) {
        let start = Instant::now();
        let n = self.pattern.n;
        match (self.ready, &mut self.direct, &self.multigrid) {
            (Ready::Direct, Some(direct), _) => direct.solve_roughly(columns),
            (Ready::Iterative, _, Some(multigrid)) => columns.chunks_exact_mut(n).for_each(|r| multigrid.apply(r)),
            _ => unreachable!("solve is called only after a successful factorisation"),
        }
        self.solves += columns.len() / n;
        self.solve_time += start.elapsed();
    }
}

/// Generalised minimal residuals, restarted whenever three digits are gained, so that few directions are stored.
fn restarted(
    multiply: impl Fn(&[f64]) -> Vec<f64>,
    precondition: impl Fn(&[f64]) -> Vec<f64>,
    b: &[f64],
    bound: f64,
) -> (Outcome, usize) {
    let (mut x, mut left, mut products) = (vec![0.0; b.len()], b.to_vec(), 0);
    while norm(&left) > bound {
        let next = bound.max(RESTART * norm(&left));
        let most = MOST_ITERATIONS - products;
        let Ok((dx, count)) = gmres(&multiply, |r| Ok(precondition(r)), &left, next, most) else {
            return (Outcome::Slow, MOST_ITERATIONS);
        };
        products += count;
        x.iter_mut().zip(&dx).for_each(|(x, d)| *x += d);
        left.iter_mut().zip(multiply(&x)).zip(b).for_each(|((left, ax), b)| *left = b - ax);
    }
    (Outcome::Solved(x), products)
}
