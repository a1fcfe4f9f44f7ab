//! Errors of the measurement that all data points share, in the intervals of the constants.
//!
//! The fitted law absorbs such an error, so that no residual shows it. To first order a change δrᵢ of the residuals moves the constants (and a fitted
//! slack) by δθ = (JᵀJ)⁻¹Jᵀ δr, with
//!
//! - δr = wᵢ δP for an error of the stress,
//! - δr = −wᵢ (∂P/∂e) δe for an error of the strain.
//!
//! The half-widths of independent errors are added in quadrature to that of the scatter (JCGM 100:2008, *Guide to the expression of uncertainty in
//! measurement*, 5.1.2, type B).
//!
//! Errors of zeros and of the cross-section differ between curves (a specimen in one test). Between several specimens of a test they are part of the
//! measured scatter and are not added a second time; for a test with one specimen they are added. Other scales and the compliance are common to all
//! curves.
//!
//! Limits: first order; the errors are those of one machine; an active stability constraint is ignored.

use crate::calibrate::intake::accuracy::{Accuracy, SharedError};
use crate::calibrate::intake::piece::Piece;
use crate::calibrate::judgement::errors::{curves, directions};
use crate::calibrate::sample::{Test, tests};
use crate::calibrate::solve::{LawFit, LawSetting, jacobian, offset};
use crate::calibrate::treatment::toe_line::ToeLine;
use crate::calibrate::{ErrorModel, Estimate, Experiment, FitError, FittableLaw, Sample};
use crate::math::statistics::t_quantile;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Contribution of a shared error to the intervals of the constants.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Contribution {
    pub error: SharedError,
    /// Half-width of its 95 % interval, as stated \[SI\]
    pub half_width: f64,
    /// Resulting half-width of each constant \[SI\]
    pub moves: Vec<f64>,
}

/// Ratio of a 95 % half-width of a normal error to its standard deviation
pub const NORMAL: f64 = 1.959_963_984_540_054;

/// Stated errors with their contributions, and the changes of the weighted residuals that they cause (n × errors): one column for each curve if an
/// error differs between curves.
pub struct Stated {
    pub contributions: Vec<Contribution>,
    pub columns: DMatrix<f64>,
    /// Covariance of the constants due to these errors \[SI²\]
    pub covariance: DMatrix<f64>,
}

/// Contributions of the errors that data points share: those of their test pieces, and those `asked` for all.
pub fn contributions(
    setting: &LawSetting,
    fitted: &[Sample],
    answer: &LawFit,
    experiment: &Experiment,
    asked: &Accuracy,
) -> Result<Stated, FitError> {
    let count = answer.values.len();
    let columns = DMatrix::zeros(fitted.len(), 0);
    let mut stated = Stated { contributions: vec![], columns, covariance: DMatrix::zeros(count, count) };
    let errors = errors_of_rows(setting, fitted, answer, experiment, asked);
    let present =
        |of_row: &Accuracy| of_row.0.iter().filter(|(_, half)| **half > 0.0).map(|(kind, _)| *kind).collect::<Vec<_>>();
    let kinds: BTreeSet<SharedError> = errors.iter().flat_map(present).collect();
    if kinds.is_empty() {
        return Ok(stated);
    }
    let every: Vec<usize> = (0..fitted.len()).collect();
    let tests = tests(fitted);
    let alone = alone(fitted, &tests, answer);
    let step = directions(&jacobian(setting, fitted, answer)).inverse();
    for kind in kinds {
        let width = |k: usize| errors[k].0.get(&kind).copied().unwrap_or(0.0);
        let moved = |rows: &Vec<usize>| -> Result<DVector<f64>, FitError> {
            let mut residuals = DVector::zeros(fitted.len());
            for &k in rows.iter().filter(|k| width(**k) > 0.0) {
                let change = change(kind, setting, answer, (&fitted[k], tests[k]), experiment.piece(&fitted[k]))?;
                residuals[k] = answer.weight[k] * width(k) * change;
            }
            Ok(residuals)
        };
        let together = if kind.is_of_a_curve() { &alone[..] } else { std::slice::from_ref(&every) };
        let has_error = |rows: &&Vec<usize>| rows.iter().any(|k| width(*k) > 0.0);
        let columns = together.iter().filter(has_error).map(moved).collect::<Result<Vec<_>, _>>()?;
        if columns.is_empty() {
            continue;
        }
        let shifts: Vec<DVector<f64>> = columns.iter().map(|c| &step * c).collect();
        for shift in &shifts {
            let own = shift.rows(0, count) / NORMAL;
            stated.covariance += &own * own.transpose();
        }
        let moves = (0..count).map(|j| shifts.iter().map(|d| d[j] * d[j]).sum::<f64>().sqrt()).collect();
        let half_width = every.iter().map(|k| width(*k)).fold(0.0, f64::max);
        stated.contributions.push(Contribution { error: kind, half_width, moves });
        for column in columns {
            let at = stated.columns.ncols();
            stated.columns = stated.columns.insert_column(at, 0.0);
            stated.columns.set_column(at, &column);
        }
    }
    Ok(stated)
}

