//! Intervals by profile likelihood: how far one constant can go while a search finds all others anew.
//!
//! S(θⱼ) ≤ Ŝ(1 + t²/(n − p)), t = t₀.₉₇₅(n − p), as for direct fits ([`crate::calibrate`]'s profile). √(S − Ŝ) is almost straight in θⱼ: from the
//! end of the covariance interval, with the others where the linearised problem has them, a secant needs one or two
//! points. Each costs a forward solve or two. Assumes independent errors, as the covariance does.

use super::search::{Weights, search};
use super::{Failure, Measured, SceneModel, written};
use crate::calibrate::judgement::statistics;
use crate::math::svd::svd;
use crate::scene::Progress;
use nalgebra::{DMatrix, DVector};

/// Part of the limit at which an end is found \[–\]
const CLOSE: f64 = 0.02;
const POINTS: usize = 5;

/// The answer from which ends are looked for.
pub struct Best<'a> {
    pub values: &'a [f64],
    pub std_errors: Vec<f64>,
    /// w∂ŷ/∂θ and w(y − ŷ)
    pub jacobian: &'a DMatrix<f64>,
    pub residual: &'a DVector<f64>,
}

/// Lower and upper end \[SI\]; `None` where a forward solve fails or none is found.
type Ends = [Option<f64>; 2];

/// Both ends per constant and the forward solves they took.
pub fn ends(
    model: &SceneModel,
    measured: &Measured,
    weights: &Weights,
    best: &Best,
    watch: &mut dyn FnMut(Progress) -> bool,
) -> Result<(Vec<Ends>, usize), Failure> {
    let (n, p) = best.jacobian.shape();
    let (mut all, mut solves) = (vec![[None; 2]; p], 0);
    let Some(free) = n.checked_sub(p).filter(|f| *f > 0) else { return Ok((all, solves)) };
    let t = statistics::t_quantile(0.95, free);
    let least = best.residual.norm_squared();
    let limit = t * (least / free as f64).sqrt();
    for (j, ends) in all.iter_mut().enumerate().filter(|(j, _)| best.std_errors[*j].is_finite()) {
        for (end, side) in ends.iter_mut().zip([-1.0, 1.0]) {
            let mut offset = side * t * best.std_errors[j];
            for _ in 0..POINTS {
                let found = match squares(model, measured, weights, best, (j, offset), watch) {
                    Ok((square, n)) => {
                        solves += n;
                        (square - least).max(0.0).sqrt() / limit
                    }
                    Err(failure @ (Failure::Input(_) | Failure::Interrupted)) => return Err(failure),
                    Err(_) => break,
                };
                if (found - 1.0).abs() <= CLOSE {
                    *end = Some(best.values[j] + offset);
                    break;
                }
                offset *= (1.0 / found).clamp(0.2, 3.0);
            }
        }
    }
    Ok((all, solves))
}

/// S with constant j off the answer by this much and the others found anew, and the forward solves it took.
fn squares(
    model: &SceneModel,
    measured: &Measured,
    weights: &Weights,
    best: &Best,
    (j, offset): (usize, f64),
    watch: &mut dyn FnMut(Progress) -> bool,
) -> Result<(f64, usize), Failure> {
    let others: Vec<usize> = (0..best.values.len()).filter(|k| *k != j).collect();
    let of = |y: &[f64]| (0..y.len()).map(|i| (weights.w[i] * (measured.y[i] - y[i])).powi(2)).sum::<f64>();
    if others.is_empty() {
        let answer = model.answer(&[best.values[j] + offset], measured, watch)?;
        return Ok((of(&answer.y), 1));
    }
    let mut spec = model.spec.clone();
    let fixed = &model.unknown[j];
    let table = spec.laws.get_mut(&fixed.constant.law).expect("the unknowns were looked up in these laws");
    table.insert(fixed.constant.key.clone(), written(&fixed.parameter, best.values[j] + offset));
    // Where the linearised problem has the others: min ‖J_o δ + J_j offset‖
    let own = DMatrix::from_fn(best.jacobian.nrows(), others.len(), |i, k| {
        best.jacobian[(i, others[k])] * best.values[others[k]].abs().max(f64::MIN_POSITIVE)
    });
    let pull = best.jacobian.column(j) * -offset;
    let svd = svd(own, true, true);
    let step = svd.solve(&pull, 1e-12 * svd.singular_values.max()).unwrap_or_else(|_| DVector::zeros(others.len()));
    let start: Vec<f64> =
        others.iter().enumerate().map(|(k, o)| best.values[*o] + step[k] * best.values[*o].abs()).collect();
    let unknown = others.iter().map(|k| model.unknown[*k].clone()).collect();
    let rest = SceneModel {
        file: model.file.clone(),
        spec,
        text: model.text.clone(),
        body: model.body.clone(),
        unknown,
        x: model.x.clone(),
        y: model.y.clone(),
    };
    let found = search(&rest, measured, weights, &start, watch)?;
    Ok((of(&found.answer.y), found.solves))
}
