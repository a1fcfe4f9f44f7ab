//! Weights of data points, and the noise of a test from its own data.
//!
//! w = 1; 1/|P̂| with a floor, P̂ the stress of the law; 1/σ of the mode. With the measured stress, relative weights would prefer data points whose
//! errors are negative: μ would be too low by twice the variance of the relative errors, 0.5 % for errors of 5 % (Carroll & Ruppert, *Transformation
//! and Weighting in Regression*, 1988, ch. 2). σ² = mean of dᵢ²/(1 + aᵢ² + bᵢ²), dᵢ = Pᵢ − aᵢPᵢ₋₁ − bᵢPᵢ₊₁, with a and b from the straight line
//! between the neighbours in λ: variation from one data point to the next cannot come from the law.
//!
//! Source: Gasser, Sroka & Jennen-Steinmetz, Biometrika 73 (1986) 625–633. Limits: the data points are assumed to be independent (σ is too small for
//! correlated errors), and the curve to be straight over three data points (σ is too large for coarse tables).

use crate::calibrate::judgement::repeats::Repeats;
use crate::calibrate::{FitError, Mode, Sample, Weighting};
use serde::{Deserialize, Serialize};

/// Standard deviation of the stress of one mode.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
pub struct ModeNoise {
    pub mode: Mode,
    /// \[Pa\]
    pub std_pa: f64,
    /// Whether it was given; otherwise it was estimated from the data
    pub given: bool,
}

/// Smallest |P| by which a relative weight divides, relative to the largest |P| of the mode \[–\]
pub const FLOOR: f64 = 0.05;
/// Least number of data points at different stretches that an estimate needs
const LEAST: usize = 5;

/// The noise of each mode, as given or estimated.
pub fn of_modes(samples: &[Sample], modes: &[Mode], given: Option<f64>) -> Result<Vec<ModeNoise>, FitError> {
    if let Some(std_pa) = given.filter(|std_pa| !(*std_pa > 0.0 && std_pa.is_finite())) {
        return Err(FitError::Noise { std_pa });
    }
    let one = |mode: &Mode| match given {
        Some(std_pa) => Ok(ModeNoise { mode: *mode, std_pa, given: true }),
        None => estimate(samples, *mode).map(|std_pa| ModeNoise { mode: *mode, std_pa, given: false }),
    };
    modes.iter().map(one).collect()
}

/// Standard deviation of y over x by the same formula as for tests; `None` if it is zero or cannot be estimated.
pub fn of_curve(x: &[f64], y: &[f64]) -> Option<f64> {
    let row = |(x, y): (&f64, &f64)| Sample {
        mode: Mode::Uniaxial,
        second: 1.0,
        stretch: *x,
        stress: *y,
        line: 0,
        specimen: 0,
    };
    let rows: Vec<Sample> = x.iter().zip(y).map(row).collect();
    estimate(&rows, Mode::Uniaxial).ok()
}

fn estimate(samples: &[Sample], mode: Mode) -> Result<f64, FitError> {
    let mut rows: Vec<&Sample> = samples.iter().filter(|s| s.mode == mode).collect();
    let order = |a: &&Sample, b: &&Sample| a.specimen.cmp(&b.specimen).then(a.stretch.total_cmp(&b.stretch));
    rows.sort_by(order);
    let triple = |w: &[&Sample]| {
        let [x, y, z] = [0, 1, 2].map(|k| w[k].stretch);
        let of_one_curve = w.iter().all(|s| s.specimen == w[0].specimen && s.second == w[0].second);
        let (a, b) = ((z - y) / (z - x), (y - x) / (z - x));
        let d = w[1].stress - a * w[0].stress - b * w[2].stress;
        (of_one_curve && z > x).then(|| d * d / (1.0 + a * a + b * b))
    };
    let squares: Vec<f64> = rows.windows(3).filter_map(triple).collect();
    let std_pa = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    if squares.len() + 2 < LEAST || std_pa == 0.0 {
        return Err(FitError::NoNoise { mode, rows: rows.len() });
    }
    Ok(std_pa)
}

/// Gives each of several specimens the same weight, independently of the number of its data points, because the scatter is between specimens.
/// `specimen`: the specimen of each data point. If no test has two specimens, the data points count as those of one specimen.
pub fn share<T>(weights: &mut [f64], specimen: &[usize], repeats: &Repeats<T>) {
    if repeats.repeated.is_empty() {
        return;
    }
    let count = 1 + specimen.iter().copied().max().unwrap_or(0);
    let mut rows = vec![0.0_f64; count];
    specimen.iter().for_each(|s| rows[*s] += 1.0);
    let present = rows.iter().filter(|n| **n > 0.0).count() as f64;
    let mean = specimen.len() as f64 / present;
    if rows.iter().any(|n| *n > 0.0 && *n != mean) {
        weights.iter_mut().zip(specimen).for_each(|(w, s)| *w *= (mean / rows[*s]).sqrt());
    }
}

/// Weights before a robust loss: 1, or \[1/Pa\]. `stress`: the stress of the law at each data point, or the measured stress before there is a law.
pub fn weights(
    samples: &[Sample],
    stress: &[f64],
    weighting: Weighting,
    noise: &[ModeNoise],
) -> Result<Vec<f64>, FitError> {
    let largest = |mode| samples.iter().filter(|s| s.mode == mode).map(|s| s.stress.abs()).fold(0.0, f64::max);
    let tops = Mode::ALL.map(largest);
    let one = |(s, stress): (&Sample, &f64)| match weighting {
        Weighting::Absolute => Ok(1.0),
        // A mode without stress has no scale: its data points get the weight of the largest stress of all modes
        Weighting::Relative => {
            let top = tops[s.mode as usize];
            let all = tops.iter().copied().fold(0.0, f64::max);
            Ok(stress.abs().max(FLOOR * if top > 0.0 { top } else { all }).recip())
        }
        Weighting::Noise => {
            let own = noise.iter().find(|n| n.mode == s.mode).ok_or(FitError::NoNoise { mode: s.mode, rows: 0 })?;
            Ok(own.std_pa.recip())
        }
    };
    samples.iter().zip(stress).map(one).collect()
}
