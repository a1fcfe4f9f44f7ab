//! Rates ds/dt of signals, and whether they jump.

use super::formula::Formula;
use super::signal::{Clock, Known, PLACES, Ramp, Signal};
use std::f64::consts::{PI, TAU};

/// Length of the difference in time for the rate of a formula without a derivative, and for the second derivative of one with a derivative: its least
/// value \[s\], and its share of the time.
const DIFFERENCE: [f64; 2] = [1e-6, 1e-9];
/// Factor on this length for the second derivative of a formula without a first one, whose rounding error grows with the inverse square of the
/// length.
const SECOND: f64 = 100.0;

/// Shortest interval in which a kink of a formula is searched for, in multiples of this length: an eighth of it is still longer than the differences.
const INTERVAL: f64 = 64.0;

/// Number of rates that are compared, and the share of the largest one that counts as zero, well above rounding.
const RATES: u32 = 64;
const NO_RATE: f64 = 1e-6;
/// Rounding error of a rate by differences, in units of ε times the value over the length of the difference: about 8 from each side.
const ROUNDING: f64 = 16.0;

/// Distance by which rounding may separate a point of the time grid from the corner at which it lies \[s\].
fn slack(t: f64) -> f64 {
    PLACES * f64::EPSILON * t.abs()
}

/// Side of a time on which a rate that jumps is evaluated, with the rounding of that time \[s\].
#[derive(Clone, Copy, Debug, PartialEq)]
enum Side {
    Before(f64),
    After(f64),
}

impl Side {
    /// Whether the corner lies before `t` as seen from this side.
    fn is_past(self, t: f64, corner: f64) -> bool {
        match self {
            Self::Before(slack) => t > corner + slack,
            Self::After(slack) => t >= corner - slack,
        }
    }

    /// A step of this length towards this side.
    fn step(self, length: f64) -> f64 {
        match self {
            Self::Before(_) => -length,
            Self::After(_) => length,
        }
    }
}

/// s, ds/dt and d²s/dt² of a product.
fn product([a, da, dda]: [f64; 3], [b, db, ddb]: [f64; 3]) -> [f64; 3] {
    [a * b, da * b + a * db, dda * b + 2.0 * da * db + a * ddb]
}

impl Signal {
    /// ds/dt; where it jumps, its value from this time on.
    pub fn rate(&self, now: Clock) -> f64 {
        self.motion(now, Side::After(slack(now.t)))[1]
    }

    /// ds/dt; where it jumps, its value until this time.
    pub fn rate_before(&self, now: Clock) -> f64 {
        self.motion(now, Side::Before(slack(now.t)))[1]
    }

    /// d²s/dt²; where it jumps, its value from this time on.
    pub fn acceleration(&self, now: Clock) -> f64 {
        self.motion(now, Side::After(slack(now.t)))[2]
    }

    /// s, ds/dt and d²s/dt² on one side of a time.
    fn motion(&self, now: Clock, side: Side) -> [f64; 3] {
        let t = now.t;
        let past = |corner: f64| side.is_past(t, corner);
        let linear = |rate: f64| [self.at(now), rate, 0.0];
        let decided = |ramp: &Ramp| {
            let changes = past(ramp.start) && !past(ramp.end);
            linear(if changes { (ramp.to - ramp.from) / (ramp.end - ramp.start) } else { 0.0 })
        };
        match self {
            Self::Constant(_) => linear(0.0),
            Self::RaisedCosine { amplitude, frequency } => {
                let (w, (sin, cos)) = (TAU * frequency, (TAU * frequency * t).sin_cos());
                [self.at(now), amplitude * PI * frequency * sin, amplitude * PI * frequency * w * cos]
            }
            Self::Sine { amplitude, frequency, phase } => {
                let (w, (sin, cos)) = (TAU * frequency, (TAU * frequency * t + phase).sin_cos());
                [self.at(now), amplitude * w * cos, -amplitude * w * w * sin]
            }
            Self::Ramp { from, to, start, end } if past(*start) && !past(*end) => linear((to - from) / (end - start)),
            Self::Ramp { .. } => linear(0.0),
            Self::Hold { signal, at } if !past(*at) => signal.motion(now, side),
            Self::Delay { signal, by } if past(*by) => signal.motion(Clock { t: t - by, ..now }, side),
            Self::Hold { .. } | Self::Delay { .. } => linear(0.0),
            Self::Table(rows) => {
                let above = rows.partition_point(|row| past(row.0));
                match (above.checked_sub(1).map(|k| rows[k]), rows.get(above)) {
                    (Some(a), Some(b)) => linear((b.1 - a.1) / (b.0 - a.0)),
                    _ => linear(0.0),
                }
            }
            Self::Continued { before, from, .. } if !past(*from) => linear(*before),
            Self::Continued { after, to, .. } if past(*to) => linear(*after),
            Self::Continued { signal, .. } => signal.motion(now, side),
            Self::Product(factors) => factors.iter().map(|s| s.motion(now, side)).fold([1.0, 0.0, 0.0], product),
            Self::Sum(terms) => {
                let add = |[a, b, c]: [f64; 3], [x, y, z]: [f64; 3]| [a + x, b + y, c + z];
                terms.iter().map(|s| s.motion(now, side)).fold([0.0; 3], add)
            }
            Self::Turn { angle, cosine, sine } => {
                let [angle, rate, acceleration] = angle.motion(now, side);
                let (sin, cos) = angle.sin_cos();
                let (along, inwards) = (sine * cos - cosine * sin, -sine * sin - cosine * cos);
                [self.at(now), along * rate, inwards * rate * rate + along * acceleration]
            }
            Self::Formula(formula) => {
                let [rate, acceleration] = of_formula(formula, t, side);
                [self.at(now), rate, acceleration]
            }
            Self::Input(k) => match now.inputs.get(*k) {
                Some(Known::Ramp(ramp)) => decided(ramp),
                _ => linear(0.0),
            },
            Self::Switched { input, signals } => match now.known(*input) {
                Known::Ramp(ramp) => decided(&ramp),
                Known::Follows { signal, since } => signals[signal].motion(Clock { t: t - since, ..now }, side),
            },
        }
    }

