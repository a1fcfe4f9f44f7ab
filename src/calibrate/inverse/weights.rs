//! Weights of the data points of every curve, before a robust loss.
//!
//! w = 1, or 1/|ŷ − ŷ₀| with a floor, where ŷ is the value of the scene and ŷ₀ its value at rest: the size of a position is that of its changes,
//! wherever the origin is. Several curves are weighted by their noise, or by their relative misfit, where w is divided by the rms of w(ŷ − ŷ₀).
//! Weights from measured values would prefer data points and curves whose errors are negative, as in direct fits ([`noise`]); they are used only
//! before there is an answer. Specimens that repeat a test have equal weight, whatever the number of their data points.

use super::InverseError;
use super::model::ModelAnswer;
use super::observed::ObservedCurve;
use crate::calibrate::Weighting;
use crate::calibrate::judgement::origin::Origin;
use crate::calibrate::solve::noise;

/// Change from rest, as a share of the values, below which it is rounding \[–\]
const NOTHING: f64 = 1e-9;

/// One number for each data point, \[curves\]\[data points\].
pub type CurveValues = Vec<Vec<f64>>;

/// The rule for the weights of the data points of some curves.
pub struct Rule {
    weighting: Weighting,
    /// Standard deviation of each of several curves, if they are weighted by it
    noise: Option<Vec<f64>>,
}

impl Rule {
    /// Builds the rule; refuses curves that are zero, and curves without noise if they are weighted by it.
    pub fn new(curves: &[ObservedCurve], weighting: Weighting) -> Result<Self, InverseError> {
        if let Some(zero) = curves.iter().find(|c| largest(&c.measured.y) == 0.0) {
            return Err(InverseError::Zero { curve: zero.name.clone() });
        }
        let of = |c: &ObservedCurve| {
            let (x, y) = (&c.measured.x, &c.measured.y);
            noise::of_curve(x, y).ok_or_else(|| InverseError::NoNoise { curve: c.name.clone(), rows: y.len() })
        };
        // A single curve needs no relative noise
        let is_needed = weighting == Weighting::Noise && curves.len() > 1;
        let noise = is_needed.then(|| curves.iter().map(of).collect::<Result<_, _>>()).transpose()?;
        Ok(Self { weighting, noise })
    }

    /// Weights by `changes`, simulated or measured; neither these nor the size of a curve count below a share of `measured`.
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

/// y − b − ŷ₀ of the measured curves, with the zero b of each; for data without any change, their values.
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
