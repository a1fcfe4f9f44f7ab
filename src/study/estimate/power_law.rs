//! Power laws y = c xᑫ by least squares in logarithms, with their uncertainty.
//!
//! ```text
//! ln y = ln c + q ln x,   s² = Σ (ln yᵢ − fit)²/(n − 2),   S = Σ (ln xᵢ − mean)²
//! q ± t s/√S,   y(x) within a factor exp(t s √(1 + 1/n + (ln x − mean)²/S)),   t = t₀.₉₇₅ with n − 2 degrees of freedom
//! ```
//!
//! Source: any text on linear regression, for example Montgomery, Peck & Vining, *Introduction to Linear Regression Analysis*, 5th ed.
//! (2012), equations 2.40 (slope) and 2.54 (new observation). Limits: x is without error and the scatter is the same in every decade. With few points,
//! s does not reveal a law that bends; as a check, the last point is therefore predicted from the others.

use crate::math::statistics::t_quantile;
use schemars::JsonSchema;
use serde::Serialize;

/// Straight line through log–log points.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct PowerLaw {
    pub q: f64,
    /// Half-width of the 95 % interval of q; `None` with two points
    pub half: Option<f64>,
    /// Standard error of q; `None` with two points
    pub error: Option<f64>,
    pub points: usize,
    log_c: f64,
    mean: f64,
    spread: f64,
    deviation: f64,
}

/// A value of the law with its 95 % interval, which two points do not determine.
#[derive(Serialize, JsonSchema, Clone, Copy, Debug, PartialEq)]
pub struct Predicted {
    /// Predicted value
    pub value: f64,
    /// Ends of its 95 % interval; `None` with two points
    pub interval: Option<[f64; 2]>,
}

impl Predicted {
    /// Raises the value and its interval to at least `least`, a known lower bound.
    pub fn at_least(self, least: f64) -> Self {
        let more = |value: f64| value.max(least);
        Self { value: more(self.value), interval: self.interval.map(|ends| ends.map(more)) }
    }
}

/// Fits a power law. Returns `None` with fewer than two different x, or if a coordinate is not positive and finite.
pub fn power_law(points: &[(f64, f64)]) -> Option<PowerLaw> {
    if points.iter().any(|(x, y)| !(*x > 0.0 && *y > 0.0 && x.is_finite() && y.is_finite())) {
        return None;
    }
    let n = points.len() as f64;
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let (mean, my) = (logs.iter().map(|p| p.0).sum::<f64>() / n, logs.iter().map(|p| p.1).sum::<f64>() / n);
    let spread: f64 = logs.iter().map(|p| (p.0 - mean).powi(2)).sum();
    if points.len() < 2 || spread < 1e-6 {
        return None;
    }
    let q = logs.iter().map(|p| (p.0 - mean) * (p.1 - my)).sum::<f64>() / spread;
    let log_c = my - q * mean;
    let rest: f64 = logs.iter().map(|p| (p.1 - log_c - q * p.0).powi(2)).sum();
    let free = points.len() - 2;
    let deviation = if free > 0 { (rest / free as f64).sqrt() } else { 0.0 };
    let error = (free > 0).then(|| deviation / spread.sqrt());
    let half = error.map(|e| t_quantile(0.95, free) * e);
    Some(PowerLaw { q, half, error, points: points.len(), log_c, mean, spread, deviation })
}

impl PowerLaw {
    /// Restricts the exponent to a range, with the law through the mean of the points in logarithms. The result has no intervals, since these apply to
    /// the free exponent.
    pub fn bounded(self, [least, most]: [f64; 2]) -> Self {
        let q = self.q.clamp(least, most);
        Self { q, log_c: self.log_c + (self.q - q) * self.mean, half: None, error: None, points: 2, ..self }
    }

    /// The law at x.
    pub fn at(&self, x: f64) -> f64 {
        (self.log_c + self.q * x.ln()).exp()
    }

    /// The law at x with the interval of a new observation.
    pub fn predict(&self, x: f64) -> Predicted {
        let value = self.at(x);
        let interval = (self.points > 2).then(|| {
            let away = 1.0 + 1.0 / self.points as f64 + (x.ln() - self.mean).powi(2) / self.spread;
            let factor = (t_quantile(0.95, self.points - 2) * self.deviation * away.sqrt()).exp();
            [value / factor, value * factor]
        });
        Predicted { value, interval }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_gives_its_exponent_back() {
        let points: Vec<(f64, f64)> = [1e3, 4e3, 2e4].iter().map(|n: &f64| (*n, 3e-6 * n.powf(1.4))).collect();
        let g = power_law(&points).expect("three sizes");
        // Rounding of a few logarithms
        assert!((g.q - 1.4).abs() < 1e-12 && g.error.expect("three points") < 1e-12, "{}", g.q);
        assert!((g.predict(1e5).value / (3e-6 * 1e5f64.powf(1.4)) - 1.0).abs() < 1e-11);
        assert!(power_law(&points[..1]).is_none() && power_law(&[points[0], points[0]]).is_none());
        assert!(power_law(&[(1.0, 0.0), (2.0, 1.0)]).is_none(), "no logarithm of nothing");
    }

    /// Noise of 20 % between sizes 825 and 850 gives an exponent of 6; the law through their mean, 837.4, has the exponent of the bound.
    #[test]
    fn an_exponent_within_bounds_keeps_the_mean_of_the_points() {
        let steep = power_law(&[(825.0, 1.0), (850.0, 1.2)]).expect("two sizes").bounded([1.0, 2.0]);
        let [x, y] = [(825.0f64 * 850.0).sqrt(), 1.2f64.sqrt()];
        assert!((steep.q - 2.0).abs() < 1e-15 && (steep.at(10.0 * x) / (100.0 * y) - 1.0).abs() < 1e-12, "{steep:?}");
        let free = power_law(&[(1e3, 1.0), (1e4, 30.0)]).expect("two sizes");
        assert_eq!(free.clone().bounded([1.0, 2.0]).at(5e3), free.at(5e3));
    }

    /// ln x = −1, 0, 1 and ln y = 0, 3, 0: slope 0, mean 1, residuals −1, 2, −1, so s² = 6 with one degree of freedom, t = 12.7062.
    #[test]
    fn the_interval_is_that_of_a_regression_by_hand() {
        let e = std::f64::consts::E;
        let g = power_law(&[(1.0 / e, 1.0), (1.0, e.powi(3)), (e, 1.0)]).expect("three points");
        let t = (0.475 * std::f64::consts::PI).tan();
        assert!(g.q.abs() < 1e-14 && (g.half.expect("three points") - t * 3f64.sqrt()).abs() < 1e-10);
        let p = g.predict(1.0);
        let high = p.interval.expect("three points")[1];
        assert!(((high / p.value).ln() - t * 6f64.sqrt() * (4.0f64 / 3.0).sqrt()).abs() < 1e-9, "{p:?}");
    }
}
