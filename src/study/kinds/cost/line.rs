//! The error of one family over its cost, and the cost of an error: read off between the cases, extrapolated beyond.
//!
//! Between two cases ln c is linear in ln e. Below the least error the law e ∝ c^−s is fitted to all cases of the family
//! ([`crate::study::estimate::growth`], c over e) with its 95 % interval. A family whose error does not fall with its cost has no line.

use crate::study::estimate::growth::{Growth, growth};
use serde::Serialize;

/// One family of settings that differ in one thing.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Line {
    pub family: String,
    pub label: String,
    /// (cost \[s\], error \[–\]) cheapest first
    pub points: Vec<(f64, f64)>,
    /// Cost of every level, in their order; none where the errors do not fall
    pub costs: Vec<Option<LevelCost>>,
    /// Cost over error; none with two points
    #[serde(skip)]
    pub law: Option<Growth>,
}

/// Cost of an error.
#[derive(Serialize, Clone, Copy, Debug, PartialEq)]
pub struct LevelCost {
    pub seconds: f64,
    pub how: How,
    /// 95 % interval of an extrapolation \[s\]
    pub interval: Option<[f64; 2]>,
}

#[derive(Serialize, Clone, Copy, Debug, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum How {
    /// The coarsest case is good enough: a coarser one may be too
    AtMost,
    Between,
    Extrapolated,
}

impl Line {
    /// `points`: (cost, error) of the converged cases; `levels`: errors asked for. `None` with fewer than two points.
    pub fn new(family: &str, label: String, mut points: Vec<(f64, f64)>, levels: &[f64]) -> Option<Self> {
        points.retain(|(c, e)| *c > 0.0 && *e > 0.0);
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        if points.len() < 2 {
            return None;
        }
        let falls = points.windows(2).all(|w| w[1].1 < w[0].1);
        let reversed: Vec<(f64, f64)> = points.iter().map(|(c, e)| (*e, *c)).collect();
        let law = growth(&reversed).filter(|g| falls && g.points > 2 && g.q < 0.0);
        let costs = levels.iter().map(|l| cost(&points, law.as_ref(), *l).filter(|_| falls)).collect();
        Some(Self { family: family.into(), label, points, costs, law })
    }
}

fn cost(points: &[(f64, f64)], law: Option<&Growth>, level: f64) -> Option<LevelCost> {
    let (cheap, e) = points[0];
    if e <= level {
        return Some(LevelCost { seconds: cheap, how: How::AtMost, interval: None });
    }
    if let Some(w) = points.windows(2).find(|w| w[1].1 <= level) {
        let s = (w[0].1 / level).ln() / (w[0].1 / w[1].1).ln();
        let seconds = (w[0].0.ln() * (1.0 - s) + w[1].0.ln() * s).exp();
        return Some(LevelCost { seconds, how: How::Between, interval: None });
    }
    let p = law?.predict(level);
    Some(LevelCost { seconds: p.value, how: How::Extrapolated, interval: p.interval })
}

impl LevelCost {
    /// The least and the largest that it may be \[s\].
    pub fn ends(&self) -> [f64; 2] {
        let least = if self.how == How::AtMost { 0.0 } else { self.seconds };
        self.interval.unwrap_or([least, self.seconds])
    }

    /// `3.1 s`, `≤ 0.4 s`, `≈ 2 h`
    pub fn words(&self) -> String {
        let sign = match self.how {
            How::AtMost => "≤ ",
            How::Between => "",
            How::Extrapolated => "≈ ",
        };
        format!("{sign}{}", crate::report::numbers::seconds(self.seconds))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// e = 0.3 c^−½: between the cases and beyond them c = (0.3/e)² is exact, and the interval has no width.
    #[test]
    fn a_power_law_has_its_costs() {
        let points: Vec<(f64, f64)> = [1.0, 4.0, 9.0, 30.0].iter().map(|c: &f64| (*c, 0.3 / c.sqrt())).collect();
        let line = Line::new("f", "f".into(), points, &[0.5, 0.2, 0.01]).expect("four points");
        let cost = |k: usize| line.costs[k].expect("errors fall");
        assert_eq!((cost(0).seconds, cost(0).how), (1.0, How::AtMost));
        assert!((cost(1).seconds / 2.25 - 1.0).abs() < 1e-12 && cost(1).how == How::Between);
        assert!((cost(2).seconds / 900.0 - 1.0).abs() < 1e-9 && cost(2).how == How::Extrapolated);
        let [low, high] = cost(2).interval.expect("four points");
        assert!(high / low - 1.0 < 1e-5, "{low} to {high}");
    }

    #[test]
    fn an_error_that_rises_has_no_cost() {
        let line = Line::new("f", "f".into(), vec![(1.0, 0.2), (2.0, 0.05), (3.0, 0.06)], &[0.1]).expect("points");
        assert_eq!(line.costs, [None]);
        let two = Line::new("f", "f".into(), vec![(1.0, 0.2), (2.0, 0.1)], &[0.01]).expect("points");
        assert_eq!(two.costs, [None], "two points are no law");
    }
}
