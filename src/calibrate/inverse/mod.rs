//! Inverse analysis: constants of laws from a curve measured on a whole specimen or robot, by simulating it.
//!
//! min ½Σ wᵢ²(ŷ(xᵢ; θ) − yᵢ)² with ŷ from a scene, ∂ŷ/∂θ exact ([`crate::scene::Scene::run_with`]). A specimen is then what it is: its wide ends
//! stretch too, and the travel of the crosshead needs no gauge length.
//!
//! Intervals: covariance of the linearised problem, and a bootstrap in blocks of neighbouring data points whose refits are single Gauss–Newton
//! steps (Shao & Tu, *The Jackknife and Bootstrap*, 1995, ch. 8): θ* = θ̂ + (JₛᵀJₛ)⁻¹Jₛᵀrₛ of the data points s that were drawn.

mod answer;
mod error;
mod gauge;
mod interval;
mod measured;
mod model;
mod profile;
mod search;

pub use answer::{Calibration, Found, Gauge, Stable};
pub use error::InverseError;
pub use measured::{ColumnSpec, Measured, MeasuredSpec};
pub use model::{Failure, SceneModel, Unknown, written};

use super::judgement::certificate::{CASES, range};
use super::judgement::identify;
use super::solve::noise;
use super::{Direction, Estimate, FitWarning, Weighting};
use crate::material::{StabilityLimit, material_stability};
use crate::scene::stretch::stretches;
use crate::scene::{Progress, Scene};
use nalgebra::{DMatrix, DVector};
use search::{Weights, search};
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Differences below this one are errors of the forward solve: Newton's method stops at 1e-8 \[–\]
const ROUNDING: f64 = 1e-7;

/// Options in addition to scene and curve.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Settings {
    pub weighting: Weighting,
    /// Length and section of a homogeneous piece \[m, m²\]: where the search starts, and what it corrects
    pub gauge: Option<[f64; 2]>,
    /// Intervals by profile likelihood too, for some forward solves more
    pub profile: bool,
}

/// Finds the constants. Returns the scene at the answer too.
pub fn calibrate(
    model: &SceneModel,
    measured: &Measured,
    settings: &Settings,
    watch: &mut dyn FnMut(Progress) -> bool,
) -> Result<(Calibration, Scene), Failure> {
    let begin = Instant::now();
    let mut measured = measured.clone();
    let reached = model.reached(&measured)?;
    keep(&mut measured, &reached, &model.x);
    let weights = weigh(&measured, settings.weighting).map_err(Failure::Input)?;
    let stated: Vec<f64> = model.unknown.iter().map(|u| u.start).collect();
    let gauge = settings.gauge.and_then(|g| gauge::fit(model, &measured, settings.weighting, g));
    let of_gauge = gauge.iter().flat_map(|g| &g.values).chain(std::iter::repeat(&None));
    let mut start: Vec<f64> = stated.iter().zip(of_gauge).map(|(value, found)| found.unwrap_or(*value)).collect();
    let found = match search(model, &measured, &weights, &start, watch) {
        // Constants of the gauge length that the scene cannot take
        Err(Failure::Constants(_) | Failure::Run(_)) if start != stated => {
            start = stated;
            search(model, &measured, &weights, &start, watch)?
        }
        found => found?,
    };
    let (answer, values) = (found.answer, found.values);
    let n = measured.y.len();
    let residual = DVector::from_fn(n, |i, _| weights.w[i] * (measured.y[i] - answer.y[i]));
    let jacobian = DMatrix::from_fn(n, values.len(), |i, k| weights.w[i] * answer.sensitivities[(i, k)]);
    let parameters: Vec<_> = model.unknown.iter().map(|u| u.parameter).collect();
    let identified = identify::identify(&parameters, &values, &jacobian, &residual, weights.size, ROUNDING, None);
    let (block, drawn) = interval::drawn_again(&measured.x, &values, &jacobian, &residual);
    let best = profile::Best {
        values: &values,
        std_errors: identified.estimates.iter().map(|e| e.std_error).collect(),
        jacobian: &jacobian,
        residual: &residual,
    };
    let (ends, more) = match settings.profile {
        true => profile::ends(model, &measured, &weights, &best, watch)?,
        false => (vec![[None; 2]; values.len()], 0),
    };
    let profiled = settings.profile.then_some(&ends[..]);
    let constants = constants(model, &identified.estimates, &start, profiled, drawn.as_deref());
    let square = |v: &mut dyn Iterator<Item = f64>| v.map(|r| r * r).sum::<f64>();
    let r2 = square(&mut measured.y.iter().zip(&answer.y).map(|(a, b)| a - b));
    let y2 = square(&mut measured.y.iter().copied());
    let [median, p95, largest, _] = stretches(&answer.scene.elastic, &answer.run.last.x)[..] else {
        unreachable!("the probe has four columns")
    };
    let stretch = [median, p95, largest];
    let open_ends: Vec<String> = constants.iter().filter_map(Found::open_end).collect();
    let calibration = Calibration {
        x: model.x.clone(),
        y: model.y.clone(),
        unidentified: words(&identified.directions).into_iter().chain(open_ends).collect(),
        constants,
        covariance: identified.directions.is_empty().then(|| interval::covariance(&jacobian, &residual)).flatten(),
        block,
        runs_p: interval::few_runs(&measured.x, &residual),
        predicted: answer.y,
        curve: answer.curve,
        rms_relative: (r2 / y2).sqrt(),
        rms: (r2 / n as f64).sqrt(),
        gauge,
        stability: certificate(&answer.scene, stretch[2]),
        stretch,
        solves: found.solves,
        profile_solves: more,
        failed: found.failed,
        settled: found.settled,
        forward_s: answer.forward,
        gradient_s: answer.gradient,
        wall_s: begin.elapsed().as_secs_f64(),
        measured,
    };
    Ok((calibration, answer.scene))
}

