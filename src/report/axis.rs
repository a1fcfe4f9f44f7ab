//! An axis: range, scale, label, and ticks with short numbers.

use crate::report::numbers::raised;
use crate::report::unit;

/// Largest number that is drawn; no axis has room for larger ones \[any unit\].
const LARGEST: f64 = 1e250;
/// Smallest number that is drawn; a smaller one is zero on a linear axis, and not drawn on a logarithmic one.
const SMALLEST: f64 = 1e-250;
/// Relative difference below which values count as equal; it is rounding.
pub const ROUNDING: f64 = 1e-11;
/// Range relative to the values below which an axis shows the change from a round value.
const CHANGE: f64 = 1e-3;
/// Ratio of the smallest to the largest error that an axis reaches \[–\].
const DEPTH: f64 = 1e-4;
/// Ticks with a number in a decade of a logarithmic axis; the first choice that has room is taken.
const NAMED: [&[f64]; 4] = [&[1.0, 2.0, 3.0, 5.0], &[1.0, 2.0, 5.0], &[1.0, 3.0], &[1.0]];

/// One axis: range, scale and label.
#[derive(Clone, Debug)]
pub struct Axis {
    pub lo: f64,
    pub hi: f64,
    pub log: bool,
    /// Distance between ticks on a linear axis
    pub step: f64,
    /// Power of ten by which the ticks, minus the offset, are multiplied for printing: 3 shows metres in millimetres
    pub power: i32,
    /// Value that is subtracted from the printed numbers
    pub offset: f64,
    pub label: String,
}

impl Axis {
    /// Builds a linear axis, widened to whole ticks; a unit in the brackets of the label is replaced by one that gives short numbers.
    pub fn linear(values: impl Iterator<Item = f64>, label: &str) -> Self {
        let drawn = |v: f64| if v.abs() < SMALLEST { 0.0 } else { v };
        let (mut lo, mut hi) = bounds(values.map(drawn)).unwrap_or((0.0, 1.0));
        if hi - lo <= ROUNDING * hi.abs().max(lo.abs()) {
            let half = if hi == 0.0 { 1.0 } else { 0.1 * hi.abs() };
            (lo, hi) = (lo - half, hi + half);
        }
        let axis = Self::exact(lo, hi, label);
        let (o, step) = (axis.offset, axis.step);
        let (lo, hi) = (o + ((lo - o) / step + 1e-6).floor() * step, o + ((hi - o) / step - 1e-6).ceil() * step);
        let (power, label) = readable(label, (lo, hi), (axis.offset, step));
        Self { lo, hi, power, label, ..axis }
    }

    /// Builds an axis exactly from `lo` to `hi`. An axis without a label keeps its numbers, because nothing could name another unit.
    pub fn exact(lo: f64, hi: f64, label: &str) -> Self {
        let step = step((hi - lo).abs(), 5.0);
        if label.is_empty() {
            return Self { lo, hi, log: false, step, power: 0, offset: 0.0, label: String::new() };
        }
        let offset = offset(lo, hi);
        let (power, label) = readable(label, (lo, hi), (offset, step));
        Self { lo, hi, log: false, step, power, offset, label }
    }

    /// Builds a logarithmic axis of the positive values, with a margin of a twelfth of the length on both sides and at least two ticks with numbers.
    pub fn log(values: impl Iterator<Item = f64>, label: &str) -> Self {
        let (lo, hi) = bounds(values.filter(|v| *v >= SMALLEST)).unwrap_or((0.1, 1.0));
        let (mut a, mut b) = (lo.log10(), hi.log10());
        let margin = 0.08 * (b - a).max(0.3);
        (a, b) = (a - margin, b + margin);
        let named = || {
            let decades = a.floor() as i32..=b.ceil() as i32;
            decades.flat_map(|e| NAMED[0].iter().map(move |m| f64::from(e) + m.log10()))
        };
        if named().filter(|v| (a..=b).contains(v)).count() < 2 {
            let below = named().filter(|v| *v <= a).fold(a.floor(), f64::max);
            let above = named().filter(|v| *v >= b).fold(b.ceil(), f64::min);
            (a, b) = (below, above);
        }
        let (words, own) = unit::parts(label);
        let label = if own == "1" { format!("{words} [–]") } else { label.into() };
        Self { lo: 10f64.powf(a), hi: 10f64.powf(b), log: true, step: 0.0, power: 0, offset: 0.0, label }
    }

