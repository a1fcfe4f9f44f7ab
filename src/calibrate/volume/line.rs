//! A straight line through data, with the errors of direct fits; of several specimens one slope and an offset of each.

use crate::calibrate::Bounded;
use crate::calibrate::judgement::errors;
use crate::math::statistics::t_quantile;
use crate::math::svd::svd;
use nalgebra::{DMatrix, DVector};

/// Points of the tests of one or several specimens.
#[derive(Clone, Debug, Default)]
pub struct Points {
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    /// Specimen of each point, counted from 0
    pub specimen: Vec<usize>,
}

/// A straight line with what is needed to judge it.
pub struct Line {
    pub slope: Bounded,
    /// Of each specimen
    pub offsets: Vec<Bounded>,
    /// Rms of the residual over that of y without the mean of its specimen \[–\]
    pub misfit: f64,
    pub residual: DVector<f64>,
    pub errors: errors::Errors,
    /// Coefficient of (x − x̄)² with its interval
    pub bend: Bounded,
}

/// Part of y below which a residual is rounding \[–\]
const ROUNDING: f64 = 1e-12;

/// y = offset + slope x by least squares, and the second-order term that would be added.
pub fn line(points: &Points) -> Line {
    let Points { x, y, specimen } = points;
    let (n, count) = (x.len(), specimen.iter().max().map_or(1, |k| k + 1));
    let mean = x.iter().sum::<f64>() / n as f64;
    let target = DVector::from_column_slice(y);
    let rows_of = |one: usize| (0..n).filter(|i| specimen[*i] == one).collect::<Vec<_>>();
    let curves: Vec<Vec<usize>> = (0..count).map(rows_of).collect();
    let solve = |columns: usize| {
        let j = DMatrix::from_fn(n, count + columns, |i, k| match k.checked_sub(count) {
            None => f64::from(u8::from(specimen[i] == k)),
            Some(0) => x[i],
            Some(_) => (x[i] - mean).powi(2),
        });
        let found = svd(j.clone(), true, true).solve(&target, 1e-14).expect("both factors were asked for");
        let residual = &target - &j * &found;
        let rounding = residual.norm() <= ROUNDING * target.norm();
        let errors = errors::of_specimens(&j, &residual, specimen, &curves, rounding);
        let t = if errors.free > 0 { t_quantile(0.95, errors.free) } else { f64::INFINITY };
        let bounded = |k: usize| {
            let half = if rounding { 0.0 } else { t * errors.deviations[k] };
            Bounded { value: found[k], interval: [found[k] - half, found[k] + half] }
        };
        ((0..count + columns).map(bounded).collect::<Vec<_>>(), residual, errors.clone())
    };
    let bend = solve(2).0[count + 1];
    let (found, residual, errors) = solve(1);
    let spread = |rows: &Vec<usize>| {
        let centre = rows.iter().map(|i| y[*i]).sum::<f64>() / rows.len().max(1) as f64;
        rows.iter().map(|i| (y[*i] - centre).powi(2)).sum::<f64>()
    };
    let spread = curves.iter().map(spread).sum::<f64>().sqrt();
    let offsets = found[..count].to_vec();
    Line { slope: found[count], offsets, misfit: residual.norm() / spread, residual, errors, bend }
}
