//! Constants from measurements that share errors, and predictions with every source of their uncertainty.
//!
//! The data d = f(ξ, s) + C s + ε of the calibration, with independent ε ~ N(0, σ²), and with s ~ N(0, 1) for the inputs and for the errors that
//! several data share, give
//!
//! ```text
//! (ξ̂, ŝ) = argmin Σ ((dᵢ − fᵢ(ξ, s) − Cᵢ s)/σᵢ)² + |s|²           the constants have no prior
//! H = Jᵀ W J + P                                                   J = ∂(f + C s)/∂(ξ, s), W = 1/σ², P = diag(0, 1)
//! error of a prediction = Jₚ H⁻¹ (Jᵀ W ε − P s) − … + εₚ           a sum over independent sources
//! ```
//!
//! so that anything common to calibration and prediction, such as a length, cancels as far as it does in reality. Sources: Kennedy & O'Hagan, *J. R.
//! Stat. Soc. B* 63, 2001 (with Gaussian errors and no discrepancy term); JCGM 100:2008 (GUM), 5.1 and H.3.
//!
//! Limit: the discrepancy of the model is not modelled; if the data scatter more than their errors predict, the intervals are
//! [widened](crate::study::kinds::validation::consistency::Consistency::birge).

use crate::study::kinds::validation::surface::Surface;
use nalgebra::{DMatrix, DVector};
use std::cmp::Ordering;

/// Largest number of steps of the search.
const STEPS: usize = 100;
/// Length of a step, in standard deviations, below which the search ends.
const SETTLED: f64 = 1e-6;
/// Largest |ξ| of the search: beyond the design a surface is an extrapolation.
pub const FARTHEST: f64 = 2.0;
/// Standard deviation of a constant, in half-ranges, above which the data do not determine it.
const OPEN: f64 = 1e3;

/// A quantity that is measured or predicted.
#[derive(Clone, Debug)]
pub struct Response {
    pub surface: Surface,
    /// Indices of the constants that its surface depends on
    pub constants: Vec<usize>,
    /// Indices of the sources that are the inputs of its surface
    pub inputs: Vec<usize>,
    /// Standard deviations of the independent errors of its measurement
    pub noise: Vec<f64>,
    /// Scatter between repeats, if it is the last of these errors
    pub scatter: Option<Estimated>,
    /// Sources that add to its measurement: (index, amount of one standard deviation)
    pub shared: Vec<(usize, f64)>,
}

/// A scatter that is estimated from repeats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimated {
    /// Quantity, and index of its scatter: all data with the same pair have it from the same repeats
    pub pool: (usize, usize),
    pub freedom: usize,
    /// Factor by which its deviation is widened because of its few degrees of freedom
    pub factor: f64,
}

impl Response {
    /// Returns the standard deviation σ of all independent errors together.
    pub fn sigma(&self) -> f64 {
        self.noise.iter().map(|s| s * s).sum::<f64>().sqrt()
    }

    /// Returns the value that would be measured without independent errors.
    pub fn value(&self, xi: &[f64], s: &[f64]) -> f64 {
        self.at(xi, s).0
    }

    /// The measured value with its derivatives ∂/∂(ξ, s).
    fn at(&self, xi: &[f64], s: &[f64]) -> (f64, DVector<f64>) {
        let of = |all: &[f64], own: &[usize]| own.iter().map(|k| all[*k]).collect::<Vec<_>>();
        let (mut value, by_constants, by_inputs) = self.surface.at(&of(xi, &self.constants), &of(s, &self.inputs));
        let m = xi.len();
        let mut row = DVector::zeros(m + s.len());
        self.constants.iter().zip(by_constants).for_each(|(k, d)| row[*k] = d);
        self.inputs.iter().zip(by_inputs).for_each(|(k, d)| row[m + k] = d);
        for (k, amount) in &self.shared {
            value += amount * s[*k];
            row[m + k] += amount;
        }
        (value, row)
    }
}

/// The data of a calibration.
#[derive(Clone, Debug)]
pub struct Problem<'a> {
    pub constants: usize,
    pub sources: usize,
    pub data: Vec<&'a Response>,
}

/// Reason why the data do not determine the constants.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum JointError {
    #[error("the data do not determine constant {constant}; add a record that depends on it, or give it as an input")]
    Undetermined { constant: usize },
    #[error("the search left the range of constant {constant}; widen it, or look for a mistake in the measured values")]
    Outside { constant: usize },
}

