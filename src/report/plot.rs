//! Axes: a frame on the sheet, linear or logarithmic, with ticks and labels.

use crate::report::canvas::{Area, At, INK, LABEL, PALE, Point, RGB, SMALL, line, mm, text};
use crate::report::panels::heading;
use crate::report::unit;

/// Numbers of a larger size are not drawn: no axis has room for them \[any unit\].
const LARGEST: f64 = 1e250;
/// Numbers of a smaller size are zero on a linear axis, and not drawn on a logarithmic one.
const SMALLEST: f64 = 1e-250;

/// One axis: range, scale and label.
#[derive(Clone, Debug)]
pub struct Axis {
    pub lo: f64,
    pub hi: f64,
    pub log: bool,
    /// Distance of ticks on a linear axis
    pub step: f64,
    /// Numbers of the ticks are those of the axis times this power of ten: metres are read in millimetres with 3
    pub power: i32,
    pub label: String,
}

impl Axis {
    /// Widened to whole ticks; a unit in the brackets of the label is replaced by one that leaves short numbers.
    pub fn linear(values: impl Iterator<Item = f64>, label: &str) -> Self {
        let drawn = |v: f64| if v.abs() < SMALLEST { 0.0 } else { v };
        let (mut lo, mut hi) = bounds(values.map(drawn)).unwrap_or((0.0, 1.0));
        if hi - lo <= 1e-12 * hi.abs().max(lo.abs()) {
            let half = if hi == 0.0 { 1.0 } else { 0.1 * hi.abs() };
            (lo, hi) = (lo - half, hi + half);
        }
        let step = step(hi - lo, 5.0);
        let (lo, hi) = ((lo / step + 1e-6).floor() * step, (hi / step - 1e-6).ceil() * step);
        let (power, label) = unit::readable(label, lo.abs().max(hi.abs()));
        Self { lo, hi, log: false, step, power, label }
    }

    /// Exactly from `lo` to `hi`, in the unit of the label.
    pub fn exact(lo: f64, hi: f64, label: &str) -> Self {
        Self { lo, hi, log: false, step: step((hi - lo).abs(), 5.0), power: 0, label: label.into() }
    }

    /// Positive values only, with a margin of a twelfth of the length on both sides and at least one decade.
    pub fn log(values: impl Iterator<Item = f64>, label: &str) -> Self {
        let (lo, hi) = bounds(values.filter(|v| *v >= SMALLEST)).unwrap_or((0.1, 1.0));
        let (mut a, mut b) = (lo.log10(), hi.log10());
        let margin = 0.08 * (b - a).max(0.3);
        (a, b) = (a - margin, b + margin);
        // A tick with a number must lie inside
        if !labelled().any(|(m, e)| (a..=b).contains(&(m.log10() + e))) {
            (a, b) = (a.floor(), b.ceil());
        }
        Self { lo: 10f64.powf(a), hi: 10f64.powf(b), log: true, step: 0.0, power: 0, label: label.into() }
    }

    /// Position in \[0, 1\].
    pub fn place(&self, v: f64) -> f64 {
        if self.log { (v / self.lo).ln() / (self.hi / self.lo).ln() } else { (v - self.lo) / (self.hi - self.lo) }
    }

    /// (value, label); an empty label is a minor tick.
    pub fn ticks(&self) -> Vec<(f64, String)> {
        if !self.log {
            let step = self.step;
            if !(SMALLEST..=LARGEST).contains(&step) {
                return vec![];
            }
            let digit = (step.log10() + 1e-9).floor() as i32 + self.power;
            let shown = 10f64.powi(self.power);
            let (a, b) = (self.lo.min(self.hi), self.lo.max(self.hi));
            let first = (a / step - 1e-6).ceil() as i64;
            let last = (b / step + 1e-6).floor() as i64;
            return (first..=last).map(|k| (k as f64 * step, number(k as f64 * step * shown, digit))).collect();
        }
        let decades = (self.hi / self.lo).log10();
        let named: &[f64] = if decades > 2.5 {
            &[1.0]
        } else if decades > 1.0 {
            &[1.0, 3.0]
        } else {
            &[1.0, 2.0, 3.0, 5.0]
        };
        let mut out = vec![];
        // One form for all numbers below 1
        let is_shown = |v: f64| v >= self.lo * 0.9999 && v <= self.hi * 1.0001;
        let exponents = named.iter().any(|m| is_shown(1e-5 * m));
        for e in self.lo.log10().floor() as i32..=self.hi.log10().ceil() as i32 {
            for m in 1..10 {
                let v = f64::from(m) * 10f64.powi(e);
                if is_shown(v) {
                    let form = if exponents && e < 0 { exponent } else { number };
                    let name = named.contains(&f64::from(m)).then(|| form(v, e));
                    out.push((v, name.unwrap_or_default()));
                }
            }
        }
        out
    }
}

