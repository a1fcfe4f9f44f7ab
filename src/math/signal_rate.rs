//! Rates ds/dt of signals, and whether they jump.

use super::signal::{Clock, Signal};
use std::f64::consts::{PI, TAU};

/// Distance in time for the rate of a formula without a derivative: at least so long \[s\], and so much of the time.
const DIFFERENCE: [f64; 2] = [1e-6, 1e-9];

/// Rates that are compared, and the share of the largest one that is none, well above rounding.
const RATES: u32 = 64;
const NO_RATE: f64 = 1e-6;

impl Signal {
    /// ds/dt from this time on, where the rate jumps.
    pub fn rate(&self, now: Clock) -> f64 {
        let t = now.t;
        let earlier = |t: f64| Clock { t, ..now };
        match self {
            Self::Constant(_) => 0.0,
            Self::RaisedCosine { amplitude, frequency } => amplitude * PI * frequency * (TAU * frequency * t).sin(),
            Self::Sine { amplitude, frequency, phase } => {
                amplitude * TAU * frequency * (TAU * frequency * t + phase).cos()
            }
            Self::Ramp { from, to, start, end } if (*start..*end).contains(&t) => (to - from) / (end - start),
            Self::Ramp { .. } => 0.0,
            Self::Hold { signal, at } if t < *at => signal.rate(now),
            Self::Delay { signal, by } if t >= *by => signal.rate(earlier(t - by)),
            Self::Hold { .. } | Self::Delay { .. } => 0.0,
            Self::Table(rows) => {
                let above = rows.partition_point(|row| row.0 <= t);
                match (above.checked_sub(1).map(|k| rows[k]), rows.get(above)) {
                    (Some(a), Some(b)) => (b.1 - a.1) / (b.0 - a.0),
                    _ => 0.0,
                }
            }
            Self::Continued { before, from, .. } if t < *from => *before,
            Self::Continued { after, to, .. } if t >= *to => *after,
            Self::Continued { signal, .. } => signal.rate(now),
            Self::Product(factors) => {
                let others = |k: usize| factors.iter().enumerate().filter(move |(other, _)| *other != k);
                let term = |(k, s): (usize, &Self)| s.rate(now) * others(k).map(|(_, s)| s.at(now)).product::<f64>();
                factors.iter().enumerate().map(term).sum()
            }
            Self::Sum(terms) => terms.iter().map(|s| s.rate(now)).sum(),
            Self::Turn { angle, cosine, sine } => {
                let (sin, cos) = angle.at(now).sin_cos();
                (sine * cos - cosine * sin) * angle.rate(now)
            }
            Self::Formula(formula) => formula.rate(t).unwrap_or_else(|| {
                let step = DIFFERENCE[0].max(DIFFERENCE[1] * t.abs());
                let [now, next, last] = [0.0, 1.0, 2.0].map(|k| formula.at(t + k * step));
                (4.0 * next - 3.0 * now - last) / (2.0 * step)
            }),
            Self::Input(k) => {
                let ramp = now.inputs.get(*k).filter(|ramp| (ramp.start..ramp.end).contains(&t));
                ramp.map_or(0.0, |ramp| (ramp.to - ramp.from) / (ramp.end - ramp.start))
            }
        }
    }

    /// The latest time at which a ramp of it ends, or at which a table has another value than before \[s\].
    pub fn last_change(&self) -> Option<f64> {
        match self {
            Self::Ramp { from, to, end, .. } => (from != to).then_some(*end),
            Self::Table(rows) => rows.windows(2).rfind(|pair| pair[0].1 != pair[1].1).map(|pair| pair[1].0),
            Self::Product(all) | Self::Sum(all) => all.iter().filter_map(Self::last_change).reduce(f64::max),
            Self::Delay { signal, by } => signal.last_change().map(|end| end + by),
            _ => None,
        }
    }

    /// Whether there is a rate at a time, against the largest one from then until another time.
    pub fn moves_at(&self, from: f64, to: f64) -> bool {
        let rate = |share: f64| self.rate(Clock::from(from + share * (to - from))).abs();
        let largest = (1..=RATES).map(|k| rate(f64::from(k) / f64::from(RATES + 1))).fold(0.0, f64::max);
        rate(0.0) > NO_RATE * largest
    }

