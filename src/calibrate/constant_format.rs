//! Constants and other numbers of a fit as they are printed: in a unit that fits their size, with as many digits as the interval supports.

use super::Estimate;

/// Factor and unit in which a stress of this size \[Pa\] is printed.
pub fn stress_unit(size: f64) -> (f64, &'static str) {
    match size.abs() {
        s if s >= 2e9 => (1e-9, "GPa"),
        s if s >= 2e6 => (1e-6, "MPa"),
        s if s >= 2e3 => (1e-3, "kPa"),
        _ => (1.0, "Pa"),
    }
}

/// A stress \[Pa\] in its unit, with four digits: `-4.312 kPa`.
pub fn stress_text(stress: f64) -> String {
    within(stress, "Pa", None).text(stress)
}

/// A number without a unit, with four digits.
pub fn number_text(x: f64) -> String {
    format!("{x:.*}", decimals(x, 0.0).min(12))
}

/// The probability of a test as text: `p = 0.40`, `p = 0.023`, `p < 0.001`.
pub fn probability_text(p: f64) -> String {
    match p {
        p if p < 1e-3 => "p < 0.001".into(),
        p if p < 0.1 => format!("p = {p:.3}"),
        p => format!("p = {p:.2}"),
    }
}

/// A stretch without the noise of a unit conversion: 1.97727, not 1.9772699999999999.
pub fn stretch_text(v: f64) -> String {
    let s = format!("{v:.4}");
    s.trim_end_matches('0').trim_end_matches('.').into()
}

/// Width of an interval relative to its value below which it is rounding and says nothing about the digits \[–\]
const EXACT: f64 = 1e-6;
/// Largest number of decimals; numbers with more are written as a power of ten
const LONG: usize = 7;

/// Number of decimals that leaves two digits of the half-width of an interval, or four of a value without one.
pub fn decimals(value: f64, half: f64) -> usize {
    let (size, digits) = if half.is_finite() && half > EXACT * value.abs() { (half, 2) } else { (value.abs(), 4) };
    if size == 0.0 || !size.is_finite() {
        return 1;
    }
    (digits - 1 - size.log10().floor() as i32).clamp(0, 300) as usize
}

/// The format of the numbers of a constant: the unit, and the digits of its interval.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Printed<'a> {
    pub factor: f64,
    pub unit: &'a str,
    pub decimals: usize,
    /// The interval is much larger than the value, whose digits would be too many for its ends
    pub wide: bool,
}

impl Printed<'_> {
    /// Formats a number \[SI\] without its unit; an end that is not finite is open.
    pub fn number(&self, value: f64) -> String {
        if value.is_finite() { fixed(self.factor * value, self.decimals) } else { "open".into() }
    }

    /// Formats an end of the interval without the unit, to two digits of its own if the interval is wide.
    pub fn end(&self, value: f64) -> String {
        let end = self.factor * value;
        if !self.wide || !end.is_finite() {
            return self.number(value);
        }
        let shown = fixed(end, decimals(end, end.abs()).min(self.decimals));
        if shown.bytes().all(|c| matches!(c, b'0' | b'.')) { "0".into() } else { shown }
    }

    /// A number with its unit.
    pub fn text(&self, value: f64) -> String {
        self.number(value) + &self.suffix()
    }

    /// Formats both ends with the unit: `334 to 380 kPa`
    pub fn span(&self, ends: [f64; 2]) -> String {
        let is_open = !ends.iter().any(|end| end.is_finite());
        self.ends(ends) + &if is_open { String::new() } else { self.suffix() }
    }

    /// Formats both ends without the unit: `334 to 380`
    pub fn ends(&self, [low, high]: [f64; 2]) -> String {
        if !low.is_finite() && !high.is_finite() {
            return "open at both ends".into();
        }
        format!("{} to {}", self.end(low), self.end(high))
    }

    /// Formats a half-width or a deviation with its unit, to two digits of its own, so that a small one is not rounded away.
    pub fn width(&self, width: f64) -> String {
        Self { decimals: decimals(self.factor * width, self.factor * width), ..*self }.text(width)
    }

    /// The unit as printed after a number.
    pub fn suffix(&self) -> String {
        if matches!(self.unit, "–" | "1" | "") { String::new() } else { format!(" {}", self.unit) }
    }
}

/// A number with `decimals` decimals, without the sign of a zero; with many decimals it is written as a power of ten.
fn fixed(value: f64, decimals: usize) -> String {
    if decimals > LONG {
        return if value == 0.0 { "0".into() } else { format!("{value:.1e}") };
    }
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(zero) if zero.bytes().all(|c| matches!(c, b'0' | b'.')) => zero.into(),
        _ => text,
    }
}

/// The format of a constant with this interval \[SI\], in the unit that fits its size.
pub fn within(value: f64, unit: &str, interval: Option<[f64; 2]>) -> Printed<'_> {
    within_size(value, value, unit, interval)
}

