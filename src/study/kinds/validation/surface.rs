//! Response surfaces: a quantity as a polynomial of the constants to be determined, with its derivatives by the uncertain inputs.
//!
//! ```text
//! f(ξ, s) = p(ξ) + Σ sⱼ gⱼ(ξ)          ξ ∈ [−1, 1]ᵐ over the ranges of the constants, s in standard deviations of the inputs
//! ```
//!
//! p is fitted to values and exact derivatives at the points of the design, gⱼ to the derivatives by input j as its values. Both are least-squares
//! fits with all monomials up to a total degree. Source: Myers, Montgomery & Anderson-Cook, *Response Surface Methodology*, 4th ed. 2016, chapters 7
//! and 8; with derivatives: Morris, Mitchell & Ylvisaker, *Technometrics* 35, 1993.

use crate::math::svd::svd;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use std::cmp::Ordering;

/// Largest total degree of p; three points per axis with derivatives determine degree five along it.
const DEGREE: usize = 4;
/// Relative size below which singular values count as zero.
const RANK: f64 = 1e-9;

/// One run of the design.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Point ξ of the run \[constants\]
    pub at: Vec<f64>,
    pub value: f64,
    /// ∂f/∂ξ \[constants\]
    pub by_constants: Vec<f64>,
    /// ∂f/∂s \[inputs\]
    pub by_inputs: Vec<f64>,
}

/// A polynomial of several variables.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Polynomial {
    /// Exponents \[monomials × variables\]
    powers: Vec<Vec<i32>>,
    /// Coefficients \[monomials\]
    factors: Vec<f64>,
}

/// A quantity as a function of constants and inputs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Surface {
    value: Polynomial,
    by_inputs: Vec<Polynomial>,
}

/// Error of a design with too few runs, or runs too close together, to determine even a plane.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{runs} converged runs do not determine how it depends on {constants} constants; repair the others, or narrow the ranges"
)]
pub struct Undetermined {
    pub runs: usize,
    pub constants: usize,
}

impl Surface {
    /// Fits the runs of a design in `constants` dimensions.
    pub fn fit(constants: usize, samples: &[Sample]) -> Result<Self, Undetermined> {
        let undetermined = || Undetermined { runs: samples.len(), constants };
        let inputs = samples.first().map_or(0, |s| s.by_inputs.len());
        let values: Vec<(&[f64], f64)> = samples.iter().map(|s| (&s.at[..], s.value)).collect();
        let gradients: Vec<(&[f64], &[f64])> = samples.iter().map(|s| (&s.at[..], &s.by_constants[..])).collect();
        let value = Polynomial::fit(constants, &values, &gradients).ok_or_else(undetermined)?;
        let by_input = |j: usize| {
            let values: Vec<(&[f64], f64)> = samples.iter().map(|s| (&s.at[..], s.by_inputs[j])).collect();
            Polynomial::fit(constants, &values, &[]).ok_or_else(undetermined)
        };
        Ok(Self { value, by_inputs: (0..inputs).map(by_input).collect::<Result<_, _>>()? })
    }

    /// Returns the surface shifted by a constant, as by another mesh.
    #[must_use]
    pub fn moved(mut self, by: f64) -> Self {
        let constant = self.value.powers.iter().position(|p| p.iter().all(|n| *n == 0));
        self.value.factors[constant.expect("every polynomial has a constant term")] += by;
        self
    }

    /// Returns f(ξ, s) with ∂f/∂ξ and ∂f/∂s.
    pub fn at(&self, xi: &[f64], s: &[f64]) -> (f64, Vec<f64>, Vec<f64>) {
        let (mut value, mut by_constants) = self.value.at(xi);
        let mut by_inputs = Vec::with_capacity(s.len());
        for (g, s) in self.by_inputs.iter().zip(s) {
            let (slope, cross) = g.at(xi);
            value += s * slope;
            by_constants.iter_mut().zip(cross).for_each(|(d, c)| *d += s * c);
            by_inputs.push(slope);
        }
        (value, by_constants, by_inputs)
    }
}

impl Polynomial {
    /// A least-squares fit of the largest degree that the rows determine.
    fn fit(n: usize, values: &[(&[f64], f64)], gradients: &[(&[f64], &[f64])]) -> Option<Self> {
        let right: Vec<f64> =
            values.iter().map(|(_, v)| *v).chain(gradients.iter().flat_map(|(_, g)| g.iter().copied())).collect();
        (0..=if n == 0 { 0 } else { DEGREE }).rev().find_map(|degree| {
            let mut p = Self { powers: monomials(n, degree), factors: vec![] };
            if p.powers.len() > right.len() || (degree == 0 && n > 0) {
                return None;
            }
            let rows = values.iter().map(|(at, _)| p.row(at, None));
            let slopes = gradients.iter().flat_map(|(at, _)| (0..n).map(|k| p.row(at, Some(k))).collect::<Vec<_>>());
            let rows: Vec<f64> = rows.chain(slopes).flatten().collect();
            let matrix = DMatrix::from_row_slice(right.len(), p.powers.len(), &rows);
            let found = svd(matrix, true, true);
            let largest = found.singular_values.max();
            let least = found.singular_values.min();
            if least.partial_cmp(&(RANK * largest)) != Some(Ordering::Greater) {
                return None;
            }
            let solved = found.solve(&DVector::from_vec(right.clone()), 0.0).ok()?;
            p.factors = solved.iter().copied().collect();
            Some(p)
        })
    }

