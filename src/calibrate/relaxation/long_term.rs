//! Evidence of the data on the long-term modulus: how far a term slower than the data would lower it, and whether it is determined.
//!
//! A sum of exponentials is flat after its last time, whatever the material does later. The interval of G∞ therefore extends down to the value that
//! one further term leaves, with a time from that of the last data point to three times as long, which is the limit for the times of a series. With
//! the column φ(τ) of that term added to those of the series, one Gauss–Newton step gives all factors, and the error model of the fit their
//! covariance. The term can only lower G∞: if its factor would be negative, the interval is that of the series alone.
//!
//! Limits: the step is linear; a relaxation that begins later than three times the last data point leaves no trace in the data.

use super::response::{Record, TestKind};
use super::result::{RelaxationFit, RelaxationWarning};
use super::search::{self, Series, Weighted};
use crate::calibrate::Bounded;
use crate::calibrate::judgement::errors;
use crate::math::statistics::{root, t_quantile};
use nalgebra::{DMatrix, DVector};

/// Length of the last part of the data over which the modulus is examined, as a factor of time
const PART: f64 = 3.162_277_660_168_379_5;
/// Fall of the modulus per decade up to which it counts as a plateau \[–\]
const FLAT: f64 = 0.02;
/// Share that one further term may take from a long-term modulus that still counts as determined: for a curve that falls, and for one that is flat
/// \[–\]
const OPEN: [f64; 2] = [0.05, 0.1];
/// Half-width of the interval, relative to the long-term modulus, above which the modulus is not determined \[–\]
const WIDE: f64 = 0.5;

/// A series to which one more term may be added.
pub struct Beyond<'a> {
    pub record: &'a Record,
    pub series: &'a Series,
    pub weighted: &'a Weighted<'a>,
}

impl Beyond<'_> {
    /// The lowest long-term modulus that one more term leaves, over all its times; `jacobian` is that of the series.
    pub fn lowest(&self, jacobian: &DMatrix<f64>) -> f64 {
        let last = self.record.span()[1];
        let slowest = search::bounds(self.record)[1];
        let with = |tau: f64| self.lowest_with(jacobian, tau);
        [last, (last * slowest).sqrt(), slowest].into_iter().map(with).fold(f64::INFINITY, f64::min)
    }

    fn lowest_with(&self, jacobian: &DMatrix<f64>, tau: f64) -> f64 {
        let record = self.record;
        let further = record.column(Some(tau)).component_mul(&self.weighted.weight);
        let columns: Vec<DVector<f64>> = jacobian.column_iter().map(|c| c.into_owned()).chain([further]).collect();
        let wide = DMatrix::from_columns(&columns);
        let step = errors::directions(&wide).inverse() * &self.series.residual;
        let residual = &self.series.residual - &wide * &step;
        let fitted = self.weighted.target() - &residual;
        let errors =
            errors::of_specimens(&wide, (&residual, &fitted), &record.specimen_of_rows(), &record.curves(), false);
        if errors.free == 0 {
            return 0.0;
        }
        // In creep the long-term compliance is the sum of all factors, which a further term increases
        let creep = record.kind == TestKind::Creep;
        let factors = 1 + self.series.terms.len();
        let of = |k: usize| f64::from(u8::from(k == 0 || creep && (k < factors || k + 1 == columns.len())));
        let by = DVector::from_fn(columns.len(), |k, _| of(k));
        let half = t_quantile(0.95, errors.free) * root(by.dot(&(&errors.covariance * &by)));
        if !creep {
            return self.series.constant + by.dot(&step) - half;
        }
        let sum: f64 = self.series.constant + self.series.terms.iter().map(|t| t.0).sum::<f64>();
        record.stress.map_or(1.0, f64::abs) / (sum + by.dot(&step) + half)
    }
}

/// Extends the interval down to this value.
pub fn widened(b: Bounded, lowest: f64) -> Bounded {
    Bounded { interval: [b.interval[0].min(lowest), b.interval[1]], ..b }
}

/// The reason why the data do not determine the long-term modulus, if they do not. `longest`: whether a term has the longest time of the search.
pub fn doubt(fit: &RelaxationFit, longest: bool) -> Option<RelaxationWarning> {
    let (slope, value, [low, high]) = (slope(fit), fit.long_term.value, fit.long_term.interval);
    // The upper end is as far from the value as the lower end for the series alone
    let open = (2.0 * value - high - low) / value;
    if longest || (slope > FLAT && open > OPEN[0]) {
        return Some(RelaxationWarning::NoPlateau { end: fit.span[1], slope });
    }
    let wide = open > OPEN[1] || fit.long_term.half_width() > WIDE * value;
    wide.then_some(RelaxationWarning::LongTerm { interval: fit.long_term.interval })
}

/// Fall of the fitted modulus per decade over the last half decade of the data, relative to its last value.
fn slope(fit: &RelaxationFit) -> f64 {
    let [first, end] = fit.span;
    let from = (end / PART).max(first);
    if from >= end {
        return 0.0;
    }
    (fit.share_at(from) / fit.share_at(end) - 1.0) / (end / from).log10()
}
