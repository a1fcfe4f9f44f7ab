//! Stretches of a deformed body.

use crate::effect::CellPoints;
use crate::math::tensor::Mat3;
use std::sync::Arc;

/// Median, 95th percentile and maximum of the largest principal stretch, by volume, and the smallest J.
pub fn stretches(elastic: &[Arc<CellPoints>], x: &[f64]) -> Vec<f64> {
    let mut values: Vec<(f64, f64)> = Vec::new();
    let mut min_j = f64::INFINITY;
    for (_, points) in elastic.iter().flat_map(|e| e.deformation(x)) {
        for (weight, f) in points {
            values.push((largest_stretch(&f), weight));
            min_j = min_j.min(f.determinant());
        }
    }
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = values.iter().map(|v| v.1).sum();
    let quantile = |q: f64| {
        let mut below = 0.0;
        let found = values.iter().find(|v| {
            below += v.1;
            below >= q * total
        });
        found.or(values.last()).map_or(f64::NAN, |v| v.0)
    };
    vec![quantile(0.5), quantile(0.95), quantile(1.0), min_j]
}

/// Largest singular value of F.
pub fn largest_stretch(f: &Mat3) -> f64 {
    f.tr_mul(f).symmetric_eigenvalues().max().max(0.0).sqrt()
}
