//! The objective of a search: weighted residuals of all curves, stacked, and their derivatives with respect to all unknowns.
//!
//! The unknowns are the constants of the laws, which all curves share, followed by the offsets of single curves: the slack e of x, ŷ(x − e), and the
//! zero b of y, ŷ(x) + b.

use super::model::{Failure, ModelAnswer};
use super::observed::{ObservedCurve, origin};
use super::offset::OffsetAxis;
use super::weights::{self, CurveValues, Rule};
use super::{InverseError, Measured};
use crate::calibrate::judgement::origin::Origin;
use crate::calibrate::solve::huber_share;
use crate::calibrate::solve::rows::padded;
use crate::calibrate::{Loss, Weighting};
use crate::math::statistics::range;
use crate::math::svd::svd;
use crate::scene::Progress;
use nalgebra::{DMatrix, DVector};

/// Number of values of the slack that are tried at the start
const GRID: u32 = 40;

/// Distance of a data point from the beginning of a curve, relative to the range of x, below which it coincides with it \[–\]
const KINK: f64 = 1e-6;

/// An observer of a search: a closure that receives its progress, or more.
pub trait SearchWatch {
    /// Called after every step of every forward solve; false stops the search.
    fn progress(&mut self, now: Progress) -> bool;
    /// Called with the values of all unknowns whenever they are better than all earlier ones.
    fn better(&mut self, _values: &[f64]) {}
}

impl<F: FnMut(Progress) -> bool> SearchWatch for F {
    fn progress(&mut self, now: Progress) -> bool {
        self(now)
    }
}

/// The offset of x or y of one curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Offset {
    /// Index of its curve
    pub of: usize,
    pub axis: OffsetAxis,
}

/// Cosine between the changes of a curve and of its scene below which they have opposite signs
const OPPOSITE: f64 = -0.9;

/// Values of all unknowns with the answers of the scenes to them.
pub struct Point {
    pub values: Vec<f64>,
    pub answers: Vec<ModelAnswer>,
    /// w(y − ŷ) and w∂ŷ/∂θ over all data points
    pub residual: DVector<f64>,
    pub jacobian: DMatrix<f64>,
}

impl Point {
    /// ŷ − ŷ₀ of all data points, with ŷ₀ at rest: the part that a stiffer specimen changes in proportion.
    pub fn changes(&self) -> Vec<f64> {
        weights::simulated(&self.answers).concat()
    }
}

/// The curves, the weights of their data points, and the number of forward solves.
pub struct Objective<'a> {
    pub curves: &'a [ObservedCurve],
    pub offsets: Vec<Offset>,
    /// Specimen, test and curve of each data point
    pub origin: Origin,
    /// Weights of the data points; 1 before the first answer
    pub weights: CurveValues,
    /// √ of the weights of a robust loss that `weights` include; 1 without a robust loss
    pub shares: CurveValues,
    rule: Rule,
    /// ‖w(y − y₀)‖ over all curves, with y₀ the value of each scene at rest; `None` before the first answer
    size: Option<f64>,
    pub watch: &'a mut dyn SearchWatch,
    /// Smallest misfit so far, with these weights
    least: f64,
    pub solves: usize,
    pub failed: usize,
}