/// The errors of the curve of each data point: for a toe including the effect of the curvature of the law, and for a zero from a single data point
/// limited to the scatter about the law.
fn errors_of_rows(
    setting: &LawSetting,
    fitted: &[Sample],
    answer: &LawFit,
    experiment: &Experiment,
    asked: &Accuracy,
) -> Vec<Accuracy> {
    let mut all = vec![Accuracy::default(); fitted.len()];
    let tests = tests(fitted);
    for rows in curves(fitted) {
        let (first, test) = (&fitted[rows[0]], tests[rows[0]]);
        let piece = experiment.piece(first);
        let mut own = piece.errors(test, asked);
        if let Some(toe) = own.0.get_mut(&SharedError::Toe) {
            *toe += curvature(setting, answer, piece, (first, test));
        }
        let bounded = piece.correction(SharedError::Zeroing, test).is_some_and(|c| c.bounded);
        if let Some(zero) = own.0.get_mut(&SharedError::Zeroing).filter(|_| bounded) {
            *zero = zero.min(scatter(setting, fitted, answer, &rows));
        }
        rows.iter().for_each(|k| all[*k].clone_from(&own));
    }
    all
}

/// 95 % half-width of the unweighted scatter of the data points of a curve about the law \[Pa\].
fn scatter(setting: &LawSetting, fitted: &[Sample], answer: &LawFit, rows: &[usize]) -> f64 {
    let free = rows.len().saturating_sub(answer.values.len()).max(1);
    let own = |k: &usize| fitted[*k].stress - setting.model.at(&answer.values, &fitted[*k]);
    t_quantile(0.95, free) * (rows.iter().map(|k| own(k).powi(2)).sum::<f64>() / free as f64).sqrt()
}

/// Rows of the curves whose errors of the zero are not part of a measured scatter.
fn alone(fitted: &[Sample], tests: &[Test], answer: &LawFit) -> Vec<Vec<usize>> {
    let groups = curves(fitted);
    let of_test = |row: usize| groups.iter().filter(|rows| tests[rows[0]] == tests[row]).count();
    match answer.errors.model {
        ErrorModel::Specimens { .. } => vec![],
        ErrorModel::Levels { .. } => groups.iter().filter(|rows| of_test(rows[0]) == 1).cloned().collect(),
        _ => groups,
    }
}

/// Change of the residual of a data point per unit of an error \[Pa per SI unit of the error\].
fn change(
    kind: SharedError,
    setting: &LawSetting,
    answer: &LawFit,
    (s, test): (&Sample, Test),
    piece: &Piece,
) -> Result<f64, FitError> {
    // The stress of the law, without the scatter, which would absorb the residuals
    let law = || setting.model.at(&answer.values, s);
    let slope = || match s.stretch == 1.0 && !setting.slack.is_empty() {
        true => 0.0,
        false => offset::slope(setting.model, &answer.values, s),
    };
    let area = || piece.dimensions.needed_section(kind);
    Ok(match kind {
        SharedError::StressZero => 1.0,
        SharedError::ForceZero => area()?.recip(),
        SharedError::StressScale | SharedError::AreaScale => law(),
        SharedError::StrainZero | SharedError::Toe => slope(),
        SharedError::StrainScale => slope() * s.mode.strain(s.stretch),
        SharedError::Poisson => by_poisson(setting.model, &answer.values, s),
        SharedError::Compliance => slope() * law() * area()? / piece.dimensions.needed_length(kind)?,
        SharedError::Zeroing => {
            let own = piece.correction(SharedError::Toe, test).map_or(0.0, |c| c.strain_per_stress);
            1.0 - if own > 0.0 { slope() * own } else { 0.0 }
        }
    })
}

/// Shift of the line of a toe due to the curvature of the law \[–\].
fn curvature(setting: &LawSetting, answer: &LawFit, piece: &Piece, (s, test): (&Sample, Test)) -> f64 {
    let Some(toe) = piece.correction(SharedError::Toe, test) else { return 0.0 };
    let law = |strain: f64| setting.model.at(&answer.values, &Sample { stretch: s.mode.stretch(strain), ..*s });
    let points: Vec<(f64, f64)> = toe.line.iter().map(|e| (*e, law(*e))).collect();
    ToeLine::through(&points).map_or(0.0, |line| line.origin.abs())
}

/// −∂P/∂ν \[Pa\], the change of the residuals per error of ν, by central differences, to 1e-8.
fn by_poisson(model: FittableLaw, values: &[f64], s: &Sample) -> f64 {
    const H: f64 = 1e-5;
    let at = |nu: f64| model.with_poisson(nu).at(values, s);
    (at(model.nu - H) - at(model.nu + H)) / (2.0 * H)
}

/// Widens the intervals and standard errors of the constants by the contributions.
pub fn widen(parameters: &mut [Estimate], contributions: &[Contribution]) {
    for (k, e) in parameters.iter_mut().enumerate() {
        let more = contributions.iter().map(|c| c.moves[k] * c.moves[k]).sum::<f64>();
        if more > 0.0 {
            let [low, high] = e.interval.map(|end| ((end - e.value).powi(2) + more).sqrt());
            e.interval = [e.value - low, e.value + high];
            e.std_error = e.std_error.hypot(more.sqrt() / NORMAL);
        }
    }
}
