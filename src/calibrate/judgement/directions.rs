//! Directions of the constants that the data determine.

use super::correlation::Correlation;
use super::error_model::{ErrorModel, Errors};
use crate::calibrate::solve::rows::padded;
use crate::math::statistics::root;
use crate::math::svd::svd;
use nalgebra::DMatrix;

/// Relative singular value below which a direction is rounding \[–\]
pub const BLIND: f64 = 1e-10;

/// Orthonormal columns of the directions that the data determine, and the change of θ for each of them.
pub struct Directions {
    /// \[data points × directions\]
    pub u: DMatrix<f64>,
    /// \[constants × directions\]
    pub by: DMatrix<f64>,
}

impl Directions {
    /// (JᵀJ)⁻¹Jᵀ on these directions, (p × n): it maps a change of the weighted data to the change of the constants.
    pub fn inverse(&self) -> DMatrix<f64> {
        &self.by * self.u.transpose()
    }

    /// √((JᵀJ)⁻¹ⱼⱼ) of each constant.
    pub fn plain(&self) -> Vec<f64> {
        self.by.row_iter().map(|row| row.norm()).collect()
    }

    /// The errors of the constants from the covariance of the directions, \[directions × directions\]; `free`, `correlation` and `smooth` are the
    /// fields of [`Errors`].
    pub fn errors(
        &self,
        model: ErrorModel,
        covariance: &DMatrix<f64>,
        free: usize,
        correlation: Correlation,
        smooth: f64,
    ) -> Errors {
        let roots = |c: &DMatrix<f64>| c.diagonal().iter().map(|c| root(*c)).collect::<Vec<f64>>();
        let covariance = &self.by * covariance * self.by.transpose();
        Errors {
            model,
            deviations: roots(&covariance),
            plain: self.plain(),
            free,
            correlation,
            smooth,
            sizes: None,
            covariance,
        }
    }
}

/// The directions of a Jacobian (n × p), whose columns may have any size.
pub fn directions(jacobian: &DMatrix<f64>) -> Directions {
    let p = jacobian.ncols();
    let length: Vec<f64> = (0..p).map(|k| jacobian.column(k).norm()).map(|l| if l > 0.0 { l } else { 1.0 }).collect();
    let scaled = DMatrix::from_fn(jacobian.nrows(), p, |i, k| jacobian[(i, k)] / length[k]);
    let svd = svd(padded(&scaled, p), true, true);
    let (u, vt, sigma) = (svd.u.expect("asked for"), svd.v_t.expect("asked for"), svd.singular_values);
    let seen: Vec<usize> = (0..p).filter(|k| sigma[*k] > BLIND * sigma.max()).collect();
    Directions {
        u: DMatrix::from_fn(jacobian.nrows(), seen.len(), |i, k| u[(i, seen[k])]),
        by: DMatrix::from_fn(p, seen.len(), |j, k| vt[(seen[k], j)] / sigma[seen[k]] / length[j]),
    }
}
