//! The samples of a fit as rows of a dimensionless weighted least-squares problem.
//!
//! Row i is wᵢPᵢ/N with N = ‖wP‖, so that factors of a law are in units of N \[Pa\] and the sum of squares is the squared relative misfit.

use crate::calibrate::{FitError, Mode, Sample};
use nalgebra::{DMatrix, DVector};

/// Cosine between the data and a neo-Hookean law below which the data do not determine the stiffness of a rubber \[–\]
const LEAST_COSINE: f64 = 0.02;

/// Weighted rows.
#[derive(Clone, Debug)]
pub struct WeightedRows {
    /// Mode and principal stretches (loaded, second, free) of each row
    pub places: Vec<(Mode, [f64; 3])>,
    /// wᵢ/N \[1/Pa\]
    pub weight: Vec<f64>,
    /// wᵢPᵢ/N \[–\], of length 1
    pub target: DVector<f64>,
    /// Scale of the factors \[Pa\]: x \[–\] is c/`unit`
    pub unit: f64,
}

impl WeightedRows {
    /// Builds the rows; refuses stresses that are zero or opposite to the stretch. `nu`: Poisson's ratio of the lateral stretches.
    pub fn new(samples: &[Sample], weight: &[f64], nu: f64) -> Result<Self, FitError> {
        let weighted: Vec<f64> = samples.iter().zip(weight).map(|(s, w)| w * s.stress).collect();
        let norm = weighted.iter().map(|x| x * x).sum::<f64>().sqrt();
        // Relative weights of a zero stress are infinite, and their norm is NaN
        if norm == 0.0 || samples.iter().all(|s| s.stress == 0.0) {
            return Err(FitError::ZeroStress);
        }
        let places: Vec<_> = samples.iter().map(|s| (s.mode, s.stretches(nu))).collect();
        // A unit that makes factors of order 1: the neo-Hookean μ of the data
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

/// The matrix padded with rows of zeros, so that it has at least as many rows as columns.
pub fn padded(a: &DMatrix<f64>, columns: usize) -> DMatrix<f64> {
    let n = a.nrows().max(columns);
    a.clone().resize_vertically(n, 0.0)
}
