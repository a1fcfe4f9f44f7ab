//! The rows of a fit that determine the errors of its constants.

use crate::calibrate::judgement::errors::{self, Errors};
use crate::calibrate::judgement::identify::across;
use crate::calibrate::judgement::origin::Origin;
use nalgebra::{DMatrix, DVector};

/// Weighted Jacobian, residual and stresses of the law, in the form in which the residual shows the errors of the data points.
pub struct ErrorRows {
    pub jacobian: DMatrix<f64>,
    pub residual: DVector<f64>,
    /// The residual before a robust loss limits it. Limited residuals of correlated errors stay at their limits, which does not reflect the
    /// correlation of neighbours
    pub unlimited: DVector<f64>,
    pub fitted: DVector<f64>,
}

impl ErrorRows {
    /// Builds the rows from the weighted Jacobian and residual of an answer, the stresses of its law, the weights, and the √ of Huber's weights that
    /// they include.
    ///
    /// With Huber's loss the rows have the weights without those of the loss, and the residual is Kψ(r)/ψ̄′, where ψ(r) is the residual limited to
    /// its bound, ψ̄′ the share m of the data points within it, and K = 1 + (p/n)(1 − m)/m: its covariance (JᵀJ)⁻¹Σ(Kψ)²/((n − p)m²) is the
    /// asymptotic one (Huber, *Robust Statistics*, 1981, eq. 7.6.10). Weights of single data points would make the columns as rough as the errors
    /// are.
    pub fn of(jacobian: DMatrix<f64>, residual: &DVector<f64>, law: &[f64], weight: &[f64], share: &[f64]) -> Self {
        let (n, p) = (law.len() as f64, jacobian.ncols());
        let inside = share.iter().filter(|s| **s == 1.0).count() as f64 / n;
        let by = (1.0 + p as f64 / n * (1.0 - inside) / inside) / inside;
        Self {
            // ψ(r) = share² of the residual before the loss
            residual: DVector::from_fn(law.len(), |i, _| by * share[i] * residual[i]),
            unlimited: residual.component_div(&DVector::from_column_slice(share)),
            fitted: DVector::from_fn(law.len(), |i, _| weight[i] / share[i] * law[i]),
            jacobian: unshared(jacobian, share),
        }
    }
}

impl ErrorRows {
    /// The errors of the constants. `weighted`: the Jacobian with the weights of a robust loss, whose sum of squares is the likelihood of a profile;
    /// `rounding`: the residual is only rounding.
    pub fn errors(&self, weighted: &DMatrix<f64>, origin: &Origin, rounding: bool) -> Errors {
        let found = errors::of(&self.jacobian, &self.residual, &self.fitted, origin, rounding);
        if *weighted == self.jacobian {
            return found;
        }
        Errors { plain: errors::directions(weighted).plain(), ..found }
    }

    /// The rows divided by the standard deviations of their errors, with the least-squares residual for these weights: with equal weights, the
    /// residual of a quiet curve is dominated by the error of the constants due to a noisy one, which is smooth.
    pub fn over(self, sizes: Option<&DVector<f64>>) -> Self {
        let Some(sizes) = sizes else { return self };
        let mut jacobian = self.jacobian;
        jacobian.row_iter_mut().zip(sizes).for_each(|(mut row, size)| row /= *size);
        let [residual, unlimited] =
            [&self.residual, &self.unlimited].map(|r| across(&jacobian, &r.component_div(sizes)));
        Self { jacobian, residual, unlimited, fitted: self.fitted.component_div(sizes) }
    }
}

/// Weighted rows without Huber's weights.
pub fn unshared(mut rows: DMatrix<f64>, share: &[f64]) -> DMatrix<f64> {
    rows.row_iter_mut().zip(share).for_each(|(mut row, share)| row /= *share);
    rows
}
