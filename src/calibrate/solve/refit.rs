//! Least squares in some of the unknowns of a law, with the others held: Levenberg–Marquardt from nearby values, with factors bounded below by zero.

use super::offset::Offset;
use crate::calibrate::judgement::misfit::sum_of_squares;
use crate::calibrate::{FittableLaw, Sample};
use crate::material::FitTerms;
use nalgebra::{DMatrix, DVector};

const STEPS: usize = 60;
/// Relative decrease of the sum of squares below which the search ends
const FLAT: f64 = 1e-9;

/// Constants of which only some are fitted.
#[derive(Clone, Debug)]
pub struct Held {
    /// Initial values of all constants \[SI\]
    pub values: Vec<f64>,
    /// Indices of those that are fitted
    pub free: Vec<usize>,
}

/// The rows of a law with its unknowns: the constants, followed by strain offsets.
#[derive(Clone, Copy)]
pub struct Refit<'a> {
    pub model: FittableLaw,
    pub slack: &'a [Offset],
    pub samples: &'a [Sample],
    pub weight: &'a [f64],
}

impl Refit<'_> {
    /// The minimum of S over the unknowns with these indices, found from `x`, and S there; `None` if `x` is not admissible.
    pub fn refitted(&self, mut x: Vec<f64>, free: &[usize]) -> Option<(Vec<f64>, f64)> {
        let mut square = self.square(&x)?;
        let mut damping = 1e-9;
        for _ in 0..STEPS {
            if free.is_empty() {
                break;
            }
            let Some((next, lower)) = self.step(&x, free, square, &mut damping) else { break };
            let still = lower > square * (1.0 - FLAT);
            (x, square) = (next, lower);
            if still {
                break;
            }
        }
        Some((x, square))
    }

    fn constants<'b>(&self, values: &'b [f64]) -> &'b [f64] {
        &values[..self.model.parameters().len()]
    }

    /// The data point shifted by the strain offsets among these values.
    fn moved(&self, values: &[f64], s: &Sample) -> Sample {
        let pairs = self.slack.iter().zip(&values[self.model.parameters().len()..]);
        let by = |(o, v): (&Offset, &f64)| o.shifted(s, v - o.strain);
        // A data point inside the slack stays there
        pairs.filter(|(o, v)| o.is_of(s) && s.stretch != 1.0 && **v != o.strain).map(by).next().unwrap_or(*s)
    }

    /// P \[Pa\]
    fn law(&self, values: &[f64], s: &Sample) -> f64 {
        self.model.at(self.constants(values), &self.moved(values, s))
    }

    /// ∂P/∂ constants and offsets
    fn slopes(&self, values: &[f64], s: &Sample) -> Vec<f64> {
        let (own, s) = (self.constants(values), self.moved(values, s));
        let offsets = self.slack.iter().map(|o| o.slope(self.model, own, &s));
        self.model.sensitivities(own, &s).into_iter().chain(offsets).collect()
    }

    /// S; `None` if the law is not defined or a factor is negative.
    pub fn square(&self, values: &[f64]) -> Option<f64> {
        let sum = sum_of_squares(self.samples, self.weight, |s| self.law(values, s));
        let admitted = match &self.model.form.terms {
            FitTerms::Linear(_) => true,
            FitTerms::Separable(f) => self.constants(values).chunks_exact(2).all(|v| v[0] / (f.factor)(v[1]).0 >= 0.0),
        };
        (admitted && sum.is_finite()).then_some(sum)
    }

    /// A Levenberg–Marquardt step in some constants that lowers S; factors are bounded below by zero.
    fn step(&self, x: &[f64], free: &[usize], square: f64, damping: &mut f64) -> Option<(Vec<f64>, f64)> {
        let scale: Vec<f64> = free.iter().map(|k| if x[*k] == 0.0 { 1.0 } else { x[*k].abs() }).collect();
        let rows = self.samples.iter().zip(self.weight);
        let entries: Vec<f64> = rows
            .clone()
            .flat_map(|(s, w)| {
                let all = self.slopes(x, s);
                free.iter().zip(&scale).map(|(k, z)| w * z * all[*k]).collect::<Vec<_>>()
            })
            .collect();
        let jacobian = DMatrix::from_row_slice(self.samples.len(), free.len(), &entries);
        let residual = rows.map(|(s, w)| w * (s.stress - self.law(x, s)));
        let residual = DVector::from_iterator(self.samples.len(), residual);
        let (normal, slope) = (jacobian.transpose() * &jacobian, jacobian.transpose() * residual);
        let largest = normal.diagonal().max();
        for _ in 0..20 {
            let mut a = normal.clone();
            for k in 0..free.len() {
                a[(k, k)] += *damping * normal[(k, k)].max(1e-12 * largest);
            }
            let mut next = x.to_vec();
            if let Some(inverse) = a.cholesky() {
                let change = inverse.solve(&slope);
                free.iter().zip(&scale).zip(change.iter()).for_each(|((k, z), d)| next[*k] += z * d);
                self.stop_at_zero(&mut next, free);
                if let Some(lower) = self.square(&next).filter(|s| *s < square) {
                    *damping = (0.1 * *damping).max(1e-12);
                    return Some((next, lower));
                }
            }
            *damping = 10.0 * damping.max(1e-9);
        }
        None
    }

    fn stop_at_zero(&self, values: &mut [f64], free: &[usize]) {
        if let FitTerms::Separable(f) = &self.model.form.terms {
            let own = self.model.parameters().len();
            for k in free.iter().filter(|k| **k < own && **k % 2 == 0) {
                if values[*k] / (f.factor)(values[k + 1]).0 < 0.0 {
                    values[*k] = 0.0;
                }
            }
        }
    }
}
