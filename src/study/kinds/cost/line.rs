//! The error of one family as a function of its cost, and the cost of an error: interpolated between the cases, extrapolated beyond them.
//!
//! The cost of an error is the cost from which on every case of the family is within the error. Between two cases ln c is linear in ln e. Below the
//! error of the most expensive case the law e ∝ c^−s is fitted to all cases ([`power_law`](mod@crate::study::estimate::power_law), c over e) with its
//! 95 % interval, no part of which lies below the cost of a case that misses the error; a family whose error does not fall from case to case has no
//! such law.

use crate::study::estimate::power_law::{PowerLaw, power_law};
use serde::Serialize;

/// One family of settings that differ in one respect.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Line {
    pub family: String,
    pub label: String,
    /// Points as (cost \[s\], error \[–\]), cheapest first
    pub points: Vec<(f64, f64)>,
    /// Cost of every level, in their order; `None` if the error of the most expensive case is above the level and no law extrapolates it
    pub costs: Vec<Option<LevelCost>>,
    /// Law of cost over error; `None` with only two points
    #[serde(skip)]
    pub law: Option<PowerLaw>,
}

/// The cost of reaching an error.
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
    /// Even the coarsest case is good enough, as are all others: a still coarser one may be too
    AtMost,
    Between,
    Extrapolated,
}

impl Line {
    /// Builds the line from `points`, (cost, error) of the converged cases, and the error `levels` of interest. `None` with fewer than two points.
    pub fn new(family: &str, label: String, mut points: Vec<(f64, f64)>, levels: &[f64]) -> Option<Self> {
        points.retain(|(c, e)| *c > 0.0 && *e >= 0.0);
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        if points.len() < 2 {
            return None;
        }
        let falls = points.windows(2).all(|w| w[1].1 < w[0].1);
        let reversed: Vec<(f64, f64)> = points.iter().map(|(c, e)| (*e, *c)).collect();
        let law = power_law(&reversed).filter(|g| falls && g.points > 2 && g.q < 0.0);
        let costs = levels.iter().map(|l| cost(&points, law.as_ref(), *l)).collect();
        Some(Self { family: family.into(), label, points, costs, law })
    }
}

/// The cost from which on every case is within a level.
fn cost(points: &[(f64, f64)], law: Option<&PowerLaw>, level: f64) -> Option<LevelCost> {
    let Some(last) = points.iter().rposition(|(_, e)| *e > level) else {
        return Some(LevelCost { seconds: points[0].0, how: How::AtMost, interval: None });
    };
    let (cost, error) = points[last];
    if let Some((next, least)) = points.get(last + 1) {
        // An error of zero has no logarithm: its case is the first that is known to be within the level
        let s = if *least > 0.0 { (error / level).ln() / (error / least).ln() } else { 1.0 };
        let seconds = (cost.ln() * (1.0 - s) + next.ln() * s).exp();
        return Some(LevelCost { seconds, how: How::Between, interval: None });
    }
    // The cost exceeds that of a case that misses the level
    let p = law?.predict(level).at_least(cost);
    Some(LevelCost { seconds: p.value, how: How::Extrapolated, interval: p.interval })
}

impl LevelCost {
    /// Returns the smallest and the largest possible cost \[s\].
    pub fn ends(&self) -> [f64; 2] {
        let least = if self.how == How::AtMost { 0.0 } else { self.seconds };
        self.interval.unwrap_or([least, self.seconds])
    }

    /// Writes the cost as `3.1 s`, `≤ 0.4 s` or `≈ 2 h`.
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

    /// The law of all three cases would reach 4 % at 42 s, with an interval that starts lower; yet the case of 100 s does not reach it.
    #[test]
    fn an_extrapolated_cost_is_above_that_of_a_case_that_misses_the_error() {
        let points = vec![(1.0, 0.5), (10.0, 0.05), (100.0, 0.045)];
        let cost = Line::new("f", "f".into(), points, &[0.04]).expect("three points").costs[0].expect("errors fall");
        let [low, high] = cost.interval.expect("three points");
        assert!(cost.seconds == 100.0 && low == 100.0 && high > 1e3, "{cost:?}");
    }

    /// A measured error has a cost, even if the last errors rise by noise or a change of sign; an error that a later case exceeds has no cost, and
    /// nothing is extrapolated.
    #[test]
    fn an_error_that_rises_has_the_costs_that_are_measured() {
        let costs =
            |points: Vec<(f64, f64)>, levels: &[f64]| Line::new("f", "f".into(), points, levels).expect("points").costs;
        let rising = costs(vec![(1.0, 0.2), (2.0, 0.05), (3.0, 0.06)], &[0.3, 0.1, 0.055, 0.01]);
        assert_eq!(rising[0], Some(LevelCost { seconds: 1.0, how: How::AtMost, interval: None }));
        let between = rising[1].expect("all later cases are within");
        assert!((between.seconds - 2f64.sqrt()).abs() < 1e-12 && between.how == How::Between, "{between:?}");
        assert_eq!(rising[2..], [None, None]);
        let two = costs(vec![(1.0, 0.2), (2.0, 0.1)], &[0.01]);
        assert_eq!(two, [None], "two points are no law");
        let noise = costs(vec![(1.0, 3e-9), (2.0, 0.0), (3.0, 8e-9)], &[0.05, 0.005]);
        assert!(noise.iter().all(|cost| cost.is_some_and(|c| c.how == How::AtMost && c.seconds == 1.0)), "{noise:?}");
        let exact = costs(vec![(1.0, 0.2), (2.0, 0.0)], &[0.1])[0].expect("measured");
        assert!((exact.seconds - 2.0).abs() < 1e-12, "{exact:?}");
    }
}