    /// The latest time \[s\] at which a ramp ends or a table stops changing; `None` if the signal has neither.
    pub fn last_change(&self) -> Option<f64> {
        match self {
            Self::Ramp { from, to, end, .. } => (from != to).then_some(*end),
            Self::Table(rows) => rows.windows(2).rfind(|pair| pair[0].1 != pair[1].1).map(|pair| pair[1].0),
            Self::Product(all) | Self::Sum(all) => all.iter().filter_map(Self::last_change).reduce(f64::max),
            Self::Delay { signal, by } => signal.last_change().map(|end| end + by),
            _ => None,
        }
    }

    /// Whether the rate at time `from` is nonzero compared with the largest one until time `to`.
    pub fn moves_at(&self, from: f64, to: f64) -> bool {
        self.rate(Clock::from(from)).abs() > NO_RATE * self.largest_rate(from, to)
    }

    /// Whether the rate jumps at time `from`, compared with the largest one until time `to`.
    pub fn jumps_at(&self, from: f64, to: f64) -> bool {
        let before = self.rate_before(Clock::from(from)).abs();
        self.jump(from) > self.rounding(from).max(NO_RATE * self.largest_rate(from, to).max(before))
    }

    /// The jump of the rate at a time.
    fn jump(&self, t: f64) -> f64 {
        let now = Clock::from(t);
        (self.rate(now) - self.rate_before(now)).abs()
    }

    /// An upper bound of the rounding error of rates by differences.
    fn rounding(&self, t: f64) -> f64 {
        ROUNDING * f64::EPSILON * self.at(Clock::from(t)).abs() / difference(t)
    }

    /// The largest rate strictly between two times.
    fn largest_rate(&self, from: f64, to: f64) -> f64 {
        let rate = |k: u32| self.rate(Clock::from(from + f64::from(k) / f64::from(RATES + 1) * (to - from))).abs();
        (1..=RATES).map(rate).fold(0.0, f64::max)
    }

    /// Whether the rate may jump strictly between two times, beyond their rounding. Inputs never count as smooth; formulas do if no kink is found.
    pub fn has_corner(&self, from: f64, to: f64) -> bool {
        self.has_corner_between(from + slack(from), to - slack(to))
    }

    fn has_corner_between(&self, from: f64, to: f64) -> bool {
        let inside = |t: f64| from < t && t < to;
        match self {
            Self::Constant(_) | Self::RaisedCosine { .. } | Self::Sine { .. } => false,
            Self::Formula(formula) => has_kink(formula, from, to),
            Self::Ramp { from: low, to: high, start, end } => low != high && (inside(*start) || inside(*end)),
            Self::Hold { signal, at } => inside(*at) || signal.has_corner_between(from, to.min(*at)),
            Self::Delay { signal, by } => inside(*by) || signal.has_corner_between(from - by, to - by),
            Self::Table(rows) => rows.iter().any(|row| inside(row.0)) && rows.iter().any(|row| row.1 != rows[0].1),
            Self::Continued { signal, from: first, to: last, .. } => {
                inside(*first) || inside(*last) || signal.has_corner_between(from, to)
            }
            Self::Product(all) | Self::Sum(all) => all.iter().any(|s| s.has_corner_between(from, to)),
            Self::Turn { angle, .. } => angle.has_corner_between(from, to),
            Self::Input(_) | Self::Switched { .. } => true,
        }
    }
}