fn labelled() -> impl Iterator<Item = (f64, f64)> {
    (-12..12).flat_map(|e| [1.0, 2.0, 3.0, 5.0].map(|m| (m, f64::from(e))))
}

fn bounds(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let b = values
        .filter(|v| v.abs() <= LARGEST)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    (b.0 <= b.1).then_some(b)
}

/// 1, 2 or 5 times a power of ten, for about `count` intervals.
fn step(span: f64, count: f64) -> f64 {
    let raw = span / count;
    let base = 10f64.powf(raw.log10().floor());
    base * [1.0, 2.0, 5.0, 10.0].into_iter().find(|m| m * base >= raw * 0.999).unwrap_or(10.0)
}

/// `last` is the power of ten of the last digit. The font has no raised minus, so small numbers are 2.5e−5.
fn number(v: f64, last: i32) -> String {
    let e = if v == 0.0 { 0 } else { (v.abs().log10() + 1e-9).floor() as i32 };
    let (m, decimals, more) = (v / 10f64.powi(e), (-last).max(0) as usize, (e - last).max(0) as usize);
    let text = if v == 0.0 {
        format!("{:.*}", if last < -4 { 0 } else { decimals }, 0.0)
    } else if e < -4 {
        format!("{m:.more$}e{e}")
    } else if e >= 5 {
        let mantissa = if more == 0 && (m - 1.0).abs() < 1e-9 { String::new() } else { format!("{m:.more$}·") };
        format!("{mantissa}10{}", superscript(e))
    } else {
        format!("{v:.decimals$}")
    };
    text.replace('-', "−")
}

/// `3e−2`
fn exponent(v: f64, e: i32) -> String {
    format!("{:.0}e{e}", v / 10f64.powi(e)).replace('-', "−")
}

pub fn superscript(n: i32) -> String {
    let digit = |c: char| match c {
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        c => char::from_u32(0x2070 + c as u32 - '0' as u32).unwrap_or(c),
    };
    n.to_string().chars().map(digit).collect()
}

/// A frame between two corners of the sheet, with its axes.
pub struct Plot<'a, 'b> {
    pub area: &'a Area<'b>,
    /// Left, top, right, bottom \[units\]
    pub frame: [i32; 4],
    pub x: Axis,
    pub y: Axis,
}

impl Plot<'_, '_> {
    pub fn at(&self, x: f64, y: f64) -> Point {
        let [l, t, r, b] = self.frame.map(f64::from);
        // Far outside of the sheet is as good as farther
        let unit = |v: f64| v.round().clamp(-1e6, 1e6) as i32;
        (unit(l + self.x.place(x) * (r - l)), unit(b - self.y.place(y) * (b - t)))
    }

    pub fn path(&self, x: &[f64], y: &[f64]) -> Vec<Point> {
        x.iter().zip(y).filter(|(a, b)| a.is_finite() && b.is_finite()).map(|(a, b)| self.at(*a, *b)).collect()
    }

    /// Place of a mark: that of the value, or above the axis for a value below its range, with an arrow down to the axis.
    pub fn floored(&self, x: f64, y: f64, color: RGB) -> Point {
        if y >= self.y.lo {
            return self.at(x, y);
        }
        let (across, bottom) = self.at(x, self.y.lo);
        let (above, tip) = (bottom - mm(2.4), bottom - 10);
        line(self.area, &[(across, above), (across, tip)], color, 6);
        line(self.area, &[(across - 16, tip - 22), (across, tip), (across + 16, tip - 22)], color, 6);
        (across, above)
    }

    /// Grid, to be drawn before the data.
    pub fn grid(&self) {
        let [l, _, r, _] = self.frame;
        for (v, name) in self.y.ticks() {
            if !name.is_empty() {
                let y = self.at(self.x.lo, v).1;
                line(self.area, &[(l, y), (r, y)], PALE, 4);
            }
        }
        self.grid_x();
    }

    /// Vertical lines only.
    pub fn grid_x(&self) {
        let [_, t, _, b] = self.frame;
        for (v, name) in self.x.ticks() {
            if !name.is_empty() {
                let x = self.at(v, self.y.lo).0;
                line(self.area, &[(x, t), (x, b)], PALE, 4);
            }
        }
    }

