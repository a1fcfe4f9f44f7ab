//! Prescribed functions of time s(t), and their rates.

use super::formula::Formula;
use std::f64::consts::TAU;

/// Rounding of points of the time grid, sums of durations and steps, in units of the last place of their time.
pub const PLACES: f64 = 8.0;

/// Linear from (start, from) to (end, to), constant outside: a signal known at two points of the time grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    pub start: f64,
    pub from: f64,
    pub end: f64,
    pub to: f64,
}

impl Ramp {
    pub fn at(&self, t: f64) -> f64 {
        if t >= self.end {
            return self.to;
        }
        let s = ((t - self.start) / (self.end - self.start)).max(0.0);
        self.from + s * (self.to - self.from)
    }
}

/// An input as known until the next point of the time grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Known {
    /// A value that an event, a controller or a recording has set
    Ramp(Ramp),
    /// The signal with this index of a switched signal, whose time counts from `since`
    Follows { signal: usize, since: f64 },
}

impl Known {
    /// The value `value` at all times.
    pub fn constant(value: f64) -> Self {
        Self::Ramp(Ramp { start: 0.0, from: value, end: 0.0, to: value })
    }
}

/// A time, and the inputs as known at it.
#[derive(Clone, Copy, Debug)]
pub struct Clock<'a> {
    pub t: f64,
    pub inputs: &'a [Known],
}

impl Clock<'_> {
    /// The input of a switched signal as it is known: it follows the first one where nothing is said.
    pub(super) fn known(&self, input: usize) -> Known {
        self.inputs.get(input).copied().unwrap_or(Known::Follows { signal: 0, since: 0.0 })
    }
}

/// A time without inputs.
impl From<f64> for Clock<'_> {
    fn from(t: f64) -> Self {
        Self { t, inputs: &[] }
    }
}

/// A function of time. Its value has the unit of the quantity that it drives.
#[derive(Clone, Debug, PartialEq)]
pub enum Signal {
    /// s(t) = value
    Constant(f64),
    /// ½A(1 − cos 2πft): from 0 to A and back, never negative
    RaisedCosine {
        amplitude: f64,
        frequency: f64,
    },
    /// A sin(2πft + φ), φ in radians
    Sine {
        amplitude: f64,
        frequency: f64,
        phase: f64,
    },
    /// Linear from `from` (t ≤ start) to `to` (t ≥ end)
    Ramp {
        from: f64,
        to: f64,
        start: f64,
        end: f64,
    },
    /// The signal until `at`, its value there afterwards
    Hold {
        signal: Box<Signal>,
        at: f64,
    },
    /// s(t − by) after `by`, s(0) before
    Delay {
        signal: Box<Signal>,
        by: f64,
    },
    /// Piecewise linear through (t, s), constant outside; t strictly ascending
    Table(Vec<(f64, f64)>),
    Product(Vec<Signal>),
    /// The signal between two times, continued linearly outside with the slopes `before` and `after` \[1/s\]: for loads of a path whose time runs
    /// beyond its protocol
    Continued {
        signal: Box<Signal>,
        from: f64,
        to: f64,
        before: f64,
        after: f64,
    },
    Sum(Vec<Signal>),
    /// C (cos θ − 1) + S sin θ with θ(t) in radians: the displacement of a point that rotates about an axis
    Turn {
        angle: Box<Signal>,
        cosine: f64,
        sine: f64,
    },
    /// A formula in t
    Formula(Formula),
    /// The input with this index, which controllers or recorded columns set
    Input(usize),
    /// One of these signals, the first before any event; the input of this number says which one, or passes from one to another
    Switched {
        input: usize,
        signals: Vec<Signal>,
    },
}