impl<'a> Objective<'a> {
    pub fn new(
        curves: &'a [ObservedCurve],
        weighting: Weighting,
        watch: &'a mut dyn SearchWatch,
    ) -> Result<Self, InverseError> {
        Measured::check_repeats(curves.iter().map(|c| (&*c.name, &c.measured)))?;
        let (origin, rule) = (origin(curves), Rule::new(curves, weighting)?);
        let ones: CurveValues = curves.iter().map(|c| vec![1.0; c.measured.y.len()]).collect();
        let asked = |(of, c): (usize, &'a ObservedCurve)| c.offsets.iter().map(move |axis| Offset { of, axis: *axis });
        let offsets = curves.iter().enumerate().flat_map(asked).collect();
        Ok(Self {
            curves,
            offsets,
            origin,
            weights: ones.clone(),
            shares: ones,
            rule,
            size: None,
            watch,
            least: f64::INFINITY,
            solves: 0,
            failed: 0,
        })
    }

    /// Norm of the weighted changes of the data, with which residuals are compared.
    pub fn size(&self) -> f64 {
        self.size.expect("a search begins with an answer")
    }

    /// Number of constants that the curves share.
    pub fn constants(&self) -> usize {
        self.curves[0].model.unknown.len()
    }

    /// Makes one forward solve of each curve.
    pub fn at(&mut self, values: &[f64]) -> Result<Point, Failure> {
        let p = self.constants();
        let mut answers = vec![];
        for (of, curve) in self.curves.iter().enumerate() {
            let slack = self.offset(of, OffsetAxis::Slack).map_or(0.0, |k| values[p + k]);
            self.solves += 1;
            let watch = &mut *self.watch;
            match curve.model.answer(&values[..p], &curve.measured.x, slack, &mut |now| watch.progress(now)) {
                Ok(answer) => answers.push(answer),
                Err(failure) => {
                    self.failed += 1;
                    return Err(failure);
                }
            }
        }
        if self.size.is_none() {
            self.weigh(values, &answers);
        }
        Ok(self.point(values.to_vec(), answers))
    }

    /// Sets the weights by the measured values, before there is an answer that is close to them.
    pub fn weigh(&mut self, values: &[f64], answers: &[ModelAnswer]) {
        let changes = weights::measured(self.curves, answers, &self.zeros(values));
        self.weights = self.rule.weights(&changes, &changes, &self.origin);
        self.size = Some(weights::norm(&self.weights, &changes));
    }

    /// The zero of y of each curve.
    fn zeros(&self, values: &[f64]) -> Vec<f64> {
        let zero = |of| self.offset(of, OffsetAxis::Zero).map_or(0.0, |k| values[self.constants() + k]);
        (0..self.curves.len()).map(zero).collect()
    }

    /// The residuals of these answers with the current weights.
    pub fn point(&self, values: Vec<f64>, answers: Vec<ModelAnswer>) -> Point {
        let (p, n) = (self.constants(), self.weights.iter().map(Vec::len).sum());
        let mut residual = DVector::zeros(n);
        let mut jacobian = DMatrix::zeros(n, values.len());
        let mut row = 0;
        for (of, (curve, answer)) in self.curves.iter().zip(&answers).enumerate() {
            let [slack, zero] = [OffsetAxis::Slack, OffsetAxis::Zero].map(|axis| self.offset(of, axis));
            let b = zero.map_or(0.0, |k| values[p + k]);
            for (i, w) in self.weights[of].iter().enumerate() {
                residual[row] = w * (curve.measured.y[i] - answer.y[i] - b);
                (0..p).for_each(|k| jacobian[(row, k)] = w * answer.sensitivities[(i, k)]);
                if let Some(k) = slack {
                    jacobian[(row, p + k)] = -w * answer.slope[i];
                }
                if let Some(k) = zero {
                    jacobian[(row, p + k)] = *w;
                }
                row += 1;
            }
        }
        Point { values, answers, residual, jacobian }
    }

    /// Whether the beginning of a curve, which its slack shifts, coincides with a data point up to rounding.
    pub fn is_at_kink(&self, point: &Point) -> bool {
        let begins = |(offset, slack): (&Offset, &f64)| {
            let x = &self.curves[offset.of].measured.x;
            let begin = point.answers[offset.of].curve.first().map_or(0.0, |first| first[0] + slack);
            offset.axis == OffsetAxis::Slack
                && x.iter().any(|x_i| (x_i - begin).abs() <= KINK * range(x.iter().copied()))
        };
        self.offsets.iter().zip(&point.values[self.constants()..]).any(begins)
    }

    /// Sets the slack (on a grid up to half of the range of x) and the zero of a curve that fit the answer best, up to a factor of y, which is
    /// discarded.
    pub fn guess_offsets(&self, of: usize, answer: &ModelAnswer, values: &mut [f64]) {
        let p = self.constants();
        let [slack, zero] = [OffsetAxis::Slack, OffsetAxis::Zero].map(|axis| self.offset(of, axis));
        // Offsets of an earlier search are kept
        if slack.or(zero).is_none_or(|k| values[p + k] != 0.0) {
            return;
        }
        let (curve, w) = (&self.curves[of], &self.weights[of]);
        let Measured { x, y, .. } = &curve.measured;
        let reach = x.iter().fold(0.0_f64, |m, x| if x.abs() > m.abs() { *x } else { m });
        let wanted = DVector::from_fn(y.len(), |i, _| w[i] * y[i]);
        let one = |k: u32| {
            let e = 0.5 * reach * f64::from(k) / f64::from(GRID);
            let shifted: Vec<f64> = x.iter().map(|x| x - e).collect();
            let predicted = curve.model.interpolated(&answer.curve, &shifted)?;
            let columns =
                DMatrix::from_fn(y.len(), 1 + zero.iter().len(), |i, c| w[i] * if c == 0 { predicted[i] } else { 1.0 });
            let svd = svd(padded(&columns, columns.ncols()), true, true);
            let long = wanted.clone().resize_vertically(y.len().max(columns.ncols()), 0.0);
            let found = svd.solve(&long, 1e-10 * svd.singular_values.max()).ok()?;
            let rest = (&wanted - &columns * found.rows(0, columns.ncols())).norm();
            Some((rest, e, if columns.ncols() > 1 { found[1] } else { 0.0 }))
        };
        let tried = if slack.is_some() { GRID } else { 0 };
        let best = (0..=tried).filter_map(one).min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, e, b)) = best else { return };
        for (k, found) in [(slack, e), (zero, b)] {
            if let Some(k) = k {
                values[p + k] = found;
            }
        }
    }

    /// Refuses a curve that changes in the opposite direction to its scene if all unknowns are constants of laws, which cannot reverse a response.
    pub fn check_signs(&self, point: &Point) -> Result<(), InverseError> {
        for (of, (c, answer)) in self.curves.iter().zip(&point.answers).enumerate() {
            let of_laws = c.model.unknown.iter().all(|u| u.key.law_constant().is_some());
            if !of_laws || self.offset(of, OffsetAxis::Zero).is_some() {
                continue;
            }
            let weighted = |y: &[f64]| {
                let changes = y.iter().zip(&self.weights[of]).map(|(y, w)| w * (y - answer.at_rest()));
                DVector::from_iterator(y.len(), changes)
            };
            let [measured, found] = [&c.measured.y, &answer.y].map(|y| weighted(y));
            let cosine = measured.dot(&found) / (measured.norm() * found.norm());
            if cosine < OPPOSITE {
                return Err(InverseError::Sign { curve: c.name.clone(), column: c.model.y.clone(), cosine });
            }
        }
        Ok(())
    }

    fn offset(&self, of: usize, axis: OffsetAxis) -> Option<usize> {
        self.offsets.iter().position(|o| *o == Offset { of, axis })
    }

    /// Sets the point at which a search begins: only better points are reported.
    pub fn begin_at(&mut self, point: &Point) {
        self.least = self.least.min(point.residual.norm());
    }

    /// Reports a step of a search to the watch if it is better than all earlier ones.
    pub fn tell(&mut self, point: &Point) {
        let misfit = point.residual.norm();
        if misfit < self.least {
            self.least = misfit;
            self.watch.better(&point.values);
        }
    }

    /// Ends the reports: the answer is found, and searches around it are not reported.
    pub fn end_telling(&mut self) {
        self.least = 0.0;
    }

    /// Sets the weights by this answer, with those of a robust loss at its residuals; returns the largest relative change of a weight.
    pub fn reweigh(&mut self, loss: Loss, point: &Point) -> f64 {
        self.least = f64::INFINITY;
        let zeros = self.zeros(&point.values);
        let measured = weights::measured(self.curves, &point.answers, &zeros);
        let base = self.rule.weights(&weights::simulated(&point.answers), &measured, &self.origin);
        let size = weights::norm(&base, &measured);
        self.size = Some(size);
        let mut change = 0.0_f64;
        for (of, (curve, b)) in self.curves.iter().zip(&zeros).enumerate() {
            let rows = curve.measured.y.iter().zip(&point.answers[of].y).zip(&base[of]);
            let r: Vec<f64> = rows.map(|((y, f), w)| (w * (y - f - b)).abs()).collect();
            self.shares[of] = match loss {
                Loss::Squares => vec![1.0; r.len()],
                Loss::Huber => huber_share(&r, size),
            };
            for ((w, share), base) in self.weights[of].iter_mut().zip(&self.shares[of]).zip(&base[of]) {
                change = change.max((base * share - *w).abs() / base);
                *w = base * share;
            }
        }
        change
    }
}