/// The constants determined by the data.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Constants ξ̂
    pub xi: Vec<f64>,
    /// Sources ŝ, in standard deviations
    pub s: Vec<f64>,
    /// H⁻¹ \[(constants + sources)²\]
    pub covariance: DMatrix<f64>,
    /// J \[data × (constants + sources)\]
    jacobian: DMatrix<f64>,
    /// Residuals (d − f − C s)/σ at the solution \[data\]
    pub residuals: Vec<f64>,
    /// Sum of squares at the solution, including those of the sources
    pub chi2: f64,
    /// Number of data minus number of constants
    pub freedom: usize,
}

impl Problem<'_> {
    /// Finds the constants that fit the measured values best, starting from the centre of their ranges.
    pub fn solve(&self, values: &[f64]) -> Result<Solution, JointError> {
        self.solve_around(values, &vec![0.0; self.sources])
    }

    /// Finds the constants that fit the measured values best, with sources that are expected at `prior`.
    pub fn solve_around(&self, values: &[f64], prior: &[f64]) -> Result<Solution, JointError> {
        let (m, n) = (self.constants, self.constants + self.sources);
        let prior = DVector::from_row_slice(prior);
        let mut z = DVector::zeros(n);
        z.rows_mut(m, n - m).copy_from(&prior);
        let cost = |z: &DVector<f64>| {
            let square = |(r, d): (&&Response, &f64)| {
                ((d - r.value(&z.as_slice()[..m], &z.as_slice()[m..])) / r.sigma()).powi(2)
            };
            self.data.iter().zip(values).map(square).sum::<f64>() + (z.rows(m, n - m) - &prior).norm_squared()
        };
        let mut now = cost(&z);
        for _ in 0..STEPS {
            let (h, right, _, _) = self.normal(&z, values, &prior);
            let Some(step) = self.determined(&h)?.map(|l| l.solve(&right)) else { return Err(self.outside(&z)) };
            let covariance = self.covariance(&h)?;
            let is_small = (0..n).all(|k| step[k].abs() <= SETTLED * covariance[(k, k)].sqrt());
            let mut share = 1.0;
            loop {
                let mut next = &z + share * &step;
                next.rows_mut(0, m).iter_mut().for_each(|x| *x = x.clamp(-FARTHEST, FARTHEST));
                let then = cost(&next);
                if then <= now || share < 1e-6 {
                    (z, now) = if then <= now { (next, then) } else { (z, now) };
                    break;
                }
                share *= 0.5;
            }
            if is_small || share < 1e-6 {
                break;
            }
        }
        if (0..m).any(|k| z[k].abs() >= FARTHEST) {
            return Err(self.outside(&z));
        }
        let (h, _, jacobian, residuals) = self.normal(&z, values, &prior);
        let covariance = self.covariance(&h)?;
        let (xi, s) = (z.as_slice()[..m].to_vec(), z.as_slice()[m..].to_vec());
        let freedom = self.data.len().saturating_sub(m);
        Ok(Solution { xi, s, covariance, jacobian, residuals, chi2: now, freedom })
    }

    /// The error that names the constant farthest from the centre of its range.
    fn outside(&self, z: &DVector<f64>) -> JointError {
        let farthest = (0..self.constants).max_by(|a, b| z[*a].abs().total_cmp(&z[*b].abs()));
        JointError::Outside { constant: farthest.unwrap_or(0) }
    }

    /// H, the right-hand side of a Gauss–Newton step, J, and the residuals in units of σ.
    fn normal(
        &self,
        z: &DVector<f64>,
        values: &[f64],
        prior: &DVector<f64>,
    ) -> (DMatrix<f64>, DVector<f64>, DMatrix<f64>, Vec<f64>) {
        let (m, n) = (self.constants, self.constants + self.sources);
        let mut jacobian = DMatrix::zeros(self.data.len(), n);
        let mut residuals = vec![];
        let (mut h, mut right) = (DMatrix::zeros(n, n), DVector::zeros(n));
        for (i, (r, d)) in self.data.iter().zip(values).enumerate() {
            let (value, row) = r.at(&z.as_slice()[..m], &z.as_slice()[m..]);
            let weight = r.sigma().powi(-2);
            h.ger(weight, &row, &row, 1.0);
            right.axpy(weight * (d - value), &row, 1.0);
            jacobian.set_row(i, &row.transpose());
            residuals.push((d - value) / r.sigma());
        }
        for k in m..n {
            h[(k, k)] += 1.0;
            right[k] -= z[k] - prior[k - m];
        }
        (h, right, jacobian, residuals)
    }

    fn determined(&self, h: &DMatrix<f64>) -> Result<Option<nalgebra::Cholesky<f64, nalgebra::Dyn>>, JointError> {
        if let Some(constant) = (0..self.constants).find(|k| h[(*k, *k)].partial_cmp(&0.0) != Some(Ordering::Greater)) {
            return Err(JointError::Undetermined { constant });
        }
        Ok(h.clone().cholesky())
    }

    /// H⁻¹, if the data determine every constant.
    fn covariance(&self, h: &DMatrix<f64>) -> Result<DMatrix<f64>, JointError> {
        let undetermined = |constant| Err(JointError::Undetermined { constant });
        let Some(factor) = self.determined(h)? else { return undetermined(0) };
        let inverse = factor.inverse();
        let open = |k: &usize| inverse[(*k, *k)].sqrt().partial_cmp(&OPEN) != Some(Ordering::Less);
        match (0..self.constants).find(open) {
            Some(constant) => undetermined(constant),
            None => Ok(inverse),
        }
    }
}