/// Length of the differences for the rates of a formula \[s\].
fn difference(t: f64) -> f64 {
    DIFFERENCE[0].max(DIFFERENCE[1] * t.abs())
}

/// Whether the rate of a formula jumps strictly between two times. The deviation of the secant of an interval from the rates at its ends decreases
/// with the length of the interval where the formula is smooth, but not where it has a kink. Each of several intervals is halved repeatedly towards
/// the largest deviation.
fn has_kink(formula: &Formula, from: f64, to: f64) -> bool {
    let shortest = INTERVAL * difference(to);
    if to - from < 2.0 * shortest || formula.rate(0.5 * (from + to)).is_some() {
        return false;
    }
    let bend = |[a, b]: [f64; 2]| {
        let secant = (formula.at(b) - formula.at(a)) / (b - a);
        let [after, before] =
            [(a, Side::After(0.0)), (b, Side::Before(0.0))].map(|(t, side)| of_formula(formula, t, side)[0]);
        (secant - after).abs().max((secant - before).abs())
    };
    let sharper = |[a, b]: [f64; 2]| {
        let middle = 0.5 * (a + b);
        let halves = [[a, middle], [middle, b]];
        if bend(halves[0]) >= bend(halves[1]) { halves[0] } else { halves[1] }
    };
    let count = ((to - from) / (2.0 * shortest)).min(f64::from(RATES)) as u32;
    let point = |k: u32| from + f64::from(k) / f64::from(count) * (to - from);
    let signal = Signal::Formula(formula.clone());
    let least = NO_RATE * signal.largest_rate(from, to);
    let is_sharp = |t: f64, sharp: f64| sharp > least.max(signal.rounding(t));
    let within = (0..count).any(|k| {
        let mut interval = [point(k), point(k + 1)];
        while interval[1] - interval[0] > 2.0 * shortest {
            interval = sharper(interval);
        }
        let short = sharper(sharper(sharper(interval)));
        is_sharp(short[0], bend(short)) && bend(short) > 0.25 * bend(interval)
    });
    within || (1..count).map(point).any(|t| is_sharp(t, signal.jump(t)))
}

/// ds/dt and d²s/dt² of a formula on one side of a time.
fn of_formula(formula: &Formula, t: f64, side: Side) -> [f64; 2] {
    let step = side.step(difference(t));
    // Differences are taken from the value itself, so that they are exactly zero where nothing changes
    let first = |[now, next, last]: [f64; 3]| (4.0 * (next - now) - (last - now)) / (2.0 * step);
    let places = [0.0, 1.0, 2.0].map(|k| t + k * step);
    if let [Some(now), Some(next), Some(last)] = places.map(|t| formula.rate(t)) {
        return [now, first([now, next, last])];
    }
    let long = SECOND * step;
    let [now, one, two, three] = [0.0, 1.0, 2.0, 3.0].map(|k| formula.at(t + k * long));
    let second = (4.0 * (two - now) - 5.0 * (one - now) - (three - now)) / (long * long);
    [formula.rate(t).unwrap_or_else(|| first(places.map(|t| formula.at(t)))), second]
}

#[cfg(test)]
mod tests {
    use super::super::formula::Formula;
    use super::*;

