//! Misfit between a law and samples.

use crate::calibrate::{Mode, Sample};
use crate::math::statistics::larger;
use serde::{Deserialize, Serialize};

/// One sample compared with the law.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Residual {
    pub mode: Mode,
    /// λ \[–\]
    pub stretch: f64,
    /// [`Sample::reach`], by which ranges are selected \[–\]
    #[serde(skip)]
    pub reach: f64,
    /// Measured P \[Pa\]
    pub measured: f64,
    /// P of the law \[Pa\]
    pub law: f64,
    /// measured − law \[Pa\]
    pub residual: f64,
    /// Line of the file
    pub line: u64,
}

/// Residuals in the order of mode and stretch; equal stretches stay in the order of the file.
pub fn residuals(samples: &[Sample], law: impl Fn(&Sample) -> f64) -> Vec<Residual> {
    let mut rows: Vec<_> = samples
        .iter()
        .map(|s| {
            let p = law(s);
            Residual {
                mode: s.mode,
                stretch: s.stretch,
                reach: s.reach(),
                measured: s.stress,
                law: p,
                residual: s.stress - p,
                line: s.line,
            }
        })
        .collect();
    rows.sort_by(|a, b| a.mode.cmp(&b.mode).then(a.stretch.total_cmp(&b.stretch)));
    rows
}

/// Misfit over some data points. With residuals rᵢ = Pᵢ − P(λᵢ):
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
pub struct Misfit {
    pub rows: usize,
    /// √(Σrᵢ²/n) \[Pa\]
    pub rms_pa: f64,
    /// √(Σrᵢ²/ΣPᵢ²) \[–\]; 0 if both sums are zero
    pub rms_relative: f64,
    /// max |rᵢ| \[Pa\]
    pub max_pa: f64,
    /// max |rᵢ/Pᵢ| over data points with Pᵢ ≠ 0 \[–\]
    pub max_relative: f64,
    /// −(Σrᵢ/n)/√(ΣPᵢ²/n) \[–\]: negative if the law is too soft; its magnitude is at most `rms_relative`
    pub bias_relative: f64,
}

impl Misfit {
    /// The misfit of these residuals; `None` without data points
    pub fn of(rows: &[Residual]) -> Option<Self> {
        if rows.is_empty() {
            return None;
        }
        let sum = |f: fn(&Residual) -> f64| rows.iter().map(f).sum::<f64>();
        let largest = |f: fn(&Residual) -> f64| rows.iter().map(f).fold(0.0, larger);
        let (r2, p2) = (sum(|r| r.residual.powi(2)), sum(|r| r.measured.powi(2)));
        let ratio = |a: f64, b: f64| if a == 0.0 { 0.0 } else { a / b };
        Some(Self {
            rows: rows.len(),
            rms_pa: (r2 / rows.len() as f64).sqrt(),
            rms_relative: ratio(r2, p2).sqrt(),
            max_pa: largest(|r| r.residual.abs()),
            max_relative: largest(|r| if r.measured == 0.0 { 0.0 } else { (r.residual / r.measured).abs() }),
            bias_relative: ratio(-sum(|r| r.residual), (rows.len() as f64 * p2).sqrt()),
        })
    }
}

/// S = Σ wᵢ²rᵢ² of a law \[weighted Pa²\].
pub fn sum_of_squares(samples: &[Sample], weight: &[f64], law: impl Fn(&Sample) -> f64) -> f64 {
    let square = |(s, w): (&Sample, &f64)| (w * (s.stress - law(s))).powi(2);
    samples.iter().zip(weight).map(square).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bias_is_relative_to_what_the_rms_is() {
        let row = |measured: f64, law: f64| Residual {
            mode: Mode::Uniaxial,
            stretch: 2.0,
            reach: 2.0,
            measured,
            law,
            residual: measured - law,
            line: 1,
        };
        // A law that is too soft by the same stress everywhere
        let shifted = Misfit::of(&[row(1e3, 9e2), row(1e5, 99_900.0), row(2e5, 199_900.0)]).expect("rows");
        assert!((shifted.bias_relative + shifted.rms_relative).abs() < 1e-12, "{shifted:?}");
        let mixed = Misfit::of(&[row(1e3, 5e2), row(2e3, 1.9e3), row(-1e3, -1.4e3)]).expect("rows");
        assert!(mixed.bias_relative.abs() < mixed.rms_relative, "{mixed:?}");
        let nothing = Misfit::of(&[row(0.0, 0.0)]).expect("rows");
        assert_eq!((nothing.bias_relative, nothing.rms_relative), (0.0, 0.0));
        let undefined = Misfit::of(&[row(1e3, 9e2), row(2e3, f64::NAN)]).expect("rows");
        assert!(undefined.max_pa.is_nan() && undefined.max_relative.is_nan(), "{undefined:?}");
    }
}