impl Signal {
    /// The value s(t).
    pub fn at<'a>(&self, now: impl Into<Clock<'a>>) -> f64 {
        self.value(now.into())
    }

    fn value(&self, now: Clock) -> f64 {
        let t = now.t;
        let earlier = |t: f64| Clock { t, ..now };
        match self {
            Self::Constant(value) => *value,
            // ½(1 − cos 2x) = sin²x keeps all digits near the minimum
            Self::RaisedCosine { amplitude, frequency } => amplitude * (0.5 * TAU * frequency * t).sin().powi(2),
            Self::Sine { amplitude, frequency, phase } => amplitude * (TAU * frequency * t + phase).sin(),
            Self::Ramp { from, to, start, end } => {
                let s = ((t - start) / (end - start)).clamp(0.0, 1.0);
                from + s * (to - from)
            }
            Self::Hold { signal, at } => signal.value(earlier(t.min(*at))),
            Self::Delay { signal, by } => signal.value(earlier((t - by).max(0.0))),
            Self::Table(rows) => interpolate(rows, t),
            Self::Continued { signal, from, to, before, after } => {
                let inside = Clock { t: t.clamp(*from, *to), ..now };
                signal.value(inside) + before * (t - from).min(0.0) + after * (t - to).max(0.0)
            }
            Self::Product(factors) => factors.iter().map(|s| s.value(now)).product(),
            Self::Sum(terms) => terms.iter().map(|s| s.value(now)).sum(),
            Self::Turn { angle, cosine, sine } => {
                // 1 − cos θ = 2 sin²(θ/2) keeps all digits of small angles
                let angle = angle.value(now);
                sine * angle.sin() - 2.0 * cosine * (0.5 * angle).sin().powi(2)
            }
            Self::Formula(formula) => formula.at(t),
            Self::Input(k) => match now.inputs.get(*k) {
                Some(Known::Ramp(ramp)) => ramp.at(t),
                _ => 0.0,
            },
            Self::Switched { input, signals } => match now.known(*input) {
                Known::Ramp(ramp) => ramp.at(t),
                Known::Follows { signal, since } => signals[signal].value(earlier(t - since)),
            },
        }
    }
}

impl Signal {
    /// The changes over a step by which the forces at its start and at its end, each weighted by ½, do work. They equal the change of the signal,
    /// except for rotations: there they are taken along the tangents at both ends, because the forces rotate with the motion; with the chord the work
    /// would be too small by the factor cos(Δθ/2) sin(Δθ/2)/(Δθ/2).
    pub fn increments(&self, [start, end]: [Clock; 2]) -> [f64; 2] {
        match self {
            Self::Sum(terms) => terms.iter().fold([0.0; 2], |[a, b], term| {
                let [of_start, of_end] = term.increments([start, end]);
                [a + of_start, b + of_end]
            }),
            Self::Turn { angle, cosine, sine } => {
                let angles = [angle.value(start), angle.value(end)];
                angles.map(|theta| (angles[1] - angles[0]) * (sine * theta.cos() - cosine * theta.sin()))
            }
            _ => [self.value(end) - self.value(start); 2],
        }
    }

    /// Whether the signal is zero at all times, as far as its form shows; formulas and inputs count as nonzero.
    pub fn is_zero(&self) -> bool {
        match self {
            Self::Constant(value) => *value == 0.0,
            Self::RaisedCosine { amplitude, .. } | Self::Sine { amplitude, .. } => *amplitude == 0.0,
            Self::Ramp { from, to, .. } => [*from, *to] == [0.0; 2],
            Self::Hold { signal, .. } | Self::Delay { signal, .. } => signal.is_zero(),
            Self::Table(rows) => rows.iter().all(|row| row.1 == 0.0),
            Self::Product(factors) => factors.iter().any(Self::is_zero),
            Self::Continued { signal, before, after, .. } => [*before, *after] == [0.0; 2] && signal.is_zero(),
            Self::Sum(terms) => terms.iter().all(Self::is_zero),
            Self::Turn { angle, cosine, sine } => [*cosine, *sine] == [0.0; 2] || angle.is_zero(),
            Self::Formula(_) | Self::Input(_) | Self::Switched { .. } => false,
        }
    }

    /// The signals that it may follow and that depend on no input: itself, or those that events switch between.
    pub fn prescribed(&self) -> impl Iterator<Item = &Self> {
        let all = match self {
            Self::Switched { signals, .. } => signals,
            one => std::slice::from_ref(one),
        };
        all.iter().filter(|signal| !signal.has_inputs())
    }

    /// Whether the signal depends on an input, which is set during the run.
    pub fn has_inputs(&self) -> bool {
        self.has_input(&|_| true)
    }

    /// Whether the signal depends on input `k`.
    pub fn reads(&self, k: usize) -> bool {
        self.has_input(&|input| input == k)
    }

    fn has_input(&self, is: &dyn Fn(usize) -> bool) -> bool {
        match self {
            Self::Input(k) => is(*k),
            Self::Hold { signal, .. } | Self::Delay { signal, .. } | Self::Continued { signal, .. } => {
                signal.has_input(is)
            }
            Self::Product(all) | Self::Sum(all) => all.iter().any(|s| s.has_input(is)),
            Self::Turn { angle, .. } => angle.has_input(is),
            Self::Switched { input, signals } => is(*input) || signals.iter().any(|s| s.has_input(is)),
            _ => false,
        }
    }
}