/// The error of a prediction or of a constant, source by source, as signed standard deviations.
#[derive(Clone, Debug, PartialEq)]
pub struct Influence {
    /// Contribution of each source
    pub sources: Vec<f64>,
    /// Contribution of the independent errors of each datum
    pub data: Vec<f64>,
    /// Contribution of each own independent error of the predicted measurement
    pub own: Vec<f64>,
}

impl Influence {
    /// Returns the derivative by each datum, from its independent error.
    pub fn by_data(&self, problem: &Problem) -> Vec<f64> {
        self.data.iter().zip(&problem.data).map(|(error, r)| error / r.sigma()).collect()
    }

    /// Returns the standard deviation due to all sources together.
    pub fn deviation(&self) -> f64 {
        [&self.sources, &self.data, &self.own].into_iter().flatten().map(|x| x * x).sum::<f64>().sqrt()
    }
}

impl Solution {
    /// Returns the expected measured value of a response and the contributions to its error.
    pub fn predict(&self, problem: &Problem, response: &Response) -> (f64, Influence) {
        let (value, row) = response.at(&self.xi, &self.s);
        (value, Influence { own: response.noise.clone(), ..self.influence(problem, &row) })
    }

    /// Returns the contributions to the error of a constant, with `unit` converting ξ to the unit of the result.
    pub fn constant(&self, problem: &Problem, constant: usize, unit: f64) -> Influence {
        let mut row = DVector::zeros(self.covariance.nrows());
        row[constant] = unit;
        self.influence(problem, &row)
    }

    /// The errors of constants and sources projected onto a row of derivatives.
    fn influence(&self, problem: &Problem, row: &DVector<f64>) -> Influence {
        let carried = &self.covariance * row;
        let sources = (problem.constants..carried.len()).map(|k| -carried[k]).collect();
        let through = |(i, r): (usize, &&Response)| (self.jacobian.row(i) * &carried)[0] / r.sigma();
        let data = problem.data.iter().enumerate().map(through).collect();
        Influence { sources, data, own: vec![] }
    }