    /// Values of the monomials, or their derivatives by variable `along` \[monomials\].
    fn row(&self, at: &[f64], along: Option<usize>) -> Vec<f64> {
        let term = |powers: &Vec<i32>| {
            let factor = |(k, (n, x)): (usize, (&i32, &f64))| match along {
                Some(a) if a == k && *n == 0 => 0.0,
                Some(a) if a == k => f64::from(*n) * x.powi(n - 1),
                _ => x.powi(*n),
            };
            powers.iter().zip(at).enumerate().map(factor).product()
        };
        self.powers.iter().map(term).collect()
    }

    fn at(&self, at: &[f64]) -> (f64, Vec<f64>) {
        let sum = |row: Vec<f64>| row.iter().zip(&self.factors).map(|(m, f)| m * f).sum();
        (sum(self.row(at, None)), (0..at.len()).map(|k| sum(self.row(at, Some(k)))).collect())
    }
}

/// Exponents of all monomials of `n` variables up to a total degree, the constant first.
fn monomials(n: usize, degree: usize) -> Vec<Vec<i32>> {
    let mut all: Vec<Vec<i32>> = vec![vec![]];
    for _ in 0..n {
        let longer = |p: Vec<i32>| {
            let left = i32::try_from(degree).unwrap_or(i32::MAX) - p.iter().sum::<i32>();
            (0..=left).map(move |k| [&p[..], &[k]].concat())
        };
        all = all.into_iter().flat_map(longer).collect();
    }
    all.sort_by_key(|p| p.iter().sum::<i32>());
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::statistics::larger;

    /// A quartic of two constants, with an input whose effect depends on them, is reproduced up to rounding in values and derivatives.
    #[test]
    fn quartics_are_reproduced() {
        let f = |x: f64, y: f64| 1.0 + x - 2.0 * y + x * y + 0.5 * x * x * y * y - y.powi(4);
        let by = |x: f64, y: f64| vec![1.0 + y + x * y * y, -2.0 + x + x * x * y - 4.0 * y.powi(3)];
        let g = |x: f64, y: f64| 0.3 + 0.1 * x - 0.2 * x * y;
        let ends = [-1.0, 0.0, 1.0];
        let design: Vec<Sample> = (ends.iter())
            .flat_map(|x| ends.map(|y| (*x, y)))
            .map(|(x, y)| Sample { at: vec![x, y], value: f(x, y), by_constants: by(x, y), by_inputs: vec![g(x, y)] })
            .collect();
        let surface = Surface::fit(2, &design).expect("nine runs");
        let (x, y, s) = (0.37, -0.81, 1.7);
        let (value, by_constants, by_inputs) = surface.at(&[x, y], &[s]);
        assert!((value - f(x, y) - s * g(x, y)).abs() < 1e-12, "{value}");
        let expected = [by(x, y)[0] + s * (0.1 - 0.2 * y), by(x, y)[1] - s * 0.2 * x];
        by_constants.iter().zip(expected).for_each(|(a, b)| assert!((a - b).abs() < 1e-12, "{a} {b}"));
        assert!((by_inputs[0] - g(x, y)).abs() < 1e-12);
        assert!((surface.clone().moved(0.5).at(&[x, y], &[s]).0 - value - 0.5).abs() < 1e-12);
        let misfit = |s: &Sample| (surface.at(&s.at, &[]).0 - s.value).abs();
        assert!(design.iter().map(misfit).fold(0.0, larger) < 1e-12);
    }

    /// Runs at one point determine no dependence on the constants; without constants one run is enough.
    #[test]
    fn too_few_runs_are_refused() {
        let one = Sample { at: vec![0.0, 0.0], value: 1.0, by_constants: vec![f64::NAN; 0], by_inputs: vec![] };
        assert!(Surface::fit(2, &[one.clone(), one]).is_err());
        let fixed = Sample { at: vec![], value: 2.0, by_constants: vec![], by_inputs: vec![0.5] };
        assert_eq!(Surface::fit(0, &[fixed]).expect("one run").at(&[], &[2.0]).0, 3.0);
    }
}
