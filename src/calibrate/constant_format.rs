//! Constants and other numbers of a fit as they are printed: a unit that fits their size, and as many digits as the interval carries.

use super::Estimate;

/// Factor and unit in which a stress of this size \[Pa\] is printed.
pub fn stress_unit(size: f64) -> (f64, &'static str) {
    match size.abs() {
        s if s >= 2e6 => (1e-6, "MPa"),
        s if s >= 2e3 => (1e-3, "kPa"),
        _ => (1.0, "Pa"),
    }
}

/// A stress \[Pa\] in its unit, with four digits: `-4.312 kPa`.
pub fn stress_text(stress: f64) -> String {
    let (factor, unit, n) = within(stress, "Pa", None);
    format!("{:.n$} {unit}", factor * stress)
}

/// A number without a unit, with four digits.
pub fn number_text(x: f64) -> String {
    format!("{x:.*}", decimals(x, 0.0))
}

/// `p = 0.40`, `p = 0.023`, `p < 0.001`: the probability of a test.
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

/// Decimals that leave two digits of the half-width of an interval, and four of the value at most.
pub fn decimals(value: f64, half: f64) -> usize {
    let size = half.abs().max(1e-2 * value.abs());
    if size == 0.0 || !size.is_finite() { 1 } else { (1 - size.log10().floor() as i32).clamp(0, 12) as usize }
}

/// Factor, unit and decimals of a constant with this interval \[SI\].
pub fn within(value: f64, unit: &str, interval: Option<[f64; 2]>) -> (f64, &str, usize) {
    let (factor, unit) = if unit == "Pa" { stress_unit(value) } else { (1.0, unit) };
    let half = interval.map_or(0.0, |[a, b]| 0.5 * (b - a).abs());
    // An interval that dwarfs the value leaves it two digits all the same
    let half = if half > value.abs() && value != 0.0 { value.abs() } else { half };
    (factor, unit, decimals(factor * value, factor * half))
}

impl Estimate {
    /// Factor, printed unit with its space, and decimals.
    fn scale(&self) -> (f64, String, usize) {
        let (factor, unit, n) = within(self.value, self.unit, self.std_error.is_finite().then_some(self.interval));
        (factor, if unit == "–" { String::new() } else { format!(" {unit}") }, n)
    }

    /// `357 kPa`: a value of this constant, with its digits.
    pub fn print(&self, value: f64) -> String {
        let (factor, unit, n) = self.scale();
        format!("{:.n$}{unit}", factor * value)
    }

    /// `334 to 380 kPa`
    pub fn span(&self, [low, high]: [f64; 2]) -> String {
        let (factor, unit, n) = self.scale();
        let end = |v: f64| if v.is_finite() { format!("{:.n$}", factor * v) } else { "open".into() };
        format!("{} to {}{unit}", end(low), end(high))
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
            (357_123.4, "Pa", 1.0, "357.1 kPa"),
            (1.1753, "–", 0.2, "1.18"),
            (-41_234.0, "Pa", 300.0, "-41.23 kPa"),
            (43.21, "Pa", 9000.0, "43 Pa"),
            (2.345e6, "Pa", f64::INFINITY, "2.345 MPa"),
            (0.0, "Pa", 0.0, "0.0 Pa"),
        ] {
            assert_eq!(estimate(value, unit, half).print(value), text);
        }
        assert_eq!(estimate(357e3, "Pa", 23e3).span([334e3, 380e3]), "334 to 380 kPa");
    }

    #[test]
    fn sentences_have_no_powers_of_ten() {
        let probabilities = [1.0, 0.4, 0.0234, 9e-6, 0.0].map(probability_text);
        assert_eq!(probabilities, ["p = 1.00", "p = 0.40", "p = 0.023", "p < 0.001", "p < 0.001"]);
        let stresses = [-4312.4, 0.0, 12.5, 2.5e9].map(stress_text);
        assert_eq!(stresses, ["-4.312 kPa", "0.0 Pa", "12.50 Pa", "2500 MPa"]);
        assert_eq!([36.0, -0.012_345, 1.2e6].map(number_text), ["36.00", "-0.01235", "1200000"]);
    }
}
