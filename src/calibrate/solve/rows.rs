//! The samples of a fit as rows of a weighted least-squares problem without units.
//!
//! Row i is wᵢPᵢ/N with N = ‖wP‖, so that factors of a law come out in units of N \[Pa\] and the sum of squares is the relative
//! misfit squared.

use crate::calibrate::{FitError, Mode, Sample};
use nalgebra::{DMatrix, DVector};

/// Data that are nearly orthogonal to a Neo-Hookean law do not determine the stiffness of a rubber \[–\]
const LEAST_COSINE: f64 = 0.02;

/// Weighted rows.
#[derive(Clone, Debug)]
pub struct WeightedRows {
    /// Mode and loaded, second, free principal stretch of each row
    pub places: Vec<(Mode, [f64; 3])>,
    /// wᵢ/N \[1/Pa\]
    pub weight: Vec<f64>,
    /// wᵢPᵢ/N \[–\], of length 1
    pub target: DVector<f64>,
    /// Factor of the law x \[–\] is c/unit: `unit` \[Pa\]
    pub unit: f64,
}

impl WeightedRows {
    /// Refuses stresses that are zero or point against the stretch. `nu`: the lateral stretches follow it.
    pub fn new(samples: &[Sample], weight: &[f64], nu: f64) -> Result<Self, FitError> {
        let weighted: Vec<f64> = samples.iter().zip(weight).map(|(s, w)| w * s.stress).collect();
        let norm = weighted.iter().map(|x| x * x).sum::<f64>().sqrt();
        // Relative weights of a zero are infinite, and their norm is no number
        if norm == 0.0 || samples.iter().all(|s| s.stress == 0.0) {
            return Err(FitError::ZeroStress);
        }
        let places: Vec<_> = samples.iter().map(|s| (s.mode, s.stretches(nu))).collect();
        // A unit that makes factors of the order 1: the Neo-Hookean μ of the data
        let g: Vec<f64> = places.iter().zip(weight).map(|((m, s), w)| w * m.nominal(s.map(|l| l * l), s[0])).collect();
        let length = g.iter().map(|x| x * x).sum::<f64>().sqrt();
        let cosine = g.iter().zip(&weighted).map(|(g, p)| g * p).sum::<f64>() / (length * norm);
        if cosine < LEAST_COSINE {
            return Err(FitError::NotPositive { cosine });
        }
        let unit = norm / length;
        let weight: Vec<f64> = weight.iter().map(|w| w / norm).collect();
        Ok(Self { places, weight, target: DVector::from_vec(weighted) / norm, unit })
    }

    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// The column of a term with these τ \[–\] for a factor in units of `unit`.
    pub fn column(&self, tau: impl Fn([f64; 3]) -> [f64; 3]) -> DVector<f64> {
        let rows = self.places.iter().zip(&self.weight);
        DVector::from_iterator(self.len(), rows.map(|((m, s), w)| w * self.unit * m.nominal(tau(*s), s[0])))
    }
}

/// Columns side by side.
pub fn side_by_side(columns: &[DVector<f64>]) -> DMatrix<f64> {
    DMatrix::from_columns(columns)
}

/// The matrix with rows of zeros below, so that it has at least as many rows as columns.
pub fn padded(a: &DMatrix<f64>, columns: usize) -> DMatrix<f64> {
    let n = a.nrows().max(columns);
    a.clone().resize_vertically(n, 0.0)
}