    /// Second-order differences at times without a corner, and the rate after each corner.
    #[test]
    fn rates_are_the_derivatives() {
        let ramp = Signal::Ramp { from: 1.0, to: 3.0, start: 1.0, end: 2.0 };
        let sine = Signal::Sine { amplitude: 0.5, frequency: 0.3, phase: 0.2 };
        let signals = vec![Signal::Constant(0.0), ramp.clone()];
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
            Signal::Switched { input: 0, signals: signals.clone() },
            Signal::Switched { input: 1, signals },
            sine,
            ramp,
        ];
        let inputs =
            [Known::Ramp(Ramp { start: 1.0, from: 4.0, end: 2.0, to: 8.0 }), Known::Follows { signal: 1, since: 0.8 }];
        for signal in &all {
            let at = |t: f64| Clock { t, inputs: &inputs };
            for t in [0.3, 1.2, 1.7, 2.6] {
                let step = 1e-5;
                let difference = (signal.at(at(t + step)) - signal.at(at(t - step))) / (2.0 * step);
                assert!((signal.rate(at(t)) - difference).abs() < 1e-6, "{signal:?} at {t}");
                assert_eq!(signal.rate(at(t)), signal.rate_before(at(t)), "{signal:?} at {t}");
                let difference = (signal.rate(at(t + step)) - signal.rate(at(t - step))) / (2.0 * step);
                assert!((signal.acceleration(at(t)) - difference).abs() < 1e-5, "{signal:?} at {t}");
            }
            for corner in [0.8, 1.0, 1.5, 1.6, 1.8, 2.0] {
                assert!(
                    (signal.rate(at(corner)) - signal.rate(at(corner + 1e-9))).abs() < 1e-6,
                    "{signal:?} at {corner}"
                );
                let before = signal.rate(at(corner - 1e-9));
                assert!((signal.rate_before(at(corner)) - before).abs() < 1e-6, "{signal:?} before {corner}");
                let after = signal.acceleration(at(corner + 1e-9));
                assert!((signal.acceleration(at(corner)) - after).abs() < 1e-5, "{signal:?} after {corner}");
            }
        }
    }

    /// With a kink there is no derivative in closed form, and one-sided differences do not see the other side.
    #[test]
    fn kinks_of_formulas_have_rates_on_both_sides() {
        let signal = Signal::Formula(Formula::new("3 * max(t - 1, 0)^2 + max(t - 1, 0)", 1.0).expect("a formula"));
        let now = Clock::from(1.0);
        for (found, exact) in [(signal.rate_before(now), 0.0), (signal.rate(now), 1.0), (signal.acceleration(now), 6.0)]
        {
            assert!((found - exact).abs() < 1e-6, "{found} in place of {exact}");
        }
        assert!(signal.jumps_at(1.0, 2.0) && !signal.jumps_at(0.5, 0.9) && !signal.jumps_at(1.5, 2.0));
    }

    /// A stage of 0.1 s and one of 0.2 s end 5e-17 s after 0.3 s.
    #[test]
    fn the_rounding_of_a_point_of_the_grid_decides_about_no_corner() {
        let (point, corner) = (0.1 + 0.2, 0.3);
        assert!(point > corner);
        let ramp = |start: f64, end: f64| Signal::Ramp { from: 0.0, to: 2.0, start, end };
        let late = Signal::Delay { signal: Box::new(ramp(0.1, 0.2)), by: 0.2 };
        for (falls, rises, at) in [(ramp(0.2, corner), ramp(corner, 0.4), point), (ramp(0.2, point), late, corner)] {
            let rates =
                [&falls, &rises].map(|s| [s.rate_before(Clock::from(at)), s.rate(Clock::from(at))].map(f64::round));
            assert_eq!(rates, [[20.0, 0.0], [0.0, 20.0]], "at {at}");
            assert!(falls.jumps_at(at, 0.4) && !falls.has_corner(0.25, at) && !rises.has_corner(at, 0.35), "at {at}");
        }
        assert!(ramp(0.0, corner).has_corner(0.0, corner + 1e-12));
    }

    #[test]
    fn rounding_is_no_rate() {
        let whole = Signal::RaisedCosine { amplitude: 0.25, frequency: 1.0 };
        assert!(whole.rate(Clock::from(1.0)) != 0.0 && !whole.moves_at(1.0, 2.0) && whole.moves_at(1.1, 2.0));
        let ramp = Signal::Ramp { from: 0.0, to: 1.0, start: 0.0, end: 2.0 };
        assert_eq!((ramp.last_change(), whole.last_change()), (Some(2.0), None));
        let table = Signal::Table(vec![(0.0, 1.0), (2.0, 3.0), (4.0, 3.0)]);
        assert_eq!(table.last_change(), Some(2.0));
        assert!(
            [0.0, 2.0].iter().all(|t| ramp.jumps_at(*t, t + 1.0))
                && !ramp.jumps_at(1.0, 3.0)
                && !whole.jumps_at(1.0, 2.0)
        );
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
        let formula = |text: &str| Signal::Formula(Formula::new(text, 1.0).expect("a formula"));
        for kinked in ["10 * max(t - 1.7, 0)", "abs(t - 1.7)", "sin(3 * t) + 0.2 * min(t, 1.7)", "3 * max(t, 1.7)^2"] {
            assert_eq!(corners(&formula(kinked)), [false, true, true, false, false], "{kinked}");
        }
        for smooth in [
            "sin(30 * t)",
            "abs(5 + sin(30 * t))",
            "max(t - 1.7, 0)^3",
            "max(t^2, -1)",
            "max(0.3, 0.4)",
            // Held from the middle on by smooth steps, at values whose multiples are rounded; a slow motion far from zero; a pulse
            "0.4 * min(t / 1.7, 1)^2 * (3 - 2 * min(t / 1.7, 1))",
            "0.001 * (1 - cos(PI * min(t / 1.7, 1)))",
            "max(50, 0) + 0.01 * t",
            "max(exp(-((t - 1.7) / 0.02)^2), -1)",
        ] {
            let signal = formula(smooth);
            assert_eq!(corners(&signal), [false; 5], "{smooth}");
            assert!([1.0, 2.0, 3.0].iter().all(|t| !signal.jumps_at(*t, 4.0)), "{smooth}");
        }
        let held = formula("0.4 * min(t / 1.7, 1)^2");
        assert!(!held.moves_at(2.0, 3.0) && held.moves_at(1.0, 2.0));
    }
}
