//! Numbers as printed in sentences and tables: rounding, units, names of magnitudes.

/// Formats a share in per cent: `3.42 %`, `12 %`, and whole numbers as such: `5 %`.
pub fn percent(x: f64) -> String {
    let v = 100.0 * x;
    if v != 0.0 && v.abs() < 0.01 {
        format!("{v:.1e} %")
    } else if (v - v.round()).abs() < 1e-9 || v.abs() >= 10.0 {
        format!("{v:.0} %")
    } else {
        format!("{v:.2} %")
    }
}

/// Formats a share in per cent for a table: three significant digits, at most two decimals.
pub fn percent_cell(share: f64) -> String {
    let v = 100.0 * share;
    let decimals = if v.abs() >= 99.95 {
        0
    } else if v.abs() >= 9.995 {
        1
    } else {
        2
    };
    format!("{v:.decimals$}")
}

/// Rounds to this many significant digits, without an exponent unless the number is too small to read.
pub fn significant(x: f64, digits: i32) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x:.0}");
    }
    if x.abs() < SMALLEST {
        return format!("{x:.*e}", (digits - 1).max(0) as usize);
    }
    let last = x.abs().log10().floor() as i32 - digits + 1;
    let unit = 10f64.powi(last);
    format!("{:.*}", (-last).max(0) as usize, (x / unit).round() * unit)
}

/// Formats a measured number for a table: three significant digits, and all digits before the point.
pub fn measured(x: f64) -> String {
    format!("{x:.*}", digits(0.1 * x))
}

/// Formats a number with five digits, whatever its size.
pub fn five_digits(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e6).contains(&size) { format!("{value:.5}") } else { format!("{value:.4e}") }
}

/// Removes the sign of a number that is printed as zero: `-0.00` becomes `0.00`.
pub fn unsigned_zero(cell: &str) -> &str {
    match cell.strip_prefix(['-', '−']) {
        Some(zero) if !zero.is_empty() && zero.chars().all(|c| c == '0' || c == '.') => zero,
        _ => cell,
    }
}

/// Replaces hyphens before numbers by minus signs, `−857.1 to 0.0`; hyphens within words and exponents are kept.
pub fn minus_signs(text: &str) -> String {
    let mut before = ' ';
    let mut rest = text.chars().peekable();
    let mut out = String::with_capacity(text.len());
    while let Some(c) = rest.next() {
        let is_sign = c == '-' && (before.is_whitespace() || matches!(before, '(' | '['));
        out.push(if is_sign && rest.peek().is_some_and(char::is_ascii_digit) { '−' } else { c });
        before = c;
    }
    out
}

/// Formats a value with `decimals` decimals, or with a power of ten if these, the zeros after the point or the digits before it are too many to read.
pub fn readable(value: f64, decimals: usize) -> String {
    let are_few = decimals <= FEW_DECIMALS;
    if value == 0.0 {
        return format!("{value:.*}", if are_few { decimals } else { 0 });
    }
    if are_few && value.abs() < LARGEST || decimals <= MOST_DECIMALS && (SMALLEST..LARGEST).contains(&value.abs()) {
        return format!("{value:.decimals$}");
    }
    let digits = (decimals as f64 + value.abs().log10().floor()).clamp(0.0, 4.0) as usize;
    format!("{value:.digits$e}")
}

/// Number of decimals, and sizes of numbers, beyond which a power of ten is used
const MOST_DECIMALS: usize = 10;
const SMALLEST: f64 = 1e-4;
const LARGEST: f64 = 1e9;

/// Largest number of decimals that show nothing below [`SMALLEST`]
const FEW_DECIMALS: usize = 4;

/// Formats a time: `3.4 s`, `12 min`, `5.1 h`, `3.0 d`, `120 years`.
pub fn seconds(s: f64) -> String {
    const LONG: [(f64, &str); 3] = [(365.25 * 86_400.0, "years"), (86_400.0, "d"), (3600.0, "h")];
    if let Some((unit, name)) = LONG.iter().find(|(unit, _)| s >= 2.0 * unit) {
        let n = s / unit;
        return if n < 1e4 { format!("{n:.*} {name}", digits(n)) } else { format!("{n:.0e} {name}") };
    }
    if s >= 600.0 { format!("{:.0} min", s / 60.0) } else { format!("{s:.*} s", digits(s)) }
}

/// Formats a ratio: `2.4`, `180`, `6e5`.
pub fn times(x: f64) -> String {
    if x < 1e4 { format!("{x:.*}", digits(x)) } else { format!("{x:.0e}") }
}