    /// Returns the χ² that remains for given errors of the data and of the sources, in standard deviations, with a response that is linear in
    /// constants and sources.
    pub fn misfit(&self, problem: &Problem, errors: &[f64], sources: &[f64]) -> f64 {
        let square = |all: &[f64]| all.iter().map(|e| e * e).sum::<f64>();
        let weighted = errors.iter().zip(&problem.data).map(|(e, r)| e / r.sigma());
        let mut right = self.jacobian.tr_mul(&DVector::from_iterator(errors.len(), weighted));
        right.rows_mut(problem.constants, sources.len()).iter_mut().zip(sources).for_each(|(b, s)| *b += s);
        square(errors) + square(sources) - right.dot(&(&self.covariance * &right))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::kinds::validation::surface::Sample;

    /// The plane f = c + g ξ + Σ hⱼ sⱼ.
    fn plane(c: f64, g: f64, h: &[f64]) -> Surface {
        let at = |x: f64| Sample { at: vec![x], value: c + g * x, by_constants: vec![g], by_inputs: h.to_vec() };
        Surface::fit(1, &[at(-1.0), at(0.0), at(1.0)]).expect("three runs")
    }

    fn response(surface: Surface, inputs: usize, sigma: f64, shared: Vec<(usize, f64)>) -> Response {
        Response {
            surface,
            constants: vec![0],
            inputs: (0..inputs).collect(),
            noise: vec![sigma],
            scatter: None,
            shared,
        }
    }

    /// One datum, one constant, one input with influence h₁ on the datum and h₂ on the prediction: by hand, error = (g₂/g₁) ε + (g₂ h₁/g₁ − h₂) s,
    /// which vanishes for an input that acts equally on both.
    #[test]
    fn what_both_share_cancels() {
        let (g1, g2, h1, h2, sigma) = (2.0, 3.0, 0.4, 0.9, 0.1);
        let datum = response(plane(1.0, g1, &[h1]), 1, sigma, vec![]);
        let target = response(plane(5.0, g2, &[h2]), 1, 0.05, vec![]);
        let problem = Problem { constants: 1, sources: 1, data: vec![&datum] };
        let solution = problem.solve(&[1.7]).expect("one constant");
        assert!((solution.xi[0] - 0.35).abs() < 1e-9 && solution.s[0].abs() < 1e-9, "{solution:?}");
        let (value, influence) = solution.predict(&problem, &target);
        assert!((value - 5.0 - 0.35 * g2).abs() < 1e-9);
        assert!((influence.data[0].abs() - g2 / g1 * sigma).abs() < 1e-12);
        assert!((influence.sources[0] - (g2 * h1 / g1 - h2)).abs() < 1e-12, "{influence:?}");
        let alike = Response { surface: plane(5.0, g2, &[g2 * h1 / g1]), ..target };
        assert!(solution.predict(&problem, &alike).1.sources[0].abs() < 1e-12);
    }

    /// Two data with a common zero error, against generalised least squares: ξ̂ = Σ(V⁻¹)(d − c)/Σ V⁻¹, V = σ² + τ².
    #[test]
    fn a_shared_zero_is_that_of_generalised_least_squares() {
        let (sigma, tau) = ([0.1, 0.3], 0.2);
        let at = |k: usize, g: f64| response(plane(0.0, g, &[]), 0, sigma[k], vec![(0, tau)]);
        let (a, b) = (at(0, 1.0), at(1, 2.0));
        let problem = Problem { constants: 1, sources: 1, data: vec![&a, &b] };
        let d = [0.3, 0.8];
        let solution = problem.solve(&d).expect("one constant");
        let v = DMatrix::from_row_slice(2, 2, &[0.01 + 0.04, 0.04, 0.04, 0.09 + 0.04]).try_inverse().expect("positive");
        let (g, d) = (DVector::from_vec(vec![1.0, 2.0]), DVector::from_row_slice(&d));
        let expected = (g.transpose() * &v * &d)[0] / (g.transpose() * &v * &g)[0];
        assert!((solution.xi[0] - expected).abs() < 1e-9, "{} {expected}", solution.xi[0]);
        let variance = 1.0 / (g.transpose() * &v * &g)[0];
        assert!((solution.covariance[(0, 0)] / variance - 1.0).abs() < 1e-9);
    }

    /// A constant on which no datum depends is named.
    #[test]
    fn a_constant_without_data_is_named() {
        let flat = response(plane(1.0, 0.0, &[]), 0, 0.1, vec![]);
        let problem = Problem { constants: 1, sources: 0, data: vec![&flat] };
        assert_eq!(problem.solve(&[1.0]).expect_err("flat"), JointError::Undetermined { constant: 0 });
    }

    /// Two equal data of one constant leave half the square of the difference of their errors, even if they share a zero error.
    #[test]
    fn errors_leave_their_difference() {
        let at = || response(plane(0.0, 2.0, &[]), 0, 0.1, vec![(0, 0.3)]);
        let (a, b) = (at(), at());
        let problem = Problem { constants: 1, sources: 1, data: vec![&a, &b] };
        let solution = problem.solve(&[0.3, 0.5]).expect("one constant");
        assert!((solution.misfit(&problem, &[1.5, -0.5], &[0.7]) - 2.0).abs() < 1e-9);
    }
}