    /// Builds a logarithmic axis with the fraction `head` of its length, at most 0.6, free above the values: room for text.
    pub fn log_below(values: impl Iterator<Item = f64> + Clone, head: f64, label: &str) -> Self {
        let top = values.clone().fold(0.0, f64::max);
        let with = |k: u32| Self::log(values.clone().chain([top * 10f64.powf(0.05 * f64::from(k))]), label);
        let is_free = |axis: &Self| axis.place(top) <= 1.0 - head.min(0.6);
        (0..400).map(with).find(is_free).unwrap_or_else(|| with(0))
    }

    /// Builds a logarithmic axis for errors and the ends of their bars, with the tolerance: it reaches down to the smallest of them, but at most four
    /// decades below the largest. A smaller error, such as zero, has no position of its own.
    pub fn of_errors(values: impl Iterator<Item = f64> + Clone, tolerance: f64, head: f64, label: &str) -> Self {
        let largest = values.clone().filter(|v| *v <= LARGEST).fold(tolerance, f64::max);
        let shown = values.filter(|v| (DEPTH * largest..=LARGEST).contains(v));
        Self::log_below(shown.chain([tolerance]), head, label)
    }

    /// Returns the largest error, if all errors are so far below the tolerance that [their axis](Self::of_errors) shows none of them; otherwise
    /// `None`.
    pub fn below(errors: impl Iterator<Item = f64>, tolerance: f64) -> Option<f64> {
        let largest = errors.fold(0.0, f64::max);
        (largest < DEPTH * tolerance).then_some(largest)
    }

    /// Returns the position of a value on the axis, from 0 to 1 within its range.
    pub fn place(&self, v: f64) -> f64 {
        if self.log { (v / self.lo).ln() / (self.hi / self.lo).ln() } else { (v - self.lo) / (self.hi - self.lo) }
    }

    /// Returns the ticks as (value, label); an empty label denotes a minor tick.
    pub fn ticks(&self) -> Vec<(f64, String)> {
        self.ticks_where(|_| true)
    }

    /// Returns the ticks with as many numbers as fit, according to `fits`.
    pub fn ticks_where(&self, fits: impl Fn(&[(f64, String)]) -> bool) -> Vec<(f64, String)> {
        let choices = if self.log { self.logarithmic() } else { vec![self.even()] };
        if let Some(ticks) = choices.iter().find(|ticks| fits(ticks)) {
            return ticks.clone();
        }
        let last = choices.last().cloned().unwrap_or_default();
        let named = last.iter().filter(|t| !t.1.is_empty()).count();
        let thinned = |every: usize| {
            let (mut ticks, mut k) = (last.clone(), 0);
            for (_, name) in ticks.iter_mut().filter(|t| !t.1.is_empty()) {
                if k % every != 0 {
                    name.clear();
                }
                k += 1;
            }
            ticks
        };
        (2..named.max(3)).map(thinned).find(|ticks| fits(ticks)).unwrap_or_else(|| thinned(named.max(1)))
    }

    /// The ticks of a linear axis.
    fn even(&self) -> Vec<(f64, String)> {
        let step = self.step;
        if !(SMALLEST..=LARGEST).contains(&step) {
            return vec![];
        }
        let last = (step.log10() + 1e-9).floor() as i32 + self.power;
        let (decimals, scale) = ((-last).clamp(0, 12) as usize, 10f64.powi(self.power));
        let (a, b) = (self.lo.min(self.hi) - self.offset, self.lo.max(self.hi) - self.offset);
        let (first, end) = ((a / step - 1e-6).ceil() as i64, (b / step + 1e-6).floor() as i64);
        let name = |v: f64| format!("{:.decimals$}", v * scale).replace('-', "−");
        (first..=end)
            .map(|k| (k as f64 * step, k))
            .map(|(v, k)| (v + self.offset, name(if k == 0 { 0.0 } else { v })))
            .collect()
    }

