//! Stretches of a deformed body.

use crate::effect::CellPoints;
use crate::math::statistics::smaller;
use crate::math::tensor::Mat3;
use crate::math::threads;
use rustc_hash::FxHashSet;
use std::ops::Range;
use std::sync::Arc;

/// Number of cells whose stretches one thread computes at a time, and number of points that it sorts.
const CELLS: usize = 1024;
const POINTS: usize = 4096;

/// A point of a cell in the deformed body.
pub struct PointStretch {
    pub cell: u32,
    /// Share of the volume at rest \[m³\]
    pub weight: f64,
    /// Largest principal stretch \[–\]
    pub largest: f64,
    /// Ratio of the deformed volume to the volume at rest \[–\]
    pub j: f64,
}

/// All points of several effects, cell by cell, for displacements `x` \[unknowns\]; each cell is taken from the first effect that contains it.
pub fn points(elastic: &[Arc<CellPoints>], x: &[f64]) -> Vec<PointStretch> {
    let (mut all, mut seen) = (vec![], FxHashSet::<u32>::default());
    for effect in elastic {
        all.extend(points_of(effect, x).into_iter().filter(|point| !seen.contains(&point.cell)));
        seen.extend(&effect.cells);
    }
    all
}

fn points_of(elastic: &CellPoints, x: &[f64]) -> Vec<PointStretch> {
    let cells = elastic.cells.len();
    let ranges = (0..cells).step_by(CELLS).map(|first| first..cells.min(first + CELLS)).collect();
    let of = |range: Range<usize>| {
        let of_cell = |(cell, points): (u32, Vec<(f64, Mat3)>)| {
            points.into_iter().map(move |(weight, f)| {
                let (largest, j) = (largest_stretch(&f), f.determinant());
                PointStretch { cell, weight, largest, j }
            })
        };
        elastic.deformation(x, range).flat_map(of_cell).collect::<Vec<_>>()
    };
    threads::map(ranges, of).into_iter().flatten().collect()
}

/// Median, 95th percentile and maximum of the largest principal stretch, weighted by volume, and the smallest J.
pub fn stretches(elastic: &[Arc<CellPoints>], x: &[f64]) -> Vec<f64> {
    let points = points(elastic, x);
    let min_j = points.iter().map(|point| point.j).fold(f64::INFINITY, smaller);
    let mut all: Vec<(f64, f64)> = points.iter().map(|point| (point.largest, point.weight)).collect();
    // Completed by a sort that merges the sorted parts
    let order = |a: &(f64, f64), b: &(f64, f64)| a.0.total_cmp(&b.0);
    threads::map(all.chunks_mut(POINTS).collect(), |points| points.sort_by(order));
    all.sort_by(order);
    let largest = all.last().map_or(f64::NAN, |(value, _)| *value);
    vec![quantile(&all, 0.5), quantile(&all, 0.95), largest, min_j]
}

/// Relative rounding of a sum of weights.
const TIE: f64 = 1e-9;

/// Value below which the share `q` of the weights lies, from (value, weight) in the order of the values. If the share ends between two values it is their
/// mean, so that it does not depend on rounding.
fn quantile(sorted: &[(f64, f64)], q: f64) -> f64 {
    let total: f64 = sorted.iter().map(|(_, weight)| weight).sum();
    let reaches = |share: f64| {
        let mut below = 0.0;
        let found = sorted.iter().find(|(_, weight)| {
            below += weight;
            below >= share * total
        });
        found.or(sorted.last()).map_or(f64::NAN, |(value, _)| *value)
    };
    0.5 * (reaches(q - TIE) + reaches(q + TIE))
}

/// Largest singular value of F: the square root of the largest eigenvalue of FᵀF in closed form (Smith, Commun. ACM 4, 1961).
pub fn largest_stretch(f: &Mat3) -> f64 {
    let c = f.tr_mul(f);
    let mean = c.trace() / 3.0;
    let deviator = c - Mat3::identity() * mean;
    let size = (deviator.norm_squared() / 6.0).sqrt();
    // Cosine of three times the angle; NaN if all eigenvalues are equal
    let cosine = (deviator.determinant() / (2.0 * size.powi(3))).clamp(-1.0, 1.0);
    let above = if size > 0.0 && cosine.is_finite() { 2.0 * size * (cosine.acos() / 3.0).cos() } else { 0.0 };
    (mean + above).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix;

    /// With half of the volume at either value the result is their mean, whatever the rounding of the sum; elsewhere it is the value itself.
    #[test]
    fn a_share_that_ends_between_two_values_gives_their_mean() {
        for off in [0.0, 1e-13, -1e-13] {
            assert!((quantile(&[(1.0, 0.1), (1.2, 0.2 + off), (1.4, 0.3)], 0.5) - 1.3).abs() < 1e-15);
        }
        assert_eq!(quantile(&[(1.0, 1.0), (1.2, 1.0), (1.4, 1.0)], 0.5), 1.2);
        assert_eq!(quantile(&[(1.5, 1.0)], 0.95), 1.5);
        assert!(quantile(&[], 0.5).is_nan());
    }

    /// Compared with the iteration of nalgebra, for states from nearly undeformed to large stretches: they differ by rounding of a few units.
    #[test]
    fn largest_stretch_is_the_largest_singular_value() {
        let mut random = SplitMix(9);
        for k in 0..1000 {
            let size = 10f64.powi(k % 14 - 13);
            let f = Mat3::identity() + Mat3::from_fn(|_, _| 3.0 * size * (2.0 * random.unit() - 1.0));
            let exact = f.singular_values().max();
            assert!((largest_stretch(&f) - exact).abs() < 1e-14 * exact, "{f}: {exact}");
        }
        assert_eq!(largest_stretch(&(Mat3::identity() * 2.0)), 2.0);
        let axial = Mat3::from_diagonal(&[1.5, 0.8, 0.8].into());
        assert!((largest_stretch(&axial) - 1.5).abs() < 1e-15 && largest_stretch(&-axial) > 1.49);
    }
}
