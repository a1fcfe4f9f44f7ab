//! Weights of the data points of every curve, before a robust loss.
//!
//! w = 1, or 1/|ŷ − ŷ₀| with a floor, ŷ of the scene and ŷ₀ that at rest: a position is as large as its changes, wherever the origin is. Of several curves each counts by its
//! noise, or by its relative misfit, where w is divided by the rms of w(ŷ − ŷ₀). By the measured values both would prefer the data points and the curves whose errors are negative, as in
//! direct fits ([`noise`]); they serve before there is an answer.
//! Specimens that repeat a test have equal weight, whatever the number of their data points.

use super::InverseError;
use super::model::ModelAnswer;
use super::observed::ObservedCurve;
use crate::calibrate::Weighting;
use crate::calibrate::judgement::origin::Origin;
use crate::calibrate::solve::noise;

/// Changes from rest below this share of the values are rounding \[–\]
const NOTHING: f64 = 1e-9;

/// A number of each data point, \[curves\]\[data points\].
pub type CurveValues = Vec<Vec<f64>>;

/// The rule by which the data points of some curves are weighted.
pub struct Rule {
    weighting: Weighting,
    /// Standard deviation of each of several curves, where they count by it
    noise: Option<Vec<f64>>,
}

impl Rule {
    /// Refuses curves that are zero, and those without noise where they count by it.
    pub fn new(curves: &[ObservedCurve], weighting: Weighting) -> Result<Self, InverseError> {
        if let Some(zero) = curves.iter().find(|c| largest(&c.measured.y) == 0.0) {
            return Err(InverseError::Zero { curve: zero.name.clone() });
        }
        let of = |c: &ObservedCurve| {
            let (x, y) = (&c.measured.x, &c.measured.y);
            noise::of_curve(x, y).ok_or_else(|| InverseError::NoNoise { curve: c.name.clone(), rows: y.len() })
        };
        // One curve has one noise
        let is_needed = weighting == Weighting::Noise && curves.len() > 1;
        let noise = is_needed.then(|| curves.iter().map(of).collect::<Result<_, _>>()).transpose()?;
        Ok(Self { weighting, noise })
    }

    /// Weights by `changes`, those of the scenes or the measured ones; neither these nor the size of a curve count below a share of what was `measured`.
    pub fn weights(&self, changes: &CurveValues, measured: &CurveValues, origin: &Origin) -> CurveValues {
        let is_alone = changes.len() == 1;
        let one = |(of, (changes, measured)): (usize, (&Vec<f64>, &Vec<f64>))| {
            let least = noise::FLOOR * largest(measured);
            let point = |change: &f64| match self.weighting {
                Weighting::Absolute | Weighting::Noise => 1.0,
                Weighting::Relative => change.abs().max(least).recip(),
            };
            let weights: Vec<f64> = changes.iter().map(point).collect();
            let unit = match &self.noise {
                Some(noise) => noise[of],
                None if is_alone => 1.0,
                None => rms(&weights, changes).max(noise::FLOOR * rms(&weights, measured)),
            };
            weights.iter().map(|w| w / unit).collect::<Vec<f64>>()
        };
        let mut all: Vec<f64> = changes.iter().zip(measured).enumerate().flat_map(one).collect();
        noise::share(&mut all, &origin.specimen, &origin.repeats());
        let mut rest = all.as_slice();
        let own = |c: &Vec<f64>| {
            let (own, others) = rest.split_at(c.len());
            rest = others;
            own.to_vec()
        };
        changes.iter().map(own).collect()
    }
}

/// y − b − ŷ₀ of the measured curves, b the zero of each; of data that say that nothing changes their values.
pub fn measured(curves: &[ObservedCurve], answers: &[ModelAnswer], zeros: &[f64]) -> CurveValues {
    let one = |((curve, answer), zero): ((&ObservedCurve, &ModelAnswer), &f64)| {
        let y = &curve.measured.y;
        let changes: Vec<f64> = y.iter().map(|y| y - zero - answer.at_rest()).collect();
        if largest(&changes) > NOTHING * largest(y) { changes } else { y.clone() }
    };
    curves.iter().zip(answers).zip(zeros).map(one).collect()
}

/// ŷ − ŷ₀ of the scenes.
pub fn simulated(answers: &[ModelAnswer]) -> CurveValues {
    answers.iter().map(|a| a.y.iter().map(|y| y - a.at_rest()).collect()).collect()
}

/// ‖w y‖ over all curves.
pub fn norm(weights: &CurveValues, y: &CurveValues) -> f64 {
    let square = |(w, y): (&f64, &f64)| (w * y).powi(2);
    weights.iter().zip(y).flat_map(|(w, y)| w.iter().zip(y)).map(square).sum::<f64>().sqrt()
}

fn largest(y: &[f64]) -> f64 {
    y.iter().fold(0.0, |most, y| most.max(y.abs()))
}

/// √(Σ(wy)²/n)
fn rms(weights: &[f64], y: &[f64]) -> f64 {
    (weights.iter().zip(y).map(|(w, y)| (w * y).powi(2)).sum::<f64>() / y.len() as f64).sqrt()
}