    /// Whether the rate may jump between two times, these not included. Formulas are taken for smooth, inputs for not.
    pub fn has_corner(&self, from: f64, to: f64) -> bool {
        let inside = |t: f64| from < t && t < to;
        match self {
            Self::Constant(_) | Self::RaisedCosine { .. } | Self::Sine { .. } | Self::Formula(_) => false,
            Self::Ramp { from: low, to: high, start, end } => low != high && (inside(*start) || inside(*end)),
            Self::Hold { signal, at } => inside(*at) || signal.has_corner(from, to.min(*at)),
            Self::Delay { signal, by } => inside(*by) || signal.has_corner(from - by, to - by),
            Self::Table(rows) => rows.iter().any(|row| inside(row.0)) && rows.iter().any(|row| row.1 != rows[0].1),
            Self::Continued { signal, from: first, to: last, .. } => {
                inside(*first) || inside(*last) || signal.has_corner(from, to)
            }
            Self::Product(all) | Self::Sum(all) => all.iter().any(|s| s.has_corner(from, to)),
            Self::Turn { angle, .. } => angle.has_corner(from, to),
            Self::Input(_) => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::formula::Formula;
    use super::super::signal::Ramp;
    use super::*;

    /// Differences of second order at times without a corner, and the rate after each corner.
    #[test]
    fn rates_are_the_derivatives() {
        let ramp = Signal::Ramp { from: 1.0, to: 3.0, start: 1.0, end: 2.0 };
        let sine = Signal::Sine { amplitude: 0.5, frequency: 0.3, phase: 0.2 };
        let all = [
            Signal::Constant(2.0),
            Signal::RaisedCosine { amplitude: 2.0, frequency: 0.7 },
            Signal::Hold { signal: Box::new(sine.clone()), at: 1.6 },
            Signal::Delay { signal: Box::new(sine.clone()), by: 0.8 },
            Signal::Table(vec![(0.0, 1.0), (1.0, 5.0), (1.8, 4.0)]),
            Signal::Continued { signal: Box::new(sine.clone()), from: 1.0, to: 1.5, before: 4.0, after: -2.0 },
            Signal::Turn { angle: Box::new(sine.clone()), cosine: 3.0, sine: 5.0 },
            Signal::Formula(Formula::new("sin(3 * t) + t ^ 2", 1.0).expect("a formula")),
            Signal::Sum(vec![sine.clone(), Signal::Product(vec![sine.clone(), ramp.clone(), Signal::Input(0)])]),
            sine,
            ramp,
        ];
        let inputs = [Ramp { start: 1.0, from: 4.0, end: 2.0, to: 8.0 }];
        for signal in &all {
            let at = |t: f64| Clock { t, inputs: &inputs };
            for t in [0.3, 1.2, 1.7, 2.6] {
                let step = 1e-5;
                let difference = (signal.at(at(t + step)) - signal.at(at(t - step))) / (2.0 * step);
                assert!((signal.rate(at(t)) - difference).abs() < 1e-6, "{signal:?} at {t}");
            }
            for corner in [0.8, 1.0, 1.5, 1.6, 1.8, 2.0] {
                assert!(
                    (signal.rate(at(corner)) - signal.rate(at(corner + 1e-9))).abs() < 1e-6,
                    "{signal:?} at {corner}"
                );
            }
        }
    }

    #[test]
    fn rounding_is_no_rate() {
        let whole = Signal::RaisedCosine { amplitude: 0.25, frequency: 1.0 };
        assert!(whole.rate(Clock::from(1.0)) != 0.0 && !whole.moves_at(1.0, 2.0) && whole.moves_at(1.1, 2.0));
        let ramp = Signal::Ramp { from: 0.0, to: 1.0, start: 0.0, end: 2.0 };
        assert_eq!((ramp.last_change(), whole.last_change()), (Some(2.0), None));
        let table = Signal::Table(vec![(0.0, 1.0), (2.0, 3.0), (4.0, 3.0)]);
        assert_eq!(table.last_change(), Some(2.0));
        assert!(ramp.moves_at(1.0, 2.0) && !ramp.moves_at(2.0, 3.0) && !Signal::Constant(1.0).moves_at(0.0, 1.0));
    }

    #[test]
    fn corners_are_found() {
        let ramp = Signal::Ramp { from: 0.0, to: 1.0, start: 0.0, end: 2.0 };
        let hold =
            Signal::Hold { signal: Box::new(Signal::Sine { amplitude: 1.0, frequency: 1.0, phase: 0.0 }), at: 3.0 };
        let corners = |signal: &Signal| {
            [(0.0, 1.0), (1.0, 2.0), (1.0, 2.5), (2.5, 4.0), (3.0, 4.0)].map(|(a, b)| signal.has_corner(a, b))
        };
        assert_eq!(corners(&ramp), [false, false, true, false, false]);
        assert_eq!(corners(&hold), [false, false, false, true, false]);
        assert_eq!(corners(&Signal::Table(vec![(1.5, 0.0), (9.0, 1.0)])), [false, true, true, false, false]);
        assert_eq!(corners(&Signal::Table(vec![(1.5, 1.0), (9.0, 1.0)])), [false; 5]);
        assert_eq!(corners(&Signal::Product(vec![Signal::Constant(1.0), Signal::Input(0)])), [true; 5]);
    }
}
