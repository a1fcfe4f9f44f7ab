//! Slack of a test: an offset e₀ of the measured strain, fitted with the law.
//!
//! A specimen that is not yet straight stretches without stress: P = P(λ(e − e₀)), and 0 for e < e₀ in tension (e > e₀ in compression). One e₀ for
//! every specimen and mode is found together with the constants: each iteration is a Gauss–Newton step in all unknowns, halved until the sum of
//! squares with the best constants falls (variable projection). The offset takes part in the covariance of the constants as a column −∂P/∂e.
//!
//! Unless it is requested, e₀ is fitted only if the table shows slack independently of the law:
//!
//! - at least two data points lie inside the slack, and their stresses are below a quarter of those that the law would have there without slack, with
//!   a scatter that leaves less than this quarter open at 95 %. The share is c = ΣPP̂/ΣP̂² over these data points, with the sign of the stresses, so
//!   that noise does not count as stress; its scatter is √(s²/ΣP̂²), with s² the mean square of the residuals up to twice the slack. Without this
//!   condition, draws that look like slack by chance would have an e₀ that is too large;
//! - a fit with e₀ leaves no more than a quarter of the smooth residual. A misfit of the law makes an offset significant without making a rubber
//!   stretch without stress, but most of the misfit of a curve that stiffens more than the law can remains with an offset: that is neither slack nor
//!   a reason for a warning;
//! - e₀ ≠ 0 at 1 %, by the errors of the fit with it: the residual of a fit without it is smooth, the more so the less noise there is, and looks like
//!   correlated errors.
//!
//! If one specimen shows slack, the others of its mode were clamped in the same way, and each gets an offset. If e₀ is significant and a constant
//! without it lies outside its interval with it, but no such data points exist, there is a warning.
//!
//! Limits: not for biaxial tests, and not for a specimen that was tested on both sides of rest; the gauge length is not corrected by the slack.

use super::errors;
use super::estimate::Estimate;
use super::origin::Origin;
use crate::calibrate::solve::offset::{Offset, SlackChoice, no_single_offset, removed};
use crate::calibrate::solve::{
    LawFit, LawSetting, ROUNDING, constants, fitted, jacobian, residual, solve, solve_untested,
};
use crate::calibrate::{FitError, FittableLaw, Mode, Sample};
use crate::math::statistics;
use crate::math::svd::svd;
use serde::Serialize;

/// A fitted offset as reported.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Slack {
    pub file: String,
    pub mode: Mode,
    pub strain: f64,
    /// 95 % interval \[–\]
    pub interval: [f64; 2],
    /// Data points inside the slack
    pub rows: usize,
    /// Whether it was requested; false if the data points without stress decided
    pub asked: bool,
}

/// Least number of data points inside the slack that show it, and the largest ratio of their stress to the stress without slack
const ROWS: usize = 2;
const PART: f64 = 0.25;
/// Share of the smooth residual that a fit with the offsets may leave, and that the first step towards it may leave \[–\]
const LEFT: f64 = 0.25;
const LEFT_AT_FIRST: f64 = 0.9;
/// One-sided 95 % quantile of the standard normal distribution
const SIDE: f64 = 1.645;
/// Strain up to which residuals determine the scatter at the beginning, relative to the slack \[–\]
const BEGIN: f64 = 2.0;
const STEPS: usize = 60;
/// Relative decrease of the sum of squares below which the search ends
const FLAT: f64 = 1e-13;