    /// Choices of ticks for a logarithmic axis: at equal distances of the values if its decades give at most two numbers, then by decades, then with
    /// fewer numbers; each choice has at least two numbers if that is possible.
    fn logarithmic(&self) -> Vec<Vec<(f64, String)>> {
        let by_decades = self.decades();
        let is_short = by_decades[0].iter().filter(|t| !t.1.is_empty()).count() <= 2 && self.hi / self.lo < 10.0;
        let has_plain_numbers = self.lo >= 1e-3 && self.hi < 1e5;
        let even = Self { step: step(self.hi - self.lo, 5.0), ..self.clone() };
        let even = (is_short && has_plain_numbers).then(|| even.even());
        even.into_iter().chain(by_decades).collect()
    }

    /// Choices of ticks by decades.
    fn decades(&self) -> Vec<Vec<(f64, String)>> {
        let decades = (self.hi / self.lo).log10();
        let usual = if decades > 2.5 { 3 } else { 2 * usize::from(decades > 1.0) };
        let all: Vec<_> = NAMED.iter().map(|named| self.decades_with(named)).collect();
        let enough = |k: &usize| all[*k].iter().filter(|t| !t.1.is_empty()).count() > 1;
        let least = (0..=usual).rev().find(enough).unwrap_or(0);
        let last = (least..NAMED.len()).take_while(enough).last().unwrap_or(least);
        all[least..=last].to_vec()
    }

    /// Ticks whose numbers all have one form: 0.001 to 10000, or all with a power of ten.
    fn decades_with(&self, named: &[f64]) -> Vec<(f64, String)> {
        let mut ticks = vec![];
        for e in self.lo.log10().floor() as i32..=self.hi.log10().ceil() as i32 {
            for m in 1..10 {
                let v = f64::from(m) * 10f64.powi(e);
                if v >= self.lo * 0.9999 && v <= self.hi * 1.0001 {
                    ticks.push((v, m, e, named.contains(&f64::from(m))));
                }
            }
        }
        let plain = ticks.iter().filter(|t| t.3).all(|(_, _, e, _)| (-3..=4).contains(e));
        let name = |v: f64, m: i32, e: i32| match (plain, m) {
            (true, _) => format!("{v:.*}", (-e).max(0) as usize),
            (false, 1) => raised(e),
            (false, m) => format!("{m}·{}", raised(e)),
        };
        ticks.into_iter().map(|(v, m, e, named)| (v, if named { name(v, m, e) } else { String::new() })).collect()
    }
}

/// The label with the unit that gives short numbers, and its power of ten: `x [m]` becomes `x − 40 mm [nm]` if the numbers are changes from 40 mm.
fn readable(label: &str, (lo, hi): (f64, f64), (offset, step): (f64, f64)) -> (i32, String) {
    let largest = (lo - offset).abs().max((hi - offset).abs());
    if offset == 0.0 {
        return unit::readable(label, largest, step);
    }
    let (words, own) = unit::parts(label);
    let (power, name) = unit::with_power(own, offset.abs(), offset.abs());
    let scaled = offset * 10f64.powi(power);
    let number = format!("{:.*}", decimals(scaled), scaled.abs());
    let sign = if offset < 0.0 { '+' } else { '−' };
    let space = if name == "–" || name.is_empty() || name == "°" { "" } else { " " };
    let name = if name == "–" { "" } else { &name };
    unit::readable(&format!("{words} {sign} {number}{space}{name} [{own}]"), largest, step)
}

