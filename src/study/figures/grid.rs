//! Maps over two axes, with the names of the values along both sides and, if there is room, numbers in the squares.

use crate::report::axis::Axis;
use crate::report::canvas::{Area, At, INK, SMALL, italic, mm, text};
use crate::report::color_bar::color_bar;
use crate::report::measure::{label_within, shortened, width};
use crate::report::numbers::fixed;
use crate::report::unit;
use crate::study::axis::AxisRecord;

/// Margin of a name or a number in its square \[units\].
const MARGIN: i32 = 16;
/// Height of a line of numbers \[units\].
const LINE: i32 = 74;

/// Formats a value for a figure: `g/cm^3` → `g/cm³`, `40 um` → `40 µm`, `-20 deg` → `−20°`.
pub fn raised(value: &str) -> String {
    let sign = |text: &str| text.strip_prefix('-').map_or_else(|| text.into(), |size| format!("−{size}"));
    if let Some(number) = value.strip_suffix(" deg") {
        return format!("{}°", sign(number));
    }
    let micro = value.strip_suffix("um").map(|number| format!("{number}µm"));
    sign(micro.as_deref().unwrap_or(value)).replace("^2", "²").replace("^3", "³")
}

/// Values of an axis, and its name with the unit if all of them share one: `−0.2` under `traction q [kPa]`.
fn named(axis: &AxisRecord) -> (Vec<String>, String) {
    let name = format!("{} {}", axis.label, italic(&axis.symbol));
    let unit_of = |value: &String| value.rsplit_once(' ').map(|(_, unit)| unit.to_string());
    let first = axis.values.first().and_then(unit_of);
    let shared = first
        .filter(|_| !axis.numbers.is_empty())
        .filter(|u| axis.values.iter().all(|v| unit_of(v).as_ref() == Some(u)));
    let Some(shared) = shared else { return (axis.values.iter().map(|v| raised(v)).collect(), name) };
    let bare = |value: &String| raised(value.rsplit_once(' ').map_or(value, |(number, _)| number));
    let unit = if shared == "deg" { "°".into() } else { raised(&format!(" {shared}")).trim().to_string() };
    (axis.values.iter().map(bare).collect(), format!("{name} [{unit}]"))
}

/// Draws the names of the values below a map and, with `left_too`, at its left. Where names would overlap, some are left out.
pub fn sides(area: &Area, (first, second): (&AxisRecord, &AxisRecord), frame: [i32; 4], (left_too, room): (bool, i32)) {
    let [left, top, right, bottom] = frame;
    let (values, name) = named(first);
    let wide = (right - left) / values.len().max(1) as i32;
    let widest = values.iter().map(|v| width(v, SMALL)).max().unwrap_or(0) + MARGIN;
    // Numbers between two labelled ones can be inferred; words cannot, and are shortened
    let every = if first.numbers.is_empty() { 1 } else { (widest as usize).div_ceil(wide.max(1) as usize).max(1) };
    for (k, value) in values.iter().enumerate().step_by(every) {
        let shown = shortened(value, SMALL, every as i32 * wide - MARGIN);
        text(area, &shown, (left + wide * k as i32 + wide / 2, bottom + mm(1.5)), At::Below, SMALL, INK);
    }
    let (size, name) = label_within(&name, right - left);
    text(area, &name, ((left + right) / 2, bottom + mm(6.0)), At::Below, size, INK);
    if !left_too {
        return;
    }
    let (values, name) = named(second);
    let (n, tall) = (values.len().max(1) as i32, bottom - top);
    let every = (LINE * n).div_euclid(tall.max(1)).max(0) as usize + usize::from((LINE * n) % tall.max(1) > 0);
    let mut widest = 0;
    for (k, value) in values.iter().enumerate().step_by(every.max(1)) {
        let shown = shortened(value, SMALL, room - mm(6.5));
        widest = widest.max(width(&shown, SMALL));
        let y = bottom - (f64::from(tall) * (k as f64 + 0.5) / f64::from(n)).round() as i32;
        text(area, &shown, (left - mm(1.5), y), At::Right, SMALL, INK);
    }
    let (size, name) = label_within(&name, tall);
    let at = (left - mm(1.5) - widest.max(mm(8.0)) - mm(1.5), (top + bottom) / 2);
    text(area, &name, at, At::Turned, size, INK);
}

/// Numbers of decimals: as many as give three digits, within these limits.
#[derive(Clone, Copy)]
struct Decimals {
    least: usize,
    most: usize,
}

impl Decimals {
    fn written(self, number: f64) -> String {
        let own = if number == 0.0 { 0 } else { 3 - digits_before_point(number.abs()) };
        fixed(number, own.clamp(self.least as i32, self.most as i32) as usize)
    }
}

/// Number of digits before the decimal point: 0 for 0.5, and −1 for 0.05.
fn digits_before_point(size: f64) -> i32 {
    if size > 0.0 && size.is_finite() { size.log10().floor() as i32 + 1 } else { 1 }
}

/// The format of the numbers in a map.
pub struct MapNumbers {
    power: i32,
    /// `None` if a square has no room for a number
    decimals: Option<Decimals>,
    /// The unit in the brackets of the title
    pub unit: String,
}