/// Offsets of the curves of these data points, and the constants that are found with them.
pub fn search(
    setting: &LawSetting,
    rows: &[Sample],
    mut offsets: Vec<Offset>,
) -> Result<(Vec<Offset>, LawFit), FitError> {
    let fit = |offsets: &[Offset], near: Option<&LawFit>| {
        let setting = LawSetting { slack: offsets.to_vec(), ..setting.clone() };
        let samples = removed(rows, offsets);
        let found = constants(&setting, &samples, near)?;
        let square = residual(&setting, &samples, &found).norm_squared();
        Ok::<_, FitError>((setting, samples, found, square))
    };
    let (mut own, mut samples, mut found, mut square) = fit(&offsets, None)?;
    let p = found.values.len();
    for _ in 0..STEPS {
        // Rounding moves an offset as it moves the constants
        if square.sqrt() <= ROUNDING * fitted(&own, &samples, &found).norm() {
            break;
        }
        let j = jacobian(&own, &samples, &found);
        let length: Vec<f64> = j.column_iter().map(|c| c.norm()).map(|l| if l > 0.0 { l } else { 1.0 }).collect();
        let scaled = nalgebra::DMatrix::from_fn(j.nrows(), j.ncols(), |i, k| j[(i, k)] / length[k]);
        let svd = svd(scaled, true, true);
        let Ok(step) = svd.solve(&residual(&own, &samples, &found), 1e-9 * svd.singular_values.max()) else { break };
        let moved = |t: f64| {
            let next: Vec<Offset> = (offsets.iter().enumerate())
                .map(|(k, o)| Offset { strain: o.strain + t * step[p + k] / length[p + k], ..*o })
                .collect();
            fit(&next, Some(&found)).ok().map(|f| (next, f)).filter(|(_, f)| f.3 < square)
        };
        let Some((next, lower)) = (0..14).find_map(|k| moved(0.5_f64.powi(k))) else { break };
        let still = lower.3 > square * (1.0 - FLAT);
        offsets = next;
        (own, samples, found, square) = lower;
        if still {
            break;
        }
    }
    Ok((offsets, found))
}

/// Strain offsets that a fit uses, and how they compare with a fit without any.
pub struct SlackFit {
    /// Empty if no offset is fitted
    pub offsets: Vec<Offset>,
    /// Largest significant offset that was not fitted, with the constants that belong to it
    pub hint: Option<(Offset, Vec<Estimate>)>,
}

/// Decides which offsets are fitted. `rows`: the fitted data points as measured.
pub fn find(setting: &LawSetting, rows: &[Sample], choice: SlackChoice) -> Result<SlackFit, FitError> {
    let nothing = SlackFit { offsets: vec![], hint: None };
    let mut curves: Vec<Offset> = Vec::new();
    let mut refusal = None;
    for s in rows {
        if curves.iter().any(|o| o.specimen == s.specimen && o.mode == s.mode) {
            continue;
        }
        let own = || rows.iter().filter(|o| o.specimen == s.specimen && o.mode == s.mode);
        let strains = || own().map(|o| s.mode.strain(o.stretch));
        let side = strains().sum::<f64>().signum();
        let begin = strains().map(|e| side * e).fold(0.0, f64::min);
        curves.push(Offset { specimen: s.specimen, mode: s.mode, strain: 0.0, side, begin });
        refusal = refusal.or(no_single_offset(s.mode, own()));
    }
    let few = rows.len() < setting.model.parameters().len() + curves.len() + 2;
    let refusal = refusal.or(few.then_some("there are too few data points for it"));
    match (choice, refusal) {
        (SlackChoice::No, _) | (SlackChoice::Auto, Some(_)) => return Ok(nothing),
        (SlackChoice::Yes, Some(reason)) => return Err(FitError::Slack { reason }),
        (_, None) => {}
    }
    if choice == SlackChoice::Yes {
        return Ok(SlackFit { offsets: search(setting, rows, curves)?.0, hint: None });
    }
    if !may_matter(setting, rows, &curves)? {
        return Ok(nothing);
    }
    let Ok((offsets, near)) = search(setting, rows, curves) else { return Ok(nothing) };
    let own = LawSetting { slack: offsets.clone(), ..setting.clone() };
    let found = solve_untested(&own, &removed(rows, &offsets), &near)?;
    let limit = |e: &Estimate| e.std_error * statistics::t_quantile(0.99, found.errors.free.max(1));
    let significant = |e: &Estimate| e.value.abs() > limit(e);
    let pairs = || offsets.iter().zip(&found.offsets).filter(|(_, e)| significant(e)).map(|(o, _)| o);
    let Some(largest) = pairs().max_by(|a, b| a.strain.abs().total_cmp(&b.strain.abs())) else { return Ok(nothing) };
    if !explains(setting, rows, &found)? {
        return Ok(nothing);
    }
    let shown: Vec<Mode> =
        pairs().filter(|o| is_shown(setting.model, &found.values, rows, o)).map(|o| o.mode).collect();
    let of_shown = offsets.iter().filter(|o| shown.contains(&o.mode));
    let taken: Vec<Offset> = of_shown.map(|o| Offset { strain: 0.0, ..*o }).collect();
    if !taken.is_empty() {
        return Ok(SlackFit { offsets: search(setting, rows, taken)?.0, hint: None });
    }
    let constants = solve(&own, &removed(rows, &offsets), None)?.identified.estimates;
    Ok(SlackFit { offsets: vec![], hint: Some((*largest, constants)) })
}