/// Returns the number of decimals that leaves two significant digits, at most thirty.
pub fn digits(x: f64) -> usize {
    if x == 0.0 || !x.is_finite() { 1 } else { (1 - x.abs().log10().floor() as i32).clamp(0, 30) as usize }
}

/// Formats a power of ten for a figure, with its exponent raised.
pub fn raised(exponent: i32) -> String {
    let (up, down) = crate::report::canvas::RAISED;
    format!("10{up}{}{down}", exponent.to_string().replace('-', "−"))
}

/// Formats a number with a minus sign and this many decimals; a number that would be printed as zero becomes a bound: `< 0.01`.
pub fn fixed(value: f64, decimals: usize) -> String {
    let least = 10f64.powi(-(decimals as i32));
    let bound = if value > 0.0 { format!("< {least:.decimals$}") } else { format!("> −{least:.decimals$}") };
    let is_lost = value != 0.0 && value.abs() < 0.5 * least;
    if is_lost { bound } else { format!("{value:.decimals$}").replace('-', "−") }
}

/// Returns a unit as printed after its number: all except the degree sign follow a space, and a number in the unit 1 has none.
pub fn space(unit: &str) -> String {
    match unit {
        "" | "1" => String::new(),
        "°" => unit.into(),
        unit => format!(" {unit}"),
    }
}

/// Capitalises the first letter if the text begins with a word; symbols and names are unchanged: `μ = 1 MPa`, `p = −U′(J)`, `tip_x_m`.
pub fn capital(s: &str) -> String {
    let first = s.split_whitespace().next().unwrap_or_default();
    let word =
        first.split(['-', '–', '/', '\'', '’']).next().unwrap_or_default().trim_end_matches([',', ':', ';', '.', ')']);
    let is_letter = |c: char| c.is_alphabetic() && !('\u{370}'..='\u{3ff}').contains(&c);
    if !word.chars().all(is_letter) || (word.chars().count() < 2 && first != "a") {
        return s.into();
    }
    let mut c = s.chars();
    c.next().map_or(String::new(), |f| f.to_uppercase().chain(c).collect())
}

/// Formats a range as `0.87 to 1.00`, or `1.86` if both ends are printed equally; `None` without values.
pub fn span(values: impl IntoIterator<Item = f64>, print: impl Fn(f64) -> String) -> Option<String> {
    let (low, high) = values.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let (a, b) = (print(low), print(high));
    (low <= high).then(|| if a == b { a } else { format!("{a} to {b}") })
}

/// Formats a value with two digits of its error, if that is known: `0.02 ± 0.11`, `1.3170 ± 0.0035`, `1.33`. An error that is invisible in four
/// decimals is left out.
pub fn with_error(value: f64, error: Option<f64>) -> String {
    match error {
        Some(error) if error >= 5e-5 => {
            let decimals = digits(error).min(4);
            format!("{value:.decimals$} ± {error:.decimals$}")
        }
        Some(_) => format!("{value:.4}"),
        None => format!("{value:.2}"),
    }
}

/// Formats a value with two digits of its uncertainty, at most five of its own, see [`readable`].
pub fn within(value: f64, uncertainty: f64) -> String {
    readable(value, digits(uncertainty.abs().max(1e-4 * value.abs())))
}

/// Formats a number for a table cell; a dash if it is not finite.
pub fn cell(x: f64, print: impl Fn(f64) -> String) -> String {
    if x.is_finite() { print(x) } else { "–".into() }
}