/// The constants with their intervals; `profiled`: ends by profile likelihood, `drawn`: of resampled blocks.
fn constants(
    model: &SceneModel,
    estimates: &[Estimate],
    start: &[f64],
    profiled: Option<&[[Option<f64>; 2]]>,
    drawn: Option<&[[f64; 2]]>,
) -> Vec<Found> {
    let finite = |x: f64| x.is_finite().then_some(x);
    (estimates.iter().zip(&model.unknown).zip(start).enumerate())
        .map(|(k, ((e, u), start))| Found {
            key: u.constant.to_string(),
            symbol: e.symbol.into(),
            unit: e.unit.into(),
            start: *start,
            value: e.value,
            std_error: finite(e.std_error),
            interval: finite(e.std_error).map(|_| e.interval),
            profile: profiled.map(|ends| ends[k]),
            bootstrap: drawn.map(|d| d[k]).filter(|_| e.std_error.is_finite()),
        })
        .collect()
}

/// Leaves out the data points that the protocol does not reach.
fn keep(measured: &mut Measured, reached: &[bool], name: &str) {
    let lost = reached.iter().filter(|r| !**r).count();
    if lost == 0 {
        return;
    }
    let chosen: Vec<usize> = (0..reached.len()).filter(|k| reached[*k]).collect();
    measured.x = chosen.iter().map(|k| measured.x[*k]).collect();
    measured.y = chosen.iter().map(|k| measured.y[*k]).collect();
    measured.lines = chosen.iter().map(|k| measured.lines[*k]).collect();
    measured
        .notes
        .push(format!("of {} data points {lost} beyond the range of the protocol in {name} left out", reached.len()));
}

/// w and ‖wy‖.
fn weigh(measured: &Measured, weighting: Weighting) -> Result<Weights, InverseError> {
    let largest = measured.y.iter().fold(0.0f64, |m, y| m.max(y.abs()));
    if largest == 0.0 {
        return Err(InverseError::Zero);
    }
    let one = |y: &f64| match weighting {
        // One curve has one noise
        Weighting::Absolute | Weighting::Noise => 1.0,
        Weighting::Relative => y.abs().max(noise::FLOOR * largest).recip(),
    };
    let w: Vec<f64> = measured.y.iter().map(one).collect();
    let size = w.iter().zip(&measured.y).map(|(w, y)| (w * y).powi(2)).sum::<f64>().sqrt();
    Ok(Weights { w, size })
}

/// The directions as a fit names them.
fn words(directions: &[Direction]) -> Vec<String> {
    let one = |d: &Direction| FitWarning::Unidentifiable { directions: vec![d.clone()] }.to_string();
    directions.iter().map(one).collect()
}

/// Range of material stability of the laws of the scene, up to 1.5 times the largest stretch in it.
fn certificate(scene: &Scene, largest: f64) -> Vec<Stable> {
    let top = (1.5 * largest).max(2.0);
    let of = |(name, table): (&String, &toml::Table)| {
        let law = crate::material::law_from_table(table).ok()?;
        let one = |(case, mode): (crate::material::LoadCase, &str)| {
            let looked = range(case, top);
            let found = material_stability(law.as_ref(), case, looked).ok()?;
            let amount = |limit: Option<StabilityLimit>| limit.map(|l| l.amount);
            let (below, above) = (amount(found.below), amount(found.above));
            Some(Stable { law: name.clone(), mode: mode.into(), looked, below, above })
        };
        Some(CASES.into_iter().filter_map(one).collect::<Vec<_>>())
    };
    scene.spec.laws.iter().filter_map(of).flatten().collect()
}
