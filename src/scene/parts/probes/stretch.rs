//! Probe `stretch`: `stretch_median`, `stretch_p95`, `stretch_max` of the largest principal stretch by volume, `min_j`.

use super::Probe;
use crate::effect::CellPoints;
use crate::math::tensor::Mat3;
use crate::scene::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::recorder::{Moment, Recorder};
use serde::Deserialize;
use std::sync::Arc;

/// Distribution of the largest principal stretch over the volume.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stretch {}

impl Probe for Stretch {
    fn build(&self, _: &str, _: &Builder) -> Result<Box<dyn Recorder>, SceneError> {
        Ok(Box::new(*self))
    }
}

impl Recorder for Stretch {
    fn columns(&self) -> Vec<String> {
        ["stretch_median", "stretch_p95", "stretch_max", "min_j"].map(String::from).into()
    }

    fn record(&self, now: &Moment) -> Vec<f64> {
        stretches(&now.scene.elastic, &now.state.x)
    }
}

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