impl MapNumbers {
    /// Chooses one unit and power of ten for all values. Each value down to a hundredth of the largest has three digits, if that fits into every
    /// square. Otherwise all have the number of decimals that gives the largest one three digits, or fewer; a power of ten in the unit is used where
    /// this leaves more digits.
    pub fn of(values: impl Iterator<Item = f64>, unit: &str, (wide, tall): (i32, i32)) -> Self {
        let values: Vec<f64> = values.filter(|v| v.is_finite()).collect();
        let largest = values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let usual = unit::with_power(unit, largest, largest);
        let before = digits_before_point(largest * 10f64.powi(usual.0));
        let decimals = |least: usize, more: usize| Decimals { least, most: least + more };
        let of_largest = |digits: i32| (digits - before).max(0) as usize;
        let in_unit = |digits: i32| (usual.clone(), decimals(of_largest(digits), 0));
        let each = (usual.clone(), decimals(of_largest(3), 2));
        let whole = |digits: i32| (unit::with_digits(unit, largest, digits), decimals(0, 0));
        let fits = |((power, _), decimals): &((i32, String), Decimals)| {
            let is_within = |v: &f64| width(&decimals.written(v * 10f64.powi(*power)), SMALL) + MARGIN / 2 <= wide;
            tall >= LINE && values.iter().all(is_within)
        };
        let forms = [each, in_unit(3), in_unit(2), whole(3), whole(2), in_unit(1), whole(1)];
        let found = forms.into_iter().find(fits);
        let ((power, unit), decimals) = found.map_or((usual, None), |(form, decimals)| (form, Some(decimals)));
        Self { power, decimals, unit }
    }

    /// The number in a square; `None` if the squares have no room for numbers.
    pub fn written(&self, value: f64) -> Option<String> {
        Some(self.decimals?.written(value * 10f64.powi(self.power)))
    }

    /// Whether the squares have room for their numbers.
    pub fn have_room(&self) -> bool {
        self.decimals.is_some()
    }

    /// Draws a colour bar for squares without numbers, from its left edge between two heights \[mm\].
    pub fn color_bar(&self, area: &Area, x: f64, span: (f64, f64), ends: [f64; 2]) {
        let [low, high] = ends.map(|end| end * 10f64.powi(self.power));
        // A single value gets the middle of the colour scale
        let half = if low == 0.0 { 1.0 } else { 0.1 * low.abs() };
        let (low, high) = if low < high { (low, high) } else { (low - half, high + half) };
        color_bar(area, x, span, &Axis::exact(low, high, ""));
    }

    /// The unit in brackets, ` [kPa]`, or an empty text without a unit.
    pub fn brackets(&self) -> String {
        if self.unit.is_empty() { String::new() } else { format!(" [{}]", self.unit) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_an_axis_as_a_paper_writes_them() {
        let written = ["-20 deg", "40 um", "1.1 g/cm^3", "0 deg", "-3 mm"].map(raised);
        assert_eq!(written, ["−20°", "40 µm", "1.1 g/cm³", "0°", "−3 mm"]);
    }

    #[test]
    fn numbers_of_a_map_have_one_power_and_fit() {
        let values = [1.9e-5, 2e-6, 1e-12, 0.0];
        let map = |values: &[f64], unit: &str, room: (i32, i32)| {
            let numbers = MapNumbers::of(values.iter().copied(), unit, room);
            let all: Option<Vec<String>> = values.iter().map(|v| numbers.written(*v)).collect();
            (numbers.brackets(), all.unwrap_or_default())
        };
        let words = |all: &[&str]| all.iter().map(ToString::to_string).collect::<Vec<_>>();
        assert_eq!(map(&values, "J", (400, 100)), (" [µJ]".into(), words(&["19.0", "2.00", "< 0.001", "0.0"])));
        let room = (width("< 0.1", SMALL) + MARGIN / 2, 100);
        assert_eq!(map(&values, "J", room), (" [µJ]".into(), words(&["19.0", "2.0", "< 0.1", "0.0"])));
        assert_eq!(map(&values, "J", (130, 100)), (" [µJ]".into(), words(&["19", "2", "< 1", "0"])));
        for room in [(20, 100), (400, 20)] {
            assert_eq!(map(&values, "J", room), (" [µJ]".into(), vec![]));
        }
        // Whole numbers keep every value visible
        let small = [0.102, 0.0461, 0.0046];
        let ten = |exponent| format!(" [{}]", crate::report::numbers::raised(exponent));
        assert_eq!(map(&small, "1", (400, 100)), (" [–]".into(), words(&["0.102", "0.0461", "0.00460"])));
        // A small value next to large ones has three digits too
        let lengths = [-0.105, -0.08651, -0.001038, -1e-9, 0.0];
        let shown = words(&["−105", "−86.5", "−1.04", "> −0.01", "0"]);
        assert_eq!(map(&lengths, "m", (400, 100)), (" [mm]".into(), shown));
        let room = (width("102", SMALL) + MARGIN / 2, 100);
        assert_eq!(map(&small, "1", room), (ten(-3), words(&["102", "46", "5"])));
    }
}