/// Number of decimals of a round number, at most twelve.
fn decimals(v: f64) -> usize {
    let is_whole = |n: &usize| {
        let scaled = v * 10f64.powi(*n as i32);
        (scaled - scaled.round()).abs() <= 1e-13 * scaled.abs().max(1.0)
    };
    (0..12).find(is_whole).unwrap_or(12)
}

/// The roundest value near a small range of large values; zero for other ranges.
fn offset(lo: f64, hi: f64) -> f64 {
    let (span, largest, middle) = ((hi - lo).abs(), lo.abs().max(hi.abs()), 0.5 * (lo + hi));
    if span >= CHANGE * largest || span <= 0.0 || !largest.is_finite() {
        return 0.0;
    }
    let first = largest.log10().floor() as i32;
    let round = |e: i32| {
        // Dividing by a whole power of ten gives the float nearest to the decimal number
        let ten = 10f64.powi(e.abs());
        if e < 0 { (middle * ten).round() / ten } else { (middle / ten).round() * ten }
    };
    (0..16).map(|k| round(first - k)).find(|v| (v - middle).abs() <= span).unwrap_or(0.0)
}

fn bounds(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let b = values
        .filter(|v| v.abs() <= LARGEST)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    (b.0 <= b.1).then_some(b)
}

/// The tick distance 1, 2 or 5 times a power of ten that gives about `count` intervals.
fn step(span: f64, count: f64) -> f64 {
    let raw = span / count;
    let base = 10f64.powf(raw.log10().floor());
    base * [1.0, 2.0, 5.0, 10.0].into_iter().find(|m| m * base >= raw * 0.999).unwrap_or(10.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::canvas::SMALL;
    use crate::report::measure::width;

    fn names(axis: &Axis) -> Vec<String> {
        axis.ticks().into_iter().map(|t| t.1).filter(|name| !name.is_empty()).collect()
    }

    #[test]
    fn the_head_of_an_axis_is_free_above_its_values() {
        for (low, high) in [(0.01, 20.0), (1.0, 1.0), (3.0, 4.0)] {
            let of = |head: f64| Axis::log_below([low, high].into_iter(), head, "error [%]");
            for head in [0.1, 0.4, 0.6] {
                assert!(of(head).place(high) <= 1.0 - head, "{low} to {high}, {head}: {}", of(head).place(high));
            }
            let plain = Axis::log([low, high].into_iter(), "error [%]");
            assert_eq!([of(0.0).lo, of(0.0).hi], [plain.lo, plain.hi]);
        }
    }

    /// Every error has a position on an axis of errors, however far below their uncertainty; an error of zero does not stretch the axis.
    #[test]
    fn an_axis_of_errors_reaches_the_least_of_them() {
        let lowest = |errors: &[f64]| Axis::of_errors(errors.iter().copied(), 2.0, 0.0, "error [%]").lo;
        for (errors, least) in [
            (&[1.3, 0.33, 0.6, 12.0][..], 0.33),
            (&[20.0, 0.116, 0.0], 0.116),
            (&[20.0, 5.0, 1e-9], 2.0),
            (&[0.0, 0.0], 2.0),
            (&[f64::INFINITY, f64::NAN, 4.0, 0.5], 0.5),
        ] {
            let lo = lowest(errors);
            assert!(lo < least && lo > 0.3 * least, "{errors:?}: {lo}");
        }
    }

    #[test]
    fn errors_that_no_axis_reaches_are_told_with_their_largest() {
        let below = |errors: &[f64]| Axis::below(errors.iter().copied(), 2.0);
        assert_eq!(below(&[1e-6, 3e-6, 0.0]), Some(3e-6));
        assert_eq!([below(&[0.0]), below(&[1e-6, 3e-4]), below(&[f64::INFINITY])], [Some(0.0), None, None]);
    }

    #[test]
    fn numbers_of_ticks_differ_and_are_short() {
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for _ in 0..3000 {
            let size = 10f64.powf(24.0 * random() - 12.0) * if random() < 0.5 { -1.0 } else { 1.0 };
            let span = size.abs() * 10f64.powf(-10.5 * random());
            for label in ["x [m]", "F [N]", "θ [°]", "cells"] {
                let axis = Axis::linear([size, size + span].into_iter(), label);
                let all = names(&axis);
                let distinct: std::collections::BTreeSet<&String> = all.iter().collect();
                assert!(distinct.len() == all.len() && (2..=9).contains(&all.len()), "{axis:?} {all:?}");
                assert!(all.iter().all(|n| width(n, SMALL) <= 265), "{axis:?} {all:?}");
                assert!(axis.lo <= size + 1e-5 * span && axis.hi >= size + span * 0.99999, "{axis:?}");
                let log = Axis::log([size.abs(), size.abs() + span].into_iter(), label);
                let all = names(&log);
                assert!(all.len() >= 2 && all.iter().all(|n| width(n, SMALL) <= 265), "{log:?} {all:?}");
                assert!(
                    all.iter().all(|n| n.contains(raised(1).chars().nth(2).expect("a mark")))
                        || !all.iter().any(|n| n.contains('·'))
                );
            }
        }
    }

    #[test]
    fn any_values_have_an_axis() {
        for values in [[5e-324, 5e-324], [0.0, 1e-310], [-1e308, 1e308], [1e200, 1e200], [f64::NAN, f64::INFINITY]] {
            for axis in [Axis::linear(values.into_iter(), ""), Axis::log(values.into_iter(), "")] {
                assert!(axis.lo < axis.hi && axis.hi.is_finite(), "{axis:?}");
                assert!((1..100).contains(&names(&axis).len()), "{axis:?}");
            }
        }
    }

    #[test]
    fn a_small_range_of_large_values_is_a_change() {
        let axis = Axis::linear([0.04, 0.04 + 8e-11].into_iter(), "x [m]");
        assert_eq!(axis.label, format!("x − 40 mm [{} m]", raised(-10)).replace(&raised(-10), &raised(-11)));
        let axis = Axis::linear([-0.04, -0.04 + 8e-8].into_iter(), "x [m]");
        assert_eq!((axis.label.as_str(), names(&axis)[0].as_str()), ("x + 40 mm [nm]", "0"));
        let axis = Axis::linear([293.0, 293.1].into_iter(), "T [K]");
        assert_eq!((axis.label.as_str(), names(&axis)[1].as_str()), ("T − 293 K [K]", "0.02"));
        assert_eq!(Axis::linear([2.0, 2.0 + 1e-13].into_iter(), "x [mm]").label, "x [mm]");
    }

    /// Within a short range, where decades have at most two numbers, the ticks are at equal distances of the values.
    #[test]
    fn a_short_logarithmic_axis_has_more_than_two_numbers() {
        let named = |lo: f64, hi: f64| names(&Axis::log([lo, hi].into_iter(), ""));
        assert_eq!(named(22.8, 27.0), ["20", "22", "24", "26", "28", "30"]);
        assert_eq!(named(2.2, 2.7), ["2.0", "2.2", "2.4", "2.6", "2.8", "3.0"]);
        assert_eq!(named(0.0022, 0.0027), ["0.0020", "0.0022", "0.0024", "0.0026", "0.0028", "0.0030"]);
    }

    #[test]
    fn numbers_of_a_logarithmic_axis_have_one_form() {
        let named = |lo: f64, hi: f64| names(&Axis::log([lo, hi].into_iter(), ""));
        assert_eq!(named(1e-5, 1.0), [-5, -4, -3, -2, -1, 0].map(raised));
        assert_eq!(named(1e-3, 1.0), ["0.001", "0.01", "0.1", "1"]);
        assert_eq!(named(1.0, 3.0), ["1", "2", "3"]);
        assert_eq!(named(3e-5, 6e-4), [format!("3·{}", raised(-5)), raised(-4), format!("3·{}", raised(-4))]);
    }
}