/// Formats an integer with thin spaces: `36 600`, `2 290 000`.
pub fn thousands(n: usize) -> String {
    let digits = n.to_string();
    if digits.len() < 5 {
        return digits;
    }
    let groups = digits.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy);
    groups.collect::<Vec<_>>().join("\u{2009}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_values_keep_their_digits() {
        let words = [2.36, 0.0213, 1.234e-6, 5.6e-11, 0.0].map(|v| format!("{v:.*}", digits(v)));
        assert_eq!(words, ["2.4", "0.021", "0.0000012", "0.000000000056", "0.0"]);
    }

    #[test]
    fn numbers_have_the_digits_that_their_interval_carries() {
        assert_eq!([2.0566, 0.98765, 0.0404, 0.0058].map(percent_cell), ["206", "98.8", "4.04", "0.58"]);
        assert_eq!([9.9949e-2, 9.9951e-2, 0.99951].map(percent_cell), ["9.99", "10.0", "100"]);
        assert_eq!([1303.0, 386.0, 0.01234, 99.6].map(|x| significant(x, 2)), ["1300", "390", "0.012", "100"]);
        assert_eq!(
            ["-0.0", "−0.00", "-0", "-0.01", "-", "–"].map(unsigned_zero),
            ["0.0", "0.00", "0", "-0.01", "-", "–"]
        );
    }

    #[test]
    fn only_hyphens_before_numbers_are_signs() {
        let texts = ["-23.0 to -1.2", "[-1, 2] (-3)", "tet10-length-4500", "-9.0e-5 N", "a - 1", "--1"];
        let shown = ["−23.0 to −1.2", "[−1, 2] (−3)", "tet10-length-4500", "−9.0e-5 N", "a - 1", "--1"];
        assert_eq!(texts.map(minus_signs), shown);
    }

    #[test]
    fn numbers_beyond_reading_have_a_power_of_ten() {
        let of = |value: f64| readable(value, digits(1e-3 * value));
        let shown = [-1_294_868_717_823.0, 4.844_291e-18, 3.21e-5, 2.657_123, 0.0].map(of);
        assert_eq!(shown, ["-1.2949e12", "4.8443e-18", "3.2100e-5", "2.6571", "0.0"]);
        assert_eq!([readable(3e-17, 4), readable(0.0, 22)], ["0.0000", "0"]);
        assert_eq!([readable(7.9e-10, 10), readable(1.2e-4, 6)], ["8e-10", "0.000120"]);
        assert_eq!([significant(1.7512e-9, 3), significant(1.2345e-4, 3)], ["1.75e-9", "0.000123"]);
    }

    #[test]
    fn no_measured_number_is_rounded_to_zero() {
        let shown = [12345.67, 123.4, 5.678, 0.00342, 3.2e-7, 0.0].map(measured);
        assert_eq!(shown, ["12346", "123", "5.68", "0.00342", "0.000000320", "0.0"]);
    }

    #[test]
    fn words_are_capitalised_and_symbols_are_not() {
        let texts =
            ["a tip", "maximum tilt, x", "body's mass", "μ = 1 MPa", "r is at its bound", "p = −U′(J)", "tip_x_m"];
        let shown =
            ["A tip", "Maximum tilt, x", "Body's mass", "μ = 1 MPa", "r is at its bound", "p = −U′(J)", "tip_x_m"];
        assert_eq!(texts.map(capital), shown);
        assert_eq!(capital("tet10, 240 cells"), "tet10, 240 cells");
        assert_eq!(capital(""), "");
    }

    #[test]
    fn a_span_of_one_value_is_that_value() {
        let print = |v: f64| format!("{v:.2}");
        assert_eq!(span([1.861, 1.862], print).as_deref(), Some("1.86"));
        assert_eq!(span([1.0, 0.87], print).as_deref(), Some("0.87 to 1.00"));
        assert_eq!(span([], print), None);
        assert_eq!(
            [within(8.04e-11, 0.0), within(-0.0054213, 1.2e-4), within(0.0, 0.0)],
            ["8.0400e-11", "-0.00542", "0.0"]
        );
        assert_eq!([within(8e-10, 2e-10), within(-4.9273e-12, 1e-18)], ["8.0e-10", "-4.9273e-12"]);
        assert_eq!(cell(f64::NAN, print), "–");
    }

    #[test]
    fn every_group_of_three_digits_is_apart() {
        let shown = [9999, 36_600, 2_290_000, 1_000_000_007].map(thousands);
        assert_eq!(shown, ["9999", "36\u{2009}600", "2\u{2009}290\u{2009}000", "1\u{2009}000\u{2009}000\u{2009}007"]);
    }

    #[test]
    fn an_error_has_two_digits() {
        let shown = [with_error(0.0234, Some(0.113)), with_error(1.31702, Some(0.0035)), with_error(1.327, None)];
        assert_eq!(shown, ["0.02 ± 0.11", "1.3170 ± 0.0035", "1.33"]);
        assert_eq!(
            [7.8e-16, 0.0, 1.2e-4].map(|e| with_error(1.149_999, Some(e))),
            ["1.1500", "1.1500", "1.1500 ± 0.0001"]
        );
    }

    #[test]
    fn large_ratios_have_a_power_of_ten() {
        assert_eq!([1.0, 2.43, 179.6, 2_029_699.0].map(times), ["1.0", "2.4", "180", "2e6"]);
    }

    #[test]
    fn long_times_have_long_units() {
        let words = [0.034, 3.42, 59.0, 720.0, 7200.0, 200_000.0, 1e9, 1e15].map(seconds);
        assert_eq!(words, ["0.034 s", "3.4 s", "59 s", "12 min", "2.0 h", "2.3 d", "32 years", "3e7 years"]);
    }
}