/// The format of a constant with this interval \[SI\]; a stress is in the unit that fits `size`, the size that all constants of a table share.
pub fn within_size(size: f64, value: f64, unit: &str, interval: Option<[f64; 2]>) -> Printed<'_> {
    let (factor, unit) = if unit == "Pa" { stress_unit(size) } else { (1.0, unit) };
    let half = interval.map_or(0.0, |[a, b]| 0.5 * (b - a).abs());
    // A value with a much larger interval still gets two digits
    let wide = half > value.abs() && value != 0.0;
    let half = if wide { value.abs() } else { half };
    Printed { factor, unit, decimals: decimals(factor * value, factor * half), wide }
}

/// The largest stress among constants with their units \[Pa\]; it determines the unit of all.
pub fn largest_stress<'a>(constants: impl IntoIterator<Item = (f64, &'a str)>) -> f64 {
    constants.into_iter().filter(|(_, unit)| *unit == "Pa").map(|(v, _)| v.abs()).fold(0.0, f64::max)
}

/// The formats of the constants of one list; all stresses have one unit.
pub fn printed(all: &[Estimate]) -> Vec<Printed<'static>> {
    let size = largest_stress(all.iter().map(|e| (e.value, e.unit)));
    all.iter().map(|e| e.printed(size)).collect()
}

/// Values of constants as text, `μ₁ = 12 kPa, α₁ = 3.1`, each with the digits of its own estimate.
pub fn list(own: &[Estimate], values: impl IntoIterator<Item = f64>) -> String {
    let one = |((e, p), v): ((&Estimate, Printed), f64)| format!("{} = {}", e.symbol, p.text(v));
    own.iter().zip(printed(own)).zip(values).map(one).collect::<Vec<_>>().join(", ")
}

impl Estimate {
    /// Unit and digits of this constant in a list whose largest stress is `size` \[Pa\].
    pub fn printed(&self, size: f64) -> Printed<'static> {
        within_size(size, self.value, self.unit, self.std_error.is_finite().then_some(self.interval))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_follow_the_interval() {
        let estimate = |value: f64, unit: &'static str, half: f64| Estimate {
            name: "mu",
            symbol: "μ",
            unit,
            value,
            std_error: half,
            interval: [value - half, value + half],
        };
        for (value, unit, half, text) in [
            (357_123.4, "Pa", 23_000.0, "357 kPa"),
            (357_123.4, "Pa", 2.0, "357.1234 kPa"),
            (357_123.4, "Pa", 0.01, "357.1 kPa"),
            (1.1753, "–", 0.2, "1.18"),
            (-41_234.0, "Pa", 300.0, "-41.23 kPa"),
            (43.21, "Pa", 9000.0, "43 Pa"),
            (2.345e6, "Pa", f64::INFINITY, "2.345 MPa"),
            (2.345e9, "Pa", 1e8, "2.35 GPa"),
            (0.0, "Pa", 0.0, "0.0 Pa"),
            (3.21e-30, "Pa", 1.0, "3.2e-30 Pa"),
        ] {
            assert_eq!(list(&[estimate(value, unit, half)], [value]), format!("μ = {text}"));
        }
        let one = estimate(357e3, "Pa", 23e3);
        assert_eq!(one.printed(357e3).span([334e3, 380e3]), "334 to 380 kPa");
        assert_eq!(one.printed(357e3).span([-0.1, f64::INFINITY]), "0 to open kPa");
        let wide = within(0.98, "Pa", Some([1e-4, 2540.56]));
        assert_eq!([wide.text(0.98), wide.span([1e-4, 2540.56])], ["0.98 Pa", "0 to 2541 Pa"]);
        assert_eq!(within(-5.4, "–", Some([-857.1, 0.12])).span([-857.1, 0.12]), "-857 to 0.1");
        assert_eq!(one.printed(357e3).width(0.0), "0.0 kPa");
        assert_eq!(one.printed(357e3).width(31.0), "0.031 kPa");
    }

    #[test]
    fn a_list_has_one_unit() {
        let estimate = |value: f64, half: f64| Estimate {
            name: "mu",
            symbol: "μ",
            unit: "Pa",
            value,
            std_error: half,
            interval: [value - half, value + half],
        };
        let all = [estimate(6123.0, 200.0), estimate(-15.3, 2.6)];
        assert_eq!(list(&all, all.each_ref().map(|e| e.value)), "μ = 6.12 kPa, μ = -0.0153 kPa");
    }

    #[test]
    fn sentences_have_no_powers_of_ten() {
        let probabilities = [1.0, 0.4, 0.0234, 9e-6, 0.0].map(probability_text);
        assert_eq!(probabilities, ["p = 1.00", "p = 0.40", "p = 0.023", "p < 0.001", "p < 0.001"]);
        let stresses = [-4312.4, 0.0, 12.5, 2.5e9].map(stress_text);
        assert_eq!(stresses, ["-4.312 kPa", "0.0 Pa", "12.50 Pa", "2.500 GPa"]);
        assert_eq!([36.0, -0.012_345, 1.2e6].map(number_text), ["36.00", "-0.01235", "1200000"]);
    }
}