/// Whether the data points inside this offset show that they carry no stress.
fn is_shown(model: FittableLaw, values: &[f64], rows: &[Sample], o: &Offset) -> bool {
    let strain = |s: &Sample| o.side * s.mode.strain(s.stretch);
    let up_to = |end: f64| rows.iter().filter(move |s| o.is_of(s) && strain(s) <= end * o.side * o.strain);
    let inside: Vec<&Sample> = up_to(1.0).filter(|s| strain(s) > 0.0).collect();
    let law: Vec<f64> = inside.iter().map(|s| model.at(values, s)).collect();
    let size: f64 = law.iter().map(|p| p * p).sum();
    let part = inside.iter().zip(&law).map(|(s, p)| s.stress * p).sum::<f64>() / size;
    let square = |s: &Sample| (s.stress - model.at(values, &o.shifted(s, o.strain))).powi(2);
    let scatter = up_to(BEGIN).map(square).sum::<f64>() / up_to(BEGIN).count() as f64;
    inside.len() >= ROWS && part < PART && SIDE * (scatter / size).sqrt() < PART
}

/// Whether a first step from zero explains part of the smooth residual, and is significant at 1 % under independent errors (a test without another
/// fit). A single step leaves more than the offsets would, and the smooth part of what it leaves does not count as noise.
fn may_matter(setting: &LawSetting, rows: &[Sample], curves: &[Offset]) -> Result<bool, FitError> {
    let own = LawSetting { slack: curves.to_vec(), ..setting.clone() };
    let found = constants(&own, rows, None)?;
    let p = found.values.len();
    let j = jacobian(&own, rows, &found);
    let length: Vec<f64> = j.column_iter().map(|c| c.norm()).map(|l| if l > 0.0 { l } else { 1.0 }).collect();
    let scaled = nalgebra::DMatrix::from_fn(j.nrows(), j.ncols(), |i, k| j[(i, k)] / length[k]);
    let all = residual(&own, rows, &found);
    let svd = svd(scaled.clone(), true, true);
    let Ok(step) = svd.solve(&all, 1e-9 * svd.singular_values.max()) else { return Ok(false) };
    let left = &all - scaled * &step;
    let (stress, origin) = (fitted(&own, rows, &found), Origin::of(rows));
    let [before, after] = [(j.columns(0, p).into_owned(), &all), (j.clone(), &left)]
        .map(|(j, residual)| errors::of(&j, residual, &stress, &origin, false));
    let free = rows.len() - j.ncols();
    // Half of the bound, to allow for the residual that the step leaves
    let limit = 0.5 * statistics::t_quantile(0.99, free) * left.norm() / (free as f64).sqrt();
    let is_long = |k: usize| (step[k] / length[k]).abs() > limit * after.plain[k];
    Ok(after.smooth <= LEFT_AT_FIRST * before.smooth && (p..j.ncols()).any(is_long))
}

/// Whether the offsets explain the smooth residual of a fit without them.
fn explains(setting: &LawSetting, rows: &[Sample], with: &LawFit) -> Result<bool, FitError> {
    Ok(with.errors.smooth <= LEFT * solve_untested(setting, rows, with)?.errors.smooth)
}
