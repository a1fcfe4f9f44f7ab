//! Selection of the points from which forces are summed, with their weights.
//!
//! The forces of the training states along the modes are reproduced by few points with non-negative weights, so that the sum still derives from an
//! energy, and its tangent is symmetric and as stable as that of each point (Farhat et al. 2014, section 4;
//! [`nonnegative`](crate::math::nonnegative)).

use super::basis::Basis;
use super::body_points::{BodyPoints, Place, PointForce};
use super::fields_at_points::FieldsAtPoints;
use super::points_at::PointsAt;
use crate::math::nonnegative::sparse_weights;
use crate::math::vector::norm;
use crate::reduction::error::ReductionError;
use crate::reduction::points::StoredPoints;
use faer::Mat;

/// Points with their weights, and the error of the sums over them.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// (point, factor on its own weight), in ascending order
    pub points: Vec<(usize, f64)>,
    /// Relative error of the forces of the training states \[–\]
    pub error: f64,
}

impl Selection {
    /// Selects every point with its own weight.
    pub fn all(points: usize) -> Self {
        Self { points: (0..points).map(|p| (p, 1.0)).collect(), error: 0.0 }
    }
}

/// Error of the sums above which a selection is unusable \[–\].
pub const WORST: f64 = 0.05;
/// Force, relative to the largest of all states, that is the smallest scale for the errors \[–\].
const SMALL: f64 = 0.05;

/// Selects few points that reproduce the forces along the modes at the states with coordinates `states`, within the relative `tolerance`.
pub fn select(
    (points, at): (&BodyPoints, &PointsAt),
    fields: &FieldsAtPoints,
    basis: &Basis,
    (states, amplitudes): (&[Vec<f64>], [f64; 2]),
    tolerance: f64,
) -> Result<Selection, ReductionError> {
    let forces = states.iter().enumerate().map(|(state, y)| at.forces(state, fields, y));
    select_for(points, fields, basis, (forces, amplitudes), tolerance)
}

/// Selects few points that reproduce the forces along the modes, given the forces at all points.
pub fn select_for(
    points: &BodyPoints,
    fields: &FieldsAtPoints,
    basis: &Basis,
    (states, amplitudes): (impl Iterator<Item = Result<Vec<PointForce>, ReductionError>>, [f64; 2]),
    tolerance: f64,
) -> Result<Selection, ReductionError> {
    let (weights, modes) = (points.weights(), basis.modes.len());
    let scale = |mode: usize| amplitudes[usize::from(mode >= basis.displacements)];
    let mut rows: Vec<Vec<f64>> = vec![];
    let mut sizes = vec![];
    for forces in states {
        let forces = forces?;
        let row = |mode: usize| -> Vec<f64> {
            let work = |p: usize| scale(mode) * fields.work(mode, p, weights[p], &forces[p]);
            (0..weights.len()).map(work).collect()
        };
        let of_state: Vec<Vec<f64>> = (0..modes).map(row).collect();
        let sums: Vec<f64> = of_state.iter().map(|row| row.iter().sum()).collect();
        sizes.push(norm(&sums));
        rows.extend(of_state);
    }
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    for (row, size) in rows.chunks_mut(modes).zip(sizes) {
        let factor = 1.0 / (size + SMALL * largest);
        row.iter_mut().flatten().for_each(|value| *value *= factor);
    }
    // The volume, so that a state at rest also counts
    let volume: f64 = weights.iter().sum();
    rows.push(weights.iter().map(|w| w / volume).collect());
    of_rows(&rows, tolerance)
}

/// Selects few points whose weighted sums reproduce the sums of each row over all points.
pub fn of_rows(rows: &[Vec<f64>], tolerance: f64) -> Result<Selection, ReductionError> {
    let count = rows.first().map_or(0, Vec::len);
    let a = Mat::from_fn(rows.len(), count, |i, p| rows[i][p]);
    let b: Vec<f64> = rows.iter().map(|row| row.iter().sum()).collect();
    let found = sparse_weights(&a, &b, tolerance, count.min(rows.len()));
    if found.residual > WORST {
        return Err(ReductionError::Sampling { reached: found.residual, most: WORST });
    }
    Ok(Selection { points: found.weights, error: found.residual })
}

/// Returns the selected points by law and rate-dependent forces, with the modes and tests there.
pub fn stored(
    points: &BodyPoints,
    selection: &Selection,
    (fields, basis): (&FieldsAtPoints, &Basis),
    tests: Option<&FieldsAtPoints>,
) -> Vec<StoredPoints> {
    let places: Vec<Place> = points.places().collect();
    let weights = points.weights();
    let of_kind = |(k, kind): (usize, usize)| {
        let part = &points.parts[k];
        let has_pressure = part.constitution.pressure.is_some();
        let mut out = StoredPoints {
            law: part.constitution.law.clone(),
            has_pressure,
            rates: part.rates[kind].clone(),
            weights: vec![],
            gradients: vec![],
            pressures: vec![],
            test_gradients: vec![],
            test_pressures: vec![],
        };
        for &(p, factor) in selection.points.iter().filter(|(p, _)| points.kind(&places[*p]) == (k, kind)) {
            out.weights.push(factor * weights[p]);
            let (displacements, pressures) = fields.gradients.split_at(basis.displacements);
            out.gradients.extend(displacements.iter().flat_map(|of| of[p]));
            out.pressures
                .extend((basis.displacements..basis.displacements + pressures.len()).map(|c| fields.pressures[c][p]));
            if let Some(tests) = tests {
                out.test_gradients.extend(tests.gradients.iter().flat_map(|of| of[p]));
                if has_pressure {
                    out.test_pressures.extend(tests.pressures.iter().map(|of| of[p]));
                }
            }
        }
        out
    };
    points.kinds().map(of_kind).collect()
}