    /// Both axes, to be drawn after the data. `names`: with numbers and label along x.
    pub fn axes(&self, names: bool) {
        let [l, t, r, b] = self.frame;
        line(self.area, &[(l, t), (l, b), (r, b)], INK, 6);
        self.ticks_x(names);
        let mut widest = crate::report::canvas::width("0.00", SMALL);
        for (v, name) in self.y.ticks() {
            let y = self.at(self.x.lo, v).1;
            let long = if name.is_empty() { 12 } else { 25 };
            line(self.area, &[(l - long, y), (l, y)], INK, 5);
            if !name.is_empty() {
                widest = widest.max(crate::report::canvas::width(&name, SMALL));
                text(self.area, &name, (l - 38, y), At::Right, SMALL, INK);
            }
        }
        text(self.area, &self.y.label, (l - 60 - widest, (t + b) / 2), At::Turned, LABEL, INK);
    }

    /// The axis along x only.
    pub fn axis_x(&self) {
        let [l, _, r, b] = self.frame;
        line(self.area, &[(l, b), (r, b)], INK, 6);
        self.ticks_x(true);
    }

    fn ticks_x(&self, names: bool) {
        let [l, _, r, b] = self.frame;
        for (v, name) in self.x.ticks() {
            let x = self.at(v, self.y.lo).0;
            let long = if name.is_empty() { 12 } else { 25 };
            line(self.area, &[(x, b), (x, b + long)], INK, 5);
            if names && !name.is_empty() {
                text(self.area, &name, (x, b + 38), At::Below, SMALL, INK);
            }
        }
        if names {
            text(self.area, &self.x.label, ((l + r) / 2, b + 125), At::Below, LABEL, INK);
        }
    }

    /// A title with the letter of the panel, above the frame.
    pub fn title(&self, letter: Option<char>, words: &str) {
        let [l, t, ..] = self.frame;
        text(self.area, &heading(letter, words), (l, t - mm(2.4)), At::Left, LABEL, INK);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_of_small_numbers_differ_and_have_glyphs() {
        for (lo, hi) in [(1.5e-5, 3.4e-5), (-6e-6, 0.0), (1e-9, 3e-9), (2e-5, 1e-4), (0.0, 1.0), (0.0, 4e6), (1e6, 2e6)]
        {
            let names: Vec<String> = Axis::linear([lo, hi].into_iter(), "").ticks().into_iter().map(|t| t.1).collect();
            let distinct: std::collections::BTreeSet<&String> = names.iter().collect();
            assert_eq!(distinct.len(), names.len(), "{names:?}");
            // Neither the raised minus nor the raised zero is in the font.
            assert!(!names.iter().any(|n| n.contains(['\u{207b}', '\u{2070}'])), "{names:?}");
        }
        for values in [[5e-324, 5e-324], [0.0, 1e-310], [-1e308, 1e308], [1e200, 1e200], [f64::NAN, f64::INFINITY]] {
            for axis in [Axis::linear(values.into_iter(), ""), Axis::log(values.into_iter(), "")] {
                assert!(axis.lo < axis.hi && axis.hi.is_finite(), "{axis:?}");
                assert!((1..100).contains(&axis.ticks().iter().filter(|t| !t.1.is_empty()).count()), "{axis:?}");
            }
        }
        let named = |lo: f64, hi: f64| -> Vec<String> {
            let ticks = Axis::log([lo, hi].into_iter(), "").ticks().into_iter();
            ticks.map(|t| t.1).filter(|name| !name.is_empty()).collect()
        };
        assert_eq!(named(1e-5, 1.0), ["1e−5", "1e−4", "1e−3", "1e−2", "1e−1", "1"]);
        assert_eq!(named(1e-3, 1.0), ["0.001", "0.01", "0.1", "1"]);
        assert_eq!(named(3e-5, 6e-4), ["3e−5", "1e−4", "3e−4"]);
        assert_eq!(number(2.5e-5, -6), "2.5e−5");
        assert_eq!(number(-2e-6, -6), "−2e−6");
        assert_eq!(number(1e-5, -5), "1e−5");
        assert_eq!(number(0.0, -6), "0");
        assert_eq!(number(0.02, -2), "0.02");
        assert_eq!(number(3e6, 6), "3·10⁶");
        assert_eq!(number(1.2e6, 5), "1.2·10⁶");
    }
}
