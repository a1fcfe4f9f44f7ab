//! Errors of the measurement that all data points share, in the intervals of the constants.
//!
//! A law that is fitted takes up such an error: no residual shows it. To first order a change δrᵢ of the residuals moves the constants by
//! δθ = (JᵀJ)⁻¹Jᵀ δr, with a fitted slack among them where there is one; δr = wᵢ δP of an error of the stress, −wᵢ (∂P/∂e) δe of one of
//! the strain. The half-widths of independent errors are added in quadrature to the one of the scatter (JCGM 100:2008, *Guide to the
//! expression of uncertainty in measurement*, 5.1.2, type B).
//!
//! Zeros are those of each curve, a specimen in one mode. Between several specimens of a mode they are a part of the scatter, which is measured, and are not
//! added a second time; those of the one specimen of another mode are. Scales and the compliance are common to all.
//!
//! Limits: first order; the errors are those of one machine; a constraint of stability that is active is not followed.

use crate::calibrate::intake::accuracy::{Accuracy, SharedError};
use crate::calibrate::intake::dimensions::Dimensions;
use crate::calibrate::judgement::errors::{curves, directions};
use crate::calibrate::solve::{LawFit, LawSetting, jacobian, offset};
use crate::calibrate::{ErrorModel, Estimate, FitError, Model, Sample};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// Part of a shared error in the intervals of the constants.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Contribution {
    pub error: SharedError,
    /// Half-width of its 95 % interval, as given \[SI\]
    pub half_width: f64,
    /// Half-widths that follow, of each constant \[SI\]
    pub moves: Vec<f64>,
}

/// Ratio of a 95 % half-width of a normal error to its standard deviation
const NORMAL: f64 = 1.959_963_984_540_054;

/// Stated errors with their contributions, and how each moves the weighted residuals, (n, errors): one column for each curve where they are of a curve.
pub struct Stated {
    pub contributions: Vec<Contribution>,
    pub columns: DMatrix<f64>,
}

/// Contributions of the stated errors. `dimensions`: of the test piece, for those of force and compliance.
pub fn contributions(
    setting: &LawSetting,
    fitted: &[Sample],
    answer: &LawFit,
    accuracy: &Accuracy,
    dimensions: Dimensions,
) -> Result<Stated, FitError> {
    let mut stated = Stated { contributions: vec![], columns: DMatrix::zeros(fitted.len(), 0) };
    if accuracy.0.is_empty() {
        return Ok(stated);
    }
    let groups = curves(fitted);
    let of_mode = |row: usize| groups.iter().filter(|rows| fitted[rows[0]].mode == fitted[row].mode).count();
    // The curves whose zeros are in no scatter
    let alone: Vec<&Vec<usize>> = match answer.errors.model {
        ErrorModel::Specimens { .. } => vec![],
        ErrorModel::Levels { .. } => groups.iter().filter(|rows| of_mode(rows[0]) == 1).collect(),
        _ => groups.iter().collect(),
    };
    let step = directions(&jacobian(setting, fitted, answer)).inverse();
    let slope = |s: &Sample| match s.stretch == 1.0 && !setting.slack.is_empty() {
        true => 0.0,
        false => offset::slope(setting.model, &answer.values, s),
    };
    // The stress without its scatter, which would take up the residuals
    let law = |s: &Sample| setting.model.at(&answer.values, s);
    for (kind, half_width) in accuracy.0.iter().filter(|(kind, _)| !(alone.is_empty() && kind.is_of_a_curve())) {
        let area = || dimensions.needed_section(*kind);
        let change: Box<dyn Fn(&Sample) -> f64> = match kind {
            SharedError::StressZero => Box::new(|_| 1.0),
            SharedError::ForceZero => {
                let area = area()?;
                Box::new(move |_| area.recip())
            }
            SharedError::StressScale => Box::new(law),
            SharedError::StrainZero => Box::new(slope),
            SharedError::StrainScale => Box::new(|s| slope(s) * s.mode.strain(s.stretch)),
            SharedError::Poisson => Box::new(|s| by_poisson(setting.model, &answer.values, s)),
            SharedError::Compliance => {
                let by = area()? / dimensions.needed_length(*kind)?;
                Box::new(move |s| slope(s) * law(s) * by)
            }
        };
        let moved = |rows: &[usize]| {
            let mut residuals = DVector::zeros(fitted.len());
            rows.iter().for_each(|k| residuals[*k] = answer.weight[*k] * half_width * change(&fitted[*k]));
            residuals
        };
        let columns: Vec<DVector<f64>> = match kind.is_of_a_curve() {
            true => alone.iter().map(|rows| moved(rows)).collect(),
            false => vec![moved(&(0..fitted.len()).collect::<Vec<_>>())],
        };
        let shifts: Vec<DVector<f64>> = columns.iter().map(|c| &step * c).collect();
        let moves = (0..answer.values.len()).map(|j| shifts.iter().map(|d| d[j] * d[j]).sum::<f64>().sqrt()).collect();
        stated.contributions.push(Contribution { error: *kind, half_width: *half_width, moves });
        for column in columns {
            let at = stated.columns.ncols();
            stated.columns = stated.columns.insert_column(at, 0.0);
            stated.columns.set_column(at, &column);
        }
    }
    Ok(stated)
}

/// −∂P/∂ν \[Pa\], what an error of ν leaves in the residuals: central differences, to 1e-8.
fn by_poisson(model: Model, values: &[f64], s: &Sample) -> f64 {
    const H: f64 = 1e-5;
    let at = |nu: f64| model.with_poisson(nu).at(values, s);
    (at(model.nu - H) - at(model.nu + H)) / (2.0 * H)
}

/// The constants with wider intervals and standard errors.
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