fn interpolate(rows: &[(f64, f64)], t: f64) -> f64 {
    let above = rows.partition_point(|row| row.0 <= t);
    match (above.checked_sub(1).and_then(|k| rows.get(k)), rows.get(above)) {
        (Some(a), Some(b)) => a.1 + (t - a.0) / (b.0 - a.0) * (b.1 - a.1),
        (Some(end), None) | (None, Some(end)) => end.1,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tap that is over before half a second, and a rotation that begins after a second.
    #[test]
    fn what_moves_at_any_time_is_not_zero() {
        let rest = Signal::Constant(0.0);
        let knock = Signal::Table(vec![(0.0, 0.0), (0.05, 8e-3), (0.1, 0.0)]);
        let late = Signal::Ramp { from: 0.0, to: 0.5, start: 1.0, end: 2.0 };
        let turn = |angle: &Signal, sine: f64| Signal::Turn { angle: Box::new(angle.clone()), cosine: 0.0, sine };
        for moves in [knock.clone(), turn(&late, 1.0), Signal::Sum(vec![rest.clone(), knock.clone()]), Signal::Input(0)]
        {
            assert!(!moves.is_zero(), "{moves:?}");
        }
        let none = Signal::Table(vec![(0.0, 0.0), (1.0, 0.0)]);
        let products = Signal::Product(vec![knock, rest.clone()]);
        for stays in [none, turn(&late, 0.0), turn(&rest, 1.0), products, rest] {
            assert!(stays.is_zero(), "{stays:?}");
        }
    }

    #[test]
    fn values_at_marked_times() {
        let cosine = Signal::RaisedCosine { amplitude: 2.0, frequency: 0.5 };
        assert_eq!(cosine.at(0.0), 0.0);
        assert!((cosine.at(1.0) - 2.0).abs() < 1e-15 && (cosine.at(0.5) - 1.0).abs() < 1e-15);
        let ramp = Signal::Ramp { from: 1.0, to: 3.0, start: 1.0, end: 2.0 };
        assert_eq!([ramp.at(0.0), ramp.at(1.5), ramp.at(9.0)], [1.0, 2.0, 3.0]);
        let hold = Signal::Hold { signal: Box::new(ramp.clone()), at: 1.5 };
        assert_eq!([hold.at(1.25), hold.at(9.0)], [1.5, 2.0]);
        let delay = Signal::Delay { signal: Box::new(ramp.clone()), by: 1.0 };
        assert_eq!([delay.at(0.5), delay.at(2.5), delay.at(9.0)], [1.0, 2.0, 3.0]);
        let table = Signal::Table(vec![(0.0, 1.0), (2.0, 5.0)]);
        assert_eq!([table.at(-1.0), table.at(0.5), table.at(2.0), table.at(3.0)], [1.0, 2.0, 5.0, 5.0]);
        let step = Ramp { start: 1.0, from: 4.0, end: 2.0, to: 8.0 };
        let input = Signal::Sum(vec![Signal::Input(0), Signal::Constant(1.0)]);
        let at = |t: f64| input.at(Clock { t, inputs: &[Known::Ramp(step)] });
        assert_eq!([at(0.5), at(1.0), at(1.25), at(2.0), at(3.0)], [5.0, 5.0, 6.0, 9.0, 9.0]);
        assert!(input.has_inputs() && !ramp.has_inputs());
        let switched = Signal::Switched { input: 0, signals: vec![Signal::Constant(7.0), table.clone()] };
        let at = |known: &[Known]| switched.at(Clock { t: 1.25, inputs: known });
        let follows = [0, 1].map(|signal| at(&[Known::Follows { signal, since: 0.25 }]));
        assert_eq!([at(&[]), at(&[Known::Ramp(step)]), follows[0], follows[1]], [7.0, 5.0, 7.0, 3.0]);
        assert!(switched.has_inputs() && switched.prescribed().count() == 2 && input.prescribed().count() == 0);
        let continued =
            Signal::Continued { signal: Box::new(ramp.clone()), from: 1.0, to: 1.5, before: 4.0, after: -2.0 };
        assert_eq!([continued.at(0.5), continued.at(1.25), continued.at(2.0)], [-1.0, 1.5, 1.0]);
        let turn = Signal::Turn { angle: Box::new(Signal::Constant(TAU / 4.0)), cosine: 3.0, sine: 5.0 };
        assert!((turn.at(0.0) - 2.0).abs() < 1e-15);
        let both = Signal::Sum(vec![Signal::Constant(1.0), Signal::Product(vec![ramp, table])]);
        assert_eq!(both.at(2.0), 16.0);
    }
}
